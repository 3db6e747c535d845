//! Leaf cards: how many, how large, and what is drawn on them.

use super::dress;
use super::levels::LevelText;
use super::levels::Planner;
use super::words::{angle, around, n, n_whole, quoted};
use crate::import::Mark;

/// Leaf cards of a tree, about: as many as fill a crown without slowing anything down.
const CARDS: f32 = 30_000.0;
/// Most blades that are drawn on one card.
const BLADES: f32 = 24.0;
/// Most blades on a card that stands on a stem of its own: longer ones look like fronds.
const SPRIG: f32 = 9.0;
/// Cards that stand for several of theirs grow at most so much: the rest of the leaf area is left out.
const LARGEST: f32 = 1.5;
/// What stands on a card, and where cards stand.
struct Card {
    /// Leaves or stems of theirs that all cards of a branch stand for.
    wanted: f32,
    links: f32,
    blades: f32,
    length: f32,
    down: f32,
    /// The level of theirs whose angles the cards have.
    level: usize,
}

impl Planner<'_> {
    pub(super) fn leaves(&mut self, levels: usize, folded: bool) {
        let p = self.p;
        let count = p.get("Leaves");
        if count == 0.0 {
            return;
        }
        let fan = count < 0.0;
        // Toward the tips there are more: the mean of the tapered law is three quarters.
        let leaves = count.abs() * if fan { 1.0 } else { 0.75 };
        let (size, width) = (p.get("LeafScale"), p.get("LeafScale") * p.get("LeafScaleX"));
        let card = if folded {
            let stems = self.number(levels - 1);
            let shoot = self.stem.length * p.of(levels - 1, "Length").max(0.01) * 0.7;
            Card {
                wanted: stems,
                links: (CARDS / self.stem.count).clamp(1.0, stems).round(),
                blades: leaves.clamp(1.0, BLADES).round(),
                length: (shoot + size * 0.5).max(size * 1.3),
                down: p.of(levels - 1, "DownAngle"),
                level: levels - 1,
            }
        } else {
            let links = (CARDS / self.stem.count).clamp(1.0, leaves).round();
            let blades = (leaves / links).ceil().clamp(1.0, SPRIG);
            let stretch = self.stem.length / links;
            Card {
                wanted: links * blades,
                links,
                blades,
                length: if blades > 1.0 {
                    (stretch + size * 0.8).clamp(size * 1.4, size * (1.2 + 0.3 * blades))
                } else {
                    size
                },
                down: p.of(levels, "DownAngle"),
                level: levels,
            }
        };
        let single = card.blades <= 1.0;
        let angle_deg = p.of(card.level, "DownAngle").abs().clamp(30.0, 60.0);
        let card_width = if single {
            width
        } else {
            let reach = libm::sinf(angle_deg.to_radians()) * size;
            2.1 * reach.max(width * 0.5)
        };
        self.leaf_kind(&card, size, card_width, angle_deg);
        // What the scales of all levels take from a leaf in the mean, and for a fold what is left out.
        let spared = if folded {
            (card.wanted / card.links).sqrt().min(LARGEST)
        } else {
            1.0
        };
        let grown = spared / self.stem.scale.max(0.05);
        self.leaf_level(&card, fan, folded, grown);
        self.leaf_notes(&card, levels, folded, leaves, spared);
    }

    fn leaf_kind(&mut self, card: &Card, size: f32, card_width: f32, angle_deg: f32) {
        let p = self.p;
        let outline = dress::blade(&p.leaf_shape)
            .or(dress::blade(""))
            .unwrap_or_default();
        let ratio = p.get("LeafScaleX").clamp(0.005, 5.0);
        let mut fields = vec![
            ("name", quoted("leaf")),
            ("length_m", n(card.length)),
            ("width_m", n(card_width)),
        ];
        if card.blades > 1.0 {
            let blade = (size / card.length).clamp(0.05, 0.9);
            let arrangement = format!(
                "Alternate(count: {}, angle_deg: {}, blade: {})",
                n_whole(card.blades - 1.0),
                n(angle_deg),
                n(blade)
            );
            fields.push(("arrangement", arrangement));
        }
        fields.push(("blade", format!("(width: {}, {outline})", n(ratio))));
        fields.push(("colour", quoted(dress::leaf_colour(&p.name))));
        fields.push(("colour_vary", "0.14".to_owned()));
        fields.push(("translucency", "0.35".to_owned()));
        self.plan.leaf = fields;
    }

    fn leaf_level(&mut self, card: &Card, fan: bool, folded: bool, grown: f32) {
        let p = self.p;
        let vary = p.of(card.level, "DownAngleV").abs().clamp(10.0, 60.0);
        let (start, turn, down) = if fan {
            let spread = angle(&[(0.97, 85.0), (1.0, -85.0)], 3.0);
            (0.97, "(at: 90, step: 0)".to_owned(), spread)
        } else {
            (0.1, around(p, card.level), angle(&[(0.0, card.down)], vary))
        };
        let mut fields = vec![
            ("name", quoted("leaves")),
            ("links", n_whole(card.links)),
            ("start", n(start)),
            ("jitter", "0.3".to_owned()),
            ("around", turn),
            ("down", down),
            ("spin", "(vary: 30)".to_owned()),
            ("kinds", "[\"leaf\"]".to_owned()),
            ("scale", format!("(at: {}, vary: 0.15)", n(grown.min(50.0)))),
            ("tropism", n(self.tropism(2))),
        ];
        fields.retain(|(name, value)| match *name {
            "tropism" => value != "0",
            // A fan is even and flat.
            "jitter" | "spin" => !fan,
            _ => true,
        });
        let comment = match (folded, card.blades > 1.0) {
            (true, _) => format!(
                "Each card is a shoot of the last level with its {} leaves.",
                n_whole(card.blades)
            ),
            (false, true) => format!("Each card stands for {} leaves.", n_whole(card.blades)),
            (false, false) => String::new(),
        };
        self.plan.levels.push(LevelText {
            kind: "Leaves",
            comment,
            fields,
        });
    }

    fn leaf_notes(&mut self, card: &Card, levels: usize, folded: bool, leaves: f32, spared: f32) {
        let text = if folded {
            let all = self.number(levels - 1) * leaves * self.stem.count;
            format!(
                "each stem of level {} is a card with {} leaves, {} cards for {} stems a branch, {} times as \
                 large; all leaves would be {}",
                levels - 1,
                n_whole(card.blades),
                n_whole(card.links),
                n_whole(card.wanted),
                n(spared),
                n_whole(all)
            )
        } else if card.blades > 1.0 {
            format!(
                "{} cards a stem, each with {} leaves; the law by position gives {} in the mean",
                n_whole(card.links),
                n_whole(card.blades),
                n(leaves)
            )
        } else {
            format!(
                "{} cards a stem: the mean of the law by position",
                n_whole(card.links)
            )
        };
        self.general(Mark::Approximated, &["Leaves"], text);
        self.general(
            Mark::Used,
            &["LeafScale", "LeafScaleX"],
            "size of the blades, after what the scales of their branches take",
        );
        let level = card.level;
        if folded {
            let names = [
                "Branches",
                "Length",
                "DownAngle",
                "DownAngleV",
                "Rotate",
                "RotateV",
            ];
            self.of_level(
                Mark::Approximated,
                level,
                &names,
                "links, size, down and around of the cards",
            );
            let names = [
                "LengthV",
                "Taper",
                "CurveRes",
                "Curve",
                "CurveBack",
                "CurveV",
                "SegSplits",
                "SplitAngle",
                "SplitAngleV",
                "BranchDist",
            ];
            self.of_level(Mark::Ignored, level, &names, "this level is drawn on cards");
        } else if level < super::LEVELS {
            let names = ["DownAngle", "DownAngleV", "Rotate", "RotateV"];
            self.of_level(Mark::Used, level, &names, "down and around of the leaves");
        }
    }
}

//! From the model's levels to ours: the trunk, leaders where it splits at its base, and branches.

use super::Parameters;
use super::laws::positions;
use super::shape::{bends, curve, gnarl, taper};
use super::words::{angle, around, n, n_whole, points, quoted};
use crate::import::{Mark, Note};
use crate::math::{float, round_to_u32};

/// With more stems than this of the last level, each stem with its leaves becomes a card.
const STEMS: f32 = 20_000.0;
/// One level of a script: its kind, a comment, and its fields in order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LevelText {
    pub(super) kind: &'static str,
    pub(super) comment: String,
    pub(super) fields: Vec<(&'static str, String)>,
}

/// All parts of a script.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Plan {
    /// Splines by name.
    pub(super) splines: Vec<(String, Vec<[f32; 3]>)>,
    /// Fields of the leaf kind; none without leaves.
    pub(super) leaf: Vec<(&'static str, String)>,
    pub(super) levels: Vec<LevelText>,
    pub(super) notes: Vec<Note>,
}

/// What is known of a branch level once it is planned.
#[derive(Clone, Debug)]
pub(super) struct Stem {
    /// Mean length of its nodes, metres.
    pub(super) length: f32,
    /// Mean scale of its nodes, with all that they stand on.
    pub(super) scale: f32,
    /// How many there are.
    pub(super) count: f32,
}

/// A script in the making.
pub(super) struct Planner<'a> {
    pub(super) p: &'a Parameters,
    pub(super) plan: Plan,
    /// Part of the trunk's length below the base splits, and how many stems come out of them.
    pub(super) bole: f32,
    pub(super) leaders: u32,
    /// The level that carries the next.
    pub(super) stem: Stem,
}

/// Plans a script.
pub(super) fn plan(p: &Parameters) -> Plan {
    let splits = p.get("0BaseSplits").abs();
    let mut planner = Planner {
        p,
        plan: Plan::default(),
        bole: if splits >= 1.0 {
            (1.0 / p.of(0, "CurveRes")).clamp(0.08, 0.2)
        } else {
            1.0
        },
        leaders: round_to_u32(splits).min(8) + 1,
        stem: Stem {
            length: p.get("Scale") * p.get("ZScale") * p.of(0, "Length"),
            scale: 1.0,
            count: 1.0,
        },
    };
    planner.trunk();
    if planner.leaders > 1 {
        planner.leaders();
    }
    let levels = round_to_u32(p.get("Levels")) as usize;
    let folded = planner.folds(levels);
    for level in 1..levels - usize::from(folded) {
        planner.branches(level);
    }
    planner.leaves(levels, folded);
    planner.rest(levels);
    planner.plan
}
impl Planner<'_> {
    pub(super) fn trunk(&mut self) {
        let p = self.p;
        let length = self.stem.length;
        let radius = (length * p.get("Ratio") * p.get("0Scale")).max(0.0002);
        let scale_vary = (p.get("ScaleV") / p.get("Scale")).min(0.45);
        let length_vary = (p.of(0, "LengthV").abs() / p.of(0, "Length").max(0.01)).min(0.45);
        let mut fields = vec![
            ("name", quoted("trunk")),
            ("length_m", n(length * self.bole)),
            ("length_vary", n(length_vary)),
            ("radius_m", n(radius)),
            ("splines", "[\"trunk\"]".to_owned()),
            ("taper", points(&self.trunk_taper(0.0, self.bole))),
            ("gnarl", n(gnarl(p, 0))),
            ("scale", format!("(vary: {})", n(scale_vary))),
            ("sides", "16".to_owned()),
        ];
        fields.retain(|field| {
            !matches!(
                (field.0, field.1.as_str()),
                ("length_vary" | "gnarl", "0") | ("scale", "(vary: 0)")
            )
        });
        let flare = p.get("Flare");
        if flare > 0.0 {
            // 100^(1 - 8 z) falls to a tenth over a 28th of the trunk; ours by a square over this height.
            let height = length / 8.0 * 0.6;
            let height = height.min(length * self.bole);
            fields.push((
                "flare",
                format!("(height_m: {}, amount: {})", n(height), n(flare)),
            ));
        }
        let (lobes, depth) = (round_to_u32(p.get("Lobes")), p.get("LobeDepth").min(0.5));
        if lobes > 0 && depth > 0.0 {
            fields.push(("flutes", format!("(count: {lobes}, depth: {})", n(depth))));
        }
        self.spline("trunk", 0);
        self.plan.levels.push(LevelText {
            kind: "Branch",
            comment: String::new(),
            fields,
        });
        self.trunk_notes(scale_vary);
    }

    /// Taper of the part `from..to` of the trunk, relative to its radius at `from`.
    pub(super) fn trunk_taper(&self, from: f32, to: f32) -> Vec<(f32, f32)> {
        let whole = crate::species::schema::Curve {
            points: taper(self.p.of(0, "Taper")),
        };
        let first = whole.at(from).max(0.03);
        let mut part = vec![(0.0, 1.0)];
        for &(x, y) in whole
            .points
            .iter()
            .filter(|(x, _)| (from + 1e-3..to - 1e-3).contains(x))
        {
            part.push(((x - from) / (to - from), y / first));
        }
        part.push((1.0, whole.at(to) / first));
        part
    }

    /// Base splits: stems that go on where the bole ends.
    pub(super) fn leaders(&mut self) {
        let p = self.p;
        let down = self.lean();
        let whole = 1.0 / self.bole;
        let fields = vec![
            ("name", quoted("leaders")),
            ("children", self.leaders.to_string()),
            ("start", "1".to_owned()),
            ("around", "(vary: 20)".to_owned()),
            (
                "down",
                angle(&[(0.0, down)], p.of(0, "SplitAngleV").abs().max(4.0)),
            ),
            ("length_of_parent", n(whole - 1.0)),
            ("radius_of_parent", n(0.8)),
            ("splines", "[\"trunk\"]".to_owned()),
            ("taper", points(&self.trunk_taper(self.bole, 1.0))),
            ("gnarl", n(gnarl(p, 0).max(0.02))),
            ("variants", self.leaders.min(3).to_string()),
            ("scale", "(at: 0.95, vary: 0.1)".to_owned()),
            ("collar", "1.1".to_owned()),
            ("sides", "12".to_owned()),
        ];
        self.plan.levels.push(LevelText {
            kind: "Branch",
            comment: "Base splits: what goes on where the bole ends.".to_owned(),
            fields,
        });
        self.stem = Stem {
            length: self.stem.length * (1.0 - self.bole) * 0.95,
            scale: 0.95,
            count: float(self.leaders),
        };
        let text = format!(
            "{} leaders on a bole of {} of the trunk's length, 0.8 as thick as it",
            self.leaders,
            n(self.bole)
        );
        self.general(Mark::Approximated, &["0BaseSplits"], text);
        self.of_level(
            Mark::Approximated,
            0,
            &["SplitAngle", "SplitAngleV"],
            "down of the leaders, with an eighth of 0CurveV on top, so that they part",
        );
    }

    pub(super) fn branches(&mut self, level: usize) {
        let p = self.p;
        let name = ["trunk", "limbs", "branches", "twigs"][level.min(3)];
        let start = self.start(level);
        let at = positions(start);
        let number = self.number(level);
        let lengths = p.of(level, "Length").max(0.01);
        let bent = bends(p, level);
        let scale = self.scales(level, &at, &bent);
        let thick = self.thickness(level, &at, &scale, lengths);
        let power = libm::powf(lengths.min(1.0), p.get("RatioPower"));
        let mut fields = vec![
            ("name", quoted(name)),
            ("links", n_whole(number)),
            ("start", n(start)),
            ("jitter", "0.3".to_owned()),
            ("around", around(p, level)),
            ("down", self.down(level, &at)),
            ("length_of_parent", n(self.length_of_parent(level, lengths))),
            (
                "length_vary",
                n((p.of(level, "LengthV").abs() / lengths).min(0.9)),
            ),
            ("radius_of_parent", n(power.clamp(0.001, 0.9))),
            ("thickness", points(&thick)),
            ("splines", format!("[\"{name}\"]")),
            ("taper", points(&taper(p.of(level, "Taper")))),
            ("gnarl", n(gnarl(p, level))),
            ("variants", if level == 1 { "3" } else { "1" }.to_owned()),
            ("scale", format!("(at: {}, vary: 0.08)", points(&scale))),
            ("tropism", n(self.tropism(level))),
        ];
        fields.retain(|field| {
            !matches!(
                (field.0, field.1.as_str()),
                ("length_vary" | "gnarl" | "tropism", "0") | ("thickness" | "variants", "1")
            )
        });
        self.spline(name, level);
        self.plan.levels.push(LevelText {
            kind: "Branch",
            comment: String::new(),
            fields,
        });
        let shrink = mean(&scale);
        self.stem = Stem {
            length: self.length_of_parent(level, lengths) * self.stem.length * shrink,
            scale: self.stem.scale * shrink,
            count: self.stem.count * number,
        };
        self.branch_notes(level, number);
    }

    pub(super) fn spline(&mut self, name: &str, level: usize) {
        let mut bent = bends(self.p, level);
        let up = self.p.get("AttractionUp");
        if level >= 2 && up != 0.0 {
            // What the rigid turn leaves over, bent in along the way.
            let last = float(u32::try_from(bent.len()).unwrap_or(1));
            let most = if up < 0.0 { 40.0 } else { -20.0 * up.min(1.0) };
            for (index, bend) in (0_u32..).zip(&mut bent) {
                *bend += most * (float(index) + 0.5) / last;
            }
        }
        let points = curve(&bent);
        let count = u32::try_from(points.len()).unwrap_or(2);
        // Segments about 1 long, as in the scripts of `species/`.
        let points = points
            .into_iter()
            .map(|(along, upper)| [0.0, along * float(count - 1), upper * float(count - 1)]);
        self.plan.splines.push((name.to_owned(), points.collect()));
    }

    /// True if stems of the last level are so many that each becomes a card with its leaves.
    pub(super) fn folds(&self, levels: usize) -> bool {
        let stems: f32 = (1..levels).map(|level| self.number(level)).product();
        levels > 2 && stems * float(self.leaders) > STEMS && self.p.get("Leaves") != 0.0
    }

    /// Children of each stem of the level above.
    pub(super) fn number(&self, level: usize) -> f32 {
        let p = self.p;
        let branches = p.of(level, "Branches").abs();
        let number = match level {
            // Base splits share the limbs of one trunk and half as many again.
            1 if self.leaders > 1 => branches * 1.5 / float(self.leaders),
            1 => branches,
            // 0.2 + 0.8 of the limb's length over the longest's, in the mean over the trunk.
            2 => branches * 0.8 * self.forks(1),
            // 1 - 0.5 of the place on the parent, in the mean.
            _ => branches * 0.75 * self.forks(level - 1),
        };
        number.round().max(1.0)
    }

    /// Angle of the leaders from the upright, degrees.
    pub(super) fn lean(&self) -> f32 {
        if self.leaders == 1 {
            return 0.0;
        }
        // Turns by chance drive stems of theirs apart; here the leaders' own angle has to.
        let wander = self.p.of(0, "CurveV").abs() / 8.0;
        (self.p.of(0, "SplitAngle").abs() + wander).clamp(8.0, 80.0)
    }

    /// How many times as many children stems of a level carry for their splits, and how much longer ones: what
    /// clones of theirs would spread over their width.
    pub(super) fn forks(&self, level: usize) -> f32 {
        let splits = self.p.of(level, "SegSplits") * self.p.of(level, "CurveRes") * 0.5;
        (1.0 + splits).clamp(1.0, 2.5).sqrt()
    }

    /// First position on the parent: above the bare bole on the trunk. Other branches are bare near their
    /// foot too, or else leaves would hide all wood.
    pub(super) fn start(&self, level: usize) -> f32 {
        match level {
            1 if self.leaders > 1 => {
                ((self.p.get("BaseSize") - self.bole) / (1.0 - self.bole)).clamp(0.2, 0.95)
            }
            1 => self.p.get("BaseSize").min(0.98),
            2 => 0.2,
            _ => 0.1,
        }
    }

    /// Limbs of leaders are as long as on a whole trunk.
    pub(super) fn length_of_parent(&self, level: usize, lengths: f32) -> f32 {
        match level {
            1 if self.leaders > 1 => lengths / (1.0 - self.bole),
            1 => lengths,
            _ => lengths * self.forks(level - 1),
        }
    }

    /// Turn towards the sky or the ground, from the second level of branches on.
    pub(super) fn tropism(&self, level: usize) -> f32 {
        let up = self.p.get("AttractionUp");
        match level {
            0 | 1 => 0.0,
            _ if up < 0.0 => (up * 0.25).max(-0.75),
            _ => (up * 0.25).min(0.5),
        }
    }
}

/// Mean of a curve over the positions that it is kept at.
fn mean(curve: &[(f32, f32)]) -> f32 {
    let count = float(u32::try_from(curve.len()).unwrap_or(1).max(1));
    curve.iter().map(|p| p.1).sum::<f32>() / count
}

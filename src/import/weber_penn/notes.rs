//! What became of each parameter.

use super::dress;
use super::levels::Planner;
use super::parameters::of_level;
use super::shape::shape_name;
use super::words::{n, n_whole};
use crate::import::{Mark, Note};
use crate::math::round_to_u32;

impl Planner<'_> {
    pub(super) fn note(&mut self, mark: Mark, names: &[String], text: impl Into<String>) {
        let given: Vec<String> = names
            .iter()
            .filter(|name| self.p.has(name))
            .map(|name| format!("{name} {}", n(self.p.get(name))))
            .collect();
        if !given.is_empty() {
            self.plan.notes.push(Note {
                mark,
                parameters: given.join(", "),
                text: text.into(),
            });
        }
    }

    pub(super) fn general(&mut self, mark: Mark, names: &[&str], text: impl Into<String>) {
        let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
        self.note(mark, &names, text);
    }

    pub(super) fn of_level(
        &mut self,
        mark: Mark,
        level: usize,
        names: &[&str],
        text: impl Into<String>,
    ) {
        let names: Vec<String> = names.iter().map(|name| of_level(level, name)).collect();
        self.note(mark, &names, text);
    }

    pub(super) fn trunk_notes(&mut self, scale_vary: f32) {
        let p = self.p;
        let wanted = p.get("ScaleV") / p.get("Scale");
        self.general(
            Mark::Used,
            &["Scale", "ZScale", "0Length"],
            "length_m of the trunk",
        );
        if wanted > scale_vary + 1e-3 {
            let text = format!(
                "vary of the trunk's scale, held at {}: more would make trees of no height",
                n(scale_vary)
            );
            self.general(Mark::Approximated, &["ScaleV"], text);
        } else {
            self.general(Mark::Used, &["ScaleV"], "vary of the trunk's scale");
        }
        self.general(Mark::Used, &["0LengthV"], "length_vary of the trunk");
        self.general(
            Mark::Used,
            &["Ratio", "0Scale"],
            "radius_m of the trunk, a part of its length",
        );
        self.general(
            Mark::Ignored,
            &["0ScaleV", "ZScaleV"],
            "the trunk's scale varies by ScaleV alone",
        );
        let beads = p.of(0, "Taper") > 2.0;
        let mark = if beads {
            Mark::Approximated
        } else {
            Mark::Used
        };
        self.general(mark, &["0Taper"], "taper of the trunk");
        if p.get("Flare") > 0.0 {
            self.general(
                Mark::Approximated,
                &["Flare"],
                "flare of the trunk: fades by a square, not by a power of 100",
            );
        } else {
            self.general(Mark::Ignored, &["Flare"], "nothing flares");
        }
        self.general(Mark::Used, &["Lobes", "LobeDepth"], "flutes of the trunk");
        self.bend_notes(0);
        if p.of(0, "SegSplits") > 0.0 {
            self.of_level(
                Mark::Ignored,
                0,
                &["SegSplits"],
                "a trunk does not split by chance here; base splits become leaders",
            );
        } else {
            self.of_level(Mark::Used, 0, &["SegSplits"], "no splits");
        }
        self.of_level(
            Mark::Ignored,
            0,
            &[
                "DownAngle",
                "DownAngleV",
                "Rotate",
                "RotateV",
                "Branches",
                "BranchDist",
            ],
            "a trunk hangs on nothing",
        );
        if self.leaders == 1 {
            self.general(Mark::Used, &["0BaseSplits"], "one trunk");
            self.of_level(
                Mark::Ignored,
                0,
                &["SplitAngle", "SplitAngleV"],
                "nothing splits there",
            );
        }
    }

    pub(super) fn bend_notes(&mut self, level: usize) {
        let (segments, by_chance) = (self.p.of(level, "CurveRes"), self.p.of(level, "CurveV"));
        if (2.0..=8.0).contains(&segments) {
            self.of_level(Mark::Used, level, &["CurveRes"], "segments of the spline");
        } else {
            let text = "segments of the spline, 2 to 8";
            self.of_level(Mark::Approximated, level, &["CurveRes"], text);
        }
        self.of_level(
            Mark::Used,
            level,
            &["Curve", "CurveBack"],
            "bend of the spline",
        );
        let (mark, text) = if by_chance == 0.0 {
            (Mark::Used, "no turns by chance")
        } else if by_chance < 0.0 {
            (Mark::Approximated, "gnarl; a helix has no counterpart")
        } else {
            (
                Mark::Approximated,
                "gnarl: points moved by chance, not turns added up",
            )
        };
        self.of_level(mark, level, &["CurveV"], text);
    }

    pub(super) fn branch_notes(&mut self, level: usize, number: f32) {
        let p = self.p;
        if level == 1 {
            let shape = shape_name(round_to_u32(p.get("Shape")));
            self.general(
                Mark::Used,
                &["Shape"],
                format!("scale of the limbs over the trunk: {shape}"),
            );
            let mark = if self.leaders > 1 {
                Mark::Approximated
            } else {
                Mark::Used
            };
            let text = if self.leaders > 1 {
                "start of the limbs, which is a fifth up the leaders at the least"
            } else {
                "start of the limbs"
            };
            self.general(mark, &["BaseSize"], text);
        }
        let branches = p.of(level, "Branches").abs();
        if (number - branches).abs() < 0.5 {
            self.of_level(Mark::Used, level, &["Branches"], "links");
        } else {
            let why = if level == 1 {
                "each leader, together half as many again"
            } else {
                "each, the mean over stems of all lengths"
            };
            let text = format!("{} links on {why}", n_whole(number));
            self.of_level(Mark::Approximated, level, &["Branches"], text);
        }
        let negative = p.of(level, "DownAngleV") < 0.0;
        let text = if negative {
            "down, spread over the parent"
        } else {
            "down"
        };
        self.of_level(Mark::Used, level, &["DownAngle", "DownAngleV"], text);
        if p.of(level, "Rotate") >= 0.0 {
            self.of_level(Mark::Used, level, &["Rotate", "RotateV"], "around");
        } else if level == 1 {
            self.of_level(
                Mark::Approximated,
                level,
                &["Rotate", "RotateV"],
                "around: a spiral of that step, since a trunk has no sides",
            );
        } else {
            self.of_level(
                Mark::Approximated,
                level,
                &["Rotate", "RotateV"],
                "around: two sides by turns, straight out",
            );
        }
        self.of_level(
            Mark::Used,
            level,
            &["Length", "LengthV"],
            "length_of_parent, length_vary",
        );
        let mark = if p.of(level, "Taper") > 2.0 {
            Mark::Approximated
        } else {
            Mark::Used
        };
        self.of_level(mark, level, &["Taper"], "taper");
        self.bend_notes(level);
        let forks = self.forks(level);
        let splits: &[&str] = &["SegSplits", "SplitAngle", "SplitAngleV"];
        if forks > 1.0 {
            let text = format!(
                "branches do not split here; they carry {} times as many, which are as much longer",
                n(forks)
            );
            self.of_level(Mark::Approximated, level, splits, text);
        } else {
            self.of_level(Mark::Ignored, level, splits, "nothing splits");
        }
        self.of_level(
            Mark::Ignored,
            level,
            &["BranchDist"],
            "branches stand evenly spaced",
        );
    }

    /// Notes on what is left.
    pub(super) fn rest(&mut self, levels: usize) {
        let p = self.p;
        self.general(
            Mark::Approximated,
            &["RatioPower"],
            "radius_of_parent and thickness; branches as thick as their parent are held at 0.95 of it",
        );
        self.general(
            Mark::Used,
            &["Levels"],
            "levels of stems; leaves come after",
        );
        let up = p.get("AttractionUp");
        if up == 0.0 || levels < 3 {
            self.general(Mark::Ignored, &["AttractionUp"], "no level feels it");
        } else {
            let text = if up < -0.5 {
                "tropism from the second level of branches on, a rigid turn, and a bend of their splines; low \
                 limbs are short, so that what hangs on them ends above the ground"
            } else {
                "tropism from the second level of branches on, a rigid turn, and a bend of their splines"
            };
            self.general(Mark::Approximated, &["AttractionUp"], text);
        }
        let prune = [
            "PruneRatio",
            "PruneWidth",
            "PruneWidthPeak",
            "PrunePowerLow",
            "PrunePowerHigh",
        ];
        if p.get("PruneRatio") > 0.0 {
            self.general(
                Mark::Approximated,
                &prune,
                "scale of the limbs, worked out once for each height; branches on them are not pruned",
            );
        } else {
            self.general(Mark::Ignored, &prune, "nothing is pruned at a ratio of 0");
        }
        if p.get("Leaves") == 0.0 {
            self.general(
                Mark::Ignored,
                &["Leaves", "LeafScale", "LeafScaleX"],
                "no leaves",
            );
        }
        let quality = [
            "LeafBend",
            "LeafStemLen",
            "LeafQuality",
            "LeafDistrib",
            "Smooth",
        ];
        self.general(Mark::Ignored, &quality, "no counterpart");
        if !p.leaf_shape.is_empty() {
            let known = dress::blade(&p.leaf_shape).is_some();
            self.plan.notes.push(Note {
                mark: if known {
                    Mark::Approximated
                } else {
                    Mark::Warning
                },
                parameters: format!("LeafShape {}", p.leaf_shape),
                text: if known {
                    "outline of the blade"
                } else {
                    "not known; an ellipse stands for it"
                }
                .to_owned(),
            });
        }
        let told: Vec<String> = self
            .plan
            .notes
            .iter()
            .map(|note| note.parameters.clone())
            .collect();
        let is_told = |name: &str| {
            let mut names = told.iter().flat_map(|line| line.split(", "));
            names.any(|entry| entry.split(' ').next() == Some(name))
        };
        let left: Vec<String> = p
            .names()
            .filter(|name| !is_told(name))
            .map(str::to_owned)
            .collect();
        self.note(Mark::Ignored, &left, "this tree has no such level");
    }
}

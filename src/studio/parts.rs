//! Angles and factors: by position on the parent, by link, and by chance.

use super::curve::{self, Curve};
use crate::species::fields::{Absent, Field, Limits};
use crate::species::syntax::{self, Kind, Node};

/// An angle or factor as scripts have it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parts {
    /// By position on the parent.
    pub(super) at: Curve,
    /// Added once more for each link.
    pub(super) step: Option<f64>,
    /// Random part, either way.
    pub(super) vary: Option<f64>,
    /// True if it stands in brackets, where a step that is left out may mean another than none.
    pub(super) in_brackets: bool,
}

impl Parts {
    /// Reads what has widgets; `None` for what is better left in the script's words.
    pub(super) fn of(node: &Node) -> Option<Self> {
        if let Some(at) = Curve::of(node) {
            return Some(Self {
                at,
                step: None,
                vary: None,
                in_brackets: false,
            });
        }
        let Kind::Struct { fields, .. } = &node.kind else {
            return None;
        };
        let mut parts = Self {
            at: Curve::Flat(0.0),
            step: None,
            vary: None,
            in_brackets: true,
        };
        if !fields.iter().any(|f| f.key == "at") {
            // A factor without a value is 1, an angle 0; the step tells an angle.
            let is_angle = fields.iter().any(|f| f.key == "step");
            parts.at = Curve::Flat(if is_angle { 0.0 } else { f64::NAN });
        }
        for entry in fields {
            match entry.key.as_str() {
                "at" => parts.at = Curve::of(&entry.value)?,
                "step" => parts.step = Some(number_of(&entry.value)?),
                "vary" => parts.vary = Some(number_of(&entry.value)?),
                _ => return None,
            }
        }
        if matches!(parts.at, Curve::Flat(value) if value.is_nan()) {
            return None;
        }
        Some(parts)
    }

    /// As a script writes it.
    pub(super) fn text(&self) -> String {
        if !self.in_brackets && self.step.is_none() && self.vary.is_none() {
            return self.at.text();
        }
        let mut fields = Vec::new();
        if self.at != Curve::Flat(0.0) || self.step.is_none() {
            fields.push(format!("at: {}", self.at.text()));
        }
        if let Some(step) = self.step {
            fields.push(format!("step: {}", curve::number(step)));
        }
        if let Some(vary) = self.vary {
            fields.push(format!("vary: {}", curve::number(vary)));
        }
        format!("({})", fields.join(", "))
    }

    /// As a script writes it where brackets without a step mean this one: what had no brackets has no step, either.
    pub(super) fn text_with(&self, usual_step: f64) -> String {
        let gets_brackets = !self.in_brackets && self.vary.is_some();
        let step = (gets_brackets && usual_step != 0.0).then_some(0.0);
        let step = self.step.or(step);
        Self {
            step,
            ..self.clone()
        }
        .text()
    }

    /// The same, changed by as much at every position, so far as all of it stays within its limits.
    pub(super) fn shifted(&self, by: f64, limits: Limits) -> Self {
        let (low, high) = self.at.range();
        let (least, most) = (f64::from(limits.min) - low, f64::from(limits.max) - high);
        let by = by.clamp(least.min(0.0), most.max(0.0));
        let at = match &self.at {
            Curve::Flat(value) => Curve::Flat(value + by),
            Curve::Points(points) => {
                Curve::Points(points.iter().map(|&[x, y]| [x, y + by]).collect())
            }
        };
        Self { at, ..self.clone() }
    }
}

/// The step that brackets mean where they tell none: that of the field where it is left out.
pub(super) fn usual_step(field: &Field) -> f64 {
    let Absent::Means(text) = field.absent else {
        return 0.0;
    };
    let parts = syntax::parse(text).0.as_ref().and_then(Parts::of);
    parts.and_then(|parts| parts.step).unwrap_or(0.0)
}

/// A number's value.
pub(super) fn number_of(node: &Node) -> Option<f64> {
    match &node.kind {
        Kind::Number(number) => number.parse().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, NoFiles, fields};
    use crate::studio::templates::BLANK;

    #[test]
    fn angles_and_factors_are_read_and_written_as_scripts_have_them() {
        for text in [
            "20",
            "[(0, 1), (1, 0.5)]",
            "(step: 137.5, vary: 20)",
            "(at: [(0, 60), (1, 20)], vary: 10)",
            "(at: 45, step: 90)",
            "(at: 20)",
        ] {
            let parts = Parts::of(&syntax::parse(text).0.unwrap()).unwrap();
            assert_eq!(parts.text(), text);
        }
        // What has no widget is left to the script's words.
        for text in ["(vary: 0.2)", "(at: \"x\")", "(around: 3)", "true"] {
            assert_eq!(Parts::of(&syntax::parse(text).0.unwrap()), None, "{text}");
        }
    }

    #[test]
    fn a_number_that_gets_chance_or_a_step_keeps_all_else() {
        let usual = usual_step(fields::BRANCH.field("around").unwrap());
        for (around, step, vary, text, read) in [
            ("20", None, Some(15.0), "(at: 20, step: 0, vary: 15)", 0.0),
            ("20", Some(90.0), None, "(at: 20, step: 90)", 90.0),
            ("20", None, None, "20", 0.0),
            ("(at: 20)", None, Some(15.0), "(at: 20, vary: 15)", 137.5),
        ] {
            let mut parts = Parts::of(&syntax::parse(around).0.unwrap()).unwrap();
            (parts.step, parts.vary) = (step, vary);
            let written = parts.text_with(usual);
            assert_eq!(written, text, "{around}");
            let script = BLANK.replace("links: 18,", &format!("links: 18, around: {written},"));
            let species = species::parse("blank", &script, &NoFiles).unwrap();
            assert_eq!(species.levels[1].placement.around.step, read, "{text}");
        }
        // Where brackets mean no step, none is told.
        let down = usual_step(fields::BRANCH.field("down").unwrap());
        let mut parts = Parts::of(&syntax::parse("50").0.unwrap()).unwrap();
        parts.vary = Some(5.0);
        assert_eq!(parts.text_with(down), "(at: 50, vary: 5)");
    }

    #[test]
    fn a_shift_keeps_the_form_the_step_and_the_chance_and_stays_within_limits() {
        let limits = Limits {
            min: -360.0,
            max: 360.0,
            unit: "degrees",
        };
        for (text, by, shifted) in [
            ("20", 15.5, "35.5"),
            ("[(0, 60), (1, 20)]", -30.0, "[(0, 30), (1, -10)]"),
            ("(step: 137.5)", 12.0, "(at: 12, step: 137.5)"),
            ("(at: 20)", 1.0, "(at: 21)"),
            (
                "(at: [(0, 300), (1, 20)], vary: 10)",
                90.0,
                "(at: [(0, 360), (1, 80)], vary: 10)",
            ),
        ] {
            let parts = Parts::of(&syntax::parse(text).0.unwrap()).unwrap();
            assert_eq!(parts.shifted(by, limits).text(), shifted, "{text}");
        }
    }
}

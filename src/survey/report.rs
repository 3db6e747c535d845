//! Figures of many trees beside what is known of real ones.

use super::reference::{Estimated, Group, LeafUnit, LogLog, Reference};
use super::{Measures, Spread};
use crate::evaluate::text::number;

/// What figures lie within.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Range {
    /// Low end.
    pub low: f32,
    /// High end; `None` if it is open.
    pub high: Option<f32>,
    /// Where it comes from.
    pub of: String,
}

/// How figures compare with their range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The median lies within.
    Within,
    /// The median lies below.
    Below,
    /// The median lies above.
    Above,
    /// There is nothing to compare with.
    NoReference,
}

impl Verdict {
    /// In a word or two.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Within => "within",
            Self::Below => "BELOW",
            Self::Above => "ABOVE",
            Self::NoReference => "no reference",
        }
    }
}

/// One figure of all trees.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Line {
    /// What was measured, in words.
    pub name: String,
    /// Unit; empty for a bare number.
    pub unit: &'static str,
    /// Over the trees; `None` if no tree has it.
    pub value: Option<Spread>,
    /// What real trees have.
    pub reference: Option<Range>,
    /// How the two compare.
    pub verdict: Verdict,
    /// Why there is no reference, or what to know of it.
    pub note: String,
}

/// Leaf-area index of most open-grown trees: from the 10th percentile of species' medians in the Urban Tree
/// Database to its spruces'.
const LEAF_AREA_INDEX: (f32, f32) = (1.3, 5.5);
/// Median of a tree's fork area ratios: Leonardo's 1 to a digitised walnut's 1.16, with room on both sides.
const FORK_AREA: (f32, f32) = (0.95, 1.25);
/// Part of the forks with ratios of 0.8 to 1.7: P10 to P90 of the walnut.
const FORKS_WITHIN: f32 = 0.8;
/// Bifurcation ratio of broadleaved trees: twelve trees scanned by laser have 2.97 to 4.38, apple 4.35.
const BIFURCATION: (f32, f32) = (2.8, 5.0);
/// R^2 of the numbers of branches by order: all of 24 scanned trees reach it.
const BIFURCATION_R2: f32 = 0.97;
/// Part of the trees that should lie within two standard deviations of a regression.
const WITHIN_TWO: f32 = 0.95;

/// All figures of the trees of one species, with verdicts; `reference` is what is known of the species.
#[must_use]
pub fn lines(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    let mut lines = size(trees, reference);
    lines.extend(allometry(trees, reference));
    lines.extend(foliage(trees, reference));
    lines.extend(wood(trees, reference));
    lines.extend(angles(trees, reference));
    lines
}

impl Line {
    /// What was measured, with its unit.
    #[must_use]
    pub fn title(&self) -> String {
        match self.unit {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        }
    }

    /// Median, spread and reference in words; `-` for what there is not.
    #[must_use]
    pub fn figures(&self) -> [String; 3] {
        let none = || "-".to_owned();
        let (median, spread) = match self.value {
            Some(Spread { p10, median, p90 }) => (
                figure(median),
                format!("{} to {}", figure(p10), figure(p90)),
            ),
            None => (none(), none()),
        };
        let range = self
            .reference
            .as_ref()
            .map_or_else(none, |range| match range.high {
                Some(high) => format!("{} to {}", figure(range.low), figure(high)),
                None => format!("{} or more", figure(range.low)),
            });
        [median, spread, range]
    }

    fn new(name: impl Into<String>, unit: &'static str, figures: Vec<f32>) -> Self {
        Self {
            name: name.into(),
            unit,
            value: Spread::of(&figures),
            reference: None,
            verdict: Verdict::NoReference,
            note: String::new(),
        }
    }

    /// Compares the median with a range.
    fn against(mut self, low: f32, high: Option<f32>, of: &str) -> Self {
        if let Some(value) = self.value {
            self.verdict = if value.median < low {
                Verdict::Below
            } else if high.is_some_and(|high| value.median > high) {
                Verdict::Above
            } else {
                Verdict::Within
            };
        }
        let of = of.to_owned();
        self.reference = Some(Range { low, high, of });
        self
    }

    /// Compares with a species' range, if there is a species.
    fn of_species(
        self,
        reference: Option<&Reference>,
        range: fn(&Reference) -> (f32, f32),
    ) -> Self {
        match reference {
            Some(r) => {
                let (low, high) = range(r);
                self.against(low, Some(high), &r.latin)
            }
            None => self.note("the species is not in the table"),
        }
    }

    fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// Says that a reference is an estimate.
    fn estimate(self, reference: Option<&Reference>, figure: Estimated) -> Self {
        if reference.is_some_and(|r| r.is_estimated(figure)) {
            self.note("range estimated, not measured")
        } else {
            self
        }
    }
}

fn of_all(trees: &[Measures], figure: impl Fn(&Measures) -> Option<f32>) -> Vec<f32> {
    trees.iter().filter_map(figure).collect()
}

fn size(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    let over_height = |m: &Measures| {
        let width = m.crown_width_m?;
        (m.height_m > 0.0).then(|| width / m.height_m)
    };
    let stems = trees.iter().map(|m| m.stems).max().unwrap_or(0);
    let dbh =
        Line::new("DBH", "cm", of_all(trees, |m| m.dbh_cm)).of_species(reference, |r| r.dbh_cm);
    vec![
        Line::new("height", "m", of_all(trees, |m| Some(m.height_m)))
            .of_species(reference, |r| r.height_m),
        match stems {
            0 => dbh.note("no stem reaches 1.3 m"),
            1 => dbh,
            _ => dbh.note(format!(
                "of up to {stems} stems: root of the sum of squares"
            )),
        },
        Line::new("crown width", "m", of_all(trees, |m| m.crown_width_m))
            .of_species(reference, |r| r.crown_width_m),
        Line::new("crown width / height", "", of_all(trees, over_height))
            .of_species(reference, |r| r.crown_over_height)
            .estimate(reference, Estimated::CrownOverHeight),
        Line::new("crown base", "m", of_all(trees, |m| m.crown_base_m))
            .note("2 % of the leaf area hang lower"),
        Line::new("clear bole / height", "", of_all(trees, |m| m.clear_bole))
            .of_species(reference, |r| r.clear_bole)
            .estimate(reference, Estimated::Bole),
    ]
}

fn allometry(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    let fit = reference.and_then(Reference::regressions);
    let line = |name: &str, regression: Option<LogLog>, metres: fn(&Measures) -> Option<f32>| {
        let Some((fit, regression)) = fit.as_ref().zip(regression) else {
            let why = match reference {
                None => "the species is not in the table",
                Some(r) if r.group == Group::Palm => "a palm's thickness does not tell its size",
                Some(r) if r.columnar => "no regression of columnar crowns",
                Some(_) => "no regression of its kind",
            };
            return Line::new(name, "sd", Vec::new()).note(why);
        };
        let deviations = of_all(trees, |m| {
            Some(regression.deviations(m.dbh_cm?, metres(m)?))
        });
        let line = Line::new(name, "sd", deviations.clone());
        let LogLog(a, b, sd) = regression;
        let share = part(&deviations, |d| d.abs() <= 2.0);
        let note = format!(
            "{:.0} % of the trees within 2 sd of exp({a} + {b} ln D), sd {sd}",
            share * 100.0
        );
        let of = format!("{} trees, {}", fit.trees, fit.of);
        let mut line = line.against(-2.0, Some(2.0), &of).note(note);
        line.verdict = match line.value {
            None => Verdict::NoReference,
            Some(_) if share >= WITHIN_TWO => Verdict::Within,
            Some(value) if value.median < 0.0 => Verdict::Below,
            Some(_) => Verdict::Above,
        };
        line
    };
    let height = fit.as_ref().map(|f| f.ln_height);
    let crown = fit
        .as_ref()
        .filter(|_| reference.is_some_and(|r| !r.columnar))
        .map(|f| f.ln_crown);
    vec![
        line("height for the DBH", height, |m| Some(m.height_m)),
        line("crown width for the DBH", crown, |m| m.crown_width_m),
    ]
}

fn foliage(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    #[expect(clippy::cast_precision_loss, reason = "a count to seven digits")]
    let leaves = of_all(trees, |m| Some(m.leaves as f32));
    let count = Line::new("leaf blades", "", leaves);
    let mut lines = vec![match reference {
        None => count.note("the species is not in the table"),
        Some(r) => match (r.leaf_unit, r.leaves) {
            (LeafUnit::Leaves, Some((low, high))) => count
                .against(low, Some(high), &r.latin)
                .estimate(reference, Estimated::Leaves),
            (unit, _) => count.note(format!("no count of blades: {} are counted", unit.words())),
        },
    }];
    if let Some((r, (low, high))) = reference
        .filter(|r| r.leaf_unit == LeafUnit::Fronds)
        .and_then(|r| Some((r, r.leaves?)))
    {
        let fronds = of_all(trees, |m| Some(crate::math::float(m.leafy_limbs)));
        let line = Line::new("fronds", "", fronds).against(low, Some(high), &r.latin);
        lines.push(line.estimate(reference, Estimated::Leaves));
    }
    lines.push(
        Line::new("leaf area", "m2", of_all(trees, |m| Some(m.leaf_area_m2)))
            .note("one side; no reference"),
    );
    let index = || of_all(trees, |m| m.leaf_area_index);
    let (low, high) = LEAF_AREA_INDEX;
    let own = reference.and_then(|r| Some((r, r.fit.as_ref()?.leaf_area_index?)));
    let group = reference.map(|r| r.group);
    // Conifers hold their needles for years: where the species was measured, that range is the one to meet.
    if group != Some(Group::Palm) && (group != Some(Group::Conifer) || own.is_none()) {
        let line = Line::new("leaf-area index", "", index());
        lines.push(line.against(low, Some(high), "open-grown trees"));
    }
    if let Some((r, (p10, _, p90))) = own {
        let of = r.fit.as_ref().map_or("", |f| &f.of);
        let line = Line::new("leaf-area index of the species", "", index());
        lines.push(
            line.against(p10, Some(p90), of)
                .note("P10 to P90 of measured trees"),
        );
    }
    lines
}

fn wood(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    let group = reference.map(|r| r.group);
    let forks = Line::new(
        "fork area ratio",
        "",
        of_all(trees, |m| m.fork_area_ratio.map(|s| s.median)),
    );
    let within = Line::new(
        "forks with ratio 0.8 to 1.7",
        "",
        of_all(trees, |m| m.forks_in_range),
    );
    let ratio = Line::new(
        "Strahler bifurcation",
        "",
        of_all(trees, |m| m.bifurcation_ratio),
    );
    let r2 = Line::new("Strahler R2", "", of_all(trees, |m| m.bifurcation_r2));
    if group == Some(Group::Palm) {
        let why = "a palm's stem does not fork: fronds are leaves";
        return [forks, within, ratio, r2].map(|line| line.note(why)).into();
    }
    let bifurcation = match group {
        Some(Group::Broadleaf) => {
            let (low, high) = BIFURCATION;
            ratio.against(low, Some(high), "scanned broadleaved trees")
        }
        Some(_) => ratio.note("known of broadleaved trees only"),
        None => ratio.note("known of broadleaved trees; the species is not in the table"),
    };
    let orders = trees.iter().map(|m| m.strahler.len()).max().unwrap_or(0);
    let (low, high) = FORK_AREA;
    vec![
        forks.against(low, Some(high), "Leonardo's rule; a digitised walnut"),
        within.against(FORKS_WITHIN, None, "a digitised walnut"),
        bifurcation,
        r2.against(BIFURCATION_R2, None, "scanned trees")
            .note(format!("{orders} orders")),
    ]
}

fn angles(trees: &[Measures], reference: Option<&Reference>) -> Vec<Line> {
    let orders = trees
        .iter()
        .map(|m| m.insertion_deg.len())
        .max()
        .unwrap_or(0);
    (0..orders)
        .map(|index| {
            let medians = of_all(trees, |m| m.insertion_deg.get(index).map(|s| s.median));
            let line = Line::new(
                format!("insertion angle, order {}", index + 1),
                "deg",
                medians,
            );
            match index {
                0 => line
                    .of_species(reference, |r| r.order1_deg)
                    .estimate(reference, Estimated::Angles),
                _ => line.note("known of order 1 only"),
            }
        })
        .collect()
}

/// Part of the figures for which something holds; 0 of none.
fn part(figures: &[f32], holds: impl Fn(f32) -> bool) -> f32 {
    let count = |n: usize| crate::math::float(u32::try_from(n).unwrap_or(u32::MAX));
    let those = figures.iter().filter(|&&f| holds(f)).count();
    count(those) / count(figures.len()).max(1.0)
}

/// A number with three digits or so, its thousands apart.
fn figure(x: f32) -> String {
    let digits = match x.abs() {
        1000.0.. => return number(u64::from(crate::math::round_to_u32(x))),
        100.0.. => 0,
        10.0.. => 1,
        _ => 2,
    };
    let text = format!("{x:.digits$}");
    // Whole numbers of ranges and counts stand without zeros behind the point.
    match text.split_once('.') {
        Some((whole, zeros)) if zeros.bytes().all(|b| b == b'0') => {
            if whole == "-0" { "0" } else { whole }.to_owned()
        }
        _ => text,
    }
}

//! What an evaluation comes to: a verdict for each LOD, and the rows of its table on the terminal.

use super::text::{fixed, number, percent, plus_minus, signed_percent};
use super::{Evaluation, Model, Scores};

/// Covered area may differ from the full tree's by this part (mean over views, without its sign) in a
/// good LOD. From about here on a tree is seen to thin out or to fill up when it switches.
pub const MAX_COVERAGE_ERROR: f32 = 0.05;

/// Least IoU of the silhouettes in a good LOD. A choice, not a law: sparse crowns lose IoU to shifts of
/// single leaves that nobody sees.
pub const MIN_IOU: f32 = 0.8;

/// Lines of the screen for which [`Model::screen_size`] is turned into pixels.
const SCREEN_LINES: f32 = 1080.0;

/// Whether a LOD can be accepted without looking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within both limits, and no rival of the same budget is better.
    Good,
    /// Past a limit, or not measured.
    LookClosely,
    /// A rival of the same budget has a better silhouette.
    Losing,
}

impl Verdict {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::LookClosely => "look closely",
            Self::Losing => "losing",
        }
    }
}

/// A verdict and what led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Height of the tree at which the limits were held against the LOD, pixels; none if not measured.
    pub height: Option<u32>,
    /// Which limits the LOD is past, in words; empty if none. Rivals are in [`Model::loses_to`].
    pub reasons: Vec<String>,
}

/// Judges one model over all views.
///
/// The limits hold at the size at which the LOD is meant to be seen: of the heights measured, the least
/// that is not below `screen_size` on a screen of 1080 lines, or else the largest. Rivals compare at the
/// largest height, as [`Model::loses_to`] says.
#[must_use]
pub fn judge(model: &Model) -> Judgement {
    let mut reasons = Vec::new();
    let scores = judged_scores(model);
    match scores {
        None => reasons.push("Nothing was measured".to_owned()),
        Some(scores) => {
            let (iou, area) = (scores.all.iou, scores.all.coverage_abs);
            // Written so that NaN fails.
            if !is_iou_good(iou) {
                reasons.push(format!(
                    "Silhouette: IoU {} is below {}",
                    fixed(iou, 3),
                    fixed(MIN_IOU, 2)
                ));
            }
            if !is_coverage_good(area) {
                reasons.push(format!(
                    "Covered area: off by {}, more than {}",
                    percent(area),
                    percent(MAX_COVERAGE_ERROR)
                ));
            }
        }
    }
    let verdict = if !model.loses_to.is_empty() {
        Verdict::Losing
    } else if reasons.is_empty() {
        Verdict::Good
    } else {
        Verdict::LookClosely
    };
    Judgement {
        verdict,
        height: scores.map(|s| s.height),
        reasons,
    }
}

/// True within the limit; false for NaN.
pub(super) fn is_iou_good(iou: f32) -> bool {
    iou >= MIN_IOU
}

/// True within the limit; false for NaN.
pub(super) fn is_coverage_good(coverage_abs: f32) -> bool {
    coverage_abs <= MAX_COVERAGE_ERROR
}

/// Height of the tree on a screen of 1080 lines up to which the model may be shown, pixels.
pub(super) fn shown_height(model: &Model) -> Option<f32> {
    let height = model.screen_size? * SCREEN_LINES;
    height.is_finite().then_some(height)
}

/// The scores against which the limits are held.
pub(super) fn judged_scores(model: &Model) -> Option<&Scores> {
    let shown = shown_height(model).unwrap_or(f32::INFINITY);
    model
        .scores
        .iter()
        .filter(|s| f64::from(s.height) >= f64::from(shown))
        .min_by_key(|s| s.height)
        .or_else(|| largest(model))
}

/// The scores at the largest height.
pub(super) fn largest(model: &Model) -> Option<&Scores> {
    model.scores.iter().max_by_key(|s| s.height)
}

/// Names of the table's columns; `#` marks a number, to be aligned on the right.
pub const TABLE_HEADER: [&str; 13] = [
    "model",
    "#budget",
    "#triangles",
    "#layers",
    "#up to px",
    "#IoU",
    "#area",
    "#area off",
    "#FLIP",
    "#worst",
    "#pop",
    "#flicker",
    "verdict",
];

/// The table's rows, one for each model, as long as [`TABLE_HEADER`]; figures over all views at the
/// largest height. `up to px` is the height of the tree on a screen of 1080 lines up to which a LOD may be shown,
/// `area` the change of the covered area, `area off` the same without its sign, per view; `FLIP` is the mean over
/// both lights and `worst` the larger; `pop` is FLIP at the switch from the next finer LOD, `flicker` the change
/// from frame to frame of an orbit by that of the full tree. Behind the IoU stands half of its 95 % interval.
#[must_use]
pub fn table_rows(evaluation: &Evaluation) -> Vec<Vec<String>> {
    evaluation.models.iter().map(row).collect()
}

fn row(model: &Model) -> Vec<String> {
    let score = |text: &dyn Fn(&super::Score) -> String| {
        largest(model).map_or_else(|| "-".to_owned(), |s| text(&s.all))
    };
    let judgement = judge(model);
    let verdict = match (judgement.verdict, judgement.height) {
        _ if model.rival => "rival".to_owned(),
        (Verdict::Losing, _) => format!("loses to {}", model.loses_to.join(", ")),
        (verdict, Some(height)) => format!("{} at {height} px", verdict.words()),
        (verdict, None) => verdict.words().to_owned(),
    };
    vec![
        model.label.clone(),
        model.budget.map_or_else(|| "full".to_owned(), number),
        number(model.triangles),
        fixed(model.layers, 2),
        shown_height(model).map_or_else(|| "-".to_owned(), |px| fixed(px, 0)),
        largest(model).map_or_else(
            || "-".to_owned(),
            |s| {
                let iou = fixed(s.all.iou, 3) + " " + &plus_minus(s.iou_interval, 3);
                iou.trim_end().to_owned()
            },
        ),
        score(&|s| signed_percent(s.coverage)),
        score(&|s| percent(s.coverage_abs)),
        score(&|s| fixed(s.flip, 3)),
        score(&|s| fixed(s.flip_worst, 3)),
        model
            .pop
            .map_or_else(|| "-".to_owned(), |p| fixed(p.flip, 3)),
        model
            .flicker
            .map_or_else(|| "-".to_owned(), |f| fixed(f.ratio, 2)),
        verdict,
    ]
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn a_lod_is_judged_at_the_size_at_which_it_is_shown() {
        let mut model = sample::model("LOD3", 1_000, 0.7);
        model.screen_size = Some(0.1);
        assert_eq!(judge(&model).height, Some(128), "108 px on a screen");
        model.screen_size = Some(0.001);
        assert_eq!(judge(&model).height, Some(16));
        model.screen_size = Some(1.0);
        assert_eq!(
            judge(&model).height,
            Some(512),
            "no picture is as large as that"
        );
        model.screen_size = None;
        assert_eq!(judge(&model).height, Some(512));
        model.screen_size = Some(f32::NAN);
        assert_eq!(judge(&model).height, Some(512));
    }

    #[test]
    fn each_limit_alone_asks_for_a_look() {
        let mut model = sample::model("LOD1", 1_000, 0.9);
        model.screen_size = None;
        for scores in &mut model.scores {
            scores.all.iou = MIN_IOU;
            scores.all.coverage_abs = MAX_COVERAGE_ERROR;
        }
        assert_eq!(judge(&model).verdict, Verdict::Good, "limits are inside");
        let mut thin = model.clone();
        thin.scores[0].all.coverage_abs = 0.051;
        assert_eq!(judge(&thin).verdict, Verdict::LookClosely);
        let mut shifted = model.clone();
        shifted.scores[0].all.iou = 0.79;
        assert_eq!(judge(&shifted).verdict, Verdict::LookClosely);
        let mut unknown = model.clone();
        unknown.scores[0].all.iou = f32::NAN;
        assert_eq!(judge(&unknown).verdict, Verdict::LookClosely);
        let mut bare = model.clone();
        bare.scores.clear();
        assert_eq!(judge(&bare).verdict, Verdict::LookClosely);
        model.loses_to.push("quadrics".to_owned());
        let losing = judge(&model);
        assert_eq!(losing.verdict, Verdict::Losing);
        assert!(losing.reasons.is_empty(), "the limits hold");
    }

    #[test]
    fn the_table_has_a_row_for_each_model_and_a_cell_for_each_column() {
        let mut evaluation = sample::evaluation();
        evaluation.models[0].scores.clear();
        let rows = table_rows(&evaluation);
        assert_eq!(rows.len(), evaluation.models.len());
        for (row, model) in rows.iter().zip(&evaluation.models) {
            assert_eq!(row.len(), TABLE_HEADER.len());
            assert_eq!(row[0], model.label);
        }
        assert_eq!(rows[0][5..10], ["-"; 5]);
        assert_eq!(rows[1][5], "0.930 \u{b1}0.010");
    }
}

//! The report: one self-contained HTML file.

use super::Evaluation;

/// The report of one evaluation as a page that needs nothing else.
#[must_use]
pub fn html(evaluation: &Evaluation) -> String {
    evaluation.name.clone()
}

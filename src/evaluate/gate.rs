//! A gate for continuous integration: what in an evaluation is worse than was agreed.

use super::summary::judged_scores;
use super::text::percent;
use super::{Evaluation, Model};

/// A sentence for each LOD whose covered area is off by more than `limit` (a part, mean over all views, at the
/// height at which [`super::judge`] holds limits against it), and for each that loses to a rival of its budget.
/// A LOD that was not measured passes no gate.
#[must_use]
pub fn faults_above(evaluation: &Evaluation, limit: f32) -> Vec<String> {
    let lods = evaluation.models.iter().filter(|m| !m.rival);
    lods.flat_map(|model| faults(model, limit)).collect()
}

fn faults(model: &Model, limit: f32) -> Vec<String> {
    let mut faults = Vec::new();
    match judged_scores(model) {
        None => faults.push(format!("{}: nothing was measured", model.label)),
        // Written so that NaN is above.
        Some(scores) if !is_within(scores.all.coverage_abs, limit) => faults.push(format!(
            "{}: the covered area is off by {} at {} px, more than {}",
            model.label,
            percent(scores.all.coverage_abs),
            scores.height,
            percent(limit)
        )),
        Some(_) => {}
    }
    if !model.loses_to.is_empty() {
        faults.push(format!(
            "{}: its silhouette is worse than that of {} with no more triangles",
            model.label,
            model.loses_to.join(", ")
        ));
    }
    faults
}

fn is_within(value: f32, limit: f32) -> bool {
    value <= limit
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn the_gate_names_what_is_above_the_limit_and_who_loses() {
        let mut evaluation = sample::evaluation();
        evaluation.models.truncate(2);
        for model in &mut evaluation.models {
            model.screen_size = None;
            model.scores[0].all.coverage_abs = 0.04;
        }
        assert!(
            faults_above(&evaluation, 0.04).is_empty(),
            "limits are inside"
        );
        let found = faults_above(&evaluation, 0.03);
        assert_eq!(found.len(), 2);
        assert!(
            found[1].starts_with("LOD1: ") && found[1].contains("512 px"),
            "{found:?}"
        );
        evaluation.models[1].loses_to.push("random".to_owned());
        evaluation.models[0].scores.clear();
        let found = faults_above(&evaluation, 0.04).join("\n");
        assert!(
            found.contains("LOD0: nothing") && found.contains("of random"),
            "{found}"
        );
        evaluation.models[1].scores[0].all.coverage_abs = f32::NAN;
        assert_eq!(faults_above(&evaluation, 9.0).len(), 3, "NaN is above");
        evaluation.models[0].rival = true;
        assert_eq!(faults_above(&evaluation, 9.0).len(), 2, "rivals may be bad");
    }
}

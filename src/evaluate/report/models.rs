//! The parts of the page on one LOD, and on the rivals.

use super::super::summary::{judge, largest, shown_height};
use super::super::text::{bytes, fixed, number};
use super::super::{Evaluation, Model};
use super::cards::badge;
use super::html::{escape, facts};
use super::{chosen, plates, tables, words};

/// One LOD: its figures, pictures and tables.
pub(super) fn lod(page: &mut String, index: usize, model: &Model, evaluation: &Evaluation) {
    let judgement = judge(model);
    page.push_str(&format!(
        "<section id=\"m{index}\" class=\"model\" aria-labelledby=\"m{index}-title\">\n\
         <h2 id=\"m{index}-title\">{} {}</h2>\n{}{}",
        escape(&model.label),
        badge(judgement.verdict),
        model_facts(model, evaluation),
        losses(model, evaluation)
    ));
    if let Some(height) = judgement.height.filter(|_| !judgement.reasons.is_empty()) {
        let reasons = escape(&judgement.reasons.join(". "));
        page.push_str(&format!(
            "<p class=\"warns\"><b>At {height} px</b> {reasons}.</p>\n"
        ));
    }
    plates::section(
        page,
        model,
        &plates::of_model(evaluation, index),
        "h3",
        judgement.height,
    );
    page.push_str(&tables::scores(model));
    page.push_str("</section>\n");
}

/// The rivals in less detail: they are there to be beaten.
pub(super) fn rivals(page: &mut String, evaluation: &Evaluation) {
    if chosen(evaluation, true).next().is_none() {
        return;
    }
    page.push_str(&format!(
        "<section id=\"rivals\" class=\"model\" aria-labelledby=\"rivals-title\">\n\
         <h2 id=\"rivals-title\">Rivals</h2>\n<p class=\"hint\">{}</p>\n",
        words::RIVAL
    ));
    for (index, model) in chosen(evaluation, true) {
        page.push_str(&format!(
            "<article id=\"m{index}\" class=\"rival-part\">\n<h3>{}{}</h3>\n{}",
            escape(&model.label),
            model.budget.map_or_else(String::new, |budget| format!(
                " <span class=\"hint\">at a budget of {}</span>",
                number(budget)
            )),
            model_facts(model, evaluation)
        ));
        let pairs = plates::of_model(evaluation, index);
        plates::section(page, model, &pairs, "h4", None);
        page.push_str(&format!(
            "<details><summary>All figures</summary>\n{}</details>\n</article>\n",
            tables::scores(model)
        ));
    }
    page.push_str("</section>\n");
}

fn model_facts(model: &Model, evaluation: &Evaluation) -> String {
    let mut pairs = vec![
        ("Triangles", number(model.triangles)),
        (
            "Of the full tree",
            tables::part_of_full(model.triangles, evaluation.reference_triangles),
        ),
        (
            "Budget",
            model.budget.map_or_else(|| "full".to_owned(), number),
        ),
        ("Layers (overdraw)", fixed(model.layers, 2)),
    ];
    if let Some(error) = model.error_m {
        pairs.push(("Error", tables::metres(error)));
    }
    if let Some(height) = shown_height(model) {
        pairs.push(("Shown up to", fixed(height, 0) + " px of 1080"));
    }
    if let Some(pop) = model.pop {
        let words = format!(
            "{}, worst {}, at {} px",
            fixed(pop.flip, 3),
            fixed(pop.worst, 3),
            pop.height
        );
        pairs.push(("Pop (FLIP at the switch)", words));
    }
    if let Some(flicker) = model.flicker {
        let words = format!(
            "{} of the full tree, worst step {}",
            fixed(flicker.ratio, 2),
            fixed(flicker.worst_ratio, 2)
        );
        pairs.push(("Flicker", words));
    }
    if !model.rival {
        pairs.push(("Foliage texture, shared", bytes(evaluation.texture_bytes)));
    }
    if !model.state.is_empty() {
        let name = if model.rival {
            "Settings"
        } else {
            "Forms of the levels"
        };
        pairs.push((name, escape(&model.state)));
    }
    facts(&pairs)
}

/// A line for each rival that beats the model, with both silhouettes, and one for those that may.
fn losses(model: &Model, evaluation: &Evaluation) -> String {
    let iou = |m: &Model| largest(m).map_or_else(|| "-".to_owned(), |s| fixed(s.all.iou, 3));
    let undecided: Vec<String> = model.undecided.iter().map(|name| escape(name)).collect();
    let undecided = if undecided.is_empty() {
        String::new()
    } else {
        format!(
            "<p class=\"hint\">These views do not tell whether the silhouette is better than that of {}.</p>\n",
            undecided.join(", ")
        )
    };
    let losses: String = model
        .loses_to
        .iter()
        .map(|name| {
            let rival = evaluation
                .models
                .iter()
                .find(|m| m.rival && m.label == *name && m.budget == model.budget);
            let against = rival.map_or_else(String::new, |rival| {
                format!(": IoU {} against {}", iou(rival), iou(model))
            });
            format!(
                "<p class=\"loses\"><b>Loses to {}</b> of the same budget{against} at the largest height.</p>\n",
                escape(name)
            )
        })
        .collect();
    losses + &undecided
}

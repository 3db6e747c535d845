//! The verdicts: a card for each LOD, and the small signs that stand for a verdict elsewhere.

use super::super::summary::{
    Judgement, MAX_COVERAGE_ERROR, MIN_IOU, judge, judged_scores, shown_height,
};
use super::super::text::{count, fixed, percent, signed_percent};
use super::super::{Evaluation, Model, Verdict};
use super::html::{Size, escape, facts, minus};
use super::{chosen, count_of_triangles, plates, tables};

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::LookClosely => "look",
        Verdict::Losing => "losing",
    }
}

/// A sign that differs in shape, not only in colour.
fn sign(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "\u{2713}",
        Verdict::LookClosely => "\u{25d0}",
        Verdict::Losing => "\u{2715}",
    }
}

/// A verdict as a sign alone.
pub(super) fn dot(verdict: Verdict) -> String {
    format!(
        "<span class=\"dot {}\" role=\"img\" aria-label=\"{}\">{}</span> ",
        class(verdict),
        verdict.words(),
        sign(verdict)
    )
}

/// A verdict as a small label.
pub(super) fn badge(verdict: Verdict) -> String {
    format!(
        "<span class=\"badge {}\"><span aria-hidden=\"true\">{}</span> {}</span>",
        class(verdict),
        sign(verdict),
        verdict.words()
    )
}

/// The section that says at a glance which LODs can be accepted, and by which limits.
pub(super) fn section(page: &mut String, evaluation: &Evaluation) {
    let lods: Vec<(usize, &Model, Judgement)> = chosen(evaluation, false)
        .map(|(index, model)| (index, model, judge(model)))
        .collect();
    let of = |verdict: Verdict| lods.iter().filter(|l| l.2.verdict == verdict).count();
    let lede = if lods.is_empty() {
        "No LOD was measured.".to_owned()
    } else {
        let parts = [
            (of(Verdict::Good), "good"),
            (of(Verdict::LookClosely), "to look at closely"),
            (of(Verdict::Losing), "losing to a rival"),
        ];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(n, _)| *n > 0)
            .map(|(n, words)| format!("{n} {words}"))
            .collect();
        format!(
            "Of {}: {}.",
            count(lods.len(), "LOD", "LODs"),
            parts.join(", ")
        )
    };
    page.push_str(&format!(
        "<section id=\"verdict\" aria-labelledby=\"verdict-title\">\n<h2 id=\"verdict-title\">Verdict</h2>\n\
         <p class=\"lede\">{lede}</p>\n<div class=\"cards\">\n"
    ));
    for (index, model, judgement) in &lods {
        card(page, *index, model, judgement, evaluation);
    }
    page.push_str(&format!(
        "</div>\n<p class=\"note\"><b>Good</b>: covered area off by at most {} and IoU at least {}, both means \
         over all views, and no rival of the same budget with a better silhouette. <b>Look closely</b>: past one \
         of the two limits, or not measured. <b>Losing</b>: a rival's IoU is better at the largest height, and by \
         more than resampled views leave open (95%). The limits hold at \
         the size at which a LOD is shown: the least height measured that is not below the LOD's screen size on \
         1080 lines.</p>\n</section>\n",
        percent(MAX_COVERAGE_ERROR),
        fixed(MIN_IOU, 2),
    ));
}

fn card(
    page: &mut String,
    index: usize,
    model: &Model,
    judgement: &Judgement,
    evaluation: &Evaluation,
) {
    page.push_str(&format!(
        "<article class=\"card {}\">\n",
        class(judgement.verdict)
    ));
    if let Some(pair) = plates::thumbnail(&plates::of_model(evaluation, index)) {
        page.push_str("<div class=\"thumb\">");
        pair.model(page, &format!("{}, small", model.label), Size::Fit);
        page.push_str("</div>\n");
    }
    page.push_str(&format!(
        "<div class=\"words\">\n<h3><a href=\"#m{index}\">{}</a></h3>\n{}\n\
         <p class=\"size-line\"><b>{}</b> {}</p>\n",
        escape(&model.label),
        badge(judgement.verdict),
        count_of_triangles(model.triangles),
        match tables::part_of_full(model.triangles, evaluation.reference_triangles) {
            part if part.starts_with('1') => format!("{part} of full"),
            _ => String::new(),
        }
    ));
    if let Some(scores) = judged_scores(model) {
        page.push_str(&facts(&[
            ("IoU", fixed(scores.all.iou, 3)),
            ("Area", minus(&signed_percent(scores.all.coverage))),
            ("Area off", percent(scores.all.coverage_abs)),
            ("FLIP", fixed(scores.all.flip, 3)),
            (
                "Pop",
                model
                    .pop
                    .map_or_else(|| "-".to_owned(), |p| fixed(p.flip, 3)),
            ),
        ]));
    }
    let judged = judgement
        .height
        .map_or_else(String::new, |height| format!("Judged at {height} px"));
    let shown = shown_height(model).map_or_else(String::new, |px| {
        format!("; shown up to {} px", fixed(px, 0))
    });
    page.push_str(&format!(
        "<p class=\"hint\">{judged}{shown}</p>\n{}</div>\n</article>\n",
        reasons(model, judgement)
    ));
}

/// What speaks against a LOD, for its card.
fn reasons(model: &Model, judgement: &Judgement) -> String {
    let losses = model
        .loses_to
        .iter()
        .map(|name| format!("<li class=\"loss\">Loses to {}</li>", escape(name)));
    let limits = judgement
        .reasons
        .iter()
        .map(|r| format!("<li>{}</li>", escape(r)));
    let items: String = losses.chain(limits).collect();
    if items.is_empty() {
        return items;
    }
    format!("<ul class=\"reasons\">{items}</ul>\n")
}

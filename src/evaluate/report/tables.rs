//! The report's tables.

use super::super::summary::{is_coverage_good, is_iou_good, judge, largest, shown_height};
use super::super::text::{fixed, number, percent, plus_minus, signed_percent};
use super::super::{Evaluation, Model, Score, Scores};
use super::cards::badge;
use super::html::{escape, minus};
use super::words;

/// All LODs, or all rivals, at the largest height. Empty if there are none.
pub(super) fn models(evaluation: &Evaluation, rivals: bool) -> String {
    let chosen: Vec<(usize, &Model)> = evaluation
        .models
        .iter()
        .enumerate()
        .filter(|(_, m)| m.rival == rivals)
        .collect();
    if chosen.is_empty() {
        return String::new();
    }
    let height = evaluation.heights.iter().max().copied().unwrap_or(0);
    let (title, kept, state) = if rivals {
        ("Rivals", words::RIVAL, "Settings")
    } else {
        ("LODs", words::TRIANGLES, "Forms of the levels")
    };
    let caption = format!(
        "<b>{title}</b> at {height} px, means over all views. {kept} {}",
        words::PAST
    );
    let mut head = vec!["Model", "Budget", "Triangles", "Of full", "Layers"];
    if !rivals {
        head.extend(["Error", "Up to"]);
    }
    head.extend(["IoU", "Area", "Area off", "FLIP", "Normals", "Worst"]);
    if !rivals {
        head.extend(["Pop", "Flicker", "Verdict"]);
    }
    head.push(state);
    let head: String = head
        .iter()
        .map(|h| {
            let class = if matches!(*h, "Model" | "Verdict") || *h == state {
                " class=\"text\""
            } else {
                ""
            };
            format!("<th scope=\"col\"{class}>{h}</th>")
        })
        .collect();
    let rows: String = chosen
        .iter()
        .map(|(index, model)| model_row(*index, model, evaluation))
        .collect();
    scrolling(
        title,
        &format!(
            "<table>\n<caption>{caption}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>"
        ),
    )
}

fn model_row(index: usize, model: &Model, evaluation: &Evaluation) -> String {
    let mut row = format!(
        "<tr><th scope=\"row\"><a href=\"#m{index}\">{}</a></th>",
        escape(&model.label)
    );
    let mut cell = |text: &str| row.push_str(&format!("<td>{text}</td>"));
    cell(&model.budget.map_or_else(|| "full".to_owned(), number));
    cell(&number(model.triangles));
    cell(&part_of_full(
        model.triangles,
        evaluation.reference_triangles,
    ));
    cell(&fixed(model.layers, 2));
    if !model.rival {
        cell(&model.error_m.map_or_else(|| "-".to_owned(), metres));
        cell(&shown_height(model).map_or_else(|| "-".to_owned(), |px| fixed(px, 0) + " px"));
    }
    match largest(model) {
        Some(scores) => row.push_str(&format!(
            "{}<td>{}</td>",
            score_cells(&scores.all, "", Some(scores)),
            fixed(scores.all.flip_worst, 3)
        )),
        None => row.push_str(&"<td>-</td>".repeat(6)),
    }
    if !model.rival {
        row.push_str(&format!(
            "<td>{}</td><td>{}</td><td class=\"text\">{}</td>",
            model
                .pop
                .map_or_else(|| "-".to_owned(), |p| fixed(p.flip, 3)),
            model
                .flicker
                .map_or_else(|| "-".to_owned(), |f| fixed(f.ratio, 2)),
            badge(judge(model).verdict)
        ));
    }
    row + &format!(
        "<td class=\"text state\">{}</td></tr>\n",
        escape(&model.state)
    )
}

/// All figures of one model: a row for each height; all views, side views and aerial views.
pub(super) fn scores(model: &Model) -> String {
    if model.scores.is_empty() {
        return "<p class=\"note\">Nothing was measured.</p>\n".to_owned();
    }
    let groups = ["All views", "Side views", "Aerial views"];
    let figures = ["IoU", "Area", "Area off", "FLIP", "Normals"];
    let group_head: String = groups
        .iter()
        .map(|g| format!("<th scope=\"colgroup\" colspan=\"5\" class=\"group\">{g}</th>"))
        .collect();
    let figure_head: String = groups
        .iter()
        .flat_map(|_| figures.iter().enumerate())
        .map(|(i, f)| format!("<th scope=\"col\"{}>{f}</th>", first_of_group(i)))
        .collect();
    let rows: String = model
        .scores
        .iter()
        .map(|s| {
            let cells: String = [(&s.all, Some(s)), (&s.side, None), (&s.aerial, None)]
                .iter()
                .map(|(score, intervals)| score_cells(score, " class=\"first\"", *intervals))
                .collect();
            format!("<tr><th scope=\"row\">{} px</th>{cells}</tr>\n", s.height)
        })
        .collect();
    let label = escape(&model.label);
    scrolling(
        &format!("Figures of {label}"),
        &format!(
            "<table class=\"scores\">\n<caption><b>All figures of {label}</b> by height of the tree. \
             {} {} {} {} {} {}</caption>\n<colgroup></colgroup>{}\n\
             <thead><tr><td></td>{group_head}</tr>\n<tr><th scope=\"col\">Height</th>{figure_head}</tr></thead>\n\
             <tbody>\n{rows}</tbody>\n</table>",
            words::IOU,
            words::AREA,
            words::AREA_OFF,
            words::FLIP,
            words::NORMALS,
            words::PAST,
            "<colgroup span=\"5\"></colgroup>".repeat(groups.len()),
        ),
    )
}

fn first_of_group(index: usize) -> &'static str {
    if index == 0 { " class=\"first\"" } else { "" }
}

/// Five cells; figures past their limit are marked. `first` is the attribute of the first cell, `intervals` holds
/// those of the figures, if they have any.
fn score_cells(score: &Score, first: &str, intervals: Option<&Scores>) -> String {
    let about = |interval: fn(&Scores) -> [f32; 2]| {
        let half = intervals.map_or_else(String::new, |s| plus_minus(interval(s), 3));
        if half.is_empty() {
            half
        } else {
            format!(" <small>{half}</small>")
        }
    };
    let mark = |text: String, is_good: bool| {
        if is_good || text == "-" {
            text
        } else {
            format!("<em class=\"past\">{text}</em>")
        }
    };
    let iou = mark(fixed(score.iou, 3), is_iou_good(score.iou));
    let off = mark(
        percent(score.coverage_abs),
        is_coverage_good(score.coverage_abs),
    );
    let normals = match fixed(score.normal_deg, 1) {
        none if none == "-" => none,
        degrees => degrees + "\u{b0}",
    };
    format!(
        "<td{first}>{iou}{}</td><td>{}</td><td>{off}</td><td>{}{}</td><td>{normals}</td>",
        about(|s| s.iou_interval),
        minus(&signed_percent(score.coverage)),
        fixed(score.flip, 3),
        about(|s| s.flip_interval),
    )
}

/// Metres with three digits.
pub(super) fn metres(x: f32) -> String {
    match fixed(x, 3) {
        none if none == "-" => none,
        text => text + " m",
    }
}

/// `1/83`; `all` for as many triangles as the full tree or more.
pub(super) fn part_of_full(triangles: u64, full: u64) -> String {
    if triangles == 0 || full == 0 {
        return "-".to_owned();
    }
    if triangles >= full {
        return "all".to_owned();
    }
    let tenths = full.saturating_mul(10) / triangles;
    if tenths < 100 {
        format!("1/{}.{}", tenths / 10, tenths % 10)
    } else {
        format!("1/{}", number(tenths / 10))
    }
}

/// A table that scrolls on its own where the page is too narrow; `label` is HTML.
fn scrolling(label: &str, table: &str) -> String {
    format!(
        "<div class=\"scroll\" role=\"region\" aria-label=\"{label}\" tabindex=\"0\">\n{table}\n</div>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::super::super::sample;
    use super::*;

    #[test]
    fn parts_of_the_full_tree_are_fractions() {
        assert_eq!(part_of_full(1_000, 83_000), "1/83");
        assert_eq!(part_of_full(50_000, 83_000), "1/1.6");
        assert_eq!(part_of_full(83_000, 83_000), "all");
        assert_eq!(part_of_full(4, 104_766), "1/26,191");
        assert_eq!(part_of_full(0, 83_000), "-");
    }

    #[test]
    fn rows_are_as_long_as_their_head() {
        let evaluation = sample::evaluation();
        for table in [models(&evaluation, false), models(&evaluation, true)] {
            let columns = table.matches("scope=\"col\"").count();
            for row in table.lines().filter(|l| l.contains("scope=\"row\"")) {
                assert_eq!(row.matches("<td").count() + 1, columns, "{row}");
            }
        }
        let table = scores(&evaluation.models[0]);
        let rows: Vec<&str> = table.lines().filter(|l| l.contains("\"row\"")).collect();
        assert_eq!(rows.len(), 5);
        assert!(rows.iter().all(|r| r.matches("<td").count() == 15));
    }

    #[test]
    fn figures_past_their_limit_are_marked() {
        let good = Score {
            iou: 0.9,
            ..Score::default()
        };
        assert!(!score_cells(&good, "", None).contains("past"));
        let thin = Score {
            coverage_abs: 0.2,
            ..good
        };
        assert_eq!(score_cells(&thin, "", None).matches("past").count(), 1);
        let unknown = Score {
            iou: f32::NAN,
            ..good
        };
        assert!(
            !score_cells(&unknown, "", None).contains("past"),
            "a dash is no fault"
        );
    }
}

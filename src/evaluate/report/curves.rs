//! Which curves the report draws: how the looks fall as triangles and pixels go.

use super::super::summary::{MAX_COVERAGE_ERROR, MIN_IOU, largest};
use super::super::text::{fixed, number, percent};
use super::super::{Evaluation, Model, Score, Scores};
use super::html::escape;
use super::plot::{Axis, Limit, Mark, Plot, Series, legend};
use super::words;

/// Colours of the page for the lines of LODs and of rivals; more lines than that share them.
const COLOURS: usize = 6;
const RIVAL_COLOURS: usize = 4;

const TRIANGLES: &str = "triangles";

/// A coarse LOD is not meant to be as large as the plot shows it.
const LIMIT: &str = "A LOD has to meet the dashed limit only at the size at which it is shown.";

/// The four plots, as far as there is something to draw.
pub(super) fn section(evaluation: &Evaluation) -> String {
    let plots = [
        iou(evaluation),
        coverage(evaluation),
        flip(evaluation),
        rivals(evaluation),
    ];
    let figures: String = plots.into_iter().flatten().collect();
    if figures.is_empty() {
        return String::new();
    }
    format!(
        "<section id=\"curves\" aria-labelledby=\"curves-title\">\n\
         <h2 id=\"curves-title\">Curves</h2>\n<div class=\"curves\">\n{figures}</div>\n</section>\n"
    )
}

fn figure(title: &str, plot: &Plot, caption: &str) -> String {
    let legend = if plot.series.iter().all(|s| s.named) {
        String::new()
    } else {
        legend(&plot.series)
    };
    format!(
        "<figure class=\"card\">\n<h3>{title}</h3>\n{legend}{}<figcaption>{}</figcaption>\n</figure>\n",
        plot.svg(),
        escape(caption)
    )
}

/// One curve over the LODs' triangles, from the scores at the largest height.
fn by_triangles(
    models: &[&Model],
    label: &str,
    class: String,
    mark: Mark,
    value: impl Fn(&Scores) -> f32,
    words: impl Fn(f32) -> String,
) -> Series {
    let mut points: Vec<(f64, f64, String)> = models
        .iter()
        .filter(|m| m.triangles > 0)
        .filter_map(|m| {
            let y = value(largest(m)?);
            let words = format!(
                "{}, {} triangles: {}",
                m.label,
                number(m.triangles),
                words(y)
            );
            y.is_finite()
                .then_some((m.triangles as f64, f64::from(y), words))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Series {
        label: label.to_owned(),
        class,
        mark,
        named: false,
        points,
    }
}

/// A way to one of the three means of a [`Scores`].
type Part = fn(&Scores) -> &Score;

/// Side and aerial views apart, over the triangles of the LODs.
fn of_lods(
    evaluation: &Evaluation,
    value: fn(&Score) -> f32,
    words: fn(f32) -> String,
) -> Vec<Series> {
    let lods: Vec<&Model> = evaluation.models.iter().filter(|m| !m.rival).collect();
    let parts: [(&str, &str, Mark, Part); 2] = [
        ("side views", "side", Mark::Disc, |s| &s.side),
        ("aerial views", "aerial", Mark::Diamond, |s| &s.aerial),
    ];
    parts
        .into_iter()
        .map(|(label, class, mark, part)| {
            by_triangles(
                &lods,
                label,
                class.to_owned(),
                mark,
                |s| value(part(s)),
                words,
            )
        })
        .filter(|s| !s.points.is_empty())
        .collect()
}

fn xs(series: &[Series]) -> impl Iterator<Item = f64> {
    series.iter().flat_map(|s| s.points.iter().map(|p| p.0))
}

fn ys(series: &[Series]) -> impl Iterator<Item = f64> {
    series.iter().flat_map(|s| s.points.iter().map(|p| p.1))
}

fn hundredths(value: f64) -> String {
    format!("{value:.2}")
}

fn iou(evaluation: &Evaluation) -> Option<String> {
    let series = of_lods(evaluation, |s| s.iou, |y| format!("IoU {}", fixed(y, 3)));
    let plot = Plot {
        alt: "Line plot of the silhouettes' IoU against triangles, for side and aerial views. The \
              figures are in the tables."
            .to_owned(),
        x: Axis::log_of(TRIANGLES, xs(&series))?,
        y: Axis::linear_of("IoU", ys(&series), &[1.0, f64::from(MIN_IOU)], hundredths)?,
        series,
        limit: Some(iou_limit()),
    };
    let caption = format!("{} {} {LIMIT}", words::IOU, at_largest(evaluation));
    Some(figure("Silhouette against triangles", &plot, &caption))
}

fn iou_limit() -> Limit {
    Limit {
        at: f64::from(MIN_IOU),
        words: format!("good from {}", fixed(MIN_IOU, 2)),
    }
}

fn at_largest(evaluation: &Evaluation) -> String {
    evaluation
        .heights
        .iter()
        .max()
        .map_or_else(String::new, |height| {
            format!("Here for a tree {height} px high.")
        })
}

fn coverage(evaluation: &Evaluation) -> Option<String> {
    let series = of_lods(
        evaluation,
        |s| s.coverage_abs,
        |y| format!("off by {}", percent(y)),
    );
    let limit = f64::from(MAX_COVERAGE_ERROR);
    let plot = Plot {
        alt: "Line plot of the error of the covered area against triangles, for side and aerial views. \
              The figures are in the tables."
            .to_owned(),
        x: Axis::log_of(TRIANGLES, xs(&series))?,
        y: Axis::linear_of("area off", ys(&series), &[0.0, limit * 1.2], |v| {
            format!("{:.0}%", v * 100.0)
        })?,
        series,
        limit: Some(Limit {
            at: limit,
            words: format!("good up to {}", percent(MAX_COVERAGE_ERROR)),
        }),
    };
    let caption = format!("{} {} {LIMIT}", words::AREA_OFF, at_largest(evaluation));
    Some(figure("Covered area against triangles", &plot, &caption))
}

fn flip(evaluation: &Evaluation) -> Option<String> {
    let lods = evaluation.models.iter().filter(|m| !m.rival);
    let series: Vec<Series> = lods
        .enumerate()
        .map(|(index, model)| flip_line(index, model))
        .filter(|s| !s.points.is_empty())
        .collect();
    let mut x = Axis::log_of("height of the tree, pixels", xs(&series))?;
    x.ticks = evaluation
        .heights
        .iter()
        .map(|&h| (f64::from(h), h.to_string()))
        .filter(|(h, _)| (x.range[0]..=x.range[1]).contains(h))
        .collect();
    let plot = Plot {
        alt: "Line plot of FLIP against the height of the tree in the picture, a line for each LOD. The \
              figures are in the tables."
            .to_owned(),
        x,
        y: Axis::linear_of("FLIP", ys(&series), &[0.0], hundredths)?,
        series,
        limit: None,
    };
    let caption = format!(
        "{} Means over all views; smaller trees forgive more.",
        words::FLIP
    );
    Some(figure("Seen difference against size", &plot, &caption))
}

fn flip_line(index: usize, model: &Model) -> Series {
    let mut points: Vec<(f64, f64, String)> = model
        .scores
        .iter()
        .filter(|s| s.height > 0 && s.all.flip.is_finite())
        .map(|s| {
            let words = format!(
                "{} at {} px: FLIP {}",
                model.label,
                s.height,
                fixed(s.all.flip, 3)
            );
            (f64::from(s.height), f64::from(s.all.flip), words)
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    Series {
        label: model.label.clone(),
        class: format!("s{}", index % COLOURS),
        mark: Mark::Disc,
        named: true,
        points,
    }
}

fn rivals(evaluation: &Evaluation) -> Option<String> {
    let mut names: Vec<&str> = Vec::new();
    for model in evaluation.models.iter().filter(|m| m.rival) {
        if !names.contains(&model.label.as_str()) {
            names.push(&model.label);
        }
    }
    if names.is_empty() {
        return None;
    }
    let words = |y: f32| format!("IoU {}", fixed(y, 3));
    let of = |pick: &dyn Fn(&Model) -> bool| -> Vec<&Model> {
        evaluation.models.iter().filter(|m| pick(m)).collect()
    };
    let lods = of(&|m| !m.rival);
    let mut series = vec![by_triangles(
        &lods,
        "the LODs",
        "side".to_owned(),
        Mark::Disc,
        |s| s.all.iou,
        words,
    )];
    let marks = [Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Cross];
    for (index, name) in names.into_iter().enumerate() {
        let models = of(&|m| m.rival && m.label == name);
        let class = format!("rival r{}", index % RIVAL_COLOURS);
        let mark = marks[index % marks.len()];
        series.push(by_triangles(
            &models,
            name,
            class,
            mark,
            |s| s.all.iou,
            words,
        ));
    }
    series.retain(|s| !s.points.is_empty());
    let plot = Plot {
        alt: "Plot of the silhouettes' IoU against triangles for the LODs and their rivals. The figures are \
              in the tables."
            .to_owned(),
        x: Axis::log_of(TRIANGLES, xs(&series))?,
        y: Axis::linear_of("IoU", ys(&series), &[1.0], hundredths)?,
        series,
        limit: None,
    };
    let caption = format!(
        "{} {} {} Means over all views.",
        words::IOU,
        words::RIVAL,
        at_largest(evaluation)
    );
    Some(figure("Against the rivals", &plot, &caption))
}

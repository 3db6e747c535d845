//! The report: one self-contained HTML page on which an artist accepts a tree's LODs or sends them back.
//!
//! Nothing comes from the network: pictures are inside the page, each once, and its content policy forbids the
//! rest, every script too but the page's own. That one moves the wipes and blinks; without it the page still
//! shows all. The same evaluation makes the same bytes.

mod cards;
mod curves;
mod html;
mod models;
mod plates;
mod plot;
mod tables;
mod words;

use super::summary::judge;
use super::text::{bytes, count, number};
use super::{Evaluation, Model};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use html::{escape, facts};
use sha2::{Digest, Sha256};

/// The page's look.
const STYLE: &str = include_str!("report/style.css");

/// What moves on the page.
const SCRIPT: &str = include_str!("report/compare.js");

/// The report of one evaluation as a page that needs nothing else.
///
/// Texts of the evaluation are escaped; figures that are no numbers are shown as `-`. Missing pictures,
/// models and scores leave gaps, never faults.
#[must_use]
pub fn html(evaluation: &Evaluation) -> String {
    let mut page = String::with_capacity(page_bytes(evaluation));
    page.push_str(&format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'; script-src 'sha256-{}'\">\n\
         <title>{} {}: LOD evaluation</title>\n<style>\n{STYLE}</style>\n<style>\n{}</style>\n</head>\n<body>\n",
        STANDARD.encode(Sha256::digest(SCRIPT)),
        escape(&evaluation.name),
        evaluation.seed,
        plates::style(evaluation)
    ));
    page.push_str(&header(evaluation));
    page.push_str("<main>\n");
    cards::section(&mut page, evaluation);
    page.push_str(&curves::section(evaluation));
    page.push_str(&figures(evaluation));
    for (index, model) in chosen(evaluation, false) {
        models::lod(&mut page, index, model, evaluation);
    }
    models::rivals(&mut page, evaluation);
    page.push_str(&format!(
        "</main>\n<footer>Written by pleach {}. This page holds all its pictures and loads nothing; they have at \
         most 256 colours.</footer>\n\
         <button type=\"button\" id=\"blink\" aria-pressed=\"false\" hidden>Blink <kbd>B</kbd></button>\n\
         <script>{SCRIPT}</script>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    ));
    page
}

/// The LODs, or the rivals, with their index in the evaluation.
fn chosen(evaluation: &Evaluation, rivals: bool) -> impl Iterator<Item = (usize, &Model)> {
    let models = evaluation.models.iter().enumerate();
    models.filter(move |(_, m)| m.rival == rivals)
}

/// About how long the page gets.
fn page_bytes(evaluation: &Evaluation) -> usize {
    let of = |p: &super::Plate| {
        let shown = p.shown.iter().map(|s| s.picture.len() + s.error.len());
        p.reference.len() + shown.sum::<usize>()
    };
    let pictures: usize = evaluation.plates.iter().map(of).sum();
    pictures / 2 * 3 + 24_576 * (evaluation.models.len() + 2)
}

fn header(evaluation: &Evaluation) -> String {
    let latin = if evaluation.latin.is_empty() {
        String::new()
    } else {
        format!(
            "<p class=\"latin\" lang=\"la\">{}</p>\n",
            escape(&evaluation.latin)
        )
    };
    let heights: Vec<String> = evaluation.heights.iter().map(u32::to_string).collect();
    let rivals = chosen(evaluation, true).count();
    let lods = chosen(evaluation, false).count();
    let mut links: String = chosen(evaluation, false)
        .map(|(index, m)| {
            let sign = cards::dot(judge(m).verdict);
            format!(
                "<li><a href=\"#m{index}\">{sign}{}</a></li>",
                escape(&m.label)
            )
        })
        .collect();
    if rivals > 0 {
        links.push_str("<li><a href=\"#rivals\">Rivals</a></li>");
    }
    let none = |text: String| {
        if text.is_empty() {
            "-".to_owned()
        } else {
            text
        }
    };
    format!(
        "<header>\n<p class=\"kicker\">LOD evaluation</p>\n<h1>{}</h1>\n{latin}{}\
         <nav aria-label=\"Sections\"><ul><li><a href=\"#verdict\">Verdict</a></li>\
         <li><a href=\"#figures\">Figures</a></li>{links}</ul></nav>\n</header>\n",
        escape(&evaluation.name),
        facts(&[
            ("Seed", evaluation.seed.to_string()),
            (
                "Full tree",
                count_of_triangles(evaluation.reference_triangles)
            ),
            (
                "Compared",
                format!(
                    "{}, {}",
                    count(lods, "LOD", "LODs"),
                    count(rivals, "rival", "rivals")
                )
            ),
            ("Foliage texture", bytes(evaluation.texture_bytes)),
            (
                "Views",
                format!(
                    "{} side, {} aerial",
                    evaluation.side_views, evaluation.aerial_views
                )
            ),
            ("Heights of the tree", none(heights.join(", ")) + " px"),
        ])
    )
}

fn count_of_triangles(triangles: u64) -> String {
    let word = if triangles == 1 {
        "triangle"
    } else {
        "triangles"
    };
    format!("{} {word}", number(triangles))
}

/// The tables of all models, and what the figures mean.
fn figures(evaluation: &Evaluation) -> String {
    let meanings: String = words::ALL
        .iter()
        .filter_map(|sentence| sentence.split_once(": "))
        .map(|(name, meaning)| format!("<div><dt>{name}</dt><dd>{meaning}</dd></div>"))
        .collect();
    format!(
        "<section id=\"figures\" aria-labelledby=\"figures-title\">\n<h2 id=\"figures-title\">Figures</h2>\n\
         {}{}<h3>What the figures mean</h3>\n<dl class=\"meanings\">{meanings}</dl>\n</section>\n",
        tables::models(evaluation, false),
        tables::models(evaluation, true),
    )
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    /// Elements that have no end tag.
    const VOID: [&str; 2] = ["meta", "input"];

    /// Walks the tags; every opened one is closed, in the right order, and none else.
    fn check_tags(page: &str) -> Result<usize, String> {
        let mut open: Vec<&str> = Vec::new();
        let mut seen = 0;
        let mut rest = page;
        while let Some(start) = rest.find('<') {
            rest = &rest[start + 1..];
            let end = rest.find('>').ok_or("a tag without an end")?;
            let (tag, after) = (&rest[..end], &rest[end + 1..]);
            rest = after;
            if tag.contains('<') {
                return Err(format!("a tag within a tag: {tag}"));
            }
            if tag.matches('"').count() % 2 == 1 {
                return Err(format!("an open quote: {tag}"));
            }
            let name = tag.split([' ', '\n']).next().unwrap_or_default();
            seen += 1;
            match name.strip_prefix('/') {
                Some(closed) => match open.pop() {
                    Some(last) if last == closed => {}
                    last => return Err(format!("</{closed}> closes {last:?}")),
                },
                None if name == "!DOCTYPE" || VOID.contains(&name) => {}
                None => open.push(name),
            }
        }
        if open.is_empty() {
            Ok(seen)
        } else {
            Err(format!("never closed: {open:?}"))
        }
    }

    #[test]
    fn the_check_of_tags_finds_faults() {
        assert_eq!(check_tags("<p>a<input max=\"b\"></p>"), Ok(3));
        for fault in ["<p><b></p></b>", "<p>", "</p>", "<p a=\"b></p>", "a <"] {
            assert!(check_tags(fault).is_err(), "{fault}");
        }
    }

    #[test]
    fn every_tag_is_closed_and_every_model_is_named() {
        let evaluation = sample::evaluation();
        let page = html(&evaluation);
        assert!(check_tags(&page).unwrap() > 500);
        for (index, model) in evaluation.models.iter().enumerate() {
            assert!(page.contains(&format!("id=\"m{index}\"")));
            assert!(page.contains(&format!(">{}", model.label)));
        }
        assert!(page.contains("Olea europaea"));
        assert_eq!(page, html(&evaluation), "same input, same bytes");
    }

    #[test]
    fn a_lod_that_loses_says_to_whom_and_by_how_much() {
        let page = html(&sample::evaluation());
        assert!(page.contains(
            "<p class=\"loses\"><b>Loses to Billboard</b> of the same budget: IoU 0.570 against 0.550"
        ));
        let mut evaluation = sample::evaluation();
        evaluation.models[4].loses_to.clear();
        assert!(!html(&evaluation).contains("class=\"loses\""));
    }

    #[test]
    fn texts_of_the_user_cannot_become_markup() {
        let evil = "<script>alert('1')</script>\" onload=\"x";
        let mut evaluation = sample::evaluation();
        evaluation.name = evil.to_owned();
        evaluation.latin = evil.to_owned();
        for model in &mut evaluation.models {
            model.label = evil.to_owned();
            model.state = evil.to_owned();
            model.loses_to = vec![evil.to_owned()];
        }
        let page = html(&evaluation);
        assert!(check_tags(&page).is_ok());
        assert_eq!(page.matches("<script").count(), 1, "the page's own");
        assert!(!page.contains("\" onload"));
        assert!(page.contains("&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;"));
    }

    #[test]
    fn nothing_is_loaded_from_elsewhere() {
        let page = html(&sample::evaluation());
        assert!(!page.contains("http://") && !page.contains("https://"));
        assert!(!page.contains("@import") && !page.contains(" src="));
        let pictures = page.matches("url(").count();
        let data = "url(data:image/png;base64,";
        assert_eq!(pictures, page.matches(data).count());
        assert_eq!(pictures, 2 * (5 + 2 * 5 + 2), "every picture once");
        assert_eq!(
            page.matches("class=\"pic ").count(),
            page.matches("role=\"img\" style=\"--k").count()
                + page.matches("role=\"img\" aria-label=\"").count()
                - page.matches("class=\"dot ").count()
                - page.matches("<svg class=\"plot\"").count()
        );
    }

    #[test]
    fn the_policy_allows_the_pages_own_script_alone() {
        let page = html(&sample::evaluation());
        let (_, rest) = page.split_once("<script>").unwrap();
        let (script, _) = rest.split_once("</script>").unwrap();
        assert!(!script.contains('<') && script.len() > 200);
        let hash = STANDARD.encode(Sha256::digest(script));
        assert!(page.contains(&format!("script-src 'sha256-{hash}'\">")));
    }

    #[test]
    fn a_page_without_models_or_pictures_still_stands() {
        let mut evaluation = sample::evaluation();
        evaluation.plates.clear();
        assert!(check_tags(&html(&evaluation)).is_ok());
        for model in &mut evaluation.models {
            model.scores.clear();
        }
        assert!(html(&evaluation).contains("Nothing was measured"));
        evaluation.models.clear();
        evaluation.heights.clear();
        evaluation.reference_triangles = 0;
        let page = html(&evaluation);
        assert!(check_tags(&page).is_ok());
        assert!(page.contains("No LOD was measured"));
    }

    #[test]
    fn pictures_that_are_none_and_plates_of_no_model_do_no_harm() {
        let mut evaluation = sample::evaluation();
        evaluation.plates[0].shown[0].picture.clear();
        evaluation.plates[1].reference = b"no picture".to_vec();
        evaluation.plates[2].shown[1].model = 99;
        let page = html(&evaluation);
        assert!(check_tags(&page).is_ok());
        assert!(page.contains("no picture"));
    }

    #[test]
    fn what_is_no_number_is_shown_as_a_dash() {
        let mut evaluation = sample::evaluation();
        for model in &mut evaluation.models {
            model.layers = f32::NAN;
            model.error_m = Some(f32::INFINITY);
            model.screen_size = Some(f32::NAN);
            for scores in &mut model.scores {
                scores.all = super::super::Score {
                    iou: f32::NAN,
                    coverage: f32::INFINITY,
                    coverage_abs: f32::INFINITY,
                    flip: f32::NAN,
                    flip_by_light: [f32::NAN; 2],
                    flip_worst: f32::NAN,
                    normal_deg: f32::NEG_INFINITY,
                };
                scores.side = scores.all;
                scores.aerial = scores.all;
                scores.iou_interval = [f32::NAN; 2];
                scores.flip_interval = [f32::NAN, f32::INFINITY];
            }
            if let Some(pop) = &mut model.pop {
                pop.flip = f32::NAN;
            }
            if let Some(flicker) = &mut model.flicker {
                flicker.ratio = f32::INFINITY;
            }
        }
        let page = html(&evaluation);
        assert!(check_tags(&page).is_ok());
        assert!(page.contains("<td>-</td>"));
        let text = page.replace("data:image", "");
        for word in [
            ">NaN",
            " NaN",
            ">inf",
            "-inf",
            "\"NaN",
            "\u{2212}inf",
            "+inf",
        ] {
            assert!(!text.contains(word), "{word}");
        }
    }
}

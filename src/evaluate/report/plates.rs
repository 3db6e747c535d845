//! The report's pictures: reference, LOD and error side by side, and small trees enlarged.

use super::super::text::fixed;
use super::super::{Model, Plate};
use super::html::{Size, escape, picture, png_size};

/// Height to which small pictures are enlarged, by a whole factor, pixels.
const ENLARGED: u32 = 256;

/// All pictures of one model, by view; the largest height first. `heading` is the element of the titles.
pub(super) fn section(page: &mut String, model: &Model, plates: &[&Plate], heading: &str) {
    let mut views: Vec<&str> = Vec::new();
    for plate in plates {
        if !views.contains(&plate.view) {
            views.push(plate.view);
        }
    }
    for view in views {
        let mut shown: Vec<&Plate> = plates.iter().copied().filter(|p| p.view == view).collect();
        shown.sort_by_key(|p| std::cmp::Reverse(p.height));
        let Some((large, small)) = shown.split_first() else {
            continue;
        };
        page.push_str(&format!(
            "<{heading} class=\"view\">{}</{heading}>\n",
            escape(&seen_from(view))
        ));
        trio(page, model, large);
        if !small.is_empty() {
            // One width for all, so that the enlarged pictures stand in columns.
            let widest = small.iter().map(|p| width_of(p)).max().unwrap_or(0);
            page.push_str(&format!(
                "<div class=\"sizes\" style=\"--true:{widest}px\">\n"
            ));
            for plate in small {
                enlarged(page, model, plate);
            }
            page.push_str("</div>\n");
        }
    }
}

/// The smallest picture that still shows a shape, for the model's card.
pub(super) fn thumbnail<'a>(plates: &[&'a Plate]) -> Option<&'a Plate> {
    let large_enough = plates.iter().filter(|p| p.height >= 100);
    large_enough
        .min_by_key(|p| p.height)
        .or_else(|| plates.iter().max_by_key(|p| p.height))
        .copied()
}

fn seen_from(view: &str) -> String {
    match view {
        "side" => "From the side".to_owned(),
        "above" => "From above".to_owned(),
        other => format!("View: {other}"),
    }
}

fn alt(what: &str, plate: &Plate) -> String {
    format!(
        "{what}, {}, {} px high",
        seen_from(plate.view).to_lowercase(),
        plate.height
    )
}

fn width_of(plate: &Plate) -> u32 {
    png_size(&plate.picture).map_or(plate.height, |[width, _]| width)
}

/// Reference, model and error at full size. Pointing at the model puts the reference in its place,
/// which shows a difference better than looking to and fro.
fn trio(page: &mut String, model: &Model, plate: &Plate) {
    let width = width_of(plate);
    page.push_str(&format!(
        "<div class=\"trio\" style=\"--w:{width}px\">\n<figure class=\"ref\">"
    ));
    picture(page, &plate.reference, &alt("Full tree", plate), Size::Fit);
    page.push_str(&format!(
        "<figcaption><b>Full tree</b> at {} px</figcaption></figure>\n<figure class=\"lod\" tabindex=\"0\">",
        plate.height
    ));
    picture(page, &plate.picture, &alt(&model.label, plate), Size::Fit);
    page.push_str(&format!(
        "<figcaption><b>{}</b> <span class=\"hint\">Point here to see the full tree in its place</span>\
         </figcaption></figure>\n<figure>",
        escape(&model.label)
    ));
    let error = alt(&format!("FLIP error map of {}", model.label), plate);
    picture(page, &plate.error, &error, Size::Fit);
    page.push_str(
        "<figcaption><b>FLIP</b> The brighter, the more an eye sees the difference</figcaption></figure>\n</div>\n",
    );
}

fn enlarged(page: &mut String, model: &Model, plate: &Plate) {
    let factor = (ENLARGED / plate.height.max(1)).max(1);
    let width = width_of(plate);
    page.push_str(&format!(
        "<figure class=\"size\" style=\"--w:{}px\">\n<div class=\"pair\">",
        width.saturating_mul(factor)
    ));
    picture(
        page,
        &plate.reference,
        &alt("Full tree, enlarged", plate),
        Size::Enlarged(factor),
    );
    let enlarged = alt(&format!("{}, enlarged", model.label), plate);
    picture(page, &plate.picture, &enlarged, Size::Enlarged(factor));
    page.push_str("<div class=\"actual\">");
    picture(
        page,
        &plate.reference,
        &alt("Full tree, true size", plate),
        Size::True,
    );
    let actual = alt(&format!("{}, true size", model.label), plate);
    picture(page, &plate.picture, &actual, Size::True);
    page.push_str(&format!(
        "</div></div>\n<figcaption><b>{} px</b> Full tree, {}, and both at true size{}</figcaption>\n</figure>\n",
        plate.height,
        escape(&model.label),
        figures(model, plate)
    ));
}

/// IoU and FLIP of the pictures' height and kind of view.
fn figures(model: &Model, plate: &Plate) -> String {
    let scores = model.scores.iter().find(|s| s.height == plate.height);
    scores.map_or_else(String::new, |s| {
        let (score, views) = if plate.view == "side" {
            (&s.side, "side views")
        } else {
            (&s.aerial, "aerial views")
        };
        format!(
            "<span class=\"hint\">Mean of the {views}: IoU {}, FLIP {}</span>",
            fixed(score.iou, 2),
            fixed(score.flip, 2)
        )
    })
}

//! The report's pictures: reference, LOD and error side by side, and small trees enlarged.
//!
//! Every picture is in the page once, as the background of a class; whatever shows it bears the class.

use super::super::text::fixed;
use super::super::{Evaluation, Model, Plate, Shown};
use super::html::{Size, escape, picture, png_rule, png_size};

/// Height to which small pictures are enlarged, by a whole factor, pixels.
const ENLARGED: u32 = 256;

/// One model's pictures from one view at one height.
#[derive(Clone, Copy)]
pub(super) struct Pair<'a> {
    /// Index of the plate.
    at: usize,
    plate: &'a Plate,
    shown: &'a Shown,
}

/// All pictures of one model.
pub(super) fn of_model(evaluation: &Evaluation, model: usize) -> Vec<Pair<'_>> {
    let plates = evaluation.plates.iter().enumerate();
    plates
        .filter_map(|(at, plate)| {
            let shown = plate.shown.iter().find(|s| s.model == model)?;
            Some(Pair { at, plate, shown })
        })
        .collect()
}

/// The style that holds the pictures.
pub(super) fn style(evaluation: &Evaluation) -> String {
    let mut rules = String::new();
    for (at, plate) in evaluation.plates.iter().enumerate() {
        png_rule(&mut rules, &format!("p{at}"), &plate.reference);
        for shown in &plate.shown {
            png_rule(
                &mut rules,
                &format!("p{at}m{}", shown.model),
                &shown.picture,
            );
            png_rule(&mut rules, &format!("p{at}e{}", shown.model), &shown.error);
        }
    }
    rules
}

/// All pictures of one model, by view; the largest height first. `heading` is the element of the titles,
/// `judged` the height at which the model is judged.
pub(super) fn section(
    page: &mut String,
    model: &Model,
    pairs: &[Pair<'_>],
    heading: &str,
    judged: Option<u32>,
) {
    let mut views: Vec<&str> = Vec::new();
    for pair in pairs {
        if !views.contains(&pair.plate.view) {
            views.push(pair.plate.view);
        }
    }
    for view in views {
        let of_view = pairs.iter().filter(|p| p.plate.view == view);
        let mut shown: Vec<&Pair<'_>> = of_view.collect();
        shown.sort_by_key(|p| std::cmp::Reverse(p.plate.height));
        let Some((large, small)) = shown.split_first() else {
            continue;
        };
        page.push_str(&format!(
            "<{heading} class=\"view\">{}</{heading}>\n",
            escape(&seen_from(view))
        ));
        large.trio(page, model);
        if !small.is_empty() {
            // One width for all, so that the enlarged pictures stand in columns.
            let widest = small.iter().map(|p| p.width()).max().unwrap_or(0);
            page.push_str(&format!(
                "<div class=\"sizes\" style=\"--true:{widest}px\">\n"
            ));
            for pair in small {
                pair.enlarged(page, model, judged == Some(pair.plate.height));
            }
            page.push_str("</div>\n");
        }
    }
}

/// The smallest picture that still shows a shape, for the model's card.
pub(super) fn thumbnail<'p, 'a>(pairs: &'p [Pair<'a>]) -> Option<&'p Pair<'a>> {
    let large_enough = pairs.iter().filter(|p| p.plate.height >= 100);
    large_enough
        .min_by_key(|p| p.plate.height)
        .or_else(|| pairs.iter().max_by_key(|p| p.plate.height))
}

fn seen_from(view: &str) -> String {
    match view {
        "side" => "From the side".to_owned(),
        "above" => "From above".to_owned(),
        other => format!("View: {other}"),
    }
}

impl Pair<'_> {
    fn alt(&self, what: &str) -> String {
        format!(
            "{what}, {}, {} px high",
            seen_from(self.plate.view).to_lowercase(),
            self.plate.height
        )
    }

    fn width(&self) -> u32 {
        png_size(&self.shown.picture).map_or(self.plate.height, |[width, _]| width)
    }

    pub(super) fn reference(&self, page: &mut String, what: &str, size: Size) {
        let class = format!("p{}", self.at);
        picture(page, &class, &self.plate.reference, &self.alt(what), size);
    }

    pub(super) fn model(&self, page: &mut String, what: &str, size: Size) {
        let class = format!("p{}m{}", self.at, self.shown.model);
        picture(page, &class, &self.shown.picture, &self.alt(what), size);
    }

    /// The model with the full tree over it, of which the page shows a part or shows it in turn.
    fn stage(&self, page: &mut String, what: &str, size: Size, open: u32) {
        page.push_str(&format!("<div class=\"stage\" style=\"--at:{open}%\">"));
        self.model(page, what, size);
        page.push_str("<div class=\"over\">");
        self.reference(page, "Full tree in its place", size);
        page.push_str("</div></div>");
    }

    /// Reference, model and error at full size. The model's picture can be wiped and blinked, which shows a
    /// difference better than looking to and fro.
    fn trio(&self, page: &mut String, model: &Model) {
        page.push_str(&format!(
            "<div class=\"trio\" style=\"--w:{}px\">\n<figure>",
            self.width()
        ));
        self.reference(page, "Full tree", Size::Fit);
        page.push_str(&format!(
            "<figcaption><b>Full tree</b> {} px high</figcaption></figure>\n<figure class=\"large\">",
            self.plate.height
        ));
        self.stage(page, &model.label, Size::Fit, 50);
        page.push_str(&format!(
            "<figcaption><b>{}</b> <span class=\"hint\">Left of the line the full tree, right of it the LOD</span>\
             <label class=\"wipe\">LOD <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" \
             aria-label=\"Part of the picture that shows the full tree\"> Full tree</label></figcaption></figure>\n<figure>",
            escape(&model.label)
        ));
        let class = format!("p{}e{}", self.at, self.shown.model);
        let error = self.alt(&format!("FLIP error map of {}", model.label));
        picture(page, &class, &self.shown.error, &error, Size::Fit);
        page.push_str(
            "<figcaption><b>FLIP</b> How much an eye sees the difference\
             <span class=\"ramp\"><span>0 none</span><i></i><span>1 most</span></span></figcaption></figure>\n</div>\n",
        );
    }

    fn enlarged(&self, page: &mut String, model: &Model, is_judged: bool) {
        let factor = (ENLARGED / self.plate.height.max(1)).max(1);
        page.push_str(&format!(
            "<figure class=\"size{}\" style=\"--w:{}px\">\n<div class=\"pair\">",
            if is_judged { " judged" } else { "" },
            self.width().saturating_mul(factor)
        ));
        self.reference(page, "Full tree, enlarged", Size::Enlarged(factor));
        let label = &model.label;
        self.stage(
            page,
            &format!("{label}, enlarged"),
            Size::Enlarged(factor),
            0,
        );
        page.push_str("<div class=\"actual\">");
        self.reference(page, "Full tree, true size", Size::True);
        self.model(page, &format!("{label}, true size"), Size::True);
        page.push_str(&format!(
            "</div></div>\n<figcaption><b>{} px</b> Full tree, {}, and both at true size{}{}</figcaption>\n</figure>\n",
            self.plate.height,
            escape(label),
            if is_judged {
                " <span class=\"badge\">the size at which it is judged</span>"
            } else {
                ""
            },
            self.figures(model)
        ));
    }

    /// IoU and FLIP of the pictures' height and kind of view.
    fn figures(&self, model: &Model) -> String {
        let scores = model.scores.iter().find(|s| s.height == self.plate.height);
        scores.map_or_else(String::new, |s| {
            let (score, views) = if self.plate.view == "side" {
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
}

#[cfg(test)]
mod tests {
    use crate::image::Image;
    use crate::measure::flip::magma;

    #[test]
    fn the_legend_has_the_colours_of_the_error_map() {
        let style = include_str!("style.css");
        let ramp = style.lines().find(|l| l.contains(".ramp i")).unwrap();
        for step in 0..=5_u8 {
            let at = Image::filled(1, 1, f32::from(step) / 5.0);
            let [r, g, b] = *magma(&at).at(0, 0);
            let colour = format!("#{r:02x}{g:02x}{b:02x}");
            assert!(ramp.contains(&colour), "{colour} at {step}/5 in {ramp}");
        }
    }
}

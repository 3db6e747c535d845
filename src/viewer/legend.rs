//! Which colour is which level's, where levels have colours.

use super::subject::Subject;
use crate::render::level_colour;
use crate::tree::{Kind, Tree};
use eframe::egui::{Color32, Response, Sense, Ui, vec2};

/// Edge of a swatch, points.
const EDGE: f32 = 9.0;

/// The names of a tree's levels, each at the place of its colour.
fn names(tree: &Tree) -> impl Iterator<Item = &str> {
    let levels = tree.levels.iter().filter(|l| l.kind != Kind::Stool);
    levels.map(|level| level.name.as_str())
}

/// The place of the colour that a level of a tree has.
#[must_use]
pub fn place(tree: &Tree, name: &str) -> Option<usize> {
    names(tree).position(|level| level == name)
}

/// A square in the colour at a place.
pub fn swatch(ui: &mut Ui, place: usize) -> Response {
    let [red, green, blue] = level_colour(place);
    let (rect, response) = ui.allocate_exact_size(vec2(EDGE, EDGE), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, Color32::from_rgb(red, green, blue));
    response
}

/// The colours with the names of their levels.
pub fn ui(ui: &mut Ui, subject: Option<&Subject>) {
    let Some(asset) = subject.and_then(Subject::asset) else {
        ui.weak("A pack does not tell which level a triangle is of: all are grey.");
        return;
    };
    ui.horizontal_wrapped(|ui| {
        for (place, name) in names(&asset.tree).enumerate() {
            ui.horizontal(|ui| {
                swatch(ui, place);
                ui.label(name);
            });
        }
    });
}

//! The panes that show what a tree is drawn with: the foliage atlas with its captures named, and the nine shadows.

use crate::asset::TreeAsset;
use crate::capture::{Plan, Subject, VIEWS};
use crate::image::Image;
use crate::preview::sheets;
use crate::shadow;
use crate::viewer::settings::Sun;
use eframe::egui::{self, Color32, ColorImage, Rect, Sense, Stroke, TextureHandle, Ui, pos2, vec2};

/// Pictures on the window's device, and the tree that they are of.
#[derive(Default)]
pub(super) struct Pictures {
    atlas: Option<Picture>,
    rose: Option<Picture>,
}

struct Picture {
    /// Number of its tree.
    of: u64,
    texture: TextureHandle,
}

impl Picture {
    /// The picture of a tree, made anew if the one at hand is of another.
    fn of<'p>(
        at_hand: &'p mut Option<Self>,
        ui: &Ui,
        (name, of): (&str, u64),
        draw: impl FnOnce() -> Image<[u8; 4]>,
    ) -> &'p TextureHandle {
        if at_hand.as_ref().is_none_or(|picture| picture.of != of) {
            let image = draw();
            let size = [image.width(), image.height()].map(|edge| edge as usize);
            let bytes = bytemuck::cast_slice(image.texels());
            let image = ColorImage::from_rgba_unmultiplied(size, bytes);
            let texture = ui
                .ctx()
                .load_texture(name, image, egui::TextureOptions::LINEAR);
            *at_hand = Some(Self { of, texture });
        }
        match at_hand {
            Some(picture) => &picture.texture,
            None => unreachable!("it was made above"),
        }
    }
}

impl Pictures {
    /// The atlas, each part outlined and named where the mouse rests.
    pub(super) fn atlas(&mut self, ui: &mut Ui, (number, tree): (u64, &TreeAsset)) {
        let texture = Picture::of(&mut self.atlas, ui, ("atlas", number), || {
            sheets::on_white(&tree.foliage)
        });
        let (place, response) = shown(ui, texture, "Foliage atlas");
        let edge = texture.size_vec2().x.max(1.0);
        let scale = place.width() / edge;
        let names = names(tree);
        let mut told = None;
        for (part, name) in tree.rects.iter().zip(&names) {
            let [x, y, width, height] =
                [part.x, part.y, part.width, part.height].map(crate::math::float);
            let corner = place.min + vec2(x, y) * scale;
            let outline = Rect::from_min_size(corner, vec2(width, height) * scale);
            let under = response.hover_pos().is_some_and(|at| outline.contains(at));
            let colour = if under {
                Color32::from_rgb(230, 120, 40)
            } else {
                Color32::from_gray(150)
            };
            let stroke = Stroke::new(if under { 2.0 } else { 0.7 }, colour);
            ui.painter()
                .rect_stroke(outline, 0.0, stroke, egui::StrokeKind::Inside);
            if under {
                told = Some(format!("{name}, {} x {} texels", part.width, part.height));
            }
        }
        ui.label(told.unwrap_or_else(|| {
            let parts = tree.rects.len();
            format!("{parts} parts on {edge} x {edge} texels; point at one for its name")
        }));
    }

    /// The nine shadows as a compass has them, with their shares under the sun as it stands.
    pub(super) fn shadows(&mut self, ui: &mut Ui, (number, tree): (u64, &TreeAsset), sun: Sun) {
        if tree.shadows.maps.is_empty() {
            ui.weak("no shadows yet");
            return;
        }
        let texture = Picture::of(&mut self.rose, ui, ("shadows", number), || {
            sheets::rose(&tree.shadows)
        });
        let (place, _) = shown(ui, texture, "Nine shadows");
        for (index, share) in shadow::weights(sun.toward()) {
            let Some(map) = tree.shadows.maps.get(index).filter(|_| share > 0.0) else {
                continue;
            };
            let cell = |x: f32| {
                if x > 0.1 {
                    2.0
                } else if x > -0.1 {
                    1.0
                } else {
                    0.0
                }
            };
            let third = place.width() / 3.0;
            let corner = place.min + vec2(cell(map.direction.x), cell(map.direction.z)) * third;
            let outline = Rect::from_min_size(corner, vec2(third, third)).shrink(1.5);
            let stroke = Stroke::new(1.0 + 3.0 * share, Color32::from_rgb(230, 120, 40));
            let painter = ui.painter();
            painter.rect_stroke(outline, 0.0, stroke, egui::StrokeKind::Inside);
            let font = egui::FontId::proportional(12.0);
            let words = format!("{:.0} %", share * 100.0);
            let at = outline.left_top() + vec2(5.0, 4.0);
            painter.text(
                at,
                egui::Align2::LEFT_TOP,
                words,
                font,
                Color32::from_gray(30),
            );
        }
        ui.label("Outlined: what the sun as it stands is blended from. North is up.");
    }
}

/// A picture as wide as there is room.
fn shown(ui: &mut Ui, texture: &TextureHandle, name: &str) -> (Rect, egui::Response) {
    let room = ui.available_size() - vec2(0.0, 24.0);
    let edge = room.min_elem().max(40.0);
    let (place, response) = ui.allocate_exact_size(vec2(edge, edge), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter()
        .image(texture.id(), place, whole, Color32::WHITE);
    (place, response)
}

/// What each part of an atlas shows, in words.
fn names(tree: &TreeAsset) -> Vec<String> {
    let level = |level: usize| tree.tree.levels.get(level).map_or("", |l| &*l.name);
    let plan = Plan::of(&tree.tree);
    let mut names = Vec::new();
    for subject in plan.subjects.iter().take(tree.captures / VIEWS) {
        let name = match subject {
            Subject::Combined { level: of, .. } => {
                format!("{} with all that grows on it", level(*of))
            }
            Subject::Branch { level: of, .. } => format!("{} alone", level(*of)),
        };
        names.extend((1..=VIEWS).map(|side| format!("{name}, side {side}")));
    }
    let leaves = tree
        .rects
        .len()
        .saturating_sub(names.len() + tree.plane_captures);
    names.extend((1..=leaves).map(|kind| format!("leaf kind {kind}")));
    names.extend((1..=tree.plane_captures).map(|plane| format!("plane {plane}")));
    names
}

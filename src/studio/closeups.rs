//! The leaf or the bark of a page from near: what its fields make, as they are changed.

use crate::asset::TreeAsset;
use crate::preview::closeups::{self, Channel, Paint};
use crate::species::schema::Species;
use eframe::egui::{self, Color32, ColorImage, Rect, Sense, TextureHandle, Ui, pos2, vec2};

/// What a close-up is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Near {
    /// A leaf kind by number.
    Leaf(usize),
    Bark,
}

/// Edge of a close-up, pixels.
const EDGE: u32 = 240;

/// The close-up that was shown last.
#[derive(Default)]
pub(super) struct Closeups {
    channel: Channel,
    shown: Option<((u64, Near, Channel), Option<TextureHandle>)>,
}

impl Closeups {
    /// Shows a close-up of a tree, whose number tells it from others.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        near: Near,
        (number, tree): (u64, &TreeAsset),
        species: &Species,
    ) {
        let channels = match near {
            Near::Leaf(_) => Channel::OF_LEAVES,
            Near::Bark => Channel::OF_BARK,
        };
        if !channels.iter().any(|(channel, _)| *channel == self.channel) {
            self.channel = Channel::Lit;
        }
        ui.horizontal_top(|ui| {
            let (texture, words) = (
                self.texture(ui, near, (number, tree), species),
                caption(near, species),
            );
            let edge = (ui.available_width() - 90.0).clamp(90.0, 200.0);
            let (place, response) = ui.allocate_exact_size(vec2(edge, edge), Sense::hover());
            response
                .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "From near"));
            if let Some(texture) = texture {
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter()
                    .image(texture.id(), place, whole, Color32::WHITE);
            }
            ui.vertical(|ui| {
                for (channel, name) in channels {
                    ui.radio_value(&mut self.channel, *channel, *name);
                }
                ui.add_space(4.0);
                ui.weak(words);
            });
        });
        ui.separator();
    }

    fn texture(
        &mut self,
        ui: &Ui,
        near: Near,
        (number, tree): (u64, &TreeAsset),
        species: &Species,
    ) -> Option<TextureHandle> {
        let key = (number, near, self.channel);
        if self.shown.as_ref().is_none_or(|(shown, _)| *shown != key) {
            let size = [EDGE, EDGE];
            let paint = match near {
                Near::Leaf(kind) => species.leaves.get(kind).and_then(|leaf| {
                    let card = [leaf.width_m, leaf.length_m];
                    closeups::leaf(tree, (kind, card), size, self.channel)
                }),
                Near::Bark => Some(closeups::bark(tree, size, self.channel)),
            };
            let texture = paint.map(|paint| {
                let image = image(&paint);
                ui.ctx()
                    .load_texture("from near", image, egui::TextureOptions::LINEAR)
            });
            self.shown = Some((key, texture));
        }
        self.shown.as_ref()?.1.clone()
    }
}

/// A picture as the window's device takes it.
pub(super) fn image(paint: &Paint) -> ColorImage {
    let size = [paint.width(), paint.height()].map(|edge| edge as usize);
    ColorImage::from_rgb(size, bytemuck::cast_slice(paint.texels()))
}

/// How large it is.
fn caption(near: Near, species: &Species) -> String {
    match near {
        Near::Leaf(kind) => species.leaves.get(kind).map_or_else(String::new, |leaf| {
            format!(
                "a card of {} by {}",
                metres(leaf.width_m),
                metres(leaf.length_m)
            )
        }),
        Near::Bark => format!("{} high", metres(species.bark.height_m())),
    }
}

/// A length in the unit that it is spoken of in.
pub(super) fn metres(length: f32) -> String {
    if length < 0.995 {
        format!("{:.1} cm", length * 100.0)
    } else {
        format!("{length:.2} m")
    }
}

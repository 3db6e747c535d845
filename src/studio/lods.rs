//! The pane of LODs: a picture of each, its budget, what was made of it, and what it costs the eye.

use super::app::Order;
use super::budgets::Budgets;
use super::judging::Protocol;
use super::lod_table::{Table, reach};
use super::panes::{Panes, named};
use super::priorities;
use crate::asset::TreeAsset;
use crate::viewer::level::Choice;
use crate::viewer::loader::Stage;
use crate::viewer::split;
use eframe::egui::{
    self, Color32, Rect, Response, Role, ScrollArea, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

impl Panes<'_> {
    pub(super) fn lods(&mut self, ui: &mut Ui) {
        let Some(grown) = self.grown else {
            ui.weak("no tree yet");
            return;
        };
        let (subject, number) = (&grown.subject, self.number);
        let Some(asset) = subject.asset() else {
            return;
        };
        let is_current = grown.text == self.document.text();
        self.judging.attend(ui, (number, grown), is_current);
        let mut changes = Vec::new();
        ScrollArea::vertical().show(ui, |ui| {
            ui.set_width(ui.available_width());
            self.strip(ui, (asset, is_current));
            self.controls(ui);
            ui.add_space(2.0);
            let reading = self.document.reading();
            let lod = reading.species.as_ref().ok().map(|species| &species.lod);
            let written = reading.root.as_ref().zip(lod);
            let table = Table {
                subject,
                asset,
                budgets: written.map(|(root, lod)| Budgets {
                    root,
                    budgets: &lod.budgets,
                }),
                strip: Some(&self.judging.strip).filter(|_| self.judging.has_pictures_of(number)),
                figures: self.judging.figures(),
                is_current,
                are_figures_current: is_current && self.judging.has_figures_of(number),
                reach: reach(self.view.rig.camera().lens),
            };
            let choice = &mut self.settings.choice;
            sideways(ui, "table", |ui| table.ui(ui, choice, &mut changes));
            table.finer(ui, &mut changes);
            self.measuring(ui, is_current);
            if let Some((root, lod)) = written {
                ui.add_space(4.0);
                priorities::ui(ui, root, lod, &mut changes);
            }
            for warning in &subject.warnings {
                ui.small(format!("warning: {warning}"));
            }
        });
        self.orders.extend(changes.into_iter().map(Order::Change));
    }

    /// A picture of each LOD; a press shows it.
    fn strip(&mut self, ui: &mut Ui, (asset, is_current): (&TreeAsset, bool)) {
        let strip = &self.judging.strip;
        let is_current = is_current && self.judging.has_pictures_of(self.number);
        let choice = &mut self.settings.choice;
        sideways(ui, "pictures", |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for lod in 0..asset.lods.len() {
                let texture = strip.textures.get(lod);
                let size = texture.map_or(vec2(72.0, 96.0), egui::TextureHandle::size_vec2);
                let response = ui.allocate_response(size, Sense::click());
                let is_chosen = *choice == Choice::Fixed(lod);
                let name = format!("Show LOD {lod}");
                let look = Look {
                    name: format!("LOD{lod}"),
                    is_chosen,
                    is_current,
                };
                response.widget_info(|| {
                    WidgetInfo::selected(Role::Button, true, is_chosen, name.clone())
                });
                framed_picture(ui, texture, &response, look);
                if response.clicked() {
                    toggle(choice, lod);
                }
            }
        });
    }

    /// What is shown of the LODs in the view.
    fn controls(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let by_distance = self.settings.choice == Choice::ByDistance;
            let label = ui.selectable_label(by_distance, "by distance");
            let label = label.on_hover_text("Show in the view the LOD that its distance asks for");
            if label.clicked() {
                self.settings.choice = Choice::ByDistance;
            }
            split::toggle(ui, self.settings);
        });
    }

    /// What was measured, how far measuring is, and a button for all of it.
    fn measuring(&mut self, ui: &mut Ui, is_current: bool) {
        let Some(grown) = self.grown else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            if let Some((protocol, stage)) = self.judging.measuring() {
                let told = match (stage.name, stage.steps) {
                    ("", _) => "beginning".to_owned(),
                    (name, 0) => name.to_owned(),
                    (name, steps) => format!("{name}, {} of {steps}", stage.done.min(steps)),
                };
                let bar = egui::ProgressBar::new(part_of(&stage));
                ui.add(bar.desired_width(60.0).desired_height(8.0))
                    .on_hover_text(&told);
                ui.label(format!("{} ...", protocol.words()))
                    .on_hover_text(told);
                if protocol == Protocol::Full && named(ui, "stop", "Stop measuring", true) {
                    self.judging.stop_measuring();
                }
                ui.ctx().request_repaint_after(super::panes::BUSY);
                return;
            }
            if let Some(fault) = self.judging.fault() {
                ui.colored_label(ui.visuals().warn_fg_color, fault);
                return;
            }
            let has = self.judging.has_figures_of(self.number) && is_current;
            match self.judging.figures().filter(|_| has) {
                Some(figures) => {
                    ui.label(figures.protocol.words());
                }
                None if is_current => {
                    ui.weak("measured in a moment");
                }
                None => {
                    ui.weak("measured once the tree has come to rest");
                }
            }
            let is_full = self.judging.figures().is_some_and(|f| f.protocol == Protocol::Full);
            let what = format!(
                "Measure as `pleach evaluate` does, {}, and how the LODs change into each other. Takes minutes for a \
                 large tree; the next edit stops it.",
                Protocol::Full.words()
            );
            let button = egui::Button::new("measure in full").small();
            let button = ui.add_enabled(is_current && !(has && is_full), button);
            if button.on_hover_text(what).clicked() {
                self.judging.measure((self.number, grown), Protocol::Full);
            }
        });
    }
}

/// How far a stage is, 0 to 1.
fn part_of(stage: &Stage) -> f32 {
    #[expect(clippy::cast_precision_loss, reason = "a bar of some points")]
    let [done, steps] = [stage.done, stage.steps].map(|count| count as f32);
    (done / steps.max(1.0)).min(1.0)
}

/// Something in a row, which is scrolled where there is no room for it.
fn sideways(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ScrollArea::horizontal()
        .id_salt(name)
        .auto_shrink([true, true])
        .show(ui, |ui| ui.horizontal(content));
}

/// Shows a LOD from any distance, or LODs by distance again.
pub(super) fn toggle(choice: &mut Choice, lod: usize) {
    *choice = if *choice == Choice::Fixed(lod) {
        Choice::ByDistance
    } else {
        Choice::Fixed(lod)
    };
}

/// How a small picture is shown.
struct Look {
    name: String,
    is_chosen: bool,
    is_current: bool,
}

fn framed_picture(ui: &Ui, texture: Option<&egui::TextureHandle>, place: &Response, look: Look) {
    let (painter, rect) = (ui.painter(), place.rect);
    match texture {
        Some(texture) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let tint = if look.is_current {
                Color32::WHITE
            } else {
                Color32::from_gray(150)
            };
            painter.image(texture.id(), rect, whole, tint);
        }
        None => {
            painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
        }
    }
    let foot = Rect::from_min_max(pos2(rect.left(), rect.bottom() - 14.0), rect.max);
    painter.rect_filled(foot, 0.0, Color32::from_black_alpha(130));
    let font = egui::FontId::proportional(10.0);
    let middle = egui::Align2::CENTER_CENTER;
    painter.text(foot.center(), middle, look.name, font, Color32::WHITE);
    let stroke = if look.is_chosen {
        Stroke::new(2.0, ui.visuals().selection.bg_fill)
    } else if place.has_focus() || place.hovered() {
        Stroke::new(1.5, ui.visuals().widgets.hovered.fg_stroke.color)
    } else {
        ui.visuals().widgets.noninteractive.bg_stroke
    };
    painter.rect_stroke(rect, 2.0, stroke, egui::StrokeKind::Inside);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_press_goes_back_to_lods_by_distance() {
        let mut choice = Choice::ByDistance;
        for expected in [Choice::Fixed(2), Choice::ByDistance, Choice::Fixed(2)] {
            toggle(&mut choice, 2);
            assert_eq!(choice, expected);
        }
        toggle(&mut choice, 1);
        assert_eq!(choice, Choice::Fixed(1));
    }
}

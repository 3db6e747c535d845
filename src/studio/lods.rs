//! The pane of LODs: a picture of each, its budget, what was made of it, and what it costs the eye.

use super::app::Order;
use super::budgets::{self, Budgets, Line};
use super::document::Edit;
use super::form::Change;
use super::judging::{Figures, Protocol, Strip};
use super::panes::{Panes, named};
use super::priorities;
use crate::asset::TreeAsset;
use crate::evaluate::{self, Judgement, MAX_COVERAGE_ERROR, MIN_IOU, Model, Scores};
use crate::render::Lens;
use crate::viewer::level::Choice;
use crate::viewer::{Subject, split};
use eframe::egui::{
    self, Color32, DragValue, Grid, Rect, Response, RichText, Role, ScrollArea, Sense, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};

/// Words that tell which part of a table a number stands in.
const HEADINGS: [(&str, &str); 9] = [
    (
        "LOD",
        "Press one to see it from any distance, and again for LODs by distance.",
    ),
    (
        "budget",
        "Triangles that the LOD may have, as the script says. Drag it or type into it: budgets fall from LOD to LOD.",
    ),
    ("triangles", "Triangles that it has."),
    ("atlas", "Part of the foliage atlas that it shows."),
    (
        "from",
        "The distance from which on it is shown: where it errs by no more than a pixel or two is decided by its size in \
         the picture, so the distance goes by the lens of this view.",
    ),
    (
        "IoU",
        "Silhouette: what it and the full tree both cover, by what either covers. 1 is the same; a good LOD has 0.8 or \
         more.",
    ),
    (
        "area",
        "Covered area against the full tree's: below 0 it thins out, above 0 it fills up. A good LOD is off by less than \
         5 % from any side.",
    ),
    (
        "FLIP",
        "How much an eye sees that it is another picture than the full tree's: 0 is the same, 1 is black for white.",
    ),
    (
        "pop",
        "FLIP at the moment when it takes the place of the finer LOD. Measured in full only.",
    ),
];

/// What of the pane hangs on the last whole tree.
struct Table<'a> {
    subject: &'a Subject,
    asset: &'a TreeAsset,
    /// The text's budgets; none while it is at fault.
    budgets: Option<Budgets<'a>>,
    strip: Option<&'a Strip>,
    figures: Option<&'a Figures>,
    /// True if the tree is the one that the text says, and the figures are those of the tree.
    is_current: bool,
    are_figures_current: bool,
    /// Metres of distance for each metre of the picture's height.
    reach: Option<f32>,
}

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
        ScrollArea::both().show(ui, |ui| {
            self.strip(ui, asset);
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
            table.ui(ui, &mut self.settings.choice, &mut changes);
            self.measuring(ui, is_current);
            if let Some(written) = written {
                ui.add_space(4.0);
                priorities::ui(ui, written, &mut changes);
            }
            for warning in &subject.warnings {
                ui.small(format!("warning: {warning}"));
            }
        });
        self.orders.extend(changes.into_iter().map(Order::Change));
    }

    /// A picture of each LOD; a press shows it.
    fn strip(&mut self, ui: &mut Ui, asset: &TreeAsset) {
        let strip = &self.judging.strip;
        let is_current = self.judging.has_pictures_of(self.number);
        let choice = &mut self.settings.choice;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for lod in 0..asset.lods.len() {
                let texture = strip.textures.get(lod);
                let size = texture.map_or(vec2(72.0, 96.0), egui::TextureHandle::size_vec2);
                let (rect, response) = ui.allocate_exact_size(size, Sense::click());
                let is_chosen = *choice == Choice::Fixed(lod);
                let name = format!("Show LOD {lod}");
                response.widget_info(|| {
                    WidgetInfo::selected(Role::Button, true, is_chosen, name.clone())
                });
                framed_picture(ui, rect, texture, (&response, is_chosen, is_current));
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
                ui.add(egui::Spinner::new().size(12.0));
                let words = match (stage.name, stage.steps) {
                    ("", _) => "beginning".to_owned(),
                    (name, 0) => name.to_owned(),
                    (name, steps) => format!("{name}, {} of {steps}", stage.done.min(steps)),
                };
                ui.label(format!("{}; {words}", protocol.words()));
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

/// Shows a LOD from any distance, or LODs by distance again.
fn toggle(choice: &mut Choice, lod: usize) {
    *choice = if *choice == Choice::Fixed(lod) {
        Choice::ByDistance
    } else {
        Choice::Fixed(lod)
    };
}

fn framed_picture(
    ui: &Ui,
    rect: Rect,
    texture: Option<&egui::TextureHandle>,
    (response, is_chosen, is_current): (&Response, bool, bool),
) {
    let painter = ui.painter();
    match texture {
        Some(texture) => {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let tint = if is_current {
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
    let stroke = if is_chosen {
        Stroke::new(2.0, ui.visuals().selection.bg_fill)
    } else if response.has_focus() || response.hovered() {
        Stroke::new(1.5, ui.visuals().widgets.hovered.fg_stroke.color)
    } else {
        ui.visuals().widgets.noninteractive.bg_stroke
    };
    painter.rect_stroke(rect, 2.0, stroke, egui::StrokeKind::Inside);
}

/// Metres of distance for each metre of the picture's height; none without perspective.
fn reach(lens: Lens) -> Option<f32> {
    match lens {
        Lens::Perspective(angle) => Some(0.5 / libm::tanf(angle * 0.5)),
        Lens::Orthographic(_) => None,
    }
}

/// The distance at which a tree of a height fills a part of the picture's height, metres.
fn distance(height: f32, part: f32, reach: f32) -> f32 {
    height / part.max(1e-4) * reach
}

impl Table<'_> {
    fn ui(&self, ui: &mut Ui, choice: &mut Choice, changes: &mut Vec<Change>) {
        let written = self.budgets.as_ref().map(|b| b.budgets);
        let asked = &self.asset.asked.budgets;
        let made_of: Vec<Option<u64>> = self.subject.lods.iter().map(|lod| lod.budget).collect();
        let lines = budgets::lines(written.unwrap_or(asked), asked, &made_of);
        let is_full = self.figures.is_some_and(|f| f.protocol == Protocol::Full);
        let columns = if is_full { 9 } else { 8 };
        Grid::new("lods")
            .striped(true)
            .spacing(vec2(7.0, 3.0))
            .min_col_width(0.0)
            .show(ui, |ui| {
                for (name, meaning) in HEADINGS.iter().take(columns) {
                    ui.label(RichText::new(*name).small().weak())
                        .on_hover_text(*meaning);
                }
                ui.end_row();
                for line in &lines {
                    self.line(ui, *line, (choice, is_full), changes);
                    ui.end_row();
                }
            });
        if let Some(written) = &self.budgets {
            let new = budgets::between(written.budgets, 0);
            if named(ui, "+ finer", "Add a finer budget", new.is_some())
                && let Some(new) = new
            {
                let name = "Add a finer budget".to_owned();
                changes.push(Change::Edit(name, None, written.add(0, new)));
            }
        }
    }

    fn line(
        &self,
        ui: &mut Ui,
        line: Line,
        (choice, is_full): (&mut Choice, bool),
        changes: &mut Vec<Change>,
    ) {
        match line.lod {
            Some(lod) => self.name(ui, lod, choice),
            None => {
                ui.weak("none").on_hover_text(
                    "This budget got no LOD of its own; the warnings below say why.",
                );
            }
        }
        self.budget(ui, line, changes);
        match line.lod {
            Some(lod) => {
                self.facts(ui, lod);
                self.figures(ui, lod, is_full);
            }
            None => {
                for _ in 0..if is_full { 7 } else { 6 } {
                    ui.weak("-");
                }
            }
        }
        self.buttons(ui, line, changes);
    }

    fn name(&self, ui: &mut Ui, lod: usize, choice: &mut Choice) {
        let chosen = *choice == Choice::Fixed(lod);
        let label = ui.selectable_label(chosen, format!("LOD{lod}"));
        let state = &self.asset.lods[lod].state;
        if label.on_hover_text(state).clicked() {
            toggle(choice, lod);
        }
    }

    fn budget(&self, ui: &mut Ui, line: Line, changes: &mut Vec<Change>) {
        let (Some(index), Some(written)) = (line.budget, &self.budgets) else {
            let of = line.lod.and_then(|lod| self.subject.lods[lod].budget);
            ui.weak(of.map_or_else(|| "full".to_owned(), |budget| budget.to_string()));
            return;
        };
        let mut budget = written.budgets[index];
        #[expect(clippy::cast_precision_loss, reason = "the speed of a drag")]
        let speed = (budget as f64 * 0.01).max(0.2);
        let field = DragValue::new(&mut budget)
            .range(budgets::range(written.budgets, index))
            .speed(speed);
        let response = ui.add(field);
        ui.ctx().accesskit_node_builder(response.id, |node| {
            node.set_label(format!("Budget {}", index + 1));
        });
        if response.changed() {
            let gesture = Some(format!("lod.budgets.{index}"));
            let name = format!("Set budget {}", index + 1);
            changes.push(Change::Edit(name, gesture, written.set(index, budget)));
        }
        if response.drag_stopped() || response.lost_focus() {
            changes.push(Change::Rest);
        }
    }

    /// What is known of a LOD without measuring it.
    fn facts(&self, ui: &mut Ui, lod: usize) {
        let text = |text: String, is_current: bool| {
            let text = RichText::new(text);
            if is_current { text } else { text.weak() }
        };
        let facts = &self.subject.lods[lod];
        ui.label(text(facts.triangles.to_string(), self.is_current));
        let part = self.strip.and_then(|strip| strip.atlas.get(lod));
        let part = part.map_or_else(|| "-".to_owned(), |part| format!("{:.0} %", part * 100.0));
        ui.label(text(part, self.is_current));
        let height = self.subject.bounds.size().y;
        let from = match self.reach {
            Some(_) if lod == 0 => "near".to_owned(),
            Some(reach) => format!("{:.0} m", distance(height, facts.screen_size, reach)),
            None => "-".to_owned(),
        };
        ui.label(text(from, self.is_current)).on_hover_text(format!(
            "Shown where the tree fills at most {:.0} % of the picture's height. Its coverage is right to a tenth over \
             blocks of {:.3} m.",
            facts.screen_size * 100.0,
            facts.error_m
        ));
    }

    /// What was measured of a LOD, at the size at which it is meant to be seen.
    fn figures(&self, ui: &mut Ui, lod: usize, is_full: bool) {
        let models = self.figures.map_or(&[][..], |f| &f.evaluation.models);
        let model = models.get(lod).filter(|model| !model.rival);
        let judgement = model.map(evaluate::judge);
        let scores = judgement
            .as_ref()
            .zip(model)
            .and_then(|(judgement, model)| {
                let height = judgement.height?;
                model.scores.iter().find(|scores| scores.height == height)
            });
        let (Some(model), Some(judgement), Some(scores)) = (model, judgement, scores) else {
            for _ in 0..if is_full { 4 } else { 3 } {
                ui.weak("-");
            }
            return;
        };
        let Scores { all, .. } = scores;
        let told = told(model, &judgement, self.are_figures_current);
        let mut figure = |text: String, is_good: bool| {
            let mut text = RichText::new(text);
            if !self.are_figures_current {
                text = text.weak();
            } else if !is_good {
                text = text.color(ui.visuals().warn_fg_color);
            }
            ui.label(text).on_hover_text(&told);
        };
        figure(format!("{:.3}", all.iou), all.iou >= MIN_IOU);
        figure(
            format!("{:+.1} %", all.coverage * 100.0),
            all.coverage_abs <= MAX_COVERAGE_ERROR,
        );
        figure(format!("{:.3}", all.flip), true);
        if is_full {
            let pop = model.pop.map(|pop| format!("{:.3}", pop.flip));
            figure(pop.unwrap_or_else(|| "-".to_owned()), true);
        }
    }

    fn buttons(&self, ui: &mut Ui, line: Line, changes: &mut Vec<Change>) {
        let (Some(index), Some(written)) = (line.budget, &self.budgets) else {
            return;
        };
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            let new = budgets::between(written.budgets, index + 1);
            let offers: [(&str, String, Option<Edit>); 2] = [
                (
                    "+",
                    format!("Add a budget after {}", index + 1),
                    new.map(|new| written.add(index + 1, new)),
                ),
                (
                    "x",
                    format!("Remove budget {}", index + 1),
                    written.remove(index),
                ),
            ];
            for (label, what, edit) in offers {
                if named(ui, label, &what, edit.is_some())
                    && let Some(edit) = edit
                {
                    changes.push(Change::Edit(what, None, edit));
                }
            }
        });
    }
}

/// What a figure tells at length: the verdict, and the figures at each height.
fn told(model: &Model, judgement: &Judgement, is_current: bool) -> String {
    let mut lines = Vec::new();
    if !is_current {
        lines.push("Of the tree before the last change.".to_owned());
    }
    let height = judgement.height.unwrap_or_default();
    lines.push(format!(
        "{}, seen {height} px high",
        judgement.verdict.words()
    ));
    lines.extend(judgement.reasons.iter().cloned());
    if !model.loses_to.is_empty() {
        lines.push(format!("Loses to {}", model.loses_to.join(", ")));
    }
    for Scores { height, all, .. } in &model.scores {
        lines.push(format!(
            "At {height} px: IoU {:.3}, area {:+.1} % (off by {:.1} % a view), FLIP {:.3}, normals off by {:.0} degrees",
            all.iou,
            all.coverage * 100.0,
            all.coverage_abs * 100.0,
            all.flip,
            all.normal_deg
        ));
    }
    if let Some(flicker) = model.flicker {
        lines.push(format!(
            "In motion it changes {:.2} times as much as the full tree",
            flicker.ratio
        ));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::render::Camera;

    #[test]
    fn a_lod_takes_over_where_a_camera_sees_the_tree_that_large() {
        let lens = Lens::Perspective(0.5);
        let (height, part) = (6.0, 0.2);
        let away = distance(height, part, reach(lens).unwrap());
        let camera = Camera {
            eye: Vec3::Z * away,
            target: Vec3::ZERO,
            lens,
        };
        assert!((height / camera.height_at(Vec3::ZERO) - part).abs() < 1e-4);
        assert_eq!(reach(Lens::Orthographic(3.0)), None);
    }

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

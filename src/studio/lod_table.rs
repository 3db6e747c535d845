//! The table of LODs: budgets to be changed, and figures.

use super::budgets::{self, Budgets, Line};
use super::document::Edit;
use super::form::Change;
use super::judging::{Figures, Protocol, Strip};
use super::lods::toggle;
use super::panes::named;
use crate::asset::TreeAsset;
use crate::evaluate::{self, Judgement, MAX_COVERAGE_ERROR, MIN_IOU, Model, Scores};
use crate::render::Lens;
use crate::viewer::Subject;
use crate::viewer::level::Choice;
use eframe::egui::{Align, DragValue, Grid, Layout, Response, RichText, Ui, vec2};

/// Names of the columns, and what is told of them.
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
        "The distance from which on it is shown, through the lens of this view: what decides is its size in the picture.",
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
pub(super) struct Table<'a> {
    pub(super) subject: &'a Subject,
    pub(super) asset: &'a TreeAsset,
    /// The text's budgets; none while it is at fault.
    pub(super) budgets: Option<Budgets<'a>>,
    pub(super) strip: Option<&'a Strip>,
    pub(super) figures: Option<&'a Figures>,
    /// True if the tree is the one that the text says, and the figures are those of the tree.
    pub(super) is_current: bool,
    pub(super) are_figures_current: bool,
    /// Metres of distance for each metre of the picture's height.
    pub(super) reach: Option<f32>,
}

/// A cell with a number, which ends where the others of its column do.
fn number(ui: &mut Ui, text: RichText) -> Response {
    let left = Layout::right_to_left(Align::Center);
    ui.with_layout(left, |ui| ui.label(text)).inner
}

/// A distance in few digits.
fn metres(distance: f32) -> String {
    if distance < 1000.0 {
        format!("{distance:.0} m")
    } else {
        format!("{:.1} km", distance / 1000.0)
    }
}

/// Metres of distance for each metre of the picture's height; none without perspective.
pub(super) fn reach(lens: Lens) -> Option<f32> {
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
    /// All lines of it; what is changed goes into `changes`.
    pub(super) fn ui(&self, ui: &mut Ui, choice: &mut Choice, changes: &mut Vec<Change>) {
        let written = self.budgets.as_ref().map(|b| b.budgets);
        let asked = &self.asset.asked.budgets;
        let made_of: Vec<Option<u64>> = self.subject.lods.iter().map(|lod| lod.budget).collect();
        let lines = budgets::lines(written.unwrap_or(asked), asked, &made_of);
        let is_full = self.figures.is_some_and(|f| f.protocol == Protocol::Full);
        let columns = if is_full { 9 } else { 8 };
        ui.spacing_mut().button_padding.x = 5.0;
        Grid::new("lods")
            .striped(true)
            .spacing(vec2(6.0, 3.0))
            .min_col_width(0.0)
            .show(ui, |ui| {
                for (column, (name, meaning)) in HEADINGS.iter().take(columns).enumerate() {
                    let name = RichText::new(*name).small().weak();
                    // Names stand at the left of their columns, numbers at the right.
                    let heading = if column < 2 {
                        ui.label(name)
                    } else {
                        number(ui, name)
                    };
                    heading.on_hover_text(*meaning);
                }
                ui.end_row();
                for line in &lines {
                    self.line(ui, *line, (choice, is_full), changes);
                    ui.end_row();
                }
            });
    }

    /// A button that puts a budget before the others.
    pub(super) fn finer(&self, ui: &mut Ui, changes: &mut Vec<Change>) {
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
                    number(ui, RichText::new("-").weak());
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
        number(ui, text(facts.triangles.to_string(), self.is_current));
        let part = self.strip.and_then(|strip| strip.atlas.get(lod));
        let part = part.map_or_else(|| "-".to_owned(), |part| format!("{:.0}%", part * 100.0));
        number(ui, text(part, self.is_current));
        let height = self.subject.bounds.size().y;
        let from = match self.reach {
            Some(_) if lod == 0 => "near".to_owned(),
            Some(reach) => metres(distance(height, facts.screen_size, reach)),
            None => "-".to_owned(),
        };
        number(ui, text(from, self.is_current)).on_hover_text(format!(
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
                number(ui, RichText::new("-").weak());
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
            number(ui, text).on_hover_text(&told);
        };
        figure(format!("{:.2}", all.iou), all.iou >= MIN_IOU);
        figure(
            format!("{:+.1}%", all.coverage * 100.0),
            all.coverage_abs <= MAX_COVERAGE_ERROR,
        );
        figure(format!("{:.2}", all.flip), true);
        if is_full {
            let pop = model.pop.map(|pop| format!("{:.2}", pop.flip));
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
}

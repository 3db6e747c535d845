//! The panes around the tree: parts, fields, script.

use super::adding;
use super::app::Order;
use super::bringing::Outside;
use super::closeups::{Closeups, Near};
use super::dock::{Pane, SIMPLER};
use super::document::{Document, Edit};
use super::drawings::Drawings;
use super::form::{self, Change, Sheet};
use super::growing::Grown;
use super::hand::{Hand, Scene};
use super::judging::Judging;
use super::outline::{self, Page, Section};
use super::pictures::Pictures;
use super::script;
use super::seeds::{Seeds, Wanted};
use super::spline_editor::Editor;
use crate::asset::TreeAsset;
use crate::render::forest::ForestError;
use crate::species::fault::Fault;
use crate::species::syntax::Node;
use crate::viewer::loader::Stage;
use crate::viewer::settings::{Arrangement, Settings, Sun};
use crate::viewer::{Subject, Viewport};
use crate::viewer::{legend, panel};
use eframe::egui::{self, Align2, RichText, Ui, UiBuilder, UiKind, UiStackInfo, vec2};
use egui_tiles::{Behavior, SimplificationOptions, TileId, UiResponse};
use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;

/// How often the word of what is being done moves.
pub(super) const BUSY: Duration = Duration::from_millis(200);

/// What panes see of the studio.
pub(super) struct Panes<'a> {
    pub(super) document: &'a Document,
    pub(super) pages: &'a [Page],
    pub(super) faults: &'a [Fault],
    pub(super) selected: &'a str,
    pub(super) settings: &'a mut Settings,
    pub(super) view: &'a mut Viewport,
    pub(super) hand: &'a mut Hand,
    pub(super) shown: Option<&'a Arc<Grown>>,
    pub(super) subject: Option<&'a Subject>,
    /// The last tree with all its LODs.
    pub(super) grown: Option<&'a Arc<Grown>>,
    /// A newer one that has captures and shadows alone.
    pub(super) furnished: Option<&'a Arc<Grown>>,
    /// How many of those there were.
    pub(super) furnishings: u64,
    /// The whole one's number.
    pub(super) number: u64,
    pub(super) pictures: &'a mut Pictures,
    pub(super) closeups: &'a mut Closeups,
    pub(super) drawings: &'a RefCell<Drawings>,
    pub(super) seeds: &'a mut Seeds,
    /// Number of the tree that is shown.
    pub(super) shows: u64,
    /// True while a tree is growing, or about to.
    pub(super) growing: bool,
    pub(super) judging: &'a mut Judging,
    pub(super) busy: Option<Stage>,
    pub(super) stale: bool,
    pub(super) fault: Option<ForestError>,
    pub(super) frame: bool,
    pub(super) orders: Vec<Order>,
}

impl Behavior<Pane> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        match pane {
            Pane::Tree => self.tree(ui),
            Pane::Outline => framed(ui, |ui| self.outline(ui)),
            Pane::Fields => framed(ui, |ui| self.fields(ui)),
            Pane::Seeds => framed(ui, |ui| self.seeds(ui)),
            Pane::Script => framed(ui, |ui| self.script(ui)),
            Pane::Lods => framed(ui, |ui| self.lods(ui)),
            Pane::Atlas => framed(ui, |ui| {
                self.asset(ui, |pictures, ui, tree, _| pictures.atlas(ui, tree));
            }),
            Pane::Shadows => framed(ui, |ui| {
                self.asset(ui, |pictures, ui, tree, sun| {
                    pictures.shadows(ui, tree, sun);
                });
            }),
            Pane::View => framed(ui, |ui| {
                let asked = panel::ui(ui, self.settings, self.view, self.subject);
                self.frame |= asked.frame;
            }),
        }
        UiResponse::None
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SIMPLER
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }
}

/// A pane's content with air around it. The window's background is of a panel's colour: painting that once more takes a
/// software driver long, but what lies on it must know.
fn framed(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    let background = egui::Frame::NONE.fill(ui.visuals().panel_fill);
    let info = UiStackInfo::new(UiKind::Frame).with_frame(background);
    ui.scope_builder(UiBuilder::new().ui_stack_info(info), |ui| {
        egui::Frame::NONE.inner_margin(6.0).show(ui, |ui| {
            ui.set_min_size(ui.available_size());
            content(ui);
        });
    });
}

impl Panes<'_> {
    fn tree(&mut self, ui: &mut Ui) {
        let response = match self.view.ui(ui, self.settings, self.subject) {
            Ok(response) => response,
            Err(error) => {
                self.fault = Some(error);
                return;
            }
        };
        if let Some(shown) = self.shown
            && self.settings.arrangement == Arrangement::Single
        {
            let scene = Scene {
                view: self.view.projection(response.rect),
                response: &response,
                shown,
                document: self.document,
                pages: self.pages,
                selected: self.selected,
            };
            self.hand.ui(ui, &scene, &mut self.orders);
        }
        if let Some(stage) = &self.busy {
            let at = response.rect.center_top() + vec2(0.0, 10.0);
            let font = egui::FontId::proportional(13.0);
            let words = match (stage.name, stage.steps) {
                ("", _) => "growing ...".to_owned(),
                (name, 0) => format!("{name} ..."),
                (name, steps) => format!("{name}, {} of {steps}", stage.done.min(steps)),
            };
            let painter = ui.painter();
            painter.text(at, Align2::CENTER_TOP, words, font, egui::Color32::WHITE);
            ui.ctx().request_repaint_after(BUSY);
        } else if self.stale {
            let at = response.rect.center_top() + vec2(0.0, 10.0);
            let font = egui::FontId::proportional(13.0);
            let words = "the last sound tree: the script is at fault";
            let colour = ui.visuals().error_fg_color;
            ui.painter()
                .text(at, Align2::CENTER_TOP, words, font, colour);
        }
    }

    fn outline(&mut self, ui: &mut Ui) {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.set_width(ui.available_width());
            for section in [
                Section::Species,
                Section::Stems,
                Section::Bark,
                Section::Lod,
                Section::Levels,
                Section::Leaves,
                Section::Splines,
                Section::Variations,
            ] {
                if let Some(heading) = section.heading() {
                    ui.add_space(6.0);
                    ui.horizontal_wrapped(|ui| {
                        ui.label(RichText::new(heading).strong());
                        self.adding(ui, section);
                    });
                }
                for page in self.pages.iter().filter(|p| p.section == section) {
                    ui.horizontal(|ui| {
                        #[expect(clippy::cast_precision_loss, reason = "a few levels")]
                        ui.add_space(page.depth as f32 * 10.0);
                        if page.section == Section::Levels {
                            self.swatch(ui, page);
                        }
                        let is_selected = page.path == self.selected;
                        let row = egui::Button::selectable(is_selected, &page.title);
                        let is_item = outline::number(&page.path).is_some();
                        let row = ui.add(if is_item {
                            row.sense(egui::Sense::click_and_drag())
                        } else {
                            row
                        });
                        if row.clicked() {
                            self.orders.push(Order::Select(page.path.clone()));
                        }
                        if is_item {
                            self.dragged(ui, page, &row);
                        }
                    });
                }
            }
        });
    }

    /// The colour of a level's page where the picture shows levels by their colours.
    fn swatch(&self, ui: &mut Ui, page: &Page) {
        let tree = self
            .subject
            .and_then(Subject::asset)
            .map(|asset| &asset.tree);
        let grown = tree.and_then(|tree| legend::place(tree, &page.title));
        let place = grown.or_else(|| outline::number(&page.path));
        legend::swatch(ui, place.unwrap_or(0))
            .on_hover_text("Its colour in the view \"Level colours\" (V)");
    }

    /// Lets a row be dragged to another place of its list.
    fn dragged(&mut self, ui: &Ui, page: &Page, row: &egui::Response) {
        row.dnd_set_drag_payload(page.path.clone());
        let list = |path: &str| path.rsplit_once('.').map(|(list, _)| list.to_owned());
        let over = row.dnd_hover_payload::<String>();
        if over.is_none_or(|from| list(&from) != list(&page.path) || *from == page.path) {
            return;
        }
        let at = ui.ctx().pointer_latest_pos().unwrap_or_default();
        let below = at.y > row.rect.center().y;
        let edge = if below {
            row.rect.bottom()
        } else {
            row.rect.top()
        };
        let stroke = egui::Stroke::new(2.0, ui.visuals().selection.bg_fill);
        ui.painter().hline(row.rect.x_range(), edge, stroke);
        let Some(from) = row.dnd_release_payload::<String>() else {
            return;
        };
        let (Some(from_index), Some(index)) = (outline::number(&from), outline::number(&page.path))
        else {
            return;
        };
        // Its own place is empty once it is taken up.
        let to = (index + usize::from(below))
            .saturating_sub(usize::from(from_index < index + usize::from(below)));
        let title = self.pages.iter().find(|p| p.path == *from);
        let name = title.map_or_else(String::new, |page| format!("Move {}", page.title));
        let path = (*from).clone();
        let select = list(&path).map(|list| format!("{list}.{to}"));
        let edit = Edit::Reorder { path, to };
        self.orders
            .push(Order::Change(Change::Edit(name, None, edit)));
        self.orders.extend(select.map(Order::Select));
    }

    /// Buttons that add an item to a list.
    fn adding(&mut self, ui: &mut Ui, section: Section) {
        let reading = self.document.reading();
        let (Some(root), Ok(species)) = (&reading.root, &reading.species) else {
            return;
        };
        for offer in adding::offers(section, (root, species), self.pages, self.selected) {
            if named(ui, offer.label, offer.what, true) {
                let change = Change::Edit(offer.what.to_owned(), None, offer.edit);
                self.orders.push(Order::Change(change));
                self.orders.push(Order::Select(offer.select));
            }
        }
    }

    fn fields(&mut self, ui: &mut Ui) {
        let Some(root) = &self.document.reading().root else {
            ui.label("The script's brackets do not match; mend it in its text.");
            return;
        };
        let page = self.pages.iter().find(|p| p.path == self.selected);
        let Some(page) = page.or_else(|| self.pages.first()) else {
            return;
        };
        let Some(node) = outline::at(root, &page.path) else {
            return;
        };
        egui::ScrollArea::vertical()
            .id_salt(&page.path)
            .show(ui, |ui| {
                ui.set_width(ui.available_width());
                ui.horizontal(|ui| {
                    ui.heading(&page.title);
                    self.item_buttons(ui, page);
                });
                ui.label(RichText::new(page.table.doc).small().weak());
                ui.add_space(4.0);
                let mut changes = Vec::new();
                self.designer(ui, page, node, &mut changes);
                let sheet = Sheet {
                    source: self.document.text(),
                    faults: self.faults,
                    is_trunk: page.path == "levels.0",
                    drawings: self.drawings,
                    within: None,
                };
                form::page(ui, sheet, (node, page.table), &page.path, &mut changes);
                self.orders.extend(changes.into_iter().map(Order::Change));
            });
    }

    /// What a page shows above its fields: a spline's editor, a leaf or the bark from near.
    fn designer(&mut self, ui: &mut Ui, page: &Page, node: &Node, changes: &mut Vec<Change>) {
        let near = match page.section {
            Section::Splines => {
                match Editor::of(&page.path, node) {
                    Some(editor) => editor.ui(ui, changes),
                    None => {
                        let species = self.document.reading().species.as_ref().ok();
                        let outside = species.and_then(|s| Outside::of(&page.path, node, s));
                        let text = self.document.text();
                        changes.extend(outside.and_then(|outside| outside.ui(ui, text)));
                    }
                }
                ui.separator();
                return;
            }
            Section::Leaves => Near::Leaf(outline::number(&page.path).unwrap_or(0)),
            Section::Bark => Near::Bark,
            _ => return,
        };
        let tree = self.subject.and_then(Subject::asset);
        if let (Some(tree), Ok(species)) = (tree, &self.document.reading().species) {
            self.closeups.ui(ui, near, (self.shows, tree), species);
        }
    }

    fn seeds(&mut self, ui: &mut Ui) {
        let reading = self.document.reading();
        let (Some(root), Ok(species)) = (&reading.root, &reading.species) else {
            ui.label("The script is at fault; mend it first.");
            return;
        };
        let folder = self.document.folder();
        let wanted = self.seeds.ui(
            ui,
            (self.document.text(), root, species),
            folder,
            self.growing,
        );
        self.orders
            .extend(wanted.into_iter().map(|wanted| match wanted {
                Wanted::Change(change) => Order::Change(change),
                Wanted::Select(path) => Order::Select(path),
            }));
    }

    /// What can be done to an item of a list.
    fn item_buttons(&mut self, ui: &mut Ui, page: &Page) {
        let Some(index) = outline::number(&page.path) else {
            return;
        };
        let list = page.section.field();
        let count = self
            .pages
            .iter()
            .filter(|p| p.section == page.section)
            .count();
        let at = |index: usize| format!("{list}.{index}");
        let path = page.path.clone();
        let names = self
            .pages
            .iter()
            .filter(|p| p.section == page.section)
            .map(|p| &*p.title);
        let name = adding::free(names, &page.title);
        let title = &page.title;
        let offers = [
            (
                "up",
                format!("Move {title} up"),
                index > 0,
                Edit::Reorder {
                    path: path.clone(),
                    to: index.saturating_sub(1),
                },
                at(index.saturating_sub(1)),
            ),
            (
                "down",
                format!("Move {title} down"),
                index + 1 < count,
                Edit::Reorder {
                    path: path.clone(),
                    to: index + 1,
                },
                at(index + 1),
            ),
            (
                "copy",
                format!("Duplicate {title}"),
                true,
                Edit::Duplicate {
                    path: path.clone(),
                    name,
                },
                at(index + 1),
            ),
            (
                "delete",
                format!("Delete {title}"),
                true,
                Edit::Remove(path.clone()),
                at(index.saturating_sub(1)),
            ),
        ];
        for (label, what, enabled, edit, then) in offers {
            if named(ui, label, &what, enabled) {
                self.orders
                    .push(Order::Change(Change::Edit(what, None, edit)));
                self.orders.push(Order::Select(then));
            }
        }
    }

    fn script(&mut self, ui: &mut Ui) {
        let (edited, finished) = script::ui(ui, self.document.text(), self.faults);
        if let Some(text) = edited {
            let gesture = Some("type".to_owned());
            let change = Change::Edit("Type in the script".to_owned(), gesture, Edit::Text(text));
            self.orders.push(Order::Change(change));
        }
        if finished {
            self.orders.push(Order::Change(Change::Rest));
        }
    }

    /// Shows something of the last tree that has captures and shadows.
    fn asset(
        &mut self,
        ui: &mut Ui,
        show: impl FnOnce(&mut Pictures, &mut Ui, (u64, &TreeAsset), Sun),
    ) {
        let tree = self.furnished.or(self.grown);
        match tree.and_then(|tree| tree.subject.asset()) {
            Some(tree) => {
                let number = self.number + self.furnishings;
                show(self.pictures, ui, (number, tree), self.settings.sun);
            }
            None => {
                ui.weak("no tree yet");
            }
        }
    }
}

/// A small button that says at length what it does; true if it was pressed.
pub(super) fn named(ui: &mut Ui, label: &str, what: &str, enabled: bool) -> bool {
    let button = ui.add_enabled(enabled, egui::Button::new(label).small());
    let button = button.on_hover_text(what);
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, what));
    button.clicked()
}

//! The panes around the tree: parts, fields, script.

use super::adding;
use super::app::Order;
use super::document::{Document, Edit};
use super::form::{self, Change, Sheet};
use super::growing::Grown;
use super::judging::Judging;
use super::outline::{self, Page, Section};
use super::pictures::Pictures;
use super::script;
use crate::asset::TreeAsset;
use crate::render::forest::ForestError;
use crate::species::fault::Fault;
use crate::viewer::loader::Stage;
use crate::viewer::panel;
use crate::viewer::settings::{Settings, Sun};
use crate::viewer::{Subject, Viewport};
use eframe::egui::{self, Align2, RichText, Ui, vec2};
use egui_tiles::{Behavior, Tile, TileId, Tiles, Tree, UiResponse};
use std::sync::Arc;
use std::time::Duration;

/// How often the word of what is being done moves.
pub(super) const BUSY: Duration = Duration::from_millis(200);

/// A part of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pane {
    Tree,
    Outline,
    Fields,
    Script,
    Lods,
    Atlas,
    Shadows,
    View,
}

impl Pane {
    fn title(self) -> &'static str {
        match self {
            Self::Tree => "Tree",
            Self::Outline => "Parts",
            Self::Fields => "Fields",
            Self::Script => "Script",
            Self::Lods => "LODs",
            Self::Atlas => "Atlas",
            Self::Shadows => "Shadows",
            Self::View => "View",
        }
    }
}

/// How the panes stand at first.
pub(super) fn dock() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let [tree, outline, fields, script, lods, atlas, shadows, view] = [
        Pane::Tree,
        Pane::Outline,
        Pane::Fields,
        Pane::Script,
        Pane::Lods,
        Pane::Atlas,
        Pane::Shadows,
        Pane::View,
    ]
    .map(|pane| tiles.insert_pane(pane));
    let left = tiles.insert_tab_tile(vec![outline]);
    let middle = tiles.insert_tab_tile(vec![tree]);
    let upper = tiles.insert_tab_tile(vec![fields, view]);
    let lower = tiles.insert_tab_tile(vec![script, lods, atlas, shadows]);
    let right = tiles.insert_vertical_tile(vec![upper, lower]);
    let root = tiles.insert_horizontal_tile(vec![left, middle, right]);
    for (tabs, active) in [(upper, fields), (lower, script)] {
        if let Some(Tile::Container(egui_tiles::Container::Tabs(tabs))) = tiles.get_mut(tabs) {
            tabs.set_active(active);
        }
    }
    if let Some(Tile::Container(egui_tiles::Container::Linear(linear))) = tiles.get_mut(root) {
        for (tile, share) in [(left, 0.55), (middle, 2.0), (right, 1.25)] {
            linear.shares.set_share(tile, share);
        }
    }
    Tree::new(egui::Id::unique("studio dock"), root, tiles)
}

/// What panes see of the studio.
pub(super) struct Panes<'a> {
    pub(super) document: &'a Document,
    pub(super) pages: &'a [Page],
    pub(super) faults: &'a [Fault],
    pub(super) selected: &'a str,
    pub(super) settings: &'a mut Settings,
    pub(super) view: &'a mut Viewport,
    pub(super) subject: Option<&'a Subject>,
    /// The last tree with all its LODs.
    pub(super) grown: Option<&'a Arc<Grown>>,
    /// Its number.
    pub(super) number: u64,
    pub(super) pictures: &'a mut Pictures,
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

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }
}

fn framed(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    let frame = egui::Frame::NONE.fill(ui.visuals().panel_fill);
    frame.inner_margin(6.0).show(ui, |ui| {
        ui.set_min_size(ui.available_size());
        content(ui);
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
                        let is_selected = page.path == self.selected;
                        if ui.selectable_label(is_selected, &page.title).clicked() {
                            self.orders.push(Order::Select(page.path.clone()));
                        }
                    });
                }
            }
        });
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
                let sheet = Sheet {
                    source: self.document.text(),
                    faults: self.faults,
                    is_trunk: page.path == "levels.0",
                };
                let mut changes = Vec::new();
                form::page(ui, sheet, (node, page.table), &page.path, &mut changes);
                self.orders.extend(changes.into_iter().map(Order::Change));
            });
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

    /// Shows something of the last tree that has all of it.
    fn asset(
        &mut self,
        ui: &mut Ui,
        show: impl FnOnce(&mut Pictures, &mut Ui, (u64, &TreeAsset), Sun),
    ) {
        match self.grown.and_then(|grown| grown.subject.asset()) {
            Some(tree) => show(self.pictures, ui, (self.number, tree), self.settings.sun),
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

//! Sixteen trees of the species, each from another seed: to look at, to take over, to keep by name.

use super::adding::free;
use super::closeups;
use super::document::Edit;
use super::form::{Change, quoted};
use super::outline;
use crate::pipeline::{self, Sketcher};
use crate::preview::closeups::Paint;
use crate::preview::{self, Settings};
use crate::species::Beside;
use crate::species::schema::Species;
use crate::species::syntax::Node;
use crate::viewer::loader::Loader;
use eframe::egui::{self, Color32, Rect, RichText, Stroke, TextureHandle, Ui, pos2, vec2};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Trees that are shown at once, and in a row.
const COUNT: usize = 16;
const ACROSS: usize = 4;

/// Seeds from one grid to the next.
const STEP: u64 = COUNT as u64;

/// Size of a picture, pixels.
const SIZE: [u32; 2] = [150, 176];

/// The pictures of one species.
pub(super) struct Seeds {
    loader: Loader<()>,
    first: u64,
    of: Option<(Box<Species>, u64)>,
    /// The text that was looked at last, and the first seed: while they stay, so do the pictures.
    seen: Option<(String, u64)>,
    shared: Arc<Mutex<Vec<Option<Paint>>>>,
    textures: Vec<Option<TextureHandle>>,
}

/// What was asked for in the grid.
pub(super) enum Wanted {
    /// To change the script.
    Change(Change),
    /// To show a page.
    Select(String),
}

impl Seeds {
    pub(super) fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {
            loader: Loader::start("seeds", wake)?,
            first: 1,
            of: None,
            seen: None,
            shared: Arc::default(),
            textures: Vec::new(),
        })
    }

    /// Lets go of what is being drawn: something else needs the processor.
    pub(super) fn stop(&mut self) {
        if self.loader.stage().is_some() {
            self.loader.stop();
            (self.of, self.seen) = (None, None);
        }
    }

    /// Shows the grid; draws it anew if the species is another one and nothing else is `busy`.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        (text, root, species): (&str, &Node, &Species),
        folder: PathBuf,
        busy: bool,
    ) -> Vec<Wanted> {
        self.loader.poll();
        let mut wanted = Vec::new();
        ui.horizontal(|ui| {
            if ui.button("earlier").clicked() {
                self.first = self.first.saturating_sub(STEP);
            }
            ui.label(format!("seeds {} to {}", self.first, self.first + STEP - 1));
            if ui.button("later").clicked() {
                self.first = self.first.saturating_add(STEP);
            }
            ui.weak("Click a tree to take its seed.");
        });
        let same = |(seen, first): &(String, u64)| seen == text && *first == self.first;
        if !busy && !self.seen.as_ref().is_some_and(same) {
            self.seen = Some((text.to_owned(), self.first));
            self.draw(species, folder);
        }
        self.fetch(ui);
        if let Some(fault) = self.loader.fault() {
            ui.colored_label(ui.visuals().error_fg_color, fault);
        }
        let room = (ui.available_width() - 12.0) / 4.0;
        let width = room.clamp(52.0, 150.0);
        let size = vec2(width, width * 1.17);
        egui::ScrollArea::vertical()
            .id_salt("seeds")
            .show(ui, |ui| {
                egui::Grid::new("grid of seeds")
                    .spacing(vec2(4.0, 4.0))
                    .show(ui, |ui| {
                        for (index, seed) in (self.first..self.first + STEP).enumerate() {
                            let texture = self.textures.get(index).and_then(Option::as_ref);
                            ui.vertical(|ui| {
                                if cell(ui, (seed, seed == species.seed), size, texture) {
                                    wanted.push(Wanted::Change(take(seed)));
                                }
                                if let Some((change, path)) = keep(ui, root, seed) {
                                    wanted.push(Wanted::Change(change));
                                    wanted.push(Wanted::Select(path));
                                }
                            });
                            if index % ACROSS == ACROSS - 1 {
                                ui.end_row();
                            }
                        }
                    });
            });
        wanted
    }

    /// True if all pictures of the grid are there.
    pub(super) fn is_whole(&self) -> bool {
        !self.textures.is_empty() && self.textures.iter().all(Option::is_some)
    }

    /// Begins to draw the pictures that are wanted now, if others were drawn last. Trees of other seeds are the
    /// same; the seed of the script only says which textures they have.
    fn draw(&mut self, species: &Species, folder: PathBuf) {
        let same =
            |(drawn, first): &(Box<Species>, u64)| *first == self.first && alike(drawn, species);
        if self.of.as_ref().is_some_and(same) {
            return;
        }
        let species = Box::new(species.clone());
        self.of = Some((species.clone(), self.first));
        self.shared = Arc::new(Mutex::new(vec![None; COUNT]));
        self.textures = vec![None; COUNT];
        let (shared, first) = (Arc::clone(&self.shared), self.first);
        self.loader.ask(Box::new(move |progress| {
            let mut sketcher = Sketcher::default();
            for (index, seed) in (first..first + STEP).enumerate() {
                // Wakes the window, so that each picture is shown as soon as it is there.
                progress.begin("seeds", STEP);
                if progress.cancelled() {
                    return Ok(());
                }
                let settings = pipeline::Settings::default();
                let seeds = (seed, species.seed);
                let sketch = sketcher.shape(&species, seeds, &settings, &Beside(folder.clone()));
                let Some(sketch) = sketch.map_err(|e| e.to_string())? else {
                    return Err("the tree has too many triangles to be sketched".to_owned());
                };
                let settings = Settings {
                    size: SIZE,
                    supersample: 1,
                    ..Settings::default()
                };
                let picture = preview::picture(&sketch.asset.drawable(), &settings);
                let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
                shared[index] = Some(picture);
            }
            Ok(())
        }));
    }

    /// Puts pictures that have come on the window's device.
    fn fetch(&mut self, ui: &Ui) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        for (paint, texture) in shared.iter_mut().zip(&mut self.textures) {
            if let Some(paint) = paint.take() {
                let image = closeups::image(&paint);
                let options = egui::TextureOptions::LINEAR;
                *texture = Some(ui.ctx().load_texture("seed", image, options));
            }
        }
    }
}

/// True if two species grow the same trees: what they are called and what is kept of them does not matter.
fn alike(a: &Species, b: &Species) -> bool {
    let plain = |species: &Species| Species {
        seed: 0,
        variations: Vec::new(),
        name: String::new(),
        latin: String::new(),
        slug: String::new(),
        ..species.clone()
    };
    plain(a) == plain(b)
}

/// One tree; true if it was clicked.
fn cell(
    ui: &mut Ui,
    (seed, is_own): (u64, bool),
    size: egui::Vec2,
    texture: Option<&TextureHandle>,
) -> bool {
    let (place, response) = ui.allocate_exact_size(size, egui::Sense::click());
    let name = format!("Take seed {seed}");
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_own, name.clone()));
    let visuals = ui.visuals();
    let painter = ui.painter();
    painter.rect_filled(place, 3.0, visuals.extreme_bg_color);
    if let Some(texture) = texture {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture.id(), place, whole, Color32::WHITE);
    }
    if is_own || response.hovered() || response.has_focus() {
        let width = if is_own { 2.5 } else { 1.5 };
        let stroke = Stroke::new(width, visuals.selection.bg_fill);
        painter.rect_stroke(place, 3.0, stroke, egui::StrokeKind::Inside);
    }
    let at = place.left_bottom() + vec2(4.0, -3.0);
    let font = egui::FontId::proportional(11.0);
    let ink = Color32::from_gray(20);
    painter.text(at, egui::Align2::LEFT_BOTTOM, seed.to_string(), font, ink);
    response.clicked()
}

fn take(seed: u64) -> Change {
    let edit = Edit::Set {
        path: "seed".to_owned(),
        value: seed.to_string(),
    };
    Change::Edit(format!("Take seed {seed}"), None, edit)
}

/// A button that keeps a seed by name, or the name that it is kept by.
fn keep(ui: &mut Ui, root: &Node, seed: u64) -> Option<(Change, String)> {
    let list = outline::field(root, "variations");
    let kept = list.map_or(&[][..], outline::items);
    let is_of = |item: &&Node| {
        let own = outline::field(item, "seed").map(|s| &s.kind);
        let text = seed.to_string();
        matches!(own, Some(crate::species::syntax::Kind::Number(number)) if *number == text)
    };
    if let Some(name) = kept.iter().find(is_of).and_then(outline::name) {
        ui.label(RichText::new(name).small().strong());
        return None;
    }
    let what = format!("Keep seed {seed}");
    let button = ui.add(egui::Button::new("keep").small().frame(false));
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, what.clone()));
    if !button.clicked() {
        return None;
    }
    let names = kept.iter().filter_map(outline::name);
    let name = quoted(&free(names, "kept"));
    let item = format!("(name: {name}, seed: {seed})");
    let edit = match list {
        Some(_) => Edit::Insert {
            list: "variations".to_owned(),
            index: kept.len(),
            item,
        },
        None => Edit::Set {
            path: "variations".to_owned(),
            value: format!("[{item}]"),
        },
    };
    let select = format!("variations.{}", kept.len());
    Some((Change::Edit(what, None, edit), select))
}

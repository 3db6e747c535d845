//! Drawings of what a field does: the species with less of it, as it is, and with more, side by side.

use super::closeups;
use super::skeleton::{self, Line};
use crate::image::Image;
use crate::math::Vec3;
use crate::preview::closeups::{Channel, Paint};
use crate::species::edit;
use crate::species::schema::{Bark, LeafLook, Species};
use crate::species::{self, Beside};
use crate::texture;
use crate::tree::{self, Limits};
use crate::viewer::loader::Loader;
use eframe::egui::{self, Color32, Rect, Sense, Stroke, TextureHandle, Ui, pos2, vec2};
use std::path::PathBuf;

/// Most lines of one drawing: enough to tell a tree by.
const LINES: usize = 700;

/// Size of a drawing, points; texels of a texture's edge.
const SIZE: [f32; 2] = [96.0, 112.0];
const TEXELS: u32 = 128;

/// What is to be drawn: a field, and the values that it is drawn with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wish {
    /// Path of the field, as for [`edit::set`].
    pub(super) path: String,
    /// Captions and values, as a script writes them.
    pub(super) values: Vec<(String, String)>,
}

/// A wish that came true.
#[derive(Debug)]
struct Drawn {
    of: Asked,
    cells: Vec<(String, Cell)>,
}

/// One drawing.
#[derive(Clone, Debug)]
enum Cell {
    /// Lines in metres (right and up); true for those of the field's level.
    Lines(Vec<(bool, Vec<[f32; 2]>)>),
    Texture(Paint),
    /// It cannot be grown so.
    Nothing,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Asked {
    text: String,
    wish: Wish,
}

/// Drawings, made on a thread of their own.
pub(super) struct Drawings {
    loader: Loader<Drawn>,
    /// What was pointed at in the last frame.
    wanted: Option<Wish>,
    asked: Option<Asked>,
    /// Textures of the newest ones on the window's device.
    textures: Option<(Asked, Vec<Option<TextureHandle>>)>,
}

impl Drawings {
    pub(super) fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {
            loader: Loader::start("draw", wake)?,
            wanted: None,
            asked: None,
            textures: None,
        })
    }

    /// Begins to draw what was pointed at, with a script whose files are in a folder.
    pub(super) fn draw(&mut self, text: &str, folder: impl FnOnce() -> PathBuf) {
        self.loader.poll();
        let Some(wish) = self.wanted.take() else {
            return;
        };
        let asked = Asked {
            text: text.to_owned(),
            wish,
        };
        if self.asked.as_ref() == Some(&asked) {
            return;
        }
        self.asked = Some(asked.clone());
        let folder = folder();
        self.loader.ask(Box::new(move |progress| {
            let mut cells = Vec::new();
            for (caption, value) in &asked.wish.values {
                if progress.cancelled() {
                    break;
                }
                let text = edit::set(&asked.text, &asked.wish.path, value).unwrap_or_default();
                let species = species::parse("script", &text, &Beside(folder.clone()));
                let cell = match &species {
                    Ok(species) => drawn(species, &asked.wish.path),
                    Err(_) => Cell::Nothing,
                };
                cells.push((caption.clone(), cell));
            }
            Ok(Drawn { of: asked, cells })
        }));
    }

    /// Shows what was wished for, or room for it.
    pub(super) fn ui(&mut self, ui: &mut Ui, wish: &Wish) {
        self.wanted = Some(wish.clone());
        let drawn = self.loader.good().filter(|drawn| drawn.of.wish == *wish);
        let drawn = drawn.cloned();
        if let Some(drawn) = &drawn
            && self.textures.as_ref().is_none_or(|(of, _)| *of != drawn.of)
        {
            let texture = |(name, cell): &(String, Cell)| match cell {
                Cell::Texture(paint) => {
                    let image = closeups::image(paint);
                    Some(
                        ui.ctx()
                            .load_texture(name, image, egui::TextureOptions::LINEAR),
                    )
                }
                _ => None,
            };
            self.textures = Some((drawn.of.clone(), drawn.cells.iter().map(texture).collect()));
        }
        let frame = drawn.as_ref().map(|drawn| frame(drawn));
        ui.horizontal(|ui| {
            for (index, (caption, value)) in wish.values.iter().enumerate() {
                ui.vertical(|ui| {
                    let (place, _) = ui.allocate_exact_size(SIZE.into(), Sense::hover());
                    ui.painter()
                        .rect_filled(place, 3.0, ui.visuals().extreme_bg_color);
                    let cell = drawn.as_ref().and_then(|d| d.cells.get(index));
                    match cell.map(|(_, cell)| cell) {
                        Some(Cell::Lines(lines)) => {
                            if let Some(frame) = frame {
                                paint(ui, place, frame, lines);
                            }
                        }
                        Some(Cell::Texture(_)) => {
                            let textures = self.textures.as_ref().map(|(_, all)| all);
                            if let Some(Some(texture)) = textures.and_then(|all| all.get(index)) {
                                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                                let square =
                                    Rect::from_center_size(place.center(), vec2(96.0, 96.0));
                                ui.painter()
                                    .image(texture.id(), square, whole, Color32::WHITE);
                            }
                        }
                        Some(Cell::Nothing) | None => {}
                    }
                    ui.small(caption).on_hover_text(value);
                });
            }
        });
    }
}

/// A species' tree as lines, or the texture that a path is about.
fn drawn(species: &Species, path: &str) -> Cell {
    let mut steps = path.split('.');
    let (first, second) = (steps.next(), steps.next());
    let number = second.and_then(|step| step.parse::<usize>().ok());
    match (first, number) {
        (Some("leaves"), Some(kind)) => leaf(species, kind),
        (Some("bark"), _) => match &species.bark {
            Bark::Drawn(art) => {
                let texels = texture::bark(art, species.seed, TEXELS);
                Cell::Texture(texels.map(|texel| Channel::Lit.of(texel)))
            }
            Bark::Image { .. } => Cell::Nothing,
        },
        (Some("lod" | "variations"), _) => Cell::Nothing,
        (first, number) => lines(species, number.filter(|_| first == Some("levels"))),
    }
}

fn leaf(species: &Species, kind: usize) -> Cell {
    let Some(kind) = species.leaves.get(kind) else {
        return Cell::Nothing;
    };
    let LeafLook::Drawn(art) = &kind.look else {
        return Cell::Nothing;
    };
    let longest = kind.length_m.max(kind.width_m);
    let texels =
        |side: f32| crate::math::round_to_u32(side / longest * crate::math::float(TEXELS)).max(4);
    let [width, height] = [kind.width_m, kind.length_m].map(texels);
    let card = texture::leaf(kind, art, art.state, species.seed, width, height);
    let card = card.map(|texel| Channel::Lit.on_paper(texel));
    let mut square = Image::filled(
        TEXELS,
        TEXELS,
        Channel::Lit.on_paper(&crate::image::Texel::EMPTY),
    );
    let corner = [width, height].map(|edge| (TEXELS - edge.min(TEXELS)) / 2);
    for y in 0..height.min(TEXELS) {
        for x in 0..width.min(TEXELS) {
            *square.at_mut(corner[0] + x, corner[1] + y) = *card.at(x, y);
        }
    }
    Cell::Texture(square)
}

fn lines(species: &Species, level: Option<usize>) -> Cell {
    let Ok(tree) = tree::grow(species, species.seed, &Limits::default()) else {
        return Cell::Nothing;
    };
    let shift = usize::from(species.stems.is_some());
    let own = level.map(|level| level + shift);
    let flat = |p: &Vec3| [p.x, p.y];
    let line = |Line { level, points }: Line| {
        (
            own.is_none_or(|own| own == level),
            points.iter().map(flat).collect(),
        )
    };
    Cell::Lines(
        skeleton::lines(&tree, LINES)
            .into_iter()
            .map(line)
            .collect(),
    )
}

/// The box that all drawings of a wish lie in: left, lower, right and upper end, metres.
fn frame(drawn: &Drawn) -> [f32; 4] {
    let lines = drawn.cells.iter().filter_map(|(_, cell)| match cell {
        Cell::Lines(lines) => Some(lines),
        _ => None,
    });
    let points = lines.flatten().flat_map(|(_, points)| points);
    points.fold([-0.1, 0.0, 0.1, 0.1], |[a, b, c, d], [x, y]| {
        [a.min(*x), b.min(*y), c.max(*x), d.max(*y)]
    })
}

fn paint(
    ui: &Ui,
    place: Rect,
    [left, low, right, high]: [f32; 4],
    lines: &[(bool, Vec<[f32; 2]>)],
) {
    let place = place.shrink(4.0);
    let scale = (place.width() / (right - left)).min(place.height() / (high - low));
    let at = |[x, y]: &[f32; 2]| {
        pos2(
            place.center().x + (x - (left + right) * 0.5) * scale,
            place.bottom() - (y - low) * scale,
        )
    };
    let painter = ui.painter_at(place);
    let visuals = ui.visuals();
    for own in [false, true] {
        let stroke = if own {
            Stroke::new(1.2, visuals.hyperlink_color)
        } else {
            Stroke::new(0.6, visuals.weak_text_color().gamma_multiply(0.7))
        };
        for (_, points) in lines.iter().filter(|(is_own, _)| *is_own == own) {
            painter.line(points.iter().map(at).collect(), stroke);
        }
    }
}

//! The view of a tree, to be put into any egui window: its camera, what the mouse does in it, how fine it is
//! drawn, and what is written over it.

use super::canvas::{Canvas, Side, Woods};
use super::keys;
use super::level::Choice;
use super::pace::{Frames, Pace, Quality, REST};
use super::person;
use super::projection::Projection;
use super::rig::{Rig, Stance, Steps};
use super::settings::{Arrangement, Settings};
use super::split;
use super::stage::{Cast, Shown, Stage};
use super::subject::Subject;
use crate::gpu::GpuError;
use crate::image::Image;
use crate::math::{TAU, Vec3, float, round_to_u32};
use crate::render::forest::ForestError;
use crate::render::{Maker, Model, Scene};
use eframe::egui::{self, Color32, PointerButton, Pos2, Rect, Response, Sense, Ui, vec2};
use eframe::egui_wgpu::RenderState;
use std::time::Duration;

/// What there is where there is no picture.
const UNSEEN: Color32 = Color32::from_gray(24);

/// Radians a second of the turntable.
const TURNTABLE: f32 = 0.45;

/// Zoom of one point of scrolling, as the logarithm of a factor.
const SCROLL: f32 = 0.0022;

/// Longest time that passes for what is animated, seconds: after a slow frame things go on and do not jump.
const LONGEST: f32 = 0.25;

/// Height of the camera over the horizon, radians, where a strip and a forest are framed.
const STRIP_ELEVATION: f32 = 0.05;
const FOREST_ELEVATION: f32 = 0.2;

/// Seconds in which a tree of a forest goes over to another LOD while something moves.
const FADE: f32 = 0.4;

/// A view and its camera.
#[derive(Debug)]
pub struct Viewport {
    canvas: Canvas,
    stage: Stage,
    pace: Pace,
    /// Times of the last frames.
    pub frames: Frames,
    /// The camera.
    pub rig: Rig,
    /// What was drawn last.
    pub shown: Shown,
    /// How fine it was drawn.
    pub quality: Quality,
    /// Size of the view in pixels.
    pub size: [u32; 2],
    /// What of the settings decides how long a picture takes.
    costly: Option<Costly>,
    /// Azimuth and elevation from which one tree was seen last.
    angles: [f32; 2],
    /// True until the tree that has come first is framed.
    unframed: bool,
    /// What decides the picture, as it was in the frame before.
    last: Option<(Rig, Settings, [u32; 2])>,
    /// True if another tree has come since the frame before, which counts as a move.
    arrived: bool,
    /// True while a better tree than the one that is shown is about to come.
    awaits: bool,
    /// When something moved last, seconds of the window's clock; none if it never did.
    moved: Option<f64>,
    /// When the frame before was begun, if something moved then.
    before: Option<f64>,
    /// How long pictures of sketches take while there is a whole tree, and the other way round.
    other_pace: Pace,
    /// What the last whole tree and the last sketch had of LODs, and of triangles in a hurry.
    finest: [Option<(usize, u64)>; 2],
}

type Costly = (Arrangement, Choice, bool);

impl Viewport {
    /// A view without a tree.
    ///
    /// # Errors
    /// What the driver says.
    pub fn new(state: &RenderState) -> Result<Self, GpuError> {
        Ok(Self {
            canvas: Canvas::new(state)?,
            stage: Stage::default(),
            pace: Pace::default(),
            frames: Frames::default(),
            rig: Rig::around(&[Vec3::ZERO, Vec3::Y * 5.0], 1.0),
            shown: Shown::default(),
            quality: Quality::FULL,
            size: [0, 0],
            costly: None,
            angles: [0.0; 2],
            unframed: true,
            last: None,
            arrived: false,
            awaits: false,
            moved: None,
            before: None,
            other_pace: Pace::default(),
            finest: [None; 2],
        })
    }

    /// Name and driver of the adapter.
    #[must_use]
    pub fn describe(&self) -> String {
        self.canvas.describe()
    }

    /// What makes models for this view on other threads.
    #[must_use]
    pub fn maker(&self) -> Maker {
        self.canvas.maker()
    }

    /// Shows a tree that such a thread has put on the device; the camera stays, but for the first tree. If it is the
    /// tree that is shown, only finer, there is no haste.
    pub fn put(&mut self, model: Model, is_finer: bool) {
        let was_sketch = self.canvas.is_sketch();
        self.canvas.put(model, is_finer);
        let (now, is_sketch) = (self.canvas.finest(), self.canvas.is_sketch());
        if is_sketch != was_sketch {
            std::mem::swap(&mut self.pace, &mut self.other_pace);
        }
        // One edit after another changes little of how long a picture takes.
        let alike = |(lods, triangles): (usize, u64), (count, now): (usize, u64)| {
            lods == count && now.max(triangles) <= now.min(triangles).saturating_mul(3) / 2
        };
        let before = std::mem::replace(&mut self.finest[usize::from(is_sketch)], now);
        if !before.zip(now).is_some_and(|(a, b)| alike(a, b)) {
            self.pace.forget();
        }
        self.arrived |= !is_finer;
    }

    /// Whether another tree than the one that is shown is about to come: this one is then not worth a picture in full.
    pub fn await_tree(&mut self, awaits: bool) {
        self.awaits = awaits;
    }

    /// What a window with this view is cleared with: the colour of panels, which then need not paint it.
    #[must_use]
    pub fn background(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.canvas.background(visuals.panel_fill)
    }

    /// True if a processor draws, which takes its time.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.canvas.is_software()
    }

    /// Frames the tree that comes next, as it does the first one.
    pub fn reframe(&mut self) {
        self.unframed = true;
    }

    /// Keeps a camera that was used before the view was made anew.
    pub fn keep(&mut self, rig: Rig) {
        self.rig = rig;
        self.unframed = false;
    }

    /// Takes the camera to where another arrangement is best seen from: straight before a strip, and from some
    /// height over a forest. One tree is seen again as it was.
    pub fn arrange(&mut self, from: Arrangement, subject: &Subject, settings: &Settings) {
        let orbit = &mut self.rig.orbit;
        if from == Arrangement::Single {
            self.angles = [orbit.azimuth, orbit.elevation];
        }
        [orbit.azimuth, orbit.elevation] = match settings.arrangement {
            Arrangement::Single => self.angles,
            Arrangement::Strip => [0.0, STRIP_ELEVATION],
            Arrangement::Forest => [self.angles[0], FOREST_ELEVATION],
        };
        self.frame(subject, settings);
    }

    /// Shows all of what stands in the picture.
    pub fn frame(&mut self, subject: &Subject, settings: &Settings) {
        let cast = cast(subject);
        let points = self.stage.frame(&cast, settings, self.canvas.hull());
        self.rig.frame(&points, aspect(self.size));
    }

    /// What the driver told since the last call.
    ///
    /// # Errors
    /// That.
    pub fn check(&self) -> Result<(), GpuError> {
        self.canvas.check()
    }

    /// The view as a picture to keep, with all its pixels and LODs as they are at rest.
    ///
    /// # Errors
    /// If the device fails.
    pub fn still(
        &mut self,
        subject: &Subject,
        settings: &Settings,
    ) -> Result<Image<[u8; 4]>, ForestError> {
        let (scene, _) = self
            .stage
            .scene(&cast(subject), settings, self.rig.camera(), 0);
        let size = self.canvas.fitting(self.size.map(|edge| edge.max(1)));
        let trees = self.stage.forest(&cast(subject), settings);
        let woods = woods(settings, 0, 0.0);
        self.canvas.still(&scene, (trees, woods), size)
    }

    /// The scene that is shown at rest.
    pub fn scene(&mut self, subject: &Subject, settings: &Settings) -> Scene {
        let camera = self.rig.camera();
        self.stage.scene(&cast(subject), settings, camera, 0).0
    }

    /// Takes the device away, as a driver that gives up does: to see what becomes of the window.
    pub fn destroy_device(&self) {
        self.canvas.destroy_device();
    }

    /// Takes all the room that is left, follows mouse and keys, and draws. Without a tree it is empty.
    ///
    /// # Errors
    /// If the device fails; the picture before stays.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        settings: &mut Settings,
        subject: Option<&Subject>,
    ) -> Result<Response, ForestError> {
        let room = ui.available_size();
        let (rect, response) = ui.allocate_exact_size(room, Sense::click_and_drag());
        let scale = ui.ctx().pixels_per_point();
        // As many pixels as lie between its edges on the screen.
        self.size = [rect.x_range(), rect.y_range()].map(|range| {
            let [from, to] = [range.min, range.max].map(|at| (at * scale).round());
            round_to_u32((to - from).max(0.0))
        });
        let name = subject.map_or("no tree yet", |s| s.name.as_str());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Canvas, true, format!("View of {name}"))
        });
        let Some(subject) = subject else {
            ui.painter().rect_filled(rect, 0.0, UNSEEN);
            return Ok(response);
        };
        if self.unframed && !self.size.contains(&0) {
            self.unframed = false;
            self.frame(subject, settings);
        }
        if response.double_clicked() {
            self.frame(subject, settings);
        }
        self.follow(ui, &response, settings);
        let drawn = self.draw(ui, settings, subject);
        self.paint(ui, &response, settings, subject);
        self.label_strip(ui, rect, settings, subject);
        if settings.person && settings.arrangement == Arrangement::Single {
            person::draw(ui, &self.projection(rect));
        }
        drawn?;
        Ok(response)
    }

    /// What is seen where, in a picture that fills `rect`.
    #[must_use]
    pub fn projection(&self, rect: Rect) -> Projection {
        Projection::new(self.rig.camera(), rect)
    }

    /// Shows what is drawn: one LOD, or two beside a line.
    fn paint(&self, ui: &Ui, view: &Response, settings: &mut Settings, subject: &Subject) {
        let rect = view.rect;
        let Some(main) = self.canvas.picture(Side::Main) else {
            ui.painter().rect_filled(rect, 0.0, UNSEEN);
            return;
        };
        let finest = self.canvas.picture(Side::Finest);
        let Some((at, finest)) = split::place(settings).zip(finest) else {
            main.paint(ui.painter(), rect);
            return;
        };
        split::paint(ui, rect, at, [finest, main]);
        split::label(ui, rect, at, subject, self.shown.lod);
        if let Some(at) = &mut settings.compare {
            split::line(ui, rect, view, at);
        }
    }

    /// Mouse, held keys and clocks.
    fn follow(&mut self, ui: &Ui, response: &Response, settings: &mut Settings) {
        let drag = response.drag_delta() / response.rect.height().max(1.0);
        let ctrl = ui.input(|i| i.modifiers.command);
        if response.dragged_by(PointerButton::Primary) && ctrl {
            let forward = self.rig.camera().forward();
            settings.sun.drag(drag.x, -drag.y, forward);
        } else if response.dragged_by(PointerButton::Primary) {
            self.rig.turn(drag.x, drag.y);
        } else if response.dragged() {
            self.rig.pan(drag.x, drag.y);
        }
        if response.contains_pointer() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            if scroll != 0.0 || pinch != 1.0 {
                self.rig
                    .zoom(libm::expf(-scroll * SCROLL) / pinch.max(0.01));
            }
        }
        let seconds = ui.input(|i| i.stable_dt).min(LONGEST);
        let steps = steps(ui);
        self.rig.walk(steps, seconds);
        let turns = settings.turntable && self.rig.stance == Stance::Orbit;
        if turns {
            let azimuth = &mut self.rig.orbit.azimuth;
            *azimuth = libm::fmodf(*azimuth + TURNTABLE * seconds, TAU);
        }
        let blows = settings.breeze.moves();
        if blows {
            settings.breeze.time += seconds;
        }
        if steps.any() || turns || blows {
            ui.ctx().request_repaint();
        }
    }

    /// True if the picture is another than in the frame before.
    fn moves(&mut self, settings: &Settings) -> bool {
        let settings = Settings {
            help: false,
            panel: false,
            // The line moves over pictures that stay.
            compare: settings.compare.map(|_| split::MIDDLE),
            ..*settings
        };
        let now = (self.rig, settings, self.size);
        let arrived = std::mem::take(&mut self.arrived);
        self.last.replace(now) != Some(now) || arrived
    }

    /// Draws what is to be seen, as fine as there is time for, unless it is there already.
    fn draw(&mut self, ui: &Ui, settings: &Settings, subject: &Subject) -> Result<(), ForestError> {
        let now = ui.input(|i| i.time);
        let moves = self.moves(settings);
        if moves || self.awaits {
            self.moved = Some(now);
        }
        let resting = self.moved.map_or(f64::MAX, |moved| now - moved);
        let hurried = resting < REST && settings.adapt;
        if hurried {
            let left = Duration::from_secs_f64(REST - resting);
            ui.ctx().request_repaint_after(left);
        }
        let two = split::place(settings).is_some();
        let costly = (settings.arrangement, settings.choice, two);
        if self.costly.replace(costly) != Some(costly) {
            self.pace.forget();
        }
        let most = match costly {
            (Arrangement::Strip, ..) | (_, Choice::Fixed(_), _) => 0,
            _ => cast(subject).coarsest_in_a_hurry(),
        };
        let wanted = if !settings.adapt {
            Quality::FULL
        } else if hurried && !moves {
            self.quality
        } else {
            let least = usize::from(self.canvas.is_rough()).min(most);
            self.pace.quality(hurried, (least, most), self.quality)
        };
        let cast = cast(subject);
        let camera = self.rig.camera();
        let (scene, mut shown) = self.stage.scene(&cast, settings, camera, wanted.coarser);
        let size = self.canvas.fitting(scaled(self.size, wanted.factor));
        let seconds = if moves {
            ui.input(|i| i.stable_dt)
        } else {
            0.0
        };
        let trees = self.stage.forest(&cast, settings);
        let woods = Woods {
            hurried: hurried && self.canvas.is_software(),
            ..woods(settings, wanted.coarser, seconds)
        };
        let mut drawn = self.canvas.draw(Side::Main, &scene, (trees, woods), size)?;
        if two {
            let finest = split::finest(&scene);
            let more = self
                .canvas
                .draw(Side::Finest, &finest, (&[], woods), size)?;
            drawn = drawn.map(|seconds| seconds + more.unwrap_or(0.0)).or(more);
        } else {
            self.canvas.let_go(Side::Finest);
        }
        if let Some(seconds) = drawn {
            self.pace.observe(wanted, seconds);
            if !moves {
                // What is told beside the picture is that of the frame before; and now that it is known how long it
                // takes, it may be drawn finer.
                ui.ctx().request_repaint();
            }
            if let Some((trees, triangles)) = self.canvas.counts() {
                (shown.trees, shown.triangles) = (trees, triangles);
            }
            (self.shown, self.quality) = (shown, wanted);
            let whole = self.before.filter(|_| moves).map(|before| now - before);
            #[expect(clippy::cast_possible_truncation, reason = "a frame's time")]
            self.frames.add(whole.map_or(seconds, |s| s as f32));
        }
        self.before = moves.then_some(now);
        Ok(())
    }

    /// Writes under each tree of a strip which LOD it is.
    fn label_strip(&mut self, ui: &Ui, rect: Rect, settings: &Settings, subject: &Subject) {
        let places = self.stage.strip_places(&cast(subject), settings);
        let projection = self.projection(rect);
        for (index, (place, lod)) in places.iter().zip(&subject.lods).enumerate() {
            if let Some(at) = projection.seen(*place) {
                let text = format!("LOD {index}\n{} triangles", grouped(lod.triangles));
                write(ui, at + vec2(0.0, 10.0), egui::Align2::CENTER_TOP, &text);
            }
        }
    }
}

/// What a stage must know of a tree.
fn cast(subject: &Subject) -> Cast<'_> {
    Cast {
        lods: &subject.lods,
        stand_ins: &subject.stand_ins,
        bounds: subject.bounds,
    }
}

/// How a forest is drawn after a frame of so many seconds; 0 for a picture that stays, where no LOD is half
/// faded in.
fn woods(settings: &Settings, coarser: usize, seconds: f32) -> Woods {
    Woods {
        lod: match settings.choice {
            Choice::ByDistance => None,
            Choice::Fixed(lod) => u32::try_from(lod).ok(),
        },
        coarser,
        fade: if seconds > 0.0 { FADE } else { 0.0 },
        seconds,
        hurried: false,
    }
}

fn aspect([width, height]: [u32; 2]) -> f32 {
    (float(width.max(1)) / float(height.max(1))).clamp(0.05, 20.0)
}

fn scaled(size: [u32; 2], factor: f32) -> [u32; 2] {
    size.map(|edge| match edge {
        0 => 0,
        _ => round_to_u32(float(edge) * factor).max(1),
    })
}

/// Which keys of walking are held.
fn steps(ui: &Ui) -> Steps {
    if ui.ctx().egui_wants_keyboard_input() {
        return Steps::default();
    }
    ui.input(|input| {
        let mut steps = Steps {
            hurry: input.modifiers.shift,
            ..Steps::default()
        };
        for (key, [aside, ahead]) in keys::WALKING {
            if input.key_down(key) && !input.modifiers.command {
                steps.aside += aside;
                steps.ahead += ahead;
            }
        }
        steps
    })
}

/// Text that can be read over any picture.
pub(crate) fn write(ui: &Ui, at: Pos2, align: egui::Align2, text: &str) {
    let font = egui::FontId::proportional(13.0);
    let painter = ui.painter();
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::WHITE);
    let rect = align.anchor_size(at, galley.size());
    painter.rect_filled(rect.expand(4.0), 4.0, Color32::from_black_alpha(140));
    painter.galley(rect.min, galley, Color32::WHITE);
}

/// A number with its digits in groups of three.
pub(super) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        for (number, expected) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1234567, "1,234,567"),
        ] {
            assert_eq!(grouped(number), expected);
        }
    }

    #[test]
    fn a_size_without_area_stays_so_and_others_keep_a_pixel() {
        assert_eq!(scaled([0, 400], 0.25), [0, 100]);
        assert_eq!(scaled([1, 3], 0.25), [1, 1]);
    }
}

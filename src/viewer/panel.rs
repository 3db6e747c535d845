//! The panel beside the view: every setting with its name, and what is shown in numbers.

use super::keys;
use super::legend;
use super::level::Choice;
use super::pace::{Frames, KEPT};
use super::rig::Stance;
use super::settings::{Arrangement, Breeze, LOWEST_SUN, Settings, VIEWS};
use super::split;
use super::subject::Subject;
use super::viewport::{Viewport, grouped};
use crate::math::float;
use crate::render::{Filter, LightMode, ViewMode};
use eframe::egui::{self, Color32, RichText, Slider, Stroke, Ui, pos2, vec2};

/// Seconds at the upper edge of the graph of frame times; what took longer is cut off there.
const GRAPH: f32 = 0.15;

/// What a person asked for in the panel that is no setting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asked {
    /// To frame what is shown.
    pub frame: bool,
    /// To write a screenshot.
    pub shot: bool,
}

/// Brightness of text on dark and on light: egui's own is hard to read over a long day.
const TEXT: [(egui::Theme, u8); 2] = [(egui::Theme::Dark, 195), (egui::Theme::Light, 50)];

/// How all of the window looks.
pub fn style(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| style.spacing.item_spacing.y = 3.0);
    for (theme, text) in TEXT {
        ctx.style_mut_of(theme, |style| {
            style.visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(text);
        });
    }
}

/// The panel.
pub fn ui(
    ui: &mut Ui,
    settings: &mut Settings,
    view: &mut Viewport,
    subject: Option<&Subject>,
) -> Asked {
    let mut asked = Asked::default();
    egui::ScrollArea::vertical().show(ui, |ui| {
        ui.set_width(ui.available_width());
        if let Some(subject) = subject {
            ui.heading(&subject.name);
            ui.weak(format!("seed {}", subject.seed));
            ui.add_space(4.0);
            lods(ui, settings, view, subject);
        }
        section(ui, "Picture", |ui| picture(ui, settings, subject));
        section(ui, "Frames", |ui| frames(ui, settings, view));
        section(ui, "Camera", |ui| asked.frame = camera(ui, settings, view));
        section(ui, "Sun", |ui| {
            let sun = &mut settings.sun;
            slider(
                ui,
                Slider::new(&mut sun.azimuth, 0.0..=360.0).suffix("°"),
                "Azimuth",
            );
            let heights = LOWEST_SUN..=90.0;
            slider(
                ui,
                Slider::new(&mut sun.elevation, heights).suffix("°"),
                "Elevation",
            );
        });
        section(ui, "Wind", |ui| wind(ui, &mut settings.breeze));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            asked.shot = ui.button("Screenshot").clicked();
            ui.toggle_value(&mut settings.help, "Help");
        });
        if let Some(subject) = subject {
            for warning in &subject.warnings {
                ui.add_space(4.0);
                ui.small(format!("warning: {warning}"));
            }
        }
    });
    asked
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    ui.add_space(6.0);
    ui.separator();
    ui.strong(title);
    contents(ui);
}

fn slider(ui: &mut Ui, slider: Slider<'_>, name: &str) {
    ui.spacing_mut().slider_width = 96.0;
    ui.add(slider.max_decimals(2).text(name));
}

/// How the LOD is chosen, and what is shown of each.
fn lods(ui: &mut Ui, settings: &mut Settings, view: &Viewport, subject: &Subject) {
    let shown = &view.shown;
    let strip = settings.arrangement == Arrangement::Strip;
    ui.add_enabled_ui(!strip, |ui| {
        ui.selectable_value(&mut settings.choice, Choice::ByDistance, "LOD by distance");
        for (index, lod) in subject.lods.iter().enumerate() {
            let budget = if lod.budget.is_none() {
                ", full detail"
            } else {
                ""
            };
            let text = format!("LOD {index}: {} triangles{budget}", grouped(lod.triangles));
            let drawn = shown.trees.get(index).is_some_and(|&trees| trees > 0);
            let text = if drawn {
                RichText::new(text).strong()
            } else {
                RichText::new(text)
            };
            ui.selectable_value(&mut settings.choice, Choice::Fixed(index), text)
                .on_hover_text(format!(
                    "error {:.3} m; shown where the tree fills at most {} of the picture's height",
                    lod.error_m,
                    percent(lod.screen_size)
                ));
        }
    });
    split::toggle(ui, settings);
    ui.add_space(4.0);
    let single = settings.arrangement == Arrangement::Single;
    if let Some(lod) = subject.lods.get(shown.lod).filter(|_| single) {
        ui.label(match lod.budget {
            None => format!("Shown: LOD {}, full detail", shown.lod),
            Some(_) => format!(
                "Shown: LOD {}, error {:.3} m, fit for up to {} of the height",
                shown.lod,
                lod.error_m,
                percent(lod.screen_size)
            ),
        });
        ui.label(format!(
            "The tree fills {} of the height",
            percent(shown.part)
        ));
    }
    let trees: usize = shown.trees.iter().sum();
    ui.label(format!(
        "{} triangles in {trees} {}",
        grouped(shown.triangles),
        if trees == 1 { "tree" } else { "trees" }
    ));
    if settings.arrangement == Arrangement::Forest {
        let each = shown.trees.iter().map(ToString::to_string);
        ui.label(format!(
            "Trees by LOD: {}",
            each.collect::<Vec<_>>().join(", ")
        ));
    }
}

fn percent(part: f32) -> String {
    format!("{:.0} %", part.min(9.99) * 100.0)
}

fn picture(ui: &mut Ui, settings: &mut Settings, subject: Option<&Subject>) {
    ui.horizontal(|ui| {
        for (arrangement, name) in [
            (Arrangement::Single, "One tree"),
            (Arrangement::Strip, "LOD strip"),
            (Arrangement::Forest, "Forest"),
        ] {
            ui.selectable_value(&mut settings.arrangement, arrangement, name);
        }
    });
    if settings.arrangement == Arrangement::Forest {
        let trees = Slider::new(&mut settings.trees, 10..=5000).logarithmic(true);
        slider(ui, trees, "Trees");
    }
    ui.horizontal_wrapped(|ui| {
        for (view, name) in VIEWS {
            ui.selectable_value(&mut settings.view, view, name);
        }
    });
    if settings.view == ViewMode::Levels {
        legend::ui(ui, subject);
    }
    ui.add_enabled_ui(settings.arrangement == Arrangement::Single, |ui| {
        ui.checkbox(&mut settings.person, "Person beside the tree")
            .on_hover_text("1.75 m high, to see how large the tree is");
    });
    ui.collapsing("Light and filter", |ui| {
        ui.horizontal(|ui| {
            ui.selectable_value(&mut settings.light, LightMode::Product, "Product");
            ui.selectable_value(&mut settings.light, LightMode::FourFactors, "Four factors");
        });
        ui.horizontal_wrapped(|ui| {
            for (filter, name) in [
                (Filter::None, "No filter"),
                (Filter::Bilinear, "Bilinear"),
                (Filter::Alpha, "Alpha"),
                (Filter::Combined, "Combined"),
            ] {
                ui.selectable_value(&mut settings.filter, filter, name);
            }
        });
    });
}

/// True if the frame button was pressed.
fn camera(ui: &mut Ui, settings: &mut Settings, view: &mut Viewport) -> bool {
    let mut frame = false;
    ui.horizontal(|ui| {
        let mut stance = view.rig.stance;
        ui.selectable_value(&mut stance, Stance::Orbit, "Orbit");
        ui.selectable_value(&mut stance, Stance::Walk, "Walk");
        view.rig.hold(stance);
        frame = ui.button("Frame").clicked();
    });
    match view.rig.stance {
        Stance::Orbit => {
            ui.checkbox(&mut settings.turntable, "Turntable");
        }
        Stance::Walk => {
            let speed = Slider::new(&mut view.rig.walker.speed, 0.25..=64.0).logarithmic(true);
            slider(ui, speed.suffix(" m/s"), "Speed");
        }
    }
    frame
}

fn wind(ui: &mut Ui, breeze: &mut Breeze) {
    ui.horizontal(|ui| {
        ui.checkbox(&mut breeze.on, "Wind blows");
        let name = if breeze.playing { "Pause" } else { "Play" };
        if ui.add_enabled(breeze.on, egui::Button::new(name)).clicked() {
            breeze.playing = !breeze.playing;
        }
    });
    ui.add_enabled_ui(breeze.on, |ui| {
        slider(
            ui,
            Slider::new(&mut breeze.direction, 0.0..=360.0).suffix("°"),
            "Direction",
        );
        slider(
            ui,
            Slider::new(&mut breeze.speed, 0.0..=25.0).suffix(" m/s"),
            "Wind speed",
        );
        slider(
            ui,
            Slider::new(&mut breeze.gustiness, 0.0..=1.0),
            "Gustiness",
        );
        ui.horizontal(|ui| {
            let name = ui.label("Time");
            let time = egui::DragValue::new(&mut breeze.time)
                .speed(0.05)
                .range(0.0..=1e5)
                .max_decimals(2)
                .suffix(" s");
            ui.add(time).labelled_by(name.id);
        });
    });
}

fn frames(ui: &mut Ui, settings: &mut Settings, view: &Viewport) {
    graph(ui, &view.frames);
    let last = view.frames.last().unwrap_or(0.0) * 1e3;
    ui.label(format!(
        "{last:.0} ms, slowest {:.0} ms",
        view.frames.slowest() * 1e3
    ));
    let coarser = match view.quality.coarser {
        0 => String::new(),
        1 => ", LODs one coarser".to_owned(),
        n => format!(", LODs {n} coarser"),
    };
    ui.label(format!(
        "Resolution {}{coarser}",
        percent(view.quality.factor)
    ));
    ui.checkbox(&mut settings.adapt, "Coarser while moving, if slow");
}

/// Times of the last frames as bars, with lines at 16 and 100 milliseconds.
fn graph(ui: &mut Ui, frames: &Frames) {
    let (rect, response) =
        ui.allocate_exact_size(vec2(ui.available_width(), 44.0), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Frame times"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, Color32::from_gray(18));
    let height = |seconds: f32| rect.bottom() - rect.height() * (seconds / GRAPH).min(1.0);
    #[expect(clippy::cast_precision_loss, reason = "a hundred or so")]
    let wide = rect.width() / KEPT as f32;
    let count = u32::try_from(frames.times().len()).unwrap_or(0);
    for (index, seconds) in (0u32..).zip(frames.times()) {
        let x = rect.right() - float(count - index) * wide;
        let colour = match seconds {
            s if s <= 1.0 / 50.0 => Color32::from_rgb(110, 190, 110),
            s if s <= 0.1 => Color32::from_rgb(215, 185, 90),
            _ => Color32::from_rgb(215, 110, 90),
        };
        let bar = egui::Rect::from_min_max(pos2(x, height(seconds)), pos2(x + wide, rect.bottom()));
        painter.rect_filled(bar, 0.0, colour);
    }
    for (seconds, name) in [(1.0 / 60.0, "16 ms"), (0.1, "100 ms")] {
        let y = height(seconds);
        painter.hline(rect.x_range(), y, Stroke::new(1.0, Color32::from_gray(70)));
        let font = egui::FontId::proportional(9.0);
        let align = egui::Align2::LEFT_BOTTOM;
        painter.text(
            pos2(rect.left() + 2.0, y),
            align,
            name,
            font,
            Color32::from_gray(140),
        );
    }
}

/// What keys and mouse do.
pub fn help(ctx: &egui::Context, open: &mut bool) {
    if !*open {
        return;
    }
    let mut close = false;
    egui::Window::new("Keys and mouse")
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .show(ctx, |ui| {
            egui::Grid::new("keys").striped(true).show(ui, |ui| {
                let keys = keys::KEYS.iter().map(|(line, _)| line);
                for line in keys::HELD.iter().chain(keys) {
                    ui.strong(line.keys);
                    ui.label(line.does);
                    ui.end_row();
                }
            });
            ui.add_space(4.0);
            close = ui.button("Close help").clicked();
        });
    *open &= !close;
}

/// What is wrong with the script, under the view.
pub fn faults(ui: &mut Ui, fault: &str, has_tree: bool) {
    let title = if has_tree {
        "The newest state is at fault; the last good tree is shown"
    } else {
        "There is no tree yet"
    };
    ui.colored_label(
        Color32::from_rgb(235, 120, 100),
        RichText::new(title).strong(),
    );
    egui::ScrollArea::both()
        .max_height(180.0)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            let text = RichText::new(fault).monospace();
            ui.add(egui::Label::new(text).extend().selectable(true));
        });
}

//! Two LODs of one tree in one picture, from the same camera and under the same sun: the finest to the left of a
//! line that is dragged, the chosen one to its right.

use super::settings::{Arrangement, Settings};
use super::show::Paintable;
use super::subject::Subject;
use super::viewport::{grouped, write};
use crate::math::float;
use crate::render::Scene;
use eframe::egui::accesskit::{Action, ActionData, Orientation};
use eframe::egui::{
    self, Align2, Color32, CursorIcon, EventFilter, Key, Rect, Response, Role, Sense, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};

/// Where the line stands at first, as a part of the picture's width.
pub const MIDDLE: f32 = 0.5;

/// How far a key moves the line.
const STEP: f32 = 0.02;

/// Points to each side of the line at which it is still taken hold of.
const REACH: f32 = 6.0;

/// What the line is called.
pub const NAME: &str = "Line between the finest LOD and the chosen one";

/// A box to tick for such a picture, which only one tree has.
pub fn toggle(ui: &mut Ui, settings: &mut Settings) -> Response {
    let is_single = settings.arrangement == Arrangement::Single;
    let mut on = settings.compare.is_some();
    let tick = egui::Checkbox::new(&mut on, "Compare with the finest LOD");
    let response = ui.add_enabled(is_single, tick).on_hover_text(
        "The finest LOD to the left of a line, the one that is shown to its right. Drag the line, or move it by the \
         arrow keys.",
    );
    if response.changed() {
        settings.compare = on.then_some(MIDDLE);
    }
    response
}

/// The place of the line where two LODs are to be shown.
#[must_use]
pub(super) fn place(settings: &Settings) -> Option<f32> {
    settings
        .compare
        .filter(|_| settings.arrangement == Arrangement::Single)
}

/// A scene with all its trees at their finest.
#[must_use]
pub(super) fn finest(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for group in &mut scene.groups {
        group.lod = 0;
    }
    scene
}

/// Shows the left part of one picture and the right part of another.
pub(super) fn paint(ui: &Ui, rect: Rect, at: f32, [left, right]: [&Paintable; 2]) {
    let (a, b) = rect.split_left_right_at_fraction(at);
    for (picture, part) in [(left, a), (right, b)] {
        picture.paint(&ui.painter().with_clip_rect(part), rect);
    }
}

/// The line, which is moved by the mouse, by the arrow keys once it is reached by Tab, and by a screen reader.
pub(super) fn line(ui: &Ui, rect: Rect, view: &Response, at: &mut f32) {
    let x = egui::lerp(rect.x_range(), *at);
    let grip = Rect::from_x_y_ranges(x - REACH..=x + REACH, rect.y_range());
    let id = view.id.with("line");
    let response = ui
        .interact(grip, id, Sense::drag())
        .on_hover_cursor(CursorIcon::ResizeHorizontal);
    let before = *at;
    if let Some(pointer) = response.interact_pointer_pos()
        && response.dragged()
    {
        *at = (pointer.x - rect.left()) / rect.width().max(1.0);
    }
    if response.has_focus() {
        let filter = EventFilter {
            horizontal_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, filter));
        *at += STEP * asked_by_keys(ui);
    }
    if let Some(place) = asked_by_reader(ui, id) {
        *at = place;
    }
    *at = at.clamp(0.0, 1.0);
    if *at != before {
        ui.ctx().request_repaint();
    }
    response.widget_info(|| {
        let mut info = WidgetInfo::labeled(Role::Splitter, true, NAME);
        info.value = Some(f64::from(*at));
        info
    });
    ui.ctx().accesskit_node_builder(id, |node| {
        node.set_orientation(Orientation::Vertical);
        node.set_min_numeric_value(0.0);
        node.set_max_numeric_value(1.0);
        node.set_numeric_value_step(f64::from(STEP));
        node.add_action(Action::SetValue);
        node.add_action(Action::Increment);
        node.add_action(Action::Decrement);
    });
    let held = response.dragged() || response.has_focus();
    draw(ui, rect, *at, held || response.hovered());
}

/// Steps to the right that keys ask for.
fn asked_by_keys(ui: &Ui) -> f32 {
    let presses = |key: Key| {
        let count = ui.input(|input| input.num_presses(key));
        float(u32::try_from(count).unwrap_or(0))
    };
    presses(Key::ArrowRight) - presses(Key::ArrowLeft)
}

/// Where a screen reader wants the line.
fn asked_by_reader(ui: &Ui, id: egui::Id) -> Option<f32> {
    ui.input(|input| {
        let mut requests = input.accesskit_action_requests(id, Action::SetValue);
        requests.find_map(|request| match request.data {
            #[expect(clippy::cast_possible_truncation, reason = "a part of a width")]
            Some(ActionData::NumericValue(value)) => Some(value as f32),
            _ => None,
        })
    })
}

fn draw(ui: &Ui, rect: Rect, at: f32, is_held: bool) {
    let x = egui::lerp(rect.x_range(), at);
    let painter = ui.painter();
    let width = if is_held { 3.0 } else { 1.5 };
    // Seen over a light and over a dark tree.
    let dark = Stroke::new(width + 2.0, Color32::from_black_alpha(140));
    painter.vline(x, rect.y_range(), dark);
    painter.vline(x, rect.y_range(), Stroke::new(width, Color32::WHITE));
    let knob = pos2(x, rect.center().y);
    painter.circle(
        knob,
        if is_held { 7.0 } else { 5.5 },
        Color32::WHITE,
        Stroke::new(1.5, Color32::from_black_alpha(160)),
    );
}

/// Writes at the foot of the line what stands on either side of it.
pub(super) fn label(ui: &Ui, rect: Rect, at: f32, subject: &Subject, shown: usize) {
    let foot = pos2(egui::lerp(rect.x_range(), at), rect.bottom() - 12.0);
    for (lod, align, aside) in [
        (0, Align2::RIGHT_BOTTOM, -14.0),
        (shown, Align2::LEFT_BOTTOM, 14.0),
    ] {
        let Some(facts) = subject.lods.get(lod) else {
            continue;
        };
        let text = format!("LOD {lod}\n{} triangles", grouped(facts.triangles));
        write(ui, foot + vec2(aside, 0.0), align, &text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::render::{Camera, Group, Instance, Lens, Setting, ViewMode};

    #[test]
    fn only_one_tree_is_shown_twice() {
        let mut settings = Settings::default();
        assert_eq!(place(&settings), None);
        settings.compare = Some(0.3);
        assert_eq!(place(&settings), Some(0.3));
        for arrangement in [Arrangement::Strip, Arrangement::Forest] {
            settings.arrangement = arrangement;
            assert_eq!(place(&settings), None);
        }
    }

    #[test]
    fn the_finest_scene_differs_in_its_lods_alone() {
        let settings = Settings::default();
        let tree = Instance::at(Vec3::X, 0.3, 1.0);
        let group = |lod| Group {
            model: 0,
            lod,
            trees: vec![tree],
        };
        let scene = |lod| Scene {
            camera: Camera {
                eye: Vec3::Z,
                target: Vec3::ZERO,
                lens: Lens::Perspective(0.5),
            },
            setting: Setting::default(),
            wind: settings.breeze.wind(),
            time: 2.0,
            view: ViewMode::Lit,
            filter: settings.filter,
            groups: vec![group(lod)],
        };
        assert_eq!(finest(&scene(3)), scene(0));
    }
}

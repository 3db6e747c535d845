//! Handles under the pointer and the keyboard: a drag is one gesture, and the tree follows it.

use super::app::Order;
use super::crown::Crown;
use super::curve::number;
use super::hand::{Hand, Level, Scene};
use super::handles::{self, Handle, Sets};
use super::marks::{self, Shaped};
use super::picking::placed;
use crate::math::Vec3;
use crate::species::schema::Habit;
use crate::tree::{Kind, Part, Tree};
use crate::viewer::write;
use eframe::egui::accesskit::Action;
use eframe::egui::{
    Align2, CursorIcon, EventFilter, Id, Key, Pos2, Rect, Response, Role, Sense, Stroke, Ui, Vec2,
    WidgetInfo, vec2,
};

/// Edge of the square in which a handle is taken hold of, points.
const GRIP: f32 = 18.0;

/// What is held, as it was when it was taken hold of: the tree that follows it lags behind.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Held {
    handle: Handle,
    /// Where on its track it is now.
    place: f32,
    /// From the pointer to the handle's middle.
    off: Vec2,
    pub(super) following: Following,
}

/// How far the tree has followed what is held.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Following {
    /// True once it was let go of, until the tree has followed.
    pub(super) is_released: bool,
    /// What the script said then.
    left: Option<String>,
}

impl Following {
    /// True once the handles of the tree that is shown are right again, or the script says something else.
    pub(super) fn is_over(&mut self, scene: &Scene<'_>) -> bool {
        if !self.is_released {
            return false;
        }
        let text = scene.document.text();
        let left = self.left.get_or_insert_with(|| text.to_owned());
        scene.is_up_to_date() || left != text
    }
}

/// A handle's widget.
pub(super) struct Grip<'a> {
    pub(super) id: Id,
    pub(super) at: Pos2,
    pub(super) shaped: Shaped,
    pub(super) label: &'a str,
    /// What it sets, if that is one number.
    pub(super) value: Option<f64>,
    pub(super) meaning: &'a str,
}

impl Grip<'_> {
    /// Shows it; `None` where it is not in the picture.
    pub(super) fn ui(&self, ui: &Ui, rect: Rect) -> Option<Response> {
        let place = Rect::from_center_size(self.at, Vec2::splat(GRIP));
        // What is drawn out of the picture is still held.
        let held = [ui.ctx().dragged_id(), ui.ctx().drag_stopped_id()];
        if !rect.contains(self.at) && !held.contains(&Some(self.id)) {
            return None;
        }
        let response = ui.interact(place, self.id, Sense::click_and_drag());
        response.widget_info(|| match self.value {
            Some(value) => WidgetInfo::slider(true, value, self.label),
            None => WidgetInfo::labeled(Role::Button, true, self.label),
        });
        let is_active = response.hovered() || response.dragged() || response.has_focus();
        marks::handle(&ui.painter_at(rect), self.at, self.shaped, is_active);
        let response = response.on_hover_cursor(CursorIcon::Grab);
        // Who drags it knows what it is.
        if response.dragged() {
            return Some(response);
        }
        Some(response.on_hover_text(self.meaning))
    }
}

/// How far arrow keys and what stands in for them move a handle that has the focus: to the right, and up.
pub(super) fn keyed(ui: &Ui, response: &Response) -> [f32; 2] {
    let id = response.id;
    let mut steps = [0.0; 2];
    if response.has_focus() {
        let arrows = EventFilter {
            horizontal_arrows: true,
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(id, arrows));
        ui.input(|input| {
            for (key, [right, up]) in [
                (Key::ArrowRight, [1.0, 0.0]),
                (Key::ArrowLeft, [-1.0, 0.0]),
                (Key::ArrowUp, [0.0, 1.0]),
                (Key::ArrowDown, [0.0, -1.0]),
            ] {
                if input.key_pressed(key) {
                    steps[0] += right;
                    steps[1] += up;
                }
            }
        });
    }
    for (action, sign) in [(Action::Increment, 1.0), (Action::Decrement, -1.0)] {
        if ui.input(|input| input.has_accesskit_action_request(id, action)) {
            steps[0] += sign;
        }
    }
    steps
}

/// Where the pointer took hold, from there to the handle's middle.
pub(super) fn offset(ui: &Ui, at: Pos2) -> Vec2 {
    let pressed = ui.input(|input| input.pointer.press_origin());
    pressed.map_or(Vec2::ZERO, |pressed| at - pressed)
}

impl Hand {
    /// Handles on the chosen node of a level.
    pub(super) fn handles(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        level: Level<'_>,
        orders: &mut Vec<Order>,
    ) {
        let Ok(species) = &scene.document.reading().species else {
            self.held = None;
            return;
        };
        // The button may be let go of where the handle is not to be seen.
        let is_up = ui.input(|i| !i.pointer.any_down() && !i.pointer.any_released());
        if is_up
            && self
                .held
                .as_ref()
                .is_some_and(|held| !held.following.is_released)
        {
            self.rest(orders);
        }
        self.held.take_if(|held| held.following.is_over(scene));
        let chosen = self.chosen.as_ref().filter(|c| c.level == level.index);
        let node = scene.tree().zip(chosen).and_then(|(tree, chosen)| {
            let node = placed(tree, &chosen.way)?;
            (usize::from(node.link.level) == level.index).then_some((tree, node))
        });
        let mut made = node.map_or_else(handles::Handles::default, |(tree, node)| {
            let tip = tip(tree, &node);
            let on_trunk = is_trunk(tree, node.parent_level);
            let moved = species.habit == Habit::Forest && on_trunk;
            handles::of(&node, tip, level.node, moved, &scene.view)
        });
        if let Some(held) = &self.held {
            made.handles
                .retain(|handle| handle.sets != held.handle.sets);
            made.handles.push(held.handle.clone());
            if let (Sets::Down, Some([_, tip])) = (held.handle.sets, &mut made.arm) {
                *tip = held.handle.track.at(held.place);
            }
        }
        let painter = ui.painter_at(scene.view.rect);
        let thin = Stroke::new(1.0, marks::SELECTED.gamma_multiply(0.7));
        marks::line(&painter, &scene.view, &made.ring, thin);
        marks::line(&painter, &scene.view, &made.span, thin);
        if let Some(arm) = &made.arm {
            marks::line(&painter, &scene.view, arm, thin);
        }
        for handle in &made.handles {
            self.handle(ui, scene, (handle, level.path), orders);
        }
    }

    fn handle(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        (handle, level): (&Handle, &str),
        orders: &mut Vec<Order>,
    ) {
        let view = &scene.view;
        let held = self.held.as_ref().filter(|h| h.handle.sets == handle.sets);
        let place = held.map_or(handle.place, |held| held.place);
        let Some(at) = view.place(handle.track.at(place)) else {
            return;
        };
        let grip = Grip {
            id: ui.scope_id().with(("handle", handle.sets)),
            at,
            shaped: match handle.sets {
                Sets::Down | Sets::Around => Shaped::Round,
                Sets::Start | Sets::End => Shaped::Diamond,
            },
            label: &handle.label(),
            value: Some(handle.value(place)),
            meaning: &handle.meaning(),
        };
        let Some(response) = grip.ui(ui, view.rect) else {
            return;
        };
        if response.drag_started() {
            self.held = Some(Held {
                handle: handle.clone(),
                place,
                off: offset(ui, at),
                following: Following::default(),
            });
        }
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
            && let Some(held) = &mut self.held
        {
            let to = handle.track.nearest(view, pointer + held.off, held.place);
            let to = handle.within(to);
            if to.to_bits() != held.place.to_bits() {
                held.place = to;
                orders.push(Order::Change(handle.change(level, to)));
            }
            write(
                ui,
                at + vec2(12.0, -12.0),
                Align2::LEFT_BOTTOM,
                &handle.told(to),
            );
        }
        let steps: f32 = keyed(ui, &response).iter().sum();
        if steps != 0.0 && self.held.is_none() {
            let to = handle.within(place + steps * handle.sets.step());
            orders.push(Order::Change(handle.change(level, to)));
        }
        if response.drag_stopped() || response.lost_focus() {
            self.rest(orders);
        }
    }

    /// The envelope of a level whose branches stand on the trunk.
    pub(super) fn crown(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        level: Level<'_>,
        orders: &mut Vec<Order>,
    ) {
        let (Ok(species), Some(tree)) = (&scene.document.reading().species, scene.tree()) else {
            return;
        };
        // A tree of another age or habit has another envelope than the script says.
        let as_written = species.age.to_bits() == 1.0_f32.to_bits() && species.habit == Habit::Open;
        let on_trunk =
            tree.levels[level.index].parent == Some(0) && tree.levels[0].kind == Kind::Branch;
        let Some(crown) = Crown::of(level.node).filter(|_| as_written && on_trunk) else {
            return;
        };
        let view = &scene.view;
        if !Crown::is_seen(view) {
            return;
        }
        let painter = ui.painter_at(view.rect);
        for side in [1.0, -1.0] {
            let stroke = Stroke::new(1.5, marks::SELECTED);
            marks::line(&painter, view, &crown.profile(view, side), stroke);
        }
        self.top(ui, scene, (&crown, level.path), orders);
        for point in 0..crown.count() {
            for (side, name) in [(1.0, "right"), (-1.0, "left")] {
                let place = crown.place(view, point, side).and_then(|p| view.place(p));
                let Some(at) = place else {
                    continue;
                };
                let told = crown.told(point);
                let grip = Grip {
                    id: ui.scope_id().with(("crown", point, name)),
                    at,
                    shaped: Shaped::Round,
                    label: &format!("Envelope point {}, {name}", point + 1),
                    value: Some(crown.value(point)),
                    meaning: &format!(
                        "The envelope that the tips stay within: {told}\nDrag it, or use the arrow keys."
                    ),
                };
                let Some(response) = grip.ui(ui, view.rect) else {
                    continue;
                };
                let before = crown.clone();
                let mut after = None;
                if response.dragged()
                    && let Some(pointer) = response.interact_pointer_pos()
                {
                    after = crown.dragged(view, (point, side), pointer);
                    write(ui, at + vec2(12.0, -12.0), Align2::LEFT_BOTTOM, &told);
                }
                let [right, up] = keyed(ui, &response).map(f64::from);
                if right != 0.0 || up != 0.0 {
                    after = Some(crown.nudged(point, [up * 0.01, right * 0.05]));
                }
                if let Some(after) = after.filter(|after| *after != before) {
                    orders.push(Order::Change(after.change(level.path)));
                }
                if response.drag_stopped() || response.lost_focus() {
                    self.rest(orders);
                }
            }
        }
    }
}

impl Hand {
    /// The handle that raises an envelope's top.
    fn top(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        (crown, level): (&Crown, &str),
        orders: &mut Vec<Order>,
    ) {
        let view = &scene.view;
        let ends = crown.top(view);
        let Some(mut at) = view.place(ends[1]) else {
            return;
        };
        // The top may be above the picture, and is lowered from its edge then.
        at.y = at.y.max(view.rect.top() + GRIP);
        let painter = ui.painter_at(view.rect);
        marks::line(&painter, view, &ends, Stroke::new(1.5, marks::SELECTED));
        let told = format!("height {} m", number(crown.height()));
        let grip = Grip {
            id: ui.scope_id().with("crown top"),
            at,
            shaped: Shaped::Diamond,
            label: "Height of the envelope",
            value: Some(crown.height()),
            meaning: &format!(
                "The top of the envelope that the tips stay within: {told}\nDrag it, or use the arrow keys."
            ),
        };
        let Some(response) = grip.ui(ui, view.rect) else {
            return;
        };
        let mut after = None;
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let pressed = ui.input(|input| input.pointer.press_origin());
            let begun = response.id.with("height");
            if response.drag_started() {
                ui.data_mut(|data| data.insert_temp(begun, crown.height()));
            }
            let height = ui.data(|data| data.get_temp(begun));
            after = height
                .zip(pressed)
                .and_then(|(height, from)| crown.raised(view, height, [from, pointer]));
            write(ui, at + vec2(12.0, 12.0), Align2::LEFT_TOP, &told);
        }
        let steps: f32 = keyed(ui, &response).iter().sum();
        if steps != 0.0 {
            after = Some(crown.as_high_as(crown.height() + f64::from(steps) * 0.1));
        }
        if let Some(after) = after.filter(|after| after != crown) {
            orders.push(Order::Change(after.change_of_height(level)));
        }
        if response.drag_stopped() || response.lost_focus() {
            self.rest(orders);
        }
    }
}

/// Where a node ends.
fn tip(tree: &Tree, node: &super::picking::Placed<'_>) -> Vec3 {
    let link = node.link;
    let own = tree.prototype(usize::from(link.level), usize::from(link.prototype));
    let tip = match &own.part {
        Part::Branch(branch) => branch.axis.last().map_or(Vec3::Y, |s| s.position),
        Part::Leaf { length, .. } => Vec3::Y * *length,
        Part::Stool => Vec3::ZERO,
    };
    node.place.point(tip)
}

/// True for the level of trunks.
fn is_trunk(tree: &Tree, level: usize) -> bool {
    let parent = tree.levels[level].parent;
    parent.is_none_or(|parent| tree.levels[parent].kind == Kind::Stool)
}

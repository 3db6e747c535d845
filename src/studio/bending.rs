//! The points of a spline in the picture: handles on a branch that was grown from it, moved in the picture's plane.

use super::app::Order;
use super::bearer::Bearer;
use super::girth::Girth;
use super::grips::{Following, Grip, keyed, offset};
use super::hand::{Hand, Scene, Spline, metres};
use super::marks::{self, Shaped};
use super::spline_editor::{Editor, Touch, written};
use crate::math::Vec3;
use crate::viewer::write;
use eframe::egui::{
    Align2, CursorIcon, Key, PointerButton, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo, vec2,
};

/// Edge of the square in which the line takes a double click, points.
const GRIP: f32 = 14.0;

/// What is done to a spline in the picture.
#[derive(Debug, Default)]
pub(super) struct Bending {
    held: Option<Pulled>,
    /// The point that is to have the focus once the tree has followed.
    focus: Option<usize>,
    pub(super) girth: Girth,
}

/// A point that is held.
#[derive(Debug)]
struct Pulled {
    /// Its branch as it was when it was taken hold of.
    from: Bearer,
    /// And as it is to be; the tree that follows lags behind.
    bent: Bearer,
    point: usize,
    /// Where it was drawn to.
    to: Vec3,
    /// From the pointer to the handle's middle.
    off: Vec2,
    following: Following,
}

/// What handles are made from.
#[derive(Clone, Copy)]
struct Bent<'a> {
    spline: Spline<'a>,
    editor: &'a Editor<'a>,
    bearer: &'a Bearer,
}

impl Hand {
    /// The line and the points of a spline on the chosen branch.
    pub(super) fn bend(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        spline: Spline<'_>,
        orders: &mut Vec<Order>,
    ) {
        let is_down = ui.input(|input| input.pointer.any_down());
        self.bending.held.take_if(|held| {
            held.following.is_released |= !is_down;
            held.following.is_over(scene)
        });
        let bearer = || {
            let species = scene.document.reading().species.as_ref().ok()?;
            let editor = Editor::of(spline.path, spline.node)?;
            let branch = (scene.tree()?, &*self.chosen.as_ref()?.way);
            let bearer = Bearer::of(species, branch, (spline.index, &editor))?;
            Some((editor, bearer))
        };
        let Some((editor, bearer)) = bearer() else {
            return;
        };
        let held = self.bending.held.as_ref();
        let bearer = held.map_or(bearer, |held| held.bent.clone());
        let painter = ui.painter_at(scene.view.rect);
        marks::cased(&painter, &scene.view, &bearer.line(), marks::SELECTED);
        let bent = Bent {
            spline,
            editor: &editor,
            bearer: &bearer,
        };
        let mut touches = bent.line(ui, scene);
        let mut focus = None;
        for point in bearer.points() {
            if let Some(response) = self.point(ui, scene, bent, point, &mut touches) {
                let is_free = ui.memory(|memory| memory.focused().is_none());
                if self
                    .bending
                    .focus
                    .take_if(|focus| *focus == point)
                    .is_some()
                    && is_free
                {
                    response.request_focus();
                }
                focus = bent.keys(ui, (&response, point), &mut touches).or(focus);
            }
        }
        self.bending.focus = focus.or(self.bending.focus);
        if self.bending.held.is_none() {
            self.ring(ui, scene, &bearer, orders);
        }
        let changes = touches.into_iter().map(|touch| editor.change(touch));
        orders.extend(changes.map(Order::Change));
    }

    /// The handle of a point, as the pointer moves it.
    fn point(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        bent: Bent<'_>,
        point: usize,
        touches: &mut Vec<Touch>,
    ) -> Option<Response> {
        let (view, bearer) = (&scene.view, bent.bearer);
        let place = bearer.at(point);
        let at = view.place(place)?;
        let radius = metres(bearer.radius(point));
        let label = format!("Point {point} of {}", bent.spline.name);
        let grip = Grip {
            id: ui.scope_id().with(("spline point", point)),
            at,
            shaped: Shaped::Round,
            label: &label,
            value: None,
            meaning: &format!(
                "{label}, where the branch has a radius of {radius}\nDrag it, or use the arrow keys; Insert adds one behind it.\nA right click or Delete takes it away."
            ),
        };
        let response = grip.ui(ui, view.rect)?;
        if response.hovered() || response.dragged() || response.has_focus() {
            self.bending.girth.point = point;
        }
        if response.drag_started_by(PointerButton::Primary) {
            self.bending.held = Some(Pulled {
                from: bearer.clone(),
                bent: bearer.clone(),
                point,
                to: place,
                off: offset(ui, at),
                following: Following::default(),
            });
        }
        let held = self.bending.held.as_mut().filter(|h| h.point == point);
        if response.dragged_by(PointerButton::Primary)
            && let Some(held) = held
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let ray = view.ray(pointer + held.off);
            let to = ray.meets(held.from.at(point), view.camera.forward());
            if let Some(to) = to.filter(|to| *to != held.to) {
                held.to = to;
                held.bent = held.from.bent(point, to);
                touches.push(Touch::Move(point, held.bent.said(point)));
            }
            let words = format!("{}, radius {radius}", written(held.bent.said(point)));
            // Toward the middle, where there is room.
            let (aside, align) = if at.x > view.rect.center().x {
                (-12.0, Align2::RIGHT_BOTTOM)
            } else {
                (12.0, Align2::LEFT_BOTTOM)
            };
            write(ui, at + vec2(aside, -12.0), align, &words);
        }
        if response.drag_stopped() || response.lost_focus() {
            touches.push(Touch::Rest);
        }
        let [right, up] = keyed(ui, &response);
        if (right != 0.0 || up != 0.0) && self.bending.held.is_none() {
            let [x, y] = view.camera.sides();
            let by = (x * right + y * up) * bearer.step();
            touches.push(Touch::Move(point, bearer.nudged(point, by)));
        }
        Some(response)
    }
}

impl Bent<'_> {
    /// A double click on the line adds a point there.
    fn line(&self, ui: &Ui, scene: &Scene<'_>) -> Vec<Touch> {
        let over = scene.response.contains_pointer() && !scene.response.dragged();
        let pointer = ui.input(|input| input.pointer.hover_pos());
        let near = pointer
            .filter(|_| over && !self.bearer.points().is_empty())
            .and_then(|pointer| self.bearer.nearest(&scene.view, pointer));
        let Some((at, span, part)) = near else {
            return Vec::new();
        };
        // It stands before the picture, where a click means what is under it, and a double click frames the tree.
        let place = Rect::from_center_size(at, Vec2::splat(GRIP));
        let id = ui.scope_id().with("spline line");
        let response = ui.interact(place, id, Sense::CLICK);
        response.widget_info(|| {
            let label = format!("Line of {}", self.spline.name);
            WidgetInfo::labeled(Role::Canvas, true, label)
        });
        let response = response.on_hover_cursor(CursorIcon::Crosshair);
        let response = response.on_hover_text("A double click adds a point");
        let point = self.bearer.between(span, part);
        match point.filter(|_| response.double_clicked()) {
            Some(point) => vec![Touch::Add(span + 1, point), Touch::Rest],
            None => Vec::new(),
        }
    }

    /// Adds a point behind one that has the focus, or takes one away. Gives the one that is to have the focus then.
    fn keys(
        &self,
        ui: &Ui,
        (response, point): (&Response, usize),
        touches: &mut Vec<Touch>,
    ) -> Option<usize> {
        let focused = response.has_focus();
        let pressed = |key| focused && ui.input(|input| input.key_pressed(key));
        let count = self.editor.points.len();
        if (response.secondary_clicked() || pressed(Key::Delete)) && count > 2 {
            touches.extend([Touch::Take(point), Touch::Rest]);
            return focused.then_some(point.min(count - 2));
        }
        if pressed(Key::Insert) || pressed(Key::Enter) {
            let new = self.editor.after(point);
            touches.extend([Touch::Add(point + 1, new), Touch::Rest]);
            return Some(point + 1);
        }
        None
    }
}

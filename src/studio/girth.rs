//! The ring about a branch that bears a spline's handles: drawn wider, all branches of its level get thicker.

use super::app::Order;
use super::bearer::Bearer;
use super::curve;
use super::document::Edit;
use super::form::{Change, readable};
use super::grips::{Following, Grip, keyed, offset};
use super::hand::{Hand, Scene, metres};
use super::marks::{self, Shaped};
use super::outline::{self, Section};
use super::parts::number_of;
use crate::math::Vec3;
use crate::species::fields::{BRANCH, Holds, Limits};
use crate::viewer::projection::Projection;
use crate::viewer::write;
use eframe::egui::{Align2, PointerButton, Pos2, Response, Stroke, Ui, Vec2, vec2};

/// Points of the screen from the ring to its handle: the ring of a twig is as small as a point's own handle.
const APART: f32 = 20.0;

/// Part by which a press of an arrow key changes a radius.
const STEP: f64 = 0.02;

/// A radius is written to so many parts of a unit.
const FINEST: f64 = 10_000.0;

/// What a script says of a level's radius.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    /// The level's name.
    level: String,
    /// Path of the field.
    path: String,
    field: &'static str,
    value: f64,
    limits: Limits,
}

impl Said {
    /// That of the level of a tree's branch.
    fn of(scene: &Scene<'_>, level: usize) -> Option<Self> {
        let name = &scene.tree()?.levels.get(level)?.name;
        let mut pages = scene.pages.iter();
        let page = pages.find(|p| p.section == Section::Levels && p.title == *name)?;
        let root = scene.document.reading().root.as_ref()?;
        let node = outline::at(root, &page.path)?;
        ["radius_m", "radius_of_parent"]
            .into_iter()
            .find_map(|field| {
                let Holds::Number(limits) = BRANCH.field(field)?.holds else {
                    return None;
                };
                Some(Self {
                    level: name.clone(),
                    path: format!("{}.{field}", page.path),
                    field,
                    value: number_of(outline::field(node, field)?)?,
                    limits,
                })
            })
    }

    /// A value as it is written: within its limits, and with few digits.
    fn rounded(&self, value: f64) -> f64 {
        let value = (value * FINEST).round() / FINEST;
        value.clamp(self.limits.min.into(), self.limits.max.into())
    }

    fn change(&self, value: f64) -> Change {
        let (path, value) = (self.path.clone(), curve::number(value));
        let name = format!("Set {}", readable(self.field));
        Change::Edit(name, Some(path.clone()), Edit::Set { path, value })
    }
}

/// The ring as it was when it was taken hold of.
#[derive(Debug)]
struct Held {
    said: Said,
    point: usize,
    /// Radius of the tube and how far outside of it the handle stood, metres.
    radius: f32,
    beyond: f32,
    /// Factor on the radius now.
    factor: f32,
    /// From the pointer to the handle's middle.
    off: Vec2,
    following: Following,
}

/// What is done to a radius in the picture.
#[derive(Debug, Default)]
pub(super) struct Girth {
    /// The point whose ring is shown; the first one, if that is gone.
    pub(super) point: usize,
    held: Option<Held>,
}

/// Where the handle of a ring stands.
struct Stand {
    centre: Vec3,
    /// Unit vector across the branch and the line of sight.
    aside: Vec3,
    radius: f32,
    beyond: f32,
}

impl Stand {
    fn of(bearer: &Bearer, point: usize, view: &Projection) -> Self {
        let (centre, radius) = (bearer.at(point), bearer.radius(point));
        Self {
            centre,
            aside: bearer.aside(point, view),
            radius,
            beyond: APART * view.metres_a_point(centre),
        }
    }

    fn at(&self, factor: f32) -> Vec3 {
        self.centre + self.aside * (self.radius * factor + self.beyond)
    }

    /// The factor on the radius with which the handle is under the pointer.
    fn factor(&self, view: &Projection, pointer: Pos2) -> Option<f32> {
        let met = view
            .ray(pointer)
            .meets(self.centre, view.camera.forward())?;
        let radius = (met - self.centre).dot(self.aside) - self.beyond;
        (self.radius > 0.0).then(|| (radius / self.radius).max(0.0))
    }
}

impl Hand {
    /// The ring about one point of a branch, and its handle.
    pub(super) fn ring(
        &mut self,
        ui: &Ui,
        scene: &Scene<'_>,
        bearer: &Bearer,
        orders: &mut Vec<Order>,
    ) {
        let girth = &mut self.bending.girth;
        let is_down = ui.input(|input| input.pointer.any_down());
        girth.held.take_if(|held| {
            held.following.is_released |= !is_down;
            held.following.is_over(scene)
        });
        let points = bearer.points();
        let point = girth.held.as_ref().map_or(girth.point, |held| held.point);
        let point = point.clamp(points.start, points.end.max(points.start + 1) - 1);
        let Some(said) = Said::of(scene, bearer.level).filter(|_| points.contains(&point)) else {
            return;
        };
        let view = &scene.view;
        let mut stand = Stand::of(bearer, point, view);
        let mut factor = 1.0;
        if let Some(held) = &girth.held {
            (stand.radius, stand.beyond, factor) = (held.radius, held.beyond, held.factor);
        }
        let painter = ui.painter_at(view.rect);
        let corners = bearer.ring(point, stand.radius * factor);
        marks::cased(&painter, view, &corners, marks::HOVERED);
        let foot = stand.centre + stand.aside * (stand.radius * factor);
        let arm = [foot, stand.at(factor)];
        marks::line(&painter, view, &arm, Stroke::new(1.0, marks::HOVERED));
        let Some(at) = view.place(arm[1]) else {
            return;
        };
        let told = format!("radius {} here", metres(stand.radius * factor));
        let all = format!("all {} get as much thicker", said.level);
        let doc = BRANCH.field(said.field).map_or("", |field| field.doc);
        let grip = Grip {
            id: ui.scope_id().with("ring"),
            at,
            shaped: Shaped::Diamond,
            label: &format!("Radius at point {point}"),
            value: Some(said.value),
            meaning: &format!("{doc}\n{told}; {all}\nDrag it, or use the arrow keys."),
        };
        let Some(response) = grip.ui(ui, view.rect) else {
            return;
        };
        if response.drag_started_by(PointerButton::Primary) {
            girth.held = Some(Held {
                said: said.clone(),
                point,
                radius: stand.radius,
                beyond: stand.beyond,
                factor: 1.0,
                off: offset(ui, at),
                following: Following::default(),
            });
        }
        let change = girth.drag(view, &response, &stand);
        let change = change.or_else(|| girth.nudge(ui, &response, &said));
        orders.extend(change.map(Order::Change));
        if response.dragged() {
            let at = at + vec2(12.0, -12.0);
            write(ui, at, Align2::LEFT_BOTTOM, &format!("{told}; {all}"));
        }
        if response.drag_stopped() || response.lost_focus() {
            orders.push(Order::Change(Change::Rest));
        }
    }
}

impl Girth {
    fn drag(&mut self, view: &Projection, response: &Response, stand: &Stand) -> Option<Change> {
        let held = self.held.as_mut()?;
        if !response.dragged_by(PointerButton::Primary) {
            return None;
        }
        let pointer = response.interact_pointer_pos()? + held.off;
        let factor = stand.factor(view, pointer)?;
        let value = held.said.rounded(held.said.value * f64::from(factor));
        #[expect(clippy::cast_possible_truncation, reason = "a factor on a radius")]
        let factor = (value / held.said.value) as f32;
        if factor.to_bits() == held.factor.to_bits() {
            return None;
        }
        held.factor = factor;
        Some(held.said.change(value))
    }

    fn nudge(&self, ui: &Ui, response: &Response, said: &Said) -> Option<Change> {
        let steps = f64::from(keyed(ui, response).iter().sum::<f32>());
        if steps == 0.0 || self.held.is_some() {
            return None;
        }
        let step = (said.value * STEP).max(1.0 / FINEST);
        let value = said.rounded(said.value + steps * step);
        (value.to_bits() != said.value.to_bits()).then(|| said.change(value))
    }
}

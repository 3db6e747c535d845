//! The crown envelope of a level over the picture: its profile on both sides of the trunk, with points to drag.

use super::curve::{APART, Curve, number};
use super::document::Edit;
use super::form::Change;
use super::outline;
use super::parts::number_of;
use crate::math::{Vec3, float};
use crate::species::fields::{ENVELOPE, Holds, Limits};
use crate::species::syntax::Node;
use crate::viewer::projection::Projection;
use eframe::egui::Pos2;

/// Lowest top of an envelope, metres.
const LOWEST: f64 = 0.05;

/// Largest radius of an envelope, metres.
const WIDEST: f64 = 200.0;

/// Points of the screen from the top to the handle that raises it: outer points of the profile may meet there.
const ABOVE: f32 = 20.0;

/// Points of the profile as it is drawn.
const POINTS: u32 = 64;

/// A camera that looks down more steeply than this (sine) sees no profile.
const STEEPEST: f32 = 0.9;

/// An envelope as a script says it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Crown {
    height: f64,
    radius: Curve,
}

impl Crown {
    /// The envelope of a level.
    pub(super) fn of(level: &Node) -> Option<Self> {
        let envelope = outline::field(level, "envelope")?;
        let height = number_of(outline::field(envelope, "height_m")?)?;
        let radius = Curve::of(outline::field(envelope, "radius_m")?)?;
        (height > 0.0).then_some(Self { height, radius })
    }

    /// Points that can be dragged: parts of the height, and radii.
    fn points(&self) -> Vec<[f64; 2]> {
        match &self.radius {
            Curve::Flat(radius) => vec![[0.5, *radius]],
            Curve::Points(points) => points.clone(),
        }
    }

    /// How many points can be dragged.
    pub(super) fn count(&self) -> usize {
        self.points().len()
    }

    /// Where a point stands on one side of the trunk: 1 to the right, -1 to the left.
    pub(super) fn place(&self, view: &Projection, point: usize, side: f32) -> Option<Vec3> {
        let [part, radius] = *self.points().get(point)?;
        Some(self.world(view, [part, radius], side))
    }

    #[expect(clippy::cast_possible_truncation, reason = "metres")]
    fn world(&self, view: &Projection, [part, radius]: [f64; 2], side: f32) -> Vec3 {
        let [right, _] = view.camera.sides();
        right * (radius as f32 * side) + Vec3::Y * (part * self.height) as f32
    }

    /// The profile on one side, from the ground to the top.
    pub(super) fn profile(&self, view: &Projection, side: f32) -> Vec<Vec3> {
        let mut parts: Vec<f64> = (0..=POINTS)
            .map(|step| f64::from(float(step) / float(POINTS)))
            .collect();
        parts.extend(self.points().iter().map(|p| p[0]));
        parts.sort_by(f64::total_cmp);
        let mut profile: Vec<Vec3> = parts
            .iter()
            .map(|&part| self.world(view, [part, self.radius.at(part)], side))
            .collect();
        // Nothing stands above the top: the profile closes there.
        profile.push(self.world(view, [1.0, 0.0], side));
        profile
    }

    /// The radius at a point.
    pub(super) fn value(&self, point: usize) -> f64 {
        self.points().get(point).map_or(0.0, |p| p[1])
    }

    /// What is told of a point.
    pub(super) fn told(&self, point: usize) -> String {
        let [part, radius] = self.points().get(point).copied().unwrap_or_default();
        let round = |value: f64| number((value * 100.0).round() / 100.0);
        let height = round(part * self.height);
        format!("radius {} m at a height of {height} m", round(radius))
    }

    /// The point moved under the pointer.
    pub(super) fn dragged(
        &self,
        view: &Projection,
        (point, side): (usize, f32),
        pointer: Pos2,
    ) -> Option<Self> {
        let forward = view.camera.forward();
        let normal = forward.with_y(0.0).normalize_or(Vec3::Z);
        let met = view.ray(pointer).meets(Vec3::ZERO, normal)?;
        let [right, _] = view.camera.sides();
        let radius = f64::from(met.dot(right) * side);
        Some(self.moved(point, [f64::from(met.y) / self.height, radius]))
    }

    /// A point set to a part of the height and a radius, so far as its neighbours and limits let it.
    pub(super) fn moved(&self, point: usize, [part, radius]: [f64; 2]) -> Self {
        let round = |value: f64, to: f64| (value * to).round() / to;
        let radius = round(radius.clamp(0.0, WIDEST), 100.0);
        let mut moved = self.clone();
        match &mut moved.radius {
            Curve::Flat(flat) => *flat = radius,
            Curve::Points(points) => {
                let below = point.checked_sub(1).and_then(|i| points.get(i));
                let low = below.map_or(0.0, |p| p[0] + APART);
                let high = points.get(point + 1).map_or(1.0, |p| p[0] - APART);
                if let Some(at) = points.get_mut(point) {
                    *at = [
                        round(part.clamp(low.min(high), high.max(low)), 1000.0),
                        radius,
                    ];
                }
            }
        }
        moved
    }

    /// A point moved by parts of the height and metres.
    pub(super) fn nudged(&self, point: usize, [part, radius]: [f64; 2]) -> Self {
        let [old_part, old_radius] = self.points().get(point).copied().unwrap_or_default();
        self.moved(point, [old_part + part, old_radius + radius])
    }

    /// What makes a script say this; `level` is the path of the level.
    pub(super) fn change(&self, level: &str) -> Change {
        let path = format!("{level}.envelope.radius_m");
        let value = self.radius.text();
        let gesture = Some(path.clone());
        Change::Edit(
            "Set the envelope".to_owned(),
            gesture,
            Edit::Set { path, value },
        )
    }

    /// Height of the top, metres.
    pub(super) fn height(&self) -> f64 {
        self.height
    }

    /// The top, and the handle over it that raises it.
    #[expect(clippy::cast_possible_truncation, reason = "metres")]
    pub(super) fn top(&self, view: &Projection) -> [Vec3; 2] {
        let top = Vec3::Y * self.height as f32;
        [top, top + Vec3::Y * (ABOVE * view.metres_a_point(top))]
    }

    /// The top of an envelope of some height moved as far as the pointer has gone.
    pub(super) fn raised(&self, view: &Projection, height: f64, way: [Pos2; 2]) -> Option<Self> {
        let normal = view.camera.forward().with_y(0.0).normalize_or(Vec3::Z);
        let [from, to] = way.map(|at| view.ray(at).meets(Vec3::ZERO, normal));
        Some(self.as_high_as(height + f64::from(to?.y - from?.y)))
    }

    /// The same with its top at another height, metres, so far as limits let it.
    pub(super) fn as_high_as(&self, height: f64) -> Self {
        let within = match ENVELOPE.field("height_m").map(|field| field.holds) {
            Some(Holds::Number(Limits { min, max, .. })) => {
                height.clamp(f64::from(min).max(LOWEST), max.into())
            }
            _ => height.max(LOWEST),
        };
        Self {
            height: (within * 100.0).round() / 100.0,
            ..self.clone()
        }
    }

    /// What makes a script say this height; `level` is the path of the level.
    pub(super) fn change_of_height(&self, level: &str) -> Change {
        let path = format!("{level}.envelope.height_m");
        let value = number(self.height);
        let name = "Set the height of the envelope".to_owned();
        Change::Edit(name, Some(path.clone()), Edit::Set { path, value })
    }

    /// True if a camera sees the profile from the side.
    pub(super) fn is_seen(view: &Projection) -> bool {
        view.camera.forward().y.abs() < STEEPEST
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Lens};
    use crate::species::syntax;
    use eframe::egui::{Rect, pos2, vec2};

    fn crown(radius: &str) -> Crown {
        let level = format!("Branch(envelope: (height_m: 10, radius_m: {radius}))");
        Crown::of(&syntax::parse(&level).0.unwrap()).unwrap()
    }

    fn view() -> Projection {
        let camera = Camera {
            eye: Vec3::new(18.0, 7.0, 18.0),
            target: Vec3::new(0.0, 5.0, 0.0),
            lens: Lens::Perspective(0.6),
        };
        Projection::new(
            camera,
            Rect::from_min_size(pos2(0.0, 0.0), vec2(600.0, 500.0)),
        )
    }

    #[test]
    fn a_point_goes_where_it_is_dragged_on_both_sides() {
        let view = view();
        for side in [1.0, -1.0] {
            let crown = crown("[(0, 1), (0.4, 4), (1, 0.5)]");
            let to = crown.world(&view, [0.55, 3.2], side);
            let pointer = view.place(to).unwrap();
            let dragged = crown.dragged(&view, (1, side), pointer).unwrap();
            assert_eq!(dragged.radius.text(), "[(0, 1), (0.55, 3.2), (1, 0.5)]");
            let place = dragged.place(&view, 1, side).unwrap();
            assert!(place.distance(to) < 0.02);
        }
    }

    #[test]
    fn the_top_goes_where_its_handle_is_dragged_and_parts_stay() {
        let view = view();
        let crown = crown("[(0, 1), (0.4, 4), (1, 0.5)]");
        let to = crown.as_high_as(7.5);
        let way = [&crown, &to].map(|crown| view.place(crown.top(&view)[0]).unwrap());
        let raised = crown.raised(&view, crown.height(), way).unwrap();
        assert!((raised.height() - 7.5).abs() < 0.1, "{}", raised.height());
        assert_eq!(raised.radius, crown.radius);
        assert_eq!(crown.as_high_as(-3.0).height(), LOWEST);
        let Change::Edit(_, _, edit) = to.change_of_height("levels.1") else {
            panic!("no edit");
        };
        let path = "levels.1.envelope.height_m".to_owned();
        assert_eq!(
            edit,
            Edit::Set {
                path,
                value: "7.5".to_owned()
            }
        );
    }

    #[test]
    fn points_stay_between_their_neighbours_and_a_number_stays_one() {
        let crown = crown("[(0, 1), (0.4, 4), (1, 0.5)]");
        for (point, to, expected) in [
            (1, [-2.0, 5.0], "[(0, 1), (0.005, 5), (1, 0.5)]"),
            (1, [2.0, -5.0], "[(0, 1), (0.995, 0), (1, 0.5)]"),
            (0, [0.9, 1.0], "[(0.395, 1), (0.4, 4), (1, 0.5)]"),
            (7, [0.9, 1.0], "[(0, 1), (0.4, 4), (1, 0.5)]"),
        ] {
            assert_eq!(crown.moved(point, to).radius.text(), expected);
        }
        let flat = self::crown("3");
        assert_eq!(flat.moved(0, [0.9, 2.5]).radius.text(), "2.5");
        assert_eq!(flat.nudged(0, [0.0, 0.25]).radius.text(), "3.25");
        assert_eq!(flat.count(), 1);
    }
}

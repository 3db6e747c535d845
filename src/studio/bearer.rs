//! A branch of the picture that was grown from a spline, and the way from there back into the script.
//!
//! Growth moves the spline's points by chance (`gnarl`), turns those of a trunk, scales the curve to the branch's
//! length and puts its first point at the base; the node's frame does the rest. All but the chance is undone here: as
//! far as it has moved a point, it moves it again.

use super::picking::placed;
use super::spline_editor::{Editor, rounded};
use crate::math::{Quat, Similarity, TAU, Vec3, float};
use crate::species::schema::{Knots, Species};
use crate::spline::{CatmullRom, SAMPLES_PER_SPAN};
use crate::tree::{AxisSample, Branch, Part, Prototype, Tree};
use crate::viewer::projection::Projection;
use eframe::egui::Pos2;

/// Points of the screen about the line within which it is met.
const REACH: f32 = 6.0;

/// Corners of a ring as it is drawn.
const CORNERS: u32 = 48;

/// A point that moves bends the curve, and a longer curve is scaled down more: so many times the scale is looked for
/// anew. Each time divides what it errs by two or more.
const ROUNDS: usize = 8;

/// A node of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<'a> {
    /// Its level.
    pub(super) level: usize,
    variant: usize,
    prototype: &'a Prototype,
    place: Similarity,
    thickness: f32,
}

impl<'a> Node<'a> {
    pub(super) fn branch(&self) -> Option<&'a Branch> {
        match &self.prototype.part {
            Part::Branch(branch) => Some(branch),
            Part::Stool | Part::Leaf { .. } => None,
        }
    }
}

/// The node that a way of links leads to: the first one, if there are none.
pub(super) fn node<'a>(tree: &'a Tree, way: &[usize]) -> Option<Node<'a>> {
    if way.is_empty() {
        return Some(Node {
            level: 0,
            variant: 0,
            prototype: tree.levels.first()?.prototypes.first()?,
            place: Similarity::IDENTITY,
            thickness: 1.0,
        });
    }
    let placed = placed(tree, way)?;
    let (level, variant) = (placed.link.level.into(), placed.link.prototype.into());
    Some(Node {
        level,
        variant,
        prototype: tree.prototype(level, variant),
        place: placed.place,
        thickness: placed.link.thickness,
    })
}

/// A branch that bears the handles of a spline's points.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bearer {
    /// Its level in the tree.
    pub(super) level: usize,
    place: Similarity,
    thickness: f32,
    axis: Vec<AxisSample>,
    length: f32,
    /// The turn of its own curve.
    turn: Quat,
    /// Metres of its frame that a unit of the spline is.
    unit: f32,
    knots: Knots,
    /// The points as the script has them.
    script: Vec<[f64; 3]>,
    /// And as they are grown, in the spline's unit; none if the branch was not grown from as many.
    control: Vec<Vec3>,
}

impl Bearer {
    /// The node at the end of a way of links, if it was grown from the spline with this number.
    pub(super) fn of(
        species: &Species,
        (tree, way): (&Tree, &[usize]),
        (spline, editor): (usize, &Editor<'_>),
    ) -> Option<Self> {
        let node = node(tree, way)?;
        let branch = node.branch().filter(|b| usize::from(b.spline) == spline)?;
        let raw = long(
            &editor.points.iter().map(single).collect::<Vec<_>>(),
            editor.knots,
        )?;
        let unit = branch.length / raw;
        let spans = editor.points.len() - 1;
        let same = branch.axis.len() == spans * SAMPLES_PER_SPAN + 1;
        let control = branch.axis.iter().step_by(SAMPLES_PER_SPAN);
        Some(Self {
            level: node.level,
            place: node.place,
            thickness: node.thickness,
            axis: branch.axis.clone(),
            length: branch.length,
            turn: tree.own_turn(species, node.level, node.variant),
            unit,
            knots: editor.knots,
            script: editor.points.clone(),
            control: control
                .map(|sample| sample.position / unit)
                .filter(|_| same)
                .collect(),
        })
    }

    /// Its axis in the world.
    pub(super) fn line(&self) -> Vec<Vec3> {
        let places = self.axis.iter().map(|s| self.place.point(s.position));
        places.collect()
    }

    /// The points that can be moved: all but the first, which is the base.
    pub(super) fn points(&self) -> std::ops::Range<usize> {
        1..self.control.len().max(1)
    }

    fn sample(&self, point: usize) -> &AxisSample {
        &self.axis[(point * SAMPLES_PER_SPAN).min(self.axis.len() - 1)]
    }

    /// Where a point stands in the world.
    pub(super) fn at(&self, point: usize) -> Vec3 {
        self.place.point(self.sample(point).position)
    }

    /// Radius of the tube at a point, metres in the world.
    pub(super) fn radius(&self, point: usize) -> f32 {
        self.sample(point).radius * self.place.scale * self.thickness
    }

    /// Unit vector across the axis at a point and across the line of sight, to the right of the picture.
    pub(super) fn aside(&self, point: usize, view: &Projection) -> Vec3 {
        let along = self.place.rotation * self.sample(point).frame * Vec3::Y;
        let [right, _] = view.camera.sides();
        let aside = along.cross(view.camera.forward()).normalize_or(right);
        if aside.dot(right) < 0.0 {
            -aside
        } else {
            aside
        }
    }

    /// The outline of a tube of some radius across the axis at a point.
    pub(super) fn ring(&self, point: usize, radius: f32) -> Vec<Vec3> {
        let centre = self.at(point);
        let frame = self.place.rotation * self.sample(point).frame;
        let arm = Vec3::X * radius;
        (0..=CORNERS)
            .map(|corner| TAU * float(corner) / float(CORNERS))
            .map(|turn| centre + frame * (Quat::from_axis_angle(Vec3::Y, turn) * arm))
            .collect()
    }

    /// What it becomes where a point is moved to a place of the world.
    ///
    /// The last point can be turned to any place, but not drawn out to it: the branch stays as long as it is.
    pub(super) fn bent(&self, point: usize, to: Vec3) -> Self {
        let mut bent = self.clone();
        let Some(&old) = self.control.get(point) else {
            return bent;
        };
        let to = self.place.inverse().point(to);
        let is_last = point + 1 == self.control.len();
        for _ in 0..if is_last { 1 } else { ROUNDS } {
            bent.control[point] = to / bent.unit;
            if let Some(raw) = long(&bent.control, self.knots) {
                bent.unit = (self.length / raw).clamp(self.unit * 0.5, self.unit * 2.0);
            }
        }
        bent.script[point] = self.shifted(point, bent.control[point] - old);
        if let (Some(curve), Some(raw)) = (
            CatmullRom::new(&bent.control, self.knots),
            long(&bent.control, self.knots),
        ) {
            bent.unit = self.length / raw;
            for (sample, at) in bent.axis.iter_mut().zip(curve.samples()) {
                sample.position = at * bent.unit;
            }
        }
        bent
    }

    /// What the script says of a point.
    pub(super) fn said(&self, point: usize) -> [f64; 3] {
        self.script[point]
    }

    /// What the script is to say of a point that is moved by some metres of the world.
    pub(super) fn nudged(&self, point: usize, by: Vec3) -> [f64; 3] {
        let by = self.place.rotation.conjugate() * by;
        self.shifted(point, by / (self.place.scale * self.unit))
    }

    fn shifted(&self, point: usize, by: Vec3) -> [f64; 3] {
        let by = self.turn.conjugate() * by;
        let [x, y, z] = self.script[point];
        [
            rounded(x + f64::from(by.x)),
            rounded(y + f64::from(by.y)),
            rounded(z + f64::from(by.z)),
        ]
    }

    /// How far a press of an arrow key moves a point, metres of the world.
    pub(super) fn step(&self) -> f32 {
        self.length * self.place.scale * 0.01
    }

    /// The part of the line that is under a pointer: where it is seen, after which point, and how far to the next.
    pub(super) fn nearest(&self, view: &Projection, pointer: Pos2) -> Option<(Pos2, usize, f32)> {
        let seen: Vec<Option<Pos2>> = self.line().iter().map(|p| view.place(*p)).collect();
        let mut best: Option<(f32, Pos2, f32)> = None;
        let mut before = 0.0;
        for pair in seen.windows(2) {
            if let [Some(a), Some(b)] = *pair {
                let along = b - a;
                let part = (pointer - a).dot(along) / along.length_sq().max(1e-6);
                let part = part.clamp(0.0, 1.0);
                let at = a + along * part;
                let away = at.distance(pointer);
                if away <= REACH && best.is_none_or(|best| away < best.0) {
                    best = Some((away, at, before + part));
                }
            }
            before += 1.0;
        }
        let (_, at, sample) = best?;
        #[expect(clippy::cast_precision_loss, reason = "a small whole number")]
        let spans = sample / SAMPLES_PER_SPAN as f32;
        let last = self.points().len().checked_sub(1)?;
        let mut span = 0;
        let mut part = spans;
        while part >= 1.0 && span < last {
            span += 1;
            part -= 1.0;
        }
        Some((at, span, part))
    }

    /// The point of the script's own curve at a part of the way from a point to the next.
    pub(super) fn between(&self, span: usize, part: f32) -> Option<[f64; 3]> {
        let control: Vec<Vec3> = self.script.iter().map(single).collect();
        let curve = CatmullRom::new(&control, self.knots)?;
        let point = (span < curve.spans()).then(|| curve.point(span, part))?;
        Some(point.to_array().map(|part| rounded(part.into())))
    }
}

#[expect(clippy::cast_possible_truncation, reason = "coordinates of a spline")]
fn single(point: &[f64; 3]) -> Vec3 {
    Vec3::from(point.map(|part| part as f32))
}

/// Length of the curve through some points, as growth measures it.
fn long(control: &[Vec3], knots: Knots) -> Option<f32> {
    let samples = CatmullRom::new(control, knots)?.samples();
    let long: f32 = samples.windows(2).map(|p| p[0].distance(p[1])).sum();
    (long > 0.0 && long.is_finite()).then_some(long)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Lens};
    use crate::species::{self, NoFiles};
    use crate::studio::document::Document;
    use crate::studio::form::Change;
    use crate::studio::outline;
    use crate::studio::spline_editor::Touch;
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits, grow};
    use eframe::egui::{Rect, pos2, vec2};

    fn bearer(script: &str, spline: usize, way: &[usize]) -> Option<Bearer> {
        let species = species::parse("blank", script, &NoFiles).unwrap();
        let tree = grow(&species, 1, &Limits::default()).unwrap();
        let document = Document::new(script.to_owned());
        let root = document.reading().root.as_ref().unwrap();
        let path = format!("splines.{spline}");
        let editor = Editor::of(&path, outline::at(root, &path).unwrap()).unwrap();
        Bearer::of(&species, (&tree, way), (spline, &editor))
    }

    fn edited(script: &str, spline: usize, touch: Touch) -> String {
        let mut document = Document::new(script.to_owned());
        let root = document.reading().root.clone().unwrap();
        let path = format!("splines.{spline}");
        let editor = Editor::of(&path, outline::at(&root, &path).unwrap()).unwrap();
        let Change::Edit(name, gesture, edit) = editor.change(touch) else {
            panic!("no edit");
        };
        document.apply(&name, gesture.as_deref(), edit).unwrap();
        document.text().to_owned()
    }

    fn view() -> Projection {
        let camera = Camera {
            eye: Vec3::new(9.0, 4.0, 15.0),
            target: Vec3::new(0.0, 3.0, 0.0),
            lens: Lens::Perspective(0.5),
        };
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 800.0));
        Projection::new(camera, rect)
    }

    /// Drags a point by parts of the branch's length to the right and up, and tells how far from there it is grown.
    /// The picture tells it beforehand; where chance has its part, less exactly.
    fn missed(script: &str, spline: usize, way: &[usize], (point, by): (usize, [f32; 2])) -> f32 {
        let told = if script.contains("gnarl") {
            0.05
        } else {
            0.005
        };
        let view = view();
        let before = bearer(script, spline, way).unwrap();
        let reach = before.length * before.place.scale;
        let [right, up] = view.camera.sides();
        let to = before.at(point) + (right * by[0] + up * by[1]) * reach;
        let pointer = view.place(to).unwrap();
        let forward = view.camera.forward();
        let met = view.ray(pointer).meets(before.at(point), forward).unwrap();
        assert!(met.distance(to) < reach * 0.01, "{met} {to}");
        let script = edited(
            script,
            spline,
            Touch::Move(point, before.bent(point, met).said(point)),
        );
        let after = bearer(&script, spline, way).unwrap();
        let bent = before.bent(point, met);
        for other in after.points() {
            let off = bent.at(other).distance(after.at(other));
            assert!(off < reach * told, "{other}: {off} of {reach}");
        }
        let seen = view.place(after.at(point)).unwrap();
        assert!(after.at(point).distance(before.at(point)) > 0.05 * reach);
        seen.distance(pointer) / (reach / view.metres_a_point(to))
    }

    const FOUR: &str =
        "(name: \"limb\", points: [(0, 0, 0), (0.3, 2, 0.2), (0, 4, 0.8), (0.5, 6, 1)])";

    fn four() -> String {
        let limb = "(name: \"limb\", points: [(0, 0, 0), (0.1, 1, 0.1), (0, 2, 0.4)])";
        let script = BLANK.replace(limb, FOUR);
        assert_ne!(script, BLANK);
        script
    }

    #[test]
    fn a_point_is_grown_where_it_was_dragged_to() {
        let script = four();
        // Limbs are turned, scaled and of another length than the spline.
        for way in [[2], [7], [16]] {
            for point in [1, 2] {
                for by in [[0.2, 0.0], [-0.1, 0.15], [0.0, -0.2]] {
                    let missed = missed(&script, 1, &way, (point, by));
                    assert!(missed < 0.01, "{way:?} {point} {by:?}: {missed}");
                }
            }
        }
    }

    #[test]
    fn the_tip_is_turned_to_where_it_was_dragged_to() {
        let before = bearer(&four(), 1, &[7]).unwrap();
        let tip = before.at(3);
        let along = (tip - before.place.translation).normalize_or(Vec3::Y);
        let aside = along.cross(view().camera.forward()).normalize_or(Vec3::X);
        let to = tip + aside * (before.length * before.place.scale * 0.15);
        let script = edited(&four(), 1, Touch::Move(3, before.bent(3, to).said(3)));
        let after = bearer(&script, 1, &[7]).unwrap();
        let reach = before.length * before.place.scale;
        assert!(after.at(3).distance(to) < 0.04 * reach);
        assert!((after.length - before.length).abs() < 1e-4);
    }

    #[test]
    fn chance_and_a_trunks_own_turn_are_kept() {
        let trunk = "radius_m: 0.14,";
        let turned = BLANK.replace(trunk, &format!("{trunk} around: 120,"));
        assert!(missed(&turned, 0, &[], (2, [0.15, 0.05])) < 0.01);
        let gnarled = four().replace("links: 18,", "links: 18, gnarl: 0.04,");
        let missed = missed(&gnarled, 1, &[7], (2, [0.15, 0.05]));
        assert!(missed < 0.05, "{missed}");
    }

    #[test]
    fn a_nudge_moves_a_point_as_far_as_it_says() {
        let before = bearer(BLANK, 1, &[7]).unwrap();
        let by = Vec3::new(0.02, 0.03, -0.01);
        let script = edited(BLANK, 1, Touch::Move(1, before.nudged(1, by)));
        let after = bearer(&script, 1, &[7]).unwrap();
        let moved = after.at(1) - before.at(1);
        assert!(moved.distance(by) < 0.1 * by.length(), "{moved}");
    }

    #[test]
    fn a_point_on_the_line_is_found_under_the_pointer_and_leaves_the_curve_as_it_is() {
        let (before, view) = (bearer(BLANK, 1, &[7]).unwrap(), view());
        let line = before.line();
        let pointer = view.place(line[SAMPLES_PER_SPAN + 6]).unwrap();
        let (at, span, part) = before.nearest(&view, pointer + vec2(1.0, 1.0)).unwrap();
        assert!(at.distance(pointer) < 2.0);
        assert_eq!(span, 1);
        assert!((part - 6.0 / 16.0).abs() < 0.1, "{part}");
        let point = before.between(span, part).unwrap();
        let script = edited(BLANK, 1, Touch::Add(span + 1, point));
        let after = bearer(&script, 1, &[7]).unwrap();
        assert_eq!((before.points(), after.points()), (1..3, 1..4));
        let near = line.iter().map(|p| p.distance(after.at(2)));
        let near = near.fold(f32::MAX, f32::min);
        assert!(near < 0.02 * before.length, "{near}");
        assert_eq!(before.nearest(&view, pointer + vec2(90.0, 90.0)), None);
    }

    #[test]
    fn a_ring_is_as_wide_as_the_tube_and_lies_across_it() {
        let before = bearer(BLANK, 1, &[7]).unwrap();
        let (centre, radius) = (before.at(1), before.radius(1));
        assert!((0.005..0.1).contains(&radius), "{radius}");
        let line = before.line();
        let along = line[SAMPLES_PER_SPAN + 1] - line[SAMPLES_PER_SPAN - 1];
        for corner in before.ring(1, radius) {
            let arm = corner - centre;
            assert!((arm.length() - radius).abs() < 1e-4);
            assert!(
                arm.normalize_or(Vec3::X)
                    .dot(along.normalize_or(Vec3::Y))
                    .abs()
                    < 0.02
            );
        }
    }

    #[test]
    fn other_splines_and_trees_that_lag_behind_have_no_points() {
        assert!(bearer(BLANK, 1, &[]).is_none());
        assert!(bearer(BLANK, 0, &[7]).is_none());
        let species = species::parse("blank", BLANK, &NoFiles).unwrap();
        let tree = grow(&species, 1, &Limits::default()).unwrap();
        let document = Document::new(four());
        let root = document.reading().root.as_ref().unwrap();
        let editor = Editor::of("splines.1", outline::at(root, "splines.1").unwrap()).unwrap();
        let lags = Bearer::of(&species, (&tree, &[7]), (1, &editor)).unwrap();
        assert!(lags.points().is_empty());
        assert_eq!(lags.line().len(), 2 * SAMPLES_PER_SPAN + 1);
    }
}

//! Handles on one node of a level: its angle away from its parent, its turn about it, and where along the parent
//! its level begins and ends.
//!
//! A handle moves along a line in the world; the pointer picks the point of it that is nearest on the screen. So a
//! line that is seen from its end cannot throw a handle far away.

use super::curve;
use super::document::Edit;
use super::form::Change;
use super::outline;
use super::parts::{Parts, number_of};
use super::picking::Placed;
use crate::math::{Quat, TAU, Vec3, float};
use crate::species::fields::{Absent, BRANCH, Holds, Limits};
use crate::species::syntax::{self, Node};
use crate::tree::{Branch, Part};
use crate::viewer::projection::Projection;
use eframe::egui::Pos2;

/// Points of the screen from a node's base to the handle at its tip, at least.
const ARM: f32 = 52.0;

/// Radius of the ring around the parent, points of the screen, at least.
const RING: f32 = 24.0;

/// Of handles nearer to one another than this, points of the screen, one is left out; zooming in brings it back.
const APART: f32 = 13.0;

/// Corners of the ring as it is drawn.
const CORNERS: u32 = 48;

/// How far a handle may go from one frame to the next, degrees; a far side of a circle is no place to leap to.
const LEAP: f32 = 60.0;

/// Points of the screen that a degree is worth: of two places as near to the pointer, that with less turn is meant.
const INERTIA: f32 = 0.05;

/// What a handle sets.
#[derive(Clone, Copy, Debug, Hash, PartialEq, Eq)]
pub(super) enum Sets {
    /// The angle away from the parent's axis.
    Down,
    /// The turn about the parent's axis.
    Around,
    /// Where along the parent the level begins.
    Start,
    /// And where it ends.
    End,
}

impl Sets {
    /// The field's name.
    pub(super) fn field(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Around => "around",
            Self::Start => "start",
            Self::End => "end",
        }
    }

    fn is_angle(self) -> bool {
        matches!(self, Self::Down | Self::Around)
    }

    /// What one press of an arrow key changes.
    pub(super) fn step(self) -> f32 {
        if self.is_angle() { 1.0 } else { 0.01 }
    }
}

/// A line in the world along which a handle moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Track {
    /// A circle; places on it are degrees from where the handle stands.
    Turn {
        pivot: Vec3,
        /// Unit vector.
        axis: Vec3,
        /// From the pivot to the handle.
        arm: Vec3,
    },
    /// A branch's axis; places on it are parts of its length, rising.
    Slide(Vec<(f32, Vec3)>),
}

impl Track {
    /// The point at a place.
    pub(super) fn at(&self, place: f32) -> Vec3 {
        match self {
            Self::Turn { pivot, axis, arm } => {
                *pivot + Quat::from_axis_angle(*axis, place.to_radians()) * *arm
            }
            Self::Slide(points) => {
                let after = points.partition_point(|(t, _)| *t <= place);
                let after = after.clamp(1, points.len().saturating_sub(1).max(1));
                match (points.get(after - 1), points.get(after)) {
                    (Some(&(t0, p0)), Some(&(t1, p1))) => {
                        p0.lerp(p1, ((place - t0) / (t1 - t0)).clamp(0.0, 1.0))
                    }
                    (Some(&(_, point)), _) | (None, Some(&(_, point))) => point,
                    (None, None) => Vec3::ZERO,
                }
            }
        }
    }

    /// The place that is seen nearest to the pointer, for a handle that is at `from` now.
    pub(super) fn nearest(&self, view: &Projection, pointer: Pos2, from: f32) -> f32 {
        let (low, high, step) = match self {
            Self::Turn { .. } => (from - LEAP, from + LEAP, 0.5),
            Self::Slide(_) => (0.0, 1.0, 0.005),
        };
        let cost = |place: f32| {
            let away = view.place(self.at(place))?.distance(pointer);
            let turn = match self {
                Self::Turn { .. } => (place - from).abs() * INERTIA,
                Self::Slide(_) => 0.0,
            };
            Some((place, away + turn))
        };
        let count = crate::math::round_to_u32((high - low) / step);
        let places = (0..=count).map(|index| low + float(index) * step);
        let nearest = places
            .filter_map(cost)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(place, _)| place);
        nearest.unwrap_or(from)
    }
}

/// What a script says of a handle's field.
#[derive(Clone, Debug, PartialEq)]
enum Says {
    /// An angle with all its parts; `here` is where on the parent the handle stands.
    Angle {
        parts: Parts,
        limits: Limits,
        here: f64,
    },
    /// A position, and the least and the most that it may be.
    Position([f32; 2]),
}

/// A handle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Handle {
    pub(super) sets: Sets,
    pub(super) track: Track,
    /// Where on its track it stands.
    pub(super) place: f32,
    says: Says,
}

impl Handle {
    /// True if both would be taken hold of at once.
    fn covers(&self, other: &Self, view: &Projection) -> bool {
        let seen = [self, other].map(|handle| view.place(handle.track.at(handle.place)));
        matches!(seen, [Some(a), Some(b)] if a.distance(b) < APART)
    }

    /// What it is called, for those who do not see it.
    pub(super) fn label(&self) -> String {
        format!("Handle of {}", self.sets.field())
    }

    /// The value that it sets at a place.
    pub(super) fn value(&self, place: f32) -> f64 {
        match &self.says {
            Says::Angle { parts, here, .. } => parts.at.at(*here) + f64::from(place),
            Says::Position(_) => f64::from(place),
        }
    }

    /// The value in words.
    pub(super) fn told(&self, place: f32) -> String {
        let (unit, digits) = if self.sets.is_angle() {
            ("°", 10.0)
        } else {
            ("", 1000.0)
        };
        let value = curve::number((self.value(place) * digits).round() / digits);
        format!("{} {value}{unit}", self.sets.field())
    }

    /// What hovering it tells.
    pub(super) fn meaning(&self) -> String {
        let doc = BRANCH.field(self.sets.field()).map_or("", |f| f.doc);
        let where_it_is = match &self.says {
            Says::Angle { parts, .. } if parts.at.range().0 < parts.at.range().1 => {
                ", here; the whole curve moves along"
            }
            _ => "",
        };
        format!(
            "{doc}\n{}{where_it_is}\nDrag it, or use the arrow keys.",
            self.told(self.place)
        )
    }

    /// A place that it may be at.
    pub(super) fn within(&self, place: f32) -> f32 {
        match &self.says {
            Says::Angle { .. } => place,
            Says::Position([low, high]) => place.clamp(*low, high.max(*low)),
        }
    }

    /// What moving it to a place changes; `level` is the path of its level.
    pub(super) fn change(&self, level: &str, place: f32) -> Change {
        let field = self.sets.field();
        let path = format!("{level}.{field}");
        let value = match &self.says {
            Says::Angle { parts, limits, .. } => parts.shifted(f64::from(place), *limits).text(),
            Says::Position(_) => {
                curve::number((f64::from(self.within(place)) * 1000.0).round() / 1000.0)
            }
        };
        let gesture = Some(path.clone());
        Change::Edit(format!("Set {field}"), gesture, Edit::Set { path, value })
    }
}

/// All handles of a node, and what is drawn with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Handles {
    pub(super) handles: Vec<Handle>,
    /// The ring around the parent.
    pub(super) ring: Vec<Vec3>,
    /// From the node's base to the handle at its tip.
    pub(super) arm: Option<[Vec3; 2]>,
    /// The part of the parent's axis on which the level stands.
    pub(super) span: Vec<Vec3>,
}

/// What a field says, or what it means where it is left out.
fn said(level: &Node, field: &str) -> Option<Node> {
    if let Some(value) = outline::field(level, field) {
        return Some(value.clone());
    }
    match BRANCH.field(field)?.absent {
        Absent::Means(text) => syntax::parse(text).0,
        Absent::Fault | Absent::Special => None,
    }
}

fn angle(level: &Node, sets: Sets, here: f64) -> Option<Says> {
    let Holds::Angle(limits) = BRANCH.field(sets.field())?.holds else {
        return None;
    };
    let parts = Parts::of(&said(level, sets.field())?)?;
    Some(Says::Angle {
        parts,
        limits,
        here,
    })
}

/// The handles of a node. `moved` is true where the positions on the parent are not those of the script.
pub(super) fn of(
    node: &Placed<'_>,
    tip: Vec3,
    level: &Node,
    moved: bool,
    view: &Projection,
) -> Handles {
    let Part::Branch(parent) = &node.on.part else {
        return Handles::default();
    };
    let mut made = Handles::default();
    let base = node.place.translation;
    let sample = parent.at(node.link.at);
    let along = (node.parent.rotation * sample.frame * Vec3::Y).normalize_or(Vec3::Y);
    let centre = node.parent.point(sample.position);
    let direction = (node.place.rotation * Vec3::Y).normalize_or(Vec3::Y);
    let hinge = along.cross(direction);
    let hinge = if hinge.length() > 0.05 {
        hinge.normalize_or(Vec3::X)
    } else {
        // The half turn that puts a child's upper side on top turns its X, too.
        node.place.rotation * Vec3::NEG_X
    };
    let wide = view.metres_a_point(centre);
    let here = f64::from(node.link.at);
    if let Some(says) = angle(level, Sets::Down, here) {
        let reach = tip - base;
        let long = (ARM * wide).max(reach.length());
        let arm = reach.normalize_or(direction) * long;
        made.arm = Some([base, base + arm]);
        made.handles.push(Handle {
            sets: Sets::Down,
            track: Track::Turn {
                pivot: base,
                axis: hinge,
                arm,
            },
            place: 0.0,
            says,
        });
    }
    if let Some(says) = angle(level, Sets::Around, here) {
        let radius = (sample.radius * node.parent.scale * 2.0).max(RING * wide);
        // Behind the parent as seen from the node, where the handle at its tip is not in the way.
        let arm = along.cross(hinge).normalize_or(Vec3::Z) * radius;
        made.ring = (0..=CORNERS)
            .map(|corner| TAU * float(corner) / float(CORNERS))
            .map(|turn| centre + Quat::from_axis_angle(along, turn) * arm)
            .collect();
        made.handles.push(Handle {
            sets: Sets::Around,
            track: Track::Turn {
                pivot: centre,
                axis: along,
                arm,
            },
            place: 0.0,
            says,
        });
    }
    if !moved {
        made.ends(node, parent, level, view);
    }
    made
}

impl Handles {
    /// Handles at the first and the last position on the parent.
    fn ends(&mut self, node: &Placed<'_>, parent: &Branch, level: &Node, view: &Projection) {
        let axis: Vec<(f32, Vec3)> = parent
            .axis
            .iter()
            .map(|sample| (sample.t, node.parent.point(sample.position)))
            .collect();
        #[expect(clippy::cast_possible_truncation, reason = "a part of a length")]
        let part = |field: &str| number_of(&said(level, field)?).map(|value| value as f32);
        let (Some(start), Some(end)) = (part("start"), part("end")) else {
            return;
        };
        let track = Track::Slide(axis);
        self.span = (0..=24_u32)
            .map(|step| track.at(start + (end - start) * float(step) / 24.0))
            .collect();
        for (sets, place, range) in [
            (Sets::Start, start, [0.0, end]),
            (Sets::End, end, [start, 1.0]),
        ] {
            let handle = Handle {
                sets,
                track: track.clone(),
                place,
                says: Says::Position(range),
            };
            if !self.handles.iter().any(|other| other.covers(&handle, view)) {
                self.handles.push(handle);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Lens};
    use crate::species::{self, NoFiles};
    use crate::studio::document::Document;
    use crate::studio::picking::placed;
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits as GrowLimits, Tree, grow};
    use eframe::egui::{Rect, pos2, vec2};

    fn tree(script: &str) -> Tree {
        let species = species::parse("blank", script, &NoFiles).unwrap();
        grow(&species, 1, &GrowLimits::default()).unwrap()
    }

    fn view() -> Projection {
        let camera = Camera {
            eye: Vec3::new(0.0, 3.0, 20.0),
            target: Vec3::new(0.0, 3.0, 0.0),
            lens: Lens::Perspective(0.5),
        };
        let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 800.0));
        Projection::new(camera, rect)
    }

    fn tip(node: &Placed<'_>, tree: &Tree) -> Vec3 {
        let link = node.link;
        let child = tree.prototype(usize::from(link.level), usize::from(link.prototype));
        match &child.part {
            Part::Branch(branch) => node
                .place
                .point(branch.axis[branch.axis.len() - 1].position),
            _ => node.place.point(Vec3::Y),
        }
    }

    fn handles(script: &str, way: &[usize]) -> (Handles, Vec3) {
        let tree = tree(script);
        let node = placed(&tree, way).unwrap();
        let document = Document::new(script.to_owned());
        let root = document.reading().root.as_ref().unwrap();
        let level = outline::at(root, "levels.1").unwrap();
        let tip = tip(&node, &tree);
        (of(&node, tip, level, false, &view()), tip)
    }

    fn find(handles: &Handles, sets: Sets) -> Handle {
        let found = handles.handles.iter().find(|h| h.sets == sets);
        found.unwrap().clone()
    }

    #[test]
    fn a_node_goes_where_its_handles_were_dragged() {
        for (sets, by) in [
            (Sets::Down, 20.0),
            (Sets::Down, -15.0),
            (Sets::Around, 30.0),
        ] {
            let (before, at) = handles(BLANK, &[7]);
            let handle = find(&before, sets);
            let mut document = Document::new(BLANK.to_owned());
            let Change::Edit(name, gesture, edit) = handle.change("levels.1", by) else {
                panic!("no edit");
            };
            document.apply(&name, gesture.as_deref(), edit).unwrap();
            let (after, now) = handles(document.text(), &[7]);
            // The tip turns about the axis that the handle turns about.
            let Track::Turn { pivot, axis, .. } = handle.track else {
                panic!("no turn");
            };
            let turned = pivot + Quat::from_axis_angle(axis, by.to_radians()) * (at - pivot);
            assert!(turned.distance(now) < 0.05, "{sets:?}: {turned} {now}");
            let value = find(&after, sets).value(0.0) - handle.value(0.0);
            assert!((value - f64::from(by)).abs() < 1e-3, "{sets:?} {value}");
        }
    }

    #[test]
    fn the_script_keeps_its_form() {
        let (made, _) = handles(BLANK, &[7]);
        for (sets, place, expected) in [
            (Sets::Down, 5.0, "(at: [(0.3, 75), (1, 30)], vary: 10)"),
            (Sets::Around, -4.0, "(at: -4, step: 137.5)"),
            (Sets::Start, 0.41, "0.41"),
            // Not beyond the end, and no end before the start.
            (Sets::Start, 1.4, "1"),
            (Sets::End, 0.1, "0.3"),
        ] {
            let Change::Edit(_, _, Edit::Set { value, path }) =
                find(&made, sets).change("levels.1", place)
            else {
                panic!("no edit");
            };
            assert_eq!(value, expected);
            assert_eq!(path, format!("levels.1.{}", sets.field()));
        }
    }

    #[test]
    fn the_pointer_finds_the_place_that_it_is_over() {
        let (made, _) = handles(BLANK, &[7]);
        let view = view();
        for handle in &made.handles {
            let (from, to) = if handle.sets.is_angle() {
                (0.0, 12.0)
            } else {
                (handle.place, 0.6)
            };
            let pointer = view.place(handle.track.at(to)).unwrap();
            let found = handle.track.nearest(&view, pointer, from);
            let seen = view.place(handle.track.at(found)).unwrap();
            assert!(seen.distance(pointer) < 2.0, "{:?}: {found}", handle.sets);
        }
    }

    #[test]
    fn no_pointer_makes_a_handle_leap() {
        let (made, _) = handles(BLANK, &[7]);
        let view = view();
        for handle in made.handles.iter().filter(|h| h.sets.is_angle()) {
            for pointer in [pos2(-900.0, 400.0), pos2(1e4, -1e4), view.rect.center()] {
                let found = handle.track.nearest(&view, pointer, 10.0);
                assert!((found - 10.0).abs() <= LEAP, "{found}");
            }
        }
    }
}

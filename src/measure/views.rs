//! From where trees are looked at: held-out views for judging, others for calibrating and choosing.
//!
//! The two sets never mix, or a LOD would be judged from where it was fitted. No held-out view comes within
//! nine degrees of a calibration view or of a capture's axis (`tests` below).

use crate::capture::View;
use crate::math::{Bounds, TAU, Vec3, float};
use core::f32::consts::PI;

/// A direction to look from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Turn about the tree, radians; 0 looks along -Z.
    pub azimuth: f32,
    /// Above the horizon, radians.
    pub elevation: f32,
}

/// Turn from one view to the next, radians: the golden angle, so that any number of views spread evenly.
const GOLDEN: f32 = 2.399_963_2;

/// Elevations of side views, degrees.
const SIDE: [f32; 2] = [-5.0, 30.0];

/// Elevations of aerial views, degrees.
const AERIAL: [f32; 2] = [35.0, 80.0];

/// Turn of the first held-out view, radians. Chosen so that 24 and 12 views stay clear of the calibration
/// views and of the captures' axes.
const HELD_OUT_START: f32 = 5.76;

/// Side views from which LODs are judged.
#[must_use]
pub fn held_out_side(count: usize) -> Vec<Direction> {
    spread(count, SIDE, HELD_OUT_START)
}

/// Aerial views from which LODs are judged.
#[must_use]
pub fn held_out_aerial(count: usize) -> Vec<Direction> {
    spread(count, AERIAL, HELD_OUT_START + 0.7)
}

/// Side views and aerial views from which LODs are calibrated and chosen: as many of each, in proportion, as
/// they are judged from.
const CALIBRATION: [usize; 2] = [8, 4];

/// Turns of the first of them, radians.
const CALIBRATION_START: [f32; 2] = [0.56, 1.43];

/// Views from which LODs are calibrated and chosen.
#[must_use]
pub fn calibration() -> Vec<Direction> {
    let [side, aerial] = CALIBRATION;
    let mut views = spread(side, SIDE, CALIBRATION_START[0]);
    views.extend(spread(aerial, AERIAL, CALIBRATION_START[1]));
    views
}

/// Directions from all around, above and below: for sub-trees, which stand at any angle.
#[must_use]
pub fn sphere(count: usize) -> Vec<Direction> {
    let count = u32::try_from(count).unwrap_or(u32::MAX);
    let direction = |i: u32| {
        let height = 1.0 - 2.0 * (float(i) + 0.5) / float(count);
        Direction {
            azimuth: 0.3 + GOLDEN * float(i),
            elevation: libm::asinf(height),
        }
    };
    (0..count).map(direction).collect()
}

/// `count` directions, evenly spread in azimuth and between two elevations in degrees.
fn spread(count: usize, [low, high]: [f32; 2], start: f32) -> Vec<Direction> {
    let count = u32::try_from(count).unwrap_or(u32::MAX);
    let direction = |i: u32| {
        // Evenly by elevation; an even spread over the sphere's area would look from below too often.
        let degrees = low + (high - low) * (float(i) + 0.5) / float(count);
        let turn = start + GOLDEN * float(i);
        Direction {
            azimuth: turn - (turn / TAU).floor() * TAU,
            elevation: degrees * PI / 180.0,
        }
    };
    (0..count).map(direction).collect()
}

impl Direction {
    /// Right, up and toward the viewer, unit vectors.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 3] {
        let (sine, cosine) = libm::sincosf(self.azimuth);
        let (lift, level) = libm::sincosf(self.elevation);
        let right = Vec3::new(cosine, 0.0, -sine);
        let toward = Vec3::new(sine * level, lift, cosine * level);
        [right, toward.cross(right), toward]
    }

    /// Bounds of points as seen from here: x to the right, y up, z toward the viewer.
    #[must_use]
    pub fn seen(&self, points: impl IntoIterator<Item = Vec3>) -> Bounds {
        let [right, up, toward] = self.axes();
        Bounds::of_points(
            points
                .into_iter()
                .map(|p| Vec3::new(p.dot(right), p.dot(up), p.dot(toward))),
        )
    }

    /// An orthographic view of `seen` bounds with samples `sample` metres apart, and a margin of one
    /// sample.
    #[must_use]
    pub fn view(&self, seen: &Bounds, sample: f32) -> View {
        let [right, up, toward] = self.axes();
        let (middle, size) = (seen.centre(), seen.size());
        let count = |length: f32| crate::math::floor_to_u32(length / sample + 3.0).min(LARGEST);
        let (width, height) = (count(size.x), count(size.y));
        View {
            centre: right * middle.x + up * middle.y + toward * middle.z,
            right,
            up,
            half: [float(width) * sample * 0.5, float(height) * sample * 0.5],
            width,
            height,
        }
    }
}

/// Samples along an edge of a picture at most; a crown many times wider than high is cut there.
const LARGEST: u32 = 16_384;

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees_between(a: &Direction, b: &Direction) -> f32 {
        let cosine = a.axes()[2].dot(b.axes()[2]).clamp(-1.0, 1.0);
        libm::acosf(cosine) * 180.0 / PI
    }

    #[test]
    fn held_out_views_keep_clear_of_calibration_views_and_capture_axes() {
        let mut held_out = held_out_side(24);
        held_out.extend(held_out_aerial(12));
        let mut others = calibration();
        for quarter in 0..4_u16 {
            let azimuth = f32::from(quarter) * TAU / 4.0;
            others.push(Direction {
                azimuth,
                elevation: 0.0,
            });
        }
        for view in &held_out {
            for other in &others {
                let apart = degrees_between(view, other);
                assert!(apart > 9.0, "{view:?} is {apart} degrees from {other:?}");
            }
        }
    }

    #[test]
    fn views_cover_the_elevations_of_the_protocol() {
        let degrees = |d: &Direction| d.elevation * 180.0 / PI;
        let side: Vec<f32> = held_out_side(24).iter().map(degrees).collect();
        assert!(side.iter().all(|e| (-5.0..=30.0).contains(e)));
        assert!(side[0] < -4.0 && side[23] > 29.0, "{side:?}");
        let aerial: Vec<f32> = held_out_aerial(12).iter().map(degrees).collect();
        assert!(aerial.iter().all(|e| (35.0..=80.0).contains(e)));
    }

    #[test]
    fn a_view_holds_what_it_was_framed_for() {
        let direction = held_out_side(5)[2];
        let points = [Vec3::new(-1.0, 0.0, 2.0), Vec3::new(3.0, 7.0, -1.0)];
        let view = direction.view(&direction.seen(points), 0.01);
        for point in points {
            let (at, _) = view.project(point);
            assert!(at.x > 0.9 && at.x < float(view.width) - 0.9, "{at}");
            assert!(at.y > 0.9 && at.y < float(view.height) - 0.9, "{at}");
        }
    }
}

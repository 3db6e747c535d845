//! Trimming: the smallest four-sided outline of what a picture shows.
//!
//! A quad around foliage is mostly air, and an adapter shades the air too. A quad costs two triangles whatever
//! its shape, so its corners may as well lie close to what it shows: the picture stays the same texel by texel,
//! and what is paid for it falls.
//!
//! Idea: Persson, *Graphics Gems for Games: Findings from Avalanche Studios*, 2011 (particle trimming), with
//! polygons of any number of corners. Here they are four, hardly outside of the picture, and the smallest of
//! all that lie along 48 directions.

use crate::math::{TAU, Vec2, float};

/// Corners in a picture that reaches from -1 to 1, y up: lower left, lower right, upper left, upper right.
pub type Corners = [[f32; 2]; 4];

/// The corners of the picture itself.
pub const WHOLE: Corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];

/// Texels of air around what is shown: a filter between two texels reaches as far.
const AIR: f32 = 0.5;

/// Directions of the outline's sides, a multiple of four so that the picture's own are among them.
const SIDES: usize = 48;

/// The corners of the convex outline of least area around all covered texels, at most `over` texels outside of
/// the picture, where nothing may be; of the whole picture if nothing is covered.
#[must_use]
pub fn trimmed(
    (width, height): (u32, u32),
    over: f32,
    is_covered: impl Fn(u32, u32) -> bool,
) -> Corners {
    let places = rim(width, height, is_covered);
    if places.is_empty() {
        return WHOLE;
    }
    let count = |sides: usize| float(u32::try_from(sides).unwrap_or(u32::MAX));
    let normals: [Vec2; SIDES] = core::array::from_fn(|i| {
        let (sine, cosine) = libm::sincosf(TAU * count(i) / count(SIDES));
        Vec2::new(cosine, sine)
    });
    let reaches = normals.map(|n| places.iter().fold(f32::MIN, |reach, p| reach.max(p.dot(n))));
    let farthest = 1.0 + 2.0 * over / Vec2::new(float(width), float(height));
    let meeting = |i: usize, j: usize| {
        let (i, j) = (i % SIDES, j % SIDES);
        meeting((normals[i], reaches[i]), (normals[j], reaches[j]), farthest)
    };
    // By side: those further on whose meeting with it is not too far out, and where.
    let next: Vec<Vec<(usize, Vec2)>> = (0..SIDES)
        .map(|i| {
            let further = i + 1..i + SIDES / 2;
            further.filter_map(|j| Some((j, meeting(i, j)?))).collect()
        })
        .collect();
    let after = |side: usize| {
        let turns = side / SIDES * SIDES;
        next[side % SIDES]
            .iter()
            .map(move |&(j, at)| (j + turns, at))
    };
    let mut best = (f32::INFINITY, None);
    for first in 0..SIDES {
        for (second, a) in after(first) {
            for (third, b) in after(second) {
                for (fourth, c) in after(third).take_while(|&(side, _)| side < first + SIDES) {
                    let back = next[fourth % SIDES]
                        .iter()
                        .find(|&&(side, _)| side % SIDES == first);
                    let Some(&(_, d)) = back else { continue };
                    let area = (c - a).perp_dot(d - b);
                    if area < best.0 {
                        best = (area, Some([a, b, c, d]));
                    }
                }
            }
        }
    }
    best.1.map_or(WHOLE, in_order)
}

/// The outermost corners of the covered texels of each row, with air around them.
fn rim(width: u32, height: u32, is_covered: impl Fn(u32, u32) -> bool) -> Vec<Vec2> {
    let size = Vec2::new(float(width), float(height));
    let mut places = Vec::new();
    for y in 0..height {
        let is_there = |&x: &u32| is_covered(x, y);
        let Some(left) = (0..width).find(is_there) else {
            continue;
        };
        let right = (0..width).rev().find(is_there).unwrap_or(left);
        let (left, right) = (float(left) - AIR, float(right) + 1.0 + AIR);
        for y in [float(y) - AIR, float(y) + 1.0 + AIR] {
            for x in [left, right] {
                let place = Vec2::new(x, y).clamp(Vec2::ZERO, size) / size * 2.0 - 1.0;
                places.push(Vec2::new(place.x, -place.y));
            }
        }
    }
    places
}

/// Where two sides meet, if that is not farther out than `farthest`.
fn meeting((a, reach_a): (Vec2, f32), (b, reach_b): (Vec2, f32), farthest: Vec2) -> Option<Vec2> {
    /// Rounding must not throw out the picture's own corners.
    const ROUNDING: f32 = 1e-4;
    let sine = a.perp_dot(b);
    let at = Vec2::new(reach_a * b.y - reach_b * a.y, reach_b * a.x - reach_a * b.x) / sine;
    let is_near = at.abs().cmple(farthest + ROUNDING).all();
    let snapped = |x: f32| {
        if (x.abs() - 1.0).abs() < ROUNDING {
            x.signum()
        } else {
            x
        }
    };
    is_near.then(|| Vec2::new(snapped(at.x), snapped(at.y)).clamp(-farthest, farthest))
}

/// Corners that go round against the clock, in the order of [`Corners`].
fn in_order(round: [Vec2; 4]) -> Corners {
    let from_lower_left = |i: usize| round[i].x + round[i].y;
    let first = (1..4).fold(0, |first, i| {
        if from_lower_left(i) < from_lower_left(first) {
            i
        } else {
            first
        }
    });
    [0, 1, 3, 2].map(|i| round[(first + i) % 4].to_array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::scan::{Clip, triangle};

    /// Texels that the outline covers, of a picture of 64 by 48.
    fn covered(corners: &Corners) -> Vec<bool> {
        let mut hits = vec![false; 64 * 48];
        let clip = Clip {
            x0: 0,
            y0: 0,
            x1: 64,
            y1: 48,
        };
        let at = |i: usize| {
            let [x, y] = corners[i];
            Vec2::new((x + 1.0) * 32.0, (1.0 - y) * 24.0)
        };
        for corner in [[0, 1, 3], [0, 3, 2]] {
            triangle(corner.map(at), clip, |x, y, _| {
                hits[(y * 64 + x) as usize] = true;
            });
        }
        hits
    }

    fn area(corners: &Corners) -> usize {
        covered(corners).iter().filter(|&&c| c).count()
    }

    #[test]
    fn all_that_is_shown_stays() {
        let mut words = 1_u32;
        let mut next = |below: u32| {
            words = words.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (words >> 8) % below
        };
        for _ in 0..200 {
            let mut shown = vec![false; 64 * 48];
            for _ in 0..1 + next(12) {
                let (x, y) = (next(60), next(40));
                for (dx, dy) in (0..next(5)).flat_map(|dx| (0..8).map(move |dy| (dx, dy))) {
                    shown[((y + dy) * 64 + x + dx) as usize] = true;
                }
            }
            let corners = trimmed((64, 48), 0.0, |x, y| shown[(y * 64 + x) as usize]);
            assert!(corners.iter().flatten().all(|c| c.abs() <= 1.0));
            let covered = covered(&corners);
            assert!(
                shown.iter().zip(&covered).all(|(s, c)| c >= s),
                "{corners:?}"
            );
        }
    }

    #[test]
    fn a_tapering_picture_loses_its_corners() {
        let inside = |x: u32, y: u32| {
            let half = (y + 1) * 24 / 48;
            (32 - half..32 + half).contains(&x)
        };
        let corners = trimmed((64, 48), 0.0, inside);
        // A triangle of 48 by 48 with a texel and a half of air: the box around it is twice as large.
        assert!(area(&corners) < 1500, "{}", area(&corners));
        let [lower_left, _, upper_left, upper_right] = corners;
        assert!(lower_left[0] < -0.7 && lower_left[1] < -0.9);
        assert!(upper_left[0] > -0.2 && upper_right[0] < 0.2);
    }

    #[test]
    fn a_full_picture_and_an_empty_one_keep_their_corners() {
        for corners in [
            trimmed((64, 48), 0.0, |_, _| true),
            trimmed((64, 48), 0.0, |_, _| false),
        ] {
            assert_eq!(corners, WHOLE);
        }
    }

    #[test]
    fn a_stripe_from_corner_to_corner_is_followed() {
        let inside = |x: u32, y: u32| (x * 3).abs_diff(y * 4) < 24;
        let corners = trimmed((64, 48), 12.0, inside);
        assert!(area(&corners) < 64 * 48 / 2, "{}", area(&corners));
        assert!(corners.iter().flatten().any(|c| c.abs() > 1.0));
        // Where the sides would meet outside of the picture, and must not, they stay on its edges.
        assert_eq!(area(&trimmed((64, 48), 0.0, inside)), 64 * 48);
    }
}

//! Planes of the straightened space: wings that hang together at the branch.

use super::super::{Item, Plane, mean_shift};
use crate::math::{PI, TAU, Vec3, float};

/// Rounds of Lloyd's algorithm for wings; few wings settle in a handful.
const ROUNDS: usize = 10;

/// First turns that are tried for wings.
const STARTS: u32 = 6;

/// `count` half planes that hang together at the straightened branch (+Y), or one plane through it: every leaf
/// is on one of them, and the branch itself, what lies within `stem` of the axis, on all. Fewer if there is
/// nothing for some of them.
#[must_use]
pub fn wings(items: &[Item], count: usize, stem: f32) -> Vec<Plane> {
    let on_stem = |item: &Item| {
        let within = |c: &Vec3| c.x * c.x + c.z * c.z <= stem * stem;
        !item.foliage && item.corners.iter().all(within)
    };
    let spread: Vec<&Item> = items.iter().filter(|i| !on_stem(i)).collect();
    if spread.is_empty() || count == 0 {
        return Vec::new();
    }
    let directions = if count == 1 {
        vec![sheet(&spread)]
    } else {
        directions(&spread, count)
    };
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); directions.len()];
    let stems = (0_u32..).zip(items).filter(|(_, i)| on_stem(i));
    let stems: Vec<u32> = stems.map(|(index, _)| index).collect();
    for (index, item) in (0_u32..).zip(items).filter(|(_, i)| !on_stem(i)) {
        members[nearest(&directions, item).0].push(index);
    }
    let parts = directions.into_iter().zip(members);
    let parts: Vec<(Vec3, Vec<u32>)> = parts.filter(|(_, m)| !m.is_empty()).collect();
    let shown = parts.iter().flat_map(|(_, m)| m).chain(&stems);
    let ends = shown.flat_map(|&m| items[m as usize].corners).map(|c| c.y);
    // One span for all, so that wings meet in every row.
    let span = ends.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], y| {
        [low.min(y), high.max(y)]
    });
    let wing = |(direction, mut members): (Vec3, Vec<u32>)| {
        members.extend(&stems);
        members.sort_unstable();
        wing(items, members, direction, span)
    };
    parts.into_iter().map(wing).collect()
}

/// The plane from the branch outward that holds some items.
fn wing(items: &[Item], members: Vec<u32>, out: Vec3, [low, high]: [f32; 2]) -> Plane {
    let shown = || members.iter().map(|&m| &items[m as usize]);
    let across = shown().flat_map(|i| i.corners).map(|c| c.dot(out));
    let (near, far) = across.fold((0.0_f32, 0.0_f32), |(near, far), x| {
        (near.min(x), far.max(x))
    });
    let facing: Vec3 = shown().map(|i| i.normal * i.area).sum();
    let centre = out * ((near + far) * 0.5) + Vec3::Y * ((low + high) * 0.5);
    // The picture shows the leaves' upper sides.
    let right = if out.cross(Vec3::Y).dot(facing) < 0.0 {
        -out
    } else {
        out
    };
    Plane {
        centre,
        right,
        up: Vec3::Y,
        half: [(far - near) * 0.5, (high - low) * 0.5].map(|h| h.max(1e-5)),
        members: Some(members),
    }
}

/// The direction of the plane through +Y that is nearest to items on both sides.
fn sheet(items: &[&Item]) -> Vec3 {
    let (mut even, mut odd) = (0.0_f64, 0.0_f64);
    for item in items {
        let area = f64::from(item.area);
        for c in item.corners {
            even += area * f64::from(c.x * c.x - c.z * c.z);
            odd += area * f64::from(2.0 * c.x * c.z);
        }
    }
    // The main axis of a 2 x 2 matrix is at half the angle of (xx - zz, 2 xz).
    let angle = libm::atan2(odd, even) * 0.5;
    #[expect(clippy::cast_possible_truncation, reason = "an angle")]
    let (sine, cosine) = libm::sincosf(angle as f32);
    Vec3::new(cosine, 0.0, sine)
}

/// Directions of wings: Lloyd's algorithm from some evenly turned starts, the best of them.
fn directions(items: &[&Item], count: usize) -> Vec<Vec3> {
    let count = u32::try_from(count).unwrap_or(1);
    let mut best: Option<(f64, Vec<Vec3>)> = None;
    for start in 0..STARTS {
        let turn = |wing: u32| {
            let part = (float(wing) + float(start) / float(STARTS)) / float(count);
            let (sine, cosine) = libm::sincosf(TAU * part);
            Vec3::new(cosine, 0.0, sine)
        };
        let mut wings: Vec<Vec3> = (0..count).map(turn).collect();
        let mut error = 0.0;
        for round in 0..=ROUNDS {
            let mut sums = vec![Vec3::ZERO; wings.len()];
            error = 0.0;
            for item in items {
                let (wing, miss) = nearest(&wings, item);
                sums[wing] += radial(item.middle()) * item.area;
                error += f64::from(miss) * f64::from(item.area);
            }
            if round < ROUNDS {
                for (wing, sum) in wings.iter_mut().zip(sums) {
                    *wing = sum.normalize_or(*wing);
                }
            }
        }
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, wings));
        }
    }
    best.map(|(_, wings)| wings).unwrap_or_default()
}

fn radial(point: Vec3) -> Vec3 {
    Vec3::new(point.x, 0.0, point.z)
}

/// The wing nearest to an item, and its squared distance from it; the first of equals.
fn nearest(wings: &[Vec3], item: &Item) -> (usize, f32) {
    let at = radial(item.middle());
    let distance = |wing: &Vec3| {
        let along = at.dot(*wing).max(0.0);
        at.length_squared() - along * along
    };
    let mut best = (0, f32::INFINITY);
    for (index, wing) in wings.iter().enumerate() {
        let miss = distance(wing);
        if miss < best.1 {
            best = (index, miss);
        }
    }
    best
}

/// How far items stray from their wings, against items at the same distances evenly around the branch: 0 in the
/// wings, about 1 all around.
#[must_use]
pub fn spread(items: &[Item], wings: &[Plane]) -> f32 {
    let (mut reach, mut area) = (0.0, 0.0);
    for item in items {
        reach += radial(item.middle()).length() * item.area;
        area += item.area;
    }
    // One plane is as good as two wings.
    let sides = float(u32::try_from(wings.len()).unwrap_or(1).max(2));
    let sector = PI / sides;
    let even = (1.0 - libm::cosf(sector)) / sector * reach / area.max(1e-12);
    mean_shift(items, wings) / even.max(1e-12)
}

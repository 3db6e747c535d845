//! Planes fitted to the leaves of one shared prototype: more quads than a cross, each with its own leaves.
//!
//! Home of: Garcia, Sbert, Szirmay-Kalos 2005, "Tree rendering with billboard clouds of leaf clusters".
//! Leaves are grouped by Lloyd's algorithm: each goes to the plane with the least error, and each plane is
//! fitted anew to its leaves.
//!
//! Changes versus the paper: the clustering runs inside one prototype, so that all nodes of a level share
//! its few pictures, where the paper clusters the whole tree once. The plane's normal is the eigenvector of
//! the smallest eigenvalue of the error's matrix, found by Jacobi rotations; the paper's iteration on the
//! inverse finds the eigenvalue nearest to zero, which is another one as soon as the matrix is indefinite.
//! A leaf also pays for its distance from the middle of its cluster, which keeps planes small and overdraw
//! low. Distances are measured at a leaf's corners, not at its middle. Branches take part triangle by
//! triangle.
//!
//! Guarantee: the summed error never rises from one round to the next. Cost: O(items x planes x rounds).

use super::{Item, Plane, largest};
use crate::math::{Mat3, Vec3, symmetric_eigenvectors};

/// How far a leaf may stray from the middle of its cluster: weight of that distance against the distance
/// from the plane. 0 is the paper, whose planes span the whole crown.
const LOCALITY: f32 = 0.22;

/// Weight of a leaf's turn out of the plane (the paper's alpha), in squared radii of the prototype.
const TURN: f32 = 0.004;

/// Rounds of Lloyd's algorithm at most; it settles in about ten.
const ROUNDS: usize = 12;

/// `count` planes fitted to items; fewer if there are fewer items. The order is that of the clusters'
/// seeds, and the same on every machine.
#[must_use]
pub fn fitted(items: &[Item], count: usize) -> Vec<Plane> {
    let count = count.min(items.len());
    if count == 0 {
        return Vec::new();
    }
    let radius = reach(items);
    let mut clusters = seeds(items, count, radius);
    let mut owner = vec![0_usize; items.len()];
    let mut before = f64::INFINITY;
    for _ in 0..ROUNDS {
        let error = assign(items, &clusters, &mut owner, radius);
        reseed(items, &mut clusters, &mut owner, radius);
        if error >= before * 0.999 {
            break;
        }
        before = error;
        for (index, cluster) in clusters.iter_mut().enumerate() {
            if let Some(fit) = fit(items, &owner, index, radius) {
                *cluster = fit;
            }
        }
    }
    (0..count)
        .filter_map(|index| rectangle(items, &owner, index, &clusters[index]))
        .collect()
}

/// A plane through a cluster's middle.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    middle: Vec3,
    normal: Vec3,
}

impl Cluster {
    /// Error of showing an item on this plane, square metres.
    fn error(&self, item: &Item, radius: f32) -> f32 {
        let mut sum = 0.0;
        for corner in item.corners {
            let away = corner - self.middle;
            let off = away.dot(self.normal);
            sum += off * off * (1.0 - LOCALITY) + away.length_squared() * LOCALITY;
        }
        let facing = item.normal.dot(self.normal);
        let turn = item.normal.length_squared() - facing * facing;
        sum * 0.25 + TURN * radius * radius * turn
    }
}

/// Distance of the farthest corner from the mean.
fn reach(items: &[Item]) -> f32 {
    let middle = items.iter().map(Item::middle).sum::<Vec3>() / count(items.len());
    items
        .iter()
        .flat_map(|i| i.corners)
        .map(|c| c.distance_squared(middle))
        .fold(0.0, f32::max)
        .sqrt()
}

#[expect(
    clippy::cast_precision_loss,
    reason = "a mean needs no more than 24 bits"
)]
fn count(n: usize) -> f32 {
    n as f32
}

/// First middles: each the item farthest from those before it.
fn seeds(items: &[Item], wanted: usize, radius: f32) -> Vec<Cluster> {
    let middle = items.iter().map(Item::middle).sum::<Vec3>() / count(items.len());
    let mut nearest: Vec<f32> = items
        .iter()
        .map(|item| item.middle().distance_squared(middle) + radius * radius)
        .collect();
    let mut clusters = Vec::with_capacity(wanted);
    for _ in 0..wanted {
        let farthest = largest(nearest.iter().zip(items).map(|(d, i)| d * i.area.sqrt()));
        let seed = &items[farthest];
        let normal = if seed.normal == Vec3::ZERO {
            Vec3::X
        } else {
            seed.normal
        };
        clusters.push(Cluster {
            middle: seed.middle(),
            normal,
        });
        for (distance, item) in nearest.iter_mut().zip(items) {
            *distance = distance.min(item.middle().distance_squared(seed.middle()));
        }
    }
    clusters
}

/// Gives each item to its best cluster; the summed error by area.
fn assign(items: &[Item], clusters: &[Cluster], owner: &mut [usize], radius: f32) -> f64 {
    let mut sum = 0.0;
    for (item, owner) in items.iter().zip(owner) {
        let mut best = (0, f32::INFINITY);
        for (index, cluster) in clusters.iter().enumerate() {
            let error = cluster.error(item, radius);
            if error < best.1 {
                best = (index, error);
            }
        }
        *owner = best.0;
        sum += f64::from(best.1) * f64::from(item.area);
    }
    sum
}

/// A cluster that lost all its items takes the item with the largest error.
fn reseed(items: &[Item], clusters: &mut [Cluster], owner: &mut [usize], radius: f32) {
    for index in 0..clusters.len() {
        if owner.contains(&index) {
            continue;
        }
        let errors = items
            .iter()
            .zip(owner.iter())
            .map(|(item, &o)| clusters[o].error(item, radius) * item.area);
        let worst = largest(errors);
        owner[worst] = index;
        clusters[index].middle = items[worst].middle();
    }
}

/// The plane of least error for a cluster's items.
fn fit(items: &[Item], owner: &[usize], index: usize, radius: f32) -> Option<Cluster> {
    let members = || {
        items
            .iter()
            .zip(owner)
            .filter(move |&(_, &o)| o == index)
            .map(|(item, _)| item)
    };
    let area: f32 = members().map(|i| i.area).sum();
    if area <= 0.0 {
        return None;
    }
    let middle = members().map(|i| i.middle() * i.area).sum::<Vec3>() / area;
    let mut matrix = Mat3::ZERO;
    for item in members() {
        for corner in item.corners {
            let away = corner - middle;
            matrix += outer(away) * (item.area * 0.25 * (1.0 - LOCALITY));
        }
        matrix += outer(item.normal) * (-TURN * radius * radius * item.area);
    }
    let (_, vectors) = symmetric_eigenvectors(matrix);
    Some(Cluster {
        middle,
        normal: vectors[0],
    })
}

fn outer(v: Vec3) -> Mat3 {
    Mat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Turns tried for the smallest rectangle, over a quarter turn.
const TURNS: u16 = 12;

/// The smallest rectangle of a cluster's plane that holds its items.
fn rectangle(items: &[Item], owner: &[usize], index: usize, cluster: &Cluster) -> Option<Plane> {
    let members: Vec<u32> = (0_u32..)
        .zip(owner)
        .filter(|&(_, &o)| o == index)
        .map(|(item, _)| item)
        .collect();
    if members.is_empty() {
        return None;
    }
    let corners = || {
        members
            .iter()
            .flat_map(|&m| items[m as usize].corners)
            .map(|c| c - cluster.middle)
    };
    let normal = cluster.normal;
    let across = Vec3::Y.cross(normal).normalize_or(Vec3::X);
    let along = normal.cross(across);
    let mut best: Option<(f32, Plane)> = None;
    for turn in 0..TURNS {
        let angle = f32::from(turn) * core::f32::consts::FRAC_PI_2 / f32::from(TURNS);
        let (sine, cosine) = libm::sincosf(angle);
        let right = across * cosine + along * sine;
        let up = along * cosine - across * sine;
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in corners() {
            let at = Vec3::new(corner.dot(right), corner.dot(up), 0.0);
            low = low.min(at);
            high = high.max(at);
        }
        let size = high - low;
        let area = size.x * size.y;
        if best.as_ref().is_none_or(|(least, _)| area < *least) {
            let middle = (low + high) * 0.5;
            best = Some((
                area,
                Plane {
                    centre: cluster.middle + right * middle.x + up * middle.y,
                    right,
                    up,
                    half: [size.x * 0.5, size.y * 0.5].map(|h| h.max(1e-5)),
                    members: None,
                },
            ));
        }
    }
    best.map(|(_, plane)| Plane {
        members: Some(members),
        ..plane
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A card with its middle at `middle`, facing `normal`.
    fn card(middle: Vec3, normal: Vec3, size: f32) -> Item {
        let across = normal.any_orthonormal_vector() * size * 0.5;
        let along = normal.cross(across);
        Item {
            corners: [
                middle - across - along,
                middle + across - along,
                middle - across + along,
                middle + across + along,
            ],
            area: size * size,
            normal,
            indices: 0..0,
            foliage: true,
        }
    }

    fn scattered(count: u64) -> Vec<Item> {
        let key = crate::rng::Key::of_seed(7);
        (0..count)
            .map(|i| {
                let unit = |part: u64| {
                    key.with(i).with(part).unit(crate::rng::Parameter::Texture) * 2.0 - 1.0
                };
                let normal = Vec3::new(unit(3), unit(4), unit(5)).normalize_or(Vec3::Y);
                card(Vec3::new(unit(0), unit(1), unit(2)), normal, 0.1)
            })
            .collect()
    }

    #[test]
    fn leaves_of_two_planes_are_told_apart() {
        let mut items = Vec::new();
        for i in 0..10_u8 {
            for j in 0..10_u8 {
                let (x, y) = (f32::from(i) * 0.1, f32::from(j) * 0.1);
                items.push(card(Vec3::new(x, y, 0.0), Vec3::Z, 0.08));
                items.push(card(Vec3::new(3.0, y, x), Vec3::X, 0.08));
            }
        }
        let planes = fitted(&items, 2);
        assert_eq!(planes.len(), 2);
        for plane in &planes {
            let normal = plane.normal();
            assert!(normal.z.abs() > 0.999 || normal.x.abs() > 0.999, "{normal}");
            assert_eq!(plane.members.as_ref().map(Vec::len), Some(100));
            for &member in plane.members.iter().flatten() {
                for corner in items[member as usize].corners {
                    assert!(corner.distance(plane.flattened(corner)) < 1e-4);
                }
            }
        }
    }

    #[test]
    fn every_item_lies_on_exactly_one_plane_and_inside_its_rectangle() {
        let items = scattered(400);
        let planes = fitted(&items, 9);
        let mut shown = vec![0; items.len()];
        for plane in &planes {
            for &member in plane.members.iter().flatten() {
                shown[member as usize] += 1;
                for corner in items[member as usize].corners {
                    let away = corner - plane.centre;
                    assert!(away.dot(plane.right).abs() <= plane.half[0] + 1e-4);
                    assert!(away.dot(plane.up).abs() <= plane.half[1] + 1e-4);
                }
            }
        }
        assert!(shown.iter().all(|&s| s == 1));
    }

    #[test]
    fn the_error_never_rises_from_round_to_round() {
        let items = scattered(600);
        let radius = reach(&items);
        let mut clusters = seeds(&items, 12, radius);
        let mut owner = vec![0; items.len()];
        let mut before = f64::INFINITY;
        for round in 0..10 {
            let error = assign(&items, &clusters, &mut owner, radius);
            assert!(
                error <= before * (1.0 + 1e-5),
                "round {round}: {error} > {before}"
            );
            before = error;
            for (index, cluster) in clusters.iter_mut().enumerate() {
                if let Some(fit) = fit(&items, &owner, index, radius) {
                    *cluster = fit;
                }
            }
        }
    }

    #[test]
    fn leaves_in_one_plane_get_that_plane_whatever_the_weight_of_turns() {
        // The paper's power iteration on the inverse fails here: the matrix is indefinite.
        let items: Vec<Item> = (0..50_u8)
            .map(|i| {
                let (x, y) = (f32::from(i % 10), f32::from(i / 10) * 3.0);
                card(
                    Vec3::new(x, y, 0.5 * x),
                    Vec3::new(-0.5, 0.0, 1.0).normalize_or(Vec3::Z),
                    0.3,
                )
            })
            .collect();
        let plane = &fitted(&items, 1)[0];
        let facing = plane
            .normal()
            .dot(Vec3::new(-0.5, 0.0, 1.0).normalize_or(Vec3::Z));
        assert!(facing.abs() > 0.9999, "{facing}");
    }

    #[test]
    fn few_and_coinciding_items_do_no_harm() {
        assert!(fitted(&[], 4).is_empty());
        let one = card(Vec3::ONE, Vec3::Y, 0.2);
        assert_eq!(fitted(core::slice::from_ref(&one), 4).len(), 1);
        let same = vec![one; 5];
        let planes = fitted(&same, 3);
        assert!(!planes.is_empty() && planes.iter().all(|p| p.centre.is_finite()));
    }
}

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

use crate::math::{Mat3, Vec3, symmetric_eigenvectors};
use crate::mesh::{Mesh, Primitive};

/// A rectangle in space, with what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Middle, metres in the prototype's frame.
    pub centre: Vec3,
    /// Unit vector to the right of its picture.
    pub right: Vec3,
    /// Unit vector up its picture.
    pub up: Vec3,
    /// Half of its width and height, metres.
    pub half: [f32; 2],
    /// The items that it shows, rising; `None` for all of them.
    pub members: Option<Vec<u32>>,
}

impl Plane {
    /// Unit normal, toward the viewer of its picture.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.right.cross(self.up)
    }

    /// The point of the plane nearest to a point.
    #[must_use]
    pub fn flattened(&self, point: Vec3) -> Vec3 {
        let normal = self.normal();
        point - normal * (point - self.centre).dot(normal)
    }
}

/// How far a leaf may stray from the middle of its cluster: weight of that distance against the distance
/// from the plane. 0 is the paper, whose planes span the whole crown.
const LOCALITY: f32 = 0.22;

/// Weight of a leaf's turn out of the plane (the paper's alpha), in squared radii of the prototype.
const TURN: f32 = 0.004;

/// Rounds of Lloyd's algorithm at most; it settles in about ten.
const ROUNDS: usize = 12;

/// One thing that is shown whole on one plane: a leaf card, or a triangle of a branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Corners, metres; unused ones repeat the last.
    pub corners: [Vec3; 4],
    /// Area, square metres.
    pub area: f32,
    /// Unit normal of a card; zero for branches, which look alike from all sides.
    pub normal: Vec3,
    /// Triangles: a range of indices into the foliage or the bark.
    pub indices: core::ops::Range<usize>,
    /// True for foliage.
    pub foliage: bool,
}

impl Item {
    fn middle(&self) -> Vec3 {
        (self.corners[0] + self.corners[1] + self.corners[2] + self.corners[3]) * 0.25
    }
}

/// The items of a mesh: every leaf card, then every bark triangle.
#[must_use]
pub fn items(mesh: &Mesh) -> Vec<Item> {
    let mut items = cards(&mesh.foliage);
    for (index, corner) in mesh.bark.indices.chunks_exact(3).enumerate() {
        let [a, b, c] = [corner[0], corner[1], corner[2]].map(|i| at(&mesh.bark, i));
        items.push(Item {
            corners: [a, b, c, c],
            area: (b - a).cross(c - a).length() * 0.5,
            normal: Vec3::ZERO,
            indices: index * 3..index * 3 + 3,
            foliage: false,
        });
    }
    items
}

fn at(primitive: &Primitive, index: u32) -> Vec3 {
    Vec3::from(primitive.vertices[index as usize].position)
}

/// Leaf cards: runs of triangles that share vertices.
fn cards(foliage: &Primitive) -> Vec<Item> {
    let mut cards: Vec<Item> = Vec::new();
    let mut highest = None;
    for (triangle, corner) in foliage.indices.chunks_exact(3).enumerate() {
        let lowest = corner[0].min(corner[1]).min(corner[2]);
        let range = triangle * 3..triangle * 3 + 3;
        match cards.last_mut() {
            Some(card) if highest.is_some_and(|h| lowest <= h) => card.indices.end = range.end,
            _ => cards.push(Item {
                corners: [Vec3::ZERO; 4],
                area: 0.0,
                normal: Vec3::ZERO,
                indices: range,
                foliage: true,
            }),
        }
        let top = corner[0].max(corner[1]).max(corner[2]);
        highest = Some(highest.map_or(top, |h: u32| h.max(top)));
    }
    for card in &mut cards {
        let indices = &foliage.indices[card.indices.clone()];
        let mut normal = Vec3::ZERO;
        for corner in indices.chunks_exact(3) {
            let [a, b, c] = [corner[0], corner[1], corner[2]].map(|i| at(foliage, i));
            normal += (b - a).cross(c - a) * 0.5;
        }
        card.area = normal.length();
        card.normal = normal.normalize_or(Vec3::ZERO);
        // The first and last two vertices of a card are its corners, folded or not.
        let low = indices.iter().copied().min().unwrap_or(0);
        let high = indices.iter().copied().max().unwrap_or(0);
        card.corners = [low, (low + 1).min(high), high.max(1) - 1, high].map(|i| at(foliage, i));
    }
    cards
}

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

/// Index of the largest value; the first of equals.
fn largest(values: impl Iterator<Item = f32>) -> usize {
    let mut best = (0, f32::NEG_INFINITY);
    for (index, value) in values.enumerate() {
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
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

/// Mean distance of items from the nearest plane that shows them, by area, metres.
#[must_use]
pub fn mean_shift(items: &[Item], planes: &[Plane]) -> f32 {
    let mut nearest = vec![f32::INFINITY; items.len()];
    for plane in planes {
        let normal = plane.normal();
        let mut see = |index: usize| {
            let away = (items[index].middle() - plane.centre).dot(normal).abs();
            nearest[index] = nearest[index].min(away);
        };
        match &plane.members {
            Some(members) => members.iter().for_each(|&m| see(m as usize)),
            None => (0..items.len()).for_each(see),
        }
    }
    let (mut sum, mut area) = (0.0, 0.0);
    for (item, shift) in items.iter().zip(nearest) {
        if shift.is_finite() {
            sum += shift * item.area;
            area += item.area;
        }
    }
    if area > 0.0 { sum / area } else { 0.0 }
}

/// Items that clumps are found from at most; the rest join the nearest.
const CLUMP_SAMPLE: usize = 3000;

/// `count` clumps of neighbouring items, each as two crossed upright planes and, if `level`, a level one, all
/// of which show the whole clump. Where fitted planes lose what is seen edge-on, clumps keep their coverage from
/// all sides; where one cross stands for a whole crown, clumps keep leaves near their places.
#[must_use]
pub fn clumps(items: &[Item], count: usize, turn: f32, level: bool) -> Vec<Plane> {
    let count = count.min(items.len());
    if count == 0 {
        return Vec::new();
    }
    let stride = items.len().div_ceil(CLUMP_SAMPLE);
    let sample: Vec<(Vec3, f32)> = items
        .iter()
        .step_by(stride)
        .map(|i| (i.middle(), i.area))
        .collect();
    let middles = clump_middles(&sample, count);
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); middles.len()];
    for (index, item) in (0_u32..).zip(items) {
        members[nearest(&middles, item.middle())].push(index);
    }
    let (sine, cosine) = libm::sincosf(turn);
    let mut axes = vec![
        (Vec3::new(cosine, 0.0, -sine), Vec3::Y),
        (Vec3::new(-sine, 0.0, -cosine), Vec3::Y),
    ];
    if level {
        axes.push((Vec3::X, Vec3::NEG_Z));
    }
    let shown = members.iter().filter(|m| !m.is_empty());
    shown
        .flat_map(|members| {
            axes.iter()
                .map(|&(right, up)| framed(items, members, right, up))
        })
        .collect()
}

/// Middles of clumps, by Lloyd's algorithm on points with weights.
fn clump_middles(points: &[(Vec3, f32)], count: usize) -> Vec<Vec3> {
    let area: f32 = points.iter().map(|p| p.1).sum();
    let middle = points.iter().map(|p| p.0 * p.1).sum::<Vec3>() / area.max(1e-12);
    let mut far: Vec<f32> = points
        .iter()
        .map(|p| p.0.distance_squared(middle))
        .collect();
    let mut middles = Vec::with_capacity(count);
    for _ in 0..count {
        let seed = points[largest(far.iter().copied())].0;
        middles.push(seed);
        for (far, point) in far.iter_mut().zip(points) {
            *far = far.min(point.0.distance_squared(seed));
        }
    }
    for _ in 0..ROUNDS {
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); count];
        for &(point, weight) in points {
            let sum = &mut sums[nearest(&middles, point)];
            *sum = (sum.0 + point * weight, sum.1 + weight);
        }
        for (middle, (sum, weight)) in middles.iter_mut().zip(sums) {
            if weight > 0.0 {
                *middle = sum / weight;
            }
        }
    }
    middles
}

/// Index of the nearest of some points; the first of equals.
fn nearest(middles: &[Vec3], point: Vec3) -> usize {
    largest(middles.iter().map(|m| -m.distance_squared(point)))
}

/// How much more than leaves branches draw a clump's planes toward themselves.
const STEM_WEIGHT: f32 = 10.0;

/// The plane through the middle of some items that shows them all.
fn framed(items: &[Item], members: &[u32], right: Vec3, up: Vec3) -> Plane {
    let normal = right.cross(up);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (mut depth, mut area) = (0.0, 0.0);
    for &member in members {
        let item = &items[member as usize];
        for corner in item.corners {
            let at = Vec3::new(corner.dot(right), corner.dot(up), 0.0);
            low = low.min(at);
            high = high.max(at);
        }
        // A stem beside its place is seen twice; leaves are not so easily found out.
        let weight = item.area * if item.foliage { 1.0 } else { STEM_WEIGHT };
        depth += item.middle().dot(normal) * weight;
        area += weight;
    }
    let middle = (low + high) * 0.5;
    Plane {
        centre: right * middle.x + up * middle.y + normal * (depth / area.max(1e-12)),
        right,
        up,
        half: [(high.x - low.x) * 0.5, (high.y - low.y) * 0.5].map(|h| h.max(1e-5)),
        members: Some(members.to_vec()),
    }
}

/// Upright planes through a point, evenly turned, and one level plane if `level`: all of them show
/// everything.
#[must_use]
pub fn star(mesh: &Mesh, through: Vec3, upright: u16, turn: f32, level: bool) -> Vec<Plane> {
    let bounds = mesh.bounds();
    let mut planes = Vec::new();
    for index in 0..upright {
        let angle = turn + core::f32::consts::PI * f32::from(index) / f32::from(upright);
        let (sine, cosine) = libm::sincosf(angle);
        let right = Vec3::new(cosine, 0.0, -sine);
        planes.push(whole(mesh, through, right, Vec3::Y));
    }
    if level {
        // At the height at which most of the crown's area lies.
        let (mut sum, mut area) = (0.0, 0.0);
        for item in items(mesh).iter().filter(|i| i.foliage) {
            sum += item.middle().y * item.area;
            area += item.area;
        }
        let height = if area > 0.0 {
            sum / area
        } else {
            bounds.centre().y
        };
        let at = Vec3::new(through.x, height, through.z);
        planes.push(whole(mesh, at, Vec3::X, Vec3::NEG_Z));
    }
    planes
}

/// A plane through a point that shows a whole mesh.
fn whole(mesh: &Mesh, through: Vec3, right: Vec3, up: Vec3) -> Plane {
    let vertices = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for vertex in vertices {
        let point = Vec3::from(vertex.position);
        let at = Vec3::new(point.dot(right), point.dot(up), 0.0);
        low = low.min(at);
        high = high.max(at);
    }
    let middle = (low + high) * 0.5;
    let normal = right.cross(up);
    Plane {
        centre: right * middle.x + up * middle.y + normal * through.dot(normal),
        right,
        up,
        half: [(high.x - low.x) * 0.5, (high.y - low.y) * 0.5].map(|h| h.max(1e-5)),
        members: None,
    }
}

/// The triangles that a plane shows, as a mesh of their own; vertices are not thinned out.
#[must_use]
pub fn part(mesh: &Mesh, items: &[Item], plane: &Plane) -> Mesh {
    let Some(members) = &plane.members else {
        return mesh.clone();
    };
    let mut part = Mesh::default();
    for &member in members {
        let item = &items[member as usize];
        let (from, to) = if item.foliage {
            (&mesh.foliage, &mut part.foliage)
        } else {
            (&mesh.bark, &mut part.bark)
        };
        let indices = &from.indices[item.indices.clone()];
        let low = indices.iter().copied().min().unwrap_or(0);
        let high = indices.iter().copied().max().unwrap_or(0);
        let base = u32::try_from(to.vertices.len()).unwrap_or(u32::MAX);
        if item.foliage {
            to.vertices
                .extend_from_slice(&from.vertices[low as usize..=high as usize]);
            to.indices.extend(indices.iter().map(|i| i - low + base));
        } else {
            to.vertices
                .extend(indices.iter().map(|&i| from.vertices[i as usize]));
            to.indices.extend([base, base + 1, base + 2]);
        }
    }
    part
}

/// What a set of planes looks like at any resolution: each plane's geometry, pressed onto it.
#[must_use]
pub fn pressed(mesh: &Mesh, items: &[Item], planes: &[Plane]) -> Mesh {
    let mut all = Mesh::default();
    for plane in planes {
        let mut flat = part(mesh, items, plane);
        for (from, to) in [
            (&mut flat.bark, &mut all.bark),
            (&mut flat.foliage, &mut all.foliage),
        ] {
            let base = u32::try_from(to.vertices.len()).unwrap_or(u32::MAX);
            for vertex in &mut from.vertices {
                vertex.position = plane.flattened(Vec3::from(vertex.position)).to_array();
            }
            to.vertices.append(&mut from.vertices);
            to.indices.extend(from.indices.iter().map(|i| i + base));
        }
    }
    all
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

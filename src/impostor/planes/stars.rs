//! Planes that show a whole sub-tree, or a whole clump of it, each: seen from any side, something is seen.

use super::{Item, Plane, items, largest};
use crate::math::{PI, Vec3};
use crate::mesh::Mesh;

/// Rounds of Lloyd's algorithm; clumps need not be settled to the last leaf.
const ROUNDS: usize = 12;

/// Items that clumps are found from at most; the rest join the nearest.
const CLUMP_SAMPLE: usize = 3000;

/// `count` clumps of neighbouring items, each as two crossed upright planes and, if `level`, a level one, all
/// of which show the whole clump. Where fitted planes lose what is seen edge-on, clumps keep their coverage from
/// all sides; where one cross stands for a whole crown, clumps keep leaves near their places.
///
/// Unless they must stay `upright`, pictures are turned in their planes so that least of them is air.
#[must_use]
pub fn clumps(
    items: &[Item],
    count: usize,
    turn: f32,
    (level, upright): (bool, bool),
) -> Vec<Plane> {
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
            axes.iter().map(|&(right, up)| {
                if upright {
                    framed(items, members, right, up)
                } else {
                    snug(items, members, right, up)
                }
            })
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

/// The frame of least area in the plane of two axes.
fn snug(items: &[Item], members: &[u32], right: Vec3, up: Vec3) -> Plane {
    /// Turns that are tried over a quarter turn.
    const TURNS: u16 = 12;
    /// A turn must save this part of the area: pictures along the axes are easier to read.
    const SAVES: f32 = 0.03;
    let area = |plane: &Plane| plane.half[0] * plane.half[1];
    let mut best = framed(items, members, right, up);
    let mut least = area(&best) * (1.0 - SAVES);
    for turn in 1..TURNS {
        let (sine, cosine) = libm::sincosf(PI * 0.5 * f32::from(turn) / f32::from(TURNS));
        let (right, up) = (right * cosine + up * sine, up * cosine - right * sine);
        let other = framed(items, members, right, up);
        if area(&other) < least {
            least = area(&other);
            best = other;
        }
    }
    best
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

/// The branch that carries a sub-tree, as planes see it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stem {
    /// Points along its axis, metres.
    pub axis: Vec<Vec3>,
    /// Radius at its base, metres.
    pub radius: f32,
    /// Its triangles: the first of the mesh's bark.
    pub triangles: usize,
}

/// A stem that strays from its plane by more than this many of its radii would be seen twice.
pub const DOUBLED_ABOVE: f32 = 1.5;

impl Stem {
    /// How far the stem bends out of planes of a normal: half of its reach along it, in radii.
    #[must_use]
    pub fn strays(&self, normal: Vec3) -> f32 {
        let along = self.axis.iter().map(|p| p.dot(normal));
        let (low, high) = along.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        (high - low).max(0.0) * 0.5 / self.radius.max(1e-6)
    }
}

/// Upright planes through a point, evenly turned, and one level plane if `level`. All of them show everything,
/// but that a bent `stem` is left to the upright plane that shows it best: on several it would be seen beside
/// itself (Koniaris et al., section IV.D, of the second of two views).
#[must_use]
pub fn star(
    mesh: &Mesh,
    stem: Option<&Stem>,
    (through, upright): (Vec3, u16),
    turn: f32,
    level: bool,
) -> Vec<Plane> {
    let bounds = mesh.bounds();
    let mut planes = Vec::new();
    for index in 0..upright {
        let angle = turn + PI * f32::from(index) / f32::from(upright);
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
    if let Some(stem) = stem {
        leave_stem_to_one(mesh, stem, &mut planes);
    }
    planes
}

/// Takes a bent stem off all planes but the upright one that it strays from the least.
fn leave_stem_to_one(mesh: &Mesh, stem: &Stem, planes: &mut [Plane]) {
    let strays: Vec<f32> = planes.iter().map(|p| stem.strays(p.normal())).collect();
    let is_level = |plane: &Plane| plane.normal().y.abs() > 0.9;
    let fits = planes.iter().zip(&strays);
    let best = largest(fits.map(|(p, s)| if is_level(p) { f32::NEG_INFINITY } else { -s }));
    let items = items(mesh);
    let first = items.iter().position(|i| !i.foliage).unwrap_or(items.len());
    let stems = first..first + stem.triangles;
    let rest: Vec<u32> = (0_u32..)
        .take(items.len())
        .filter(|&i| !stems.contains(&(i as usize)))
        .collect();
    if rest.is_empty() {
        return;
    }
    for (index, plane) in planes.iter_mut().enumerate() {
        if index == best || (strays[index] <= DOUBLED_ABOVE && !is_level(plane)) {
            continue;
        }
        let through = plane.centre;
        let shown = framed(&items, &rest, plane.right, plane.up);
        let normal = plane.normal();
        *plane = Plane {
            centre: shown.centre + normal * (through - shown.centre).dot(normal),
            ..shown
        };
    }
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

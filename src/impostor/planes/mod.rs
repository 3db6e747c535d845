//! Sets of planes that show one shared prototype: more quads than a cross.
//!
//! Stars show everything on each plane, clumps a part of it on two or three, fitted planes each leaf once; strips are
//! planes bent along a branch.

mod fitted;
mod stars;
pub mod strips;

pub use fitted::fitted;
pub use stars::{DOUBLED_ABOVE, Stem, clumps, star};

use crate::math::Vec3;
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

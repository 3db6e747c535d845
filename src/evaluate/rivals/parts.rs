//! Connected parts of a primitive: a leaf card, a tube. What rivals keep or leave out as a whole.

use crate::math::{Vec3, float};
use crate::mesh::{Mesh, Primitive, Vertex};

/// The connected parts of one primitive, numbered by their first triangles. Triangles are connected by
/// shared indices; vertices that only stand at one place connect nothing.
pub(super) struct Parts {
    /// By triangle: its part.
    of_triangle: Vec<u32>,
    /// By part: number of triangles.
    triangles: Vec<u64>,
}

impl Parts {
    /// Finds them by union-find over the vertices.
    pub(super) fn of(primitive: &Primitive) -> Self {
        let mut parents: Vec<u32> = (0..).take(primitive.vertices.len()).collect();
        for corners in primitive.indices.chunks_exact(3) {
            for &other in &corners[1..] {
                let (a, b) = (root(&mut parents, corners[0]), root(&mut parents, other));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
        let mut numbers = vec![UNSEEN; parents.len()];
        let mut parts = Self {
            of_triangle: Vec::with_capacity(primitive.indices.len() / 3),
            triangles: Vec::new(),
        };
        let mut next = 0;
        for corners in primitive.indices.chunks_exact(3) {
            let number = &mut numbers[root(&mut parents, corners[0]) as usize];
            if *number == UNSEEN {
                *number = next;
                next += 1;
                parts.triangles.push(0);
            }
            parts.of_triangle.push(*number);
            parts.triangles[*number as usize] += 1;
        }
        parts
    }

    /// Number of triangles of each part.
    pub(super) fn triangles(&self) -> &[u64] {
        &self.triangles
    }

    /// The parts of `primitive`, whose parts these are, for which `keep` is true; vertices to the bit, all
    /// in their order.
    pub(super) fn kept(&self, primitive: &Primitive, keep: &[bool]) -> Primitive {
        let triangles = primitive.indices.chunks_exact(3).zip(&self.of_triangle);
        let indices = triangles
            .filter(|(_, part)| keep[**part as usize])
            .flat_map(|(corners, _)| corners.iter().copied());
        compact(&primitive.vertices, indices.collect())
    }
}

/// No number yet.
const UNSEEN: u32 = u32::MAX;

/// The root of a vertex' set; halves the path to it.
fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        let grandparent = parents[parents[at as usize] as usize];
        parents[at as usize] = grandparent;
        at = grandparent;
    }
    at
}

/// A primitive of the triangles `indices` with only the vertices that they use, in their order.
pub(super) fn compact(vertices: &[Vertex], mut indices: Vec<u32>) -> Primitive {
    let mut numbers = vec![UNSEEN; vertices.len()];
    for &index in &indices {
        numbers[index as usize] = 0;
    }
    let mut used = Vec::new();
    let mut next = 0;
    for (number, vertex) in numbers.iter_mut().zip(vertices) {
        if *number != UNSEEN {
            *number = next;
            next += 1;
            used.push(*vertex);
        }
    }
    for index in &mut indices {
        *index = numbers[*index as usize];
    }
    Primitive {
        vertices: used,
        indices,
        ..Primitive::default()
    }
}

/// Scales each part of a primitive about the mean of its vertices; only positions change, and none if the
/// factor is 1.
pub(super) fn scale_about_centres(primitive: &mut Primitive, factor: f32) {
    if factor == 1.0 {
        return;
    }
    let parts = Parts::of(primitive);
    let mut of_vertex = vec![UNSEEN; primitive.vertices.len()];
    for (corners, &part) in primitive.indices.chunks_exact(3).zip(&parts.of_triangle) {
        for &corner in corners {
            of_vertex[corner as usize] = part;
        }
    }
    let mut centres = vec![(Vec3::ZERO, 0_u32); parts.triangles.len()];
    for (vertex, &part) in primitive.vertices.iter().zip(&of_vertex) {
        if part != UNSEEN {
            let (sum, count) = &mut centres[part as usize];
            *sum += Vec3::from(vertex.position);
            *count += 1;
        }
    }
    for (sum, count) in &mut centres {
        *sum /= float(*count);
    }
    for (vertex, &part) in primitive.vertices.iter_mut().zip(&of_vertex) {
        if part != UNSEEN {
            let centre = centres[part as usize].0;
            let position = centre + (Vec3::from(vertex.position) - centre) * factor;
            vertex.position = position.to_array();
        }
    }
}

/// The bark's part of a budget: as large a part as the bark is of the full tree, rounded down.
pub(super) fn bark_budget(full: &Mesh, budget: u64) -> u64 {
    let (bark, all) = (full.bark.triangles(), full.triangles());
    if budget >= all {
        return bark;
    }
    let share = u128::from(budget) * u128::from(bark) / u128::from(all);
    // No more than the bark has, so it always fits.
    u64::try_from(share).unwrap_or(bark)
}

#[cfg(test)]
mod tests {
    use super::super::samples::{cards, olive};
    use super::*;

    #[test]
    fn cards_at_one_place_are_parts_of_their_own() {
        let mut foliage = cards(&[2, 4, 2]).foliage;
        let first = foliage.vertices[0].position;
        for vertex in &mut foliage.vertices {
            vertex.position = first;
        }
        let parts = Parts::of(&foliage);
        assert_eq!(parts.triangles(), [2, 4, 2]);
        assert_eq!(parts.of_triangle, [0, 0, 1, 1, 1, 1, 2, 2]);
    }

    #[test]
    fn triangles_joined_late_are_one_part() {
        // Two strips that only the last triangle connects, over their ends.
        let vertices = vec![cards(&[2]).foliage.vertices[0]; 8];
        let primitive = Primitive {
            vertices,
            indices: vec![0, 1, 2, 5, 4, 6, 6, 7, 5, 3, 2, 7],
            ..Primitive::default()
        };
        let parts = Parts::of(&primitive);
        assert_eq!(parts.triangles(), [4]);
        assert!(Parts::of(&Primitive::default()).triangles().is_empty());
    }

    #[test]
    fn all_parts_kept_are_the_primitive() {
        for primitive in [&olive().bark, &olive().foliage] {
            let parts = Parts::of(primitive);
            let keep = vec![true; parts.triangles().len()];
            assert!(parts.kept(primitive, &keep) == *primitive);
            let none = vec![false; keep.len()];
            assert!(parts.kept(primitive, &none) == Primitive::default());
        }
    }

    #[test]
    fn the_olive_falls_into_its_leaves_and_branches() {
        let leaves = Parts::of(&olive().foliage);
        assert!(leaves.triangles().iter().all(|t| [2, 4].contains(t)));
        let branches = Parts::of(&olive().bark);
        assert!(branches.triangles().len() > 10, "trunk and limbs at least");
        assert!(branches.triangles().iter().all(|&t| t > 4));
    }

    #[test]
    fn a_scaled_card_keeps_its_centre_and_all_but_its_positions() {
        let plain = cards(&[2, 4]).foliage;
        let mut large = plain.clone();
        scale_about_centres(&mut large, 3.0);
        let centre = |vertices: &[Vertex]| -> Vec3 {
            let sum: Vec3 = vertices.iter().map(|v| Vec3::from(v.position)).sum();
            sum / float(u32::try_from(vertices.len()).expect("few"))
        };
        for range in [0..4, 4..10] {
            let (a, b) = (&plain.vertices[range.clone()], &large.vertices[range]);
            assert!(centre(a).distance(centre(b)) < 1e-5);
            let edge = |v: &[Vertex]| Vec3::from(v[0].position).distance(v[1].position.into());
            assert!((edge(b) / edge(a) - 3.0).abs() < 1e-4);
            for (a, b) in a.iter().zip(b) {
                assert_eq!((a.normal, a.tangent, a.uv), (b.normal, b.tangent, b.uv));
            }
        }
        assert_eq!(plain.indices, large.indices);
    }

    #[test]
    fn the_bark_gets_its_share_of_the_budget() {
        let mut mesh = cards(&[2, 2, 2]);
        mesh.bark = cards(&[2]).foliage;
        assert_eq!(bark_budget(&mesh, 4), 1);
        assert_eq!(bark_budget(&mesh, 3), 0, "rounded down");
        assert_eq!(bark_budget(&mesh, u64::MAX), 2);
        assert_eq!(bark_budget(&Mesh::default(), 0), 0);
    }
}

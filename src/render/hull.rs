//! The outermost points of a mesh.

use crate::math::{Bounds, Vec3};
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Directions in which the outermost point is looked for.
const DIRECTIONS: u16 = 128;

/// Vertices that are passed over together where their bounds are not far enough out. Those of a twig follow one
/// another, so that bounds are small.
const TOGETHER: usize = 64;

/// The outermost points of a mesh, in directions on a Fibonacci spiral.
pub(super) fn hull(mesh: &Mesh) -> Vec<Vec3> {
    let points: Vec<Vec3> = [&mesh.bark, &mesh.foliage]
        .iter()
        .flat_map(|p| &p.vertices)
        .map(|v| Vec3::from(v.position))
        .collect();
    let groups: Vec<(Bounds, &[Vec3])> = points
        .par_chunks(TOGETHER)
        .map(|group| (Bounds::of_points(group.iter().copied()), group))
        .collect();
    (0..DIRECTIONS)
        .into_par_iter()
        .filter_map(|index| farthest(&groups, direction(index)))
        .collect()
}

fn direction(index: u16) -> Vec3 {
    let y = 1.0 - (f32::from(index) * 2.0 + 1.0) / f32::from(DIRECTIONS);
    let level = (1.0 - y * y).max(0.0).sqrt();
    let (sine, cosine) = libm::sincosf(f32::from(index) * 2.399_963);
    Vec3::new(cosine * level, y, sine * level)
}

/// The last of the points that are farthest out.
fn farthest(groups: &[(Bounds, &[Vec3])], direction: Vec3) -> Option<Vec3> {
    let mut best: Option<(f32, Vec3)> = None;
    for (bounds, group) in groups {
        let reach = bounds.centre().dot(direction) + (bounds.size() * 0.5).dot(direction.abs());
        // Rounding must not pass over a point that is out by as little.
        let slack = 1e-5 * (bounds.min.abs() + bounds.max.abs()).element_sum();
        if best.is_some_and(|(farthest, _)| reach + slack < farthest) {
            continue;
        }
        for &point in *group {
            let out = point.dot(direction);
            if best.is_none_or(|(farthest, _)| out >= farthest) {
                best = Some((out, point));
            }
        }
    }
    best.map(|(_, point)| point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Vertex, WHITE};

    #[test]
    fn groups_that_are_passed_over_hold_no_outermost_point() {
        let mut mesh = Mesh::default();
        for index in 0..5000_u16 {
            let (sine, cosine) = libm::sincosf(f32::from(index) * 0.37);
            let out = f32::from(index % 97) * 0.03;
            let position = [cosine * out, f32::from(index) * 1e-3, sine * out * 2.0];
            mesh.foliage.vertices.push(Vertex {
                position,
                normal: [0.0, 1.0, 0.0],
                tangent: [1.0, 0.0, 0.0, 1.0],
                uv: [0.0; 2],
                tint: WHITE,
            });
        }
        let points = || mesh.foliage.vertices.iter().map(|v| Vec3::from(v.position));
        let by_all = |index: u16| {
            let direction = direction(index);
            points().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
        };
        let expected: Vec<Vec3> = (0..DIRECTIONS).filter_map(by_all).collect();
        assert_eq!(hull(&mesh), expected);
        assert!(hull(&Mesh::default()).is_empty());
    }
}

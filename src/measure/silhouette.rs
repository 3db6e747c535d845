//! Silhouettes: which pixels a mesh covers, and how two of them compare.

use super::views::Direction;
use crate::capture::{ALPHA_CUTOFF, Textures, View, fetch, mip_level};
use crate::image::scan::{self, Clip};
use crate::math::{Bounds, Vec2, Vec3, float};
use crate::mesh::{Mesh, Primitive};

/// Covered pixels of one picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Silhouette {
    /// Pixels across.
    pub width: u32,
    /// True where covered.
    pub covered: Vec<bool>,
}

impl Silhouette {
    /// Covered pixels.
    #[must_use]
    pub fn area(&self) -> u64 {
        self.covered.iter().filter(|&&c| c).count() as u64
    }

    /// Pixels covered in both, and in either.
    ///
    /// # Panics
    /// If the pictures are of different sizes.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> (u64, u64) {
        assert_eq!(self.covered.len(), other.covered.len(), "one view for both");
        let pairs = || self.covered.iter().zip(&other.covered);
        let both = pairs().filter(|(a, b)| **a && **b).count() as u64;
        let either = pairs().filter(|(a, b)| **a || **b).count() as u64;
        (both, either)
    }

    /// Pixels of `n` times `n` samples, covered where at least half of the samples are.
    #[must_use]
    pub fn reduced(&self, n: u32) -> Self {
        let width = self.width / n;
        let rows = self.covered.len() / self.width.max(1) as usize;
        let height = u32::try_from(rows).unwrap_or(u32::MAX) / n;
        let pixel = |x: u32, y: u32| {
            let samples = (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j)));
            let count = samples
                .filter(|&(i, j)| self.covered[j as usize * self.width as usize + i as usize])
                .count();
            2 * count >= (n * n) as usize
        };
        let covered = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect();
        Self { width, covered }
    }
}

/// Draws a silhouette, a sample a pixel of the view: no depth, no surface, hence fast.
#[must_use]
pub fn silhouette(mesh: &Mesh, textures: Textures<'_>, view: &View) -> Silhouette {
    let mut covered = vec![false; view.width as usize * view.height as usize];
    each_triangle(mesh, view, |corners, uv, clip| {
        let mip = uv.map(|uv| &textures.foliage[mip_level(corners, uv, textures.foliage)]);
        scan::triangle(corners, clip, |x, y, b| {
            let at = y as usize * clip.x1 as usize + x as usize;
            if !covered[at] {
                covered[at] = match (uv, mip) {
                    (Some(uv), Some(mip)) => {
                        let at = core::array::from_fn(|k| {
                            uv[0][k] * b[0] + uv[1][k] * b[1] + uv[2][k] * b[2]
                        });
                        fetch(mip, at, true).alpha >= ALPHA_CUTOFF
                    }
                    _ => true,
                };
            }
        });
    });
    Silhouette {
        width: view.width,
        covered,
    }
}

/// Fragments that a rasteriser would shade: every sample of every triangle, transparent ones too.
#[must_use]
pub fn fragments(mesh: &Mesh, view: &View) -> u64 {
    let mut count = 0;
    each_triangle(mesh, view, |corners, _, clip| {
        scan::triangle(corners, clip, |_, _, _| count += 1);
    });
    count
}

/// Projects all triangles: corners in samples, and texture coordinates for foliage.
fn each_triangle(
    mesh: &Mesh,
    view: &View,
    mut visit: impl FnMut([Vec2; 3], Option<[[f32; 2]; 3]>, Clip),
) {
    let clip = Clip {
        x0: 0,
        y0: 0,
        x1: view.width,
        y1: view.height,
    };
    let project = |primitive: &Primitive| -> Vec<Vec2> {
        let vertices = primitive.vertices.iter();
        vertices
            .map(|v| view.project(Vec3::from(v.position)).0)
            .collect()
    };
    let bark = project(&mesh.bark);
    for corner in mesh.bark.indices.chunks_exact(3) {
        visit(
            [corner[0], corner[1], corner[2]].map(|i| bark[i as usize]),
            None,
            clip,
        );
    }
    let foliage = project(&mesh.foliage);
    for corner in mesh.foliage.indices.chunks_exact(3) {
        let corner = [corner[0], corner[1], corner[2]].map(|i| i as usize);
        visit(
            corner.map(|i| foliage[i]),
            Some(corner.map(|i| mesh.foliage.vertices[i].uv)),
            clip,
        );
    }
}

/// Bounds of a mesh as seen from a direction.
#[must_use]
pub fn seen_bounds(mesh: &Mesh, direction: &Direction) -> Bounds {
    let vertices = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
    direction.seen(vertices.map(|v| Vec3::from(v.position)))
}

/// How two silhouettes compare.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Match {
    /// Intersection over union, 0..=1.
    pub iou: f32,
    /// Covered area of the test over the reference's.
    pub coverage: f32,
}

/// Compares a test with its reference. Two empty pictures are equal.
#[must_use]
pub fn compare(reference: &Silhouette, test: &Silhouette) -> Match {
    let (both, either) = reference.overlap(test);
    let ratio = |a: u64, b: u64| {
        let count = |n: u64| float(u32::try_from(n).unwrap_or(u32::MAX));
        if b == 0 {
            if a == 0 { 1.0 } else { f32::INFINITY }
        } else {
            count(a) / count(b)
        }
    };
    Match {
        iou: ratio(both, either),
        coverage: ratio(test.area(), reference.area()),
    }
}

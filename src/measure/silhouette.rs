//! Silhouettes: which pixels meshes cover, and how two of them compare.
//!
//! No depth and no surface, only coverage: several times as fast as a picture, and the silhouette of a whole
//! is the union of the silhouettes of its parts.

use super::views::Direction;
use crate::capture::{ALPHA_CUTOFF, View, fetch};
use crate::image::scan::{self, Clip};
use crate::image::{Image, Texel};
use crate::math::{Bounds, Similarity, Vec2, Vec3, float};
use crate::mesh::{Mesh, Primitive};

/// Which texels of the foliage atlas are there.
///
/// Samples read the finest texels, never mips: then a covered share is right in the mean however far away the
/// tree is, where the alpha test of a mip is right for some parts of an atlas and wrong for others.
#[derive(Clone, Debug)]
pub struct Cutouts(Image<bool>);

impl Cutouts {
    /// Cuts an atlas at the alpha of exported materials.
    #[must_use]
    pub fn of(atlas: &Image<Texel>) -> Self {
        Self(atlas.map(|t| t.alpha >= ALPHA_CUTOFF))
    }

    /// A picture of coverage as a texture.
    #[must_use]
    pub fn from_silhouette(silhouette: Silhouette) -> Self {
        let Silhouette {
            width,
            height,
            covered,
        } = silhouette;
        Self(Image::from_texels(width, height, covered))
    }
}

/// Covered pixels of one picture, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Silhouette {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// True where covered.
    pub covered: Vec<bool>,
}

impl Silhouette {
    /// Nothing covered yet, a pixel a sample of the view.
    #[must_use]
    pub fn empty(view: &View) -> Self {
        Self {
            width: view.width,
            height: view.height,
            covered: vec![false; view.width as usize * view.height as usize],
        }
    }

    /// The silhouette of one mesh.
    #[must_use]
    pub fn of(mesh: &Mesh, cutouts: &Cutouts, view: &View) -> Self {
        let mut silhouette = Self::empty(view);
        silhouette.add(mesh, &Similarity::IDENTITY, cutouts, view);
        silhouette
    }

    /// Adds a mesh, moved to `place`.
    pub fn add(&mut self, mesh: &Mesh, place: &Similarity, cutouts: &Cutouts, view: &View) {
        let covered = &mut self.covered;
        each_triangle(mesh, place, view, |corners, uv, clip| {
            let Some(uv) = uv else {
                scan::triangle(corners, clip, |x, y, _| {
                    covered[y as usize * clip.x1 as usize + x as usize] = true;
                });
                return;
            };
            scan::triangle(corners, clip, |x, y, b| {
                let at = &mut covered[y as usize * clip.x1 as usize + x as usize];
                if !*at {
                    let [u, v] = core::array::from_fn(|k| {
                        uv[0][k] * b[0] + uv[1][k] * b[1] + uv[2][k] * b[2]
                    });
                    *at = *fetch(&cutouts.0, [u, v], true);
                }
            });
        });
    }

    /// Adds what another silhouette of the same view covers.
    pub fn unite(&mut self, other: &Self) {
        for (mine, theirs) in self.covered.iter_mut().zip(&other.covered) {
            *mine |= theirs;
        }
    }

    /// Covered pixels.
    #[must_use]
    pub fn area(&self) -> u64 {
        self.covered.iter().filter(|&&c| c).count() as u64
    }

    /// Pixels covered in one and not in the other.
    #[must_use]
    pub fn difference(&self, other: &Self) -> u64 {
        let (both, either) = self.overlap(other);
        either - both
    }

    /// Pixels covered in both, and in either.
    ///
    /// # Panics
    /// If the pictures are of different sizes.
    #[must_use]
    pub fn overlap(&self, other: &Self) -> (u64, u64) {
        assert_eq!(self.covered.len(), other.covered.len(), "one view for both");
        let (mut both, mut either) = (0, 0);
        for (&a, &b) in self.covered.iter().zip(&other.covered) {
            both += u64::from(a & b);
            either += u64::from(a | b);
        }
        (both, either)
    }

    /// Pixels of `n` times `n` samples, covered where at least half of the samples are.
    #[must_use]
    pub fn reduced(&self, n: u32) -> Self {
        let (width, height) = (self.width / n, self.height / n);
        let pixel = |x: u32, y: u32| {
            let samples = (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j)));
            let count = samples
                .filter(|&(i, j)| self.covered[j as usize * self.width as usize + i as usize])
                .count();
            2 * count >= (n * n) as usize
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            width,
            height,
            covered: pixels.map(|(x, y)| pixel(x, y)).collect(),
        }
    }
}

/// Fragments that a rasteriser would shade: every sample of every triangle, transparent ones too.
#[must_use]
pub fn fragments(mesh: &Mesh, view: &View) -> u64 {
    let mut count = 0;
    each_triangle(mesh, &Similarity::IDENTITY, view, |corners, _, clip| {
        scan::triangle(corners, clip, |_, _, _| count += 1);
    });
    count
}

/// Projects all triangles: corners in samples, and texture coordinates for foliage. Those without a sample
/// in their box are left out.
fn each_triangle(
    mesh: &Mesh,
    place: &Similarity,
    view: &View,
    mut visit: impl FnMut([Vec2; 3], Option<[[f32; 2]; 3]>, Clip),
) {
    let clip = Clip {
        x0: 0,
        y0: 0,
        x1: view.width,
        y1: view.height,
    };
    // The whole way from the mesh to samples as two rows of an affine map.
    let origin = view.project(place.point(Vec3::ZERO)).0;
    let [x, y, z] =
        [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| view.project(place.point(axis)).0 - origin);
    let project = |primitive: &Primitive| -> Vec<Vec2> {
        let point = |[px, py, pz]: [f32; 3]| origin + x * px + y * py + z * pz;
        primitive
            .vertices
            .iter()
            .map(|v| point(v.position))
            .collect()
    };
    let has_samples = |[a, b, c]: [Vec2; 3]| {
        let (low, high) = (a.min(b).min(c) + 0.5, a.max(b).max(c) + 0.5);
        low.x.floor() != high.x.floor() && low.y.floor() != high.y.floor()
    };
    let bark = project(&mesh.bark);
    for corner in mesh.bark.indices.chunks_exact(3) {
        let corners = [corner[0], corner[1], corner[2]].map(|i| bark[i as usize]);
        if has_samples(corners) {
            visit(corners, None, clip);
        }
    }
    let foliage = project(&mesh.foliage);
    for corner in mesh.foliage.indices.chunks_exact(3) {
        let corner = [corner[0], corner[1], corner[2]].map(|i| i as usize);
        let corners = corner.map(|i| foliage[i]);
        if has_samples(corners) {
            visit(
                corners,
                Some(corner.map(|i| mesh.foliage.vertices[i].uv)),
                clip,
            );
        }
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
        match (a, b) {
            (0, 0) => 1.0,
            _ => count(a) / count(b),
        }
    };
    Match {
        iou: ratio(both, either),
        coverage: ratio(test.area(), reference.area()),
    }
}

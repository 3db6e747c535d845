//! Silhouettes: which pixels meshes cover, and how two of them compare.
//!
//! No depth and no surface, only coverage: several times as fast as a picture, and the silhouette of a whole
//! is the union of the silhouettes of its parts.

use super::views::Direction;
use crate::capture::View;
pub use crate::image::cutouts::Cutouts;
use crate::math::{Bounds, Similarity, Vec2, Vec3, float, floor_to_u32};
use crate::mesh::{Mesh, Primitive};

/// Pixels are counted in runs whose sums fit a byte: many of them add at once.
const RUN: usize = 240;

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
        let width = view.width as usize;
        each_triangle(mesh, place, view, |corners, uv| {
            let Some(uv) = uv else {
                spans(corners, view, |y, columns| {
                    let row = y as usize * width;
                    covered[row + columns.start..row + columns.end].fill(true);
                });
                return;
            };
            // Inside a crown most samples are covered already: they need no texture coordinates.
            let mut texels = None;
            spans(corners, view, |y, columns| {
                let row = y as usize * width;
                let pixels = &mut covered[row + columns.start..row + columns.end];
                if pixels.iter().all(|&covered| covered) {
                    return;
                }
                let texels = texels.get_or_insert_with(|| Gradient::of(corners, uv, cutouts));
                let mut at = texels.at(columns.start, y);
                for pixel in pixels {
                    if !*pixel {
                        *pixel = cutouts.at(at[0] >> FRACTION, at[1] >> FRACTION);
                    }
                    at[0] = at[0].wrapping_add(texels.step[0]);
                    at[1] = at[1].wrapping_add(texels.step[1]);
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

    /// The picture as a texture that is there where it is covered.
    #[must_use]
    pub fn cutouts(&self) -> Cutouts {
        Cutouts::from_texels(self.width, self.height, &self.covered)
    }

    /// Covered pixels.
    #[must_use]
    pub fn area(&self) -> u64 {
        let count = |run: &[bool]| run.iter().map(|&c| u8::from(c)).sum::<u8>();
        self.covered
            .chunks(RUN)
            .map(|run| u64::from(count(run)))
            .sum()
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
        for (a, b) in self.covered.chunks(RUN).zip(other.covered.chunks(RUN)) {
            let pairs = || a.iter().zip(b);
            both += u64::from(pairs().map(|(a, b)| u8::from(a & b)).sum::<u8>());
            either += u64::from(pairs().map(|(a, b)| u8::from(a | b)).sum::<u8>());
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

/// Bits of a texture coordinate behind the point.
const FRACTION: u32 = 32;

/// Texture coordinates, in texels, over a triangle in a picture. Found in doubles, since a sliver's gradients are
/// steep; followed in whole numbers.
struct Gradient {
    /// At the picture's upper left corner.
    origin: [f64; 2],
    /// For a step to the right and a step down.
    right: [f64; 2],
    down: [f64; 2],
    /// For a step to the right, with [`FRACTION`] bits behind the point.
    step: [i64; 2],
}

impl Gradient {
    fn of(corners: [Vec2; 3], uv: [[f32; 2]; 3], cutouts: &Cutouts) -> Self {
        let [a, b, c] = corners.map(|p| p.to_array().map(f64::from));
        let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let inverse = 1.0 / (ab[0] * ac[1] - ab[1] * ac[0]);
        let size = [f64::from(cutouts.width), f64::from(cutouts.height)];
        let axis = |k: usize| {
            let [ta, tb, tc] = uv.map(|t| f64::from(t[k]) * size[k]);
            let right = ((tb - ta) * ac[1] - (tc - ta) * ab[1]) * inverse;
            let down = ((tc - ta) * ab[0] - (tb - ta) * ac[0]) * inverse;
            (ta - right * a[0] - down * a[1], right, down)
        };
        let (u, v) = (axis(0), axis(1));
        Self {
            origin: [u.0, v.0],
            right: [u.1, v.1],
            down: [u.2, v.2],
            step: [u.1, v.1].map(fixed),
        }
    }

    /// At the middle of a pixel, with [`FRACTION`] bits behind the point.
    #[expect(
        clippy::cast_precision_loss,
        reason = "picture sizes are far below 2^52"
    )]
    fn at(&self, x: usize, y: u32) -> [i64; 2] {
        let (x, y) = (x as f64 + 0.5, f64::from(y) + 0.5);
        core::array::from_fn(|k| fixed(self.origin[k] + self.right[k] * x + self.down[k] * y))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the cast saturates, far outside of any texture"
)]
fn fixed(texels: f64) -> i64 {
    const ONE: f64 = (1_u64 << FRACTION) as f64;
    (texels * ONE) as i64
}

/// Calls `fill` with each row and the columns whose middles a triangle covers: from its left edge to before
/// its right one, so that triangles that share an edge share no pixel.
#[inline]
fn spans(corners: [Vec2; 3], view: &View, mut fill: impl FnMut(u32, core::ops::Range<usize>)) {
    let [mut top, mut middle, mut bottom] = corners;
    for _ in 0..2 {
        if middle.y < top.y {
            (top, middle) = (middle, top);
        }
        if bottom.y < middle.y {
            (middle, bottom) = (bottom, middle);
        }
    }
    // First row whose middle lies below a height.
    let row = |y: f32| floor_to_u32((y + 0.5).max(0.0)).min(view.height);
    let column = |x: f32| floor_to_u32((x + 0.5).max(0.0)).min(view.width) as usize;
    // Columns for a row, from the upper end downward: edges that two triangles share are the same in both.
    let slope = |a: Vec2, b: Vec2| (b.x - a.x) / (b.y - a.y);
    let rows = [row(top.y), row(middle.y), row(bottom.y)];
    if rows[0] == rows[2] {
        return;
    }
    let long = slope(top, bottom);
    for (first, last, from, to) in [
        (rows[0], rows[1], top, middle),
        (rows[1], rows[2], middle, bottom),
    ] {
        if first == last {
            continue;
        }
        let short = slope(from, to);
        for y in first..last {
            let height = float(y) + 0.5;
            let one = from.x + short * (height - from.y);
            let other = top.x + long * (height - top.y);
            let (left, right) = (column(one.min(other)), column(one.max(other)));
            if left < right {
                fill(y, left..right);
            }
        }
    }
}

/// Fragments that a rasteriser would shade: every sample of every triangle, transparent ones too.
#[must_use]
pub fn fragments(mesh: &Mesh, view: &View) -> u64 {
    let mut count = 0;
    each_triangle(mesh, &Similarity::IDENTITY, view, |corners, _| {
        spans(corners, view, |_, columns| count += columns.len() as u64);
    });
    count
}

/// Projects all triangles: corners in samples, and texture coordinates for foliage. Those without a sample
/// in their box are left out.
fn each_triangle(
    mesh: &Mesh,
    place: &Similarity,
    view: &View,
    mut visit: impl FnMut([Vec2; 3], Option<[[f32; 2]; 3]>),
) {
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
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Whole numbers from 0 up: what lies above or left of the picture has none either.
        let cell = |x: f32| floor_to_u32((x + 0.5).max(0.0));
        cell(low.x) != cell(high.x)
            && cell(low.y) != cell(high.y)
            && (b - a).perp_dot(c - a).is_normal()
    };
    let bark = project(&mesh.bark);
    for corner in mesh.bark.indices.chunks_exact(3) {
        let corners = [corner[0], corner[1], corner[2]].map(|i| bark[i as usize]);
        if has_samples(corners) {
            visit(corners, None);
        }
    }
    let foliage = project(&mesh.foliage);
    for corner in mesh.foliage.indices.chunks_exact(3) {
        let corner = [corner[0], corner[1], corner[2]].map(|i| i as usize);
        let corners = corner.map(|i| foliage[i]);
        if has_samples(corners) {
            visit(corners, Some(corner.map(|i| mesh.foliage.vertices[i].uv)));
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

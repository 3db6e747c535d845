//! One picture of a model against that of the full tree.

use super::light::LIGHTS;
use super::picture::{Crop, Picture};
use crate::capture::View;
use crate::math::{Vec3, float};
use crate::measure::flip::{PIXELS_PER_DEGREE, flip, masked_mean};
use crate::measure::silhouette::{Cutouts, Silhouette};
use crate::mesh::Mesh;

/// Pixels around both silhouettes over which FLIP is still averaged: an edge is seen from both of its sides.
const RIM: usize = 2;

/// How one picture compares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    /// Intersection over union.
    pub(super) iou: f32,
    /// Covered area over the full tree's, minus 1.
    pub(super) coverage: f32,
    /// Mean FLIP around both silhouettes, by light; none if only the outline was drawn.
    pub(super) flip: Option<[f32; LIGHTS]>,
    /// Mean angle of the normals, degrees; none if no pixel is covered in both.
    pub(super) normal_deg: Option<f32>,
}

/// The outline of a model: what alone decides its coverage and silhouette.
pub(super) struct Outline {
    /// Pixels of which most samples are covered.
    pixels: Silhouette,
    /// Covered samples.
    samples: u64,
}

impl Outline {
    /// Draws a model with `n` by `n` samples in each pixel of `view`, each reading the finest texels.
    pub(super) fn draw(mesh: &Mesh, cutouts: &Cutouts, view: &View, n: u32) -> Self {
        let samples = View {
            width: view.width * n,
            height: view.height * n,
            ..*view
        };
        let silhouette = Silhouette::of(mesh, cutouts, &samples);
        Self {
            pixels: silhouette.reduced(n),
            samples: silhouette.area(),
        }
    }
}

/// Compares a model with the full tree; colours and normals only if it was drawn.
pub(super) fn compare(
    (full, full_outline): (&Picture, &Outline),
    (test, test_outline): (Option<&Picture>, &Outline),
) -> Difference {
    let (both, either) = full_outline.pixels.overlap(&test_outline.pixels);
    let (of_full, of_test) = (full_outline.samples, test_outline.samples);
    Difference {
        iou: if either == 0 {
            1.0
        } else {
            real(both) / real(either)
        },
        coverage: match (of_full, of_test) {
            (0, 0) => 0.0,
            // Nothing to compare with: as wrong as a doubled tree.
            (0, _) => 1.0,
            _ => real(of_test) / real(of_full) - 1.0,
        },
        flip: test.map(|test| masked_flip(full, test, core::array::from_fn(|light| light))),
        normal_deg: test.and_then(|test| normal_angle(full, test)),
    }
}

/// FLIP over both silhouettes and a rim, under each of some lights. Only the part of the picture that either
/// touches is looked at: past its air both are background, and FLIP repeats the edge.
pub(super) fn masked_flip<const N: usize>(
    full: &Picture,
    test: &Picture,
    lights: [usize; N],
) -> [f32; N] {
    let Some(crop) = Crop::around(&[full, test], RIM + 1) else {
        return [0.0; N];
    };
    let mask = mask(&full.silhouette, &test.silhouette, crop);
    lights.map(|light| {
        let [a, b] = [full, test].map(|p| crop.image(&p.colours[light]));
        flip(&a, &b, PIXELS_PER_DEGREE).map_or(0.0, |errors| masked_mean(&errors, &mask))
    })
}

/// FLIP over both silhouettes and a rim, under the first light.
pub(super) fn flip_between(full: &Picture, test: &Picture) -> f32 {
    let [flip] = masked_flip(full, test, [0]);
    flip
}

/// Pixels within the rim of either silhouette.
fn mask(a: &Silhouette, b: &Silhouette, crop: Crop) -> Vec<bool> {
    let (a, b) = (crop.of(&a.covered, a.width), crop.of(&b.covered, b.width));
    let either: Vec<bool> = a.iter().zip(&b).map(|(a, b)| a | b).collect();
    let (width, height) = (crop.x1 - crop.x0, crop.y1 - crop.y0);
    // A square is a row of columns.
    let spread = |from: &[bool], along: usize, end: &dyn Fn(usize) -> usize, count: usize| {
        let mut to = from.to_vec();
        for at in (0..from.len()).filter(|&at| from[at]) {
            let place = end(at);
            for step in 1..=RIM {
                if place >= step {
                    to[at - step * along] = true;
                }
                if place + step < count {
                    to[at + step * along] = true;
                }
            }
        }
        to
    };
    let wide = spread(&either, 1, &|at| at % width, width);
    spread(&wide, width, &|at| at / width, height)
}

/// Mean angle between the normals where both are covered, degrees.
fn normal_angle(full: &Picture, test: &Picture) -> Option<f32> {
    let (a, b) = (&full.silhouette.covered, &test.silhouette.covered);
    let mut sum = 0.0_f64;
    let mut count = 0;
    for at in (0..a.len()).filter(|&at| a[at] && b[at]) {
        sum += f64::from(angle(full.normals[at], test.normals[at]));
        count += 1;
    }
    #[expect(clippy::cast_possible_truncation, reason = "an angle in degrees")]
    (count > 0).then(|| (sum / f64::from(count)).to_degrees() as f32)
}

/// Angle between unit vectors, radians: exact for equal ones too.
fn angle(a: Vec3, b: Vec3) -> f32 {
    2.0 * libm::atan2f((a - b).length(), (a + b).length())
}

fn real(count: u64) -> f32 {
    float(u32::try_from(count).unwrap_or(u32::MAX))
}

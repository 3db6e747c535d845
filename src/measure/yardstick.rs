//! The yardstick: full detail as seen from the calibration views, against which LODs are scaled, chosen and
//! given their errors.

use super::silhouette::{Cutouts, Silhouette, compare, seen_bounds};
use super::views::calibration;
use crate::capture::View;
use crate::math::{Bounds, Vec3};
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Samples along the height of the tree.
const SAMPLES: f32 = 256.0;

/// Air around the tree, as a part of its height: quads may reach outside.
const AIR: f32 = 0.08;

/// A LOD's coverage may be wrong by this part, over blocks of the size of its error.
pub const BLOCK_TOLERANCE: f32 = 0.1;

/// Blocks are squares of up to so many times two samples.
const BLOCK_STEPS: u32 = 6;

/// Full detail from all calibration views.
#[derive(Clone, Debug)]
pub struct Yardstick {
    views: Vec<View>,
    reference: Vec<Silhouette>,
    /// Edge of a sample, metres.
    sample: f32,
}

/// How a LOD compares with full detail, means over the calibration views.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Intersection over union of the silhouettes, 0..=1.
    pub iou: f32,
    /// Covered area over full detail's.
    pub coverage: f32,
    /// Edge of the blocks over which the coverage is right to within [`BLOCK_TOLERANCE`], metres.
    pub error_m: f32,
}

impl Yardstick {
    /// Looks at full detail.
    #[must_use]
    pub fn new(full: &Mesh, cutouts: &Cutouts) -> Self {
        let size = full.bounds().size();
        let sample = (size.y / SAMPLES)
            .max(size.max_element() / 1024.0)
            .max(1e-6);
        let air = Vec3::splat(size.max_element() * AIR);
        let views: Vec<View> = calibration()
            .iter()
            .map(|direction| {
                let seen = seen_bounds(full, direction);
                let seen = Bounds {
                    min: seen.min - air,
                    max: seen.max + air,
                };
                direction.view(&seen, sample)
            })
            .collect();
        let reference = views
            .par_iter()
            .map(|view| Silhouette::of(full, cutouts, view))
            .collect();
        Self {
            views,
            reference,
            sample,
        }
    }

    /// Coverage of a LOD over full detail's, mean over views.
    #[must_use]
    pub fn coverage(&self, mesh: &Mesh, cutouts: &Cutouts) -> f32 {
        let of_view = |(view, reference): (&View, &Silhouette)| {
            compare(reference, &Silhouette::of(mesh, cutouts, view)).coverage
        };
        let all: Vec<f32> = self
            .views
            .par_iter()
            .zip(&self.reference)
            .map(of_view)
            .collect();
        mean(&all)
    }

    /// Compares a LOD with full detail.
    #[must_use]
    pub fn judge(&self, mesh: &Mesh, cutouts: &Cutouts) -> Verdict {
        let seen: Vec<(f32, f32, [u64; BLOCK_STEPS as usize + 1], u64)> = self
            .views
            .par_iter()
            .zip(&self.reference)
            .map(|(view, reference)| {
                let test = Silhouette::of(mesh, cutouts, view);
                let matched = compare(reference, &test);
                let misses = core::array::from_fn(|step| block_miss(reference, &test, 1 << step));
                (matched.iou, matched.coverage, misses, reference.area())
            })
            .collect();
        let area: u64 = seen.iter().map(|s| s.3).sum();
        let misses: [f32; BLOCK_STEPS as usize + 1] = core::array::from_fn(|step| {
            real(seen.iter().map(|s| s.2[step]).sum()) / real(area.max(1))
        });
        Verdict {
            iou: mean(&seen.iter().map(|s| s.0).collect::<Vec<_>>()),
            coverage: mean(&seen.iter().map(|s| s.1).collect::<Vec<_>>()),
            error_m: block_size(&misses) * self.sample,
        }
    }

    /// The factor between two bounds at which `mesh_at` covers as much as full detail, by secants; the nearest
    /// bound if there is none.
    ///
    /// # Errors
    /// Those of `mesh_at`.
    pub fn scale<E>(
        &self,
        cutouts: &Cutouts,
        [low, high]: [f32; 2],
        mesh_at: impl Fn(f32) -> Result<Mesh, E>,
    ) -> Result<f32, E> {
        /// Coverage is right when it is within this.
        const CLOSE: f32 = 0.002;
        /// Secant steps at most.
        const STEPS: usize = 4;
        let miss = |scale: f32| Ok(self.coverage(&mesh_at(scale)?, cutouts) - 1.0);
        let mut before = (1.0_f32, miss(1.0)?);
        if before.1.abs() < CLOSE {
            return Ok(1.0);
        }
        let guess = (1.0 - 0.6 * before.1).clamp(low, high);
        let mut now = (guess, miss(guess)?);
        for _ in 0..STEPS {
            let slope = (now.1 - before.1) / (now.0 - before.0);
            if now.1.abs() < CLOSE || !slope.is_normal() {
                break;
            }
            let next = (now.0 - now.1 / slope).clamp(low, high);
            if (next - now.0).abs() < 1e-4 {
                break;
            }
            before = now;
            now = (next, miss(next)?);
        }
        Ok(if now.1.abs() <= before.1.abs() {
            now.0
        } else {
            before.0
        })
    }
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / real(values.len().max(1) as u64)
}

#[expect(clippy::cast_precision_loss, reason = "a mean needs few digits")]
fn real(count: u64) -> f32 {
    count as f32
}

/// Sum over blocks of `edge` samples of how much their covered samples differ in number.
fn block_miss(a: &Silhouette, b: &Silhouette, edge: u32) -> u64 {
    let columns = a.width.div_ceil(edge) as usize;
    let mut row = vec![0_i64; columns];
    let mut sum = 0;
    for y in 0..a.height {
        let start = y as usize * a.width as usize;
        for x in 0..a.width as usize {
            let (in_a, in_b) = (a.covered[start + x], b.covered[start + x]);
            row[x / edge as usize] += i64::from(in_a) - i64::from(in_b);
        }
        if (y + 1).is_multiple_of(edge) || y + 1 == a.height {
            sum += row.iter().map(|d| d.unsigned_abs()).sum::<u64>();
            row.fill(0);
        }
    }
    sum
}

/// Edge of the blocks, in samples, over which the miss falls to the tolerance: between steps in the logarithm,
/// and in proportion outside of them.
fn block_size(misses: &[f32]) -> f32 {
    let edge = |step: usize| crate::math::float(1 << step);
    let Some(step) = misses.iter().position(|&m| m <= BLOCK_TOLERANCE) else {
        let last = misses.len() - 1;
        return edge(last) * misses[last] / BLOCK_TOLERANCE;
    };
    if step == 0 {
        return misses[0] / BLOCK_TOLERANCE;
    }
    let (above, below) = (misses[step - 1], misses[step]);
    let part = (above - BLOCK_TOLERANCE) / (above - below).max(1e-9);
    edge(step - 1) * (1.0 + part)
}

//! The yardstick: full detail as seen from the calibration views, against which LODs are scaled, chosen and
//! given their errors.

use super::silhouette::{Cutouts, Match, Silhouette, compare, seen_bounds};
use super::views::calibration;
use crate::capture::View;
use crate::math::{Bounds, Vec3};
use crate::mesh::Mesh;
use core::convert::Infallible;
use rayon::prelude::*;

/// Samples along the height of the tree.
const SAMPLES: f32 = 256.0;

/// Air around the tree, as a part of its height: quads may reach outside.
const AIR: f32 = 0.08;

/// A LOD's coverage may be wrong by this part, over blocks of the size of its error.
pub const BLOCK_TOLERANCE: f32 = 0.1;

/// Sizes of blocks: squares of 1, 2, 4, ... 64 samples along an edge.
const BLOCKS: usize = 7;

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
        let Ok(yardstick) = Self::while_ok(full, cutouts, || Ok::<(), Infallible>(()));
        yardstick
    }

    /// The same; `go_on` is asked before each view.
    ///
    /// # Errors
    /// Those of `go_on`.
    pub fn while_ok<E: Send>(
        full: &Mesh,
        cutouts: &Cutouts,
        go_on: impl Fn() -> Result<(), E> + Sync,
    ) -> Result<Self, E> {
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
        let reference: Result<Vec<Silhouette>, E> = views
            .par_iter()
            .map(|view| go_on().map(|()| Silhouette::of(full, cutouts, view)))
            .collect();
        Ok(Self {
            reference: reference?,
            views,
            sample,
        })
    }

    /// Coverage of a LOD over full detail's, mean over views.
    #[must_use]
    pub fn coverage(&self, mesh: &Mesh, cutouts: &Cutouts) -> f32 {
        self.coverage_of(&self.look(mesh, cutouts))
    }

    /// A LOD from all views.
    fn look(&self, mesh: &Mesh, cutouts: &Cutouts) -> Vec<Silhouette> {
        let views = self.views.par_iter();
        views.map(|v| Silhouette::of(mesh, cutouts, v)).collect()
    }

    fn coverage_of(&self, seen: &[Silhouette]) -> f32 {
        let pairs = self.reference.iter().zip(seen);
        let all: Vec<f32> = pairs.map(|(r, t)| compare(r, t).coverage).collect();
        mean(&all)
    }

    /// Compares a LOD with full detail.
    #[must_use]
    pub fn judge(&self, mesh: &Mesh, cutouts: &Cutouts) -> Verdict {
        self.verdict(&self.look(mesh, cutouts))
    }

    fn verdict(&self, seen: &[Silhouette]) -> Verdict {
        let seen: Vec<(Match, [u64; BLOCKS], u64)> = self
            .reference
            .par_iter()
            .zip(seen)
            .map(|(reference, test)| {
                let misses = block_misses(reference, test);
                (compare(reference, test), misses, reference.area())
            })
            .collect();
        let area: u64 = seen.iter().map(|s| s.2).sum();
        let misses: [f32; BLOCKS] = core::array::from_fn(|step| {
            real(seen.iter().map(|s| s.1[step]).sum()) / real(area.max(1))
        });
        Verdict {
            iou: mean(&seen.iter().map(|s| s.0.iou).collect::<Vec<_>>()),
            coverage: mean(&seen.iter().map(|s| s.0.coverage).collect::<Vec<_>>()),
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
        bounds: [f32; 2],
        mesh_at: impl Fn(f32) -> Result<Mesh, E>,
    ) -> Result<f32, E> {
        Ok(self.fit(cutouts, bounds, mesh_at)?.scale)
    }

    /// The same, with the mesh at that factor and how it compares.
    ///
    /// # Errors
    /// Those of `mesh_at`.
    pub fn fit<E>(
        &self,
        cutouts: &Cutouts,
        [low, high]: [f32; 2],
        mesh_at: impl Fn(f32) -> Result<Mesh, E>,
    ) -> Result<Fit, E> {
        /// Coverage is right when it is within this.
        const CLOSE: f32 = 0.002;
        /// Secant steps at most.
        const STEPS: usize = 4;
        let at = |scale: f32| {
            let mesh = mesh_at(scale)?;
            let seen = self.look(&mesh, cutouts);
            let miss = self.coverage_of(&seen) - 1.0;
            Ok(Guess {
                scale,
                mesh,
                seen,
                miss,
            })
        };
        let mut before = at(1.0)?;
        if before.miss.abs() < CLOSE || high <= low {
            return Ok(self.fitted(before));
        }
        let mut now = at((1.0 - 0.6 * before.miss).clamp(low, high))?;
        for _ in 0..STEPS {
            let slope = (now.miss - before.miss) / (now.scale - before.scale);
            if now.miss.abs() < CLOSE || !slope.is_normal() {
                break;
            }
            let next = (now.scale - now.miss / slope).clamp(low, high);
            if (next - now.scale).abs() < 1e-4 {
                break;
            }
            before = now;
            now = at(next)?;
        }
        let is_better = now.miss.abs() <= before.miss.abs();
        Ok(self.fitted(if is_better { now } else { before }))
    }

    fn fitted(&self, guess: Guess) -> Fit {
        Fit {
            verdict: self.verdict(&guess.seen),
            scale: guess.scale,
            mesh: guess.mesh,
        }
    }
}

/// A LOD at the factor at which it covers as much as full detail.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The factor.
    pub scale: f32,
    /// The LOD at that factor.
    pub mesh: Mesh,
    /// How it compares with full detail.
    pub verdict: Verdict,
}

/// A step on the way to a [`Fit`].
struct Guess {
    scale: f32,
    mesh: Mesh,
    seen: Vec<Silhouette>,
    /// Coverage less 1.
    miss: f32,
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / real(values.len().max(1) as u64)
}

#[expect(clippy::cast_precision_loss, reason = "a mean needs few digits")]
fn real(count: u64) -> f32 {
    count as f32
}

/// For blocks of 1, 2, 4, ... samples along an edge: the sum of how much their covered samples differ in number.
fn block_misses(a: &Silhouette, b: &Silhouette) -> [u64; BLOCKS] {
    let (mut width, mut height) = (a.width as usize, a.height as usize);
    let pairs = a.covered.iter().zip(&b.covered);
    // At most 64 times 64 samples to a block.
    let mut blocks: Vec<i16> = pairs.map(|(&a, &b)| i16::from(a) - i16::from(b)).collect();
    core::array::from_fn(|step| {
        if step > 0 {
            blocks = quartered(&blocks, width);
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
        }
        debug_assert_eq!(blocks.len(), width * height);
        let sizes = blocks.iter().map(|d| u64::from(d.unsigned_abs()));
        sizes.sum()
    })
}

/// Sums of two by two, of fewer at the right and lower edges.
fn quartered(blocks: &[i16], width: usize) -> Vec<i16> {
    let columns = width.div_ceil(2);
    let mut sums = Vec::with_capacity(blocks.len().div_ceil(4) + columns);
    for pair in blocks.chunks(2 * width.max(1)) {
        let first = sums.len();
        let (upper, lower) = pair.split_at(width);
        sums.extend(upper.chunks(2).map(|c| c.iter().sum::<i16>()));
        for (sum, c) in sums[first..].iter_mut().zip(lower.chunks(2)) {
            *sum += c.iter().sum::<i16>();
        }
    }
    sums
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

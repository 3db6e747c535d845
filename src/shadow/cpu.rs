//! The backend that needs no driver: hard shadows as bit masks, summed.

use rayon::prelude::*;

use crate::report::{Cancelled, Progress};
use crate::shadow::backend::{Backend, BakeError, Light, Work};
use crate::shadow::ground::floor_log2;
use crate::shadow::raster::{Cut, Mask};

/// 2^32 over the golden ratio: its multiples fill the circle of 32-bit numbers evenly.
const GOLDEN: u32 = 0x9e37_79b9;

/// Step between the thresholds of neighbouring triangles: the plastic number's share of 2^32, so
/// that it keeps no pace with [`GOLDEN`].
const SPREAD: u32 = 0xc13f_a9a9;

/// Draws with the processor: the same sums on any machine, at any number of threads.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cpu;

impl Backend for Cpu {
    fn sums(&self, work: &Work<'_>, progress: &dyn Progress) -> Result<Vec<Vec<u16>>, BakeError> {
        Ok(sums(work, progress)?)
    }
}

/// The summed shares of every light.
pub(super) fn sums(work: &Work<'_>, progress: &dyn Progress) -> Result<Vec<Vec<u16>>, Cancelled> {
    let lights = work.lights.par_iter();
    lights
        .map(|light| Job { work, light }.sums(progress))
        .collect()
}

/// One light's shadow.
struct Job<'a> {
    work: &'a Work<'a>,
    light: &'a Light,
}

/// What a thread needs to draw samples one after the other.
struct Desk {
    shadows: Vec<[f32; 2]>,
    mask: Mask,
    sums: Vec<u16>,
}

impl Job<'_> {
    /// Summed shares of the samples in whose shadow each texel lies.
    fn sums(&self, progress: &dyn Progress) -> Result<Vec<u16>, Cancelled> {
        let size = self.work.size;
        let texels = size as usize * size as usize;
        let desk = || Desk {
            shadows: Vec::with_capacity(self.work.casters.points.len()),
            mask: Mask::new(size),
            sums: vec![0; texels],
        };
        let draw = |mut desk: Desk, index: usize| {
            if progress.cancelled() {
                return Err(Cancelled);
            }
            self.draw(index, &mut desk);
            progress.step();
            Ok(desk)
        };
        // Integers: the sum is the same in whatever order threads come by.
        let add = |mut a: Vec<u16>, b: Vec<u16>| {
            if a.is_empty() {
                return Ok(b);
            }
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            Ok(a)
        };
        (0..self.light.samples.len())
            .into_par_iter()
            .with_min_len(4)
            .try_fold(desk, draw)
            .map(|desk| desk.map(|desk| desk.sums))
            .try_reduce(Vec::new, add)
    }

    /// Adds one sample's hard shadow.
    fn draw(&self, index: usize, desk: &mut Desk) {
        let Desk {
            shadows,
            mask,
            sums,
        } = desk;
        let (casters, coverage) = (self.work.casters, self.work.coverage);
        let projection = &self.light.samples[index];
        shadows.clear();
        shadows.extend(casters.points.iter().map(|&p| projection.shadow(p)));
        mask.clear();
        for corners in &casters.bark {
            mask.solid(corners.map(|i| shadows[i as usize]));
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most 64 * 256 samples")]
        let mut phase = (index as u32).wrapping_mul(GOLDEN);
        for leaf in &casters.leaves {
            // Over the samples a triangle's thresholds fill the range evenly, and so do
            // neighbouring triangles' in one sample.
            phase = phase.wrapping_add(SPREAD);
            let stray = self.light.stray.of(leaf.key, index);
            let corners = leaf.corners.map(|i| {
                let ([x, z], [_, height, _]) = (shadows[i as usize], casters.points[i as usize]);
                [x - height * stray.x, z - height * stray.y]
            });
            let level = floor_log2(leaf.uv_area / area(corners)) >> 1;
            let level = level.clamp(0, leaf.last_level);
            let cut = Cut {
                level: coverage.level(usize::try_from(level).unwrap_or(0)),
                uv: leaf.uv,
                threshold: phase.to_be_bytes()[0].max(1),
            };
            mask.cut_out(corners, &cut);
        }
        mask.add_to(sums, self.light.shares[index]);
    }
}

/// Twice the area of a triangle.
#[inline]
fn area([a, b, c]: [[f32; 2]; 3]) -> f32 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
}

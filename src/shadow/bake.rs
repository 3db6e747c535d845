//! The nine soft shadows: hard shadows of all samples, summed.

use rayon::prelude::*;

use crate::image::Image;
use crate::math::{Vec2, Vec3};
use crate::mesh::Mesh;
use crate::report::{Cancelled, Progress};
use crate::shadow::coverage::Coverage;
use crate::shadow::directions::{COUNT, Sample, direction, samples};
use crate::shadow::ground::{Casters, Ground, floor_log2};
use crate::shadow::raster::{Cut, Mask};
use crate::shadow::{Settings, ShadowMap, Shadows};

/// Sum of a texel in the shadow of all samples: 256 steps a byte, and no overflow of 16 bits.
const FULL: u16 = 255 * 256;

/// 2^32 over the golden ratio: its multiples fill the circle of 32-bit numbers evenly.
const GOLDEN: u32 = 0x9e37_79b9;

/// Casts the soft shadows of a mesh on the ground from all nine lights.
///
/// Bark is solid. Foliage casts where `alpha`, the foliage atlas's coverage (uv 0..=1, v down,
/// nearest texel beyond), is at least `cutoff`. An empty mesh has maps all lit. The same bytes at
/// any number of threads.
///
/// # Errors
/// [`Cancelled`] if `progress` said so before the last sample.
pub fn bake(
    mesh: &Mesh,
    alpha: &Image<u8>,
    cutoff: u8,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Shadows, Cancelled> {
    let settings = settings.clamped();
    let coverage = Coverage::new(alpha, cutoff);
    let casters = Casters::new(mesh, &coverage);
    let a_map = 1 + u64::from(settings.bands) * u64::from(settings.samples);
    progress.begin("shadows", COUNT as u64 * a_map);
    let maps = (0..COUNT).into_par_iter().map(|index| {
        let light = direction(index);
        let job = Job::new(&casters, &coverage, light, &settings);
        let sums = job.sums(progress)?;
        Ok(job.map(light, &sums))
    });
    Ok(Shadows {
        maps: maps.collect::<Result<_, _>>()?,
    })
}

/// One light's shadow.
struct Job<'a> {
    casters: &'a Casters,
    coverage: &'a Coverage,
    samples: Vec<Sample>,
    /// Integer shares of the samples; they sum to [`FULL`].
    shares: Vec<u16>,
    /// Where each sample's grid lies against the map's, texels.
    shifts: Vec<Vec2>,
    ground: Ground,
    size: u32,
}

/// What a thread needs to draw samples one after the other.
struct Desk {
    shadows: Vec<[f32; 2]>,
    mask: Mask,
    sums: Vec<u16>,
}

impl<'a> Job<'a> {
    fn new(casters: &'a Casters, coverage: &'a Coverage, light: Vec3, settings: &Settings) -> Self {
        let samples = samples(light, settings);
        let size = settings.size;
        Self {
            casters,
            coverage,
            shares: shares(&samples),
            shifts: shifts(&samples),
            ground: Ground::around(casters, &samples, size),
            samples,
            size,
        }
    }

    /// Summed shares of the samples in whose shadow each texel lies.
    fn sums(&self, progress: &dyn Progress) -> Result<Vec<u16>, Cancelled> {
        let texels = self.size as usize * self.size as usize;
        let desk = || Desk {
            shadows: Vec::with_capacity(self.casters.points.len()),
            mask: Mask::new(self.size),
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
        (0..self.samples.len())
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
        let (sample, shift) = (&self.samples[index], self.shifts[index]);
        self.ground
            .project(&self.casters.points, sample, shift, shadows);
        mask.clear();
        for corners in &self.casters.bark {
            mask.solid(corners.map(|i| shadows[i as usize]));
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most 64 * 256 samples")]
        let mut phase = (index as u32).wrapping_mul(GOLDEN);
        for leaf in &self.casters.leaves {
            // Over the samples a triangle's thresholds fill the range evenly, and so do
            // neighbouring triangles' in one sample.
            phase = phase.wrapping_add(SPREAD);
            let corners = leaf.corners.map(|i| shadows[i as usize]);
            let level = floor_log2(leaf.uv_area / area(corners)) >> 1;
            let level = level.clamp(0, leaf.last_level);
            let cut = Cut {
                level: self.coverage.level(usize::try_from(level).unwrap_or(0)),
                uv: leaf.uv,
                threshold: phase.to_be_bytes()[0].max(1),
            };
            mask.cut_out(corners, &cut);
        }
        mask.add_to(sums, self.shares[index]);
    }

    fn map(&self, light: Vec3, sums: &[u16]) -> ShadowMap {
        let bytes = sums.iter().map(|sum| ((sum + 128) >> 8).to_le_bytes()[0]);
        let mut image = Image::from_texels(self.size, self.size, bytes.collect());
        let trunk_base = self.ground.trunk_base;
        let code = trunk_base.iter().flat_map(|x| x.to_le_bytes());
        for (texel, byte) in image.texels_mut().iter_mut().zip(code) {
            *texel = byte;
        }
        ShadowMap {
            direction: light,
            image,
            ground_rect_m: self.ground.rect_m(),
            trunk_base,
        }
    }
}

/// Step between the thresholds of neighbouring triangles: the plastic number's share of 2^32, so
/// that it keeps no pace with [`GOLDEN`].
const SPREAD: u32 = 0xc13f_a9a9;

/// Twice the area of a triangle.
#[inline]
fn area([a, b, c]: [[f32; 2]; 3]) -> f32 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs()
}

/// The samples' weights as integers that sum to [`FULL`].
fn shares(samples: &[Sample]) -> Vec<u16> {
    let total: f64 = samples.iter().map(|s| f64::from(s.weight)).sum();
    let mut sum = 0.0;
    let mut given = 0;
    let share = |sample: &Sample| {
        sum += f64::from(sample.weight);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and FULL"
        )]
        let until = (sum / total * f64::from(FULL)).round() as u16;
        let share = until - given;
        given = until;
        share
    };
    samples.iter().map(share).collect()
}

/// Shifts of the samples' grids that fill a texel evenly (Roberts's R2 sequence), and whose
/// weighted mean is zero, so that the shadow stays in its place. Each is less than a texel.
fn shifts(samples: &[Sample]) -> Vec<Vec2> {
    const STEP: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);
    #[expect(clippy::cast_precision_loss, reason = "at most 64 * 256 samples")]
    let raw = (0..samples.len()).map(|i| (STEP * i as f32 + 0.5).fract() - 0.5);
    let raw: Vec<Vec2> = raw.collect();
    let pairs = raw.iter().zip(samples);
    let mean: Vec2 = pairs.map(|(&shift, sample)| shift * sample.weight).sum();
    raw.into_iter().map(|shift| shift - mean).collect()
}

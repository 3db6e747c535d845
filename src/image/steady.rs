//! Steady alpha: foliage keeps its coverage in mips that other programs make.
//!
//! An engine halves an atlas by plain averages and cuts each mip at the same alpha, so that slim leaves vanish with
//! distance and dense ones grow together. Mips made with care (Castaño 2010, "Computing alpha mipmaps") would
//! help, but glTF cannot hold them. So the care goes into the texture itself: where there is nothing, alpha lies
//! below the cutoff, but not at zero, and where there is something, above it, but not at one. An average of such
//! texels passes the cutoff once a certain share of them is covered, a half in a plain texture, and this
//! share is chosen for each part of the atlas so that its mips cover what it covers itself. Seen close, nothing
//! changes: the same texels are there.

use super::atlas::Rect;
use super::cutouts::ALPHA_CUTOFF;
use super::mips::halved_by;
use super::{Image, Texel};
use crate::math::{byte_from_unit, float, floor_to_u32};
use core::ops::RangeInclusive;
use rayon::prelude::*;

/// Mips that are looked at, the base included. In the sixth, parts of usual size are a few texels, and run into
/// each other.
const LEVELS: usize = 5;

/// Shares are tried in steps of this part.
const WHOLE: u8 = 64;

const BINS: usize = WHOLE as usize + 1;

/// By step of the share: the covered part of some samples.
type Covered = [f32; BINS];

/// The steps. Beyond them, eight bits hold too little.
const STEPS: RangeInclusive<u8> = 6..=58;

/// How a part's alpha leaves the cutoff: by how much upward where it is covered and downward where it is not.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slopes {
    up: f32,
    down: f32,
}

impl Slopes {
    /// The slopes with which an average passes the cutoff if this share of it is covered.
    fn of(share: f32) -> Self {
        let ratio = share / (1.0 - share);
        Self {
            up: (1.0 - ALPHA_CUTOFF) * (1.0 / ratio).min(1.0),
            down: ALPHA_CUTOFF * ratio.min(1.0),
        }
    }

    fn alpha(self, coverage: f32) -> f32 {
        let [over, under] = sides(coverage);
        ALPHA_CUTOFF + over * self.up - under * self.down
    }
}

/// How far a coverage lies above the cutoff and below it, as parts of the most.
fn sides(coverage: f32) -> [f32; 2] {
    let over = (coverage - ALPHA_CUTOFF) / (1.0 - ALPHA_CUTOFF);
    let under = (ALPHA_CUTOFF - coverage) / ALPHA_CUTOFF;
    [over.clamp(0.0, 1.0), under.clamp(0.0, 1.0)]
}

/// What no quad shows: not there, and no weight in a mip that it bleeds into.
const BETWEEN: f32 = ALPHA_CUTOFF - 0.02;

/// Alpha for an atlas whose `alpha` is coverage, by texel: at or above the cutoff exactly where the coverage is.
/// Each rectangle of `parts` is treated by itself.
#[must_use]
pub fn alpha(atlas: &Image<Texel>, parts: &[Rect]) -> Image<u8> {
    let slopes: Vec<Slopes> = parts.par_iter().map(|part| fitted(atlas, part)).collect();
    let mut alpha = Image::filled(atlas.width(), atlas.height(), byte_from_unit(BETWEEN));
    for (part, slopes) in parts.iter().zip(slopes) {
        for y in part.y..part.y + part.height {
            for x in part.x..part.x + part.width {
                *alpha.at_mut(x, y) = byte_from_unit(slopes.alpha(atlas.at(x, y).alpha));
            }
        }
    }
    alpha
}

/// A part with its gutter, as far as it lies in the atlas.
fn within(atlas: &Image<Texel>, part: &Rect) -> Rect {
    let outer = part.outer();
    Rect {
        width: outer.width.min(atlas.width().saturating_sub(outer.x)),
        height: outer.height.min(atlas.height().saturating_sub(outer.y)),
        ..outer
    }
}

/// The slopes that keep a part's coverage best over its mips.
fn fitted(atlas: &Image<Texel>, part: &Rect) -> Slopes {
    let outer = within(atlas, part);
    let inside = inside(part, &outer);
    let mut base = Image::filled(outer.width, outer.height, [0.0; 2]);
    for y in part.y..(part.y + part.height).min(outer.y + outer.height) {
        for x in part.x..(part.x + part.width).min(outer.x + outer.width) {
            *base.at_mut(x - outer.x, y - outer.y) = sides(atlas.at(x, y).alpha);
        }
    }
    let mut mips = mips(base, &inside).into_iter();
    // Texels of the base that count as covered are so whatever the slopes.
    let wanted = mips.next().map_or(0.0, |base| base[usize::from(WHOLE / 2)]);
    if wanted <= 0.0 {
        return Slopes::of(ALPHA_CUTOFF);
    }
    let mips: Vec<Covered> = mips.collect();
    // A part that vanishes is as bad as one that grows eightfold.
    let miss = |got: f32| libm::logf((got / wanted).clamp(0.125, 8.0)).abs();
    let misses = |step: u8| {
        mips.iter()
            .map(|mip| miss(mip[usize::from(step)]))
            .sum::<f32>()
    };
    let best = STEPS
        .map(|step| (step, misses(step)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(WHOLE / 2, |(step, _)| step);
    Slopes::of(f32::from(best) / f32::from(WHOLE))
}

/// Where quads show a part, in texels from the corner of its gutter: left, top, right, bottom.
fn inside(part: &Rect, outer: &Rect) -> [f32; 4] {
    let (left, top) = (part.x - outer.x, part.y - outer.y);
    let right = (left + part.width).min(outer.width);
    let bottom = (top + part.height).min(outer.height);
    [left, top, right, bottom].map(float)
}

/// By mip, and by step of the share: what of a part a bilinear sampler finds covered.
fn mips(base: Image<[f32; 2]>, inside: &[f32; 4]) -> Vec<Covered> {
    let mut mips = Vec::new();
    let mut image = base;
    let mut scale = 1.0;
    while mips.len() < LEVELS {
        let Some(covered) = covered(&image, &inside.map(|side| side / scale)) else {
            break;
        };
        mips.push(covered);
        image = halved_by(&image, |corners| sum(corners.map(|&c| c)).map(|s| s * 0.25));
        scale *= 2.0;
    }
    mips
}

/// Looks at texels' middles and halfway between them; `None` if none of these lies inside.
fn covered(image: &Image<[f32; 2]>, inside: &[f32; 4]) -> Option<Covered> {
    let (width, height) = (image.width(), image.height());
    let at = |x: u32, y: u32| *image.at(x.min(width - 1), y.min(height - 1));
    let [left, top, right, bottom] = *inside;
    let mut counts = [0_u32; BINS];
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let middle = [float(2 * x + 1 + dx) * 0.5, float(2 * y + 1 + dy) * 0.5];
            if !(left..=right).contains(&middle[0]) || !(top..=bottom).contains(&middle[1]) {
                continue;
            }
            let corners = [at(x, y), at(x + dx, y), at(x, y + dy), at(x + dx, y + dy)];
            let [over, under] = sum(corners);
            let share = over / (over + under).max(f32::MIN_POSITIVE);
            counts[floor_to_u32(share * f32::from(WHOLE)) as usize] += 1;
        }
    }
    let all = float(counts.iter().sum::<u32>());
    if all == 0.0 {
        return None;
    }
    let mut above = 0;
    let mut covered = counts.map(|_| 0.0);
    for (covered, count) in covered.iter_mut().zip(counts).rev() {
        above += count;
        *covered = float(above) / all;
    }
    Some(covered)
}

fn sum(corners: [[f32; 2]; 4]) -> [f32; 2] {
    corners
        .iter()
        .fold([0.0; 2], |[over, under], c| [over + c[0], under + c[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Key, Parameter};

    const PARTS: [Rect; 2] = [part_at(8), part_at(136)];

    const fn part_at(x: u32) -> Rect {
        Rect {
            x,
            y: 8,
            width: 112,
            height: 112,
        }
    }

    /// One part with slim leaves strewn by chance, and one that is full but for slim holes.
    fn atlas() -> Image<Texel> {
        let mut image = Image::filled(256, 128, Texel::EMPTY);
        for (part, fill) in PARTS.iter().zip([0.0, 1.0]) {
            for y in part.y..part.y + part.height {
                for x in part.x..part.x + part.width {
                    image.at_mut(x, y).alpha = fill;
                }
            }
            for slim in 0..220 {
                let key = Key::of_seed(7).with(part.x.into()).with(slim);
                let at = |side: u64| {
                    floor_to_u32(key.with(side).unit(Parameter::Texture) * float(part.width - 8))
                };
                for (step, thick) in (0..12).map(|i| (i / 2, i % 2)) {
                    let (x, y) = (part.x + at(0) + step, part.y + at(1) + step / 2);
                    image.at_mut(x, y + thick).alpha = 1.0 - fill;
                }
            }
        }
        image
    }

    /// Covered shares of the two parts of a mip.
    fn coverage(alpha: &Image<f32>, scale: u32) -> [f32; 2] {
        PARTS.each_ref().map(|part| {
            let [x, y, edge] = [part.x, part.y, part.width].map(|side| side / scale);
            let part = alpha.part(x, y, edge, edge);
            let there = part.texels().iter().filter(|&&a| a >= ALPHA_CUTOFF).count();
            float(u32::try_from(there).unwrap()) / float(edge * edge)
        })
    }

    fn halved(alpha: &Image<f32>) -> Image<f32> {
        halved_by(alpha, |corners| corners.into_iter().sum::<f32>() * 0.25)
    }

    #[test]
    fn plain_mips_keep_the_coverage_of_sparse_parts_and_of_dense_ones() {
        let image = atlas();
        let mut steady = alpha(&image, &PARTS).map(|&a| f32::from(a) / 255.0);
        let mut plain = image.map(|t| t.alpha);
        let wanted = coverage(&plain, 1);
        assert_eq!(coverage(&steady, 1), wanted);
        for scale in [2, 4, 8] {
            (steady, plain) = (halved(&steady), halved(&plain));
            for (got, wanted) in coverage(&steady, scale).into_iter().zip(wanted) {
                assert!((got - wanted).abs() < 0.12, "1/{scale}: {got} for {wanted}");
            }
        }
        let [sparse, dense] = coverage(&plain, 8);
        assert!(sparse < 0.3 * wanted[0] && dense > 1.1 * wanted[1]);
    }

    #[test]
    fn just_what_is_covered_reaches_the_cutoff() {
        let mut image = atlas();
        for (i, texel) in image.texels_mut().iter_mut().enumerate() {
            texel.alpha = (texel.alpha - float(u32::try_from(i % 101).unwrap()) * 0.01).abs();
        }
        // Beside the parts there is nothing.
        let inside = |i: usize| {
            let (x, y) = (i % 256, i / 256);
            (8..120).contains(&y) && ((8..120).contains(&x) || (136..248).contains(&x))
        };
        let steady = alpha(&image, &PARTS);
        for (i, (texel, &alpha)) in image.texels().iter().zip(steady.texels()).enumerate() {
            let is_there = inside(i) && texel.alpha >= ALPHA_CUTOFF;
            assert_eq!(alpha >= 128, is_there, "{} became {alpha}", texel.alpha);
        }
    }

    #[test]
    fn a_part_with_nothing_on_it_stays_below_the_cutoff() {
        let image = Image::filled(256, 128, Texel::EMPTY);
        assert!(alpha(&image, &PARTS).texels().iter().all(|&a| a < 128));
    }
}

//! Mip chains whose alpha keeps the coverage of the base.
//!
//! Plain averaging thins foliage out with distance: fewer and fewer texels stay above the cutoff. Here
//! each mip's alpha is scaled so that the share of texels at or above the cutoff is that of the base
//! (Castaño 2010, "Computing alpha mipmaps").

use super::{Image, Texel};
use crate::math::{float, floor_to_u32};
use rayon::prelude::*;

/// Largest factor on a mip's alpha; beyond it, thin parts grow into solid blobs.
const LARGEST_SCALE: f32 = 8.0;

/// `levels` images, the first being `base`, each half the size of the one before (at least 1 texel).
/// Colours are averaged by coverage, so that empty texels do not darken edges.
#[must_use]
pub fn chain(base: Image<Texel>, levels: usize, cutoff: f32) -> Vec<Image<Texel>> {
    let wanted = coverage(&base, 1.0, cutoff);
    // Scaled alpha must not feed the next level, so the plain chain is built first.
    let mut images = vec![base];
    for _ in 1..levels.max(1) {
        let next = halved(&images[images.len() - 1]);
        images.push(next);
    }
    images
        .iter_mut()
        .skip(1)
        .for_each(|image| keep_coverage(image, wanted, cutoff));
    images
}

/// Share of texels whose alpha times `scale` is at or above `cutoff`.
#[must_use]
pub fn coverage(image: &Image<Texel>, scale: f32, cutoff: f32) -> f32 {
    let covered = image
        .texels()
        .iter()
        .filter(|t| t.alpha * scale >= cutoff)
        .count();
    #[expect(
        clippy::cast_precision_loss,
        reason = "a share needs no more than 24 bits"
    )]
    let share = covered as f32 / image.texels().len().max(1) as f32;
    share
}

/// Scales alpha so that the wanted share of texels is at or above the cutoff. The threshold that parts
/// them is read from a histogram; among texels of equal alpha no scale can part, and the nearer share
/// is taken.
fn keep_coverage(image: &mut Image<Texel>, wanted: f32, cutoff: f32) {
    const BINS: u16 = 1024;
    let mut bins = [0_u32; BINS as usize + 1];
    for texel in image.texels() {
        bins[floor_to_u32(texel.alpha.min(1.0) * f32::from(BINS)) as usize] += 1;
    }
    let total = float(u32::try_from(image.texels().len()).unwrap_or(u32::MAX)).max(1.0);
    let (mut above, mut best, mut nearest) = (0, 1.0, f32::INFINITY);
    // From the most covered texels down; those with no alpha at all never count.
    for bin in (1..=BINS).rev().filter(|&bin| bins[usize::from(bin)] > 0) {
        above += bins[usize::from(bin)];
        let miss = (float(above) / total - wanted).abs();
        if miss < nearest {
            nearest = miss;
            best = f32::from(bin) / f32::from(BINS);
        }
    }
    let scale = (cutoff / best).min(LARGEST_SCALE);
    image
        .texels_mut()
        .par_iter_mut()
        .for_each(|t| t.alpha = (t.alpha * scale).min(1.0));
}

/// An image of half the size; odd edges are clamped.
#[must_use]
pub fn halved(image: &Image<Texel>) -> Image<Texel> {
    halved_by(image, average)
}

/// An image of half the size, each texel made of four; odd edges are clamped.
#[must_use]
pub fn halved_by<T: Sync, U: Send>(
    image: &Image<T>,
    mean: impl Fn([&T; 4]) -> U + Sync,
) -> Image<U> {
    let (width, height) = ((image.width() / 2).max(1), (image.height() / 2).max(1));
    let mean = &mean;
    let texels = (0..height).into_par_iter().flat_map_iter(|y| {
        (0..width).map(move |x| {
            let (x1, y1) = (
                (2 * x + 1).min(image.width() - 1),
                (2 * y + 1).min(image.height() - 1),
            );
            let (x0, y0) = ((2 * x).min(x1), (2 * y).min(y1));
            mean([
                image.at(x0, y0),
                image.at(x1, y0),
                image.at(x0, y1),
                image.at(x1, y1),
            ])
        })
    });
    Image::from_texels(width, height, texels.collect())
}

/// The mean of some texels: alpha plainly, all else weighted by alpha.
#[must_use]
pub fn average<const N: usize>(texels: [&Texel; N]) -> Texel {
    let alpha: f32 = texels.iter().map(|t| t.alpha).sum();
    // With nothing covered, weigh all alike, so that dilated colour survives.
    let weight = |t: &Texel| if alpha > 0.0 { t.alpha } else { 1.0 };
    let total: f32 = texels.iter().map(|t| weight(t)).sum();
    let mix = |f: fn(&Texel) -> f32| texels.iter().map(|t| f(t) * weight(t)).sum::<f32>() / total;
    let normal = glam::Vec3::new(
        mix(|t| t.normal[0]),
        mix(|t| t.normal[1]),
        mix(|t| t.normal[2]),
    );
    #[expect(clippy::cast_precision_loss, reason = "a handful of texels")]
    let count = N as f32;
    Texel {
        albedo: [
            mix(|t| t.albedo[0]),
            mix(|t| t.albedo[1]),
            mix(|t| t.albedo[2]),
        ],
        alpha: alpha / count,
        normal: normal.normalize_or(glam::Vec3::Z).to_array(),
        occlusion: mix(|t| t.occlusion),
        roughness: mix(|t| t.roughness),
        translucency: mix(|t| t.translucency),
        depth: mix(|t| t.depth),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thin leaves strewn by chance: what plain mips lose entirely.
    fn sparse() -> Image<Texel> {
        let mut image = Image::filled(256, 256, Texel::EMPTY);
        let key = crate::rng::Key::of_seed(5);
        for leaf in 0..1800 {
            let at = |side| {
                let unit = key
                    .with(leaf)
                    .with(side)
                    .unit(crate::rng::Parameter::Texture);
                floor_to_u32(unit * 253.0)
            };
            (0..3).for_each(|i| image.at_mut(at(0) + i, at(1)).alpha = 1.0);
        }
        image
    }

    #[test]
    fn every_mip_keeps_the_coverage_that_plain_averaging_loses() {
        let base = sparse();
        let wanted = coverage(&base, 1.0, 0.5);
        let plain = halved(&halved(&base));
        assert!(coverage(&plain, 1.0, 0.5) < 0.3 * wanted);
        for (level, mip) in chain(base, 4, 0.5).iter().enumerate() {
            let got = coverage(mip, 1.0, 0.5);
            assert!(
                (got - wanted).abs() < 0.08,
                "level {level}: {got} for {wanted}"
            );
        }
    }

    #[test]
    fn empty_texels_do_not_darken_their_neighbours() {
        let mut image = Image::filled(2, 2, Texel::EMPTY);
        *image.at_mut(0, 0) = Texel {
            albedo: [0.8; 3],
            alpha: 1.0,
            ..Texel::EMPTY
        };
        let mip = halved(&image);
        assert_eq!(mip.at(0, 0).albedo, [0.8; 3]);
        assert_eq!(mip.at(0, 0).alpha, 0.25);
    }
}

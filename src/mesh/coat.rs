//! How bark lies on stems: one texture for all of a tree, its scale, and the colour of what is still young.

use super::WHITE;
use crate::image::{Image, Texel};
use crate::math::{byte_from_unit, lerp, smoothstep};
use crate::species::schema::Bark;

/// Part of the mature radius at which a stem is still wholly young.
const TWIG: f32 = 0.1;

/// Part of the texture's brightest texels that may clip where a texture is lightened for the sake of its tints.
const CLIPPED: usize = 200;

/// The bark of a tree as its tubes wear it.
///
/// A trunk is furrowed and a twig is smooth, and bark grows from the one to the other with the radius
/// (`species` scripts: `young`, `mature_radius_m`). A texture cannot show both at one place, so a tube's vertices
/// carry a colour that the texture is multiplied by: white where the bark is mature, and toward the tips what
/// makes the texture's mean the colour of young bark. Tints go by the radius that a prototype has in its own
/// frame: all nodes of a level are the same sub-tree and share their captures, and so they share their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// Real height of one repeat, metres.
    pub height_m: f32,
    /// Radius from which on bark is mature, metres; 0 if all of it is.
    mature_m: f32,
    /// Factors on the texture's linear colour where it is mature, and on a twig; within 0..=1.
    mature: [f32; 3],
    young: [f32; 3],
}

impl Coat {
    /// Bark that is the same on all stems; `height_m` is the real height of one repeat, metres.
    #[must_use]
    pub fn plain(height_m: f32) -> Self {
        Self {
            height_m,
            mature_m: 0.0,
            mature: [1.0; 3],
            young: [1.0; 3],
        }
    }

    /// The coat of a species, and the texture that it is made for.
    ///
    /// A tint cannot lighten: engines take vertex colours up to 1. Where young bark is lighter than the mature
    /// bark in a channel, the texture is made lighter as a whole and mature stems are tinted down to what they
    /// were, as far as the texture has room above it.
    #[must_use]
    pub fn of(bark: &Bark, mut texture: Image<Texel>) -> (Self, Image<Texel>) {
        let plain = Self::plain(bark.height_m());
        let mature_m = bark.mature_radius_m();
        let (mean, top) = (mean(&texture), top(&texture));
        if mature_m <= 0.0 || mean.iter().any(|&m| m <= 0.0) {
            return (plain, texture);
        }
        let young = bark.young();
        let ratio = [0, 1, 2].map(|i| young[i] / mean[i]);
        let lighter = ratio
            .into_iter()
            .fold(1.0, f32::max)
            .min((1.0 / top).max(1.0));
        if lighter > 1.0 {
            for texel in texture.texels_mut() {
                texel.albedo = texel.albedo.map(|c| (c * lighter).min(1.0));
            }
        }
        let coat = Self {
            mature_m,
            mature: [1.0 / lighter; 3],
            young: ratio.map(|r| (r / lighter).min(1.0)),
            ..plain
        };
        (coat, texture)
    }

    /// The tint of a stem of this radius, metres.
    #[must_use]
    pub fn tint(&self, radius: f32) -> [u8; 4] {
        if self.mature_m <= 0.0 {
            return WHITE;
        }
        let old = smoothstep(TWIG * self.mature_m, self.mature_m, radius);
        let part = |i: usize| byte_from_unit(lerp(self.young[i], self.mature[i], old));
        [part(0), part(1), part(2), 255]
    }
}

/// Mean linear colour.
fn mean(texture: &Image<Texel>) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    for texel in texture.texels() {
        for (sum, &part) in sum.iter_mut().zip(&texel.albedo) {
            *sum += f64::from(part);
        }
    }
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "a mean of colours within 0..=1"
    )]
    sum.map(|s| (s / texture.texels().len().max(1) as f64) as f32)
}

/// The strongest channel of the texture's brightest texels, a few left out.
fn top(texture: &Image<Texel>) -> f32 {
    let strongest = |t: &Texel| t.albedo.into_iter().fold(0.0, f32::max);
    let mut all: Vec<f32> = texture.texels().iter().map(strongest).collect();
    if all.is_empty() {
        return 1.0;
    }
    let rank = all.len() - 1 - all.len() / CLIPPED;
    *all.select_nth_unstable_by(rank, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_bark(mature_radius_m: f32, young: [f32; 3]) -> Bark {
        Bark::Image {
            path: String::new(),
            height_m: 1.0,
            young,
            mature_radius_m,
        }
    }

    fn grey(value: f32) -> Image<Texel> {
        let texel = Texel {
            albedo: [value; 3],
            alpha: 1.0,
            ..Texel::EMPTY
        };
        Image::filled(4, 4, texel)
    }

    /// What is seen on a stem.
    fn seen((coat, texture): &(Coat, Image<Texel>), radius: f32) -> [f32; 3] {
        let tint = coat.tint(radius);
        core::array::from_fn(|i| texture.at(1, 1).albedo[i] * f32::from(tint[i]) / 255.0)
    }

    #[test]
    fn twigs_have_the_colour_of_young_bark_and_trunks_that_of_the_texture() {
        for young in [[0.1, 0.05, 0.02], [0.3, 0.1, 0.35]] {
            let coat = Coat::of(&image_bark(0.1, young), grey(0.2));
            for (radius, wanted) in [
                (0.0, young),
                (0.01, young),
                (0.1, [0.2; 3]),
                (2.0, [0.2; 3]),
            ] {
                let found = seen(&coat, radius);
                let off = (0..3)
                    .map(|i| (found[i] - wanted[i]).abs())
                    .fold(0.0, f32::max);
                assert!(off < 0.004, "{young:?} at {radius}: {found:?}");
            }
            let between = seen(&coat, 0.05)[0];
            assert!((between - 0.2).abs() < (young[0] - 0.2).abs() && between != 0.2);
        }
    }

    #[test]
    fn a_texture_without_room_above_it_is_not_made_to_clip() {
        let (coat, texture) = Coat::of(&image_bark(0.1, [1.0; 3]), grey(0.9));
        assert!(texture.at(0, 0).albedo[0] <= 1.0);
        assert!(
            (f32::from(coat.tint(1.0)[0]) / 255.0 * texture.at(0, 0).albedo[0] - 0.9).abs() < 0.004
        );
    }

    #[test]
    fn without_a_mature_radius_nothing_is_tinted() {
        let (coat, texture) = Coat::of(&image_bark(0.0, [0.5; 3]), grey(0.2));
        assert_eq!((coat.tint(0.0), texture), (WHITE, grey(0.2)));
    }
}

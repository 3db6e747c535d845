//! Dilation: colour under the transparent texels, so that filtering and mips show no fringe.
//!
//! Pull and push (Gortler et al. 1996, "The lumigraph"): covered texels are averaged into ever smaller
//! images, and each empty texel takes the value of the smallest image that knows one. Alpha stays.

use super::mips::halved;
use super::{Image, Texel};
use rayon::prelude::*;

/// Fills colour, normal, occlusion, roughness, translucency and depth of texels with no alpha.
pub fn dilate(image: &mut Image<Texel>) {
    if image.width() <= 1 && image.height() <= 1 {
        return;
    }
    let mut smaller = halved(image);
    // A quarter of coverage is still a known colour.
    for texel in smaller.texels_mut() {
        texel.alpha = if texel.alpha > 0.0 { 1.0 } else { 0.0 };
    }
    dilate(&mut smaller);
    let width = image.width() as usize;
    let from = &smaller;
    image
        .texels_mut()
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let y = (u32::try_from(y).unwrap_or(0) / 2).min(from.height() - 1);
            for (x, texel) in row.iter_mut().enumerate() {
                if texel.alpha <= 0.0 {
                    let x = (u32::try_from(x).unwrap_or(0) / 2).min(from.width() - 1);
                    *texel = Texel {
                        alpha: 0.0,
                        ..*from.at(x, y)
                    };
                }
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_texels_take_the_nearest_colour_and_stay_empty() {
        let mut image = Image::filled(32, 16, Texel::EMPTY);
        *image.at_mut(3, 3) = Texel {
            albedo: [0.1, 0.4, 0.05],
            alpha: 1.0,
            ..Texel::EMPTY
        };
        *image.at_mut(28, 12) = Texel {
            albedo: [0.4, 0.2, 0.1],
            alpha: 1.0,
            ..Texel::EMPTY
        };
        dilate(&mut image);
        assert_eq!(image.at(0, 0).albedo, [0.1, 0.4, 0.05]);
        assert_eq!(image.at(31, 15).albedo, [0.4, 0.2, 0.1]);
        assert!(image.texels().iter().all(|t| t.albedo != [0.0; 3]));
        assert_eq!(image.texels().iter().filter(|t| t.alpha > 0.0).count(), 2);
    }

    #[test]
    fn an_image_with_nothing_on_it_stays_as_it_is() {
        let mut image = Image::filled(8, 8, Texel::EMPTY);
        dilate(&mut image);
        assert!(image.texels().iter().all(|t| *t == Texel::EMPTY));
    }
}

//! Texels from image files, and resizing.

use crate::image::{Image, Texel};
use crate::math::{float, floor_to_u32, linear_from_srgb};

/// Roughness of a surface of which only the colour is known.
const ROUGHNESS: f32 = 0.75;

/// Surface texels from sRGB colour and alpha: flat, matt and opaque to light from behind.
#[must_use]
pub fn texels_from_srgb(image: &Image<[u8; 4]>) -> Image<Texel> {
    let linear: Vec<f32> = (0..=255).map(linear_from_srgb).collect();
    image.map(|&[r, g, b, a]| Texel {
        albedo: [r, g, b].map(|c| linear[usize::from(c)]),
        alpha: f32::from(a) / 255.0,
        roughness: ROUGHNESS,
        ..Texel::EMPTY
    })
}

/// An image of another size. Each new texel is the mean of the old ones under it; when growing, the
/// nearest one.
#[must_use]
pub fn resized(image: &Image<Texel>, width: u32, height: u32) -> Image<Texel> {
    let span = |at: u32, of: u32, from: u32| {
        let step = float(from) / float(of);
        let low = floor_to_u32(float(at) * step).min(from - 1);
        let high = floor_to_u32((float(at) + 1.0) * step - 1e-3).clamp(low, from - 1);
        (low, high)
    };
    let texels = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let (x0, x1) = span(x, width, image.width());
            let (y0, y1) = span(y, height, image.height());
            mean(image, (x0, x1), (y0, y1))
        });
    Image::from_texels(width, height, texels.collect())
}

fn mean(image: &Image<Texel>, (x0, x1): (u32, u32), (y0, y1): (u32, u32)) -> Texel {
    let mut sum = Texel {
        albedo: [0.0; 3],
        alpha: 0.0,
        roughness: 0.0,
        ..*image.at(x0, y0)
    };
    let (mut weights, mut count) = (0.0, 0.0);
    for y in y0..=y1 {
        for x in x0..=x1 {
            let texel = image.at(x, y);
            // A trace of weight keeps the colour of wholly transparent blocks.
            let weight = texel.alpha.max(1e-4);
            for (mine, theirs) in sum.albedo.iter_mut().zip(texel.albedo) {
                *mine += theirs * weight;
            }
            sum.alpha += texel.alpha;
            sum.roughness += texel.roughness * weight;
            weights += weight;
            count += 1.0;
        }
    }
    sum.albedo = sum.albedo.map(|c| c / weights);
    sum.roughness /= weights;
    sum.alpha /= count;
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_an_image_averages_and_keeps_the_colour_of_what_is_covered() {
        let mut bytes = Image::filled(4, 2, [0, 0, 0, 0]);
        *bytes.at_mut(0, 0) = [255, 255, 255, 255];
        let small = resized(&texels_from_srgb(&bytes), 2, 1);
        assert_eq!(small.at(0, 0).alpha, 0.25);
        assert!(small.at(0, 0).albedo[0] > 0.99);
        assert_eq!(small.at(1, 0).alpha, 0.0);
    }

    #[test]
    fn growing_an_image_repeats_its_texels() {
        let bytes = Image::from_texels(2, 1, vec![[10, 20, 30, 255], [200, 100, 50, 255]]);
        let texels = texels_from_srgb(&bytes);
        let large = resized(&texels, 4, 2);
        assert_eq!(large.at(1, 1), texels.at(0, 0));
        assert_eq!(large.at(2, 0), texels.at(1, 0));
    }
}

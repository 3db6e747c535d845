//! Sheets of what a tree is drawn with: its atlas, its shadows.

use crate::asset::Surface;
use crate::image::Image;
use crate::math::{float, srgb_from_linear};
use crate::shadow::Shadows;

/// The atlas as it is seen: colours where it is covered, white elsewhere.
#[must_use]
pub fn on_white(foliage: &Surface) -> Image<[u8; 4]> {
    foliage.texels().map(|texel| {
        let over = |c: f32| srgb_from_linear(c * texel.alpha + 1.0 - texel.alpha);
        let [r, g, b] = texel.albedo.map(over);
        [r, g, b, 255]
    })
}

/// The nine shadows as a compass has them: the vertical light's in the middle, each other one where its sun
/// stands, north (-Z) up.
#[must_use]
pub fn rose(shadows: &Shadows) -> Image<[u8; 4]> {
    let edge = shadows.maps.first().map_or(0, |map| map.image.width());
    let gap = edge / 16;
    let step = edge + gap;
    let mut sheet = Image::filled(3 * step + gap, 3 * step + gap, [255; 4]);
    for map in &shadows.maps {
        let place = |x: f32| if x > 0.1 { 2 } else { u32::from(x > -0.1) };
        let [x0, y0] = [map.direction.x, map.direction.z].map(|x| place(x) * step + gap);
        let image = map.image_without_code();
        for y in 0..edge {
            for x in 0..edge {
                let light = 1.0 - 0.85 * f32::from(*image.at(x, y)) / 255.0;
                let [r, g, b] = [0.62, 0.58, 0.48].map(|c| srgb_from_linear(c * light));
                *sheet.at_mut(x0 + x, y0 + y) = [r, g, b, 255];
            }
        }
        let [u, v] = map.trunk_base.map(u32::from);
        let radius = edge / 64 + 1;
        for y in v.saturating_sub(radius)..(v + radius).min(edge) {
            for x in u.saturating_sub(radius)..(u + radius).min(edge) {
                let away = libm::hypotf(float(x) - float(u), float(y) - float(v));
                if away < float(radius) {
                    *sheet.at_mut(x0 + x, y0 + y) = [120, 60, 40, 255];
                }
            }
        }
    }
    sheet
}

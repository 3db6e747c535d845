//! The report's pictures of LODs: cut to the tree and encoded.

use super::palette::Palette;
use super::picture::{Crop, Picture};
use super::{Plate, Shown};
use crate::image::Image;
use crate::measure::flip::{PIXELS_PER_DEGREE, flip, magma};

/// Air around the trees, as a part of their height.
const AIR: u32 = 24;

/// Steps of the error maps' colours: finer ones are not told apart, and cost bytes.
const ERROR_STEPS: f32 = 64.0;

/// Pictures of LODs (by their index) from one view at one height, all cut alike, in the same colours and
/// under the first light; FLIP only where there is room to see it. None without LODs, or if there is nothing to see.
pub(super) fn plate(
    full: &Picture,
    lods: &[(usize, Picture)],
    view: &'static str,
    height: u32,
    with_error: bool,
) -> Option<Plate> {
    let mut all = vec![full];
    all.extend(lods.iter().map(|(_, picture)| picture));
    let air = (height / AIR).max(2) as usize;
    let crop = Crop::around(&all, air).filter(|_| !lods.is_empty())?;
    let pictures: Vec<Image<[u8; 3]>> = all.iter().map(|p| crop.image(&p.colours[0])).collect();
    let palette = Palette::of(&pictures.iter().collect::<Vec<_>>());
    let (reference, pictures) = pictures.split_first()?;
    let error = |picture: &Image<[u8; 3]>| {
        let errors = flip(reference, picture, PIXELS_PER_DEGREE).filter(|_| with_error);
        errors.map_or_else(Vec::new, |e| error_png(&e))
    };
    Some(Plate {
        view,
        height,
        reference: palette.png(reference),
        shown: lods
            .iter()
            .zip(pictures)
            .map(|((model, _), picture)| Shown {
                model: *model,
                picture: palette.png(picture),
                error: error(picture),
            })
            .collect(),
    })
}

fn error_png(errors: &Image<f32>) -> Vec<u8> {
    let map = magma(&errors.map(|e| (e * ERROR_STEPS + 0.5).floor() / ERROR_STEPS));
    Palette::of(&[&map]).png(&map)
}

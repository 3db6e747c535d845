//! The report's pictures of LODs: cut to the tree and encoded.

use super::Plate;
use super::picture::{Crop, Picture};
use crate::image::Image;
use crate::image::png::{PngTexel, encode};
use crate::measure::flip::{PIXELS_PER_DEGREE, flip, magma};

/// Air around the trees, as a part of their height.
const AIR: u32 = 24;

/// Pictures of LODs (by their index) from one view at one height, all cut alike; FLIP only where there is room
/// to see it.
pub(super) fn plates(
    full: &Picture,
    lods: &[(usize, Picture)],
    view: &'static str,
    height: u32,
    with_error: bool,
) -> Vec<Plate> {
    let mut all = vec![full];
    all.extend(lods.iter().map(|(_, picture)| picture));
    let air = (height / AIR).max(2) as usize;
    let Some(crop) = Crop::around(&all, air).filter(|_| !lods.is_empty()) else {
        return Vec::new();
    };
    let reference = crop.image(&full.colour);
    let reference_png = png(&reference);
    lods.iter()
        .map(|(model, picture)| {
            let picture = crop.image(&picture.colour);
            let errors = with_error.then(|| flip(&reference, &picture, PIXELS_PER_DEGREE));
            Plate {
                model: *model,
                view,
                height,
                reference: reference_png.clone(),
                picture: png(&picture),
                error: errors.flatten().map_or_else(Vec::new, |e| png(&magma(&e))),
            }
        })
        .collect()
}

/// No bytes if the picture cannot be encoded; the report then says that there is none.
fn png<P: PngTexel>(image: &Image<P>) -> Vec<u8> {
    encode(image).unwrap_or_default()
}

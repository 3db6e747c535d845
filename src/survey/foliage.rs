//! What stands on a leaf card: how many blades, and how much of the card they cover.

use crate::species::schema::{LeafArt, LeafKind, LeafLook};
use crate::species::{Files, schema::Species};
use crate::{image::Image, image::Texel, pipeline, texture};

/// Longer edge of the picture on which covered texels are counted. Twice as many change the area by less than
/// a hundredth.
const PICTURE: u32 = 256;

/// What stands on one card of a leaf kind, at scale 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foliage {
    /// Leaves drawn on it; 1 for an image file, whose leaves nobody can count.
    pub blades: u32,
    /// One side of what is drawn, square metres.
    pub area_m2: f32,
}

/// What stands on a card of each leaf kind of a species.
///
/// # Errors
/// If an image file cannot be read; the text says why.
pub fn foliage(species: &Species, files: &dyn Files) -> Result<Vec<Foliage>, String> {
    species
        .leaves
        .iter()
        .map(|kind| {
            let (blades, picture) = match &kind.look {
                LeafLook::Drawn(art) => {
                    let leaves = texture::leaves_on(kind, art, species.seed);
                    (leaves, drawn(kind, art, species.seed))
                }
                LeafLook::Image(path) => {
                    let image = pipeline::read_image(path, files).map_err(|e| e.to_string())?;
                    (1, image)
                }
            };
            let area_m2 = kind.length_m * kind.width_m * covered(&picture);
            Ok(Foliage { blades, area_m2 })
        })
        .collect()
}

fn drawn(kind: &LeafKind, art: &LeafArt, seed: u64) -> Image<Texel> {
    let longer = kind.length_m.max(kind.width_m);
    let texels = |metres: f32| {
        let part = crate::math::float(PICTURE) * metres / longer;
        crate::math::round_to_u32(part).max(8)
    };
    texture::leaf(
        kind,
        art,
        art.state,
        seed,
        texels(kind.width_m),
        texels(kind.length_m),
    )
}

/// Part of a picture that is leaf: texels at an edge count as far as they are covered.
fn covered(picture: &Image<Texel>) -> f32 {
    let texels = picture.texels();
    let covered: f64 = texels.iter().map(|texel| f64::from(texel.alpha)).sum();
    let all = f64::from(picture.width()) * f64::from(picture.height());
    #[expect(clippy::cast_possible_truncation, reason = "a part of one")]
    let part = (covered / all.max(1.0)) as f32;
    part
}

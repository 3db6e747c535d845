//! What the tests that draw share: a tree that costs little, and how pictures are compared.

use pleach::asset::TreeAsset;
use pleach::image::Image;
use pleach::measure::flip;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::{self, Beside};
use pleach::{capture, shadow};
use std::path::PathBuf;
use std::sync::OnceLock;

pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A species with small textures.
pub(crate) fn grown(name: &str) -> TreeAsset {
    let path = root().join("species").join(name);
    let text = std::fs::read_to_string(&path).expect("species can be read");
    let files = Beside(root().join("species"));
    let species = species::parse(name, &text, &files).expect("species has no faults");
    let settings = Settings {
        full: true,
        captures: capture::Settings {
            atlas_size: 512,
            ..capture::Settings::default()
        },
        bark_size: 128,
        shadows: shadow::Settings {
            size: 128,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    pipeline::generate(&species, &settings, &files, &Quiet).expect("species grows")
}

/// The cheapest species.
pub(crate) fn palm() -> &'static TreeAsset {
    static PALM: OnceLock<TreeAsset> = OnceLock::new();
    PALM.get_or_init(|| grown("palm.ron"))
}

pub(crate) fn rgb(image: &Image<[u8; 4]>) -> Image<[u8; 3]> {
    image.map(|&[r, g, b, _]| [r, g, b])
}

/// Mean FLIP over the whole picture, at 67 pixels a degree.
pub(crate) fn mean_flip(a: &Image<[u8; 4]>, b: &Image<[u8; 4]>) -> f32 {
    let errors = flip::flip(&rgb(a), &rgb(b), flip::PIXELS_PER_DEGREE).expect("one size");
    flip::masked_mean(&errors, &vec![true; errors.texels().len()])
}

/// Covered part of a picture, by its alpha.
pub(crate) fn covered(picture: &Image<[u8; 4]>) -> f32 {
    let sum: u64 = picture.texels().iter().map(|p| u64::from(p[3])).sum();
    sum as f32 / 255.0 / picture.texels().len() as f32
}

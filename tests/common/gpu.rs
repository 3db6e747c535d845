//! What the tests that draw share: the adapter, and a tree that costs little.

use libtest_mimic::{Arguments, Failed, Trial};
use pleach::asset::TreeAsset;
use pleach::gpu::Gpu;
use pleach::image::Image;
use pleach::measure::flip;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::{self, Beside};
use pleach::{capture, shadow};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::OnceLock;

pub(crate) type Outcome = Result<(), Failed>;
pub(crate) type Test = (&'static str, fn() -> Outcome);

/// Runs tests that need a graphics adapter. Without one they show as ignored; with `PLEACH_REQUIRE_GPU=1` they
/// fail.
pub(crate) fn run(tests: &[Test]) -> ExitCode {
    let arguments = Arguments::from_args();
    let adapter = Gpu::headless();
    let required = std::env::var_os("PLEACH_REQUIRE_GPU").is_some();
    let reason = match &adapter {
        Ok(gpu) => {
            eprintln!("drawing with {}", gpu.describe());
            None
        }
        Err(error) => {
            eprintln!("{error}");
            Some(error.to_string())
        }
    };
    let trials = tests
        .iter()
        .map(|&(name, test)| {
            let trial = match (&reason, required) {
                (Some(reason), true) => {
                    let reason = reason.clone();
                    Trial::test(name, move || Err(reason.into()))
                }
                _ => Trial::test(name, test),
            };
            let ignored = reason.is_some() && !required;
            trial
                .with_kind(if ignored { "no graphics adapter" } else { "" })
                .with_ignored_flag(ignored)
        })
        .collect();
    libtest_mimic::run(&arguments, trials).exit_code()
}

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

//! Draws the pictures of the README: `cargo run --release --example pictures -- OUT_DIR SPECIES.ron...`.
//!
//! Writes `trees.png` (each species at full detail, side by side), and for each species `SLUG_lods.png`
//! (full detail and its LODs), `SLUG_atlas.png` and `SLUG_shadows.png`.

use std::error::Error;
use std::path::{Path, PathBuf};

use pleach::asset::TreeAsset;
use pleach::image::png::{self, PngTexel};
use pleach::image::{Image, Texel};
use pleach::pipeline::{self, Settings};
use pleach::preview;
use pleach::report::Quiet;
use pleach::species::{self, Beside};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1).map(PathBuf::from);
    let out = args
        .next()
        .ok_or("usage: pictures OUT_DIR SPECIES.ron...")?;
    std::fs::create_dir_all(&out)?;
    let mut portraits = Vec::new();
    for path in args {
        let asset = grown(&path)?;
        let slug = &asset.slug;
        let portrait = preview::Settings {
            size: [380, 480],
            ..preview::Settings::default()
        };
        portraits.push(preview::picture(&asset.drawable(), &portrait));
        let small = preview::Settings {
            size: [260, 330],
            ..portrait
        };
        write(
            &out.join(format!("{slug}_lods.png")),
            &preview::strip(&asset.drawable(), &small),
        )?;
        write(&out.join(format!("{slug}_atlas.png")), &on_white(&asset))?;
        write(
            &out.join(format!("{slug}_shadows.png")),
            &asset.shadows.atlas().0,
        )?;
    }
    write(&out.join("trees.png"), &preview::side_by_side(&portraits))
}

fn grown(path: &Path) -> Result<TreeAsset, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let files = Beside(path.parent().unwrap_or(Path::new("")).to_owned());
    let species = species::parse(&path.display().to_string(), &text, &files)?;
    let settings = Settings {
        full: true,
        ..Settings::default()
    };
    Ok(pipeline::generate(&species, &settings, &files, &Quiet)?)
}

/// The foliage atlas over white, at half size.
fn on_white(asset: &TreeAsset) -> Image<[u8; 3]> {
    let half = pleach::image::mips::halved(&asset.foliage.texels());
    half.map(|texel| {
        let albedo = texel.albedo.map(|c| c * texel.alpha + (1.0 - texel.alpha));
        let [r, g, b, _] = Texel { albedo, ..*texel }.albedo_bytes();
        [r, g, b]
    })
}

fn write<P: PngTexel>(path: &Path, image: &Image<P>) -> Result<(), Box<dyn Error>> {
    std::fs::write(path, png::encode(image)?)?;
    println!("{}", path.display());
    Ok(())
}

//! Draws trees in the wind: `cargo run --release --example wind -- OUT_DIR SPEED SPECIES.ron...`.
//!
//! Writes `SLUG_wind.png`: the first LOD at rest and at four times, and below it the coarser LODs at the same
//! times, all in one wind of SPEED metres a second from the left.

use std::error::Error;
use std::path::{Path, PathBuf};

use pleach::asset::TreeAsset;
use pleach::image::Image;
use pleach::image::png;
use pleach::math::{Vec2, Vec3};
use pleach::pipeline::{self, Settings};
use pleach::preview;
use pleach::report::Quiet;
use pleach::species::{self, Beside};
use pleach::wind::Wind;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let usage = "usage: wind OUT_DIR SPEED SPECIES.ron...";
    let out = PathBuf::from(args.next().ok_or(usage)?);
    let speed_m_s: f32 = args.next().ok_or(usage)?.parse()?;
    std::fs::create_dir_all(&out)?;
    for path in args.map(PathBuf::from) {
        let asset = grown(&path)?;
        println!("{}: {:?}", asset.slug, asset.wind);
        let file = out.join(format!("{}_wind.png", asset.slug));
        std::fs::write(&file, png::encode(&sheet(asset, speed_m_s))?)?;
        println!("{}", file.display());
    }
    Ok(())
}

fn grown(path: &Path) -> Result<TreeAsset, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let files = Beside(path.parent().unwrap_or(Path::new("")).to_owned());
    let species = species::parse(&path.display().to_string(), &text, &files)?;
    Ok(pipeline::generate(
        &species,
        &Settings::default(),
        &files,
        &Quiet,
    )?)
}

fn sheet(mut asset: TreeAsset, speed_m_s: f32) -> Image<[u8; 3]> {
    // The picture's right-hand direction.
    let (sine, cosine) = libm::sincosf(preview::Settings::default().azimuth);
    let wind = Wind {
        direction: Vec2::new(cosine, -sine),
        speed_m_s,
        gustiness: 1.0,
    };
    let toward = Vec3::new(sine, 0.0, cosine);
    let lods = asset.lods.clone();
    let mut rows = Vec::new();
    for lod in &lods {
        let mut row = Vec::new();
        for time in [None, Some(2.0), Some(3.1), Some(8.0), Some(12.3)] {
            // The first LOD at rest frames all pictures.
            let mut moved = lod.clone();
            if let Some(time) = time {
                moved.mesh = lod.mesh.in_wind(&wind, &asset.wind, time, toward);
            }
            asset.lods = vec![lods[0].clone(), moved];
            let settings = preview::Settings {
                size: [420, 480],
                lod: 1,
                ..preview::Settings::default()
            };
            row.push(preview::picture(&asset.drawable(), &settings));
        }
        rows.push(preview::side_by_side(&row));
    }
    let texels: Vec<[u8; 3]> = rows.iter().flat_map(|r| r.texels().to_vec()).collect();
    let height = rows.iter().map(Image::height).sum();
    Image::from_texels(rows[0].width(), height, texels)
}

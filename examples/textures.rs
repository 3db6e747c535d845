//! Draws barks and leaf cards as PNGs, to look at: `cargo run --release --example textures -- DIR [NAME...]`.
//! Of barks those are drawn whose names hold the first name; leaf kinds that are named are drawn large as well.

mod barks;

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use pleach::image::{Image, Texel};
use pleach::math::{Vec3, float, round_to_u32, srgb_from_linear};
use pleach::species::schema::{LeafKind, LeafLook, LeafState, Species};
use pleach::species::{self, NoFiles};
use pleach::texture;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    barks::sheet(folder, std::env::args().nth(2).as_deref())?;
    let script = include_str!("leaf_kinds.ron");
    let species = species::parse("leaf_kinds.ron", script, &NoFiles)?;
    let season = |season: f32| move |state| LeafState { season, ..state };
    leaf_sheet(&species, |state| state, lit).save(folder.join("leaves.png"))?;
    leaf_sheet(&species, |state| state, |texel| texel.normal_bytes())
        .save(folder.join("leaves-normal.png"))?;
    leaf_sheet(&species, season(1.5), lit).save(folder.join("leaves-turning.png"))?;
    leaf_sheet(&species, season(2.0), lit).save(folder.join("leaves-autumn.png"))?;
    let ill = |state| LeafState {
        health: 0.3,
        ..state
    };
    leaf_sheet(&species, ill, lit).save(folder.join("leaves-ill.png"))?;
    // One kind large, if a name is given.
    for kind in &species.leaves {
        if let LeafLook::Drawn(art) = &kind.look
            && std::env::args().skip(2).any(|name| name == kind.name)
        {
            let [width, height] = card_size(kind, [1024, 1024]);
            let start = Instant::now();
            let card = texture::leaf(kind, art, art.state, 3, width, height);
            println!("large {}: {:?}", kind.name, start.elapsed());
            save(folder, &format!("leaf-{}", kind.name), &card, 1, lit)?;
        }
    }
    Ok(())
}

/// Lambert's law under a slanted sun (from the upper right) and a sky, over light grey.
fn lit(texel: &Texel) -> [u8; 3] {
    let sun = Vec3::new(0.62, 0.42, 0.66).normalize_or(Vec3::Z);
    let normal = Vec3::from_array(texel.normal);
    let half = (sun + Vec3::Z).normalize_or(Vec3::Z);
    let power = 2.0 / (texel.roughness * texel.roughness).max(0.02);
    let shine = libm::powf(normal.dot(half).max(0.0), power) * 0.06 * (1.0 - texel.roughness);
    let light = 1.3 * normal.dot(sun).max(0.0) + 0.4 * texel.occlusion;
    texel.albedo.map(|x| {
        let seen = x * light + shine * light;
        srgb_from_linear(seen * texel.alpha + 0.6 * (1.0 - texel.alpha))
    })
}

fn save(
    folder: &Path,
    name: &str,
    image: &Image<Texel>,
    repeats: u32,
    show: impl Fn(&Texel) -> [u8; 3],
) -> Result<(), Box<dyn Error>> {
    let (width, height) = (image.width(), image.height());
    image::RgbImage::from_fn(width * repeats, height * repeats, |x, y| {
        image::Rgb(show(image.at(x % width, y % height)))
    })
    .save(folder.join(format!("{name}.png")))?;
    Ok(())
}

/// Height of a card on the contact sheet, and the width it may have, texels.
const CELL: [u32; 2] = [300, 320];
/// Cards in a row.
const COLUMNS: u32 = 8;

/// All leaf kinds of `leaf_kinds.ron` side by side, in one state.
fn leaf_sheet(
    species: &Species,
    change: impl Fn(LeafState) -> LeafState,
    show: impl Fn(&Texel) -> [u8; 3],
) -> image::RgbImage {
    let rows = u32::try_from(species.leaves.len()).map_or(1, |count| count.div_ceil(COLUMNS));
    let grey = image::Rgb([203; 3]);
    let mut sheet = image::RgbImage::from_pixel(COLUMNS * CELL[0], rows * CELL[1], grey);
    for (index, kind) in (0_u32..).zip(&species.leaves) {
        let LeafLook::Drawn(art) = &kind.look else {
            continue;
        };
        let [width, height] = card_size(kind, CELL);
        let start = Instant::now();
        let card = texture::leaf(kind, art, change(art.state), 3, width, height);
        println!(
            "leaf {} {width} x {height}: {:?}",
            kind.name,
            start.elapsed()
        );
        let (left, top) = (index % COLUMNS * CELL[0], index / COLUMNS * CELL[1]);
        let left = left + (CELL[0] - width) / 2;
        for y in 0..height {
            for x in 0..width {
                sheet.put_pixel(left + x, top + y, image::Rgb(show(card.at(x, y))));
            }
        }
    }
    sheet
}

/// The largest card of a kind's shape within a box.
fn card_size(kind: &LeafKind, [most_width, most_height]: [u32; 2]) -> [u32; 2] {
    let aspect = kind.width_m / kind.length_m;
    let (width, height) = (float(most_width), float(most_height));
    if aspect * height > width {
        [most_width, round_to_u32(width / aspect)]
    } else {
        [round_to_u32(height * aspect), most_height]
    }
}

//! Barks of many species: each pattern with parameters that suit them, and a sheet to look at them.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use pleach::image::{Image, Texel};
use pleach::math::{TAU, Vec3, floor_to_u32, linear_from_srgb, srgb_from_linear};
use pleach::species::schema::{BarkArt, BarkPattern};
use pleach::texture;

/// Edge of a drawn tile, texels.
const TILE: u32 = 512;
/// Edge of a picture on the sheet, pixels.
const CELL: u32 = 256;
/// Radius of the stem on the sheet, metres.
const STEM_M: f32 = 0.2;
/// Ages of the last picture of a row, from left to right.
const AGES: [f32; 4] = [0.0, 0.3, 0.5, 0.8];

/// Barks on one sheet.
const PER_SHEET: usize = 10;

/// Draws each bark, and sheets of ten: a row holds two barks, and of each the tile as it is lit,
/// twice by twice; its albedo; a stem of 20 cm radius; four ages.
pub(crate) fn sheet(folder: &Path, only: Option<&str>) -> Result<(), Box<dyn Error>> {
    let barks = all();
    let shown: Vec<_> = barks
        .iter()
        .filter(|(name, _)| only.is_none_or(|part| name.contains(part)))
        .collect();
    for (barks, number) in shown.chunks(PER_SHEET).zip(1..) {
        let rows = u32::try_from(barks.len().div_ceil(2))?;
        let mut sheet = image::RgbImage::new(8 * CELL, rows * CELL);
        draw(folder, barks, &mut sheet)?;
        sheet.save(folder.join(format!("barks-{number}.png")))?;
    }
    Ok(())
}

fn draw(
    folder: &Path,
    barks: &[&(&str, BarkArt)],
    sheet: &mut image::RgbImage,
) -> Result<(), Box<dyn Error>> {
    for (&(name, art), i) in barks.iter().zip(0..) {
        let start = Instant::now();
        let tile = texture::bark(art, 7, TILE);
        let took = start.elapsed();
        let texels = tile.texels();
        let mean: [f32; 3] = [0, 1, 2]
            .map(|i| texels.iter().map(|t| t.albedo[i]).sum::<f32>() / texels.len() as f32);
        println!("bark {name}: {took:?}, mean albedo {mean:.3?}");
        let [x0, y0] = [i % 2 * 4 * CELL, i / 2 * CELL];
        let ages = AGES.map(|age| {
            let art = BarkArt { age, ..art.clone() };
            texture::bark(&art, 7, TILE / 4)
        });
        for y in 0..CELL {
            for x in 0..CELL {
                let pictures = [
                    lit(tile.at(2 * (x * 2 % CELL), 2 * (y * 2 % CELL))),
                    flat(tile.at(2 * x, 2 * y)),
                    stem(&tile, art.height_m, x, y),
                    aged(&ages, x, y),
                ];
                for (picture, column) in pictures.into_iter().zip(0..) {
                    sheet.put_pixel(x0 + column * CELL + x, y0 + y, image::Rgb(picture));
                }
            }
        }
        image::RgbImage::from_fn(TILE, TILE, |x, y| image::Rgb(lit(tile.at(x, y))))
            .save(folder.join(format!("bark-{name}.png")))?;
    }
    Ok(())
}

/// Lambert's law under a slanted sun (from the upper right) and a sky.
fn lit(texel: &Texel) -> [u8; 3] {
    shaded(
        texel,
        Vec3::from_array(texel.normal),
        Vec3::new(0.62, 0.42, 0.66),
    )
}

fn shaded(texel: &Texel, normal: Vec3, sun: Vec3) -> [u8; 3] {
    let sun = sun.normalize_or(Vec3::Z);
    let half = (sun + Vec3::Z).normalize_or(Vec3::Z);
    let power = 2.0 / (texel.roughness * texel.roughness).max(0.02);
    let shine = libm::powf(normal.dot(half).max(0.0), power) * 0.25 * (1.0 - texel.roughness);
    let light = 1.6 * normal.dot(sun).max(0.0) + 0.5 * texel.occlusion;
    texel
        .albedo
        .map(|x| srgb_from_linear(x * light + shine * light))
}

fn flat(texel: &Texel) -> [u8; 3] {
    let [r, g, b, _] = texel.albedo_bytes();
    [r, g, b]
}

/// A pixel of an upright stem, with as many repeats around as `mesh::tube` gives it.
fn stem(tile: &Image<Texel>, height_m: f32, x: u32, y: u32) -> [u8; 3] {
    let across = (x as f32 + 0.5) / CELL as f32 * 2.4 - 1.2;
    if across.abs() >= 1.0 {
        return [150, 160, 170];
    }
    let angle = libm::asinf(across);
    let repeats = (TAU * STEM_M / height_m).round().max(1.0);
    let up = (1.0 - (y as f32 + 0.5) / CELL as f32) * 2.4 * STEM_M;
    let u = (angle / TAU + 0.5) * repeats;
    let v = up / height_m;
    let wrapped = |x: f32| floor_to_u32((x - x.floor()) * TILE as f32).min(TILE - 1);
    let texel = tile.at(wrapped(u), wrapped(-v));
    let [nx, ny, nz] = texel.normal;
    let (sine, cosine) = libm::sincosf(angle);
    let normal = Vec3::new(nx * cosine + nz * sine, ny, nz * cosine - nx * sine);
    shaded(texel, normal, Vec3::new(0.62, 0.42, 0.66))
}

fn aged(ages: &[Image<Texel>; 4], x: u32, y: u32) -> [u8; 3] {
    let half = CELL / 2;
    let age = &ages[(x / half + 2 * (y / half)) as usize];
    lit(age.at(x % half, y % half))
}

fn hex(rgb: u32) -> [f32; 3] {
    let [_, r, g, b] = rgb.to_be_bytes();
    [r, g, b].map(linear_from_srgb)
}

/// Colours: light, dark, accent, young.
type Colours = [u32; 4];
/// Metres: one repeat, depth, width and length of a part.
type Sizes = [f32; 4];

fn art(pattern: BarkPattern, colours: Colours, sizes: Sizes, roughness: f32) -> BarkArt {
    let [light, dark, accent, young] = colours.map(hex);
    let [height_m, depth_m, width_m, length_m] = sizes;
    BarkArt {
        pattern,
        light,
        dark,
        accent,
        young,
        mature_radius_m: 0.0,
        height_m,
        depth_m,
        width_m,
        length_m,
        age: 1.0,
        roughness,
        lichen: 0.0,
        moss: 0.0,
    }
}

fn grown_over(art: BarkArt, lichen: f32, moss: f32) -> BarkArt {
    BarkArt {
        lichen,
        moss,
        ..art
    }
}

/// By name.
#[rustfmt::skip]
fn all() -> Vec<(&'static str, BarkArt)> {
    use BarkPattern::{
        Banded, Fibrous, Gnarled, Lattice, Mosaic, Papery, Plates, Ridged, Rings, Smooth,
    };
    let ridged = |braid, flat, cracks| Ridged { braid, flat, cracks };
    let smooth = |wrinkles, lenticels, scars| Smooth { wrinkles, lenticels, scars };
    let papery = |lenticels, peel, diamonds| Papery { lenticels, peel, diamonds };
    let plates = |flakes, lift| Plates { flakes, lift };
    vec![
        ("poplar", art(ridged(0.5, 0.2, 0.45), [0x8a_8073, 0x35_2f27, 0x5a_4432, 0x8f_8a6c], [1.2, 0.035, 0.07, 0.3], 0.9)),
        ("aspen", art(papery(0.25, 0.0, 0.3), [0xa8_a79d, 0x2e_2b26, 0x9b_9a7c, 0x7f_8266], [0.9, 0.004, 0.1, 0.06], 0.65)),
        ("birch", art(papery(0.7, 0.3, 0.35), [0xc2_beb4, 0x2b_2724, 0xa0_8a74, 0x5c_3f31], [0.9, 0.008, 0.13, 0.17], 0.55)),
        ("oak", grown_over(art(ridged(0.15, 0.35, 0.6), [0x82_786a, 0x2e_2820, 0x5c_4330, 0x77_7263], [1.0, 0.035, 0.045, 0.28], 0.92), 0.15, 0.25)),
        ("beech", grown_over(art(smooth(0.6, 0.15, 0.3), [0x90_908b, 0x6c_6c67, 0x38_3733, 0x63_5c50], [0.9, 0.004, 0.16, 0.12], 0.7), 0.12, 0.1)),
        ("maple", art(ridged(0.55, 0.5, 0.25), [0x82_7b70, 0x45_3e35, 0x5a_4838, 0x7a_7159], [0.7, 0.012, 0.028, 0.12], 0.88)),
        ("willow", art(ridged(0.3, 0.1, 0.5), [0x78_7065, 0x29_251f, 0x4c_3c2d, 0x8d_8448], [1.0, 0.035, 0.06, 0.17], 0.92)),
        ("ash", art(ridged(1.0, 0.25, 0.1), [0x98_9487, 0x46_4137, 0x5c_503f, 0x8b_8d78], [0.8, 0.022, 0.048, 0.19], 0.88)),
        ("chestnut", art(plates(0.35, 0.35), [0x79_7064, 0x38_3129, 0x86_6e58, 0x80_7566], [0.8, 0.014, 0.06, 0.12], 0.9)),
        ("plane", art(Mosaic { shed: 0.6 }, [0xae_a588, 0x66_5f52, 0x82_8064, 0x6e_6c4c], [1.0, 0.006, 0.11, 0.14], 0.65)),
        ("lime", art(ridged(0.25, 0.85, 0.15), [0x7e_776a, 0x3b_352c, 0x55_4636, 0x6e_5f4b], [0.8, 0.016, 0.035, 0.26], 0.88)),
        ("elm", art(ridged(0.35, 0.55, 0.35), [0x8a_8276, 0x36_302a, 0x6a_5544, 0x77_6a58], [1.0, 0.03, 0.06, 0.22], 0.9)),
        ("cherry", art(Banded { lenticels: 0.6, peel: 0.25 }, [0x70_4639, 0x3b_231d, 0x8c_7058, 0x6b_4334], [0.6, 0.004, 0.024, 0.045], 0.42)),
        ("japanese-maple", art(smooth(0.25, 0.35, 0.0), [0x80_7f70, 0x5b_5a4b, 0x9b_9380, 0x5d_6a3c], [0.6, 0.002, 0.09, 0.2], 0.68)),
        ("olive", art(Gnarled { scales: 0.5 }, [0x8d_867a, 0x3b_352d, 0x7d_6a55, 0x8b_8d80], [0.7, 0.03, 0.045, 0.095], 0.87)),
        ("thorn", art(ridged(0.3, 0.3, 0.8), [0x6c_6154, 0x24_1f1a, 0x4f_3a2b, 0x7f_6850], [0.7, 0.018, 0.03, 0.1], 0.92)),
        ("spruce", art(plates(0.3, 0.8), [0x7a_6a5e, 0x40_332b, 0x8a_6a58, 0x8a_6a48], [0.5, 0.006, 0.02, 0.028], 0.88)),
        ("pine-below", art(plates(0.8, 0.1), [0x80_7064, 0x2c_231d, 0x94_6a50, 0x9a_7048], [1.2, 0.03, 0.11, 0.24], 0.9)),
        ("pine-above", art(plates(0.9, 0.5), [0x9a_6844, 0x6c_4128, 0xae_8058, 0x9a_7048], [0.6, 0.0035, 0.06, 0.075], 0.72)),
        ("larch", art(plates(0.6, 0.25), [0x86_7064, 0x34_2822, 0x97_6657, 0x9a_8058], [1.0, 0.03, 0.06, 0.14], 0.9)),
        ("cypress", art(Fibrous { shreds: 0.35 }, [0x80_6c5b, 0x3a_2c23, 0x8b_8278, 0x6c_5a40], [0.8, 0.012, 0.035, 0.5], 0.9)),
        ("redwood", art(Fibrous { shreds: 0.5 }, [0x8c_5c43, 0x35_1e15, 0x86_7466, 0x7c_5a3a], [1.6, 0.06, 0.1, 0.8], 0.92)),
        ("stone-pine", art(plates(0.7, 0.0), [0x8e_6e5a, 0x2e_221c, 0xa3_7253, 0x8f_6d50], [1.4, 0.035, 0.14, 0.36], 0.88)),
        ("coconut", art(Rings { fissures: 0.55 }, [0x93_897b, 0x4f_463b, 0xa0_9584, 0x86_7d60], [0.5, 0.012, 0.016, 0.06], 0.88)),
        ("date-palm", art(Lattice { boots: 0.6 }, [0x80_7261, 0x30_2821, 0x98_8365, 0x86_7d60], [1.0, 0.05, 0.14, 0.11], 0.9)),
        ("fan-palm", art(Rings { fissures: 0.9 }, [0x85_7d72, 0x45_3e36, 0x8e_8578, 0x86_7d60], [0.5, 0.008, 0.012, 0.022], 0.88)),
        ("hazel", art(smooth(0.2, 0.55, 0.0), [0x86_7660, 0x60_523d, 0x98_8a70, 0x78_6a50], [0.5, 0.0015, 0.08, 0.16], 0.6)),
    ]
}

//! Draws barks and leaf cards as PNGs, to look at:
//! `cargo run --release --example textures -- DIR [NAME]`, where NAME is a part of a bark's name.

mod barks;

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use pleach::image::{Image, Texel};
use pleach::math::{Vec3, linear_from_srgb, srgb_from_linear};
use pleach::species::schema::{Arrangement, Blade, LeafArt, LeafKind, LeafLook};
use pleach::texture;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    barks::sheet(folder, std::env::args().nth(2).as_deref())?;
    for (name, kind, size) in leaves() {
        let LeafLook::Drawn(art) = &kind.look else {
            continue;
        };
        let start = Instant::now();
        let card = texture::leaf(&kind, art, 3, size[0], size[1]);
        println!("leaf {name}: {:?}", start.elapsed());
        save(folder, &format!("leaf-{name}-lit"), &card, 1, lit)?;
        save(folder, &format!("leaf-{name}-albedo"), &card, 1, flat)?;
        save(folder, &format!("leaf-{name}-normal"), &card, 1, |texel| {
            texel.normal_bytes()
        })?;
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

fn flat(texel: &Texel) -> [u8; 3] {
    let [r, g, b, _] = texel.albedo_bytes();
    [r, g, b]
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

fn hex(rgb: u32) -> [f32; 3] {
    let [_, r, g, b] = rgb.to_be_bytes();
    [r, g, b].map(linear_from_srgb)
}

fn leaves() -> Vec<(&'static str, LeafKind, [u32; 2])> {
    let blade = |width, widest, sharpness, teeth, veins| Blade {
        width,
        widest,
        sharpness,
        teeth,
        tooth_depth: 0.1,
        veins,
    };
    let kind = |name, size: [f32; 2], arrangement, blade, colour, gloss| LeafKind {
        name: String::from(name),
        length_m: size[0],
        width_m: size[1],
        fold_deg: 0.0,
        look: LeafLook::Drawn(LeafArt {
            arrangement,
            blade,
            colour: hex(colour),
            colour_vary: 0.14,
            stalk_colour: hex(0x7a_7358),
            gloss,
            translucency: 0.4,
        }),
    };
    let olive = Arrangement::Opposite {
        pairs: 5,
        angle_deg: 45.0,
        blade: 0.42,
    };
    let poplar = Arrangement::Alternate {
        count: 5,
        angle_deg: 60.0,
        blade: 0.36,
    };
    let slim = blade(0.2, 0.5, 0.7, 0, 7);
    let deltoid = blade(0.9, 0.3, 0.8, 14, 6);
    let ribbon = blade(0.07, 0.4, 0.35, 0, 5);
    let elliptic = blade(0.5, 0.45, 0.6, 12, 8);
    vec![
        (
            "olive",
            kind("olive", [0.14, 0.075], olive, slim, 0x56_694a, 0.4),
            [256, 512],
        ),
        (
            "poplar",
            kind("poplar", [0.2, 0.16], poplar, deltoid, 0x4a_6a2c, 0.35),
            [512, 512],
        ),
        (
            "palm",
            kind(
                "palm",
                [0.7, 0.05],
                Arrangement::Single,
                ribbon,
                0x4f_6a2f,
                0.4,
            ),
            [64, 512],
        ),
        (
            "single",
            kind(
                "s",
                [0.1, 0.06],
                Arrangement::Single,
                elliptic,
                0x4a_6333,
                0.3,
            ),
            [256, 512],
        ),
    ]
}

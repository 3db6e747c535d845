//! The plate of a species: the tree and its silhouette, a leaf card and the bark from near, and below them the
//! chain of LODs.

use crate::asset::TreeAsset;
use crate::image::atlas::Rect;
use crate::image::cutouts::Cutouts;
use crate::image::{Image, Texel};
use crate::math::{Vec3, float, floor_to_u32, round_to_u32, srgb_from_linear};
use crate::measure::silhouette::Silhouette;
use crate::mesh::WHITE;
use crate::preview::{self, Settings};
use crate::species::schema::Species;

/// A picture's pixels, sRGB.
pub type Paint = Image<[u8; 3]>;

/// Sizes of the tree's picture, of its silhouette, and of the leaf and the bark, one above the other.
const TREE: [u32; 2] = [400, 460];
const SHADE: [u32; 2] = [360, 460];
const NEAR: [u32; 2] = [230, 230];

/// Size of the LODs' row.
const CHAIN: [u32; 2] = [990, 250];

/// Samples along each edge of a silhouette's pixel.
const FINE: u32 = 3;

const PAPER: [u8; 3] = [244, 243, 239];
const INK: [u8; 3] = [34, 36, 32];

/// Light on leaf and bark, as a vector toward it.
const LIGHT: Vec3 = Vec3::new(-0.45, 0.55, 0.7);
const AROUND: f32 = 0.45;
const SUN: f32 = 1.5;

/// The plate of a species' tree whose first LOD is full detail, 990 x 710 pixels.
#[must_use]
pub fn plate(species: &Species, tree: &TreeAsset) -> Paint {
    let mut plate = Image::filled(CHAIN[0], TREE[1] + CHAIN[1], PAPER);
    let drawable = tree.drawable();
    let of = |size, lod| Settings {
        size,
        lod,
        ..Settings::default()
    };
    put(
        &mut plate,
        [0, 0],
        &preview::picture(&drawable, &of(TREE, 0)),
    );
    put(&mut plate, [TREE[0], 0], &silhouette(tree));
    let column = TREE[0] + SHADE[0];
    put(&mut plate, [column, 0], &leaf(species, tree));
    put(&mut plate, [column, NEAR[1]], &bark(tree));
    let lods = tree.lods.len().saturating_sub(1).max(1);
    let count = u32::try_from(lods).unwrap_or(1);
    for index in 0..count {
        let edge = |i: u32| CHAIN[0] * i / count;
        let lod = tree.lods.len() - lods + index as usize;
        let size = [edge(index + 1) - edge(index), CHAIN[1]];
        let picture = preview::picture(&drawable, &of(size, lod));
        put(&mut plate, [edge(index), TREE[1]], &picture);
    }
    plate
}

fn put(plate: &mut Paint, [x0, y0]: [u32; 2], picture: &Paint) {
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            *plate.at_mut(x0 + x, y0 + y) = *picture.at(x, y);
        }
    }
}

/// Full detail, black on paper.
fn silhouette(tree: &TreeAsset) -> Paint {
    let settings = Settings {
        size: SHADE,
        supersample: FINE,
        elevation: 0.0,
        ..Settings::default()
    };
    let view = preview::framed(&tree.drawable(), &settings);
    let cutouts = Cutouts::of(&tree.foliage.texels());
    let seen = Silhouette::of(&tree.lods[0].mesh, &cutouts, &view);
    let samples = (0..FINE * FINE).map(|i| [i % FINE, i / FINE]);
    let covered = |x: u32, y: u32| {
        let at = |[i, j]: [u32; 2]| {
            seen.covered[(y * FINE + j) as usize * seen.width as usize + (x * FINE + i) as usize]
        };
        let count = samples.clone().filter(|&sample| at(sample)).count();
        float(u32::try_from(count).unwrap_or(0)) / float(FINE * FINE)
    };
    drawn(SHADE, |x, y| mixed(PAPER, INK, covered(x, y)))
}

/// The first leaf kind's card on paper, as large as fits.
fn leaf(species: &Species, tree: &TreeAsset) -> Paint {
    let (Some(kind), Some(rect)) = (species.leaves.first(), tree.rects.get(tree.captures)) else {
        return Image::filled(NEAR[0], NEAR[1], PAPER);
    };
    let inner = Rect {
        x: rect.x + 1,
        y: rect.y + 1,
        width: rect.width - 2,
        height: rect.height - 2,
    };
    let card = tree.foliage.texels();
    let card = card.part(inner.x, inner.y, inner.width, inner.height);
    let scale = (float(NEAR[0]) / kind.width_m).min(float(NEAR[1]) / kind.length_m) * 0.92;
    let [across, down] = [kind.width_m, kind.length_m].map(|side| side * scale);
    drawn(NEAR, |x, y| {
        let u = (float(x) + 0.5 - float(NEAR[0]) * 0.5) / across + 0.5;
        let v = (float(y) + 0.5 - float(NEAR[1]) * 0.5) / down + 0.5;
        if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
            return PAPER;
        }
        let texel = between(&card, u, v);
        mixed(PAPER, lit(&texel), texel.alpha)
    })
}

/// Bark at a texel a pixel, or more where it has few, as it is at the trunk's foot.
fn bark(tree: &TreeAsset) -> Paint {
    let mut texels = tree.bark.texels();
    let foot = tree.lods[0].mesh.bark.vertices.first();
    let tint = foot.map_or(WHITE, |vertex| vertex.tint);
    for texel in texels.texels_mut() {
        for (part, tint) in texel.albedo.iter_mut().zip(tint) {
            *part *= f32::from(tint) / 255.0;
        }
    }
    let part = texels.width().min(texels.height()).min(2 * NEAR[0]);
    drawn(NEAR, |x, y| {
        let at = |pixel: u32, of: u32| (float(pixel) + 0.5) / float(of) * float(part);
        let (u, v) = (at(x, NEAR[0]), at(y, NEAR[1]));
        lit(&between(
            &texels,
            u / float(texels.width()),
            v / float(texels.height()),
        ))
    })
}

fn drawn(size: [u32; 2], mut pixel: impl FnMut(u32, u32) -> [u8; 3]) -> Paint {
    let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    Image::from_texels(size[0], size[1], places.map(|(x, y)| pixel(x, y)).collect())
}

/// A texel's colour under a plain light.
fn lit(texel: &Texel) -> [u8; 3] {
    let facing = Vec3::from(texel.normal)
        .dot(LIGHT.normalize_or(Vec3::Z))
        .max(0.0);
    let light = AROUND * texel.occlusion + SUN * facing;
    texel.albedo.map(|c| srgb_from_linear(c * light))
}

fn mixed(under: [u8; 3], over: [u8; 3], part: f32) -> [u8; 3] {
    let mix = |k: usize| {
        let under = f32::from(under[k]);
        under + (f32::from(over[k]) - under) * part
    };
    core::array::from_fn(|k| u8::try_from(round_to_u32(mix(k))).unwrap_or(u8::MAX))
}

/// The mean of the four texels around a place, which is given as parts of the image.
fn between(image: &Image<Texel>, u: f32, v: f32) -> Texel {
    let place = |part: f32, size: u32| (part * float(size) - 0.5).clamp(0.0, float(size - 1));
    let (x, y) = (place(u, image.width()), place(v, image.height()));
    let (x0, y0) = (floor_to_u32(x), floor_to_u32(y));
    let (x1, y1) = (
        (x0 + 1).min(image.width() - 1),
        (y0 + 1).min(image.height() - 1),
    );
    let (fx, fy) = (x - float(x0), y - float(y0));
    let corners = [
        (image.at(x0, y0), (1.0 - fx) * (1.0 - fy)),
        (image.at(x1, y0), fx * (1.0 - fy)),
        (image.at(x0, y1), (1.0 - fx) * fy),
        (image.at(x1, y1), fx * fy),
    ];
    let mix = |f: fn(&Texel) -> f32| corners.iter().map(|(t, w)| f(t) * w).sum::<f32>();
    Texel {
        albedo: [
            mix(|t| t.albedo[0]),
            mix(|t| t.albedo[1]),
            mix(|t| t.albedo[2]),
        ],
        alpha: mix(|t| t.alpha),
        normal: [
            mix(|t| t.normal[0]),
            mix(|t| t.normal[1]),
            mix(|t| t.normal[2]),
        ],
        occlusion: mix(|t| t.occlusion),
        ..Texel::EMPTY
    }
}

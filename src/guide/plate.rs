//! The plate of a species: the tree and its silhouette, a leaf card and the bark from near, and below them the
//! chain of LODs.

use crate::asset::TreeAsset;
use crate::image::Image;
use crate::image::cutouts::Cutouts;
use crate::math::float;
use crate::measure::silhouette::Silhouette;
use crate::preview::closeups::{self, Channel, PAPER, Paint, drawn, mixed};
use crate::preview::{self, Settings};
use crate::species::schema::Species;

/// Sizes of the tree's picture, of its silhouette, and of the leaf and the bark, one above the other.
const TREE: [u32; 2] = [400, 460];
const SHADE: [u32; 2] = [360, 460];
const NEAR: [u32; 2] = [230, 230];

/// Size of the LODs' row.
const CHAIN: [u32; 2] = [990, 250];

/// Samples along each edge of a silhouette's pixel.
const FINE: u32 = 3;

const INK: [u8; 3] = [34, 36, 32];

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
    let leaf = species.leaves.first().map(|kind| {
        let card = [kind.width_m, kind.length_m];
        closeups::leaf(tree, (0, card), NEAR, Channel::Lit)
    });
    if let Some(leaf) = leaf.flatten() {
        put(&mut plate, [column, 0], &leaf);
    }
    let bark = closeups::bark(tree, NEAR, Channel::Lit);
    put(&mut plate, [column, NEAR[1]], &bark);
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

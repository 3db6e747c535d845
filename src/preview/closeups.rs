//! A leaf card and the bark from near, under a plain light.

use crate::asset::TreeAsset;
use crate::image::{Image, Texel};
use crate::math::{Vec3, float, floor_to_u32, round_to_u32, srgb_from_linear};
use crate::mesh::WHITE;

/// A picture's pixels, sRGB.
pub type Paint = Image<[u8; 3]>;

/// What leaves lie on.
pub const PAPER: [u8; 3] = [244, 243, 239];

/// Light on leaf and bark, as a vector toward it.
const LIGHT: Vec3 = Vec3::new(-0.45, 0.55, 0.7);
const AROUND: f32 = 0.45;
const SUN: f32 = 1.5;

/// What is shown of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Its colour under a light from the upper left.
    #[default]
    Lit,
    /// The light that comes through from behind.
    Through,
    /// The colour alone.
    Colour,
    /// Normals, as bytes have them.
    Normals,
    /// Roughness, white where it is matt.
    Roughness,
    /// Ambient light that arrives.
    Occlusion,
}

impl Channel {
    /// Those that a leaf has something to tell in, with their names.
    pub const OF_LEAVES: &[(Self, &str)] = &[
        (Self::Lit, "lit"),
        (Self::Through, "from behind"),
        (Self::Colour, "colour"),
        (Self::Normals, "normals"),
        (Self::Roughness, "roughness"),
        (Self::Occlusion, "occlusion"),
    ];

    /// Those that a bark has something to tell in, with their names.
    pub const OF_BARK: &[(Self, &str)] = &[
        (Self::Lit, "lit"),
        (Self::Colour, "colour"),
        (Self::Normals, "normals"),
        (Self::Roughness, "roughness"),
        (Self::Occlusion, "occlusion"),
    ];

    /// A texel over [`PAPER`].
    pub(crate) fn on_paper(self, texel: &Texel) -> [u8; 3] {
        mixed(PAPER, self.of(texel), texel.alpha)
    }

    /// A texel's colour.
    pub(crate) fn of(self, texel: &Texel) -> [u8; 3] {
        match self {
            Self::Lit => {
                let facing = Vec3::from(texel.normal)
                    .dot(LIGHT.normalize_or(Vec3::Z))
                    .max(0.0);
                let light = AROUND * texel.occlusion + SUN * facing;
                texel.albedo.map(|c| srgb_from_linear(c * light))
            }
            Self::Through => {
                let light = (AROUND * texel.occlusion + SUN) * texel.translucency;
                texel.albedo.map(|c| srgb_from_linear(c * light))
            }
            Self::Colour => texel.albedo.map(srgb_from_linear),
            Self::Normals => texel.normal_bytes(),
            Self::Roughness => grey(texel.roughness),
            Self::Occlusion => grey(texel.occlusion),
        }
    }
}

fn grey(part: f32) -> [u8; 3] {
    [u8::try_from(round_to_u32(part.clamp(0.0, 1.0) * 255.0)).unwrap_or(u8::MAX); 3]
}

/// A leaf kind's card on [`PAPER`], as large as fits: the kind by number, and its width and length in metres.
/// `None` if the tree's atlas has no such kind.
#[must_use]
pub fn leaf(
    tree: &TreeAsset,
    (kind, card): (usize, [f32; 2]),
    size: [u32; 2],
    channel: Channel,
) -> Option<Paint> {
    let rect = tree.rects.get(tree.captures + kind)?;
    // Without the free border.
    let [width, height] = [rect.width, rect.height].map(|edge| edge.saturating_sub(2).max(1));
    let texels = tree.foliage.part(rect.x + 1, rect.y + 1, width, height);
    let texels = texels.texels();
    let scale = (float(size[0]) / card[0]).min(float(size[1]) / card[1]) * 0.92;
    let [across, down] = card.map(|side| side * scale);
    Some(drawn(size, |x, y| {
        let u = (float(x) + 0.5 - float(size[0]) * 0.5) / across + 0.5;
        let v = (float(y) + 0.5 - float(size[1]) * 0.5) / down + 0.5;
        if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
            return PAPER;
        }
        let texel = between(&texels, u, v);
        channel.on_paper(&texel)
    }))
}

/// Bark as it is at the trunk's foot, at a texel a pixel, or more where it has few.
#[must_use]
pub fn bark(tree: &TreeAsset, size: [u32; 2], channel: Channel) -> Paint {
    let [width, height] = [tree.bark.albedo.width(), tree.bark.albedo.height()];
    let part = width.min(height).min(2 * size[0]);
    // A texel more on each side, for what lies between two of them.
    let [w, h] = [width, height].map(|edge| (part + 1).min(edge));
    let mut texels = tree.bark.part(0, 0, w, h).texels();
    let foot = tree.lods[0].mesh.bark.vertices.first();
    let tint = foot.map_or(WHITE, |vertex| vertex.tint);
    for texel in texels.texels_mut() {
        for (part, tint) in texel.albedo.iter_mut().zip(tint) {
            *part *= f32::from(tint) / 255.0;
        }
    }
    drawn(size, |x, y| {
        let at = |pixel: u32, of: u32| (float(pixel) + 0.5) / float(of) * float(part);
        let (u, v) = (at(x, size[0]), at(y, size[1]));
        channel.of(&between(&texels, u / float(w), v / float(h)))
    })
}

/// A picture by its pixels.
pub(crate) fn drawn(size: [u32; 2], mut pixel: impl FnMut(u32, u32) -> [u8; 3]) -> Paint {
    let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    Image::from_texels(size[0], size[1], places.map(|(x, y)| pixel(x, y)).collect())
}

/// One colour over another, which it covers in part.
pub(crate) fn mixed(under: [u8; 3], over: [u8; 3], part: f32) -> [u8; 3] {
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
    let mix = |f: &dyn Fn(&Texel) -> f32| corners.iter().map(|(t, w)| f(t) * w).sum::<f32>();
    Texel {
        albedo: core::array::from_fn(|k| mix(&|t| t.albedo[k])),
        alpha: mix(&|t| t.alpha),
        normal: core::array::from_fn(|k| mix(&|t| t.normal[k])),
        occlusion: mix(&|t| t.occlusion),
        roughness: mix(&|t| t.roughness),
        translucency: mix(&|t| t.translucency),
        depth: 0.0,
    }
}

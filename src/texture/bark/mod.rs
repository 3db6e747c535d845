//! Bark as one tile that repeats around the stem and along it.
//!
//! Each pattern is a height field from periodic noise whose cells are sized in metres, so a taller
//! tile holds more ridges and not larger ones. Normal and occlusion follow from the height field at
//! its real depth; colour follows from height, grain and blotches. `age` blends the pattern with the
//! smooth skin of a twig, patch by patch; lichen and moss come last. The top of the image is up the
//! stem. Cost: 10 to 20 noise samples and 1 to 4 cellular ones a texel, and two blurs of the height
//! field.

mod cover;
mod loom;
mod palms;
mod plane;
mod plates;
mod ridged;
mod skins;
#[cfg(test)]
mod tests;

use self::cover::{Cover, Skin, mixed};
use self::loom::Loom;
use self::palms::{Lattice, Rings};
use self::plane::Plane;
use self::plates::{Mosaic, Plates};
use self::ridged::{Fibrous, Gnarled, Ridged};
use self::skins::{Banded, Papery, Smooth};
use super::noise::Periodic;
use super::texels_from_rows;
use crate::image::{Image, Texel};
use crate::math::{lerp, round_to_u32};
use crate::species::schema::{BarkArt, BarkPattern};

/// Radii of the two occlusion blurs, metres: the furrow's own width, and the nearer surroundings.
const OCCLUSION_RADII_M: [f32; 2] = [0.006, 0.02];
/// Occlusion never falls below this: a furrow is open at its top.
const OCCLUSION_FLOOR: f32 = 0.35;

/// A seamless tile of bark, `size` by `size` texels; `height_m` high and wide in reality.
///
/// Texels are opaque (alpha 1) with translucency and depth 0. Any size is valid; 0 gives an empty
/// plane. Heights and depths that are not positive give flat bark.
#[must_use]
pub fn bark(art: &BarkArt, seed: u64, size: u32) -> Image<Texel> {
    let drawing = Drawing::new(art, seed);
    let (points, height) = drawing.relief(size);
    let texel_m = art.height_m.max(1e-3) / size.max(1) as f32;
    let depth_m = art.depth_m.max(0.0);
    let blurs = OCCLUSION_RADII_M.map(|radius_m| height.blurred(round_to_u32(radius_m / texel_m)));
    let texels = texels_from_rows(size, size, Texel::EMPTY, |x, y| {
        let index = height.index(x, y);
        let cavity: f32 = blurs
            .iter()
            .zip(OCCLUSION_RADII_M)
            .map(|(blur, radius_m)| {
                (blur.values[index] - height.values[index]).max(0.0) * depth_m / radius_m
            })
            .sum();
        let occlusion = (1.0 - 0.55 * cavity).max(OCCLUSION_FLOOR);
        let (albedo, roughness) = drawing.surface(&points[index], place(size, x, y));
        Texel {
            albedo,
            alpha: 1.0,
            normal: height.normal(x, y, depth_m / texel_m),
            occlusion,
            roughness: (roughness + 0.06 * (1.0 - occlusion)).clamp(0.05, 1.0),
            translucency: 0.0,
            depth: 0.0,
        }
    });
    Image::from_texels(size, size, texels)
}

/// Tile position of a texel's centre.
fn place(size: u32, x: u32, y: u32) -> (f32, f32) {
    let texel_uv = 1.0 / size.max(1) as f32;
    (
        (x as f32 + 0.5) * texel_uv,
        1.0 - (y as f32 + 0.5) * texel_uv,
    )
}

/// What a pattern says of one point.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    /// 0 at the bottom of the deepest furrow ..= 1 on the highest ridge.
    height: f32,
    /// 0 the dark colour ..= 1 the light colour.
    tone: f32,
    /// Share of the accent colour.
    accent: f32,
    /// Added to the roughness.
    rough: f32,
}

/// A point, and how old the bark is there.
#[derive(Clone, Copy, Default)]
struct Aged {
    point: Point,
    /// Tone of the young skin.
    young: f32,
    /// 0 young skin ..= 1 old bark.
    grown: f32,
}

/// Mean size of a pattern's parts, metres.
#[derive(Clone, Copy)]
struct Part {
    width: f32,
    length: f32,
}

/// The noise fields of one bark.
struct Drawing<'a> {
    art: &'a BarkArt,
    pattern: Pattern,
    /// Where something is stronger or weaker; each pattern uses it in its own way.
    patch: Periodic,
    /// Blotches of colour.
    blotch: Periodic,
    skin: Skin,
    cover: Cover,
}

impl<'a> Drawing<'a> {
    fn new(art: &'a BarkArt, seed: u64) -> Self {
        let mut loom = Loom::new(seed, "bark", art.height_m);
        let part = Part {
            width: art.width_m,
            length: art.length_m,
        };
        let patch = loom.field(0.11, 0.15);
        let blotch = loom.field(0.11, 0.09);
        let pattern = Pattern::new(&mut loom, part, art.pattern);
        Self {
            art,
            pattern,
            patch,
            blotch,
            skin: Skin::new(&mut loom, art),
            cover: Cover::new(&mut loom, art),
        }
    }

    /// What is at each texel, and the heights among it.
    fn relief(&self, size: u32) -> (Vec<Aged>, Plane) {
        let points = texels_from_rows(size, size, Aged::default(), |x, y| {
            let (u, v) = place(size, x, y);
            self.at(u, v)
        });
        let values = points.iter().map(|aged| aged.point.height).collect();
        (points, Plane { size, values })
    }

    fn at(&self, u: f32, v: f32) -> Aged {
        let patch = self.patch.fbm(u, v, 2);
        let grown = self.skin.grown(patch);
        let old = if grown > 0.0 {
            self.pattern.at(u, v, patch).within()
        } else {
            Point::default()
        };
        if grown >= 1.0 {
            return Aged {
                point: old,
                young: 0.0,
                grown: 1.0,
            };
        }
        let skin = self.skin.at(u, v, patch);
        Aged {
            point: Point {
                height: lerp(skin.height, old.height, grown),
                rough: lerp(skin.rough, old.rough, grown),
                ..old
            },
            young: skin.tone.max(0.0),
            grown,
        }
    }

    /// Colour and roughness of a point, with slow blotches (algae and weather: a little greener or
    /// browner).
    fn surface(&self, aged: &Aged, (u, v): (f32, f32)) -> ([f32; 3], f32) {
        let Aged {
            point,
            young,
            grown,
        } = *aged;
        let BarkArt {
            light,
            dark,
            accent,
            ..
        } = self.art;
        let old = mixed(mixed(*dark, *light, point.tone), *accent, point.accent);
        let bare = mixed(self.art.young.map(|x| x * young), old, grown);
        let blotch = self.blotch.fbm(u, v, 2);
        let (colour, covered) = self.cover.over(bare, point.height, (u, v), blotch);
        let value = 1.0 + 0.1 * blotch;
        let tint = [1.0 + 0.03 * blotch, 1.0, 1.0 - 0.04 * blotch];
        let roughness = Cover::roughness(self.art.roughness + point.rough, covered);
        (
            [0, 1, 2].map(|i| (colour[i] * value * tint[i]).clamp(0.0, 1.0)),
            roughness,
        )
    }
}

impl Point {
    fn within(self) -> Self {
        Self {
            height: self.height.clamp(0.0, 1.0),
            tone: self.tone.clamp(0.0, 1.0),
            accent: self.accent.clamp(0.0, 1.0),
            rough: self.rough,
        }
    }
}

/// One pattern with its noise fields.
enum Pattern {
    Ridged(Ridged),
    Gnarled(Gnarled),
    Smooth(Smooth),
    Papery(Papery),
    Banded(Banded),
    Plates(Plates),
    Mosaic(Mosaic),
    Fibrous(Fibrous),
    Rings(Rings),
    Lattice(Lattice),
}

impl Pattern {
    fn new(loom: &mut Loom, part: Part, pattern: BarkPattern) -> Self {
        match pattern {
            BarkPattern::Ridged {
                braid,
                flat,
                cracks,
            } => Self::Ridged(Ridged::new(loom, part, [braid, flat, cracks])),
            BarkPattern::Gnarled { scales } => Self::Gnarled(Gnarled::new(loom, part, scales)),
            BarkPattern::Smooth {
                wrinkles,
                lenticels,
                scars,
            } => Self::Smooth(Smooth::new(loom, part, [wrinkles, lenticels, scars])),
            BarkPattern::Papery {
                lenticels,
                peel,
                diamonds,
            } => Self::Papery(Papery::new(loom, part, [lenticels, peel, diamonds])),
            BarkPattern::Banded { lenticels, peel } => {
                Self::Banded(Banded::new(loom, part, [lenticels, peel]))
            }
            BarkPattern::Plates { flakes, lift } => {
                Self::Plates(Plates::new(loom, part, [flakes, lift]))
            }
            BarkPattern::Mosaic { shed } => Self::Mosaic(Mosaic::new(loom, part, shed)),
            BarkPattern::Fibrous { shreds } => Self::Fibrous(Fibrous::new(loom, part, shreds)),
            BarkPattern::Rings { fissures } => Self::Rings(Rings::new(loom, part, fissures)),
            BarkPattern::Lattice { boots } => Self::Lattice(Lattice::new(loom, part, boots)),
        }
    }

    /// What is at (u, v); `patch` is slow noise.
    fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        match self {
            Self::Ridged(pattern) => pattern.at(u, v, patch),
            Self::Gnarled(pattern) => pattern.at(u, v, patch),
            Self::Smooth(pattern) => pattern.at(u, v, patch),
            Self::Papery(pattern) => pattern.at(u, v, patch),
            Self::Banded(pattern) => pattern.at(u, v, patch),
            Self::Plates(pattern) => pattern.at(u, v, patch),
            Self::Mosaic(pattern) => pattern.at(u, v, patch),
            Self::Fibrous(pattern) => pattern.at(u, v, patch),
            Self::Rings(pattern) => pattern.at(u, v, patch),
            Self::Lattice(pattern) => pattern.at(u, v, patch),
        }
    }
}

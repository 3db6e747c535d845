//! Nine baked soft shadows of a tree on the ground, and the weights that blend them for any sun.
//!
//! Paper: Koniaris, Gaitatzes, Papaioannou, "An Automated Modeling Method for Multiple Detail
//! Levels of Real-Time Trees", section IV.F: one vertical light and eight at 45 degrees elevation,
//! 45 degrees apart; each soft shadow is the weighted sum of hard shadows from directions on
//! concentric circles ("bands") around the light on the unit sphere.
//!
//! Changes versus the paper:
//! - The grid of each hard shadow is shifted by its own part of a texel, so that the sum smooths
//!   edges also where the penumbra is narrower than a texel: at the trunk base and in grass.
//! - A leaf texel that covers a part of a map texel is drawn in that part of the samples, by a
//!   threshold that differs from triangle to triangle. A fixed threshold on a mip would erase
//!   airy foliage, and fatten dense foliage.
//! - Every connected piece of foliage strays from each sample's light by its own part of the
//!   distance between bands, at most half of it to either side. Without it the outline of a dense
//!   crown repeats once a sample, and a few bands show as terraces. Bark does not stray.
//! - The paper names no weights; ours are in [`samples`] (within one light) and [`weights`]
//!   (between the nine).
//! - Triangles wholly below the ground cast nothing; points below it count as points on it.
//!
//! Light directions point from the ground toward the light. The ground is the plane y = 0, and
//! the trunk base stands at the origin. Not guaranteed: a receiver other than flat ground, and
//! shadows of the tree on itself.
//!
//! Cost: `9 * (1 + bands * samples)` hard rasters of the mesh, and one byte a texel.

mod backend;
mod bake;
mod coverage;
mod cpu;
mod directions;
mod ground;
mod raster;
mod weights;

pub use backend::{Backend, BakeError, Light, Work};
pub use bake::{bake, bake_with};
pub use coverage::{Coverage, Level};
pub use cpu::Cpu;
pub use directions::{COUNT, Sample, direction, samples};
pub use ground::{Casters, Leaf, Projection, Stray};
pub use weights::weights;

use crate::image::{Image, scan::Clip};
use crate::math::Vec3;

/// How finely shadows are baked. Values out of range are taken as the nearest one in range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Texels along a map's edge, 16..=8192. Higher: finer outlines, and memory and file size
    /// grow with its square.
    pub size: u32,
    /// Concentric circles of sample directions, 0..=64. Higher: a smoother edge; 0: a hard shadow.
    pub bands: u32,
    /// Sample directions on each band, 1..=256. Higher: a smoother edge, in proportionally longer
    /// time; too few show as separate copies of the trunk far from its base.
    pub samples: u32,
    /// Angular radius of the outermost band, degrees, 0..=30. Higher: a wider, softer edge. The
    /// real sun's is 0.27; several degrees stand for the bright sky around it. Foliage
    /// strays half a band further.
    pub spread_deg: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: 256,
            bands: 3,
            samples: 8,
            spread_deg: 6.0,
        }
    }
}

impl Settings {
    /// The nearest settings in range; a NaN spread is none.
    fn clamped(&self) -> Self {
        Self {
            size: self.size.clamp(16, 8192),
            bands: self.bands.min(64),
            samples: self.samples.clamp(1, 256),
            spread_deg: if self.spread_deg > 0.0 {
                self.spread_deg.min(30.0)
            } else {
                0.0
            },
        }
    }
}

/// The soft shadow of one light direction.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowMap {
    /// Unit vector from the ground toward the light.
    pub direction: Vec3,
    /// 0 lit ..= 255 full shadow. Columns follow rising world X and rows rising world Z: row 0 is
    /// the smallest Z. At least two texels on every side are lit, so that clamped sampling
    /// outside of the map finds light.
    ///
    /// The first four texels of row 0 are not shadow but a code, as in the paper: the bytes of
    /// [`ShadowMap::trunk_base`], x then y, each low byte first. A renderer must take these
    /// texels as lit; [`ShadowMap::image_without_code`] does so.
    pub image: Image<u8>,
    /// The ground that the whole image covers, metres: smallest X, smallest Z, largest X, largest
    /// Z. Texels need not be square on the ground: a shadow is often longer than it is wide.
    pub ground_rect_m: [f32; 4],
    /// Column and row of the texel whose centre is the middle of the trunk base, the origin.
    pub trunk_base: [u16; 2],
}

impl ShadowMap {
    /// The shadow alone, with the four texels of the code lit.
    #[must_use]
    pub fn image_without_code(&self) -> Image<u8> {
        let mut image = self.image.clone();
        image.texels_mut().iter_mut().take(4).for_each(|t| *t = 0);
        image
    }
}

/// The baked shadows of a tree, in the order of [`direction`].
#[derive(Clone, Debug, PartialEq)]
pub struct Shadows {
    /// [`COUNT`] maps of one size.
    pub maps: Vec<ShadowMap>,
}

impl Shadows {
    /// All maps in one image of three by three cells, row by row in index order: 0, 1, 2 on top.
    ///
    /// Returns each map's part of it. Maps keep their codes, and their lit borders keep bilinear
    /// samples apart; a smaller mip than half size needs the codes removed and borders widened.
    #[must_use]
    pub fn atlas(&self) -> (Image<u8>, [Clip; COUNT]) {
        let cell = self
            .maps
            .iter()
            .map(|m| m.image.width().max(m.image.height()));
        let cell = cell.max().unwrap_or(0);
        let mut atlas = Image::filled(cell * 3, cell * 3, 0);
        let stride = cell as usize * 3;
        let mut rects = [Clip {
            x0: 0,
            y0: 0,
            x1: 0,
            y1: 0,
        }; COUNT];
        for ((map, rect), index) in self.maps.iter().zip(&mut rects).zip(0..) {
            let (x0, y0) = (index % 3 * cell, index / 3 * cell);
            let (width, height) = (map.image.width(), map.image.height());
            *rect = Clip {
                x0,
                y0,
                x1: x0 + width,
                y1: y0 + height,
            };
            for (row, y) in map.image.texels().chunks(width.max(1) as usize).zip(y0..) {
                let start = y as usize * stride + x0 as usize;
                atlas.texels_mut()[start..start + row.len()].copy_from_slice(row);
            }
        }
        (atlas, rects)
    }
}

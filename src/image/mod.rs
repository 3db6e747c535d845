//! Pixels: planes of texels, scan conversion, dilation, mips, atlas packing, PNG.

pub mod atlas;
pub mod cutouts;
pub mod dilate;
pub mod mips;
pub mod png;
pub mod scan;
pub mod steady;
pub mod trim;

use crate::math::{byte_from_unit, srgb_from_linear};

/// A plane of texels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image<P> {
    width: u32,
    height: u32,
    texels: Vec<P>,
}

impl<P: Clone> Image<P> {
    /// A plane filled with one value.
    #[must_use]
    pub fn filled(width: u32, height: u32, value: P) -> Self {
        Self {
            width,
            height,
            texels: vec![value; width as usize * height as usize],
        }
    }
}

impl<P> Image<P> {
    /// A plane from its texels.
    ///
    /// # Panics
    /// If `texels` does not hold `width * height` of them.
    #[must_use]
    pub fn from_texels(width: u32, height: u32, texels: Vec<P>) -> Self {
        assert_eq!(
            texels.len(),
            width as usize * height as usize,
            "texels do not fill the plane"
        );
        Self {
            width,
            height,
            texels,
        }
    }

    /// Texels along x.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels along y.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All texels, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[P] {
        &self.texels
    }

    /// All texels, to change.
    pub fn texels_mut(&mut self) -> &mut [P] {
        &mut self.texels
    }

    /// One texel; `x` to the right, `y` down.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> &P {
        &self.texels[y as usize * self.width as usize + x as usize]
    }

    /// One texel, to change.
    pub fn at_mut(&mut self, x: u32, y: u32) -> &mut P {
        &mut self.texels[y as usize * self.width as usize + x as usize]
    }

    /// A plane of the same size with each texel mapped.
    #[must_use]
    pub fn map<Q>(&self, f: impl FnMut(&P) -> Q) -> Image<Q> {
        Image {
            width: self.width,
            height: self.height,
            texels: self.texels.iter().map(f).collect(),
        }
    }
}

impl<P: Copy> Image<P> {
    /// A part of a plane.
    ///
    /// # Panics
    /// If it reaches outside.
    #[must_use]
    pub fn part(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let columns = x as usize..(x + width) as usize;
        let rows = (y..y + height).map(|row| row as usize * self.width as usize);
        let texels = rows
            .flat_map(|row| &self.texels[row + columns.start..row + columns.end])
            .copied()
            .collect();
        Self::from_texels(width, height, texels)
    }
}

/// What a surface is like at one point: everything a capture or a procedural texture knows there.
/// Never lighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    /// Linear reflectance.
    pub albedo: [f32; 3],
    /// Coverage, 0..=1.
    pub alpha: f32,
    /// Unit normal in tangent space: +X along rising u, +Y up the image, +Z out of it (as glTF).
    pub normal: [f32; 3],
    /// Ambient light that arrives, 0 (none) ..= 1 (all).
    pub occlusion: f32,
    /// 0 mirror ..= 1 matt.
    pub roughness: f32,
    /// Light that passes through, as a part of the light that is reflected, 0..=1.
    pub translucency: f32,
    /// Offset from the surface's plane toward the viewer, in parts of the card's longer side, -1..=1.
    pub depth: f32,
}

impl Texel {
    /// Nothing there.
    pub const EMPTY: Self = Self {
        albedo: [0.0; 3],
        alpha: 0.0,
        normal: [0.0, 0.0, 1.0],
        occlusion: 1.0,
        roughness: 1.0,
        translucency: 0.0,
        depth: 0.0,
    };

    /// sRGB colour with alpha.
    #[must_use]
    pub fn albedo_bytes(&self) -> [u8; 4] {
        let [r, g, b] = self.albedo.map(srgb_from_linear);
        [r, g, b, byte_from_unit(self.alpha)]
    }

    /// Tangent-space normal, 0.5 meaning zero.
    #[must_use]
    pub fn normal_bytes(&self) -> [u8; 3] {
        self.normal.map(|x| byte_from_unit(x * 0.5 + 0.5))
    }

    /// Occlusion, roughness and metalness as glTF packs them in one image.
    #[must_use]
    pub fn orm_bytes(&self) -> [u8; 3] {
        [
            byte_from_unit(self.occlusion),
            byte_from_unit(self.roughness),
            0,
        ]
    }

    /// Translucency, depth (0.5 meaning zero) and coverage, for engines that light foliage well.
    #[must_use]
    pub fn extra_bytes(&self) -> [u8; 3] {
        [
            byte_from_unit(self.translucency),
            byte_from_unit(self.depth * 0.5 + 0.5),
            byte_from_unit(self.alpha),
        ]
    }
}

//! Cutouts: which texels of an alpha-tested texture are there.

use super::{Image, Texel};

/// Alpha at which a foliage texel counts as there; the cutoff of the exported material too.
pub const ALPHA_CUTOFF: f32 = 0.5;

/// Which texels of the foliage atlas are there.
///
/// Silhouettes read the finest texels, never mips: then a covered share is right in the mean however far away the
/// tree is, where the alpha test of a mip is right for some parts of an atlas and wrong for others.
#[derive(Clone, Debug)]
pub struct Cutouts {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Words of a row.
    stride: usize,
    /// A bit a texel, row by row from the top: an atlas stays in a processor's near memory.
    bits: Vec<u64>,
}

impl Cutouts {
    /// Cuts an atlas at the alpha of exported materials.
    #[must_use]
    pub fn of(atlas: &Image<Texel>) -> Self {
        let is_there = |texel: &Texel| texel.alpha >= ALPHA_CUTOFF;
        let is_there: Vec<bool> = atlas.texels().iter().map(is_there).collect();
        Self::from_texels(atlas.width(), atlas.height(), &is_there)
    }

    /// Cuts by a plane of truths, row by row from the top.
    #[must_use]
    pub fn from_texels(width: u32, height: u32, texels: &[bool]) -> Self {
        let stride = width.div_ceil(64) as usize;
        let mut bits = vec![0_u64; stride * height as usize];
        let rows = texels.chunks_exact(width.max(1) as usize);
        for (words, row) in bits.chunks_exact_mut(stride.max(1)).zip(rows) {
            for (word, texels) in words.iter_mut().zip(row.chunks(64)) {
                *word = texels
                    .iter()
                    .rev()
                    .fold(0, |word, &t| word << 1 | u64::from(t));
            }
        }
        Self {
            width,
            height,
            stride,
            bits,
        }
    }

    /// True if the texel is there; the nearest one for places outside.
    #[inline]
    pub(crate) fn at(&self, x: i64, y: i64) -> bool {
        let clamp = |x: i64, size: u32| {
            let inside = x.clamp(0, i64::from(size) - 1);
            usize::try_from(inside).unwrap_or(0)
        };
        let (x, y) = (clamp(x, self.width), clamp(y, self.height));
        self.bits[y * self.stride + x / 64] >> (x % 64) & 1 == 1
    }
}

//! The foliage atlas as coverage: what part of each texel, at each mip, lies over the cutoff.

use crate::image::Image;

/// Mips of coverage, 0 (nothing) ..= 255 (all), the full size first.
#[derive(Clone, Debug)]
pub struct Coverage {
    levels: Vec<Level>,
}

/// One mip.
#[derive(Clone, Debug)]
pub struct Level {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Texels of this mip along x and y for one of the full size.
    pub scale: [f32; 2],
    /// Part of each texel that is covered, 0..=255, row by row.
    pub texels: Vec<u8>,
}

impl Coverage {
    /// All mips of `alpha` tested against `cutoff`; an image without texels is opaque.
    pub(super) fn new(alpha: &Image<u8>, cutoff: u8) -> Self {
        let tested = |&a: &u8| if a >= cutoff { 255 } else { 0 };
        let full = if alpha.texels().is_empty() {
            Image::filled(1, 1, 255)
        } else {
            alpha.map(tested)
        };
        let mut levels = vec![Level {
            width: full.width(),
            height: full.height(),
            scale: [1.0, 1.0],
            texels: full.texels().to_vec(),
        }];
        while let Some(next) = levels
            .last()
            .and_then(|last| last.halved(full.width(), full.height()))
        {
            levels.push(next);
        }
        Self { levels }
    }

    /// Texels of the full size along x and y.
    pub(super) fn size(&self) -> [f32; 2] {
        [float(self.levels[0].width), float(self.levels[0].height)]
    }

    /// All mips, the full size first.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Number of mips, at least one.
    pub(super) fn count(&self) -> usize {
        self.levels.len()
    }

    /// One mip; the last one if there are fewer.
    pub(super) fn level(&self, index: usize) -> &Level {
        &self.levels[index.min(self.levels.len() - 1)]
    }
}

impl Level {
    /// The next smaller mip: means of two by two texels. `None` after a single texel. An odd last
    /// row or column is left out, as its texel would count double otherwise.
    fn halved(&self, full_width: u32, full_height: u32) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let sum: u16 = [(0, 0), (1, 0), (0, 1), (1, 1)]
                    .into_iter()
                    .map(|(dx, dy)| u16::from(self.at(x * 2 + dx, y * 2 + dy)))
                    .sum();
                texels.push(((sum + 2) / 4).to_le_bytes()[0]);
            }
        }
        Some(Self {
            width,
            height,
            scale: [
                float(width) / float(full_width),
                float(height) / float(full_height),
            ],
            texels,
        })
    }

    /// Coverage at a texel; the nearest one if outside.
    #[inline]
    pub(super) fn at(&self, x: u32, y: u32) -> u8 {
        let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
        self.texels[y as usize * self.width as usize + x as usize]
    }
}

/// An image size as a number.
#[expect(clippy::cast_precision_loss, reason = "image sizes are far below 2^24")]
fn float(size: u32) -> f32 {
    size as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mips_keep_the_mean_coverage_down_to_one_texel() {
        let mut alpha = Image::filled(8, 4, 10);
        for x in 0..8 {
            *alpha.at_mut(x, 1) = 200;
        }
        let coverage = Coverage::new(&alpha, 128);
        assert_eq!(coverage.count(), 4);
        assert_eq!(
            (coverage.level(0).at(3, 1), coverage.level(0).at(3, 2)),
            (255, 0)
        );
        assert_eq!(
            (coverage.level(1).at(3, 0), coverage.level(1).at(3, 1)),
            (128, 0)
        );
        assert_eq!(coverage.level(9).at(0, 0), 64);
    }

    #[test]
    fn an_image_without_texels_is_opaque() {
        assert_eq!(
            Coverage::new(&Image::filled(0, 0, 0), 128)
                .level(0)
                .at(7, 7),
            255
        );
    }
}

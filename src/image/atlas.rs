//! One texture for many parts: places rectangles of wanted shapes in a square atlas.

use crate::math::round_to_u32;
use etagere::{AllocatorOptions, AtlasAllocator, size2};

/// Empty texels around every rectangle: what four mips may blur over.
const GUTTER: u32 = 4;

/// Rectangles start and end on multiples of this, so that three mips stay aligned with the base.
const ALIGN: u32 = 8;

/// Smallest edge of a rectangle, texels.
const SMALLEST: u32 = 8;

/// Part of an atlas, in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rect {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Rect {
    /// The same with its gutters: it begins and ends on multiples of 8, where texels of three mips do, too.
    #[must_use]
    pub fn outer(&self) -> Self {
        let gutter = GUTTER.min(self.x).min(self.y);
        Self {
            x: self.x - gutter,
            y: self.y - gutter,
            width: self.width + 2 * gutter,
            height: self.height + 2 * gutter,
        }
    }
}

/// The shape that a part would like: its size at a density of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Width at density 1, texels.
    pub width: f32,
    /// Height at density 1, texels.
    pub height: f32,
}

/// Places all `wanted` shapes in a square of `size` texels, at the largest common density that fits.
///
/// The density is found by bisection, so the result depends on the shapes and their order alone. Shapes
/// that are too thin or too small get the smallest edge of 8 texels. `None` if not even those fit.
#[must_use]
pub fn layout(size: u32, wanted: &[Wanted]) -> Option<Vec<Rect>> {
    let (mut low, mut high) = (0.0_f32, 8.0_f32);
    let mut best = None;
    // 14 halvings of 8 settle the density to half a thousandth.
    for _ in 0..14 {
        let density = (low + high) * 0.5;
        match place(size, wanted, density) {
            Some(rects) => {
                best = Some(rects);
                low = density;
            }
            None => high = density,
        }
    }
    best
}

fn place(size: u32, wanted: &[Wanted], density: f32) -> Option<Vec<Rect>> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    let shape = |w: &Wanted| (edge(w.width * density), edge(w.height * density));
    // Tall ones first wastes least; equal ones keep their order.
    order.sort_by_key(|&i| {
        let (width, height) = shape(&wanted[i]);
        (core::cmp::Reverse(height), core::cmp::Reverse(width))
    });
    let edge = i32::try_from(size).ok()?;
    let align = i32::try_from(ALIGN).ok()?;
    let options = AllocatorOptions {
        alignment: size2(align, align),
        ..AllocatorOptions::default()
    };
    let mut allocator = AtlasAllocator::with_options(size2(edge, edge), &options);
    let mut rects = vec![None; wanted.len()];
    for index in order {
        let (width, height) = shape(&wanted[index]);
        let outer = size2(
            i32::try_from(width + 2 * GUTTER).ok()?,
            i32::try_from(height + 2 * GUTTER).ok()?,
        );
        let spot = allocator.allocate(outer)?.rectangle.min;
        rects[index] = Some(Rect {
            x: u32::try_from(spot.x).ok()? + GUTTER,
            y: u32::try_from(spot.y).ok()? + GUTTER,
            width,
            height,
        });
    }
    rects.into_iter().collect()
}

/// A whole number of texels that keeps the outer rectangle (with its gutters) aligned.
fn edge(texels: f32) -> u32 {
    let whole = round_to_u32(texels / 8.0) * ALIGN;
    whole.max(SMALLEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_stay_apart_inside_and_in_proportion() {
        let wanted: Vec<Wanted> = (1..20_u8)
            .map(|i| Wanted {
                width: 10.0 * f32::from(i % 5 + 1),
                height: 13.0 * f32::from(i),
            })
            .collect();
        let rects = layout(512, &wanted).unwrap();
        for (i, a) in rects.iter().enumerate() {
            assert!(a.x >= GUTTER && a.y >= GUTTER);
            assert!(a.x + a.width + GUTTER <= 512 && a.y + a.height + GUTTER <= 512);
            for b in &rects[..i] {
                let apart_x = a.x + a.width + GUTTER <= b.x || b.x + b.width + GUTTER <= a.x;
                let apart_y = a.y + a.height + GUTTER <= b.y || b.y + b.height + GUTTER <= a.y;
                assert!(apart_x || apart_y, "{a:?} {b:?}");
            }
        }
        let area: u32 = rects.iter().map(|r| r.width * r.height).sum();
        assert!(
            area * 2 > 512 * 512,
            "only {area} texels of the atlas are used"
        );
    }

    #[test]
    fn more_than_fits_is_refused() {
        assert!(
            layout(
                32,
                &[Wanted {
                    width: 1.0,
                    height: 1.0
                }; 100]
            )
            .is_none()
        );
    }
}

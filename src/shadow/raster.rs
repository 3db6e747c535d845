//! One hard shadow: triangles drawn into a mask of one bit a texel.
//!
//! Not [`crate::image::scan`]: a shadow needs no corner weights, and most of its triangles are a
//! few texels large. Rows are walked between edges, with one division an edge; every edge is
//! evaluated from its upper end, so that triangles on both sides of it agree, and neither leave a
//! texel out between them.

use crate::shadow::coverage::Level;

/// One bit a texel of a square map, row by row.
pub(super) struct Mask {
    size: u32,
    words_a_row: usize,
    words: Vec<u64>,
}

/// A cut-out card's texture at the corners of its triangle.
pub(super) struct Cut<'a> {
    /// Coverage mip to look at.
    pub(super) level: &'a Level,
    /// Corners in texels of the full-size coverage.
    pub(super) uv: [[f32; 2]; 3],
    /// Least coverage that casts a shadow, 1..=255.
    pub(super) threshold: u8,
}

impl Mask {
    /// All lit.
    pub(super) fn new(size: u32) -> Self {
        let words_a_row = size.div_ceil(64) as usize;
        Self {
            size,
            words_a_row,
            words: vec![0; words_a_row * size as usize],
        }
    }

    /// Draws a solid triangle; corners in texels, at or above zero.
    pub(super) fn solid(&mut self, corners: [[f32; 2]; 3]) {
        let stride = self.words_a_row;
        rows(corners, self.size, |y, x0, x1| {
            let row = &mut self.words[y as usize * stride..][..stride];
            let (first, last) = ((x0 / 64) as usize, ((x1 - 1) / 64) as usize);
            let from = u64::MAX << (x0 % 64);
            let to = u64::MAX >> (63 - (x1 - 1) % 64);
            if first == last {
                row[first] |= from & to;
            } else {
                row[first] |= from;
                row[first + 1..last].fill(u64::MAX);
                row[last] |= to;
            }
        });
    }

    /// Draws those texels of a triangle at whose centres the texture reaches the threshold.
    pub(super) fn cut_out(&mut self, corners: [[f32; 2]; 3], cut: &Cut<'_>) {
        let stride = self.words_a_row;
        let [origin, right, down] = planes(corners, cut);
        let (level, threshold) = (cut.level, cut.threshold);
        rows(corners, self.size, |y, x0, x1| {
            let row = &mut self.words[y as usize * stride..][..stride];
            if all_set(row, x0, x1) {
                return;
            }
            let (px, py) = (
                texel(x0) + 0.5 - corners[0][0],
                texel(y) + 0.5 - corners[0][1],
            );
            let mut u = origin[0] + px * right[0] + py * down[0];
            let mut v = origin[1] + px * right[1] + py * down[1];
            for x in x0..x1 {
                let covered = level.at(whole(u), whole(v)) >= threshold;
                row[(x / 64) as usize] |= u64::from(covered) << (x % 64);
                u += right[0];
                v += right[1];
            }
        });
    }

    /// Adds `weight` to the sum of every texel in shadow.
    pub(super) fn add_to(&self, sums: &mut [u16], weight: u16) {
        let rows = self.words.chunks(self.words_a_row);
        for (row, sums) in rows.zip(sums.chunks_mut(self.size as usize)) {
            for (&word, sums) in row.iter().zip(sums.chunks_mut(64)) {
                let mut left = word;
                while left != 0 {
                    sums[left.trailing_zeros() as usize] += weight;
                    left &= left - 1;
                }
            }
        }
    }

    /// Makes all texels lit.
    pub(super) fn clear(&mut self) {
        self.words.fill(0);
    }
}

/// True if all of a row's columns `x0..x1` are marked, at least where they lie in one word: under a crown, most do.
#[inline]
fn all_set(row: &[u64], x0: u32, x1: u32) -> bool {
    let span = (u64::MAX << (x0 % 64)) & (u64::MAX >> (63 - (x1 - 1) % 64));
    x0 / 64 == (x1 - 1) / 64 && span & !row[(x0 / 64) as usize] == 0
}

/// The texture coordinates, in texels of the cut's mip, at the first corner, and their change for
/// a texel to the right and a texel down.
#[inline]
fn planes(corners: [[f32; 2]; 3], cut: &Cut<'_>) -> [[f32; 2]; 3] {
    let [a, b, c] = corners;
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let inverse = 1.0 / (bx * cy - cx * by);
    let mut planes = [[0.0; 2]; 3];
    for axis in 0..2 {
        let scale = cut.level.scale[axis];
        let [at_a, at_b, at_c] = cut.uv.map(|uv| uv[axis] * scale);
        let (to_b, to_c) = (at_b - at_a, at_c - at_a);
        planes[0][axis] = at_a;
        planes[1][axis] = (to_b * cy - to_c * by) * inverse;
        planes[2][axis] = (to_c * bx - to_b * cx) * inverse;
    }
    planes
}

/// Calls `span(y, x0, x1)` for every row of texels whose centres the triangle covers, columns
/// `x0..x1`, never empty. A centre on a left or upper edge is outside, on a right or lower inside.
#[inline]
fn rows(corners: [[f32; 2]; 3], size: u32, mut span: impl FnMut(u32, u32, u32)) {
    let [mut top, mut middle, mut bottom] = corners;
    if middle[1] < top[1] {
        core::mem::swap(&mut top, &mut middle);
    }
    if bottom[1] < middle[1] {
        core::mem::swap(&mut middle, &mut bottom);
        if middle[1] < top[1] {
            core::mem::swap(&mut top, &mut middle);
        }
    }
    let first = first_centre(top[1]);
    let turn = first_centre(middle[1]).min(size);
    let end = first_centre(bottom[1]).min(size);
    if first >= end {
        return;
    }
    let long = Slope::new(top, bottom);
    let mut part = |short: Slope, from: u32, to: u32| {
        for y in from..to {
            let centre = texel(y) + 0.5;
            let (a, b) = (long.at(centre), short.at(centre));
            let (x0, x1) = (first_centre(a.min(b)), first_centre(a.max(b)).min(size));
            if x0 < x1 {
                span(y, x0, x1);
            }
        }
    };
    part(Slope::new(top, middle), first, turn);
    part(Slope::new(middle, bottom), turn, end);
}

/// An edge as x over y, from its upper end.
struct Slope {
    from: [f32; 2],
    slope: f32,
}

impl Slope {
    /// Of a level edge the slope is not finite, but no row's centre lies along it.
    #[inline]
    fn new(from: [f32; 2], to: [f32; 2]) -> Self {
        Self {
            from,
            slope: (to[0] - from[0]) / (to[1] - from[1]),
        }
    }

    #[inline]
    fn at(&self, y: f32) -> f32 {
        self.from[0] + (y - self.from[1]) * self.slope
    }
}

/// The first texel whose centre lies beyond `x`; a centre at `x` itself does not.
#[inline]
fn first_centre(x: f32) -> u32 {
    whole(x + 0.5)
}

/// Whole part; 0 for negative numbers and NaN.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturation is what is wanted"
)]
fn whole(x: f32) -> u32 {
    x as u32
}

/// A texel's index as a coordinate.
#[inline]
#[expect(clippy::cast_precision_loss, reason = "maps have at most 8192 columns")]
fn texel(index: u32) -> f32 {
    index as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::math::Vec2;
    use crate::shadow::coverage::Coverage;
    use proptest::prelude::*;

    fn drawn(mask: &Mask) -> Vec<u16> {
        let mut sums = vec![0; (mask.size * mask.size) as usize];
        mask.add_to(&mut sums, 1);
        sums
    }

    #[test]
    fn a_square_is_filled_whole_words_and_parts() {
        let mut mask = Mask::new(200);
        let (low, high) = (3.0, 197.0);
        mask.solid([[low, low], [high, low], [high, high]]);
        mask.solid([[low, low], [high, high], [low, high]]);
        let sums = drawn(&mask);
        for y in 0..200 {
            for x in 0..200 {
                let inside = (3..197).contains(&x) && (3..197).contains(&y);
                assert_eq!(sums[y * 200 + x], u16::from(inside), "{x} {y}");
            }
        }
    }

    #[test]
    fn a_cut_out_follows_its_texture() {
        let mut alpha = Image::filled(4, 4, 0);
        *alpha.at_mut(1, 2) = 255;
        let coverage = Coverage::new(&alpha, 128);
        let mut mask = Mask::new(16);
        let mut half = |corners: [[f32; 2]; 3], uv| {
            let level = coverage.level(0);
            mask.cut_out(
                corners,
                &Cut {
                    level,
                    uv,
                    threshold: 200,
                },
            );
        };
        half(
            [[4.0, 4.0], [12.0, 4.0], [12.0, 12.0]],
            [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]],
        );
        half(
            [[4.0, 4.0], [12.0, 12.0], [4.0, 12.0]],
            [[0.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        );
        let sums = drawn(&mask);
        let set: Vec<_> = (0..256)
            .filter(|&i| sums[i] > 0)
            .map(|i| (i % 16, i / 16))
            .collect();
        assert_eq!(set, [(6, 8), (7, 8), (6, 9), (7, 9)]);
    }

    proptest! {
        #[test]
        fn texels_agree_with_the_shared_scan_converter_but_on_edges(
            corners in prop::array::uniform3((0.0_f32..90.0, 0.0_f32..90.0)),
        ) {
            let points = corners.map(|(x, y)| Vec2::new(x, y));
            let mut mask = Mask::new(90);
            mask.solid(corners.map(|(x, y)| [x, y]));
            let mut sums = drawn(&mask);
            let clip = crate::image::scan::Clip { x0: 0, y0: 0, x1: 90, y1: 90 };
            crate::image::scan::triangle(points, clip, |x, y, _| sums[(y * 90 + x) as usize] ^= 1);
            for (index, _) in sums.iter().enumerate().filter(|(_, s)| **s != 0) {
                let centre = Vec2::new((index % 90) as f32 + 0.5, (index / 90) as f32 + 0.5);
                let off = (0..3).map(|i| {
                    let (a, b) = (points[i], points[(i + 1) % 3]);
                    ((b - a).perp_dot(centre - a) / (b - a).length().max(1e-6)).abs()
                });
                prop_assert!(off.fold(f32::MAX, f32::min) < 1e-3);
            }
        }

        #[test]
        fn neighbours_leave_no_texel_out_between_them(
            middle in (20.0_f32..70.0, 20.0_f32..70.0), corner in (1.0_f32..15.0, 1.0_f32..15.0),
        ) {
            let rim = [[corner.0, corner.1], [85.5, 3.0], [80.0, 88.0], [2.5, 77.0]];
            let mut fan = Mask::new(90);
            for i in 0..4 {
                fan.solid([rim[i], rim[(i + 1) % 4], [middle.0, middle.1]]);
            }
            let mut pair = Mask::new(90);
            pair.solid([rim[0], rim[1], rim[2]]);
            pair.solid([rim[0], rim[2], rim[3]]);
            prop_assert_eq!(drawn(&fan), drawn(&pair));
        }
    }
}

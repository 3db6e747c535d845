//! Noise that repeats exactly after a whole number of cells, for tiles without a seam.
//!
//! Lattice noise wraps its cell indices, so both edges of a tile meet by construction. The usual
//! library noises have no period: cross-blending them over a seam halves their contrast there and
//! doubles every ridge, which shows on bark.
//!
//! Gradient noise after Perlin, "Improving Noise" (2002); cellular noise after Worley, "A Cellular
//! Texture Basis Function" (1996). Changes versus the papers: integer hashes instead of permutation
//! tables; the distance to the nearest border between cells instead of F2 - F1, so that cracks along
//! borders are equally wide everywhere.

use crate::math::floor_to_u32;
use crate::rng::unit_from_bits;

/// Offsets of the neighbouring cells.
const STEPS: [f32; 3] = [-1.0, 0.0, 1.0];

/// One noise field that repeats after `period` cells in x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Periodic {
    seed: u32,
    period: [u32; 2],
}

/// What is at a point of a cellular pattern. Lengths are in cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Distance to the nearest cell's centre.
    pub(super) centre: f32,
    /// Distance to the nearest border with another cell.
    pub(super) border: f32,
    /// How much the nearest border runs across the stem: 0 along it ..= 1 straight across.
    pub(super) across: f32,
    /// Place relative to the cell's centre: x around, y up.
    pub(super) from_centre: [f32; 2],
    /// A random number of the cell, 0..1.
    pub(super) id: f32,
}

impl Cell {
    /// Another random number of the cell, 0..1, one for each `which` up to 100 or so.
    pub(super) fn draw(&self, which: f32) -> f32 {
        let spread = self.id * (57.31 + 13.7 * which);
        spread - floor(spread)
    }
}

impl Periodic {
    /// A field of at least one cell each way.
    pub(super) fn new(seed: u32, period: [u32; 2]) -> Self {
        Self {
            seed,
            period: period.map(|cells| cells.max(1)),
        }
    }

    /// Cells of one repeat, along u and v.
    pub(super) fn cells(&self) -> [u32; 2] {
        self.period
    }

    /// A random number, 0..1, of two whole numbers.
    pub(super) fn draw(&self, column: u32, row: u32) -> f32 {
        unit_from_bits(scramble(self.hash(column, row)))
    }

    /// Gradient noise at the tile position (u, v), about -1..1.
    pub(super) fn at(&self, u: f32, v: f32) -> f32 {
        let (x0, x1, fx) = wrapped(u, self.period[0]);
        let (y0, y1, fy) = wrapped(v, self.period[1]);
        let corner = |x: u32, y: u32, dx: f32, dy: f32| {
            // Two signed 16-bit parts as a gradient in the square: uneven lengths hide the lattice.
            let bits = self.hash(x, y).cast_signed();
            ((bits << 16) >> 16) as f32 * dx + (bits >> 16) as f32 * dy
        };
        let low = mix(
            corner(x0, y0, fx, fy),
            corner(x1, y0, fx - 1.0, fy),
            fade(fx),
        );
        let high = mix(
            corner(x0, y1, fx, fy - 1.0),
            corner(x1, y1, fx - 1.0, fy - 1.0),
            fade(fx),
        );
        // 1.7 brings the usual extremes near -1 and 1.
        (1.7 / 32_768.0) * mix(low, high, fade(fy))
    }

    /// Sum of `octaves` fields, each twice as fine and half as strong; about -1..1.
    pub(super) fn fbm(&self, u: f32, v: f32, octaves: u32) -> f32 {
        let mut field = *self;
        let (mut sum, mut weight) = (0.0, 1.0);
        for _ in 0..octaves {
            sum += weight * field.at(u, v);
            weight *= 0.5;
            field.period = field.period.map(|cells| cells.saturating_mul(2));
            field.seed = field.seed.wrapping_add(0x9e37_79b9);
        }
        sum * 0.65
    }

    /// Creases of the noise: 1 on its zero lines, falling to 0 away from them.
    pub(super) fn ridge(&self, u: f32, v: f32) -> f32 {
        1.0 - (self.at(u, v).abs() * 1.6).min(1.0)
    }

    /// The cellular pattern at the tile position (u, v).
    pub(super) fn cell(&self, u: f32, v: f32) -> Cell {
        let (x0, x1, fx) = wrapped(u, self.period[0]);
        let (y0, y1, fy) = wrapped(v, self.period[1]);
        let before = |cell: u32, period: u32| if cell == 0 { period - 1 } else { cell - 1 };
        let columns = [before(x0, self.period[0]), x0, x1];
        let rows = [before(y0, self.period[1]), y0, y1];
        let mut centres = [(0.0, 0.0, 0.0); 9];
        let mut first = (f32::INFINITY, 0.0, 0.0);
        let mut first_bits = 0;
        for (i, centre) in centres.iter_mut().enumerate() {
            let bits = self.hash(columns[i % 3], rows[i / 3]);
            // 0.1..0.9 of a cell, so that no two centres coincide.
            let place = |bits: u32| 0.1 + 0.8 * unit_from_bits(bits << 16);
            let x = STEPS[i % 3] + place(bits) - fx;
            let y = STEPS[i / 3] + place(bits >> 16) - fy;
            *centre = (x * x + y * y, x, y);
            if centre.0 < first.0 {
                first = *centre;
                first_bits = bits;
            }
        }
        // The nearest border need not be the one with the second nearest cell; taking that one
        // would leave steps where the second nearest changes.
        let mut border = f32::INFINITY;
        let mut across = 0.0;
        for &(square, x, y) in &centres {
            let (dx, dy) = (x - first.1, y - first.2);
            let apart = dx * dx + dy * dy;
            if apart > 0.0 {
                let distance = (square - first.0) / (2.0 * apart.sqrt());
                if distance < border {
                    border = distance;
                    across = dy * dy / apart;
                }
            }
        }
        Cell {
            centre: first.0.sqrt(),
            border,
            across,
            from_centre: [-first.1, -first.2],
            id: unit_from_bits(scramble(first_bits)),
        }
    }

    /// One round of mixing: twice as fast as [`scramble`], and even enough for gradients.
    fn hash(&self, x: u32, y: u32) -> u32 {
        let cell = x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ self.seed;
        let mixed = (cell ^ (cell >> 15)).wrapping_mul(0x2c1b_3c6d);
        mixed ^ (mixed >> 14)
    }
}

/// The cells left and right of a tile position (which may lie outside 0..1), and the way between.
fn wrapped(position: f32, period: u32) -> (u32, u32, f32) {
    let cells = (position - floor(position)) * period as f32;
    let low = floor_to_u32(cells).min(period - 1);
    let high = if low + 1 == period { 0 } else { low + 1 };
    (low, high, cells - low as f32)
}

/// `x.floor()` inline: without it, baseline x86-64 calls a function. For |x| below 2^24.
#[expect(
    clippy::cast_possible_truncation,
    reason = "positions are a few tiles at most"
)]
pub(super) fn floor(x: f32) -> f32 {
    let whole = x as i32 as f32;
    if whole > x { whole - 1.0 } else { whole }
}

fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// A bijective mixer of 32 bits (the finaliser of `MurmurHash3`).
fn scramble(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_after_one_tile_and_only_then() {
        let noise = Periodic::new(3, [5, 7]);
        let mut inside = 0.0;
        for i in 0..40 {
            let (u, v) = (i as f32 / 64.0, (i * 13 % 64) as f32 / 64.0);
            assert_eq!(noise.at(u, v), noise.at(u + 1.0, v - 2.0));
            assert_eq!(noise.cell(u, v).border, noise.cell(u - 1.0, v + 1.0).border);
            inside += (noise.at(u, v) - noise.at(u + 0.4, v)).abs();
        }
        assert!(inside > 1.0, "{inside}");
    }

    #[test]
    fn noise_fills_its_range_evenly_about_zero() {
        let noise = Periodic::new(9, [16, 16]);
        let values: Vec<f32> = (0..4096)
            .map(|i| noise.fbm((i % 64) as f32 / 63.7, (i / 64) as f32 / 63.9, 3))
            .collect();
        let mean = values.iter().sum::<f32>() / 4096.0;
        let most = values.iter().fold(0.0, |a: f32, b| a.max(b.abs()));
        assert!(mean.abs() < 0.05, "{mean}");
        assert!((0.5..1.2).contains(&most), "{most}");
    }

    #[test]
    fn a_border_is_where_two_centres_are_equally_far() {
        let noise = Periodic::new(1, [4, 4]);
        let (mut least, mut most) = (f32::INFINITY, 0.0_f32);
        for i in 0..10_000 {
            let cell = noise.cell((i % 100) as f32 / 100.0, (i / 100) as f32 / 100.0);
            assert!(cell.border >= 0.0 && cell.centre < 1.5 && (0.0..1.0).contains(&cell.id));
            least = least.min(cell.border);
            most = most.max(cell.border);
        }
        assert!(least < 0.02 && most > 0.3, "{least} {most}");
    }
}

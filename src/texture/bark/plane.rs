//! A height field that repeats in both directions: normals and blurs.

use rayon::prelude::*;

/// Steepest slope that a normal shows; steeper walls would alias into sparkle.
const STEEPEST: f32 = 2.2;

/// Columns that are blurred together: 64 bytes of floats.
const COLUMNS: usize = 16;

/// A square plane of numbers that repeats in both directions.
pub(super) struct Plane {
    pub(super) size: u32,
    pub(super) values: Vec<f32>,
}

impl Plane {
    pub(super) fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size as usize + x as usize
    }

    /// Normal at a texel; `slope` is the real height of one unit over the width of one texel.
    pub(super) fn normal(&self, x: u32, y: u32, slope: f32) -> [f32; 3] {
        let after = |at: u32| if at + 1 == self.size { 0 } else { at + 1 };
        let before = |at: u32| if at == 0 { self.size - 1 } else { at - 1 };
        let at = |x: u32, y: u32| self.values[self.index(x, y)];
        let dx = 0.5 * slope * (at(after(x), y) - at(before(x), y));
        // Rows run down, +Y runs up.
        let dy = 0.5 * slope * (at(x, before(y)) - at(x, after(y)));
        let steep = (dx * dx + dy * dy).sqrt();
        let ease = 1.0 / (1.0 + steep / STEEPEST);
        let (nx, ny) = (-dx * ease, -dy * ease);
        let length = (nx * nx + ny * ny + 1.0).sqrt();
        [nx / length, ny / length, 1.0 / length]
    }

    /// Mean over about `radius` texels around each; two box passes each way.
    pub(super) fn blurred(&self, radius: u32) -> Self {
        let radius = radius.clamp(1, (self.size / 2).max(1));
        let mut plane = self.transposed_blur(radius);
        for _ in 0..3 {
            plane = plane.transposed_blur(radius);
        }
        plane
    }

    /// One box pass along the columns, written as rows: called an even number of times, the
    /// transpositions cancel. Several columns go at once, as many as share a line of the cache.
    fn transposed_blur(&self, radius: u32) -> Self {
        let size = self.size as usize;
        let width = 2 * radius + 1;
        let scale = 1.0 / width as f32;
        let mut values = vec![0.0; self.values.len()];
        values
            .par_chunks_mut((size * COLUMNS).max(1))
            .enumerate()
            .for_each(|(block, out)| {
                let first = block * COLUMNS;
                let columns = COLUMNS.min(size - first);
                let row = |y: usize| &self.values[y * size + first..][..columns];
                let next = |y: usize| if y + 1 == size { 0 } else { y + 1 };
                let reach = radius as usize;
                let mut leaving = (size * 2 - reach) % size;
                let mut entering = leaving;
                let mut sums = [0.0; COLUMNS];
                for _ in 0..width {
                    for (sum, value) in sums.iter_mut().zip(row(entering)) {
                        *sum += value;
                    }
                    entering = next(entering);
                }
                for y in 0..size {
                    let (new, old) = (row(entering), row(leaving));
                    for (column, sum) in sums[..columns].iter_mut().enumerate() {
                        out[column * size + y] = *sum * scale;
                        *sum += new[column] - old[column];
                    }
                    entering = next(entering);
                    leaving = next(leaving);
                }
            });
        Self {
            size: self.size,
            values,
        }
    }
}

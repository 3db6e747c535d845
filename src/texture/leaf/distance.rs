//! Distances to line segments on a grid: exact beside the segments, carried outward from there.
//!
//! After Danielsson, "Euclidean Distance Mapping" (1980). Change versus the paper: cells carry the
//! segment that is nearest, not the nearest cell, so that distances are exact below a cell's size
//! wherever the right segment arrived.

use crate::math::{Vec2, floor_to_u32};

/// A grid over a blade's frame; cells are square, values stand at their corners `low + cell * (i, j)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) low: Vec2,
    pub(super) cell: f32,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// A piece of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) from: Vec2,
    pub(super) to: Vec2,
    /// Half width at both ends, for veins.
    pub(super) radius: [f32; 2],
}

impl Segment {
    /// Squared distance from a point, and the way along the segment of what is nearest.
    pub(super) fn nearest(&self, point: Vec2) -> (f32, f32) {
        let along = self.to - self.from;
        let way =
            ((point - self.from).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        ((self.from + along * way).distance_squared(point), way)
    }
}

impl Grid {
    /// A grid over a box.
    pub(super) fn new(low: Vec2, high: Vec2, cell: f32) -> Self {
        let cells = |size: f32| floor_to_u32((size / cell).min(4000.0)) as usize + 2;
        Self {
            low,
            cell,
            width: cells(high.x - low.x),
            height: cells(high.y - low.y),
        }
    }

    pub(super) fn point(&self, i: usize, j: usize) -> Vec2 {
        self.low + Vec2::new(i as f32, j as f32) * self.cell
    }

    /// Cells from `low` on, clamped to the grid.
    fn index(&self, x: f32, count: usize) -> usize {
        (floor_to_u32((x / self.cell).max(0.0)) as usize).min(count - 1)
    }

    /// For each cell the index of the nearest segment and the squared distance to it.
    pub(super) fn nearest(&self, segments: &[Segment]) -> Vec<(u32, f32)> {
        let mut cells = vec![(u32::MAX, f32::INFINITY); self.width * self.height];
        for (number, segment) in (0_u32..).zip(segments) {
            let pad = Vec2::splat(1.5 * self.cell);
            let low = segment.from.min(segment.to) - pad - self.low;
            let high = segment.from.max(segment.to) + pad - self.low;
            for j in self.index(low.y, self.height)..=self.index(high.y, self.height) {
                for i in self.index(low.x, self.width)..=self.index(high.x, self.width) {
                    let (square, _) = segment.nearest(self.point(i, j));
                    let cell = &mut cells[j * self.width + i];
                    if square < cell.1 {
                        *cell = (number, square);
                    }
                }
            }
        }
        let (width, height) = (self.width, self.height);
        for j in 0..height {
            for i in 0..width {
                self.adopt(
                    segments,
                    &mut cells,
                    (i, j),
                    &[(-1, 0), (-1, -1), (0, -1), (1, -1)],
                );
            }
            for i in (0..width).rev() {
                self.adopt(segments, &mut cells, (i, j), &[(1, 0)]);
            }
        }
        for j in (0..height).rev() {
            for i in (0..width).rev() {
                self.adopt(
                    segments,
                    &mut cells,
                    (i, j),
                    &[(1, 0), (1, 1), (0, 1), (-1, 1)],
                );
            }
            for i in 0..width {
                self.adopt(segments, &mut cells, (i, j), &[(-1, 0)]);
            }
        }
        cells
    }

    /// Takes over a neighbour's segment if it is nearer than the cell's own.
    fn adopt(
        &self,
        segments: &[Segment],
        cells: &mut [(u32, f32)],
        (i, j): (usize, usize),
        steps: &[(isize, isize)],
    ) {
        let own = j * self.width + i;
        for &(di, dj) in steps {
            let (Some(ni), Some(nj)) = (i.checked_add_signed(di), j.checked_add_signed(dj)) else {
                continue;
            };
            if ni >= self.width || nj >= self.height {
                continue;
            }
            let (number, square) = cells[nj * self.width + ni];
            if number == cells[own].0 || number == u32::MAX {
                continue;
            }
            // A neighbour's segment cannot be nearer than the neighbour is to it, less one step.
            let least = square.sqrt() - 1.5 * self.cell;
            if least > 0.0 && least * least >= cells[own].1 {
                continue;
            }
            let (square, _) = segments[number as usize].nearest(self.point(i, j));
            if square < cells[own].1 {
                cells[own] = (number, square);
            }
        }
    }

    /// For each cell, true inside a closed polygon (by the even-odd rule).
    pub(super) fn inside(&self, polygon: &[Vec2]) -> Vec<bool> {
        let mut inside = vec![false; self.width * self.height];
        let mut crossings: Vec<Vec<f32>> = vec![Vec::new(); self.height];
        for (index, &a) in polygon.iter().enumerate() {
            let b = polygon[(index + 1) % polygon.len()];
            let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
            let first = self.index(low.y - self.low.y - self.cell, self.height);
            let last = self.index(high.y - self.low.y + self.cell, self.height);
            for (j, row) in crossings.iter_mut().enumerate().take(last + 1).skip(first) {
                let y = self.point(0, j).y;
                if low.y <= y && y < high.y {
                    row.push(low.x + (high.x - low.x) * (y - low.y) / (high.y - low.y));
                }
            }
        }
        for (j, mut row) in crossings.into_iter().enumerate() {
            row.sort_by(f32::total_cmp);
            for pair in row.chunks_exact(2) {
                for i in 0..self.width {
                    let x = self.point(i, j).x;
                    if x >= pair[0] && x < pair[1] {
                        inside[j * self.width + i] ^= true;
                    }
                }
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_square_are_exact_everywhere() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from_array);
        let segments: Vec<Segment> = (0..4)
            .map(|i| Segment {
                from: corners[i],
                to: corners[(i + 1) % 4],
                radius: [0.0; 2],
            })
            .collect();
        let grid = Grid::new(Vec2::splat(-0.513), Vec2::splat(1.5), 0.031);
        let (nearest, inside) = (grid.nearest(&segments), grid.inside(&corners));
        for j in 0..grid.height {
            for i in 0..grid.width {
                let p = grid.point(i, j);
                let q = (p - Vec2::splat(0.5)).abs() - Vec2::splat(0.5);
                let signed = q.max(Vec2::ZERO).length() + q.max_element().min(0.0);
                let cell = j * grid.width + i;
                assert!((nearest[cell].1.sqrt() - signed.abs()).abs() < 1e-4, "{p}");
                assert_eq!(inside[cell], signed < 0.0, "{p}");
            }
        }
    }
}

//! How much sky a point inside a crown sees: a coarse grid of leaf density, swept in many directions.
//!
//! Leaves are too many to trace, and a single one hardly matters: what darkens the inside of a crown is
//! the mass of it. So triangle areas are gathered in a grid, and light fades along straight paths by
//! Beer and Lambert's law, half of the area facing any one direction.

use crate::math::{Bounds, Vec3, floor_to_u32};
use crate::mesh::{Mesh, Primitive};
use rayon::prelude::*;

/// Cells along the longest edge.
const CELLS: u32 = 24;

/// Part of a foliage card's area that is leaf, on average.
const CARD_COVERAGE: f32 = 0.5;

/// Opacity of area per cell: half of it faces any one direction (random orientation), and light that
/// is scattered onward makes shade softer than pure absorption.
const EXTINCTION: f32 = 0.5 * 0.6;

/// Density of a mesh and light that reaches each cell.
#[derive(Clone, Debug)]
pub struct Occlusion {
    origin: Vec3,
    cell: f32,
    size: [u32; 3],
    /// Optical depth per metre in each cell.
    density: Vec<f32>,
    /// Mean transmittance from all directions.
    open: Vec<f32>,
}

/// Exponent by which a place that light reaches is seen: light is scattered on (the 0.6 in [`EXTINCTION`]),
/// a line of sight is not.
const SIGHT: f32 = 1.0 / 0.6;

impl Occlusion {
    /// Gathers the density of a mesh and the light that all directions together bring to each cell.
    #[must_use]
    pub fn of(mesh: &Mesh) -> Self {
        let mut grid = Self::unlit(mesh);
        grid.light();
        grid
    }

    /// The density of a mesh as [`Occlusion::of`] gathers it; [`Occlusion::light`] is still to come.
    #[must_use]
    pub fn unlit(mesh: &Mesh) -> Self {
        Self::density_of(mesh, CELLS, 1.0)
    }

    /// Works out the light that all directions together bring to each cell.
    pub fn light(&mut self) {
        let directions = all_around();
        self.open = (0..self.density.len())
            .into_par_iter()
            .map(|index| {
                let point = self.middle(index);
                let sum: f32 = directions
                    .iter()
                    .map(|&d| self.transmittance(point, d))
                    .sum();
                #[expect(clippy::cast_precision_loss, reason = "a handful of directions")]
                let mean = sum / directions.len() as f32;
                mean
            })
            .collect();
    }

    /// Corner of the first cell, metres.
    #[must_use]
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Edge of a cell, metres.
    #[must_use]
    pub fn cell(&self) -> f32 {
        self.cell
    }

    /// Cells along x, y and z.
    #[must_use]
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Optical depth per metre in each cell: x runs fastest, then y.
    #[must_use]
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// The density alone, in a grid of `cells` along the longest edge; bark counts for a part of its area.
    #[must_use]
    pub fn density_of(mesh: &Mesh, cells: u32, bark: f32) -> Self {
        let bounds = mesh.bounds();
        let bounds = if bounds.is_empty() {
            Bounds {
                min: Vec3::ZERO,
                max: Vec3::ONE,
            }
        } else {
            bounds
        };
        #[expect(clippy::cast_precision_loss, reason = "a few dozen cells")]
        let cell = (bounds.size().max_element() / cells as f32).max(1e-6);
        let size = bounds
            .size()
            .to_array()
            .map(|edge| floor_to_u32(edge / cell) + 1);
        let count = size.iter().map(|&n| n as usize).product();
        let mut grid = Self {
            origin: bounds.min,
            cell,
            size,
            density: vec![0.0; count],
            open: Vec::new(),
        };
        grid.gather(&mesh.bark, bark);
        grid.gather(&mesh.foliage, CARD_COVERAGE);
        let volume = cell * cell * cell;
        grid.density
            .iter_mut()
            .for_each(|d| *d *= EXTINCTION / volume);
        grid
    }

    /// Replaces the density by that of the foliage alone, in finer cells. (A trunk of a cell's width would
    /// stand in the shade of its own cells.) What is open to all directions stays as it was, but becomes
    /// relative to [`Occlusion::mean_open`], which a finished atlas holds already.
    pub fn refine(&mut self, mesh: &Mesh, cells: u32) {
        let mean = self.mean_open();
        let coarse = core::mem::replace(self, Self::density_of(mesh, cells, 0.0));
        self.open = (0..self.density.len())
            .map(|i| coarse.open(self.middle(i)) / mean)
            .collect();
    }

    /// Part of the surrounding light that reaches what is seen of the mesh from outside, its mean, above 0
    /// and at most 1. A place is seen from as many sides as it is lit from.
    #[must_use]
    pub fn mean_open(&self) -> f32 {
        let mut sums = [0.0_f64; 2];
        for (&density, &open) in self.density.iter().zip(&self.open) {
            let seen = f64::from(density * libm::powf(open, SIGHT));
            sums[0] += seen * f64::from(open);
            sums[1] += seen;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a part of 1")]
        let mean = (sums[0] / sums[1]) as f32;
        if mean.is_normal() {
            mean.clamp(0.05, 1.0)
        } else {
            1.0
        }
    }

    fn gather(&mut self, primitive: &Primitive, coverage: f32) {
        for corners in primitive.indices.chunks_exact(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]]
                .map(|i| Vec3::from(primitive.vertices[i as usize].position));
            let area = (b - a).cross(c - a).length() * 0.5;
            let at = self.index((a + b + c) / 3.0);
            self.density[at] += area * coverage;
        }
    }

    fn index(&self, point: Vec3) -> usize {
        let p = (point - self.origin) / self.cell;
        let at = |x: f32, n: u32| floor_to_u32(x).min(n - 1) as usize;
        let [nx, ny, nz] = self.size;
        (at(p.z, nz) * ny as usize + at(p.y, ny)) * nx as usize + at(p.x, nx)
    }

    #[expect(clippy::cast_precision_loss, reason = "a few dozen cells")]
    fn middle(&self, index: usize) -> Vec3 {
        let (nx, ny) = (self.size[0] as usize, self.size[1] as usize);
        let (x, y, z) = (index % nx, index / nx % ny, index / (nx * ny));
        self.origin + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * self.cell
    }

    fn inside(&self, point: Vec3) -> bool {
        let p = (point - self.origin) / self.cell;
        let size = self.size.map(crate::math::float);
        p.cmpge(Vec3::ZERO).all() && p.x < size[0] && p.y < size[1] && p.z < size[2]
    }

    /// Part of the light from a unit `direction` that reaches a point, 0..=1. The point's own cell
    /// does not count, or every leaf would stand in its own shade.
    #[must_use]
    pub fn transmittance(&self, point: Vec3, direction: Vec3) -> f32 {
        let mut depth = 0.0;
        let mut at = point + direction * (1.2 * self.cell);
        while self.inside(at) {
            depth += self.density[self.index(at)] * self.cell;
            if depth > 6.0 {
                break;
            }
            at += direction * self.cell;
        }
        libm::expf(-depth)
    }

    /// Part of the light from a unit `direction` that reaches the middle of each cell, for [`Occlusion::between`].
    #[must_use]
    pub fn lit_from(&self, direction: Vec3) -> Vec<f32> {
        let cells = 0..self.density.len();
        let lit = |index| self.transmittance(self.middle(index), direction);
        cells.into_par_iter().map(lit).collect()
    }

    /// Part of the surrounding light that reaches a point, 0..=1, smooth between cells.
    #[must_use]
    pub fn open(&self, point: Vec3) -> f32 {
        self.between(&self.open, point)
    }

    /// A value of each cell, x fastest, at a point between their middles.
    #[must_use]
    pub fn between(&self, values: &[f32], point: Vec3) -> f32 {
        let p = (point - self.origin) / self.cell - 0.5;
        let base = p.floor();
        let part = p - base;
        let mut sum = 0.0;
        for corner in 0..8_u8 {
            let pick = |bit: u8, f: f32| {
                if corner & bit == 0 {
                    (0.0, 1.0 - f)
                } else {
                    (1.0, f)
                }
            };
            let (x, wx) = pick(1, part.x);
            let (y, wy) = pick(2, part.y);
            let (z, wz) = pick(4, part.z);
            let cell = base + Vec3::new(x, y, z) + 0.5;
            let at = self.index(self.origin + cell.max(Vec3::ZERO) * self.cell);
            sum += values[at] * wx * wy * wz;
        }
        sum
    }
}

/// Six axes and eight diagonals.
fn all_around() -> Vec<Vec3> {
    let mut directions = vec![
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let diagonal = 1.0 / 3.0_f32.sqrt();
    for corner in 0..8_u8 {
        let sign = |bit: u8| {
            if corner & bit == 0 {
                -diagonal
            } else {
                diagonal
            }
        };
        directions.push(Vec3::new(sign(1), sign(2), sign(4)));
    }
    directions
}

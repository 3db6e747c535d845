//! The lights that reach each place of a tree: worked out once for the full tree, looked up for every model.
//!
//! A model that lost its leaves is not lit more brightly for it, and pictures differ only by what they show.

use crate::capture::{Occlusion, Seen, View};
use crate::math::{Bounds, Vec3, float, floor_to_u32};
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Linear light of the sun.
const SUN: Vec3 = Vec3::new(3.1, 2.9, 2.55);

/// Linear light from above.
const SKY: Vec3 = Vec3::new(0.62, 0.74, 0.95);

/// Linear light from below.
const GROUND: Vec3 = Vec3::new(0.26, 0.24, 0.19);

/// Lights under which everything is compared: a ranking that hangs on the light is none.
pub(super) const LIGHTS: usize = 2;

/// Toward the suns. The first is that of previews; the second stands low and across. Held-out views see both
/// before them and behind them.
const TOWARD_SUN: [Vec3; LIGHTS] = [Vec3::new(0.75, 1.0, 0.45), Vec3::new(-0.8, 0.4, 0.55)];

/// Cells of the grid along its longest edge.
const CELLS: u32 = 40;

/// What falls on every model: a sun (one light has the first, the other the second), a sky and a ground, shaded
/// by the full tree's density.
pub(super) struct Light {
    toward_sun: [Vec3; LIGHTS],
    origin: Vec3,
    /// Cells to the metre.
    density: f32,
    /// Nodes along each axis, at least 2.
    size: [u32; 3],
    /// At each node the parts of each sun and of the surrounding light that arrive.
    nodes: Vec<[f32; LIGHTS + 1]>,
}

impl Light {
    /// Shade as the full tree casts it on itself.
    pub(super) fn of(full: &Mesh) -> Self {
        let mut shade = Occlusion::of(full);
        shade.refine(full, CELLS);
        let toward_sun = TOWARD_SUN.map(|t| t.normalize_or(Vec3::Y));
        let bounds = full.bounds();
        let Bounds { min: origin, .. } = bounds;
        let cell = (bounds.size().max_element() / float(CELLS)).max(1e-6);
        let size = bounds.size().to_array();
        let size = size.map(|edge| floor_to_u32((edge / cell).ceil()).max(1) + 1);
        let [nx, ny, nz] = size;
        let node = |i: u32| {
            let at = Vec3::new(float(i % nx), float(i / nx % ny), float(i / (nx * ny)));
            let point = origin + at * cell;
            let [first, second] = toward_sun.map(|t| shade.transmittance(point, t));
            [first, second, shade.open(point)]
        };
        Self {
            toward_sun,
            origin,
            density: 1.0 / cell,
            size,
            nodes: (0..nx * ny * nz).into_par_iter().map(node).collect(),
        }
    }

    /// Linear light that a surface sends to the viewer, under each light.
    pub(super) fn on(&self, seen: &Seen, point: Vec3, view: &View) -> [Vec3; LIGHTS] {
        let texel = &seen.texel;
        let [x, y, z] = texel.normal;
        let normal = view.right * x + view.up * y + view.toward() * z;
        let [first, second, open] = self.arriving(point);
        // A capture knows how much sky its parts see; single leaves and branches do not.
        let open = if seen.captured { 1.0 } else { open };
        let sky = normal.y * 0.5 + 0.5;
        let ambient = (SKY * sky + GROUND * (1.0 - sky)) * (texel.occlusion * open);
        let albedo = Vec3::from(texel.albedo);
        let under = |toward_sun: Vec3, sun: f32| {
            let facing = normal.dot(toward_sun);
            let lit = facing.max(0.0) + texel.translucency * (-facing).max(0.0);
            albedo * (SUN * (sun * lit) + ambient)
        };
        let [a, b] = self.toward_sun;
        [under(a, first), under(b, second)]
    }

    /// Parts of the suns and of the surrounding light at a point, smooth between nodes; outside of the tree as
    /// at its nearest side.
    fn arriving(&self, point: Vec3) -> [f32; LIGHTS + 1] {
        let [nx, ny, nz] = self.size;
        let last = Vec3::new(float(nx - 1), float(ny - 1), float(nz - 1));
        let at = ((point - self.origin) * self.density).clamp(Vec3::ZERO, last);
        let low = |x: f32, n: u32| floor_to_u32(x).min(n - 2);
        let (x, y, z) = (low(at.x, nx), low(at.y, ny), low(at.z, nz));
        let part = at - Vec3::new(float(x), float(y), float(z));
        let row = |y: u32, z: u32| {
            let first = ((z * ny + y) * nx + x) as usize;
            mix(self.nodes[first], self.nodes[first + 1], part.x)
        };
        let plane = |z: u32| mix(row(y, z), row(y + 1, z), part.y);
        mix(plane(z), plane(z + 1), part.z)
    }
}

fn mix(a: [f32; LIGHTS + 1], b: [f32; LIGHTS + 1], part: f32) -> [f32; LIGHTS + 1] {
    core::array::from_fn(|i| a[i] + (b[i] - a[i]) * part)
}

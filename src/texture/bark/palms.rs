//! Stems of palms: rings of leaf scars, lattices of leaf bases.

use super::loom::{Loom, Warp, bump};
use super::{Part, Point};
use crate::math::{float, round_to_u32, smoothstep};
use crate::texture::noise::{Periodic, floor};

/// Rings of leaf scars: each rises to a ledge at its top, then falls into a groove; fine cracks along
/// the stem, which the ledges interrupt.
pub(super) struct Rings {
    wave: Periodic,
    uneven: Periodic,
    rings: f32,
    crack: Periodic,
    open: Periodic,
    grain: Periodic,
    leaf: Periodic,
    band: Periodic,
    fissures: f32,
}

impl Rings {
    pub(super) fn new(loom: &mut Loom, part: Part, fissures: f32) -> Self {
        let Part { width, length } = part;
        let uneven = loom.field(0.16, length);
        Self {
            wave: loom.field(0.22, 0.1),
            rings: float(uneven.cells()[1]),
            uneven,
            crack: loom.field(width, 1.6 * length),
            open: loom.field(3.5 * width, 0.7 * length),
            grain: loom.field(0.004, 0.007),
            leaf: loom.field(0.17, length),
            band: loom.field(0.12, 0.009),
            fissures,
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        // Unevenly spaced: the same shift all around, from a row of noise.
        let uneven = 0.42 * self.uneven.at(0.123, v);
        let along = v * self.rings + 0.22 * self.wave.fbm(u, v, 2) + uneven;
        let ring = floor(along);
        let way = along - ring;
        // By the ring's number within the tile, so that the shift too repeats.
        let shift = 0.618 * (ring - self.rings * floor(ring / self.rings));
        let ledge = smoothstep(0.0, 0.16, way) * (1.0 - smoothstep(0.9, 1.0, way));
        let up = v + shift;
        // A scar fades where no leaf sat.
        let scar = smoothstep(0.62, 0.72, way)
            * (1.0 - smoothstep(0.9, 0.98, way))
            * smoothstep(-0.5, 0.3, self.leaf.at(u, up));
        let crack = if self.fissures > 0.0 {
            let open = self.open.at(u, up) + 0.5 * patch;
            let limit = 0.5 - self.fissures;
            smoothstep(0.72, 0.98, self.crack.ridge(u, up))
                * smoothstep(limit - 0.3, limit + 0.3, open)
                * smoothstep(0.05, 0.2, way)
                * (1.0 - smoothstep(0.55, 0.75, way))
        } else {
            0.0
        };
        let grain = self.grain.fbm(u, v, 2);
        let band = self.band.at(u, v);
        Point {
            height: 0.32 + ledge * (0.15 + 0.17 * way) + 0.1 * scar - 0.22 * crack
                + 0.08 * patch
                + 0.05 * band
                + 0.07 * grain,
            tone: 0.26 + 0.3 * ledge - 0.3 * crack + 0.22 * patch + 0.14 * band + 0.2 * grain,
            accent: scar * (0.4 + 0.3 * band + 0.3 * patch),
            rough: 0.0,
        }
    }
}

/// Leaf bases in a helical lattice of diamonds.
pub(super) struct Lattice {
    bend: Warp,
    /// Rows of the lattice that climb to the right and to the left: how many meet a line around the
    /// stem (uneven, which makes the helix) and a line along it.
    around: [u32; 2],
    along: u32,
    bases: Periodic,
    grain: Periodic,
    fibre: Periodic,
    rag: Periodic,
    boots: f32,
}

impl Lattice {
    pub(super) fn new(loom: &mut Loom, part: Part, boots: f32) -> Self {
        let Part { width, length } = part;
        let bases = loom.field(width, length);
        let [columns, rows] = bases.cells();
        Self {
            bend: loom.warp([1.3 * width, 1.3 * length], [0.16 * width, 0.13 * length]),
            // One more row climbs one way than the other.
            around: [columns + 1, columns],
            along: rows,
            bases,
            grain: loom.field(0.004, 0.008),
            fibre: loom.field(0.003, 0.04),
            rag: loom.field(0.012, 0.01),
            boots,
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (u, v) = self.bend.at(u, v);
        let grain = self.grain.fbm(u, v, 2);
        let fibre = self.fibre.fbm(u, v, 2);
        let rag = self.rag.at(u, v);
        let a = u * float(self.around[0]) + v * float(self.along);
        let b = v * float(self.along) - u * float(self.around[1]);
        let (i, j) = (floor(a), floor(b));
        let (fa, fb) = (a - i, b - j);
        let id = self.base(i, j);
        let draw = |which: f32| {
            let spread = id * (31.7 + 11.3 * which);
            spread - floor(spread)
        };
        // Across the base and up it, -1..1 each.
        let (x, y) = (fa - fb, fa + fb - 1.0);
        let border = fa.min(1.0 - fa).min(fb.min(1.0 - fb)) + 0.03 * rag + 0.02 * fibre;
        let wall = smoothstep(0.0, 0.085, border);
        // The cut face: a wide lens above the middle, each a little otherwise.
        let (fx, fy) = (
            x - 0.16 * (draw(1.0) - 0.5),
            y - 0.06 - 0.22 * (draw(4.0) - 0.5),
        );
        let wide = 0.76 + 0.2 * (draw(5.0) - 0.5);
        let lens = fx.abs() / wide + fy.abs() / (0.8 * wide) + 0.25 * fx * fx + 0.08 * rag;
        let face = 1.0 - smoothstep(0.82, 0.95, lens);
        let rim = bump((lens - 0.95) / 0.2);
        let out = 0.35 + self.boots * (0.28 * y + 0.2 * face);
        let height = 0.08
            + wall * (out * (1.0 - 0.3 * x * x) + 0.16 * (draw(2.0) - 0.5) + 0.14)
            + 0.1 * rim * wall
            - 0.06 * face
            + 0.07 * fibre * (1.0 - 0.6 * face)
            + 0.05 * grain;
        Point {
            height,
            tone: 0.05
                + wall * (0.42 + 0.14 * y + 0.3 * (draw(3.0) - 0.5))
                + 0.24 * fibre
                + 0.12 * grain
                + 0.12 * patch
                + 0.14 * rim
                - 0.1 * face,
            accent: face * wall * (0.55 + 0.4 * (draw(6.0) - 0.5) + 0.35 * grain),
            rough: 0.0,
        }
    }

    /// The random number of a leaf base: lattice places that a repeat maps onto each other share it.
    fn base(&self, i: f32, j: f32) -> f32 {
        let turn = float(self.around[0] + self.around[1]);
        let rise = float(self.along) * turn;
        let within = |x: f32, period: f32| x - period * floor(x / period);
        let column = within(i - j, turn);
        let row = within(float(self.around[1]) * i + float(self.around[0]) * j, rise);
        let whole = |x: f32| round_to_u32(x.max(0.0));
        self.bases.draw(whole(column), whole(row))
    }
}

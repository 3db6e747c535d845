//! What the patterns share: noise sized in metres, warps, and spots.

use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::Part;
use crate::math::{float, round_to_u32, smoothstep};
use crate::rng::{Key, Parameter};
use crate::texture::noise::{Cell, Periodic};

/// Makes the noise fields of one bark, each with a seed of its own.
pub(super) struct Loom {
    draws: Pcg64Mcg,
    /// Real width and height of the tile, metres.
    pub(super) tile_m: f32,
}

impl Loom {
    pub(super) fn new(seed: u64, part: &str, tile_m: f32) -> Self {
        Self {
            draws: Key::of_seed(seed).level(part).stream(Parameter::Texture),
            tile_m: tile_m.max(1e-3),
        }
    }

    /// Cells of about the given width and height in metres: a whole number of them in the tile, and
    /// two at least, as a single one would show that it repeats.
    pub(super) fn field(&mut self, width_m: f32, height_m: f32) -> Periodic {
        let cells = |metres: f32| round_to_u32(self.tile_m / metres.max(1e-4)).clamp(2, 4096);
        Periodic::new(self.draws.next_u32(), [cells(width_m), cells(height_m)])
    }

    /// Pushes places about by up to so many metres, in bends of the given size.
    pub(super) fn warp(&mut self, bend_m: [f32; 2], reach_m: [f32; 2]) -> Warp {
        Warp {
            fields: [
                self.field(bend_m[0], bend_m[1]),
                self.field(bend_m[0], bend_m[1]),
            ],
            reach: reach_m.map(|metres| metres / self.tile_m),
        }
    }

    /// Shifts neighbouring columns of long cells along the stem, which would else stand in rows, by
    /// up to `reach` of a length.
    pub(super) fn stagger(&mut self, part: Part, reach: f32) -> Stagger {
        Stagger {
            field: self.field(1.4 * part.width, 3.0 * part.length),
            reach: reach * part.length / self.tile_m,
        }
    }

    /// Places for spots of up to the given half width and half height in metres, each in a cell
    /// `room` times as large.
    pub(super) fn spots(&mut self, half_m: [f32; 2], room: [f32; 2]) -> Spots {
        let field = self.field(2.0 * half_m[0] * room[0], 2.0 * half_m[1] * room[1]);
        let cell_m = field.cells().map(|cells| self.tile_m / float(cells));
        Spots {
            field,
            scale: [cell_m[0] / half_m[0], cell_m[1] / half_m[1]],
        }
    }
}

/// A displacement of places.
pub(super) struct Warp {
    fields: [Periodic; 2],
    reach: [f32; 2],
}

impl Warp {
    pub(super) fn at(&self, u: f32, v: f32) -> (f32, f32) {
        (
            u + self.reach[0] * self.fields[0].at(u, v),
            v + self.reach[1] * self.fields[1].at(u, v),
        )
    }
}

/// A displacement along the stem.
pub(super) struct Stagger {
    field: Periodic,
    reach: f32,
}

impl Stagger {
    pub(super) fn at(&self, u: f32, v: f32) -> f32 {
        v + self.reach * self.field.at(u, v)
    }
}

/// Scattered spots.
pub(super) struct Spots {
    field: Periodic,
    scale: [f32; 2],
}

impl Spots {
    /// The nearest place for a spot, and where (u, v) lies from its centre, in half widths and half
    /// heights.
    pub(super) fn at(&self, u: f32, v: f32) -> (Cell, [f32; 2]) {
        let cell = self.field.cell(u, v);
        let [x, y] = cell.from_centre;
        (cell, [x * self.scale[0], y * self.scale[1]])
    }

    /// Ellipses of uneven length where a cell's number is below `share`: 1 inside, 0 outside.
    pub(super) fn dashes(&self, u: f32, v: f32, share: f32) -> f32 {
        let (cell, [x, y]) = self.at(u, v);
        if cell.id >= share {
            return 0.0;
        }
        let x = x / (0.35 + 0.65 * cell.draw(1.0));
        let y = y / (0.6 + 0.4 * cell.draw(2.0));
        (1.0 - smoothstep(0.35, 1.0, x * x + y * y)) * smoothstep(0.0, 0.06, cell.border)
    }
}

/// 1 at 0, falling to 0 at 1 or beyond, flat at both.
pub(super) fn bump(x: f32) -> f32 {
    1.0 - smoothstep(0.0, 1.0, x.abs())
}

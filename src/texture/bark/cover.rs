//! What age does to a bark: the smooth skin before it, lichen and moss upon it.

use super::Point;
use super::loom::{Loom, Spots};
use crate::math::{lerp, smoothstep};
use crate::species::schema::BarkArt;
use crate::texture::noise::Periodic;

/// Relief of a twig's skin, metres: lenticels and fine wrinkles.
const SKIN_DEPTH_M: f32 = 0.0012;
/// Crusts of lichen, linear: pale grey-green, and the yellow-green of some.
const LICHEN: [[f32; 3]; 2] = [[0.26, 0.29, 0.23], [0.22, 0.24, 0.14]];
/// Moss and green algae, linear.
const MOSS: [f32; 3] = [0.045, 0.065, 0.018];
/// Roughness of lichen and moss.
const COVER_ROUGHNESS: f32 = 0.95;

/// Young bark: a smooth skin with lenticels.
pub(super) struct Skin {
    lenticel: Spots,
    wrinkle: Periodic,
    grain: Periodic,
    /// Height of one unit of the skin's relief, in units of the old bark's.
    scale: f32,
    age: f32,
}

impl Skin {
    pub(super) fn new(loom: &mut Loom, art: &BarkArt) -> Self {
        Self {
            lenticel: loom.spots([0.0025, 0.0016], [2.4, 4.0]),
            wrinkle: loom.field(0.02, 0.05),
            grain: loom.field(0.003, 0.006),
            scale: (SKIN_DEPTH_M / art.depth_m.max(1e-4)).min(1.0),
            age: art.age,
        }
    }

    /// How old the bark is at a point: 0 skin ..= 1 old bark. It spreads from patches where `patch`
    /// is high, and never recedes as `age` rises.
    pub(super) fn grown(&self, patch: f32) -> f32 {
        smoothstep(
            0.0,
            1.0,
            self.age * 2.0 - 0.5 + 0.5 * patch.clamp(-1.0, 1.0),
        )
        .min(smoothstep(0.0, 0.1, self.age))
        .max(smoothstep(0.9, 1.0, self.age))
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let grain = self.grain.fbm(u, v, 2);
        let wrinkle = self.wrinkle.at(u, v);
        let lenticel = self.lenticel.dashes(u, v, 0.6);
        Point {
            height: 0.5 + self.scale * (0.5 * lenticel + 0.3 * wrinkle + 0.25 * grain),
            tone: 1.0 + 0.12 * grain + 0.12 * patch + 0.08 * wrinkle + 0.5 * lenticel,
            accent: 0.0,
            rough: 0.05 * lenticel,
        }
    }
}

/// Lichen and moss.
pub(super) struct Cover {
    crust: Spots,
    edge: Periodic,
    damp: Periodic,
    lichen: f32,
    moss: f32,
}

impl Cover {
    pub(super) fn new(loom: &mut Loom, art: &BarkArt) -> Self {
        Self {
            crust: loom.spots([0.02, 0.02], [1.0, 1.0]),
            edge: loom.field(0.008, 0.008),
            damp: loom.field(0.12, 0.2),
            lichen: art.lichen,
            moss: art.moss,
        }
    }

    /// Covers a colour, and says how much of it is covered.
    pub(super) fn over(
        &self,
        colour: [f32; 3],
        height: f32,
        (u, v): (f32, f32),
        patch: f32,
    ) -> ([f32; 3], f32) {
        if self.lichen <= 0.0 && self.moss <= 0.0 {
            return (colour, 0.0);
        }
        let edge = self.edge.fbm(u, v, 2);
        let mut colour = colour;
        let mut covered = 0.0;
        if self.lichen > 0.0 {
            let (crust, kind) = self.crust((u, v), height, patch, edge);
            colour = mixed(colour, kind, 0.85 * crust);
            covered = crust;
        }
        if self.moss > 0.0 {
            let low = 1.0 - smoothstep(0.0, 0.35 + 0.6 * self.moss, height + 0.2 * edge);
            if low > 0.0 {
                let damp = 0.3 + self.damp.fbm(u, v, 2);
                let dry = 0.3 - 1.3 * self.moss;
                let amount = low * smoothstep(dry, dry + 1.0, damp);
                let shade = 1.0 + 0.5 * edge;
                colour = mixed(colour, MOSS.map(|x| x * shade), 0.85 * amount);
                covered = lerp(covered, 1.0, amount);
            }
        }
        (colour, covered)
    }

    /// How much of a point is under lichen, and the lichen's colour there.
    fn crust(&self, (u, v): (f32, f32), height: f32, patch: f32, edge: f32) -> (f32, [f32; 3]) {
        // Crusts sit on the heights, where there is light.
        let lit = smoothstep(0.2, 0.4, height);
        let grown = smoothstep(-0.2 - self.lichen, 0.6 - self.lichen, patch);
        if lit * grown <= 0.0 {
            return (0.0, LICHEN[0]);
        }
        let (cell, [x, y]) = self.crust.at(u, v);
        if cell.id >= 2.0 * self.lichen {
            return (0.0, LICHEN[0]);
        }
        let draw = cell.draw(1.0);
        let size = (0.25 + 0.75 * draw * draw) * grown;
        let out = (x * x + y * y).sqrt() + 0.4 * edge;
        let amount = (1.0 - smoothstep(0.75 * size, size, out))
            * smoothstep(0.02, 0.1, size)
            * smoothstep(0.0, 0.08, cell.border)
            * lit
            * (0.75 + 0.35 * edge).clamp(0.0, 1.0);
        let shade = 0.85 + 0.25 * edge + 0.2 * (cell.draw(2.0) - 0.5);
        let kind = LICHEN[usize::from(cell.draw(3.0) > 0.7)];
        (amount, kind.map(|x| x * shade))
    }

    pub(super) fn roughness(bare: f32, covered: f32) -> f32 {
        lerp(bare, COVER_ROUGHNESS.max(bare), covered)
    }
}

/// The straight blend of two colours.
pub(super) fn mixed(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| lerp(a[i], b[i], t))
}

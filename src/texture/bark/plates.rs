//! Bark that comes off in pieces: plates, scales, mosaics.

use super::loom::{Loom, Stagger, Warp, bump};
use super::{Part, Point};
use crate::math::{lerp, smoothstep};
use crate::texture::noise::{Periodic, floor};

/// Terraces of flakes within a plate.
const TERRACES: f32 = 3.5;

/// Plates or scales parted by cracks.
pub(super) struct Plates {
    stagger: Stagger,
    bend: Warp,
    jag: Warp,
    /// Width over length of a plate.
    slim: f32,
    plates: Periodic,
    flake: Periodic,
    chip: Periodic,
    grain: Periodic,
    flakes: f32,
    lift: f32,
}

impl Plates {
    pub(super) fn new(loom: &mut Loom, part: Part, shape: [f32; 2]) -> Self {
        let Part { width, length } = part;
        Self {
            stagger: loom.stagger(part, 0.22),
            bend: loom.warp([1.4 * width, 1.4 * length], [0.28 * width, 0.2 * length]),
            jag: loom.warp([0.26 * width, 0.3 * width], [0.11 * width, 0.13 * width]),
            slim: (width / length.max(1e-4)).min(1.0),
            plates: loom.field(width, length),
            flake: loom.field(0.7 * width, 0.45 * length),
            chip: loom.field(0.2 * width, 0.22 * width),
            grain: loom.field(0.003, 0.006),
            flakes: shape[0],
            lift: shape[1],
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let (x, y) = self.jag.at(x, y);
        let plate = self.plates.cell(x, self.stagger.at(x, y));
        let chip = self.chip.at(x, y);
        let grain = self.grain.fbm(u, v, 2);
        // Cracks across the stem are no wider than those along it, and gape less under scales.
        let narrow = lerp(1.0, 0.7 * self.slim, plate.across);
        let crack = lerp(0.22, 0.07, self.lift) * narrow;
        let open = smoothstep(-0.7, 0.3, patch + 0.5 * chip);
        let wall = smoothstep(
            0.0,
            crack * (0.5 + 0.8 * open),
            plate.border + 0.035 * narrow * chip,
        );
        let form = 0.7 * self.flake.fbm(x, y, 2) + 0.16 * chip + 0.5 * (plate.id - 0.5);
        let level = (form + 1.0) * TERRACES;
        let step = floor(level);
        let way = level - step;
        // A flake is level up to its edge, and the next one starts with a crisp step.
        let terrace = (step + smoothstep(0.0, 0.16, way)) / TERRACES - 1.0;
        let hue = (step + plate.draw(3.0)) * 0.618;
        let hue = hue - floor(hue);
        // Scales: the lower edge stands out, the upper one dives under the next.
        let [sx, sy] = plate.from_centre;
        let lifted = self.lift * (-sy - 0.5 * sx * sx).clamp(-0.7, 0.7);
        let height = wall
            * (0.62
                + 0.3 * self.flakes * terrace
                + 0.55 * lifted
                + 0.22 * (plate.id - 0.5)
                + 0.06 * chip)
            + 0.05
            + 0.05 * grain * (0.4 + 0.6 * wall);
        let fresh = smoothstep(0.62, 0.7, hue) * smoothstep(-0.5, 0.4, form - 0.4 * patch);
        Point {
            height,
            tone: 0.02
                + wall * (0.55 + 0.2 * (hue - 0.5) + 0.4 * (plate.id - 0.5))
                + 0.16 * grain
                + 0.35 * lifted
                + 0.12 * chip * wall
                - 0.25 * self.flakes * bump((way - 0.04) / 0.07) * wall,
            accent: self.flakes * wall * (0.35 * hue + 0.6 * fresh).min(1.0),
            rough: -0.06 * fresh * self.flakes,
        }
    }
}

/// A mosaic of three layers, the outer ones shed in rounded flakes.
pub(super) struct Mosaic {
    bend: Warp,
    layers: [(Periodic, Periodic); 2],
    jag: Periodic,
    swell: Periodic,
    fleck: Periodic,
    grain: Periodic,
    shed: f32,
}

impl Mosaic {
    pub(super) fn new(loom: &mut Loom, part: Part, shed: f32) -> Self {
        let Part { width, length } = part;
        let mut layer = |scale: f32| {
            (
                loom.field(scale * width, scale * length),
                loom.field(2.6 * scale * width, 2.6 * scale * length),
            )
        };
        let layers = [layer(0.8), layer(1.0)];
        Self {
            bend: loom.warp([0.9 * width, 0.9 * length], [0.3 * width, 0.25 * length]),
            layers,
            jag: loom.field(0.2 * width, 0.2 * width),
            swell: loom.field(0.25, 0.3),
            fleck: loom.field(0.012, 0.018),
            grain: loom.field(0.004, 0.004),
            shed,
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let jag = self.jag.fbm(x, y, 2);
        let grain = self.grain.fbm(u, v, 2);
        let fleck = self.fleck.at(u, v);
        let swell = self.swell.at(u, v);
        // Above 0 where a layer is still there: flakes leave scallops about cell centres.
        let left = |index: usize, shed: f32| {
            let (flakes, groups) = &self.layers[index];
            let flake = flakes.cell(x, y);
            flake.centre + 0.1 * jag + 0.55 * groups.at(x, y) + 0.2 * (flake.id - 0.5) + 0.1 * patch
                - lerp(-0.45, 1.25, shed)
        };
        let middle = left(0, 0.85 * self.shed);
        let old = left(1, self.shed);
        let edge = |left: f32| smoothstep(0.0, 0.035, left);
        let on_middle = edge(middle);
        let on_old = edge(old);
        // Fresh edges curl a little.
        let curl = |left: f32| bump((left - 0.05) / 0.07);
        let height = 0.3
            + 0.18 * on_middle.max(on_old)
            + 0.24 * on_old
            + 0.12 * swell
            + 0.06 * curl(middle) * (1.0 - on_old)
            + 0.08 * curl(old)
            + 0.035 * fleck * (0.3 + on_old)
            + 0.03 * grain;
        let bright = 0.1 * patch + 0.1 * swell + 0.1 * fleck + 0.1 * grain;
        Point {
            height,
            tone: lerp(0.9, 0.12, on_old) + bright,
            accent: on_middle * (1.0 - on_old) * (0.85 + bright),
            rough: 0.14 * on_old - 0.06 * (1.0 - on_middle.max(on_old)),
        }
    }
}

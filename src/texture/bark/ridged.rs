//! Bark whose parts run along the stem: ridges, gnarled ridges, fibres.

use super::loom::{Loom, Stagger, Warp, bump};
use super::{Part, Point};
use crate::math::{lerp, smoothstep};
use crate::texture::noise::Periodic;

/// Corky ridges between furrows.
///
/// Long cells, read in two ways: as ridges, whose borders are furrows, and as furrows, whose borders
/// are a net of ridges.
pub(super) struct Ridged {
    stagger: Stagger,
    bend: Warp,
    wobble: Warp,
    islands: Periodic,
    net: Periodic,
    rib: Periodic,
    crack: Periodic,
    grain: Periodic,
    braid: f32,
    flat: f32,
    cracks: f32,
}

impl Ridged {
    pub(super) fn new(loom: &mut Loom, part: Part, shape: [f32; 3]) -> Self {
        let Part { width, length } = part;
        Self {
            stagger: loom.stagger(part, 0.42),
            bend: loom.warp([2.4 * width, length], [0.55 * width, 0.2 * length]),
            wobble: loom.warp([0.5 * width, 0.9 * width], [0.09 * width, 0.08 * width]),
            islands: loom.field(width, length),
            net: loom.field(1.1 * width, 0.8 * length),
            rib: loom.field(0.28 * width, 0.3 * length),
            crack: loom.field(0.5 * width, 0.62 * width),
            grain: loom.field(0.0035, 0.012),
            braid: shape[0],
            flat: shape[1],
            cracks: shape[2],
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, self.stagger.at(u, v));
        let (x, y) = self.wobble.at(x, y);
        let rib = self.rib.at(x, y);
        let wide = smoothstep(-0.5, 0.5, patch + 0.3 * rib);
        let mut ridge = 0.0;
        // A height and tone of each ridge's own, which fade towards its borders.
        let mut own = 0.0;
        // A braid starts with bridges over the furrows; the ridges between them go last.
        let parted = 1.0 - smoothstep(0.6, 1.0, self.braid);
        if parted > 0.0 {
            let cell = self.islands.cell(x, y);
            let wall = smoothstep(0.0, lerp(0.22, 0.4, wide), cell.border + 0.06 * rib);
            // Where the furrow closes, two ridges join.
            let joined = smoothstep(0.25, 0.7, -patch) * 0.45;
            ridge = lerp(wall, 0.85, joined) * parted;
            own = (cell.id - 0.5) * smoothstep(0.0, 0.2, cell.border);
        }
        if self.braid > 0.0 {
            let cell = self.net.cell(x, y);
            let foot = lerp(0.5, 0.36, wide) * lerp(0.35, 1.0, self.braid);
            let wall = 1.0 - smoothstep(0.05, foot, cell.border + 0.07 * rib);
            let high = smoothstep(0.0, 0.4, self.braid) * lerp(1.0, 0.85, wide);
            ridge = ridge.max(wall * high);
        }
        let crest = lerp(ridge, smoothstep(0.15, 0.55, ridge), self.flat);
        let round = lerp(0.8 + 0.2 * smoothstep(0.5, 1.0, ridge), 1.0, self.flat);
        let mask = smoothstep(
            0.75 - self.cracks,
            1.05 - self.cracks,
            0.5 + 0.5 * patch + 0.25 * rib,
        );
        let cut = if self.cracks > 0.0 && crest > 0.2 && mask > 0.0 {
            let cell = self.crack.cell(x, y);
            mask * smoothstep(0.2, 0.7, crest) * bump(cell.border / 0.13)
        } else {
            0.0
        };
        // Fine splits along the crests, where the ribs meet.
        let split = bump(rib / 0.13) * smoothstep(0.25, 0.7, crest);
        let grain = self.grain.fbm(x, v, 2);
        let height =
            0.06 + 0.68 * crest * round + 0.15 * rib * (0.35 + crest) - 0.15 * cut - 0.1 * split
                + 0.12 * own * crest
                + 0.09 * grain * (0.4 + 0.6 * crest);
        Point {
            height,
            tone: 0.04 + 0.82 * height + 0.14 * grain + 0.16 * own * crest - 0.08 * cut,
            accent: 0.3 * (1.0 - smoothstep(0.0, 0.14, height)),
            rough: 0.0,
        }
    }
}

/// Rounded twisted ridges with soft furrows, partly broken into scales, with pits.
pub(super) struct Gnarled {
    bend: Warp,
    wobble: Warp,
    knots: Periodic,
    swell: Periodic,
    scale: Periodic,
    grain: Periodic,
    fibre: Periodic,
    scales: f32,
}

impl Gnarled {
    pub(super) fn new(loom: &mut Loom, part: Part, scales: f32) -> Self {
        let Part { width, length } = part;
        Self {
            bend: loom.warp([2.2 * width, 1.1 * length], [0.75 * width, 0.35 * length]),
            wobble: loom.warp([0.5 * width, 0.8 * width], [0.16 * width, 0.12 * width]),
            knots: loom.field(width, length),
            swell: loom.field(0.42 * width, 0.32 * length),
            scale: loom.field(0.3 * width, 0.24 * length),
            grain: loom.field(0.005, 0.008),
            fibre: loom.field(0.004, 0.03),
            scales,
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let (x, y) = self.wobble.at(x, y);
        let knot = self.knots.cell(x, y);
        let swell = self.swell.fbm(x, y, 2);
        let ridge = smoothstep(-0.05, 0.5, knot.border + 0.1 * swell);
        let scale = self.scale.cell(x, y);
        let inside = smoothstep(0.0, 0.15, knot.border);
        let share = patch + 0.5 * (knot.id - 0.5) * inside;
        let broken = smoothstep(0.55 - 1.4 * self.scales, 1.2 - 1.4 * self.scales, share);
        let furrow = bump(scale.border / 0.24) * broken;
        let pit = (1.0 - smoothstep(0.05, 0.4, scale.centre)) * smoothstep(0.88, 0.93, scale.id);
        let grain = self.grain.fbm(u, v, 2);
        let fibre = self.fibre.at(x, y) * (1.0 - broken);
        let bare =
            smoothstep(0.35, 0.7, swell - 0.6 * patch) * smoothstep(0.6, 0.7, knot.id) * inside;
        let height = 0.2 + 0.5 * ridge + 0.18 * swell - 0.17 * furrow - 0.3 * pit
            + 0.14 * (scale.id - 0.5) * broken * smoothstep(0.0, 0.25, scale.border)
            + 0.2 * (knot.id - 0.5) * smoothstep(0.0, 0.3, knot.border)
            + 0.08 * grain
            + 0.05 * fibre;
        Point {
            height,
            tone: 0.16 + 0.8 * height + 0.14 * grain + 0.08 * fibre + 0.1 * patch
                - 0.12 * furrow
                - 0.12 * pit,
            accent: 0.8 * bare,
            rough: -0.05 * bare,
        }
    }
}

/// Fibrous strips along the stem.
pub(super) struct Fibrous {
    stagger: Stagger,
    bend: Warp,
    strips: Periodic,
    fibre: [Periodic; 2],
    shred: Periodic,
    tear: Periodic,
    shreds: f32,
}

impl Fibrous {
    pub(super) fn new(loom: &mut Loom, part: Part, shreds: f32) -> Self {
        let Part { width, length } = part;
        Self {
            stagger: loom.stagger(part, 0.42),
            bend: loom.warp([3.0 * width, 0.6 * length], [0.6 * width, 0.1 * length]),
            strips: loom.field(width, length),
            fibre: [
                loom.field(0.14 * width, 0.3 * length),
                loom.field(0.0022, 0.06),
            ],
            shred: loom.field(0.55 * width, 0.35 * length),
            tear: loom.field(0.006, 0.05),
            shreds,
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, self.stagger.at(u, v));
        let coarse = self.fibre[0].fbm(x, y, 2);
        let fine = self.fibre[1].fbm(x, y, 2);
        let strip = self.strips.cell(x, y);
        let wall = smoothstep(-0.02, 0.32, strip.border + 0.09 * coarse);
        let tear = self.tear.at(x, y);
        let shred = self.shred.at(x, y) + 0.3 * (strip.id - 0.5) + 0.12 * tear;
        let limit = lerp(0.9, -0.15, self.shreds);
        let loose = smoothstep(limit, limit + 0.05, shred);
        let lip = loose * (1.0 - smoothstep(limit + 0.05, limit + 0.3, shred));
        let height = 0.1
            + 0.5 * wall
            + 0.12 * coarse * (0.4 + wall)
            + 0.09 * fine
            + (0.13 * loose + 0.1 * lip) * (0.35 + 0.65 * wall)
            + 0.14 * (strip.id - 0.5) * wall;
        let grey = smoothstep(0.45, 0.85, height + 0.25 * patch);
        Point {
            height,
            tone: 0.04 + 0.75 * height + 0.24 * fine + 0.16 * coarse + 0.2 * (strip.id - 0.5),
            accent: grey * (0.45 + 0.25 * fine),
            rough: 0.0,
        }
    }
}

//! Bark that stays a skin: smooth, papery, banded.

use super::loom::{Loom, Spots, Warp, bump};
use super::{Part, Point};
use crate::math::{float, lerp, smoothstep};
use crate::texture::noise::{Periodic, floor};

/// Nearly flat: slow swellings, faint wrinkles across the stem, lenticels and eye scars.
pub(super) struct Smooth {
    bend: Warp,
    swell: Periodic,
    wrinkle: Periodic,
    fold: Periodic,
    grain: Periodic,
    streak: Periodic,
    lenticel: Spots,
    eye: Spots,
    wrinkles: f32,
    lenticels: f32,
    scars: f32,
}

impl Smooth {
    pub(super) fn new(loom: &mut Loom, part: Part, shape: [f32; 3]) -> Self {
        let Part { width, length } = part;
        Self {
            bend: loom.warp([width, length], [0.12 * width, 0.1 * length]),
            swell: loom.field(width, length),
            wrinkle: loom.field(0.09, 0.006),
            fold: loom.field(0.22, 0.035),
            grain: loom.field(0.004, 0.005),
            streak: loom.field(0.012, 0.16),
            lenticel: loom.spots([0.006, 0.0024], [1.7, 3.6]),
            eye: loom.spots([0.028, 0.017], [3.6, 6.5]),
            wrinkles: shape[0],
            lenticels: shape[1],
            scars: shape[2],
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let swell = self.swell.fbm(x, y, 2);
        let grain = self.grain.fbm(u, v, 2);
        let streak = self.streak.fbm(x, y, 2);
        let eye = if self.scars > 0.0 {
            self.eye(x, y)
        } else {
            Eye::default()
        };
        let near = 1.0 + 1.5 * eye.near;
        let wrinkle = self.wrinkle.at(x, y) * smoothstep(-0.5, 0.6, patch) * near;
        let fold = self.fold.ridge(x, y) * smoothstep(-0.3, 0.6, swell) * near;
        let crease = self.wrinkles * (0.8 * wrinkle + 1.1 * smoothstep(0.6, 1.0, fold));
        let lenticel = self.lenticel.dashes(x, y, 0.6 * self.lenticels);
        let height =
            0.45 + 0.14 * swell - 0.2 * crease + 0.16 * lenticel + 0.05 * grain + 0.4 * eye.rim
                - 0.45 * eye.pupil;
        Point {
            height,
            tone: 0.55 + 0.4 * patch + 0.3 * swell + 0.2 * grain + 0.22 * streak - 0.3 * crease,
            accent: (0.75 * lenticel + 0.75 * eye.pupil + 0.5 * eye.line).min(1.0),
            rough: 0.06 * lenticel + 0.1 * eye.pupil + 0.05 * grain,
        }
    }

    /// The scar of a lost branch: a sunken pupil in a raised rim, under a drooping brow line.
    fn eye(&self, u: f32, v: f32) -> Eye {
        let (cell, [x, y]) = self.eye.at(u, v);
        if cell.id >= self.scars {
            return Eye::default();
        }
        let size = 0.45 + 0.55 * cell.draw(1.0);
        let (x, y) = (x / size, y / size);
        let out = (x * x + y * y).sqrt();
        let inside = smoothstep(0.02, 0.12, cell.border);
        // The brow starts on the rim's top and falls on both sides, fading.
        let span = 1.0 - smoothstep(1.3, 2.6, x.abs());
        let brow = bump((y - 1.35 + 0.55 * x.abs()) / 0.3) * span;
        Eye {
            pupil: (1.0 - smoothstep(0.35, 0.8, out)) * inside,
            rim: bump((out - 1.0) / 0.5) * inside,
            line: (brow + 0.5 * bump((out - 0.85) / 0.18)).min(1.0) * inside,
            near: (1.0 - smoothstep(0.8, 2.4, out)) * inside,
        }
    }
}

/// Parts of an eye scar, each 0..=1.
#[derive(Default)]
struct Eye {
    pupil: f32,
    rim: f32,
    line: f32,
    near: f32,
}

/// Sheets that tear off around the stem.
struct Peel {
    sheet: Periodic,
    tear: Periodic,
    amount: f32,
}

/// What a sheet is at a point, each 0..=1.
struct Sheet {
    /// The sheet is gone.
    bare: f32,
    /// Its curled edge.
    lip: f32,
}

impl Peel {
    fn new(loom: &mut Loom, size_m: [f32; 2], amount: f32) -> Self {
        Self {
            sheet: loom.field(size_m[0], size_m[1]),
            tear: loom.field(0.16 * size_m[0], 0.2 * size_m[1]),
            amount,
        }
    }

    fn at(&self, u: f32, v: f32, patch: f32) -> Sheet {
        if self.amount <= 0.0 {
            return Sheet {
                bare: 0.0,
                lip: 0.0,
            };
        }
        let edge = self.sheet.at(u, v) + 0.35 * patch + 0.16 * self.tear.at(u, v);
        let limit = lerp(0.95, -0.5, self.amount);
        let bare = smoothstep(limit, limit + 0.05, edge);
        Sheet {
            bare,
            lip: smoothstep(limit - 0.22, limit, edge) * (1.0 - bare),
        }
    }
}

/// White paper: dark dashes, torn sheets, black diamonds.
pub(super) struct Papery {
    bend: Warp,
    ply: Periodic,
    streak: Periodic,
    grain: Periodic,
    dash: [Spots; 2],
    peel: Peel,
    diamond: Spots,
    jag: Periodic,
    crag: Periodic,
    lenticels: f32,
    diamonds: f32,
}

impl Papery {
    pub(super) fn new(loom: &mut Loom, part: Part, shape: [f32; 3]) -> Self {
        let Part { width, length } = part;
        Self {
            bend: loom.warp([0.12, 0.12], [0.008, 0.006]),
            ply: loom.field(0.16, 0.0035),
            streak: loom.field(0.22, 0.028),
            grain: loom.field(0.0025, 0.0025),
            dash: [
                loom.spots([0.022, 0.0016], [1.5, 7.0]),
                loom.spots([0.007, 0.001], [1.7, 6.0]),
            ],
            peel: Peel::new(loom, [0.11, 0.026], shape[1]),
            diamond: loom.spots([0.5 * width, 0.5 * length], [1.15, 1.15]),
            jag: loom.field(0.2 * width, 0.1 * length),
            crag: loom.field(0.01, 0.026),
            lenticels: shape[0],
            diamonds: shape[2],
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let ply = self.ply.fbm(x, y, 2);
        let streak = self.streak.at(x, y);
        let grain = self.grain.at(u, v);
        let black = self.black(x, y);
        let Sheet { bare, lip } = self.peel.at(x, y, patch);
        let share = 0.75 * self.lenticels;
        let dash = self.dash[0]
            .dashes(x, y, share)
            .max(0.75 * self.dash[1].dashes(x, y, share));
        let paper =
            0.5 + 0.05 * ply + 0.05 * streak + 0.03 * grain + 0.2 * lip - 0.16 * bare + 0.06 * dash;
        let tone = 0.83 + 0.16 * ply + 0.16 * streak + 0.1 * patch + 0.12 * lip - 0.85 * dash;
        if black <= 0.0 {
            return Point {
                height: paper,
                tone,
                accent: bare * (0.75 + 0.25 * ply) * (1.0 - 0.8 * dash),
                rough: 0.2 * dash,
            };
        }
        let crag = self.crag.cell(x + 0.004 * grain, y);
        let wall = smoothstep(0.02, 0.3, crag.border);
        let rough = 0.25 + 0.55 * wall + 0.2 * (crag.id - 0.5) * wall + 0.06 * grain;
        Point {
            height: lerp(paper, rough, black),
            tone: lerp(tone, 0.02 + 0.14 * wall + 0.05 * grain, black),
            accent: bare * (1.0 - black),
            rough: lerp(0.2 * dash, 0.3, black),
        }
    }

    /// How far a point lies inside a black diamond: 0 outside, 1 within.
    fn black(&self, u: f32, v: f32) -> f32 {
        if self.diamonds <= 0.0 {
            return 0.0;
        }
        let (cell, [x, y]) = self.diamond.at(u, v);
        if cell.id >= self.diamonds {
            return 0.0;
        }
        let draw = cell.draw(1.0);
        let size = 0.4 + 0.6 * draw * draw;
        let out = x.abs() + y.abs() + 0.3 * self.jag.fbm(u, v, 3);
        (1.0 - smoothstep(0.8, 0.95, out / size)) * smoothstep(0.03, 0.1, cell.border)
    }
}

/// Satin skin with bands of corky lenticels.
pub(super) struct Banded {
    bend: Warp,
    bands: u32,
    row: Periodic,
    satin: Periodic,
    streak: Periodic,
    dash: [Spots; 2],
    peel: Peel,
    lenticels: f32,
}

impl Banded {
    pub(super) fn new(loom: &mut Loom, part: Part, shape: [f32; 2]) -> Self {
        let Part { width, length } = part;
        let row = loom.field(4.0 * width, length);
        Self {
            bend: loom.warp([0.2, 0.1], [0.01, 0.14 * length]),
            bands: row.cells()[1],
            row,
            satin: loom.field(0.09, 0.002),
            streak: loom.field(0.16, 0.018),
            dash: [
                loom.spots([0.5 * width, 0.12 * width], [1.1, 1.7]),
                loom.spots([0.25 * width, 0.07 * width], [2.0, 6.0]),
            ],
            peel: Peel::new(loom, [0.14, 0.3 * length], shape[1]),
            lenticels: shape[0],
        }
    }

    pub(super) fn at(&self, u: f32, v: f32, patch: f32) -> Point {
        let (x, y) = self.bend.at(u, v);
        let satin = self.satin.fbm(x, y, 2);
        let streak = self.streak.fbm(x, y, 2);
        let way = y * float(self.bands);
        let way = way - floor(way) - 0.5;
        // Which stretches of a band bear lenticels, and how thick it is there.
        let strong = self.row.at(x, y) + 0.3 * streak;
        let thick = 0.08 + 0.22 * smoothstep(-0.4, 0.7, strong);
        let band = 1.0 - smoothstep(0.7 * thick, thick, way.abs());
        let limit = 0.55 - 1.1 * self.lenticels;
        let share = band * smoothstep(limit - 0.2, limit + 0.2, strong);
        let Sheet { bare, lip } = self.peel.at(x, y, patch);
        let cork = (self.dash[0].dashes(x, y, 0.85) * smoothstep(0.2, 0.6, share))
            .max(0.8 * self.dash[1].dashes(x, y, 0.4 * self.lenticels));
        Point {
            height: 0.4 + 0.03 * satin + 0.06 * streak + 0.3 * cork + 0.22 * lip - 0.1 * bare
                + 0.06 * share,
            tone: 0.52 + 0.3 * streak + 0.2 * satin + 0.3 * bare + 0.15 * patch - 0.16 * share,
            accent: (0.9 * cork + 0.2 * lip).min(1.0),
            rough: 0.4 * cork + 0.1 * bare + 0.06 * satin,
        }
    }
}

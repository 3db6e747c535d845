//! One leaf blade in its own frame: outline, veins, and the slopes of its surface.
//!
//! The frame: `u` runs along the midrib (0 at the base of the blade, 1 at the tip, negative on the
//! petiole), `v` across it, in parts of the blade's length. Slopes are height over way.

use crate::math::{Vec2, lerp, smoothstep};
use crate::species::schema::Blade;

/// Steps of the tabulated outline.
const STEPS: u16 = 512;
/// Blades narrower than this have veins along them, as grasses and palms do.
const PARALLEL_VEINED: f32 = 0.12;
/// Where the midrib narrows to at the tip, and how wide it is at the base, in blade lengths.
const MIDRIB: [f32; 2] = [0.003, 0.011];
/// Cotangent of the angle between side veins and the midrib (about 50 degrees).
const VEIN_LEAN: f32 = 0.85;

/// Half width of a blade by position along it: a beta profile, tabulated.
pub(super) struct Outline {
    /// At `STEPS + 1` positions; 1 at the widest.
    table: Vec<f32>,
    /// Half width over length.
    half: f32,
    teeth: f32,
    tooth_depth: f32,
    veins: f32,
}

/// What a blade's surface is like at one point.
pub(super) struct Surface {
    /// Slope of the height along the midrib and across it.
    pub(super) slope: Vec2,
    /// 0 between the veins ..= 1 on a main vein.
    pub(super) vein: f32,
    /// Way from the midrib (0) to the margin (1).
    pub(super) margin: f32,
}

impl Outline {
    /// The outline of `blade`, scaled to `half` of its own length at the widest.
    pub(super) fn new(blade: &Blade, half: f32) -> Self {
        let (a, b) = (
            (2.0 * blade.sharpness * blade.widest).max(0.02),
            (2.0 * blade.sharpness * (1.0 - blade.widest)).max(0.02),
        );
        let beta = |u: f32| libm::powf(u, a) * libm::powf(1.0 - u, b);
        let most = beta(a / (a + b)).max(1e-6);
        Self {
            table: (0..=STEPS)
                .map(|i| beta(f32::from(i) / f32::from(STEPS)) / most)
                .collect(),
            half,
            teeth: blade.teeth as f32,
            tooth_depth: blade.tooth_depth.clamp(0.0, 1.0),
            veins: blade.veins as f32,
        }
    }

    /// Greatest half width over length.
    pub(super) fn half(&self) -> f32 {
        self.half
    }

    /// Half width at `u`, teeth included, in blade lengths; 0 outside 0..=1.
    pub(super) fn half_at(&self, u: f32) -> f32 {
        let smooth = self.entire_at(u);
        if self.teeth == 0.0 {
            return smooth;
        }
        let phase = u * self.teeth;
        let phase = phase - phase.floor();
        // Rises over seven tenths and falls over three: the teeth point to the tip.
        let tooth = if phase < 0.7 {
            phase / 0.7
        } else {
            (1.0 - phase) / 0.3
        };
        let rounded = tooth * (1.5 - 0.5 * tooth);
        // Neither the base nor the very tip has teeth.
        let here = smoothstep(0.02, 0.12, u) * (1.0 - smoothstep(0.88, 0.98, u));
        smooth * (1.0 - self.tooth_depth * here * (1.0 - rounded))
    }

    fn entire_at(&self, u: f32) -> f32 {
        if !(0.0..=1.0).contains(&u) {
            return 0.0;
        }
        let place = u * f32::from(STEPS);
        let low = crate::math::floor_to_u32(place).min(u32::from(STEPS) - 1) as usize;
        self.half * lerp(self.table[low], self.table[low + 1], place - low as f32)
    }

    /// The surface at a point on the blade; `fold` is the slope of each half up from the midrib,
    /// and `shift` moves the veins of one blade against another's, 0..1.
    pub(super) fn surface(&self, u: f32, v: f32, fold: f32, shift: f32) -> Surface {
        let across = v.abs();
        let side = if v < 0.0 { -1.0 } else { 1.0 };
        let local = self.entire_at(u).max(1e-4);
        let margin = (across / local).min(1.0);
        let rib = lerp(MIDRIB[1], MIDRIB[0], u).min(self.half * 0.16);
        let x = v / rib;
        let bell = bell_of(x);
        // The halves rise from the midrib and roll down again at the margin; the tip bows down.
        let rise = fold * x / (1.0 + x.abs()) - 0.28 * side * margin * margin;
        let bow = 0.12 - 0.4 * u * u;
        let mut slope = Vec2::new(bow, rise + 0.8 * x * bell * bell);
        let mut vein = bell;
        if self.veins > 0.0 {
            let (mask, tilt) = if self.half * 2.0 < PARALLEL_VEINED {
                self.parallel_veins(u, across, local, side)
            } else {
                self.side_veins(u, across, margin, side, shift)
            };
            vein = vein.max(mask);
            slope += tilt;
        }
        Surface {
            slope,
            vein,
            margin,
        }
    }

    /// Veins that leave the midrib and bend toward the tip.
    fn side_veins(&self, u: f32, across: f32, margin: f32, side: f32, shift: f32) -> (f32, Vec2) {
        // Curved: the further out, the more along the blade.
        let lean = VEIN_LEAN * (0.8 + 0.5 * margin);
        let offset = shift + if side < 0.0 { 0.42 } else { 0.0 };
        // A slow wobble keeps the spacing from being even.
        let wobble = 0.13 * wave(1.4 * u + 6.4 * shift + 0.2 * side);
        let phase = (u - lean * across) * self.veins + offset + wobble;
        let from_middle = phase - phase.floor() - 0.5;
        let across_vein = 1.0 / (1.0 + lean * lean).sqrt();
        let distance = from_middle / self.veins * across_vein;
        let width = lerp(0.0045, 0.0018, margin);
        let x = distance / width;
        let bell = bell_of(x);
        let strength = 0.6 * (1.0 - smoothstep(0.75, 1.0, margin)) * smoothstep(0.0, 0.06, u);
        // The blade bulges between veins.
        let quilt = -0.16 * wave(from_middle) * (1.0 - margin * margin);
        let direction = Vec2::new(across_vein, -side * lean * across_vein);
        let tilt = direction * (0.5 * strength * x * bell * bell - quilt);
        (strength * bell, tilt)
    }

    /// Veins that run beside the midrib from base to tip.
    fn parallel_veins(&self, u: f32, across: f32, local: f32, side: f32) -> (f32, Vec2) {
        let phase = across / local * self.veins;
        let from_middle = phase - phase.floor() - 0.5;
        let bell = bell_of(from_middle * 5.0);
        let strength = 0.3 * smoothstep(0.0, 0.1, u) * (1.0 - smoothstep(0.9, 1.0, u));
        let tilt = 0.12 * side * wave(from_middle);
        (strength * bell, Vec2::new(0.0, tilt))
    }
}

/// 1 at 0, falling off to both sides: a cheap bell curve.
fn bell_of(x: f32) -> f32 {
    let y = 1.0 + x * x;
    1.0 / (y * y)
}

/// Close to a sine of `turns`, from two parabolas.
fn wave(turns: f32) -> f32 {
    let x = turns - (turns + 0.5).floor();
    8.0 * x * (1.0 - 2.0 * x.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn elliptic() -> Blade {
        Blade {
            width: 0.4,
            widest: 0.3,
            sharpness: 0.5,
            teeth: 0,
            tooth_depth: 0.0,
            veins: 6,
        }
    }

    #[test]
    fn a_blade_is_widest_where_its_description_says() {
        let outline = Outline::new(&elliptic(), 0.2);
        assert!((outline.half_at(0.3) - 0.2).abs() < 1e-4);
        assert!(outline.half_at(0.25) < 0.2 && outline.half_at(0.35) < 0.2);
        assert_eq!(outline.half_at(-0.01), 0.0);
        assert!(outline.half_at(1.0) < 1e-6);
    }

    #[test]
    fn teeth_only_cut_into_the_blade() {
        let toothed = Blade {
            teeth: 9,
            tooth_depth: 0.3,
            ..elliptic()
        };
        let (entire, toothed) = (Outline::new(&elliptic(), 0.2), Outline::new(&toothed, 0.2));
        let mut cut = 0;
        for i in 0..=100 {
            let u = i as f32 / 100.0;
            assert!(toothed.half_at(u) <= entire.half_at(u));
            assert!(toothed.half_at(u) >= entire.half_at(u) * 0.69);
            cut += u32::from(toothed.half_at(u) < entire.half_at(u) * 0.95);
        }
        assert!(cut > 20, "{cut}");
    }

    #[test]
    fn the_halves_of_a_folded_blade_face_each_other() {
        let outline = Outline::new(&elliptic(), 0.2);
        let slope = |v: f32| outline.surface(0.4, v, 0.3, 0.0).slope.y;
        assert!(slope(0.06) > 0.05 && slope(-0.06) < -0.05);
        let on_rib = outline.surface(0.4, 0.0, 0.3, 0.0);
        assert!(on_rib.vein > 0.99 && on_rib.margin == 0.0);
    }
}

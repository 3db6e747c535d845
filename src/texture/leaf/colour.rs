//! Colours of leaves: measured tissue, and what season, age and health make of it.
//!
//! The table is reflectance and transmittance of 13 states in linear sRGB under D65, computed with
//! PROSPECT-D (Feret et al. 2017, "PROSPECT-D: towards modeling leaf optical properties through a
//! complete lifecycle"). Green leaves are dark: an albedo of about 0.1.

use crate::math::{Vec3, lerp, smoothstep};
use crate::species::schema::{LeafArt, LeafState, Tissue};

/// Reflectance and transmittance of a state, linear RGB.
const fn measured(tissue: Tissue) -> ([f32; 3], [f32; 3]) {
    match tissue {
        Tissue::Young => ([0.1593, 0.2261, 0.0350], [0.1933, 0.2558, 0.0081]),
        Tissue::LightGreen => ([0.0842, 0.1463, 0.0314], [0.0976, 0.1651, 0.0]),
        Tissue::MidGreen => ([0.0676, 0.1246, 0.0327], [0.0602, 0.1195, 0.0]),
        Tissue::DarkGreen => ([0.0544, 0.1093, 0.0342], [0.0269, 0.0746, 0.0]),
        Tissue::Evergreen => ([0.0599, 0.1132, 0.0337], [0.0117, 0.0371, 0.0]),
        Tissue::BlueGreen => ([0.0947, 0.1671, 0.0307], [0.0225, 0.0546, 0.0]),
        Tissue::Turning => ([0.3028, 0.2331, 0.0243], [0.2950, 0.2111, 0.0]),
        Tissue::Yellow => ([0.5137, 0.2888, 0.0286], [0.4696, 0.2426, 0.0]),
        Tissue::Orange => ([0.3320, 0.1338, 0.0381], [0.2967, 0.0979, 0.0001]),
        Tissue::Red => ([0.2678, 0.0692, 0.0439], [0.2365, 0.0358, 0.0052]),
        Tissue::Purple => ([0.0624, 0.0436, 0.0404], [0.0438, 0.0101, 0.0]),
        Tissue::Russet => ([0.2190, 0.1206, 0.0466], [0.1359, 0.0550, 0.0021]),
        Tissue::Dead => ([0.1330, 0.0805, 0.0542], [0.0462, 0.0157, 0.0033]),
    }
}

/// Reflectance of a measured state, linear RGB, 0..=1.
#[must_use]
pub fn reflectance(tissue: Tissue) -> [f32; 3] {
    measured(tissue).0
}

/// One state of tissue on the way from bud to litter.
#[derive(Clone, Copy, Debug)]
struct Tone {
    colour: Vec3,
    /// Transmitted over reflected light.
    through: f32,
}

impl Tone {
    fn of(tissue: Tissue) -> Self {
        let (reflected, passed) = measured(tissue);
        let light = |rgb: [f32; 3]| Vec3::from_array(rgb).dot(Vec3::new(0.25, 0.65, 0.1));
        Self {
            colour: Vec3::from_array(reflected),
            through: (light(passed) / light(reflected)).min(1.0),
        }
    }

    fn mix(self, other: Self, t: f32) -> Self {
        Self {
            colour: self.colour.lerp(other.colour, t),
            through: lerp(self.through, other.through, t),
        }
    }
}

/// The colours of all leaves of one kind in one state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Palette {
    green: Tone,
    turning: Tone,
    autumn: Tone,
    dead: Tone,
    /// How far the leaves have turned, 0 green, 1 wholly, 2 dead.
    turned: f32,
    /// 0 whole ..= 1 blighted.
    pub(super) ill: f32,
}

/// A place of a blade, for its colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// 0 at the midrib's foot ..= 1 at the tip.
    pub(super) along: f32,
    /// 0 deep inside ..= 1 at the margin.
    pub(super) edge: f32,
    /// 0 between veins ..= 1 on a main vein.
    pub(super) vein: f32,
    /// Blotches, -1..1.
    pub(super) noise: f32,
    /// A blade's own haste, -1..1.
    pub(super) haste: f32,
    /// 0 none ..= 1 the middle of a brown spot.
    pub(super) blight: f32,
}

impl Palette {
    pub(super) fn new(art: &LeafArt, state: LeafState) -> Self {
        let measured = Tone::of(art.summer);
        let summer = Tone {
            colour: art.colour.map_or(measured.colour, Vec3::from_array),
            through: art.translucency.unwrap_or(measured.through),
        };
        let season = state.season.clamp(0.0, 3.0);
        let youth = (1.0 - season).max(1.0 - 2.0 * state.age).clamp(0.0, 1.0);
        let deciduous = art.autumn.is_some();
        // A young leaf of a hand-picked colour is paler in the same measure as a measured one.
        let young = Tone::of(Tissue::Young);
        let paler = young.colour / Tone::of(Tissue::MidGreen).colour;
        let young = Tone {
            colour: (summer.colour * paler).min(Vec3::new(0.3, 0.34, 0.12)),
            through: summer.through.max(lerp(summer.through, young.through, 0.6)),
        };
        // Evergreens keep more of their colour in spring: only shoots are young.
        let youth = youth * if deciduous { 0.8 } else { 0.35 };
        let autumn = if deciduous {
            (season - 1.0).max(0.0)
        } else {
            0.0
        };
        let aged = (2.0 * state.age - 1.0).max(0.0);
        Self {
            green: summer.mix(young, youth),
            turning: Tone::of(Tissue::Turning),
            autumn: Tone::of(art.autumn.unwrap_or(Tissue::Yellow)),
            dead: Tone::of(Tissue::Dead),
            turned: autumn.max(0.9 * aged),
            ill: 1.0 - state.health.clamp(0.0, 1.0),
        }
    }

    /// The colour of sound green tissue.
    pub(super) fn green(&self) -> Vec3 {
        self.green.colour
    }

    /// Colour and translucency of a place.
    pub(super) fn at(&self, spot: &Spot) -> (Vec3, f32) {
        let mut tone = self.green;
        if self.turned > 0.0 {
            // Margin and tip turn first; green lingers along veins.
            let lead = 0.34 * spot.edge * spot.edge + 0.14 * spot.along + 0.22 * spot.noise
                - 0.35 * spot.vein
                + 0.34 * spot.haste
                - 0.36;
            let t = 1.5 * self.turned + lead;
            tone = tone.mix(self.turning, smoothstep(0.1, 0.6, t) * 0.85);
            tone = tone.mix(self.autumn, smoothstep(0.4, 1.0, t));
            tone = tone.mix(self.dead, smoothstep(1.9, 2.9, t));
        }
        if self.ill > 0.0 {
            // Yellow between the veins, then brown from the margin, and spots.
            let pale = self.ill * (0.45 + 0.4 * spot.noise) * (1.0 - spot.vein);
            tone = tone.mix(self.turning, pale.clamp(0.0, 0.7));
            let scorch = smoothstep(1.25, 1.5, spot.edge + 0.6 * self.ill + 0.3 * spot.noise);
            tone = tone.mix(self.dead, scorch.max(spot.blight));
        }
        (tone.colour, tone.through)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPOT: Spot = Spot {
        along: 0.5,
        edge: 0.2,
        vein: 0.0,
        noise: 0.0,
        haste: 0.0,
        blight: 0.0,
    };

    fn state(season: f32) -> LeafState {
        LeafState {
            season,
            ..LeafState::default()
        }
    }

    #[test]
    fn a_summer_leaf_has_the_measured_colour_and_one_given_by_hand_wins() {
        let mut art = LeafArt {
            autumn: Some(Tissue::Yellow),
            ..LeafArt::default()
        };
        let (colour, _) = Palette::new(&art, state(1.0)).at(&SPOT);
        assert_eq!(colour.to_array(), reflectance(Tissue::MidGreen));
        art.colour = Some([0.2, 0.1, 0.3]);
        let (colour, _) = Palette::new(&art, state(1.0)).at(&SPOT);
        assert_eq!(colour.to_array(), [0.2, 0.1, 0.3]);
    }

    #[test]
    fn the_margin_turns_before_the_veins_and_evergreens_do_not() {
        let mut art = LeafArt {
            autumn: Some(Tissue::Yellow),
            ..LeafArt::default()
        };
        let red = |art: &LeafArt, spot: &Spot| Palette::new(art, state(1.3)).at(spot).0.x;
        let margin = Spot { edge: 1.0, ..SPOT };
        let vein = Spot { vein: 1.0, ..SPOT };
        assert!(red(&art, &margin) > red(&art, &SPOT) && red(&art, &SPOT) > red(&art, &vein));
        art.autumn = None;
        assert_eq!(red(&art, &margin), red(&art, &vein));
    }

    #[test]
    fn more_light_never_leaves_a_leaf_than_falls_on_it() {
        let all = [
            Tissue::Young,
            Tissue::LightGreen,
            Tissue::MidGreen,
            Tissue::DarkGreen,
            Tissue::Evergreen,
            Tissue::BlueGreen,
            Tissue::Turning,
            Tissue::Yellow,
            Tissue::Orange,
            Tissue::Red,
            Tissue::Purple,
            Tissue::Russet,
            Tissue::Dead,
        ];
        for tissue in all {
            let (reflected, passed) = measured(tissue);
            for (r, t) in reflected.iter().zip(passed) {
                assert!(*r > 0.0 && t >= 0.0 && r + t < 1.0, "{tissue:?}");
            }
        }
    }
}

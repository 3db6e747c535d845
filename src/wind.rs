//! Wind: what a mesh tells of how its vertices sway, and where they are in a given wind at a given time.
//!
//! Home of: Candussi, Höllerer, Candussi 2005, "Real-Time Rendering of Realistic Trees in Mixed Reality",
//! section 2.2. The tip of every branch is displaced, the rest of it by its distance from the tip; the
//! displacement is the sum of a vector along the wind and a smaller one across it, both changed by periodic
//! factors; leaves turn about the axis of view by a sine. How flexible branches are is worked out when the
//! tree is built (`tree::flex`, `mesh::sway`), and lies in eight bytes a vertex, [`Sway`].
//!
//! Changes versus the paper: a vertex moves with all branches that carry it, in three bands of the same
//! formula (the first level, the second, all deeper ones), so that one vertex shader pass does for every
//! branch and every LOD; a leaning point is lowered so that branches keep about their length; strength grows
//! with the speed's power of 1.5, since leaves fold in strong wind (Vogel's exponent -0.5).
//!
//! `shaders/wind.wgsl` holds the same formula with the same constants for renderers.
//!
//! Guarantees: no wind, no displacement; a weight of zero stays where it is; displacement changes smoothly
//! with time and is bounded by [`Rig::bound_m`]. Cost: about twenty sines a vertex.

use crate::math::{TAU, Vec2, Vec3};

/// How one vertex sways: 8 bytes, the attributes `_WIND` and `_WIND_LEAF` of a pack's meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sway {
    /// Unsigned, normalised: weights of the three bands as parts of [`Rig::amplitude_m`], then the phase of
    /// the limb as a part of a turn.
    pub wind: [u8; 4],
    /// Signed, normalised: the way from the leaf's hinge to the vertex as parts of [`Rig::leaf_reach_m`],
    /// then the leaf's phase in half turns. Zero for what does not turn.
    pub leaf: [i8; 4],
}

impl Sway {
    /// The four numbers of `_WIND`, 0..=1.
    #[must_use]
    pub fn weights(&self) -> [f32; 4] {
        self.wind.map(|byte| f32::from(byte) / 255.0)
    }

    /// The four numbers of `_WIND_LEAF`, -1..=1.
    #[must_use]
    pub fn turns(&self) -> [f32; 4] {
        self.leaf.map(|byte| (f32::from(byte) / 127.0).max(-1.0))
    }
}

/// How the attributes of all meshes of one tree are to be read. Its layout is that of `WindRig` in WGSL.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Rig {
    /// By band: lean that a weight of 1 stands for at [`REFERENCE_SPEED_M_S`], metres.
    pub amplitude_m: [f32; 3],
    /// Distance from its hinge that 1 stands for in a leaf's offset, metres.
    pub leaf_reach_m: f32,
    /// By band: how often branches swing a second.
    pub frequency_hz: [f32; 3],
    /// Largest turn of leaves at [`REFERENCE_SPEED_M_S`], radians.
    pub leaf_angle: f32,
}

impl Rig {
    /// No vertex of the tree is displaced farther than this in a wind, metres.
    #[must_use]
    pub fn bound_m(&self, wind: &Wind) -> f32 {
        let lean: f32 = self.amplitude_m.iter().sum();
        let swing = 1.0 + (GUST + SWING + ACROSS) * wind.gustiness;
        // Half of the lean is the most that a leaning point sinks. A leaf's offset has three components.
        lean * swing * 1.5 * wind.strength() + 2.0 * 1.733 * self.leaf_reach_m
    }
}

/// Wind over a scene. Its layout is that of `Wind` in WGSL.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Wind {
    /// Whither it blows: x and z of a horizontal unit vector.
    pub direction: Vec2,
    /// Mean speed, metres a second, 0 or more. Above 30 trees lean no farther.
    pub speed_m_s: f32,
    /// 0 (steady: trees lean and stand) ..= 1 (gusty).
    pub gustiness: f32,
}

impl Default for Wind {
    /// A fresh breeze along +X.
    fn default() -> Self {
        Self {
            direction: Vec2::X,
            speed_m_s: 8.0,
            gustiness: 0.7,
        }
    }
}

impl Wind {
    /// Lean as a multiple of the lean at [`REFERENCE_SPEED_M_S`].
    #[must_use]
    pub fn strength(&self) -> f32 {
        let part = self.part_of_reference();
        part * part.sqrt()
    }

    fn part_of_reference(&self) -> f32 {
        (self.speed_m_s / REFERENCE_SPEED_M_S).clamp(0.0, MOST_SPEED)
    }

    /// How much later than at the origin gusts reach a tree whose foot is at `base`, seconds: subtract it
    /// from the time. `scatter` (0..=1, one number a tree) keeps neighbours from swinging in step.
    #[must_use]
    pub fn delay_s(&self, base: Vec3, scatter: f32) -> f32 {
        Vec2::new(base.x, base.z).dot(self.direction) / FRONT_M_S + scatter * SCATTER_S
    }
}

/// Speed at which amplitudes are given, metres a second.
pub const REFERENCE_SPEED_M_S: f32 = 10.0;
/// Speed beyond which trees lean no farther, as a multiple of the reference's.
const MOST_SPEED: f32 = 3.0;
/// Speed at which gusts travel over a scene, metres a second: one for all winds, so that a change of the
/// wind does not move the gusts that are under way.
const FRONT_M_S: f32 = 10.0;
/// Neighbouring trees are at most so many seconds out of step.
const SCATTER_S: f32 = 7.0;

/// Part of the lean that gusts, swings along the wind and swings across it add at gustiness 1.
const GUST: f32 = 0.45;
const SWING: f32 = 0.35;
const ACROSS: f32 = 0.25;
/// Frequencies of gusts, hertz, with their shares. No two have a common period of less than minutes.
const GUST_HZ: [f32; 3] = [0.071, 0.113, 0.197];
const GUST_SHARE: [f32; 3] = [0.5, 0.3, 0.2];
/// A swing is two waves, of a band's frequency times these factors, with these shares.
const SWING_RATIO: [f32; 2] = [1.0, 1.37];
const ACROSS_RATIO: [f32; 2] = [0.83, 1.19];
const SWING_SHARE: [f32; 2] = [0.6, 0.4];
/// How far swings across the wind lag behind those along it, turns: tips draw ellipses, not lines.
const ACROSS_LAG: f32 = 0.25;
/// Frequencies of a leaf's turn, hertz, with their shares.
const LEAF_HZ: [f32; 2] = [1.7, 2.9];
const LEAF_SHARE: [f32; 2] = [0.65, 0.35];
/// Part of a leaf's turn that is left in a steady wind.
const LEAF_STEADY: f32 = 0.4;

/// Where the wind takes a vertex, metres from its place at rest.
///
/// `time_s` is the time at the tree (see [`Wind::delay_s`]); keep it below some hours, or floats lose the
/// fast waves. `height_m` is how high the vertex stands above the tree's foot at rest. `view_axis` is the
/// unit vector along which the picture is taken (the light's for a shadow map): leaves turn about it.
#[must_use]
pub fn displacement(
    wind: &Wind,
    rig: &Rig,
    time_s: f32,
    height_m: f32,
    sway: Sway,
    view_axis: Vec3,
) -> Vec3 {
    let [w0, w1, w2, phase] = sway.weights();
    let gust = gust(time_s);
    let (mut along, mut across) = (0.0, 0.0);
    for (band, (weight, phase)) in [(w0, 0.0), (w1, phase), (w2, phase)]
        .into_iter()
        .enumerate()
    {
        let lean = weight * rig.amplitude_m[band];
        let at = rig.frequency_hz[band] * time_s;
        let swing = pair(at, SWING_RATIO, SWING_SHARE, phase);
        let aside = pair(at, ACROSS_RATIO, SWING_SHARE, phase + ACROSS_LAG);
        along += lean * (1.0 + wind.gustiness * (GUST * gust + SWING * swing));
        across += lean * wind.gustiness * ACROSS * aside;
    }
    let (along, across) = (along * wind.strength(), across * wind.strength());
    let Vec2 { x, y: z } = wind.direction;
    let away = (along * along + across * across).sqrt();
    // A point at the end of a rod of this height, leaning so far, sinks by about so much.
    let sink = 0.5 * away * away / height_m.max(away).max(1e-4);
    let lean = Vec3::new(x * along - z * across, -sink, z * along + x * across);
    lean + flutter(wind, rig, time_s, gust, sway, view_axis)
}

/// The turn of a leaf about the axis of view.
fn flutter(wind: &Wind, rig: &Rig, time_s: f32, gust: f32, sway: Sway, axis: Vec3) -> Vec3 {
    let [x, y, z, phase] = sway.turns();
    let arm = Vec3::new(x, y, z) * rig.leaf_reach_m;
    let wave = pair(time_s, LEAF_HZ, LEAF_SHARE, 0.5 * phase);
    let liveliness = LEAF_STEADY + (1.0 - LEAF_STEADY) * wind.gustiness * (0.5 + 0.5 * gust);
    let turn = rig.leaf_angle * wind.part_of_reference() * liveliness * wave;
    let (sine, cosine) = libm::sincosf(turn);
    axis.cross(arm) * sine + (axis * axis.dot(arm) - arm) * (1.0 - cosine)
}

/// Rise and fall of the wind, -1..=1.
fn gust(time_s: f32) -> f32 {
    let waves = GUST_HZ.iter().zip(GUST_SHARE);
    waves.map(|(hz, share)| share * wave(hz * time_s)).sum()
}

/// Two waves of one phase, -1..=1.
fn pair(at: f32, ratio: [f32; 2], share: [f32; 2], phase: f32) -> f32 {
    share[0] * wave(at * ratio[0] + phase) + share[1] * wave(at * ratio[1] + phase)
}

/// A sine of an angle in turns.
fn wave(turns: f32) -> f32 {
    libm::sinf(TAU * (turns - turns.floor()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RIG: Rig = Rig {
        amplitude_m: [0.8, 0.5, 0.2],
        leaf_reach_m: 0.4,
        frequency_hz: [0.3, 0.55, 1.1],
        leaf_angle: 0.2,
    };

    fn any_sway() -> impl Strategy<Value = Sway> {
        (any::<[u8; 4]>(), any::<[i8; 4]>()).prop_map(|(wind, leaf)| Sway { wind, leaf })
    }

    #[test]
    fn bytes_stand_for_the_numbers_that_gltf_makes_of_them() {
        let sway = Sway {
            wind: [0, 51, 255, 128],
            leaf: [-128, -127, 0, 127],
        };
        assert_eq!(sway.weights(), [0.0, 0.2, 1.0, 128.0 / 255.0]);
        assert_eq!(sway.turns(), [-1.0, -1.0, 0.0, 1.0]);
    }

    #[test]
    fn the_mean_of_a_long_time_is_the_amplitude_downwind() {
        let wind = Wind {
            direction: Vec2::new(0.6, 0.8),
            speed_m_s: REFERENCE_SPEED_M_S,
            gustiness: 1.0,
        };
        let sway = Sway {
            wind: [255, 255, 255, 40],
            leaf: [0; 4],
        };
        let steps = 20_000_u16;
        let sum: Vec3 = (0..steps)
            .map(|i| displacement(&wind, &RIG, f32::from(i) * 0.11, 20.0, sway, Vec3::Z))
            .sum();
        let mean = sum / f32::from(steps);
        assert!(
            (mean.x - 0.6 * 1.5).abs() < 0.02 && (mean.z - 0.8 * 1.5).abs() < 0.02,
            "{mean}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

        #[test]
        fn nothing_moves_without_wind_nor_without_weight(
            sway in any_sway(), time in -50_i16..5000, height in 0_u8..40,
        ) {
            let (time, height) = (f32::from(time) * 0.37, f32::from(height));
            let calm = Wind { speed_m_s: 0.0, gustiness: 1.0, ..Wind::default() };
            prop_assert_eq!(displacement(&calm, &RIG, time, height, sway, Vec3::Z), Vec3::ZERO);
            let still = Sway { wind: [0, 0, 0, sway.wind[3]], leaf: [0, 0, 0, sway.leaf[3]] };
            let storm = Wind { speed_m_s: 25.0, gustiness: 1.0, ..Wind::default() };
            prop_assert_eq!(displacement(&storm, &RIG, time, height, still, Vec3::Z), Vec3::ZERO);
        }

        #[test]
        fn displacement_is_bounded_and_smooth_in_time(
            sway in any_sway(), time in 0_i16..5000, height in 0_u8..40, speed in 0_u8..60, gusty in 0_u8..=10,
        ) {
            let (time, height) = (f32::from(time) * 0.37, f32::from(height));
            let wind = Wind { speed_m_s: f32::from(speed), gustiness: f32::from(gusty) / 10.0, ..Wind::default() };
            let axis = Vec3::new(0.48, 0.6, 0.64);
            let at = |time| displacement(&wind, &RIG, time, height, sway, axis);
            prop_assert!(at(time).length() <= RIG.bound_m(&wind), "{}", at(time));
            // No wave is faster than 3 Hz: in a thousandth of a second it turns by a fiftieth.
            let step = at(time + 0.001).distance(at(time));
            prop_assert!(step <= 0.02 * RIG.bound_m(&wind), "{step}");
        }
    }
}

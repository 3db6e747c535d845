//! Keyed random draws.
//!
//! A draw is a function of (seed, level, variant, link, child, parameter) and of nothing else: no
//! draw depends on how many draws were made before it. So editing one parameter, or adding a level
//! of roots, never reshuffles the rest of a tree. Levels are keyed by *name*, not by position, for
//! the same reason. The generator is PCG XSL 128/64 (O'Neill 2014) by its name in `rand_pcg`,
//! because `rand`'s own default generators may change between versions.

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What a draw is for. The numbers are part of the determinism contract: never reuse or renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Parameter {
    /// Which spline a branch prototype takes.
    Spline = 1,
    /// Length of a branch prototype.
    Length = 2,
    /// Sideways wander of a control point (keyed by control point in the `link` place).
    Gnarl = 3,
    /// Rotation about the parent's axis.
    Around = 4,
    /// Angle from the parent's axis.
    Down = 5,
    /// Sideways tilt.
    Sideways = 6,
    /// Turn about the child's own axis.
    Spin = 7,
    /// Size of the child.
    Scale = 8,
    /// Thickness of the child's own tube.
    Thickness = 9,
    /// Position along the parent.
    Position = 10,
    /// Which prototype of the next level a link leads to.
    Prototype = 11,
    /// Lean of a stem of a multi-stemmed tree.
    Lean = 12,
    /// Place of a stem on the ground.
    Stem = 13,
    /// Phase of flutes and root flare.
    Phase = 14,
    /// Textures.
    Texture = 15,
    /// Phase of a limb in the wind.
    Sway = 16,
    /// Where a tree of a forest stands.
    Planted = 17,
    /// Colours of a tree of a forest.
    Tinted = 18,
}

/// One place in the tree at which random numbers are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    state: u64,
}

impl Key {
    /// The key of a tree.
    #[must_use]
    pub fn of_seed(seed: u64) -> Self {
        Self {
            state: mix(seed ^ 0x506c_6561_6368_2d31),
        }
    }

    /// The key of a level, by its name.
    #[must_use]
    pub fn level(self, name: &str) -> Self {
        // FNV-1a, 64 bit: portable and stable, unlike the standard library's hasher.
        let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325, |h: u64, b| {
            (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)
        });
        self.with(hash)
    }

    /// A key below this one, by a number (variant, link or child).
    #[must_use]
    pub fn with(self, part: u64) -> Self {
        Self {
            state: mix(self.state.rotate_left(23) ^ mix(part)),
        }
    }

    /// A generator for one parameter at this place.
    #[must_use]
    pub fn stream(self, parameter: Parameter) -> Pcg64Mcg {
        Pcg64Mcg::seed_from_u64(self.with(parameter as u64).state)
    }

    /// A draw in 0..1 for one parameter at this place.
    #[must_use]
    pub fn unit(self, parameter: Parameter) -> f32 {
        unit_from_bits(self.stream(parameter).next_u32())
    }

    /// A draw in -1..1 for one parameter at this place: what a script's `vary` is multiplied with.
    #[must_use]
    pub fn signed(self, parameter: Parameter) -> f32 {
        self.unit(parameter) * 2.0 - 1.0
    }

    /// The index that a draw picks from weights; `None` if no weight is positive.
    #[must_use]
    pub fn pick(self, parameter: Parameter, weights: &[f32]) -> Option<usize> {
        let total: f32 = weights.iter().sum();
        let mut left = self.unit(parameter) * total;
        let mut last = None;
        for (index, &weight) in weights.iter().enumerate() {
            if weight > 0.0 {
                last = Some(index);
                if left < weight {
                    return last;
                }
                left -= weight;
            }
        }
        last
    }
}

/// A value in 0..1 (24 bits, never 1) from random bits.
#[must_use]
#[expect(
    clippy::cast_precision_loss,
    reason = "24 bits fit a float's mantissa exactly"
)]
pub fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

/// The finaliser of `SplitMix64` (Steele, Lea, Flood 2014).
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_the_same_on_every_machine_and_in_every_version() {
        let key = Key::of_seed(7).level("limbs").with(0).with(3).with(1);
        let bits: Vec<u32> = [Parameter::Around, Parameter::Down, Parameter::Scale]
            .map(|parameter| key.unit(parameter).to_bits())
            .to_vec();
        assert_eq!(bits, [0x3f64_b74e, 0x3eb3_5766, 0x3dba_4260], "{bits:#x?}");
    }

    #[test]
    fn a_pick_follows_the_weights() {
        let key = Key::of_seed(1);
        let mut hits = [0_u32; 3];
        for i in 0..4000 {
            hits[key
                .with(i)
                .pick(Parameter::Spline, &[1.0, 0.0, 3.0])
                .unwrap()] += 1;
        }
        assert_eq!(hits[1], 0);
        assert!((900..1100).contains(&hits[0]), "{hits:?}");
        assert_eq!(key.pick(Parameter::Spline, &[0.0, 0.0]), None);
    }
}

//! Which baked shadows stand for a sun between the nine lights, and in what shares.

use crate::math::Vec3;

/// Maps and shares for a sun in the direction `to_sun` (any length): the vertical map first, then
/// two neighbours on the ring.
///
/// Shares are non-negative and sum to one. The vertical map's share is one minus the cotangent of
/// the elevation, because the length of a shadow is what grows with the cotangent; the ring's is
/// divided between the two neighbours by azimuth. So a sun at one of the nine gets that map alone,
/// and shares change by less than 2.6 for a radian of the sun's way, also over the zenith.
///
/// At 45 degrees and below the ring has all, and the shadow gets no longer. A renderer that wants
/// long evening shadows stretches the ground around the trunk base along the sun's azimuth by
/// the cotangent of the elevation before it looks the maps up. At and below the horizon
/// the answer depends on the azimuth alone, and the renderer should fade shadows out. With no
/// azimuth (straight up, straight down, zero) or a coordinate that is not finite, the vertical map
/// has all.
#[must_use]
pub fn weights(to_sun: Vec3) -> [(usize, f32); 3] {
    // In f64, no finite f32 is too large or too small to square.
    let [x, y, z] = to_sun.to_array().map(f64::from);
    let level = (x * x + z * z).sqrt();
    if !to_sun.is_finite() || level == 0.0 {
        return [(0, 1.0), (1, 0.0), (2, 0.0)];
    }
    let ring = if y > level { level / y } else { 1.0 };
    let (first, along) = ring_place(x, z);
    let second = (first + 1) % 8;
    [
        (0, narrow(1.0 - ring)),
        (1 + first, narrow(ring * (1.0 - along))),
        (1 + second, narrow(ring * along)),
    ]
}

/// The ring's light at or before an azimuth, 0..8, and the part of the way to the next, 0..1.
fn ring_place(x: f64, z: f64) -> (usize, f64) {
    let (across, along) = (x.abs(), z.abs());
    // One octant is measured and the others mirror it: exact at every multiple of 45 degrees.
    let octant = libm::atan(across.min(along) / across.max(along)) / core::f64::consts::FRAC_PI_4;
    let quadrant = if along > across { 2.0 - octant } else { octant };
    let steps = match (x >= 0.0, z >= 0.0) {
        (true, true) => quadrant,
        (false, true) => 4.0 - quadrant,
        (false, false) => 4.0 + quadrant,
        (true, false) => 8.0 - quadrant,
    };
    let first = steps.floor();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0..=8 by construction"
    )]
    (first as usize % 8, steps - first)
}

/// To the precision in which shares are told.
#[expect(clippy::cast_possible_truncation, reason = "shares are 0..=1")]
fn narrow(share: f64) -> f32 {
    share as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{PI, TAU};
    use crate::shadow::{COUNT, direction};
    use proptest::prelude::*;

    fn sun(azimuth: f32, elevation: f32) -> Vec3 {
        let (sin, cos) = libm::sincosf(elevation);
        Vec3::new(cos * libm::cosf(azimuth), sin, cos * libm::sinf(azimuth))
    }

    fn per_map(to_sun: Vec3) -> [f32; COUNT] {
        let mut shares = [0.0; COUNT];
        for (map, share) in weights(to_sun) {
            shares[map] += share;
        }
        shares
    }

    fn largest_change(a: Vec3, b: Vec3) -> f32 {
        let (a, b) = (per_map(a), per_map(b));
        (0..COUNT).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn each_of_the_nine_gets_its_own_map_alone() {
        for index in 0..COUNT {
            for scale in [1.0, 1e-30, 3e30] {
                let mut expected = [0.0; COUNT];
                expected[index] = 1.0;
                let shares = per_map(direction(index) * scale);
                for (share, wanted) in shares.iter().zip(expected) {
                    assert!((share - wanted).abs() < 1e-6, "{index}: {shares:?}");
                }
                if scale == 1.0 {
                    assert_eq!(shares, expected);
                }
            }
        }
    }

    #[test]
    fn suns_without_an_azimuth_or_a_number_get_the_vertical_map() {
        let broken = [
            Vec3::ZERO,
            Vec3::Y * 1e-40,
            -Vec3::Y,
            Vec3::NAN,
            Vec3::new(1.0, f32::NAN, 0.0),
            Vec3::new(f32::INFINITY, 1.0, 0.0),
        ];
        for to_sun in broken {
            assert_eq!(per_map(to_sun)[0], 1.0, "{to_sun}");
        }
    }

    #[test]
    fn halfway_round_and_halfway_up_share_evenly() {
        let shares = per_map(sun(PI / 8.0, libm::atanf(2.0)));
        for (map, wanted) in [(0, 0.5), (1, 0.25), (2, 0.25)] {
            assert!((shares[map] - wanted).abs() < 1e-5, "{shares:?}");
        }
    }

    proptest! {
        #[test]
        fn shares_are_non_negative_and_sum_to_one(x in -1.0_f32..1.0, y in -1.0_f32..1.0, z in -1.0_f32..1.0) {
            let three = weights(Vec3::new(x, y, z));
            prop_assert!(three.iter().all(|&(map, share)| map < COUNT && share >= 0.0));
            prop_assert_eq!(three[0].0, 0);
            prop_assert!(three[1].0 >= 1 && three[2].0 >= 1 && three[1].0 != three[2].0);
            let total: f32 = three.iter().map(|&(_, share)| share).sum();
            prop_assert!((total - 1.0).abs() < 1e-6);
        }

        #[test]
        fn the_vertical_map_is_unused_below_45_degrees(azimuth in 0.0..TAU, elevation in -0.5_f32..0.785) {
            prop_assert_eq!(per_map(sun(azimuth, elevation))[0], 0.0);
        }

        #[test]
        fn a_small_turn_of_the_sun_changes_shares_little(
            azimuth in 0.0..TAU, elevation in 0.0..PI / 2.0, heading in 0.0..TAU, turn in 1e-5_f32..0.02,
        ) {
            let here = sun(azimuth, elevation);
            let (a, b) = here.any_orthonormal_pair();
            let there = here + (a * libm::cosf(heading) + b * libm::sinf(heading)) * turn;
            // At 45 degrees a share changes by 2 a radian of height and by 4 / (pi sin 45) a radian around.
            prop_assert!(largest_change(here, there) < 2.75 * turn + 1e-5);
        }

        #[test]
        fn nothing_jumps_at_the_zenith_nor_where_the_ring_closes(step in 0_u8..8, elevation in 0.01_f32..1.57, tilt in 1e-6_f32..1e-3) {
            let azimuth = f32::from(step) * PI / 4.0;
            let (before, after) = (sun(azimuth - tilt, elevation), sun(azimuth + tilt, elevation));
            prop_assert!(largest_change(before, after) < 6.0 * tilt + 1e-5);
            let (here, across) = (sun(azimuth, PI / 2.0 - tilt), sun(azimuth + 2.0, PI / 2.0 - tilt));
            prop_assert!(largest_change(here, across) < 3.0 * tilt + 1e-5);
            prop_assert!(largest_change(here, Vec3::Y) < 3.0 * tilt + 1e-5);
        }
    }
}

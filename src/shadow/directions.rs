//! The nine lights, and the sample directions around each.

use crate::math::{PI, TAU, Vec3};
use crate::shadow::Settings;

/// Number of baked light directions.
pub const COUNT: usize = 9;

/// Unit vector from the ground toward baked light `index`.
///
/// 0 is straight up. 1..=8 stand 45 degrees above the horizon, at azimuth `(index - 1) * 45`
/// degrees; azimuth 0 is +X and grows toward +Z. An index of [`COUNT`] or more wraps to the ring.
#[must_use]
pub fn direction(index: usize) -> Vec3 {
    const HALF: f32 = core::f32::consts::FRAC_1_SQRT_2;
    let Some(step) = index.checked_sub(1) else {
        return Vec3::Y;
    };
    // Written out, so that opposite lights are exact mirror images.
    let (x, z) = match step % 8 {
        0 => (HALF, 0.0),
        1 => (0.5, 0.5),
        2 => (0.0, HALF),
        3 => (-0.5, 0.5),
        4 => (-HALF, 0.0),
        5 => (-0.5, -0.5),
        6 => (0.0, -HALF),
        _ => (0.5, -0.5),
    };
    Vec3::new(x, HALF, z)
}

/// One hard shadow's light and its share of the soft shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Unit vector toward the light.
    pub to_light: Vec3,
    /// Share, 0..=1; those of one light sum to one.
    pub weight: f32,
}

/// The sample directions of the soft shadow of a light in the unit direction `to_light`: the
/// centre, then each band from the innermost out.
///
/// Band `k` of `K` stands `spread * k / K` from the centre, and each of its samples weighs
/// `1 - k / (K + 1)` before all weights are divided by their sum: a cone that would reach zero one
/// band beyond the last. Each band is turned by the golden ratio's part of a step against the one
/// before, so that samples of neighbouring bands do not line up in rays.
#[must_use]
pub fn samples(to_light: Vec3, settings: &Settings) -> Vec<Sample> {
    const GOLDEN: f32 = 0.618_034;
    let Settings {
        bands,
        samples,
        spread_deg,
        ..
    } = settings.clamped();
    let spread = spread_deg * PI / 180.0;
    let (side, up) = to_light.any_orthonormal_pair();
    let mut all = vec![Sample {
        to_light,
        weight: 1.0,
    }];
    for band in 1..=bands {
        let angle = spread * small(band) / small(bands);
        let (sin, cos) = libm::sincosf(angle);
        for step in 0..samples {
            let turn = (small(step) + (small(band) * GOLDEN).fract()) / small(samples);
            let (around_sin, around_cos) = libm::sincosf(turn * TAU);
            let around = side * around_cos + up * around_sin;
            all.push(Sample {
                to_light: (to_light * cos + around * sin).normalize_or(to_light),
                weight: 1.0 - small(band) / small(bands + 1),
            });
        }
    }
    let total: f32 = all.iter().map(|sample| sample.weight).sum();
    for sample in &mut all {
        sample.weight /= total;
    }
    all
}

/// Angle from one band to the next, radians; 0 without bands.
pub(super) fn band_step(settings: &Settings) -> f32 {
    let settings = settings.clamped();
    settings.spread_deg * PI / 180.0 / small(settings.bands.max(1)) * small(settings.bands.min(1))
}

/// A count of bands or samples as a number; exact.
#[expect(
    clippy::cast_precision_loss,
    reason = "clamped settings are at most 256"
)]
fn small(count: u32) -> f32 {
    count as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ring_stands_at_45_degrees_in_steps_of_45_degrees() {
        assert_eq!(direction(0), Vec3::Y);
        for index in 1..COUNT {
            let light = direction(index);
            let azimuth = (index - 1) as f32 * PI / 4.0;
            let half = 0.5_f32.sqrt();
            let expected = Vec3::new(half * libm::cosf(azimuth), half, half * libm::sinf(azimuth));
            assert!((light - expected).length() < 1e-6, "{index}: {light}");
        }
    }

    #[test]
    fn sample_weights_sum_to_one_and_fall_outward() {
        for (bands, samples_a_band) in [(0, 8), (1, 1), (3, 8), (64, 256)] {
            let settings = Settings {
                bands,
                samples: samples_a_band,
                ..Settings::default()
            };
            let all = samples(direction(3), &settings);
            assert_eq!(all.len(), 1 + (bands * samples_a_band) as usize);
            let total: f64 = all.iter().map(|s| f64::from(s.weight)).sum();
            assert!((total - 1.0).abs() < 1e-4, "{total}");
            assert!(all.windows(2).all(|pair| pair[1].weight <= pair[0].weight));
            assert!(all.iter().all(|s| s.weight > 0.0));
        }
    }

    #[test]
    fn bands_are_circles_around_the_light_and_do_not_line_up() {
        let settings = Settings::default();
        let all = samples(direction(6), &settings);
        let angle = |s: &Sample| libm::acosf(s.to_light.dot(direction(6)).min(1.0)) * 180.0 / PI;
        for (index, sample) in all.iter().enumerate().skip(1) {
            let band = 1 + (index - 1) / 8;
            assert!((angle(sample) - 2.0 * band as f32).abs() < 0.05);
        }
        for (inner, outer) in all[1..9]
            .iter()
            .flat_map(|a| all[9..17].iter().map(move |b| (a, b)))
        {
            let from_centre = |s: &Sample| s.to_light.reject_from_normalized(direction(6));
            let turn = from_centre(inner).angle_between(from_centre(outer)) * 180.0 / PI;
            assert!(turn > 5.0, "{turn} degrees");
        }
    }
}

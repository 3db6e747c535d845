//! How much a mean over views hangs on which views were taken: the bootstrap.
//!
//! Efron, *Bootstrap Methods: Another Look at the Jackknife*, 1979; intervals are percentiles of the resampled
//! means.
//!
//! Changes versus the paper: side and aerial views are drawn apart, as many of each as there are, since their
//! numbers are no chance. Held-out views are spread evenly and not drawn at random, so an interval is rather too
//! wide than too narrow. All figures share the same draws, so that intervals of differences are paired.

use crate::rng::{Key, Parameter};
use rand::Rng;

/// Resampled sets of views.
const ROUNDS: usize = 1000;

/// Part of the means that is left out at each end.
const TAIL: f32 = 0.025;

/// Sets of views, drawn with replacement.
pub(super) struct Resamples {
    /// Views in a set.
    views: usize,
    /// Indices of views, set after set.
    picks: Vec<usize>,
}

impl Resamples {
    /// Sets of `side` views from the first `side` ones, and of `aerial` views from those after them.
    pub(super) fn new(side: usize, aerial: usize) -> Self {
        let mut stream = Key::of_seed(0)
            .level("resampled views")
            .stream(Parameter::Position);
        let mut below = |count: usize| {
            let count = u64::try_from(count).unwrap_or(u64::MAX);
            let place = (u64::from(stream.next_u32()) * count) >> 32;
            usize::try_from(place).unwrap_or(0)
        };
        let mut picks = Vec::with_capacity(ROUNDS * (side + aerial));
        for _ in 0..ROUNDS {
            picks.extend((0..side).map(|_| below(side)));
            picks.extend((0..aerial).map(|_| side + below(aerial)));
        }
        Self {
            views: side + aerial,
            picks,
        }
    }

    /// 95 % interval of the mean of one value for each view; not numbers if one is missing.
    pub(super) fn interval(&self, values: &[f32]) -> [f32; 2] {
        let is_whole = values.len() == self.views && values.iter().all(|v| v.is_finite());
        if self.views == 0 || !is_whole {
            return [f32::NAN; 2];
        }
        let sets = self.picks.chunks_exact(self.views);
        let mut means: Vec<f32> = sets
            .map(|set| super::run::mean(set.iter().map(|&view| values[view])))
            .collect();
        means.sort_by(f32::total_cmp);
        let last = crate::math::float(u32::try_from(ROUNDS - 1).unwrap_or(0));
        let at = |part: f32| means[crate::math::round_to_u32(part * last) as usize];
        [at(TAIL), at(1.0 - TAIL)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_about_two_errors_of_the_mean_to_each_side() {
        // 64 values of 0 and 1 in equal parts: the error of their mean is 0.5 / 8.
        let values: Vec<f32> = (0..64_u8).map(|i| f32::from(i % 2)).collect();
        let [low, high] = Resamples::new(64, 0).interval(&values);
        assert!((low - (0.5 - 0.1225)).abs() < 0.02, "{low}");
        assert!((high - (0.5 + 0.1225)).abs() < 0.02, "{high}");
    }

    #[test]
    fn side_and_aerial_views_keep_their_numbers() {
        // All spread lies between the two kinds, and their numbers are fixed.
        let mut values = vec![0.0; 20];
        values.extend([1.0; 10]);
        let [low, high] = Resamples::new(20, 10).interval(&values);
        assert!((low - high).abs() < 1e-6 && (low - 1.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_missing_has_no_interval() {
        let sets = Resamples::new(2, 1);
        assert_eq!(sets.interval(&[0.5; 3]), [0.5; 2]);
        assert!(sets.interval(&[0.5; 2])[0].is_nan());
        assert!(sets.interval(&[0.5, f32::NAN, 0.5])[1].is_nan());
        assert!(Resamples::new(0, 0).interval(&[])[0].is_nan());
    }
}

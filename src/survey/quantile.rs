//! Medians and tenths of figures with weights.

/// Median, tenth and ninetieth percentile.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
    /// A tenth of the figures are below.
    pub p10: f32,
    /// Half of the figures are below.
    pub median: f32,
    /// A tenth of the figures are above.
    pub p90: f32,
}

impl Spread {
    /// Of figures that count alike; `None` if there are none. Between two figures it is blended.
    #[must_use]
    pub fn of(figures: &[f32]) -> Option<Self> {
        let mut sorted = figures.to_vec();
        sorted.sort_by(f32::total_cmp);
        let at = |part: f32| quantile(&sorted, part);
        Some(Self {
            p10: at(0.1)?,
            median: at(0.5)?,
            p90: at(0.9)?,
        })
    }

    /// Of (figure, how often it occurs); `None` if there are none. No blending: there are many.
    #[must_use]
    pub fn weighted(figures: &[(f32, u64)]) -> Option<Self> {
        let mut sorted: Vec<(f32, u64)> = figures.iter().copied().filter(|f| f.1 > 0).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: u128 = sorted.iter().map(|f| u128::from(f.1)).sum();
        let at = |tenths: u128| {
            let mut passed = 0;
            sorted
                .iter()
                .find(|f| {
                    passed += u128::from(f.1);
                    passed * 10 >= total * tenths
                })
                .map(|f| f.0)
        };
        Some(Self {
            p10: at(1)?,
            median: at(5)?,
            p90: at(9)?,
        })
    }
}

/// The figure below which `part` of a sorted list lies.
fn quantile(sorted: &[f32], part: f32) -> Option<f32> {
    let last = u32::try_from(sorted.len()).ok()?.checked_sub(1)?;
    let place = part * crate::math::float(last);
    let below = crate::math::floor_to_u32(place).min(last);
    let low = *sorted.get(below as usize)?;
    let high = sorted.get(below as usize + 1).copied().unwrap_or(low);
    Some(low + (high - low) * (place - crate::math::float(below)))
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn a_spread_of_few_figures_is_blended_and_of_none_is_none() {
        let spread = Spread::of(&[4.0, 1.0, 3.0, 2.0, 5.0]).expect("figures");
        assert_eq!(spread.median, 3.0);
        assert!((spread.p10 - 1.4).abs() < 1e-6 && (spread.p90 - 4.6).abs() < 1e-6);
        assert_eq!(Spread::of(&[7.0]).map(|s| (s.p10, s.p90)), Some((7.0, 7.0)));
        assert_eq!(Spread::of(&[]), None);
    }

    #[test]
    fn weights_count_as_that_many_figures() {
        let spread = Spread::weighted(&[(9.0, 1), (1.0, 8), (5.0, 1), (2.0, 0)]).expect("figures");
        assert_eq!((spread.p10, spread.median, spread.p90), (1.0, 1.0, 5.0));
        assert_eq!(Spread::weighted(&[(1.0, 0)]), None);
    }
}

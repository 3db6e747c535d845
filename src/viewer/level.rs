//! Which LOD a tree is drawn with: by its size in the picture, or by hand.

/// How far a size must be beyond the one of a switch before the LOD changes, as a part of it: a tree that
/// hovers about a switch does not flicker.
const SLACK: f32 = 0.08;

/// How the LOD is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// By the part of the picture's height that a tree fills.
    #[default]
    ByDistance,
    /// One for all.
    Fixed(usize),
}

/// The LOD for a tree that fills a part of the picture's height, given the parts up to which each LOD may be
/// shown (falling), and the one that is shown now.
#[must_use]
pub fn by_size(
    limits: impl Fn(usize) -> f32,
    count: usize,
    part: f32,
    now: Option<usize>,
) -> usize {
    let last = count.saturating_sub(1);
    let coarsest = |part: f32| {
        (1..=last)
            .rev()
            .find(|&lod| limits(lod) >= part)
            .unwrap_or(0)
    };
    let Some(now) = now.filter(|&now| now <= last) else {
        return coarsest(part);
    };
    // Finer only if the tree is clearly larger than this LOD allows; coarser only if clearly smaller than the
    // coarser one does.
    let fine = coarsest(part / (1.0 + SLACK));
    let coarse = coarsest(part * (1.0 + SLACK));
    now.clamp(coarse.min(fine), fine.max(coarse))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: [f32; 4] = [2.0, 0.5, 0.2, 0.05];

    fn lod(part: f32, now: Option<usize>) -> usize {
        by_size(|lod| LIMITS[lod], LIMITS.len(), part, now)
    }

    #[test]
    fn a_tree_gets_the_coarsest_lod_that_its_size_allows() {
        for (part, expected) in [
            (3.0, 0),
            (0.9, 0),
            (0.5, 1),
            (0.3, 1),
            (0.2, 2),
            (0.06, 2),
            (0.01, 3),
        ] {
            assert_eq!(lod(part, None), expected, "{part}");
        }
    }

    #[test]
    fn a_tree_at_a_switch_keeps_its_lod_and_one_beyond_it_does_not() {
        for now in [0, 1] {
            for part in [0.49, 0.5, 0.51, 0.48, 0.52] {
                assert_eq!(lod(part, Some(now)), now, "{part}");
            }
        }
        assert_eq!(lod(0.45, Some(0)), 1);
        assert_eq!(lod(0.56, Some(1)), 0);
        // Far beyond, it skips those between.
        assert_eq!(lod(0.01, Some(0)), 3);
        assert_eq!(lod(0.9, Some(3)), 0);
    }

    #[test]
    fn going_away_and_back_changes_each_lod_once() {
        let mut now = None;
        let mut changes = 0;
        let steps = (0..400).map(|i| 1.0 - i as f32 / 405.0);
        for part in steps.clone().chain(steps.rev()) {
            let next = lod(part, now);
            changes += u32::from(now.is_some_and(|n| n != next));
            now = Some(next);
        }
        assert_eq!(changes, 6);
    }

    #[test]
    fn a_lod_that_is_gone_is_forgotten() {
        assert_eq!(lod(0.3, Some(9)), 1);
        assert_eq!(by_size(|_| 1.0, 1, 0.3, None), 0);
        assert_eq!(by_size(|_| 1.0, 0, 0.3, Some(0)), 0);
    }
}

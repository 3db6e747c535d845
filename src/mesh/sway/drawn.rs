//! How a branch bends as it is drawn: straight between its rings.

use crate::tree::flex::bend;

/// A branch's bend, straight between the places at which it has vertices. What grows on the branch follows
/// this line and not the true curve, so that no joint opens however coarse the tube is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Drawn {
    /// Places, rising, and the bend there; empty where the branch is not drawn.
    knots: Vec<[f32; 2]>,
}

/// Places along a branch that are nearer than this are one.
const SAME: f32 = 1e-4;

/// Places in each stretch between knots at which line and curve are compared.
const SAMPLES: u8 = 4;

impl Drawn {
    /// The line with knots at the places `at` (any order) and at 0 that is nearest to the true curve, by least
    /// squares: coarse tubes then carry what grows on them as far, in the mean, as fine ones. It never
    /// falls.
    pub(super) fn new(at: impl Iterator<Item = f32>) -> Self {
        let mut places: Vec<f32> = at.chain([0.0]).collect();
        places.sort_by(f32::total_cmp);
        places.dedup_by(|b, a| *b - *a < SAME);
        let mut rows = vec![[0.0_f32; 3]; places.len()];
        for index in 1..places.len() {
            let (start, length) = (places[index - 1], places[index] - places[index - 1]);
            for sample in 0..SAMPLES {
                let right = (f32::from(sample) + 0.5) / f32::from(SAMPLES);
                let (left, value) = (1.0 - right, bend(start + length * right));
                // Diagonal, what is right of it, right-hand side.
                rows[index - 1][0] += length * left * left;
                rows[index - 1][1] += length * left * right;
                rows[index - 1][2] += length * left * value;
                rows[index][0] += length * right * right;
                rows[index][2] += length * right * value;
            }
        }
        // The base stands still.
        rows[0] = [1.0, 0.0, 0.0];
        Self {
            knots: places
                .iter()
                .zip(solved(rows))
                .map(|(&t, b)| [t, b])
                .collect(),
        }
    }

    /// The bend at a place.
    pub(super) fn at(&self, t: f32) -> f32 {
        let after = self.knots.partition_point(|k| k[0] <= t);
        match (after.checked_sub(1), self.knots.get(after)) {
            (None, _) => bend(t),
            (Some(last), None) => self.knots[last][1],
            (Some(before), Some(&[t1, b1])) => {
                let [t0, b0] = self.knots[before];
                b0 + (b1 - b0) * (t - t0) / (t1 - t0)
            }
        }
    }
}

/// Solves symmetric tridiagonal rows whose first unknown is fixed at 0; solutions are made
/// not to fall, and to stay within 0..=1.
fn solved(mut rows: Vec<[f32; 3]>) -> Vec<f32> {
    for index in 1..rows.len() {
        let [diagonal, beside, value] = rows[index - 1];
        let factor = beside / diagonal;
        rows[index][0] -= factor * beside;
        rows[index][2] -= factor * value;
    }
    let mut solution = vec![0.0; rows.len()];
    for index in (1..rows.len()).rev() {
        let next = solution.get(index + 1).copied().unwrap_or(0.0);
        solution[index] = (rows[index][2] - rows[index][1] * next) / rows[index][0];
    }
    let mut before = 0.0_f32;
    for value in &mut solution {
        before = before.max(*value).min(1.0);
        *value = before;
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fine_line_is_the_curve_and_a_coarse_one_is_right_in_the_mean() {
        let fine = Drawn::new((0..=50_u8).map(|i| f32::from(i) / 50.0));
        let coarse = Drawn::new([1.0, 0.0, 1.0].into_iter());
        let (mut curve, mut line) = (0.0, 0.0);
        for i in 0..=100_u8 {
            let t = f32::from(i) / 100.0;
            assert!((fine.at(t) - bend(t)).abs() < 1e-3, "{t}");
            (curve, line) = (curve + bend(t), line + coarse.at(t));
        }
        assert_eq!(coarse.at(0.0), 0.0);
        assert!((line / curve - 1.0).abs() < 0.1, "{line} for {curve}");
    }

    #[test]
    fn a_branch_that_is_not_drawn_bends_as_it_would() {
        assert_eq!(Drawn::default().at(0.7), bend(0.7));
    }

    #[test]
    fn places_close_together_and_bends_that_never_fall_do_no_harm() {
        let line = Drawn::new([0.3, 0.300_01, 0.02, 0.9, 0.31].into_iter());
        let bends: Vec<f32> = line.knots.iter().map(|k| k[1]).collect();
        assert!(
            bends.is_sorted() && bends.iter().all(|b| (0.0..=1.0).contains(b)),
            "{bends:?}"
        );
        assert_eq!(
            line.at(1.0),
            line.at(0.9),
            "past its end it goes on as it ends"
        );
    }
}

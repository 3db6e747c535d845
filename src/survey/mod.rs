//! Trees measured as a forester would measure them.
//!
//! Tree -> [`Measures`], pure. [`survey()`] grows a species from many seeds and measures each tree;
//! [`lines`] sets the figures beside what is known of real trees ([`reference`](mod@reference)) and says of
//! each whether it lies within. Where nothing is known, it says that.
//!
//! Definitions, as in the field:
//! - *DBH*: diameter over bark 1.3 m above the ground; of several stems the root of the sum of squares.
//! - *Crown width*: mean of the diameters between parallel lines, over 18 directions: what two diameters at
//!   right angles are on average. The crown's projection is the disc of that diameter.
//! - *Crown base*: the height below which 2 % of the leaf area hang. *Clear bole*: the height, as a part of
//!   the tree's, at which the lowest limbs leave their stem that together carry 2 % of the leaf area.
//! - *Leaf area*: one side of all blades, from the part of each card that its picture covers. Blades that hide
//!   one another on a card count once, so it errs low. *Leaf-area index*: leaf area over the crown's disc.
//! - *Orders*: Gravelius's, counted outward from the stem (0), for insertion angles; Horton and Strahler's,
//!   counted inward from the tips (1), for the bifurcation ratio. Leaves and drawn twigs are no branches.
//! - *Insertion angle*: between the parent's axis where a branch leaves it and the chord of the branch's first
//!   tenth.
//! - *Fork area ratio*: cross-sections after a fork over that before it (Leonardo's rule says 1), see
//!   [`forks`].

mod foliage;
pub mod forks;
pub mod quantile;
pub mod reference;
mod report;
pub mod strahler;
mod walk;

pub use foliage::{Foliage, foliage};
pub use quantile::Spread;
pub use report::{Line, Range, Verdict, lines};

use crate::report::{Cancelled, Progress};
use crate::species::schema::Species;
use crate::tree::{GrowError, Limits, Tree, grow};
use rayon::prelude::*;

/// What was measured of one tree. Lengths are metres unless the name says otherwise.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Measures {
    /// Seed it grew from.
    pub seed: u64,
    /// Ground to the highest leaf or twig.
    pub height_m: f32,
    /// Diameter at 1.3 m over bark, centimetres; `None` if nothing stands there.
    pub dbh_cm: Option<f32>,
    /// Stems that were measured for it.
    pub stems: u32,
    /// Mean diameter of the foliage, seen from above; of the branches, without leaves.
    pub crown_width_m: Option<f32>,
    /// Height below which 2 % of the leaf area hang.
    pub crown_base_m: Option<f32>,
    /// Height of the lowest limbs on their stem over the tree's height, 0..=1.
    pub clear_bole: Option<f32>,
    /// Branches on the stems whose leaf area is a quarter of the largest's or more.
    pub leafy_limbs: u32,
    /// Blades drawn on all leaf cards.
    pub leaves: u64,
    /// One side of all blades, square metres.
    pub leaf_area_m2: f32,
    /// Leaf area over the crown's disc.
    pub leaf_area_index: Option<f32>,
    /// Branches of each Strahler order, the tips first.
    pub strahler: Vec<u64>,
    /// How many times fewer branches there are of each next order; `None` below two orders.
    pub bifurcation_ratio: Option<f32>,
    /// How straight the logarithm of their numbers falls (R^2); `None` below three orders.
    pub bifurcation_r2: Option<f32>,
    /// Cross-sections after each fork over that before it.
    pub fork_area_ratio: Option<Spread>,
    /// Part of the forks whose ratio is 0.8 to 1.7.
    pub forks_in_range: Option<f32>,
    /// Insertion angles, degrees, of orders 1, 2 and on.
    pub insertion_deg: Vec<Spread>,
}

/// Measures one tree; `foliage` is what stands on the cards of each of its species' leaf kinds.
#[must_use]
pub fn measure(tree: &Tree, foliage: &[Foliage]) -> Measures {
    let below = walk::Below::of(tree, foliage);
    let walked = walk::walk(tree, &below, foliage);
    let strahler = strahler::counts(tree);
    let fit = strahler::bifurcation(&strahler);
    let forks = forks::ratios(tree);
    let crown_width_m = walked.crown_width();
    let leaf_area_m2 = below.area();
    let disc = crown_width_m.map(|d| core::f32::consts::FRAC_PI_4 * d * d);
    Measures {
        seed: tree.seed,
        height_m: walked.height,
        dbh_cm: walked.dbh().map(|d| d * 100.0),
        stems: walked.stems(),
        crown_width_m,
        crown_base_m: walked.crown_base(),
        clear_bole: walked.clear_bole(),
        leafy_limbs: walked.leafy_limbs(),
        leaves: below.blades(),
        leaf_area_m2,
        leaf_area_index: disc
            .filter(|&disc| disc > 0.0 && leaf_area_m2 > 0.0)
            .map(|disc| leaf_area_m2 / disc),
        bifurcation_ratio: fit.map(|f| f.ratio),
        bifurcation_r2: fit.and_then(|f| f.r2),
        strahler,
        fork_area_ratio: Spread::weighted(&forks),
        forks_in_range: forks::part_within(&forks, 0.8, 1.7),
        insertion_deg: walked.insertion(),
    }
}

/// Why a survey has no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurveyError {
    /// A tree cannot be grown.
    #[error("seed {seed}: {error}")]
    Grow {
        /// Its seed.
        seed: u64,
        /// Why.
        error: GrowError,
    },
    /// Given up through [`Progress::cancelled`].
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Grows a tree from each seed and measures it, on all threads. The result is in the order of the seeds and
/// does not depend on the threads.
///
/// # Errors
/// If a tree would pass one of `limits` or the species is not whole, or if `progress` says to stop.
pub fn survey(
    species: &Species,
    foliage: &[Foliage],
    seeds: &[u64],
    limits: &Limits,
    progress: &dyn Progress,
) -> Result<Vec<Measures>, SurveyError> {
    progress.begin("measure trees", seeds.len() as u64);
    seeds
        .par_iter()
        .map(|&seed| {
            if progress.cancelled() {
                return Err(Cancelled.into());
            }
            let tree =
                grow(species, seed, limits).map_err(|error| SurveyError::Grow { seed, error })?;
            let measures = measure(&tree, foliage);
            progress.step();
            Ok(measures)
        })
        .collect()
}

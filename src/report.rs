//! Warnings, progress and cancelling: what every stage may tell beside its result.

use std::fmt;

/// Something that the user should know though the work succeeded.
///
/// Warnings are data: they travel beside the result, and the command line, the studio and the
/// pack's manifest show the same ones.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// No form of the tree is small enough for the budget; the smallest was used.
    BudgetBelowSmallest {
        /// Triangles asked for.
        budget: u64,
        /// Triangles of the smallest form.
        smallest: u64,
    },
    /// The chain has no state left that differs from the one before; the budget got no LOD.
    BudgetWithoutLod {
        /// Triangles asked for.
        budget: u64,
    },
    /// The LOD before is within the budget already; the budget got no LOD.
    BudgetMet {
        /// Triangles asked for.
        budget: u64,
        /// Triangles of the LOD before.
        triangles: u64,
    },
    /// A capture has fewer texels than it deserves, because the atlas is small.
    AtlasCrowded {
        /// Atlas edge, texels.
        size: u32,
        /// Texels along the longer edge of the largest capture.
        largest: u32,
    },
    /// The tree is too large to be shown leaf by leaf; captures were built from captures.
    CapturesFromCaptures {
        /// Level whose captures were used.
        level: String,
    },
    /// Shadows come from a simplified form of the tree.
    ShadowsSimplified {
        /// Triangles of the tree.
        triangles: u64,
        /// Triangles of the form that cast the shadows.
        used: u64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BudgetBelowSmallest { budget, smallest } => write!(
                f,
                "budget of {budget} triangles: the smallest form has {smallest}; that form was used"
            ),
            Self::BudgetWithoutLod { budget } => write!(
                f,
                "budget of {budget} triangles: no form is left that is simpler than the LOD before it; \
                 no LOD was made. Remove the budget, or space the budgets further apart"
            ),
            Self::BudgetMet { budget, triangles } => write!(
                f,
                "budget of {budget} triangles: the LOD before it has {triangles} and serves for this budget too; \
                 no other was made"
            ),
            Self::AtlasCrowded { size, largest } => write!(
                f,
                "the atlas of {size} x {size} texels leaves only {largest} texels for the largest \
                 capture; raise --texture-size"
            ),
            Self::CapturesFromCaptures { level } => write!(
                f,
                "captures above level `{level}` were built from the captures of `{level}`, because \
                 drawing every leaf would take too long"
            ),
            Self::ShadowsSimplified { triangles, used } => write!(
                f,
                "shadows were cast by a form of {used} triangles instead of the full {triangles}"
            ),
        }
    }
}

/// Receives progress; implemented by whoever runs the pipeline. Called from several threads.
pub trait Progress: Sync {
    /// A stage begins, with the number of steps it will take.
    fn begin(&self, stage: &'static str, steps: u64);
    /// One step of the current stage is done.
    fn step(&self);
    /// True if the work should be given up; stages ask between steps.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Tells nobody, and never cancels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Progress for Quiet {
    fn begin(&self, _stage: &'static str, _steps: u64) {}
    fn step(&self) {}
}

/// The work was cancelled through [`Progress::cancelled`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A machine that a stage leans on, a graphics adapter say, failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct MachineFault {
    /// What went wrong, and what to do.
    pub reason: String,
    /// True if another try may help.
    pub passing: bool,
}

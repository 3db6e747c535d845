//! The seam between what casts shadows in which light and what draws them.
//!
//! Where the maps lie, where samples' lights stand and what each weighs is decided once, in [`super::bake()`]; a
//! backend sums hard shadows. [`super::Cpu`] is the yardstick: its sums are the same on every machine. Another one
//! may differ from it at the edges of triangles; `tests/gpu_bake.rs` holds the adapter's to a tolerance.

use super::coverage::Coverage;
use super::ground::{Casters, Projection, Stray};
use crate::report::{Cancelled, MachineFault, Progress};

/// Sums hard shadows.
pub trait Backend: Sync {
    /// For each light and texel, row by row: the sum of the shares of those samples in whose shadow it lies.
    ///
    /// Tells `progress` a step for each sample, and asks it whether to go on.
    ///
    /// # Errors
    /// [`BakeError::Cancelled`]; [`BakeError::Machine`] if what draws failed.
    fn sums(&self, work: &Work<'_>, progress: &dyn Progress) -> Result<Vec<Vec<u16>>, BakeError>;

    /// What drew, in words, if its sums are equal to those of [`super::Cpu`] only within a tolerance.
    fn inexact(&self) -> Option<String> {
        None
    }
}

/// All shadows of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// What casts them.
    pub casters: &'a Casters,
    /// The foliage's outlines.
    pub coverage: &'a Coverage,
    /// The lights.
    pub lights: &'a [Light],
    /// Texels along the edge of every map.
    pub size: u32,
}

/// One light: hard shadows from directions around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The samples' projections. Bark casts by these alone; each piece of foliage strays from them.
    pub samples: Vec<Projection>,
    /// Integer shares of the samples; they sum to 255 * 256.
    pub shares: Vec<u16>,
    /// How far foliage strays.
    pub stray: Stray,
}

/// Why shadows could not be baked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BakeError {
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The machine that a backend draws with failed.
    #[error(transparent)]
    Machine(#[from] MachineFault),
}

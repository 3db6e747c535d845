//! Measuring pictures: which views to look from, silhouettes, and how far two pictures are apart.
//!
//! Used twice, with views that never mix: to calibrate and choose LODs while a tree is made, and to judge
//! the finished ones.

mod context;
pub mod flip;
pub mod menu;
pub mod silhouette;
mod strips;
mod trials;
pub mod views;
pub mod yardstick;

use crate::mesh::TooLarge;
use crate::report::Cancelled;

/// Why forms could not be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeasureError {
    /// A sub-tree's mesh would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

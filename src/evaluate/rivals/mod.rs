//! Rivals: other ways to bring a full tree under a triangle budget, against which our LODs are judged.
//!
//! [`random`] is always there: a LOD that loses to leaves left out by chance is of no use.

mod parts;
mod trivial;

pub use trivial::{leaf_scale, leaves, random};

#[cfg(test)]
mod samples;

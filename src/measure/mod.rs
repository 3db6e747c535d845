//! Measuring pictures: which views to look from, silhouettes, and how far two pictures are apart.
//!
//! Used twice, with views that never mix: to calibrate and choose LODs while a tree is made, and to judge
//! the finished ones.

mod context;
pub mod flip;
pub mod menu;
pub mod silhouette;
mod strips;
pub mod views;
pub mod yardstick;

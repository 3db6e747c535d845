//! Procedural bark and leaves: what a species script describes, as texels.
//!
//! Both generators are pure functions of (description, seed, size). Rows are evaluated in parallel,
//! each texel by itself, so the result does not depend on the number of threads.

mod bark;
mod from_image;
mod leaf;
mod noise;

pub use bark::bark;
pub use from_image::{resized, texels_from_srgb};
pub use leaf::{blade_outline, leaf, leaves_on, reflectance};

use rayon::prelude::*;

/// `f(x, y)` for every texel, row by row from the top.
fn texels_from_rows<T: Copy + Send>(
    width: u32,
    height: u32,
    fill: T,
    f: impl Fn(u32, u32) -> T + Sync,
) -> Vec<T> {
    let mut texels = vec![fill; width as usize * height as usize];
    texels
        .par_chunks_mut(width.max(1) as usize)
        .zip(0..height)
        .for_each(|(row, y)| {
            for (texel, x) in row.iter_mut().zip(0..width) {
                *texel = f(x, y);
            }
        });
    texels
}

//! Errors of LODs, and the screen sizes at which they become small enough.
//!
//! A finished LOD's error is measured (`measure::yardstick`); the level-wide selector by itself has bounds
//! from geometry: a tolerance for splines, and for quads the distance of the sub-tree's outermost points from
//! the nearest of the two planes.

use super::{Form, State};
use crate::math::Similarity;
use crate::tree::{Extent, Part, Tree};

/// Error on screen, in pixels of a picture 1080 high, at which a LOD may be shown. Quads overstate their
/// error much (most leaves lie near a plane, and foliage hides small shifts), so this is not 1.
pub const SWITCH_PIXELS: f32 = 6.0;

/// Picture height for [`SWITCH_PIXELS`].
const PICTURE_HEIGHT: f32 = 1080.0;

/// Part of the picture's height that a tree of `height` metres may fill when a LOD with `error` metres
/// is shown; at most 1, and 1 for no error.
#[must_use]
pub fn screen_size(error: f32, height: f32) -> f32 {
    if error <= 0.0 {
        1.0
    } else {
        (SWITCH_PIXELS / PICTURE_HEIGHT * height / error).min(1.0)
    }
}

/// Makes errors rise and screen sizes fall along a chain: a viewer would skip LODs otherwise.
#[derive(Clone, Copy, Debug)]
pub struct ScreenSizes {
    height: f32,
    before: Option<(f32, f32)>,
}

impl ScreenSizes {
    /// For a tree of some height, metres.
    #[must_use]
    pub fn new(height: f32) -> Self {
        Self {
            height,
            before: None,
        }
    }

    /// Error and screen size of the next LOD from its measured error, metres.
    pub fn next(&mut self, measured: f32) -> (f32, f32) {
        let (floor, ceiling) = self
            .before
            .map_or((0.0, 1.0), |(e, s)| (e * 1.01, s * 0.99));
        let error = measured.max(floor);
        let size = screen_size(error, self.height).min(ceiling);
        self.before = Some((error, size));
        (error, size)
    }
}

/// Error in metres of each form of each level: `errors[level]` is (by spline LOD, quads, collapsed).
#[derive(Clone, Debug)]
pub(super) struct FormErrors {
    levels: Vec<(Vec<f32>, f32, f32)>,
}

impl FormErrors {
    pub(super) fn of(tree: &Tree, extents: &[Vec<Extent>], tolerances: &[f32]) -> Self {
        let scales = largest_scales(tree);
        let levels = tree.levels.iter().enumerate().map(|(index, level)| {
            let mut splines = vec![0.0_f32; tolerances.len().max(1)];
            let (mut quads, mut collapsed) = (0.0_f32, 0.0_f32);
            for (prototype, shared) in level.prototypes.iter().enumerate() {
                let scale = scales[index][prototype];
                if let Part::Branch(branch) = &shared.part {
                    for (error, tolerance) in splines.iter_mut().zip(tolerances) {
                        *error = error.max(tolerance * branch.length * scale);
                    }
                    quads = quads.max(branch.radius * scale);
                }
                let size = extents[index][prototype]
                    .bounds(&Similarity::IDENTITY)
                    .size();
                // The point between two crossed planes is farthest at 45 degrees: half the smaller
                // width times the square root of one half.
                collapsed = collapsed
                    .max(size.x.min(size.z) * 0.5 * core::f32::consts::FRAC_1_SQRT_2 * scale);
            }
            // The finest spline LOD is the reference.
            if let Some(first) = splines.first_mut() {
                *first = 0.0;
            }
            (splines, quads, collapsed)
        });
        Self {
            levels: levels.collect(),
        }
    }

    /// The largest error of any level.
    pub(super) fn of_state(&self, state: &State) -> f32 {
        let of_form =
            |(form, (splines, quads, collapsed)): (&Form, &(Vec<f32>, f32, f32))| match form {
                Form::Geometry(lod) => splines[(*lod as usize).min(splines.len() - 1)],
                Form::Quads => *quads,
                Form::Collapsed => *collapsed,
                Form::Inside => 0.0,
            };
        state
            .forms
            .iter()
            .zip(&self.levels)
            .map(of_form)
            .fold(0.0, f32::max)
    }
}

/// The largest scale with which each prototype stands in the tree.
fn largest_scales(tree: &Tree) -> Vec<Vec<f32>> {
    let mut scales: Vec<Vec<f32>> = tree
        .levels
        .iter()
        .map(|l| vec![0.0; l.prototypes.len()])
        .collect();
    if let Some(first) = scales.first_mut().and_then(|s| s.first_mut()) {
        *first = 1.0;
    }
    for level in 0..tree.levels.len() {
        for (prototype, shared) in tree.levels[level].prototypes.iter().enumerate() {
            let scale = scales[level][prototype];
            for link in &shared.links {
                let slot = &mut scales[link.level as usize][link.prototype as usize];
                *slot = slot.max(scale * link.place.scale);
            }
        }
    }
    scales
}

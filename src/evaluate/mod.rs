//! What each LOD costs the eye: the full tree and every LOD drawn from held-out views, and compared.
//!
//! Nobody publishes how good a tree LOD looks per triangle; this module measures it. Pictures come from the
//! same rasteriser and the same light for all, from views that no capture, calibration or selection has
//! seen ([`crate::measure::views`]).

mod compare;
mod entrants;
mod gate;
mod light;
mod palette;
mod picture;
mod plates;
mod report;
pub mod rivals;
mod run;
#[cfg(test)]
mod sample;
mod subject;
mod summary;
pub(crate) mod text;

pub use gate::faults_above;
pub use report::html;
pub use run::{Settings, evaluate};
pub use subject::{Lod, Look, ReferenceError, Subject, same_atlas, settings_of, with_reference};
pub use summary::{
    Judgement, MAX_COVERAGE_ERROR, MIN_IOU, TABLE_HEADER, Verdict, judge, table_rows,
};

use serde::Serialize;

/// All that was measured of one tree.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Common name.
    pub name: String,
    /// Botanical name; may be empty.
    pub latin: String,
    /// File-name form of the name.
    pub slug: String,
    /// Seed.
    pub seed: u64,
    /// Triangles of the full tree, the reference.
    pub reference_triangles: u64,
    /// Bytes of the foliage atlas' colour and alpha as RGBA8, without mips: shared by all LODs.
    pub texture_bytes: u64,
    /// Number of held-out side views (-5 to 30 degrees above the horizon).
    pub side_views: usize,
    /// Number of held-out aerial views (35 to 80 degrees).
    pub aerial_views: usize,
    /// Heights of the tree in the pictures, pixels, falling.
    pub heights: Vec<u32>,
    /// The LODs from the finest to the coarsest, then the rivals, if any.
    pub models: Vec<Model>,
    /// Pictures for the report; not part of the machine text.
    #[serde(skip)]
    pub plates: Vec<Plate>,
}

/// One thing that was compared with the full tree.
#[derive(Clone, Debug, Serialize)]
pub struct Model {
    /// `LOD0`, or the rival's name.
    pub label: String,
    /// True for a rival: a way of simplifying that is not ours, at the budget of one of our LODs.
    pub rival: bool,
    /// Triangle budget; none for full detail.
    pub budget: Option<u64>,
    /// Triangles.
    pub triangles: u64,
    /// Fragments, transparent ones too, to the pixel of the full tree's frame (its bounding rectangle as
    /// seen), mean over views at the largest height: the fill cost, as layers.
    pub layers: f32,
    /// Measured error, metres; none for rivals.
    pub error_m: Option<f32>,
    /// Part of the picture's height up to which it may be shown; none for rivals.
    pub screen_size: Option<f32>,
    /// Forms of the levels, or the rival's settings, in words.
    pub state: String,
    /// By height, in the order of [`Evaluation::heights`]; rivals have only some of them.
    pub scores: Vec<Scores>,
    /// The rivals of the same budget, and of no more triangles, that have a better silhouette (IoU at the
    /// largest height).
    pub loses_to: Vec<String>,
}

/// Comparison with the full tree at one height, means over views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Scores {
    /// Height of the tree in the picture, pixels.
    pub height: u32,
    /// Over all views.
    pub all: Score,
    /// Over the side views.
    pub side: Score,
    /// Over the aerial views.
    pub aerial: Score,
}

/// How one model compares with the full tree, mean over some views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Score {
    /// Intersection over union of the silhouettes (coverage of a pixel at least one half), 0..=1; 1 is equal.
    pub iou: f32,
    /// Covered pixels against the full tree's, minus 1: negative is thinner.
    pub coverage: f32,
    /// The same without its sign, per view, then the mean.
    pub coverage_abs: f32,
    /// Mean FLIP over the pixels of both silhouettes, 0 (same) ..= 1.
    pub flip: f32,
    /// Mean angle between the normals where both are covered, degrees; not a number if that is nowhere.
    pub normal_deg: f32,
}

/// Pictures from one view at one height, for the report: all cut alike.
#[derive(Clone, Debug)]
pub struct Plate {
    /// `side` or `above`.
    pub view: &'static str,
    /// Height of the tree, pixels.
    pub height: u32,
    /// The full tree; PNG.
    pub reference: Vec<u8>,
    /// The models, each once.
    pub shown: Vec<Shown>,
}

/// One model in a [`Plate`].
#[derive(Clone, Debug)]
pub struct Shown {
    /// Index into [`Evaluation::models`].
    pub model: usize,
    /// The model; PNG.
    pub picture: Vec<u8>,
    /// FLIP, coloured; PNG. Empty but at the largest height.
    pub error: Vec<u8>,
}

//! What each LOD costs the eye: the full tree and every LOD drawn from held-out views, and compared.
//!
//! Nobody publishes how good a tree LOD looks per triangle; this module measures it. Pictures come from the
//! same rasteriser and the same two lights for all, from views that no capture, calibration or selection has
//! seen ([`crate::measure::views`]).

mod compare;
mod entrants;
mod gate;
mod light;
mod motion;
mod palette;
mod picture;
mod plates;
mod report;
mod resample;
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
pub use subject::{
    Lod, Look, ReferenceError, Subject, reference, same_atlas, settings_of, with_reference,
};
pub use summary::{
    Judgement, MAX_COVERAGE_ERROR, MIN_IOU, TABLE_HEADER, Verdict, judge, table_rows,
};

use serde::Serialize;

/// All that was measured of one tree: the machine text of `pleach evaluate --json`.
///
/// The names of its fields, and of those of the records in it, are stable: a field may be added, but none
/// changes its name, unit or meaning. What is no number (a mean over nothing) is `null`.
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
    /// How much the full tree itself changes from frame to frame of a slow orbit: mean FLIP of neighbouring
    /// frames. What [`Flicker::ratio`] is held against.
    pub orbit_flip: f32,
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
    /// What is seen when it takes the place of the next finer LOD, or the finest that of the full tree; none for
    /// rivals.
    pub pop: Option<Pop>,
    /// How restless it is while the viewer moves; none for rivals.
    pub flicker: Option<Flicker>,
    /// The rivals of the same budget, and of no more triangles, that have a better silhouette (IoU at the
    /// largest height): the 95 % interval of the difference, view by view, lies on their side.
    pub loses_to: Vec<String>,
    /// The rivals of the same budget, and of no more triangles, of which that interval holds 0: these views do not
    /// tell which is better.
    pub undecided: Vec<String>,
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
    /// 95 % interval of the mean IoU over all views, from resampled views; not numbers without views.
    pub iou_interval: [f32; 2],
    /// The same of FLIP.
    pub flip_interval: [f32; 2],
}

/// A switch between two neighbouring LODs, as it is seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pop {
    /// Height of the tree at the switch, pixels: [`Model::screen_size`] of 1080 lines, within 8..=512.
    pub height: u32,
    /// FLIP between the two, mean over views.
    pub flip: f32,
    /// The same from the view from which it is seen the most.
    pub worst: f32,
}

/// How much a model changes between neighbouring frames of a slow orbit, 64 pixels high, one degree a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flicker {
    /// Mean FLIP of neighbouring frames.
    pub flip: f32,
    /// That by [`Evaluation::orbit_flip`]: 1 changes as the full tree does, more is restless, less is smooth.
    pub ratio: f32,
    /// Largest FLIP of two neighbouring frames, by [`Evaluation::orbit_flip`].
    pub worst_ratio: f32,
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
    /// Mean FLIP over the pixels of both silhouettes, 0 (same) ..= 1, and over both lights.
    pub flip: f32,
    /// The same under each light: a high sun before mid-grey, and a low one across before a dark grey.
    pub flip_by_light: [f32; 2],
    /// The larger of the two.
    pub flip_worst: f32,
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

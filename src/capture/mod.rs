//! Captures: render to texture, on the CPU or by another [`Backend`].
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, section IV.D. Captured per texel: albedo, coverage,
//! normal in the quad's tangent frame, ambient occlusion, roughness, translucency, depth offset. Never
//! baked lighting.

mod backend;
mod bake;
mod cpu;
mod occlusion;
mod plan;
mod raster;
mod studio;

pub use backend::{Backend, Pass, Picture, Scene, Shot};
pub use bake::{
    BakeError, Baked, LeafArtwork, LeafSheet, Settings, Source, bake, bake_with, leaf_sheet,
    standing,
};
pub use cpu::Cpu;
pub use occlusion::Occlusion;
pub use plan::{Plan, PlaneSet, Subject, VIEWS};
pub use raster::{ALPHA_CUTOFF, Foliage, Seen, Textures, View, Visibility};
pub(crate) use studio::CAPTURE_SPLINE_LOD;

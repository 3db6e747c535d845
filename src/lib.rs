//! Pleach grows self-similar trees from species scripts and flattens them, level by level, into
//! shared textured quads: the fewest triangles that still look like the tree.
//!
//! Data flow one way: a script becomes a [`species`], a species and a seed become a tree, a tree
//! becomes meshes, captures, a chain of LODs and shadows, and those become a pack of files.

pub mod asset;
pub mod batch;
pub mod capture;
#[cfg(feature = "cli")]
pub mod cli;
pub mod disk;
pub mod evaluate;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_bake;
#[cfg(feature = "cli")]
pub mod guide;
pub mod image;
#[cfg(feature = "cli")]
pub mod import;
pub mod impostor;
pub mod lod;
pub mod math;
pub mod measure;
pub mod mesh;
pub mod pack;
pub mod pipeline;
pub mod preview;
#[cfg(feature = "gpu")]
pub mod render;
pub mod report;
pub mod rng;
pub mod shadow;
pub mod species;
pub mod spline;
#[cfg(feature = "studio")]
pub mod studio;
pub mod survey;
pub mod texture;
pub mod tree;
#[cfg(feature = "preview")]
pub mod viewer;
pub mod wind;

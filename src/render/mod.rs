//! Drawing trees as an engine would: sun with a shadow map, sky and ground light, baked shadows on the ground.
//!
//! Home of: Candussi, Hollerer, Candussi 2005, sections 2.1 (light as the sum of four factors, one of two
//! modes) and 2.3 (filters); Koniaris, Gaitatzes, Papaioannou 2009, section IV.F (nine shadows by projective
//! texturing).
//!
//! Changes versus the papers:
//! - The default light is a product of sun and sky with what stands in their way; the sum of four factors
//!   is a mode of its own, with weights that keep it from saturating.
//! - Density is a volume for each tree: what of the sky and of each of the nine lights reaches its cells. It
//!   shades every LOD alike, and stands in for the shadow map where there is none.
//! - Alpha to coverage is worked out in the shader, as a mask of samples, so that LODs can fade into one
//!   another on complementary samples.

mod binding;
mod camera;
mod drawing;
pub mod forest;
mod hull;
mod maker;
mod model;
mod part;
mod pipelines;
mod renderer;
mod scene;
mod sun_map;
mod targets;
pub mod uniforms;

pub use camera::{Camera, Lens, Orbit};
pub use maker::Maker;
pub use model::{Lod, Model, Textures};
pub use renderer::{PORTRAIT, Renderer};
pub use scene::{
    CALM, Filter, Group, LEVEL_COLOURS, LightMode, Scene, Setting, ViewMode, level_colour,
};
pub use uniforms::Instance;

//! The seam between what captures show and what draws them.
//!
//! What is shown, from where and at what size is decided once, in [`super::bake()`]; a backend turns it into
//! texels. [`super::Cpu`] is the yardstick: its bytes are the same on every machine. Another one may differ from
//! it within a tolerance, which `tests/gpu_bake.rs` holds the adapter's to.

use super::BakeError;
use super::occlusion::Occlusion;
use super::raster::{Textures, View};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use crate::math::Vec3;
use crate::mesh::Mesh;
use crate::report::Progress;

/// Draws captures.
pub trait Backend: Sync {
    /// Draws all scenes of a pass. Gives for each scene, in order, a picture for each of its shots.
    ///
    /// Asks `progress` whether to go on at least once a scene, and tells it a step for each.
    ///
    /// # Errors
    /// What a scene's making says; [`BakeError::Cancelled`]; [`BakeError::Machine`] if what draws failed.
    fn draw(
        &self,
        pass: &Pass<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Picture>>, BakeError>;

    /// What drew, in words, if its texels are equal to those of [`super::Cpu`] only within a tolerance.
    fn inexact(&self) -> Option<String> {
        None
    }
}

/// Scenes that sample nothing that another one of them writes.
pub struct Pass<'a> {
    /// Mips of the bark and of the atlas as it stands.
    pub textures: Textures<'a>,
    /// The rectangles of the atlas that the scenes may show; all else of it need not be looked at.
    pub parts: &'a [Rect],
    /// Samples along each edge of a texel.
    pub supersample: u32,
    /// Number of scenes.
    pub scenes: usize,
    /// Makes a scene. Costly in time and memory: to be called from several threads, and to be let go of soon.
    pub scene: &'a (dyn Fn(usize) -> Result<Scene, BakeError> + Sync),
}

/// One subject, with the shots that are wanted of it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the shots show.
    pub meshes: Vec<Mesh>,
    /// The density of the whole subject, not yet lit: what darkens the inside of the crown.
    pub occlusion: Occlusion,
    /// What is wanted.
    pub shots: Vec<Shot>,
}

/// One capture that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Which of the scene's meshes.
    pub mesh: usize,
    /// From where; its size is in samples.
    pub view: View,
    /// Texels across and down.
    pub texels: [u32; 2],
    /// A point of the plane that the picture is put on; in the mean of what is seen without.
    pub(super) axis: Option<Vec3>,
    /// Radius of a single branch as captured, metres; 0 for combined levels.
    pub(super) thick: f32,
    /// Thickness of the captured node.
    pub(super) thickness: f32,
}

impl Shot {
    /// A shot of a mesh, put on a plane in the mean depth of what is seen.
    #[must_use]
    pub fn new(mesh: usize, view: View, texels: [u32; 2]) -> Self {
        Self {
            mesh,
            view,
            texels,
            axis: None,
            thick: 0.0,
            thickness: 1.0,
        }
    }
}

/// One capture as drawn.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What was wanted.
    pub shot: Shot,
    /// Its texels, shaded by the scene's occlusion. Depth is in metres toward the viewer from the view's centre;
    /// texels on which nothing is seen are [`Texel::EMPTY`].
    pub image: Image<Texel>,
}

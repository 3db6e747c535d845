//! Making models on threads other than a renderer's.

use super::model::{Layouts, Lod, Model, Textures};
use crate::asset::Drawable;
use crate::gpu::{Gpu, GpuError};
use crate::mesh::Mesh;
use crate::shadow::Shadows;

/// Cells of the light volume along the longest edge of a tree, and of one that stands in for it.
const VOLUME_CELLS: u32 = 32;
const ROUGH_CELLS: u32 = 16;

/// Makes models for a renderer, on any thread.
#[derive(Clone, Debug)]
pub struct Maker {
    pub(super) gpu: Gpu,
    pub(super) layouts: Layouts,
}

impl Maker {
    /// Puts a tree on the device; with the `textures` of another model if they are the same.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if a mesh or a texture is more than the adapter takes, or what the driver says.
    pub fn make(
        &self,
        source: &Drawable<'_>,
        textures: Option<Textures>,
    ) -> Result<Model, GpuError> {
        self.gpu
            .apart(|| Model::new(&self.gpu, &self.layouts, source, (textures, VOLUME_CELLS)))
    }

    /// Puts a sketch on the device, with the meshes that stand in for it. If it is itself such a mesh it is the first of
    /// them, and its light is worked out roughly.
    ///
    /// # Errors
    /// See [`Maker::make`].
    pub fn sketch(
        &self,
        source: &Drawable<'_>,
        (stand_ins, is_one): (&[Mesh], bool),
        textures: Option<Textures>,
    ) -> Result<Model, GpuError> {
        let cells = if is_one { ROUGH_CELLS } else { VOLUME_CELLS };
        self.gpu.apart(|| {
            let mut model = Model::new(&self.gpu, &self.layouts, source, (textures, cells))?;
            model.is_rough = is_one;
            if is_one {
                model.stand_ins.extend(model.lods.first().cloned());
            }
            for mesh in stand_ins {
                let lod = Lod::new(&self.gpu, (mesh, source.reliefs), 0.0)?;
                model.stand_ins.push(lod);
            }
            Ok(model)
        })
    }

    /// The same tree with other baked shadows on the ground.
    ///
    /// # Errors
    /// What the driver says.
    pub fn shaded(&self, model: &Model, shadows: &Shadows) -> Result<Model, GpuError> {
        self.gpu
            .apart(|| Ok(model.shaded(&self.gpu, &self.layouts, &shadows.maps)))
    }
}

//! The geometry of one prototype's own part, once, in its own frame; nodes are copies of it.

use super::Vertex;
use crate::math::{Similarity, Vec3};

/// A vertex as an axis point plus an offset, so that a node's thickness is a multiplication.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemplateVertex {
    /// Point that thickness leaves in place, metres in the prototype's frame.
    pub axis: Vec3,
    /// Displacement that thickness multiplies, metres.
    pub offset: Vec3,
    /// Unit.
    pub normal: Vec3,
    /// Unit, along rising u; glTF handedness is always 1 here.
    pub tangent: Vec3,
    /// Texture coordinates.
    pub uv: [f32; 2],
}

/// Which material a template is drawn in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Material {
    /// Opaque branch geometry.
    #[default]
    Bark,
    /// Alpha-tested cards.
    Foliage,
}

/// Geometry of one prototype's part in one form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Template {
    /// Material of all triangles.
    pub material: Material,
    /// Vertices.
    pub vertices: Vec<TemplateVertex>,
    /// Three a triangle.
    pub indices: Vec<u32>,
}

impl Template {
    /// Copies the template into place. The slices must be exactly as long as the template.
    #[inline]
    pub(super) fn write(
        &self,
        place: &Similarity,
        thickness: f32,
        vertices: &mut [Vertex],
        indices: &mut [u32],
        base: u32,
    ) {
        let turn = glam::Mat3::from_quat(place.rotation);
        let stretch = turn * place.scale;
        for (out, vertex) in vertices.iter_mut().zip(&self.vertices) {
            let position = place.translation + stretch * (vertex.axis + vertex.offset * thickness);
            let tangent = turn * vertex.tangent;
            *out = Vertex {
                position: position.to_array(),
                normal: (turn * vertex.normal).to_array(),
                tangent: [tangent.x, tangent.y, tangent.z, 1.0],
                uv: vertex.uv,
            };
        }
        for (out, index) in indices.iter_mut().zip(&self.indices) {
            *out = base + index;
        }
    }
}

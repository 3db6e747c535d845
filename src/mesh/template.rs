//! The geometry of one prototype's own part, once, in its own frame; nodes are copies of it.

use super::{Mesh, Primitive, Vertex};
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
    /// As in [`Vertex::tint`].
    pub tint: [u8; 4],
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
    /// The template as a mesh of its own.
    #[must_use]
    pub fn placed(&self, place: &Similarity, thickness: f32) -> Mesh {
        let zero: Vertex = bytemuck::Zeroable::zeroed();
        let mut primitive = Primitive {
            vertices: vec![zero; self.vertices.len()],
            indices: vec![0; self.indices.len()],
            ..Primitive::default()
        };
        let Primitive {
            vertices, indices, ..
        } = &mut primitive;
        self.write(place, thickness, vertices, indices, 0);
        match self.material {
            Material::Bark => Mesh {
                bark: primitive,
                ..Mesh::default()
            },
            Material::Foliage => Mesh {
                foliage: primitive,
                ..Mesh::default()
            },
        }
    }

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
        let motion = Motion::of(place);
        for (out, vertex) in vertices.iter_mut().zip(&self.vertices) {
            let point = vertex.axis + vertex.offset * thickness;
            let tangent = vertex.tangent.extend(1.0).to_array();
            motion.write(point, vertex.normal, tangent, vertex.uv, out);
            out.tint = vertex.tint;
        }
        for (out, index) in indices.iter_mut().zip(&self.indices) {
            *out = base + index;
        }
    }
}

/// Copies finished vertices and indices into place. The slices must be exactly as long as theirs.
#[inline]
pub(super) fn write_rigid(
    from: &Primitive,
    place: &Similarity,
    vertices: &mut [Vertex],
    indices: &mut [u32],
    base: u32,
) {
    let motion = Motion::of(place);
    for (out, vertex) in vertices.iter_mut().zip(&from.vertices) {
        let (point, normal) = (Vec3::from(vertex.position), Vec3::from(vertex.normal));
        motion.write(point, normal, vertex.tangent, vertex.uv, out);
        out.tint = vertex.tint;
    }
    for (out, index) in indices.iter_mut().zip(&from.indices) {
        *out = base + index;
    }
}

/// A [`Similarity`] as columns of four lanes, which compilers turn into vector instructions.
struct Motion {
    /// Turn and scale, then the shift; the fourth lane is not used.
    stretch: [[f32; 4]; 4],
    /// Turn; the fourth lane is not used.
    turn: [[f32; 4]; 3],
}

impl Motion {
    fn of(place: &Similarity) -> Self {
        let turn = glam::Mat3::from_quat(place.rotation);
        let lanes = |v: Vec3| v.extend(0.0).to_array();
        let [x, y, z] = [turn.x_axis, turn.y_axis, turn.z_axis];
        Self {
            stretch: [
                x * place.scale,
                y * place.scale,
                z * place.scale,
                place.translation,
            ]
            .map(lanes),
            turn: [x, y, z].map(lanes),
        }
    }

    /// Writes all but the tint.
    #[inline]
    fn write(&self, point: Vec3, normal: Vec3, tangent: [f32; 4], uv: [f32; 2], out: &mut Vertex) {
        let mix = |[x, y, z]: &[[f32; 4]; 3], a: f32, b: f32, c: f32| -> [f32; 4] {
            core::array::from_fn(|i| x[i] * a + y[i] * b + z[i] * c)
        };
        let [x, y, z, shift] = &self.stretch;
        let position: [f32; 4] =
            core::array::from_fn(|i| x[i] * point.x + y[i] * point.y + (z[i] * point.z + shift[i]));
        let normal = mix(&self.turn, normal.x, normal.y, normal.z);
        let handedness = tangent[3];
        let tangent = mix(&self.turn, tangent[0], tangent[1], tangent[2]);
        // Whole lanes are stored, and the next attribute covers the lane that is not used.
        let out: &mut [f32; 13] = bytemuck::cast_mut(out);
        out[0..4].copy_from_slice(&position);
        out[3..7].copy_from_slice(&normal);
        out[6..10].copy_from_slice(&tangent);
        out[9] = handedness;
        out[10..12].copy_from_slice(&uv);
    }
}

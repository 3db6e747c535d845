//! The geometry of one prototype's own part, once, in its own frame; nodes are copies of it.

use super::{Primitive, Vertex};
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
        let motion = Motion::of(place);
        for (out, vertex) in vertices.iter_mut().zip(&self.vertices) {
            let point = vertex.axis + vertex.offset * thickness;
            let tangent = vertex.tangent.extend(1.0).to_array();
            motion.write(point, vertex.normal, tangent, vertex.uv, out);
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
    }
    for (out, index) in indices.iter_mut().zip(&from.indices) {
        *out = base + index;
    }
}

/// A [`Similarity`] as columns of four lanes, which compilers turn into vector instructions.
struct Motion {
    /// Turn and scale, then the shift; the fourth lane is not used.
    stretch: [[f32; 4]; 4],
    /// Turn; the fourth lane is 0.
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

    #[inline]
    fn write(&self, point: Vec3, normal: Vec3, tangent: [f32; 4], uv: [f32; 2], out: &mut Vertex) {
        let mix = |[x, y, z]: &[[f32; 4]; 3], v: [f32; 3], plus: [f32; 4]| -> [f32; 4] {
            core::array::from_fn(|i| x[i] * v[0] + y[i] * v[1] + z[i] * v[2] + plus[i])
        };
        let [x, y, z, shift] = self.stretch;
        let [tx, ty, tz, handedness] = tangent;
        let position = mix(&[x, y, z], point.to_array(), shift);
        let normal = mix(&self.turn, normal.to_array(), [0.0; 4]);
        let tangent = mix(&self.turn, [tx, ty, tz], [0.0, 0.0, 0.0, handedness]);
        // Whole lanes are stored, and the next attribute covers the lane that is not used.
        let out: &mut [f32; 12] = bytemuck::cast_mut(out);
        out[0..4].copy_from_slice(&position);
        out[3..7].copy_from_slice(&normal);
        out[6..10].copy_from_slice(&tangent);
        out[10..12].copy_from_slice(&uv);
    }
}

//! Triangles on the device.

use crate::gpu::{Gpu, GpuError, upload};
use crate::math::{Vec2, Vec3};
use crate::mesh::Primitive;
use crate::mesh::card::Relief;
use crate::wind::Sway;
use bytemuck::{Pod, Zeroable};

/// The level of vertices that are of none, or of one that is not known: `NO_LEVEL` of `tree.wgsl`.
const NO_LEVEL: u32 = 255;

/// Triangles of one material.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) vertices: wgpu::Buffer,
    /// How the vertices sway.
    pub(super) sway: wgpu::Buffer,
    /// What the vertices belong to, an [`Origin`] each.
    pub(super) origins: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    /// Pairs of indices, for the view of edges.
    pub(super) edges: wgpu::Buffer,
    pub(super) count: u32,
}

/// What a vertex belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Origin {
    /// The script's level, or [`NO_LEVEL`].
    pub(super) level: u32,
    /// The length that depth offsets of its capture are parts of, metres; 0 if it is of none.
    pub(super) relief_m: f32,
}

impl Part {
    /// A primitive, whose quads may show some captures.
    pub(super) fn new(
        gpu: &Gpu,
        primitive: &Primitive,
        reliefs: &[Relief],
    ) -> Result<Option<Self>, GpuError> {
        if primitive.indices.is_empty() {
            return Ok(None);
        }
        let corners = primitive.indices.as_chunks::<3>().0;
        let edges: Vec<[u32; 2]> = corners
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .collect();
        let still = vec![Sway::default(); primitive.vertices.len()];
        let sway = if primitive.sway.len() == primitive.vertices.len() {
            &primitive.sway
        } else {
            &still
        };
        let limit = gpu.device.limits().max_buffer_size;
        let buffer = |what: &'static str, contents: &[u8], usage| {
            let size = contents.len() as u64;
            if size > limit {
                return Err(GpuError::TooLarge { what, size, limit });
            }
            Ok(upload(gpu, what, contents, usage))
        };
        let of_vertices =
            |contents: &[u8]| buffer("a vertex buffer", contents, wgpu::BufferUsages::VERTEX);
        let of_indices =
            |contents: &[u8]| buffer("an index buffer", contents, wgpu::BufferUsages::INDEX);
        Ok(Some(Self {
            vertices: of_vertices(bytemuck::cast_slice(&primitive.vertices))?,
            sway: of_vertices(bytemuck::cast_slice(sway))?,
            origins: of_vertices(bytemuck::cast_slice(&origins(primitive, reliefs)))?,
            indices: of_indices(bytemuck::cast_slice(&primitive.indices))?,
            edges: of_indices(bytemuck::cast_slice(&edges))?,
            count: u32::try_from(primitive.indices.len()).unwrap_or(u32::MAX),
        }))
    }
}

/// What the vertices of a primitive belong to.
fn origins(primitive: &Primitive, reliefs: &[Relief]) -> Vec<Origin> {
    let flat = |level: u32| Origin {
        level,
        relief_m: 0.0,
    };
    let levels = primitive.levels.iter().map(|&level| flat(level.into()));
    let mut origins: Vec<Origin> = levels.collect();
    origins.resize(primitive.vertices.len(), flat(NO_LEVEL));
    if reliefs.is_empty() {
        return origins;
    }
    for &corners in primitive.indices.as_chunks::<3>().0 {
        let vertices = corners.map(|i| &primitive.vertices[i as usize]);
        let uv = vertices.map(|v| Vec2::from(v.uv));
        let middle = uv.iter().sum::<Vec2>() / 3.0;
        let Some(relief) = reliefs.iter().find(|r| r.uv.holds(middle.to_array())) else {
            continue;
        };
        let longer = longer_side(relief, uv, vertices.map(|v| Vec3::from(v.position)));
        for corner in corners {
            origins[corner as usize].relief_m = longer;
        }
    }
    origins
}

/// Longer side of the whole picture of a capture, metres, as large as it is on a triangle of a quad: whatever the scale
/// of the node, and of the quad.
fn longer_side(relief: &Relief, uv: [Vec2; 3], at: [Vec3; 3]) -> f32 {
    let [a, b] = [uv[1] - uv[0], uv[2] - uv[0]];
    let [p, q] = [at[1] - at[0], at[2] - at[0]];
    let area = a.perp_dot(b).abs();
    let across = (p * b.y - q * a.y).length() / area;
    let down = (q * a.x - p * b.x).length() / area;
    let uv = relief.uv;
    let longer = (across * (uv.u1 - uv.u0)).max(down * (uv.v1 - uv.v0));
    // A triangle without area shows nothing.
    if longer.is_finite() { longer } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Similarity;
    use crate::mesh::card::{Pane, Quad, UvRect, quads};

    #[test]
    fn a_quad_knows_the_length_that_depths_are_parts_of_at_any_size() {
        let uv = UvRect {
            u0: 0.25,
            v0: 0.5,
            u1: 0.5,
            v1: 1.0,
        };
        let quad = Quad {
            centre: Vec3::Y,
            right: Vec3::X,
            up: Vec3::Y,
            half: [0.5, 1.5],
            thick: 0.0,
            captured_thickness: 1.0,
            pane: Pane {
                uv,
                corners: [[-0.9, -1.0], [0.4, -0.7], [-0.6, 0.8], [1.0, 0.9]],
            },
        };
        let place = Similarity {
            scale: 2.0,
            ..Similarity::IDENTITY
        };
        let mesh = quads(&[quad]).placed(&place, 1.0);
        let [captured, elsewhere] = [
            uv,
            UvRect {
                u0: 0.6,
                u1: 0.9,
                ..uv
            },
        ]
        .map(|uv| Relief { uv, longer: 3.0 })
        .map(|relief| origins(&mesh.foliage, &[relief]));
        for (origin, other) in captured.iter().zip(&elsewhere) {
            assert!((origin.relief_m - 6.0).abs() < 1e-4, "{origin:?}");
            assert_eq!((origin.level, other.relief_m), (NO_LEVEL, 0.0));
        }
    }
}

//! Triangle meshes: branch tubes, leaf cards, and the flattening of a tree into one mesh.

pub mod card;
pub mod check;
mod coat;
mod flatten;
mod front;
mod sway;
mod template;
mod tube;

pub use coat::Coat;
pub use flatten::{Flattener, Form, Sizes, TooLarge};
pub use front::{Dress, Wardrobe, front};
pub use sway::Swayer;
pub use template::{Material, Template, TemplateVertex};
pub use tube::tube;

use crate::math::{Bounds, Vec3};
use crate::wind::{Rig, Sway, Wind, displacement};

/// A vertex as every stage, the exporter and the renderer see it: 52 bytes, no padding.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Metres.
    pub position: [f32; 3],
    /// Unit.
    pub normal: [f32; 3],
    /// Unit, along rising u; the fourth is the handedness, 1 or -1, as in glTF.
    pub tangent: [f32; 4],
    /// Texture coordinates, v downward as in glTF.
    pub uv: [f32; 2],
    /// Linear factor on the texture's colour, 255 for 1; the fourth is always 255. See [`Coat`].
    pub tint: [u8; 4],
}

/// The tint that leaves colours as they are.
pub const WHITE: [u8; 4] = [255; 4];

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// Vertices.
    pub vertices: Vec<Vertex>,
    /// Three a triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
    /// How the vertices sway, one a vertex, or empty: what [`Swayer`] adds once a mesh is chosen.
    pub sway: Vec<Sway>,
    /// The script's level of what each vertex belongs to, one a vertex, or empty: what [`Swayer`] adds, too. What
    /// stands for a node with all that grows on it belongs to the node's level. Files do not hold it.
    pub levels: Vec<u8>,
}

impl Primitive {
    /// Number of triangles.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        self.indices.len() as u64 / 3
    }
}

/// A tree, or a part of one, in its two materials (Koniaris et al., section IV.G).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Opaque geometry.
    pub bark: Primitive,
    /// Alpha-tested cards, textured by the foliage atlas.
    pub foliage: Primitive,
}

impl Mesh {
    /// Number of triangles of both primitives.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        self.bark.triangles() + self.foliage.triangles()
    }

    /// The mesh where a wind takes it at a time (see [`displacement`]); what has no sway stays.
    #[must_use]
    pub fn in_wind(&self, wind: &Wind, rig: &Rig, time_s: f32, view_axis: Vec3) -> Self {
        let mut moved = self.clone();
        for primitive in [&mut moved.bark, &mut moved.foliage] {
            for (vertex, &sway) in primitive.vertices.iter_mut().zip(&primitive.sway) {
                let at = Vec3::from(vertex.position);
                let away = displacement(wind, rig, time_s, at.y, sway, view_axis);
                vertex.position = (at + away).to_array();
            }
        }
        moved
    }

    /// Bounds of both primitives.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let vertices = self.bark.vertices.iter().chain(&self.foliage.vertices);
        Bounds::of_points(vertices.map(|v| Vec3::from(v.position)))
    }
}

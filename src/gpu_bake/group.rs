//! Groups of scenes that are drawn together: what lies where in their buffers and on their sheet.

use super::develop::row_bytes;
use super::layout;
use super::sheet::Sheet;
use crate::capture::{Scene, Shot};
use crate::gpu::{Gpu, GpuError};
use crate::math::{Bounds, Vec3};
use crate::mesh::{Mesh, Primitive, Vertex};

/// Bytes of vertices beyond which another group is begun.
const GROUP_BYTES: u64 = 64 << 20;

/// Samples beyond which another group is begun: 48 MiB with their depths. Larger sheets are no faster on a card, and
/// slower on a software driver, which first has to get their memory.
pub(super) const GROUP_SAMPLES: u64 = 1 << 22;

/// Why a scene fits no group.
pub(super) fn too_large(gpu: &Gpu, scene: &Ready) -> GpuError {
    let limits = gpu.device.limits();
    let edges = scene.scene.shots.iter();
    let edge = edges.map(|s| s.view.width.max(s.view.height)).max();
    let edge = edge.unwrap_or(0);
    if edge > limits.max_texture_dimension_2d {
        return GpuError::TooLarge {
            what: "a capture's edge, samples,",
            size: u64::from(edge),
            limit: u64::from(limits.max_texture_dimension_2d),
        };
    }
    GpuError::TooLarge {
        what: "a captured sub-tree, bytes,",
        size: scene.bytes(),
        limit: limits.max_buffer_size,
    }
}

/// A scene with what its drawing needs to know.
pub(super) struct Ready {
    pub(super) scene: Scene,
    /// Bounds of its meshes.
    pub(super) bounds: Vec<Bounds>,
}

impl Ready {
    pub(super) fn new(scene: Scene) -> Self {
        let bounds = scene.meshes.iter().map(Mesh::bounds).collect();
        Self { scene, bounds }
    }

    pub(super) fn vertices(&self) -> impl Iterator<Item = &[Vertex]> {
        let meshes = self.scene.meshes.iter();
        meshes.flat_map(|m| [&m.bark.vertices[..], &m.foliage.vertices[..]])
    }

    pub(super) fn indices(&self) -> impl Iterator<Item = &[u32]> {
        let meshes = self.scene.meshes.iter();
        meshes.flat_map(|m| [&m.bark.indices[..], &m.foliage.indices[..]])
    }

    /// Bytes of the larger of the two buffers.
    pub(super) fn bytes(&self) -> u64 {
        let vertices: usize = self.vertices().map(<[Vertex]>::len).sum();
        let indices: usize = self.indices().map(<[u32]>::len).sum();
        (vertices * size_of::<Vertex>()).max(indices * 4) as u64
    }
}

/// Scenes that are drawn together.
pub(super) struct Group {
    pub(super) scenes: Vec<Ready>,
    /// Where each shot lies on the sheet.
    pub(super) places: Vec<[u32; 2]>,
    pub(super) sheet: Sheet,
    pub(super) bytes: u64,
    /// Size of the picture of all grids, side by side.
    pub(super) grids: [u32; 2],
    supersample: u32,
    /// Largest buffer, and largest edge of a texture.
    limits: (u64, u32),
}

impl Group {
    pub(super) fn new(gpu: &Gpu, supersample: u32) -> Self {
        let limits = gpu.device.limits();
        Self {
            scenes: Vec::new(),
            places: Vec::new(),
            sheet: Sheet::new(limits.max_texture_dimension_2d),
            bytes: 0,
            grids: [0, 0],
            supersample,
            limits: (limits.max_buffer_size, limits.max_texture_dimension_2d),
        }
    }

    /// Takes a scene, or gives it back if it is too much.
    pub(super) fn add(&mut self, scene: Ready) -> Option<Ready> {
        let bytes = scene.bytes();
        let (buffer, edge) = self.limits;
        // A scene is drawn whole, however large.
        let (most, most_samples) = if self.scenes.is_empty() {
            (buffer, u64::MAX)
        } else {
            (buffer.min(GROUP_BYTES), GROUP_SAMPLES)
        };
        let mut sheet = self.sheet;
        let shots = scene.scene.shots.iter();
        let places: Option<Vec<[u32; 2]>> = shots
            .map(|s| sheet.place([s.view.width, s.view.height]))
            .collect();
        let grids = grids_with(self.grids, &scene.scene);
        let fits = self.bytes + bytes <= most
            && sheet.samples() <= most_samples
            && bytes_back(sheet.size(), self.supersample) <= buffer
            && grids.iter().all(|&n| n <= edge);
        let Some(places) = places.filter(|_| fits) else {
            return Some(scene);
        };
        self.places.extend(places);
        self.sheet = sheet;
        self.bytes += bytes;
        self.grids = grids;
        self.scenes.push(scene);
        None
    }

    /// Texels of the sheet, across and down.
    pub(super) fn texels(&self) -> [u32; 2] {
        self.sheet.size().map(|n| n.div_ceil(self.supersample))
    }

    /// Bytes of the grids' densities.
    pub(super) fn bytes_of_grids(&self) -> u64 {
        let cells = |ready: &Ready| ready.scene.occlusion.density().len() as u64;
        self.scenes.iter().map(cells).sum::<u64>() * 4
    }
}

/// Size of the picture of grids with another scene's.
fn grids_with([across, down]: [u32; 2], scene: &Scene) -> [u32; 2] {
    let [width, height, depth] = scene.occlusion.size();
    [across + width, down.max(height * depth)]
}

/// Bytes of all texels of a sheet on their way back.
fn bytes_back(samples: [u32; 2], supersample: u32) -> u64 {
    let [width, height] = samples.map(|n| n.div_ceil(supersample));
    u64::from(row_bytes(width)) * u64::from(height)
}

/// Triangles of a mesh's bark or foliage in the buffers of a group.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) indices: core::ops::Range<u32>,
    pub(super) first_vertex: i32,
}

/// The shots of a group as the shaders read them, and what is drawn of each.
#[derive(Default)]
pub(super) struct List {
    pub(super) shots: Vec<layout::Shot>,
    /// Bark and foliage of each shot.
    pub(super) parts: Vec<[Part; 2]>,
    /// A shot of each grid.
    pub(super) lit: Vec<usize>,
}

impl List {
    pub(super) fn of(group: &Group) -> Self {
        let mut list = Self::default();
        let mut places = group.places.iter();
        let (mut first_index, mut first_vertex) = (0, 0);
        let mut column = 0;
        for ready in &group.scenes {
            let mut part = |primitive: &Primitive| {
                let part = Part {
                    indices: first_index..first_index + count(primitive.indices.len()),
                    first_vertex: i32::try_from(first_vertex).unwrap_or(i32::MAX),
                };
                first_index = part.indices.end;
                first_vertex += primitive.vertices.len();
                part
            };
            let meshes = ready.scene.meshes.iter();
            let parts: Vec<[Part; 2]> = meshes
                .map(|mesh| [&mesh.bark, &mesh.foliage].map(&mut part))
                .collect();
            let occlusion = &ready.scene.occlusion;
            if !ready.scene.shots.is_empty() {
                list.lit.push(list.shots.len());
            }
            for (shot, &place) in ready.scene.shots.iter().zip(&mut places) {
                list.parts.push(parts[shot.mesh].clone());
                list.shots.push(layout::Shot {
                    place,
                    corner: occlusion.origin().to_array(),
                    cell: occlusion.cell(),
                    size: occlusion.size(),
                    column,
                    ..described(shot, &ready.bounds[shot.mesh])
                });
            }
            column += occlusion.size()[0];
        }
        list
    }
}

/// A number of things that fit 32 bits: groups are kept small.
pub(super) fn count(things: usize) -> u32 {
    u32::try_from(things).unwrap_or(u32::MAX)
}

fn described(shot: &Shot, bounds: &Bounds) -> layout::Shot {
    let view = &shot.view;
    let toward = view.toward();
    let wide = |v: Vec3| v.extend(0.0).to_array();
    // A little more than the mesh has, so that nothing is cut away.
    let depths = bounds.corners().map(|c| (c - view.centre).dot(toward));
    let low = depths.into_iter().fold(f32::INFINITY, f32::min);
    let high = depths.into_iter().fold(f32::NEG_INFINITY, f32::max);
    let spare = (high - low) * 0.01 + 1e-5;
    let depth = if bounds.is_empty() {
        [0.0, 1.0]
    } else {
        [low - spare, 1.0 / (high - low + 2.0 * spare)]
    };
    layout::Shot {
        right: wide(view.right),
        up: wide(view.up),
        toward: wide(toward),
        centre: wide(view.centre),
        half: view.half,
        depth,
        samples: [view.width, view.height],
        place: [0; 2],
        corner: [0.0; 3],
        cell: 1.0,
        size: [1; 3],
        column: 0,
    }
}

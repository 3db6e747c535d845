//! The mesh of a GLB that this program wrote; the reverse of its neighbour that writes, and no more.
//!
//! A GLB that says anything else is refused rather than half understood: a field that is not known here may
//! move, cut or recolour what is drawn, and a mesh read without it would not be the one in the file. Where
//! the textures lie and how they are sampled is not looked at: packs name their textures in the manifest.

use crate::capture::ALPHA_CUTOFF;
use crate::mesh::{Mesh, Primitive, Vertex, WHITE};
use crate::wind::Sway;
use core::mem::offset_of;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::gltf::{ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER, FLOAT, I8, U8, U16, U32, WIND, WIND_LEAF};

/// The JSON of a GLB. What a document may hold beside it, this program does not write.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Document {
    asset: Asset,
    scene: usize,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Meshes>,
    materials: Vec<Material>,
    #[serde(rename = "textures")]
    _textures: IgnoredAny,
    #[serde(rename = "images")]
    _images: IgnoredAny,
    #[serde(rename = "samplers")]
    _samplers: IgnoredAny,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asset {
    version: String,
    #[serde(rename = "generator")]
    _generator: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Node {
    #[serde(rename = "name")]
    _name: IgnoredAny,
    mesh: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Meshes {
    #[serde(rename = "name")]
    _name: IgnoredAny,
    primitives: Vec<Triangles>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Triangles {
    attributes: Attributes,
    indices: usize,
    material: usize,
    mode: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "SCREAMING_SNAKE_CASE")]
struct Attributes {
    position: usize,
    normal: usize,
    tangent: usize,
    texcoord_0: usize,
    color_0: Option<usize>,
    #[serde(rename = "_WIND")]
    wind: Option<usize>,
    #[serde(rename = "_WIND_LEAF")]
    wind_leaf: Option<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Material {
    name: String,
    alpha_mode: Option<String>,
    alpha_cutoff: Option<f32>,
    #[serde(default)]
    double_sided: bool,
    #[serde(rename = "pbrMetallicRoughness")]
    _colour: Colour,
    #[serde(rename = "normalTexture")]
    _normal: IgnoredAny,
    #[serde(rename = "occlusionTexture")]
    _occlusion: IgnoredAny,
}

/// Known only so that a factor that recolours the textures is refused.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Colour {
    #[serde(rename = "baseColorTexture")]
    _albedo: IgnoredAny,
    #[serde(rename = "metallicRoughnessTexture")]
    _orm: IgnoredAny,
    #[serde(rename = "metallicFactor")]
    _metallic: IgnoredAny,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Accessor {
    buffer_view: usize,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    #[serde(rename = "min")]
    _min: Option<IgnoredAny>,
    #[serde(rename = "max")]
    _max: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct View {
    buffer: usize,
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
    target: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Buffer {
    byte_length: usize,
}

/// Reads a GLB as this program writes it. Every number of the mesh is finite, every index has its vertex,
/// and the triangles are whole.
///
/// # Errors
/// What was expected and is not there, in words.
pub(super) fn mesh(glb: &[u8]) -> Result<Mesh, String> {
    let (json, bytes) = chunks(glb)?;
    let document: Document = serde_json::from_slice(json)
        .map_err(|e| format!("expected glTF as this program writes it: {e}"))?;
    let mut mesh = Mesh::default();
    for triangles in document.primitives(bytes.len())? {
        let primitive = document.primitive(triangles, bytes)?;
        let (name, slot) = match document.is_foliage(triangles.material)? {
            true => ("foliage", &mut mesh.foliage),
            false => ("bark", &mut mesh.bark),
        };
        if !slot.indices.is_empty() {
            return Err(format!("expected at most one primitive of {name}"));
        }
        *slot = primitive;
    }
    Ok(mesh)
}

/// The JSON and the binary chunk.
fn chunks(glb: &[u8]) -> Result<(&[u8], &[u8]), String> {
    let header = glb.split_first_chunk().and_then(|(magic, rest)| {
        let (version, rest) = rest.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let is_glb = magic == b"glTF" && u32::from_le_bytes(*version) == 2;
        is_glb.then_some((u32::from_le_bytes(*length), rest))
    });
    let (length, rest) = header.ok_or("expected a GLB of version 2")?;
    if usize::try_from(length) != Ok(glb.len()) {
        let found = glb.len();
        return Err(format!("expected {length} bytes, and there are {found}"));
    }
    let (json, rest) = chunk(rest, b"JSON").ok_or("expected a whole JSON chunk first")?;
    match chunk(rest, b"BIN\0") {
        Some((bytes, [])) => Ok((json, bytes)),
        _ => Err("expected a whole BIN chunk second, and no third".to_owned()),
    }
}

/// The content of the first chunk, if it is of this kind, and what follows.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Option<(&'a [u8], &'a [u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let rest = rest.strip_prefix(kind)?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}

impl Document {
    /// The primitives of the one mesh, if nothing around it moves or doubles it.
    fn primitives(&self, bytes: usize) -> Result<&[Triangles], String> {
        let one_mesh = self.asset.version == "2.0"
            && self.scene == 0
            && matches!(&self.scenes[..], [Scene { nodes }] if nodes == &[0])
            && matches!(&self.nodes[..], [Node { mesh: 0, .. }]);
        let one_buffer =
            matches!(self.buffers[..], [Buffer { byte_length }] if byte_length == bytes);
        if !one_buffer {
            return Err(format!("expected one buffer of {bytes} bytes"));
        }
        match &self.meshes[..] {
            [mesh] if one_mesh => Ok(&mesh.primitives),
            _ => Err("expected glTF 2.0 with one scene of one node with one mesh".to_owned()),
        }
    }

    fn is_foliage(&self, material: usize) -> Result<bool, String> {
        let found = self.materials.get(material).map(|m| {
            let look = (m.alpha_mode.as_deref(), m.alpha_cutoff, m.double_sided);
            (m.name.as_str(), look)
        });
        match found {
            Some(("bark", (None, None, false))) => Ok(false),
            Some(("foliage", (Some("MASK"), Some(ALPHA_CUTOFF), true))) => Ok(true),
            _ => Err(format!(
                "expected material {material} to be `bark`, opaque and one-sided, or `foliage`, masked at \
                 {ALPHA_CUTOFF} and double-sided"
            )),
        }
    }

    fn primitive(&self, triangles: &Triangles, bytes: &[u8]) -> Result<Primitive, String> {
        if triangles.mode != 4 {
            return Err(format!(
                "expected triangles (mode 4), found mode {}",
                triangles.mode
            ));
        }
        let vertices = self.vertices(&triangles.attributes, bytes)?;
        let indices = self.indices(triangles.indices, bytes)?;
        let whole = !indices.is_empty() && indices.len().is_multiple_of(3);
        if !whole {
            let found = indices.len();
            return Err(format!("expected whole triangles, found {found} indices"));
        }
        let count = vertices.len();
        if let Some(index) = indices.iter().find(|&&i| i as usize >= count) {
            return Err(format!("expected indices below {count}, found {index}"));
        }
        let sway = self.sway(&triangles.attributes, count, bytes)?;
        Ok(Primitive {
            vertices,
            indices,
            sway,
            ..Primitive::default()
        })
    }

    /// Vertices, interleaved exactly as they lie in memory; those without a tint end before it.
    fn vertices(&self, attributes: &Attributes, bytes: &[u8]) -> Result<Vec<Vertex>, String> {
        let first = self.accessor(attributes.position)?;
        let stride = if attributes.color_0.is_some() {
            size_of::<Vertex>()
        } else {
            offset_of!(Vertex, tint)
        };
        if let Some(index) = attributes.color_0 {
            let found = self.accessor(index)?;
            let place = (found.buffer_view, found.count, found.byte_offset);
            let form = (found.component_type, found.normalized, found.kind.as_str());
            let offset = offset_of!(Vertex, tint);
            if place != (first.buffer_view, first.count, offset) || form != (U8, true, "VEC4") {
                return Err(format!(
                    "expected COLOR_0 as VEC4 of normalized bytes, {offset} bytes into each vertex"
                ));
            }
        }
        for (name, index, offset, kind) in [
            (
                "POSITION",
                attributes.position,
                offset_of!(Vertex, position),
                "VEC3",
            ),
            (
                "NORMAL",
                attributes.normal,
                offset_of!(Vertex, normal),
                "VEC3",
            ),
            (
                "TANGENT",
                attributes.tangent,
                offset_of!(Vertex, tangent),
                "VEC4",
            ),
            (
                "TEXCOORD_0",
                attributes.texcoord_0,
                offset_of!(Vertex, uv),
                "VEC2",
            ),
        ] {
            let found = self.accessor(index)?;
            let place = (found.buffer_view, found.count, found.byte_offset);
            let form = (found.component_type, found.normalized, found.kind.as_str());
            if place != (first.buffer_view, first.count, offset) || form != (FLOAT, false, kind) {
                return Err(format!(
                    "expected {name} as {kind} of floats, not normalized, {offset} bytes into each vertex"
                ));
            }
        }
        let bytes = self.view(first, ARRAY_BUFFER, Some(stride), stride, bytes)?;
        bytes
            .chunks_exact(stride)
            .map(|chunk| vertex(chunk).ok_or_else(|| "expected finite vertices".to_owned()))
            .collect()
    }

    /// How the vertices sway, interleaved exactly as it lies in memory; empty if the file does not tell.
    fn sway(
        &self,
        attributes: &Attributes,
        count: usize,
        bytes: &[u8],
    ) -> Result<Vec<Sway>, String> {
        let (wind, leaf) = match (attributes.wind, attributes.wind_leaf) {
            (None, None) => return Ok(Vec::new()),
            (Some(wind), Some(leaf)) => (wind, leaf),
            _ => return Err(format!("expected both {WIND} and {WIND_LEAF}, or neither")),
        };
        let first = self.accessor(wind)?;
        for (name, index, offset, component) in [
            (WIND, wind, offset_of!(Sway, wind), U8),
            (WIND_LEAF, leaf, offset_of!(Sway, leaf), I8),
        ] {
            let found = self.accessor(index)?;
            let place = (found.buffer_view, found.count, found.byte_offset);
            let form = (found.component_type, found.normalized, found.kind.as_str());
            if place != (first.buffer_view, count, offset) || form != (component, true, "VEC4") {
                return Err(format!(
                    "expected {name} as VEC4 of normalized bytes, {offset} bytes into each of {count}"
                ));
            }
        }
        let stride = size_of::<Sway>();
        let bytes = self.view(first, ARRAY_BUFFER, Some(stride), stride, bytes)?;
        Ok(bytes
            .chunks_exact(stride)
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }

    fn indices(&self, accessor: usize, bytes: &[u8]) -> Result<Vec<u32>, String> {
        let accessor = self.accessor(accessor)?;
        let plain = accessor.byte_offset == 0 && !accessor.normalized;
        let width = match (accessor.kind.as_str(), accessor.component_type) {
            ("SCALAR", U16) if plain => size_of::<u16>(),
            ("SCALAR", U32) if plain => size_of::<u32>(),
            _ => return Err("expected indices of 16 or 32 bits".to_owned()),
        };
        let bytes = self.view(accessor, ELEMENT_ARRAY_BUFFER, None, width, bytes)?;
        let index = |chunk: &[u8]| chunk.iter().rev().fold(0, |i, &b| i << 8 | u32::from(b));
        Ok(bytes.chunks_exact(width).map(index).collect())
    }

    fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        let found = self.accessors.get(index);
        found.ok_or_else(|| format!("expected an accessor {index}"))
    }

    /// The bytes of the buffer view that `accessor` fills with elements of `width` bytes.
    fn view<'a>(
        &self,
        accessor: &Accessor,
        target: u32,
        stride: Option<usize>,
        width: usize,
        bytes: &'a [u8],
    ) -> Result<&'a [u8], String> {
        let index = accessor.buffer_view;
        let found = self.buffer_views.get(index).filter(|v| {
            (v.buffer, v.target, v.byte_stride) == (0, Some(target), stride)
                && accessor.count.checked_mul(width) == Some(v.byte_length)
        });
        found
            .and_then(|v| bytes.get(v.byte_offset..v.byte_offset.checked_add(v.byte_length)?))
            .ok_or_else(|| {
                let count = accessor.count;
                format!("expected {count} times {width} bytes in buffer view {index}")
            })
    }
}

/// A vertex from its bytes, white where they end before its tint; `None` if a number of it is not finite.
fn vertex(bytes: &[u8]) -> Option<Vertex> {
    let (words, tint) = bytes.split_at(offset_of!(Vertex, tint));
    let mut floats = words.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b));
    let mut all_finite = true;
    let mut number = || {
        let number = floats.next().unwrap_or(f32::NAN);
        all_finite &= number.is_finite();
        number
    };
    let vertex = Vertex {
        position: core::array::from_fn(|_| number()),
        normal: core::array::from_fn(|_| number()),
        tangent: core::array::from_fn(|_| number()),
        uv: core::array::from_fn(|_| number()),
        tint: tint.try_into().unwrap_or(WHITE),
    };
    all_finite.then_some(vertex)
}

#[cfg(test)]
mod tests;

//! One LOD as a GLB: one mesh, at most two primitives (bark: opaque; foliage: alpha-masked, seen from both
//! sides), interleaved vertices, textures by relative URI or inside. Tints go to `COLOR_0`, which all programs
//! multiply into the colour; how vertices sway goes to attributes of its own, which programs that do not know them
//! leave alone.

use super::{BuildError, Options, PackFile, Textures};
use crate::capture::ALPHA_CUTOFF;
use crate::mesh::{Mesh, Primitive, Vertex, WHITE};
use crate::wind::Sway;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Component types and targets of glTF 2.0.
pub(super) const FLOAT: u32 = 5126;
pub(super) const I8: u32 = 5120;
pub(super) const U8: u32 = 5121;
pub(super) const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const ARRAY_BUFFER: u32 = 34962;
pub(super) const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Attributes that tell how a vertex sways.
pub(super) const WIND: &str = "_WIND";
pub(super) const WIND_LEAF: &str = "_WIND_LEAF";
/// Samplers: linear with mips; clamp or repeat.
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33071;
const REPEAT: u32 = 10497;

/// Collects the arrays of a glTF document and the bytes of its one buffer.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    samplers: Vec<Value>,
    materials: Vec<Value>,
    primitives: Vec<Value>,
}

/// The bytes of a GLB; `None` if it would pass 4 GiB.
pub(super) fn glb(
    name: &str,
    mesh: &Mesh,
    textures: &Textures,
    options: Options,
) -> Result<Option<Vec<u8>>, BuildError> {
    let mut document = Document::default();
    document.primitive(&mesh.bark, "bark", &textures.bark, options);
    document.primitive(&mesh.foliage, "foliage", &textures.foliage, options);
    document.finish(name)
}

impl Document {
    fn primitive(
        &mut self,
        primitive: &Primitive,
        name: &str,
        textures: &[PackFile; 3],
        options: Options,
    ) {
        if primitive.indices.is_empty() {
            return;
        }
        let foliage = name == "foliage";
        let material = self.material(name, textures, foliage, options.embed);
        let tinted = primitive.vertices.iter().any(|v| v.tint != WHITE);
        let (bytes, stride) = if tinted {
            let bytes = bytemuck::cast_slice(&primitive.vertices);
            (Cow::Borrowed(bytes), size_of::<Vertex>())
        } else {
            let stride = core::mem::offset_of!(Vertex, tint);
            let untinted = |v: &Vertex| bytemuck::bytes_of(v)[..stride].to_vec();
            let bytes: Vec<u8> = primitive.vertices.iter().flat_map(untinted).collect();
            (Cow::Owned(bytes), stride)
        };
        let target = json!({ "target": ARRAY_BUFFER, "byteStride": stride });
        let vertices = self.view(&bytes, target);
        let count = primitive.vertices.len();
        let mut attribute = |offset: usize, kind: &str, bounds: Option<([f32; 3], [f32; 3])>| {
            let mut accessor = json!({
                "bufferView": vertices, "byteOffset": offset, "componentType": FLOAT,
                "count": count, "type": kind,
            });
            if let Some((min, max)) = bounds {
                accessor["min"] = json!(min);
                accessor["max"] = json!(max);
            }
            self.accessors.push(accessor);
            self.accessors.len() - 1
        };
        let mut attributes = json!({
            "POSITION": attribute(core::mem::offset_of!(Vertex, position), "VEC3", Some(bounds(primitive))),
            "NORMAL": attribute(core::mem::offset_of!(Vertex, normal), "VEC3", None),
            "TANGENT": attribute(core::mem::offset_of!(Vertex, tangent), "VEC4", None),
            "TEXCOORD_0": attribute(core::mem::offset_of!(Vertex, uv), "VEC2", None),
        });
        if tinted {
            self.accessors.push(json!({
                "bufferView": vertices, "byteOffset": core::mem::offset_of!(Vertex, tint),
                "componentType": U8, "normalized": true, "count": count, "type": "VEC4",
            }));
            attributes["COLOR_0"] = json!(self.accessors.len() - 1);
        }
        if !options.no_wind && !primitive.sway.is_empty() {
            self.sway(&primitive.sway, &mut attributes);
        }
        let indices = self.indices(primitive);
        self.primitives.push(json!({
            "attributes": attributes, "indices": indices, "material": material, "mode": 4,
        }));
    }

    /// How vertices sway, as two attributes of four normalised bytes.
    fn sway(&mut self, sway: &[Sway], attributes: &mut Value) {
        let view = self.view(
            bytemuck::cast_slice(sway),
            json!({ "target": ARRAY_BUFFER, "byteStride": size_of::<Sway>() }),
        );
        for (name, offset, kind) in [
            (WIND, core::mem::offset_of!(Sway, wind), U8),
            (WIND_LEAF, core::mem::offset_of!(Sway, leaf), I8),
        ] {
            self.accessors.push(json!({
                "bufferView": view, "byteOffset": offset, "componentType": kind, "normalized": true,
                "count": sway.len(), "type": "VEC4",
            }));
            attributes[name] = json!(self.accessors.len() - 1);
        }
    }

    /// Indices in two bytes where they fit; 65535 itself is reserved as a restart value.
    fn indices(&mut self, primitive: &Primitive) -> usize {
        let target = json!({ "target": ELEMENT_ARRAY_BUFFER });
        let narrow: Option<Vec<u16>> = if primitive.vertices.len() < usize::from(u16::MAX) {
            primitive
                .indices
                .iter()
                .map(|&i| u16::try_from(i).ok())
                .collect()
        } else {
            None
        };
        let (view, kind) = match narrow {
            Some(narrow) => (self.view(bytemuck::cast_slice(&narrow), target), U16),
            None => (
                self.view(bytemuck::cast_slice(&primitive.indices), target),
                U32,
            ),
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": kind,
            "count": primitive.indices.len(), "type": "SCALAR",
        }));
        self.accessors.len() - 1
    }

    fn material(
        &mut self,
        name: &str,
        textures: &[PackFile; 3],
        foliage: bool,
        embed: bool,
    ) -> usize {
        let wrap = if foliage { CLAMP_TO_EDGE } else { REPEAT };
        self.samplers.push(json!({
            "magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR, "wrapS": wrap, "wrapT": wrap,
        }));
        let sampler = self.samplers.len() - 1;
        let [albedo, normal, orm] =
            core::array::from_fn(|i| self.texture(&textures[i], sampler, embed));
        let mut material = json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorTexture": { "index": albedo },
                "metallicRoughnessTexture": { "index": orm },
                "metallicFactor": 0.0,
            },
            "normalTexture": { "index": normal },
            "occlusionTexture": { "index": orm },
        });
        if foliage {
            material["alphaMode"] = json!("MASK");
            material["alphaCutoff"] = json!(ALPHA_CUTOFF);
            material["doubleSided"] = json!(true);
        }
        self.materials.push(material);
        self.materials.len() - 1
    }

    fn texture(&mut self, file: &PackFile, sampler: usize, embed: bool) -> usize {
        let stem = file
            .path
            .rsplit('/')
            .next()
            .unwrap_or(&file.path)
            .trim_end_matches(".png");
        let image = if embed {
            let view = self.view(&file.bytes, json!({}));
            json!({ "name": stem, "bufferView": view, "mimeType": "image/png" })
        } else {
            json!({ "name": stem, "uri": file.path })
        };
        self.images.push(image);
        self.textures
            .push(json!({ "sampler": sampler, "source": self.images.len() - 1 }));
        self.textures.len() - 1
    }

    /// Appends bytes as a buffer view, aligned to four.
    fn view(&mut self, bytes: &[u8], mut view: Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        view["buffer"] = json!(0);
        view["byteOffset"] = json!(self.bytes.len());
        view["byteLength"] = json!(bytes.len());
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn finish(mut self, name: &str) -> Result<Option<Vec<u8>>, BuildError> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let root = json!({
            "asset": { "version": "2.0", "generator": concat!("pleach ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "name": name, "mesh": 0 }],
            "meshes": [{ "name": name, "primitives": self.primitives }],
            "materials": self.materials,
            "textures": self.textures,
            "images": self.images,
            "samplers": self.samplers,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": self.bytes.len() }],
        });
        let mut text = serde_json::to_vec(&root)?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        let (Ok(total), Ok(json_length), Ok(bin_length)) = (
            u32::try_from(total),
            u32::try_from(text.len()),
            u32::try_from(self.bytes.len()),
        ) else {
            return Ok(None);
        };
        let mut glb = Vec::with_capacity(total as usize);
        glb.extend(b"glTF");
        [2, total, json_length]
            .iter()
            .for_each(|word: &u32| glb.extend(word.to_le_bytes()));
        glb.extend(b"JSON");
        glb.extend(&text);
        glb.extend(bin_length.to_le_bytes());
        glb.extend(b"BIN\0");
        glb.extend(&self.bytes);
        Ok(Some(glb))
    }
}

/// Exact bounds, as the format demands of positions.
fn bounds(primitive: &Primitive) -> ([f32; 3], [f32; 3]) {
    let mut min = [f32::INFINITY; 3];
    let mut max = [f32::NEG_INFINITY; 3];
    for vertex in &primitive.vertices {
        for axis in 0..3 {
            min[axis] = min[axis].min(vertex.position[axis]);
            max[axis] = max[axis].max(vertex.position[axis]);
        }
    }
    (min, max)
}

//! `pack.json`: what a pack holds, in words that need no SDK. Field names are a contract.

use super::{BuildError, Options, PackFile};
use crate::asset::{Asked, AssetLod, LevelSummary, TreeAsset, level_summaries};
use crate::mesh::card::{Relief, UvRect};
use crate::species::schema::LodSelector;
use crate::tree::Tree;
use crate::wind::{REFERENCE_SPEED_M_S, Rig};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Value of the manifest's `format`.
pub const FORMAT: &str = "pleach-pack";

/// Version of the manifest that this program writes and reads.
pub const VERSION: u32 = 1;

/// The whole manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// Program and version that wrote the pack.
    pub generator: String,
    /// The graphics adapter that drew captures and shadows (`--baker gpu`): its textures, and what was measured with
    /// them, equal the processor's within a tolerance only. Left out where the processor drew: then the same script
    /// and seed give the same bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baker: Option<String>,
    /// What grew.
    pub species: SpeciesEntry,
    /// Seed.
    pub seed: u64,
    /// Always `m`.
    pub units: String,
    /// Always `+Y`.
    pub up: String,
    /// Bounds of all LODs, metres.
    pub bounds: BoundsEntry,
    /// Levels, the first first.
    pub levels: Vec<LevelEntry>,
    /// Number of captures from two sides.
    pub captures: usize,
    /// Number of captures of fitted planes; 0 in packs that have none, or were written before there were any.
    #[serde(default)]
    pub plane_captures: usize,
    /// What was asked of the chain of LODs; null in packs that do not tell.
    #[serde(default)]
    pub asked: Option<AskedEntry>,
    /// LODs, the finest first.
    pub lods: Vec<LodEntry>,
    /// Textures by role.
    pub textures: TexturesEntry,
    /// Ground shadows.
    pub shadows: ShadowsEntry,
    /// How `_WIND` and `_WIND_LEAF` are to be read; null in packs without them.
    #[serde(default)]
    pub wind: Option<WindEntry>,
    /// Every file of the pack but the manifest.
    pub files: Vec<FileEntry>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Names of a species.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeciesEntry {
    /// Common name.
    pub name: String,
    /// Botanical name.
    pub latin: String,
    /// File-name form.
    pub slug: String,
}

/// An axis-aligned box, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoundsEntry {
    /// Smallest corner.
    pub min: [f32; 3],
    /// Largest corner.
    pub max: [f32; 3],
}

/// One level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelEntry {
    /// Name.
    pub name: String,
    /// `stool`, `branch` or `leaf`.
    pub kind: String,
    /// Prototypes.
    pub prototypes: usize,
    /// Nodes.
    pub nodes: u64,
}

/// What was asked of a chain of LODs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AskedEntry {
    /// Triangle budgets, falling; some may have got no LOD.
    pub budgets: Vec<u64>,
    /// True if full detail leads.
    pub full: bool,
    /// `cut` or `levels`.
    pub selector: String,
    /// True if each LOD's quads were scaled so that it covers as much as full detail.
    pub calibrate: bool,
}

impl From<&Asked> for AskedEntry {
    fn from(asked: &Asked) -> Self {
        let selector = match asked.selector {
            LodSelector::Cut => "cut",
            LodSelector::Levels => "levels",
        };
        Self {
            budgets: asked.budgets.clone(),
            full: asked.full,
            selector: selector.to_owned(),
            calibrate: asked.calibrate,
        }
    }
}

/// One LOD.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LodEntry {
    /// Position in the chain, 0 the finest.
    pub index: usize,
    /// File.
    pub file: String,
    /// Budget; null for full detail.
    pub budget: Option<u64>,
    /// Triangles.
    pub triangles: u64,
    /// Triangles of the bark primitive.
    pub branches_triangles: u64,
    /// Triangles of the foliage primitive.
    pub foliage_triangles: u64,
    /// Edge of the blocks, metres, over which the LOD's coverage is right to within a tenth (mean over the
    /// calibration views); rises along the chain.
    pub error_m: f32,
    /// Part of the picture's height that the tree may fill while the LOD is shown: there `error_m` is 6 pixels
    /// of a picture 1080 high. At most 1; falls along the chain.
    pub screen_size: f32,
    /// Factor on the LOD's quads at which it covers as much as full detail; 1 if it was not calibrated, or has
    /// no such quads.
    #[serde(default = "one")]
    pub scale: f32,
    /// Intersection over union of its silhouette and full detail's, 0..=1, mean over the calibration views; null
    /// in packs written before it was measured.
    #[serde(default)]
    pub silhouette_iou: Option<f32>,
    /// Covered area over full detail's, mean over the calibration views; null in packs written before it was
    /// measured.
    #[serde(default)]
    pub coverage: Option<f32>,
    /// In which form each level is drawn.
    pub state: String,
}

/// The scale of what is not scaled.
const fn one() -> f32 {
    1.0
}

impl LevelEntry {
    /// Describes all levels of a tree, the first first.
    pub(crate) fn all(tree: &Tree) -> Vec<Self> {
        let one = |level: LevelSummary| Self {
            name: level.name,
            kind: level.kind.to_owned(),
            prototypes: level.prototypes,
            nodes: level.nodes,
        };
        level_summaries(tree).into_iter().map(one).collect()
    }
}

impl LodEntry {
    /// Describes all LODs of a tree, the finest first.
    pub(crate) fn all(asset: &TreeAsset) -> Vec<Self> {
        let lods = asset.lods.iter().enumerate();
        lods.map(|(index, lod)| Self::of(asset, index, lod))
            .collect()
    }

    fn of(asset: &TreeAsset, index: usize, lod: &AssetLod) -> Self {
        Self {
            index,
            file: format!("{}_LOD{index}.glb", asset.slug),
            budget: lod.budget,
            triangles: lod.triangles.total(),
            branches_triangles: lod.triangles.branches,
            foliage_triangles: lod.triangles.foliage,
            error_m: lod.error_m,
            screen_size: lod.screen_size,
            scale: lod.scale,
            silhouette_iou: Some(lod.iou),
            coverage: Some(lod.coverage),
            state: lod.state.clone(),
        }
    }
}

/// Textures by role. Foliage alpha is coverage; normals are +Y up; `orm` is occlusion, roughness,
/// metalness; `extra` is translucency, depth offset (128 is none), coverage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TexturesEntry {
    /// Bark.
    pub bark: SurfaceEntry,
    /// The foliage atlas.
    pub foliage: SurfaceEntry,
}

/// Texture files of one material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SurfaceEntry {
    /// sRGB, with alpha for foliage.
    pub albedo: String,
    /// Tangent-space normals.
    pub normal: String,
    /// Occlusion, roughness, metalness.
    pub orm: String,
    /// Translucency, depth offset (see [`CaptureEntry`]), coverage; foliage only.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub extra: Option<String>,
    /// Edge lengths, texels.
    pub size: [u32; 2],
    /// Coverage-preserving mips of the albedo, from half size downward.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub mips: Vec<String>,
    /// What the depth offsets of [`extra`](Self::extra) are parts of; none in packs that do not tell.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub captures: Vec<CaptureEntry>,
}

/// One picture of a capture in the foliage atlas. Where a quad shows it, the surface that was captured lies
/// `(depth - 128) / 127.5` times a length before the quad on the side that is seen, `depth` being the green byte of
/// `extra`. The length is the longer side that the whole picture would have on that quad: the quad's metres for a step
/// of u or v, times the picture's edge in u or v. It is right to a 255th of that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaptureEntry {
    /// Left, top, right and bottom edge, 0..=1 of the atlas.
    pub uv: [f32; 4],
    /// That length on a quad as it was captured, metres; quads of larger or smaller nodes have more or less.
    pub longer_m: f32,
}

impl From<&Relief> for CaptureEntry {
    fn from(&Relief { uv, longer }: &Relief) -> Self {
        Self {
            uv: [uv.u0, uv.v0, uv.u1, uv.v1],
            longer_m: longer,
        }
    }
}

impl From<&CaptureEntry> for Relief {
    fn from(&CaptureEntry { uv, longer_m }: &CaptureEntry) -> Self {
        let [u0, v0, u1, v1] = uv;
        Self {
            uv: UvRect { u0, v0, u1, v1 },
            longer: longer_m,
        }
    }
}

/// The shadow atlas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShadowsEntry {
    /// File: 8-bit grey, 255 full shadow. The first four texels of each map are not shadow: they hold
    /// `trunk_base` as two little-endian u16.
    pub file: String,
    /// The nine maps.
    pub maps: Vec<ShadowMapEntry>,
}

/// One shadow map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShadowMapEntry {
    /// Unit vector toward the light.
    pub direction: [f32; 3],
    /// x, y, width, height in the file, texels.
    pub rect: [u32; 4],
    /// Texel of the trunk base's centre in the map.
    pub trunk_base: [u16; 2],
    /// Ground covered by the map, metres: smallest x, smallest z, largest x, largest z.
    pub ground_rect_m: [f32; 4],
}

/// How the wind attributes of all GLBs of a pack are to be read. `_WIND` (four unsigned normalised bytes) holds
/// the weights of three bands (the first branch level, the second, all deeper ones) and the phase of the limb as a
/// part of a turn; `_WIND_LEAF` (four signed normalised bytes) the way from a leaf's hinge to the vertex and the
/// leaf's phase in half turns, all zero for what does not turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindEntry {
    /// Speed of the wind at which the other figures hold, metres a second.
    pub reference_speed_m_s: f32,
    /// By band: how far a vertex of weight 1 leans in the mean, metres.
    pub amplitude_m: [f32; 3],
    /// By band: how often branches swing a second.
    pub frequency_hz: [f32; 3],
    /// Distance from its hinge that 1 stands for in a leaf's offset, metres.
    pub leaf_reach_m: f32,
    /// Largest turn of leaves about the axis of view, radians.
    pub leaf_angle: f32,
}

impl From<&Rig> for WindEntry {
    fn from(rig: &Rig) -> Self {
        Self {
            reference_speed_m_s: REFERENCE_SPEED_M_S,
            amplitude_m: rig.amplitude_m,
            frequency_hz: rig.frequency_hz,
            leaf_reach_m: rig.leaf_reach_m,
            leaf_angle: rig.leaf_angle,
        }
    }
}

impl From<&WindEntry> for Rig {
    fn from(entry: &WindEntry) -> Self {
        Self {
            amplitude_m: entry.amplitude_m,
            leaf_reach_m: entry.leaf_reach_m,
            frequency_hz: entry.frequency_hz,
            leaf_angle: entry.leaf_angle,
        }
    }
}

/// One file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileEntry {
    /// Path in the pack.
    pub path: String,
    /// Size.
    pub bytes: u64,
    /// SHA-256 of the content, lower-case hexadecimal.
    pub sha256: String,
}

impl Manifest {
    /// Describes an asset and its files.
    pub(super) fn of(asset: &TreeAsset, files: &[PackFile], options: Options) -> Self {
        let file = |f: &PackFile| FileEntry {
            path: f.path.clone(),
            bytes: f.bytes.len() as u64,
            sha256: sha256(&f.bytes),
        };
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            generator: concat!("pleach ", env!("CARGO_PKG_VERSION")).to_owned(),
            baker: asset.baker.clone(),
            species: SpeciesEntry {
                name: asset.name.clone(),
                latin: asset.latin.clone(),
                slug: asset.slug.clone(),
            },
            seed: asset.seed,
            units: "m".to_owned(),
            up: "+Y".to_owned(),
            bounds: BoundsEntry {
                min: asset.bounds.min.to_array(),
                max: asset.bounds.max.to_array(),
            },
            levels: LevelEntry::all(&asset.tree),
            captures: asset.captures,
            plane_captures: asset.plane_captures,
            asked: Some((&asset.asked).into()),
            lods: LodEntry::all(asset),
            textures: textures(asset, files),
            shadows: shadows(asset),
            wind: (!options.no_wind).then(|| (&asset.wind).into()),
            files: files.iter().map(file).collect(),
            warnings: asset.warnings.iter().map(ToString::to_string).collect(),
        }
    }

    /// Pretty JSON with a final line feed.
    pub(super) fn to_json(&self) -> Result<Vec<u8>, BuildError> {
        let mut bytes = serde_json::to_vec_pretty(self)?;
        bytes.push(b'\n');
        Ok(bytes)
    }
}

fn textures(asset: &TreeAsset, files: &[PackFile]) -> TexturesEntry {
    let path = |name: &str| format!("textures/{name}.png");
    let mips = files
        .iter()
        .map(|f| &f.path)
        .filter(|p| p.starts_with("textures/mips/"));
    let size = |image: &crate::image::Image<[u8; 4]>| [image.width(), image.height()];
    TexturesEntry {
        bark: SurfaceEntry {
            albedo: path("bark_albedo"),
            normal: path("bark_normal"),
            orm: path("bark_orm"),
            extra: None,
            size: size(&asset.bark.albedo),
            mips: Vec::new(),
            captures: Vec::new(),
        },
        foliage: SurfaceEntry {
            albedo: path("foliage_albedo"),
            normal: path("foliage_normal"),
            orm: path("foliage_orm"),
            extra: Some(path("foliage_extra")),
            size: size(&asset.foliage.albedo),
            mips: mips.cloned().collect(),
            captures: captures(&asset.reliefs),
        },
    }
}

/// Each picture once: levels that share one may show it at several sizes.
fn captures(reliefs: &[Relief]) -> Vec<CaptureEntry> {
    let mut entries: Vec<CaptureEntry> = Vec::new();
    for relief in reliefs {
        let entry = CaptureEntry::from(relief);
        if entries.iter().all(|other| other.uv != entry.uv) {
            entries.push(entry);
        }
    }
    entries
}

fn shadows(asset: &TreeAsset) -> ShadowsEntry {
    let (_, rects) = asset.shadows.atlas();
    let maps = asset
        .shadows
        .maps
        .iter()
        .zip(rects)
        .map(|(map, rect)| ShadowMapEntry {
            direction: map.direction.to_array(),
            rect: [rect.x0, rect.y0, rect.x1 - rect.x0, rect.y1 - rect.y0],
            trunk_base: map.trunk_base,
            ground_rect_m: map.ground_rect_m,
        });
    ShadowsEntry {
        file: "textures/shadows.png".to_owned(),
        maps: maps.collect(),
    }
}

/// SHA-256 in lower-case hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    use core::fmt::Write as _;
    Sha256::digest(bytes)
        .iter()
        .fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

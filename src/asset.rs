//! A finished tree: everything that an exporter or a renderer needs, and nothing that it must compute.

use crate::image::atlas::Rect;
use crate::image::{Image, Texel, mips, steady};
use crate::impostor::cross_quad::CrossQuads;
use crate::lod::{State, Triangles};
use crate::math::{Bounds, Vec3, byte_from_unit, linear_from_srgb};
use crate::mesh::card::{Pane, Relief};
use crate::mesh::{Coat, Flattener, Mesh, TooLarge};
use crate::report::Warning;
use crate::shadow::Shadows;
use crate::species::schema::LodSelector;
use crate::tree::{Kind, Tree};
use crate::wind::Rig;
use rayon::prelude::*;

/// A tree with its LODs, textures and shadows.
#[derive(Clone, Debug)]
pub struct TreeAsset {
    /// Common name.
    pub name: String,
    /// Botanical name; may be empty.
    pub latin: String,
    /// File-name form of the name.
    pub slug: String,
    /// Seed it was grown from.
    pub seed: u64,
    /// Files that the script names, by their path beside it: with them, the script makes the tree again.
    pub sources: Vec<(String, Vec<u8>)>,
    /// The graph.
    pub tree: Tree,
    /// The adapter that drew captures and shadows; `None` if the processor did, whose bytes are the same everywhere.
    pub baker: Option<String>,
    /// Number of captures from two sides.
    pub captures: usize,
    /// Number of captures of fitted planes.
    pub plane_captures: usize,
    /// What was asked of the chain of LODs.
    pub asked: Asked,
    /// LODs from the finest to the coarsest.
    pub lods: Vec<AssetLod>,
    /// Foliage atlas.
    pub foliage: Surface,
    /// Bark texture; repeats.
    pub bark: Surface,
    /// Part of the foliage atlas of each view of each capture, then of each leaf kind.
    pub rects: Vec<Rect>,
    /// Captures in the atlas with their real sizes.
    pub reliefs: Vec<Relief>,
    /// By leaf kind: its picture in the atlas.
    pub leaves: Vec<Pane>,
    /// How bark lies on its branches.
    pub coat: Coat,
    /// For each sub-tree that has captures, what was done to their colours.
    pub tones: Vec<Tone>,
    /// Nine soft ground shadows.
    pub shadows: Shadows,
    /// Bounds of all LODs, metres.
    pub bounds: Bounds,
    /// How the sway of all meshes is to be read.
    pub wind: Rig,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// Factors on the captures of one sub-tree, with which LODs are as light as full detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// On their occlusion, 0.2..=1.5: the rest of the crown adds shade.
    pub shade: f32,
    /// On their linear albedo, 0.75..=1.3: one normal is lit unlike the leaves that it stands for.
    pub tint: [f32; 3],
}

/// What is asked of a chain of LODs: with the same script and seed it gives the same chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// Triangle budgets, falling.
    pub budgets: Vec<u64>,
    /// True to lead with full detail.
    pub full: bool,
    /// How LODs are chosen under their budgets.
    pub selector: LodSelector,
    /// True to scale each LOD's quads so that it covers as much as full detail.
    pub calibrate: bool,
}

/// One LOD, ready to be drawn or written.
#[derive(Clone, Debug)]
pub struct AssetLod {
    /// Budget that it meets; `None` for full detail.
    pub budget: Option<u64>,
    /// Forms of the levels, in words.
    pub state: String,
    /// Triangles by material; what the mesh holds.
    pub triangles: Triangles,
    /// Edge of the blocks over which its coverage is right to a tenth, metres; rises along the chain.
    pub error_m: f32,
    /// Part of the picture's height up to which it may be shown; falls along the chain.
    pub screen_size: f32,
    /// Factor on its quads at which it covers as much as full detail; 1 if not calibrated.
    pub scale: f32,
    /// Intersection over union of its silhouette and full detail's, mean over the calibration views.
    pub iou: f32,
    /// Covered area over full detail's, mean over the calibration views.
    pub coverage: f32,
    /// Geometry, with uv into the two surfaces, and with sway.
    pub mesh: Mesh,
}

/// What a tree is drawn from, whether it was just grown or read from a pack's files.
#[derive(Clone, Debug)]
pub struct Drawable<'a> {
    /// LODs from the finest to the coarsest, at least one, each with the part of the picture's height up to
    /// which it may be shown.
    pub lods: Vec<(&'a Mesh, f32)>,
    /// Foliage atlas.
    pub foliage: &'a Surface,
    /// Bark texture; repeats.
    pub bark: &'a Surface,
    /// Captures in the atlas with their real sizes; none where they are not known.
    pub reliefs: &'a [Relief],
    /// Nine soft ground shadows.
    pub shadows: &'a Shadows,
    /// How the sway of its meshes is to be read.
    pub wind: Rig,
}

impl TreeAsset {
    /// What it is drawn from.
    #[must_use]
    pub fn drawable(&self) -> Drawable<'_> {
        Drawable {
            lods: self.lods.iter().map(|l| (&l.mesh, l.screen_size)).collect(),
            foliage: &self.foliage,
            bark: &self.bark,
            reliefs: &self.reliefs,
            shadows: &self.shadows,
            wind: self.wind,
        }
    }

    /// Every branch at its finest, every leaf a card, with uv into the two surfaces and without sway: what LODs are
    /// compared with where none of them is that fine.
    ///
    /// # Errors
    /// If 32-bit indices cannot address it.
    pub fn full_detail(&self) -> Result<Mesh, TooLarge> {
        let quads = CrossQuads::none(&self.tree, self.leaves.clone());
        let form = quads.form(&self.tree, &State::full(&self.tree), self.coat);
        Flattener::new(&self.tree, &form).tree()
    }
}

/// A textured surface in the bytes that files hold.
#[derive(Clone, Debug)]
pub struct Surface {
    /// sRGB colour and linear alpha. A foliage atlas has [steady alpha](crate::image::steady), which is at or
    /// above the cutoff where there is something, and keeps its coverage in plain mips.
    pub albedo: Image<[u8; 4]>,
    /// Tangent-space normal, +Y up the image.
    pub normal: Image<[u8; 3]>,
    /// Occlusion, roughness, metalness.
    pub orm: Image<[u8; 3]>,
    /// Translucency, depth offset (128 is none), coverage.
    pub extra: Image<[u8; 3]>,
}

impl Surface {
    /// Quantises texels.
    #[must_use]
    pub fn of(texels: &Image<Texel>) -> Self {
        let (albedo, (normal, (orm, extra))) = rayon::join(
            || texels.map(Texel::albedo_bytes),
            || {
                (
                    texels.map(Texel::normal_bytes),
                    (texels.map(Texel::orm_bytes), texels.map(Texel::extra_bytes)),
                )
            },
        );
        Self {
            albedo,
            normal,
            orm,
            extra,
        }
    }

    /// Quantises the texels of a foliage atlas, with alpha that is steady over the mips of each of its parts.
    #[must_use]
    pub fn of_atlas(texels: &Image<Texel>, parts: &[Rect]) -> Self {
        let (mut surface, alpha) =
            rayon::join(|| Self::of(texels), || steady::alpha(texels, parts));
        let colours = surface.albedo.texels_mut().iter_mut();
        for (colour, &alpha) in colours.zip(alpha.texels()) {
            colour[3] = alpha;
        }
        surface
    }

    /// A rectangle of it, which must lie inside.
    #[must_use]
    pub fn part(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        Self {
            albedo: self.albedo.part(x, y, width, height),
            normal: self.normal.part(x, y, width, height),
            orm: self.orm.part(x, y, width, height),
            extra: self.extra.part(x, y, width, height),
        }
    }

    /// The texels that the bytes stand for; their alpha is the coverage.
    #[must_use]
    pub fn texels(&self) -> Image<Texel> {
        let linear: Vec<f32> = (0..=255).map(linear_from_srgb).collect();
        let unit = |byte: u8| f32::from(byte) / 255.0;
        let texels = self
            .albedo
            .texels()
            .par_iter()
            .enumerate()
            .map(|(i, &[r, g, b, _])| {
                let [nx, ny, nz] = self.normal.texels()[i].map(|n| unit(n) * 2.0 - 1.0);
                let [occlusion, roughness, _] = self.orm.texels()[i].map(unit);
                let [translucency, depth, coverage] = self.extra.texels()[i].map(unit);
                Texel {
                    albedo: [r, g, b].map(|c| linear[usize::from(c)]),
                    alpha: coverage,
                    normal: Vec3::new(nx, ny, nz).normalize_or(Vec3::Z).to_array(),
                    occlusion,
                    roughness,
                    translucency,
                    depth: depth * 2.0 - 1.0,
                }
            });
        Image::from_texels(self.albedo.width(), self.albedo.height(), texels.collect())
    }

    /// This and at most `levels - 1` smaller mips. Colours and the rest are averaged by coverage, alpha plainly, as
    /// other programs do.
    #[must_use]
    pub fn mips(&self, levels: usize) -> Vec<Self> {
        let mut alpha = self.albedo.map(|&[.., a]| f32::from(a) / 255.0);
        let mut texels = self.texels();
        let mut mips = vec![self.clone()];
        while mips.len() < levels {
            texels = mips::halved(&texels);
            alpha = mips::halved_by(&alpha, |a| a.into_iter().sum::<f32>() * 0.25);
            let mut mip = Self::of(&texels);
            for (colour, &alpha) in mip.albedo.texels_mut().iter_mut().zip(alpha.texels()) {
                colour[3] = byte_from_unit(alpha);
            }
            mips.push(mip);
        }
        mips
    }

    /// Mips of the albedo from half size downward, with the coverage of the base.
    #[must_use]
    pub fn albedo_mips(&self) -> Vec<Image<[u8; 4]>> {
        let levels = self.albedo.width().max(self.albedo.height()).ilog2() as usize + 1;
        let mips = self.mips(levels).into_iter().skip(1);
        mips.map(|mip| mip.albedo).collect()
    }
}

/// One line of a level summary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelSummary {
    /// Level name.
    pub name: String,
    /// `stool`, `branch` or `leaf`.
    pub kind: &'static str,
    /// Prototypes.
    pub prototypes: usize,
    /// Nodes of all prototypes.
    pub nodes: u64,
}

/// Levels with their node counts, from the first level outward.
#[must_use]
pub fn level_summaries(tree: &Tree) -> Vec<LevelSummary> {
    let summary = |(level, nodes): (&crate::tree::TreeLevel, &Vec<u64>)| LevelSummary {
        name: level.name.clone(),
        kind: match level.kind {
            Kind::Stool => "stool",
            Kind::Branch => "branch",
            Kind::Leaf => "leaf",
        },
        prototypes: level.prototypes.len(),
        nodes: nodes.iter().sum(),
    };
    tree.levels.iter().zip(&tree.nodes()).map(summary).collect()
}

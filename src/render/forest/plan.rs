//! What the passes over a forest are told: bins, models and the frame, as plain data. The structs mirror those of
//! `shaders/cull.wgsl`, member by member.

use super::{ForestTree, Settings};
use crate::gpu::GpuError;
use crate::math::{Vec3, float};
use crate::render::camera::{Camera, Lens};
use bytemuck::{Pod, Zeroable};

/// Trees that one group of threads works on.
pub(super) const GROUP: u32 = 256;
/// Models that a forest may be of.
pub(super) const MAX_MODELS: usize = 32;
/// LODs that a model may have in a forest.
pub(super) const MAX_LODS: usize = 16;
/// Bins of a forest; the number after it means none.
pub(super) const MAX_BINS: usize = 255;
/// Trees of a forest: as many as a list's entries can number, and fewer than fill a storage buffer of 128 MiB.
pub const MAX_TREES: usize = 1 << 22;

/// `Cull` of `cull.wgsl`, which says what each member means.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Cull {
    pub planes: [[f32; 4]; 5],
    pub eye: [f32; 4],
    pub sight: [f32; 4],
    pub shade: [f32; 4],
    pub counts: [u32; 4],
    pub orders: [u32; 4],
}

/// `Kind` of `cull.wgsl`: a model.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Kind {
    pub shape: [f32; 4],
    pub bins: [u32; 4],
    pub casts: [u32; 4],
    pub switches: [f32; 16],
}

/// What a forest needs to know of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Stature {
    /// Height of the middle of a sphere about the trunk's axis that holds all LODs, and its radius, metres.
    pub sphere: [f32; 2],
    /// Height of the tree, metres.
    pub height: f32,
    /// Radius of the ground that its baked shadows cover, metres.
    pub ground: f32,
    /// For each LOD, the part of the picture's height up to which it may be shown, and how far the shadow map may
    /// shade it.
    pub lods: Vec<(f32, f32)>,
}

/// What the trees of a bin are drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Trees that are seen.
    Draw,
    /// Depth in the shadow map.
    Cast,
    /// Baked shadows on the ground.
    Ground,
}

/// A list of trees that one draw call a material draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bin {
    /// What for.
    pub of: Use,
    /// Index of the model.
    pub model: usize,
    /// Index of its LOD.
    pub lod: usize,
}

/// Bins and models of a forest.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// All bins: first those that are drawn, from the finest LODs on.
    pub bins: Vec<Bin>,
    /// For each model, what the passes read.
    pub kinds: Vec<Kind>,
}

/// Why trees cannot make a forest.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ForestError {
    /// More than fit.
    #[error("a forest of {trees} trees; at most {MAX_TREES} fit")]
    TooManyTrees {
        /// Trees asked for.
        trees: usize,
    },
    /// More models or LODs than the passes hold.
    #[error(
        "a forest of {models} models with {lods} LODs in all; at most {MAX_MODELS} models with {MAX_LODS} LODs each \
         and some {MAX_BINS} in all fit, twice those whose shadows are mapped; use fewer species or shorter chains"
    )]
    TooManyLods {
        /// Models.
        models: usize,
        /// LODs of all.
        lods: usize,
    },
    /// A tree of a model that is not on the device.
    #[error("tree {tree} is of model {model}, and there are {models}")]
    NoSuchModel {
        /// Index of the tree.
        tree: usize,
        /// Index of its model.
        model: u32,
        /// Models there are.
        models: usize,
    },
    /// The device cannot take it.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl Plan {
    /// Bins for models.
    ///
    /// # Errors
    /// [`ForestError::TooManyLods`].
    pub fn of(models: &[Stature]) -> Result<Self, ForestError> {
        let lods = models.iter().map(|m| m.lods.len()).sum();
        let refused = ForestError::TooManyLods {
            models: models.len(),
            lods,
        };
        if models.len() > MAX_MODELS || models.iter().any(|m| m.lods.len() > MAX_LODS) {
            return Err(refused);
        }
        let mut bins = Vec::new();
        let mut kinds = Vec::new();
        for (model, stature) in models.iter().enumerate() {
            let first = index(bins.len());
            let of_lods = |of| (0..stature.lods.len()).map(move |lod| Bin { of, model, lod });
            bins.extend(of_lods(Use::Draw));
            let casts = index(bins.len());
            bins.extend(of_lods(Use::Cast).filter(|b| stature.lods[b.lod].1 > 0.0));
            let ground = index(bins.len());
            bins.push(Bin {
                of: Use::Ground,
                model,
                lod: 0,
            });
            let crisp = |mask: u32, (lod, &(_, crisp)): (usize, &(f32, f32))| {
                mask | (u32::from(crisp > 0.0) << lod)
            };
            let mask = stature.lods.iter().enumerate().fold(0, crisp);
            let mut switches = [0.0; MAX_LODS];
            for (switch, &(size, _)) in switches.iter_mut().zip(&stature.lods) {
                *switch = 1.0 / (size * size).max(1e-12);
            }
            let [middle, radius] = stature.sphere;
            kinds.push(Kind {
                shape: [middle, radius, stature.height, stature.ground],
                bins: [first, index(stature.lods.len()), ground, mask],
                casts: [casts, 0, 0, 0],
                switches,
            });
        }
        if bins.len() > MAX_BINS {
            return Err(refused);
        }
        Ok(Self { bins, kinds })
    }

    /// Refuses trees that do not fit.
    pub(super) fn check(&self, trees: &[ForestTree]) -> Result<(), ForestError> {
        if trees.len() > MAX_TREES {
            return Err(ForestError::TooManyTrees { trees: trees.len() });
        }
        let models = self.kinds.len();
        let stray = trees.iter().position(|t| t.model as usize >= models);
        stray.map_or(Ok(()), |tree| {
            Err(ForestError::NoSuchModel {
                tree,
                model: trees[tree].model,
                models,
            })
        })
    }

    /// What the passes are told of a frame.
    #[must_use]
    pub fn frame(&self, trees: usize, view: &View<'_>) -> Cull {
        let View {
            camera,
            size: [width, height],
            settings,
            shade,
            stretch,
        } = *view;
        let [w, h] = [width.max(1), height.max(1)].map(float);
        let (slope, flat) = match camera.lens {
            Lens::Perspective(angle) => {
                let twice = 2.0 * libm::tanf(angle * 0.5);
                (twice * twice, 0.0)
            }
            Lens::Orthographic(half) => (0.0, 4.0 * half * half),
        };
        // A forest shown in more detail is one whose trees are taken to be larger.
        let detail = 1.0 / settings.detail.max(1e-3);
        let room = 1.0 + settings.hysteresis.max(0.0);
        let pixel = settings.ground_pixels.max(0.0) / h;
        let detailed = [slope, flat].map(|x| x * detail * detail);
        let up = camera.eye.y;
        let trees = index(trees);
        Cull {
            planes: planes(camera, w / h),
            eye: camera.eye.extend(up * up).to_array(),
            sight: [
                detailed[0],
                detailed[1],
                room * room,
                settings.jitter.max(0.0),
            ],
            shade: [
                shade[0],
                shade[1],
                shade[2],
                pixel * pixel / (detail * detail),
            ],
            counts: [
                trees,
                trees.div_ceil(GROUP),
                index(self.bins.len()),
                settings.fade_step(),
            ],
            orders: [
                settings.lod.map_or(0, |lod| lod.saturating_add(1)),
                stretch.to_bits(),
                0,
                0,
            ],
        }
    }
}

/// How a frame is seen.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// From where.
    pub camera: &'a Camera,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// How trees are chosen.
    pub settings: &'a Settings,
    /// Middle of the shadow map on the ground (x, z) and half its edge, metres; 0 without one.
    pub shade: [f32; 3],
    /// By how much ground shadows are longer than the baked ones.
    pub stretch: f32,
}

/// Planes of a camera's pyramid, with inside where the distance to them is positive; the far one is infinitely far.
fn planes(camera: &Camera, aspect: f32) -> [[f32; 4]; 5] {
    let matrix = camera.view_projection(aspect);
    let [x, y, z, w] = [0, 1, 2, 3].map(|i| matrix.row(i));
    [w + x, w - x, w + y, w - y, w - z].map(|plane| {
        let length = plane.truncate().length();
        if length < 1e-12 {
            // Everything is inside.
            return [0.0, 0.0, 0.0, 1.0];
        }
        (plane / length).to_array()
    })
}

/// An index or a count as the device has it.
pub(super) fn index(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

impl Settings {
    /// By how much a fade goes on in a frame, of 255.
    fn fade_step(&self) -> u32 {
        let part = self.frame_seconds.max(0.0) / self.fade_seconds.max(1e-6);
        crate::math::round_to_u32(part.min(1.0) * 255.0).clamp(1, 255)
    }
}

/// How much longer a low sun makes shadows than the baked ones; `stretch_of` of `ground.wgsl`.
pub(super) fn stretch_of(sun: Vec3) -> f32 {
    (libm::hypotf(sun.x, sun.z) / sun.y.max(1e-3)).clamp(1.0, 6.0)
}

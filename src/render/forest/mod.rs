//! Forests of up to four million trees: the GPU says which trees are seen and by which LOD, and draws them with as
//! many calls as there are models, LODs and materials, whatever the number of trees.
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, section V (hardware instancing in the place of a call for each
//! tree: what the paper says its frame rates lack).
//!
//! A frame is four compute passes (`shaders/cull.wgsl`): which bins each tree is in, sums of those by groups of 256,
//! where each bin begins, each tree's number to its place. The vertex shader reads the tree's record by that number.
//! A tree takes 56 bytes: 32 of its record, 4 of what is remembered of it, 4 of the bins that it is in, and 16 of
//! lists. Nothing depends on the order in which threads run: one scene gives one picture.
//!
//! A LOD is shown up to its screen size, as measured when the tree was made. Trees differ by chance in how far below
//! that they switch, so that no ring is seen; a tree becomes coarser only with some room, so that none flickers at
//! its switch; and a switch is a fade on complementary samples over some frames.
//!
//! Not guaranteed: trees that cast shadows from behind the eye, and ground shadows, are culled by generous bounds;
//! trees of one list are not sorted by depth.

mod device;
mod draw;
mod plan;
mod plant;
mod twin;

pub use plan::{Bin, Cull, ForestError, Kind, MAX_TREES, Plan, Stature, Use, View};
pub use plant::{Clearing, Planting, plant};
pub use twin::{Entry, Lists, Twin};

pub(super) use draw::Woods;

use self::device::Device;
use super::model::Model;
use super::renderer::Renderer;
use super::scene::Scene;
use crate::gpu::{Gpu, GpuError};
use crate::image::Image;
use crate::math::{Bounds, Vec3, byte_from_unit};
use bytemuck::{Pod, Zeroable};
use core::sync::atomic::{AtomicU32, Ordering};

/// A tree of a forest: `Planted` of the shaders.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ForestTree {
    /// Where its base stands, metres.
    pub place: [f32; 3],
    /// Its size, a factor.
    pub size: f32,
    /// Cosine and sine of its turn about +Y, of 32,767.
    pub turn: [i16; 2],
    /// Factors on its red, green and blue, of 128; phase in the wind, of 255.
    pub look: [u8; 4],
    /// Index of its model.
    pub model: u32,
    /// How much of the light trees around it take from its foot, 0..=1.
    pub crowded: f32,
}

impl ForestTree {
    /// A tree by itself, turned by `turn` radians.
    #[must_use]
    pub fn at(place: Vec3, turn: f32, size: f32, model: u32) -> Self {
        let (sine, cosine) = libm::sincosf(turn);
        #[expect(clippy::cast_possible_truncation, reason = "within -32,767..=32,767")]
        let turn = [cosine, sine].map(|x| libm::rintf(x * 32_767.0) as i16);
        Self {
            place: place.to_array(),
            size,
            turn,
            look: [128, 128, 128, 0],
            model,
            crowded: 0.0,
        }
    }

    /// With factors on its colours, up to 1.99, and a phase in the wind, 0..1.
    #[must_use]
    pub fn with_look(mut self, [red, green, blue]: [f32; 3], phase: f32) -> Self {
        let factor = |x: f32| byte_from_unit(x * 128.0 / 255.0);
        self.look = [
            factor(red),
            factor(green),
            factor(blue),
            byte_from_unit(phase),
        ];
        self
    }
}

/// How the trees of a forest are chosen and drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// LOD of all trees, the coarsest they have if that is less; chosen for each if `None`.
    pub lod: Option<u32>,
    /// Factor on the size at which LODs are shown: above 1 the forest has more detail than was measured to be
    /// needed, below 1 less.
    pub detail: f32,
    /// Largest part by which trees differ in the size at which they switch. All keep their finer LOD longer.
    pub jitter: f32,
    /// By what part a tree must be smaller than at its switch before it becomes coarser.
    pub hysteresis: f32,
    /// How long a switch takes, seconds; 0 to switch at once.
    pub fade_seconds: f32,
    /// How long a frame lasts, seconds: a window sets it for each.
    pub frame_seconds: f32,
    /// Half the edge of the ground around the eye on which trees cast shadows on one another, metres; beyond it,
    /// their own light volumes shade them.
    pub shade_m: f32,
    /// Ground shadows are left out where they are lower than this, pixels.
    pub ground_pixels: f32,
    /// Distance at which the air hides what it does not hide nearer, metres.
    pub air_m: f32,
    /// How draw calls are made.
    pub calls: Calls,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            lod: None,
            detail: 1.0,
            jitter: 0.2,
            hysteresis: 0.08,
            fade_seconds: 0.4,
            frame_seconds: 1.0 / 60.0,
            shade_m: 45.0,
            ground_pixels: 1.5,
            air_m: 1_100.0,
            calls: Calls::Indirect,
        }
    }
}

/// How draw calls are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Calls {
    /// One for each model, LOD and material; the GPU chooses.
    #[default]
    Indirect,
    /// One for each tree and material, as in the paper; the processor chooses. To compare with.
    EachTree,
}

/// What a frame draws of a forest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Trees that are seen.
    pub trees: usize,
    /// Their triangles, of both LODs where one fades into another.
    pub triangles: u64,
    /// Trees with each LOD.
    pub by_lod: Vec<usize>,
}

/// A forest on the device.
#[derive(Debug)]
pub struct Forest {
    /// How its trees are chosen and drawn: may be changed between frames.
    pub settings: Settings,
    plan: Plan,
    trees: Vec<ForestTree>,
    twin: Option<Twin>,
    device: Device,
    /// Height of the tallest tree, metres.
    height: f32,
    /// Draw calls since the last choice.
    calls: AtomicU32,
}

impl Forest {
    /// Its trees.
    #[must_use]
    pub fn trees(&self) -> &[ForestTree] {
        &self.trees
    }

    /// Its bins and models.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Draw calls that its last frame took: trees, their shadows in the shadow map and on the ground.
    #[must_use]
    pub fn calls(&self) -> u32 {
        self.calls.load(Ordering::Relaxed)
    }

    /// Forgets which LODs its trees had, as after a cut to another view.
    pub fn forget(&mut self, gpu: &Gpu) {
        self.device.forget(gpu);
        self.twin = None;
    }

    /// What the passes are told of a scene.
    #[must_use]
    pub fn cull(&self, scene: &Scene, size: [u32; 2]) -> Cull {
        let shade = self.shade(scene);
        let view = View {
            camera: &scene.camera,
            size,
            settings: &self.settings,
            shade,
            stretch: plan::stretch_of(scene.setting.sun.normalize_or(Vec3::Y)),
        };
        self.plan.frame(self.trees.len(), &view)
    }

    /// The lists of the frame chosen last, read back: what tests compare and tools count.
    ///
    /// # Errors
    /// If the device fails.
    pub fn lists(&self, gpu: &Gpu) -> Result<Lists, GpuError> {
        self.device.lists(gpu, self.plan.bins.len())
    }

    /// What lists draw, of these models.
    #[must_use]
    pub fn counts(&self, lists: &Lists, models: &[Model]) -> Counts {
        let mut counts = Counts::default();
        for (index, bin) in self.plan.bins.iter().enumerate() {
            let lod = models.get(bin.model).and_then(|m| m.lods.get(bin.lod));
            let (Some(lod), Use::Draw) = (lod, bin.of) else {
                continue;
            };
            let trees = lists.bin(index).len();
            counts.trees += lists.trees(index).filter(|t| t.fade > 0).count();
            counts.triangles += lod.triangles * trees as u64;
            if counts.by_lod.len() <= bin.lod {
                counts.by_lod.resize(bin.lod + 1, 0);
            }
            counts.by_lod[bin.lod] += trees;
        }
        counts
    }

    /// Middle of the shadow map on the ground (x, z) and half its edge.
    fn shade(&self, scene: &Scene) -> [f32; 3] {
        let half = self.settings.shade_m;
        if !scene.setting.shadow_map || half <= 0.0 {
            return [0.0; 3];
        }
        let forward = scene.camera.forward();
        let ahead = Vec3::new(forward.x, 0.0, forward.z).normalize_or_zero() * half * 0.6;
        let middle = scene.camera.eye + ahead;
        [middle.x, middle.z, half]
    }

    /// What the shadow map is to hold.
    fn shade_bounds(&self, scene: &Scene) -> Option<Bounds> {
        let [x, z, half] = self.shade(scene);
        (half > 0.0).then(|| Bounds {
            min: Vec3::new(x - half, 0.0, z - half),
            max: Vec3::new(x + half, self.height, z + half),
        })
    }
}

impl Stature {
    /// Of a model on the device.
    fn of(model: &Model) -> Self {
        Self {
            sphere: model.sphere,
            height: model.bounds.size().y,
            ground: model.ground_reach,
            lods: model
                .lods
                .iter()
                .map(|l| (l.screen_size, l.crisp))
                .collect(),
        }
    }
}

impl Renderer {
    /// Puts a forest of this renderer's trees on the device. It stays right until trees are cleared.
    ///
    /// # Errors
    /// If it is too large, has trees of no model, or the device fails.
    pub fn forest(&mut self, trees: &[ForestTree]) -> Result<Forest, ForestError> {
        let models: Vec<Stature> = self.models.iter().map(Stature::of).collect();
        let plan = Plan::of(&models)?;
        plan.check(trees)?;
        let indices: Vec<[u32; 4]> = plan.bins.iter().map(|b| self.indices_of(b)).collect();
        let crisp = |b: &Bin| models[b.model].lods[b.lod].1;
        let height = trees
            .iter()
            .map(|t| models[t.model as usize].height * t.size)
            .fold(1.0, f32::max);
        let gpu = self.gpu.clone();
        let device = Device::new(&gpu, self.woods(), &plan, trees, &indices, &crisp);
        gpu.check()?;
        Ok(Forest {
            settings: Settings::default(),
            plan,
            trees: trees.to_vec(),
            twin: None,
            device,
            height,
            calls: AtomicU32::new(0),
        })
    }

    /// The commands that choose which trees of a forest are drawn, without drawing them; to be submitted.
    #[must_use]
    pub fn choose_forest(
        &mut self,
        forest: &mut Forest,
        scene: &Scene,
        size: [u32; 2],
    ) -> wgpu::CommandEncoder {
        let mut encoder = self
            .gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("choice"),
            });
        self.choose(&mut encoder, forest, scene, size);
        encoder
    }

    /// The commands that draw a scene with a forest into a picture of this size; as [`Renderer::draw`].
    ///
    /// # Errors
    /// If the size is more than the adapter allows.
    pub fn draw_forest(
        &mut self,
        forest: &mut Forest,
        scene: &Scene,
        output: &wgpu::TextureView,
        size: [u32; 2],
    ) -> Result<wgpu::CommandEncoder, GpuError> {
        self.frame(scene, Some(forest), output, size)
    }

    /// A picture of a scene with a forest; as [`Renderer::picture`].
    ///
    /// # Errors
    /// If the size is more than the adapter allows, or the device fails.
    pub fn picture_of_forest(
        &mut self,
        forest: &mut Forest,
        scene: &Scene,
        size: [u32; 2],
    ) -> Result<Image<[u8; 4]>, GpuError> {
        self.picture_with(scene, Some(forest), size)
    }
}

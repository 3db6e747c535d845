//! The draw calls of a forest: one for each bin and material, or one for each tree to compare with.

use super::plan::{Bin, Use};
use super::{Calls, Forest, Lists, Twin};
use crate::gpu::shader;
use crate::math::{Bounds, Vec3};
use crate::render::binding;
use crate::render::drawing::light_projection;
use crate::render::pipelines::ForestPipelines;
use crate::render::renderer::Renderer;
use crate::render::scene::{Scene, ViewMode};
use crate::render::sun_map::SHADOW_MAP;
use crate::render::uniforms::Frame;

use core::sync::atomic::Ordering;

/// What all forests of a renderer share.
#[derive(Debug)]
pub(in crate::render) struct Woods {
    pub(super) choosing: wgpu::BindGroupLayout,
    pub(super) drawing: wgpu::BindGroupLayout,
    pub(super) passes: [wgpu::ComputePipeline; 4],
    pipelines: ForestPipelines,
    nothing: wgpu::BindGroup,
}

/// Bits of `Frame::modes[3]`, as in `frame.wgsl`.
const FLAG_AIR: u32 = 2;

impl Woods {
    fn new(renderer: &Renderer) -> Self {
        use wgpu::ShaderStages;
        let device = &renderer.gpu.device;
        let storage = |read_only| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let entries = |types: &[wgpu::BindingType], visibility| {
            let entry = |(binding, &ty): (u32, &wgpu::BindingType)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility,
                ty,
                count: None,
            };
            (0..).zip(types).map(entry).collect::<Vec<_>>()
        };
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        let uniform = binding::uniform();
        let (read, write) = (storage(true), storage(false));
        let choosing = layout(
            "choice",
            &entries(
                &[
                    uniform, uniform, read, write, write, write, write, write, write,
                ],
                ShaderStages::COMPUTE,
            ),
        );
        let drawing = layout(
            "forest",
            &entries(&[uniform, uniform, read, read, read], ShaderStages::VERTEX),
        );
        let nothing = layout("nothing", &[]);
        let module = shader::CULLS.module(device);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("choice"),
            bind_group_layouts: &[Some(&choosing)],
            immediate_size: 0,
        });
        let passes = ["choose", "add_up", "lay_out", "scatter"].map(|entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        let pipelines = renderer.pipelines.forest(device, &drawing, &nothing);
        let nothing = binding::group(device, &nothing, &[]);
        Self {
            choosing,
            drawing,
            passes,
            pipelines,
            nothing,
        }
    }
}

impl Renderer {
    /// What all forests share, made for the first one.
    pub(super) fn woods(&mut self) -> &Woods {
        if self.woods.is_none() {
            self.woods = Some(Woods::new(self));
        }
        match &self.woods {
            Some(woods) => woods,
            None => unreachable!("made just before"),
        }
    }

    /// Numbers of indices of the calls of a bin.
    pub(super) fn indices_of(&self, bin: &Bin) -> [u32; 4] {
        let lod = &self.models[bin.model].lods[bin.lod];
        let [bark, foliage] =
            [&lod.bark, &lod.foliage].map(|part| part.as_ref().map_or(0, |p| p.count));
        [bark, foliage, bark * 2, foliage * 2]
    }

    /// Says which trees are drawn, on the device or on the processor.
    pub(in crate::render) fn choose(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        forest: &mut Forest,
        scene: &Scene,
        size: [u32; 2],
    ) {
        let cull = forest.cull(scene, size);
        forest.calls.store(0, Ordering::Relaxed);
        forest.device.write(&self.gpu, &cull);
        match forest.settings.calls {
            Calls::Indirect => {
                forest.device.choose(encoder, self.woods(), &cull);
            }
            Calls::EachTree => {
                let trees = &forest.trees;
                let twin = forest.twin.get_or_insert_with(|| Twin::new(trees.len()));
                let lists = twin.choose(&forest.plan, trees, &cull);
                forest.device.put(&self.gpu, lists);
            }
        }
    }

    /// The light and air of a forest in the place of a single tree's.
    pub(in crate::render) fn suit_forest(forest: &Forest, scene: &Scene, frame: &mut Frame) {
        frame.horizon[3] = forest.settings.air_m;
        frame.modes[3] |= FLAG_AIR;
        let sun = scene.setting.sun.normalize_or(Vec3::Y);
        if let Some(bounds) = forest.shade_bounds(scene) {
            let (_, reach) = light_projection(&bounds, sun);
            let texel = reach / crate::math::float(SHADOW_MAP);
            let (light, _) = light_projection(&snapped(&bounds, sun, texel), sun);
            frame.light_projection = light.to_cols_array_2d();
            frame.clock[2] = reach * 3.0 / crate::math::float(SHADOW_MAP);
        }
    }

    pub(in crate::render) fn cast_forest(&self, pass: &mut wgpu::RenderPass<'_>, forest: &Forest) {
        let Some(woods) = &self.woods else { return };
        let pipelines = &woods.pipelines;
        self.draw_bins(
            pass,
            forest,
            Use::Cast,
            [&pipelines.bark_cast, &pipelines.foliage_cast],
            false,
        );
    }

    pub(in crate::render) fn draw_trees(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        view: ViewMode,
    ) {
        let Some(woods) = &self.woods else { return };
        let pipelines = &woods.pipelines;
        let pair = match view {
            ViewMode::Overdraw => [&pipelines.layers; 2],
            ViewMode::Wire => [&pipelines.wires; 2],
            _ => [&pipelines.bark, &pipelines.foliage],
        };
        self.draw_bins(pass, forest, Use::Draw, pair, view == ViewMode::Wire);
    }

    pub(in crate::render) fn shade_ground(&self, pass: &mut wgpu::RenderPass<'_>, forest: &Forest) {
        let Some(woods) = &self.woods else { return };
        pass.set_pipeline(&woods.pipelines.patches);
        pass.set_bind_group(2, &woods.nothing, &[]);
        for (index, bin) in forest.plan.bins.iter().enumerate() {
            let Some(model) = self.models.get(bin.model) else {
                continue;
            };
            if bin.of != Use::Ground {
                continue;
            }
            pass.set_bind_group(1, &model.ground_group, &[]);
            forest.device.bind(pass, index);
            match forest.each(index) {
                Some(trees) => {
                    for tree in 0..trees {
                        pass.draw(0..6, tree..tree + 1);
                    }
                    forest.called(trees);
                }
                None => {
                    let (calls, at) = forest.device.call(index, 0);
                    pass.draw_indirect(calls, at);
                    forest.called(1);
                }
            }
        }
    }

    /// All bins of a use: their bark, then their foliage.
    fn draw_bins(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        of: Use,
        pipelines: [&wgpu::RenderPipeline; 2],
        edges: bool,
    ) {
        if forest.settings.calls == Calls::EachTree {
            self.draw_each(pass, forest, of, pipelines, edges);
            return;
        }
        for (material, pipeline) in pipelines.into_iter().enumerate() {
            pass.set_pipeline(pipeline);
            for (index, _) in forest.bins_of(of) {
                if self
                    .bind_bin(pass, forest, index, (material, edges))
                    .is_none()
                {
                    continue;
                }
                let call = material + if edges { 2 } else { 0 };
                let (calls, at) = forest.device.call(index, call);
                pass.draw_indexed_indirect(calls, at);
                forest.called(1);
            }
        }
    }

    /// Tree by tree, as display lists did in the paper: each brings its state and draws its two materials.
    fn draw_each(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        of: Use,
        pipelines: [&wgpu::RenderPipeline; 2],
        edges: bool,
    ) {
        for (index, trees) in forest.bins_of(of) {
            for tree in 0..trees {
                for (material, pipeline) in pipelines.into_iter().enumerate() {
                    pass.set_pipeline(pipeline);
                    let bound = self.bind_bin(pass, forest, index, (material, edges));
                    if let Some(count) = bound {
                        pass.draw_indexed(0..count, 0, tree..tree + 1);
                        forest.called(1);
                    }
                }
            }
        }
    }

    /// Binds what a material of a bin is drawn from; how many indices that has, or `None` without any.
    fn bind_bin(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        forest: &Forest,
        index: usize,
        (material, edges): (usize, bool),
    ) -> Option<u32> {
        let bin = forest.plan.bins[index];
        let model = self.models.get(bin.model)?;
        let lod = model.lods.get(bin.lod)?;
        let (part, surface) = if material == 0 {
            (&lod.bark, &model.bark)
        } else {
            (&lod.foliage, &model.foliage)
        };
        let part = part.as_ref()?;
        pass.set_bind_group(1, &model.group, &[]);
        pass.set_bind_group(2, surface, &[]);
        forest.device.bind(pass, index);
        pass.set_vertex_buffer(0, part.vertices.slice(..));
        pass.set_vertex_buffer(1, part.sway.slice(..));
        pass.set_vertex_buffer(2, part.origins.slice(..));
        let (indices, count) = if edges {
            (&part.edges, part.count * 2)
        } else {
            (&part.indices, part.count)
        };
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        Some(count)
    }
}

/// Bounds shifted by less than a texel of the shadow map along it, so that texels keep their places in the world
/// as the eye moves, and shadows do not crawl.
fn snapped(bounds: &Bounds, sun: Vec3, texel: f32) -> Bounds {
    let side = if sun.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let right = side.cross(sun).normalize_or(Vec3::X);
    let up = sun.cross(right);
    let centre = bounds.centre();
    let shift = [right, up]
        .map(|axis| axis * (libm::roundf(centre.dot(axis) / texel) * texel - centre.dot(axis)));
    let shift = shift[0] + shift[1];
    Bounds {
        min: bounds.min + shift,
        max: bounds.max + shift,
    }
}

impl Forest {
    fn called(&self, calls: u32) {
        self.calls.fetch_add(calls, Ordering::Relaxed);
    }

    /// Trees of a bin, where each is drawn by a call of its own.
    fn each(&self, bin: usize) -> Option<u32> {
        let lists: &Lists = match (self.settings.calls, &self.twin) {
            (Calls::EachTree, Some(twin)) => twin.lists(),
            _ => return None,
        };
        Some(lists.starts[bin + 1] - lists.starts[bin])
    }

    /// Bins of a use, each with its trees where they are drawn one by one.
    fn bins_of(&self, of: Use) -> impl Iterator<Item = (usize, u32)> {
        let bins = self.plan.bins.iter().enumerate();
        bins.filter(move |(_, bin)| bin.of == of)
            .map(|(index, _)| (index, self.each(index).unwrap_or(0)))
    }
}

//! The passes that draw a group of captures, and their pipelines.

use super::group::{GROUP_SAMPLES, List, count};
use super::upload;
use crate::gpu::{Gpu, shader};
use crate::math::float;
use crate::mesh::Vertex;
use wgpu::{BindGroupLayout, BindingResource, Buffer, RenderPipeline, TextureFormat, TextureView};

/// Bytes from one shot to the next among uniforms: what every adapter can step by.
pub(super) const STRIDE: usize = 256;

/// What a finished texel is kept in; see `shaders/capture_texels.wgsl`.
const TEXEL: TextureFormat = TextureFormat::Rgba32Uint;

/// What a sample is kept in; see `shaders/capture_seen.wgsl`.
const SEEN: TextureFormat = TextureFormat::Rg32Uint;

const NEAR: TextureFormat = TextureFormat::Depth32Float;

const OPEN: TextureFormat = TextureFormat::R32Float;

/// A pipeline with the layout of its one group.
#[derive(Debug)]
struct Stop {
    layout: BindGroupLayout,
    pipeline: RenderPipeline,
}

/// What is compiled once.
#[derive(Debug)]
pub(super) struct Pipelines {
    light: Stop,
    seen: BindGroupLayout,
    bark: RenderPipeline,
    foliage: RenderPipeline,
    texels: Stop,
}

/// Buffers of a group.
pub(super) struct Buffers {
    pub(super) sheet: Buffer,
    pub(super) shots: Buffer,
    pub(super) vertices: Buffer,
    pub(super) indices: Buffer,
    /// The density of all grids.
    pub(super) density: TextureView,
}

/// Pictures that one pass of a group draws for another; groups after each other draw into the same ones.
#[derive(Debug)]
pub(super) struct Targets {
    /// The light that reaches each cell.
    open: TextureView,
    /// What each sample sees, and how near it is.
    seen: TextureView,
    near: TextureView,
    /// The finished texels.
    pub(super) texels: wgpu::Texture,
    size: Size,
}

/// Width and height of the pictures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub(super) samples: [u32; 2],
    pub(super) texels: [u32; 2],
    pub(super) grids: [u32; 2],
}

impl Size {
    fn pairs(&self, other: &Self) -> [([u32; 2], [u32; 2]); 3] {
        [
            (self.samples, other.samples),
            (self.texels, other.texels),
            (self.grids, other.grids),
        ]
    }

    fn holds(&self, other: &Self) -> bool {
        let pairs = self.pairs(other);
        pairs.iter().all(|(a, b)| a[0] >= b[0] && a[1] >= b[1])
    }

    fn is_usual(&self) -> bool {
        let [across, down] = self.samples.map(u64::from);
        across * down <= GROUP_SAMPLES
    }

    fn with(&self, other: &Self) -> Self {
        let [samples, texels, grids] = self
            .pairs(other)
            .map(|(a, b)| [a[0].max(b[0]), a[1].max(b[1])]);
        Self {
            samples,
            texels,
            grids,
        }
    }
}

impl Targets {
    fn new(gpu: &Gpu, size: Size) -> Self {
        use wgpu::TextureUsages as Usage;
        let target = |label, format, size, usage| {
            texture(gpu, label, format, size, Usage::RENDER_ATTACHMENT | usage)
        };
        let view =
            |label, format, size| whole(&target(label, format, size, Usage::TEXTURE_BINDING));
        Self {
            open: view("open", OPEN, size.grids),
            seen: view("seen", SEEN, size.samples),
            near: view("near", NEAR, size.samples),
            texels: target("texels", TEXEL, size.texels, Usage::COPY_SRC),
            size,
        }
    }

    /// Those of a group before, if they hold what this one draws; larger ones if not, as long as both are small.
    pub(super) fn holding(gpu: &Gpu, before: Option<Self>, size: Size) -> Self {
        let Some(before) = before else {
            return Self::new(gpu, size);
        };
        if before.size.holds(&size) {
            return before;
        }
        let both = before.size.with(&size);
        drop(before);
        Self::new(gpu, if both.is_usual() { both } else { size })
    }

    /// True if no single scene needed more than a group is meant to have.
    pub(super) fn is_usual(&self) -> bool {
        self.size.is_usual()
    }
}

/// A flat texture without mips.
pub(super) fn texture(
    gpu: &Gpu,
    label: &str,
    format: TextureFormat,
    [width, height]: [u32; 2],
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// All of a texture.
pub(super) fn whole(texture: &wgpu::Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType as Kind, TextureSampleType as Sample};
        let layout = |images: &[Sample]| {
            let mut bindings = vec![
                upload::data(Kind::Uniform, false),
                upload::data(Kind::Uniform, true),
            ];
            bindings.extend(images.iter().map(|&sample| upload::image(sample)));
            upload::layout(device, wgpu::ShaderStages::VERTEX_FRAGMENT, &bindings)
        };
        let (words, floats) = (Sample::Uint, Sample::Float { filterable: false });
        let everywhere = |source: shader::Source,
                          entries: [&'static str; 2],
                          target,
                          layout: BindGroupLayout| {
            let module = source.module(device);
            let pipeline = Drawn {
                entries,
                target,
                mesh: false,
            };
            Stop {
                pipeline: pipeline.compiled(device, &module, &layout),
                layout,
            }
        };
        let seen = layout(&[words, words]);
        let module = shader::CAPTURES_SEEN.module(device);
        let [bark, foliage] = ["fs_bark", "fs_foliage"].map(|fragment| {
            let pipeline = Drawn {
                entries: ["vs_capture", fragment],
                target: SEEN,
                mesh: true,
            };
            pipeline.compiled(device, &module, &seen)
        });
        Self {
            light: everywhere(
                shader::CAPTURES_LIGHT,
                ["vs_light", "fs_light"],
                OPEN,
                layout(&[floats]),
            ),
            seen,
            bark,
            foliage,
            texels: everywhere(
                shader::CAPTURES_TEXELS,
                ["vs_texels", "fs_texels"],
                TEXEL,
                layout(&[words, Sample::Depth, floats, words]),
            ),
        }
    }

    /// Records the light that reaches the cells of all grids; gives the number of draws.
    pub(super) fn light(&self, on: &mut Recording<'_>) -> u64 {
        let density = [BindingResource::TextureView(&on.buffers.density)];
        let group = on.bound(&self.light.layout, &density);
        let mut pass = on.pass("light", &on.targets.open, None);
        pass.set_pipeline(&self.light.pipeline);
        for &number in &on.list.lit {
            let shot = &on.list.shots[number];
            let [across, down, deep] = shot.size;
            pass.set_scissor_rect(shot.column, 0, across, down * deep);
            pass.set_bind_group(0, &group, &[count(number * STRIDE)]);
            pass.draw(0..3, 0..1);
        }
        on.list.lit.len() as u64
    }

    /// Records the surface that each sample sees; gives the number of draws.
    pub(super) fn see(&self, on: &mut Recording<'_>, surfaces: &upload::Surfaces) -> u64 {
        let images = [&surfaces.bark, &surfaces.outlines];
        let images = images.map(|image| BindingResource::TextureView(&image.view));
        let group = on.bound(&self.seen, &images);
        let mut pass = on.pass("captures", &on.targets.seen, Some(&on.targets.near));
        let [across, down] = on.samples.map(float);
        pass.set_viewport(0.0, 0.0, across, down, 0.0, 1.0);
        pass.set_vertex_buffer(0, on.buffers.vertices.slice(..));
        pass.set_index_buffer(on.buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut calls = 0;
        for (which, pipeline) in [(0, &self.bark), (1, &self.foliage)] {
            pass.set_pipeline(pipeline);
            for (number, (shot, parts)) in on.list.shots.iter().zip(&on.list.parts).enumerate() {
                let part = &parts[which];
                if !part.indices.is_empty() {
                    let ([x, y], [width, height]) = (shot.place, shot.samples);
                    pass.set_scissor_rect(x, y, width, height);
                    pass.set_bind_group(0, &group, &[count(number * STRIDE)]);
                    pass.draw_indexed(part.indices.clone(), part.first_vertex, 0..1);
                    calls += 1;
                }
            }
        }
        calls
    }

    /// Records the averages of all texels; gives the number of draws.
    pub(super) fn texels(
        &self,
        on: &mut Recording<'_>,
        surfaces: &upload::Surfaces,
        supersample: u32,
    ) -> u64 {
        let Targets {
            open, seen, near, ..
        } = on.targets;
        let images = [seen, near, open, &surfaces.foliage.view].map(BindingResource::TextureView);
        let group = on.bound(&self.texels.layout, &images);
        let texels = whole(&on.targets.texels);
        let mut pass = on.pass("texels", &texels, None);
        pass.set_pipeline(&self.texels.pipeline);
        for (number, shot) in on.list.shots.iter().enumerate() {
            let places = [shot.place, shot.samples].map(|at| at.map(|n| n / supersample));
            let [[x, y], [width, height]] = places;
            pass.set_scissor_rect(x, y, width, height);
            pass.set_bind_group(0, &group, &[count(number * STRIDE)]);
            pass.draw(0..3, 0..1);
        }
        on.list.shots.len() as u64
    }
}

/// What the passes of a group share.
pub(super) struct Recording<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) encoder: &'a mut wgpu::CommandEncoder,
    pub(super) buffers: &'a Buffers,
    pub(super) targets: &'a Targets,
    /// Samples of the group's sheet, across and down: what is drawn must not depend on the size of older targets.
    pub(super) samples: [u32; 2],
    pub(super) list: &'a List,
}

impl<'a> Recording<'a> {
    /// Begins a pass that draws into a cleared target.
    fn pass(
        &mut self,
        label: &str,
        target: &TextureView,
        near: Option<&TextureView>,
    ) -> wgpu::RenderPass<'static> {
        let depth = near.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.0),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        });
        let pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: depth,
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.forget_lifetime()
    }

    /// The group of a pass: sheet, one shot of all, chosen by an offset, and images.
    fn bound(&self, layout: &BindGroupLayout, images: &[BindingResource<'_>]) -> wgpu::BindGroup {
        let shot = BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffers.shots,
            offset: 0,
            size: wgpu::BufferSize::new(STRIDE as u64),
        });
        let first = [self.buffers.sheet.as_entire_binding(), shot];
        let all = first.into_iter().chain(images.iter().cloned());
        let bindings: Vec<_> = (0..).zip(all).collect();
        upload::bound(self.gpu, layout, &bindings)
    }
}

/// A pipeline as asked for.
struct Drawn {
    /// Of the vertex and of the fragment shader.
    entries: [&'static str; 2],
    target: TextureFormat,
    /// Meshes with depth, or a triangle all over the target.
    mesh: bool,
}

impl Drawn {
    fn compiled(
        &self,
        device: &wgpu::Device,
        module: &wgpu::ShaderModule,
        layout: &BindGroupLayout,
    ) -> RenderPipeline {
        let attributes = wgpu::vertex_attr_array![
            0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2, 4 => Unorm8x4
        ];
        let vertices = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let [vertex, fragment] = self.entries;
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&upload::pipeline_layout(device, layout)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: if self.mesh { &vertices } else { &[] },
            },
            primitive: wgpu::PrimitiveState::default(),
            // Of equal depths the first one stays, as on the processor.
            depth_stencil: self.mesh.then(|| wgpu::DepthStencilState {
                format: NEAR,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(self.target.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

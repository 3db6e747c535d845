//! Pipelines: which shader draws what into which picture.

use super::binding::{self, depth_texture, layout, texture, uniform};
use super::model::Layouts;
use super::part::Origin;
use super::renderer::SAMPLES;
use super::targets::{DEPTH, GROUND, LIGHT};
use super::uniforms::Instance;
use crate::gpu::shader;
use crate::mesh::Vertex;
use crate::wind::Sway;
use core::mem::offset_of;
use wgpu::{VertexAttribute, VertexFormat, VertexStepMode};

/// All pipelines of a renderer and the layouts that they share.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) layouts: Layouts,
    pub(super) frame: wgpu::BindGroupLayout,
    pub(super) cast_frame: wgpu::BindGroupLayout,
    pub(super) ground_frame: wgpu::BindGroupLayout,
    pub(super) pictures: wgpu::BindGroupLayout,
    pub(super) bark: wgpu::RenderPipeline,
    pub(super) foliage: wgpu::RenderPipeline,
    pub(super) layers: wgpu::RenderPipeline,
    pub(super) wires: wgpu::RenderPipeline,
    pub(super) bark_cast: wgpu::RenderPipeline,
    pub(super) foliage_cast: wgpu::RenderPipeline,
    pub(super) backdrop: wgpu::RenderPipeline,
    pub(super) patches: wgpu::RenderPipeline,
    pub(super) present: wgpu::RenderPipeline,
}

/// Pipelines that draw the trees of a forest, each as the one of the same name draws single trees.
#[derive(Debug)]
pub(super) struct ForestPipelines {
    pub(super) bark: wgpu::RenderPipeline,
    pub(super) foliage: wgpu::RenderPipeline,
    pub(super) layers: wgpu::RenderPipeline,
    pub(super) wires: wgpu::RenderPipeline,
    pub(super) bark_cast: wgpu::RenderPipeline,
    pub(super) foliage_cast: wgpu::RenderPipeline,
    pub(super) patches: wgpu::RenderPipeline,
}

const VERTEX: [VertexAttribute; 5] = [
    attribute(0, offset_of!(Vertex, position), VertexFormat::Float32x3),
    attribute(1, offset_of!(Vertex, normal), VertexFormat::Float32x3),
    attribute(2, offset_of!(Vertex, tangent), VertexFormat::Float32x4),
    attribute(3, offset_of!(Vertex, uv), VertexFormat::Float32x2),
    attribute(10, offset_of!(Vertex, tint), VertexFormat::Unorm8x4),
];

const SWAY: [VertexAttribute; 2] = [
    attribute(4, offset_of!(Sway, wind), VertexFormat::Unorm8x4),
    attribute(5, offset_of!(Sway, leaf), VertexFormat::Snorm8x4),
];

const ORIGIN: [VertexAttribute; 2] = [
    attribute(11, offset_of!(Origin, level), VertexFormat::Uint32),
    attribute(12, offset_of!(Origin, relief_m), VertexFormat::Float32),
];

const INSTANCE: [VertexAttribute; 4] = [
    attribute(6, offset_of!(Instance, place), VertexFormat::Float32x4),
    attribute(7, offset_of!(Instance, turn), VertexFormat::Float32x4),
    attribute(8, offset_of!(Instance, tint), VertexFormat::Float32x4),
    attribute(9, offset_of!(Instance, marks), VertexFormat::Float32x4),
];

const fn attribute(location: u32, offset: usize, format: VertexFormat) -> VertexAttribute {
    VertexAttribute {
        format,
        offset: offset as u64,
        shader_location: location,
    }
}

fn vertices() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: VertexStepMode::Vertex,
        attributes: &VERTEX,
    }
}

fn sways() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Sway>() as u64,
        step_mode: VertexStepMode::Vertex,
        attributes: &SWAY,
    }
}

fn origins() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Origin>() as u64,
        step_mode: VertexStepMode::Vertex,
        attributes: &ORIGIN,
    }
}

fn instances() -> wgpu::VertexBufferLayout<'static> {
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Instance>() as u64,
        step_mode: VertexStepMode::Instance,
        attributes: &INSTANCE,
    }
}

/// What tells one pipeline from another.
struct Recipe<'a> {
    label: &'a str,
    module: &'a wgpu::ShaderModule,
    layouts: &'a [&'a wgpu::BindGroupLayout],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    vertex: &'a str,
    fragment: Option<&'a str>,
    target: Option<wgpu::TextureFormat>,
    blend: Option<wgpu::BlendState>,
    topology: wgpu::PrimitiveTopology,
    cull: bool,
    depth: Option<wgpu::DepthStencilState>,
    samples: u32,
    constants: &'a [(&'a str, f64)],
}

impl<'a> Recipe<'a> {
    /// A pipeline that writes opaque colour, without depth.
    fn new(
        label: &'a str,
        module: &'a wgpu::ShaderModule,
        layouts: &'a [&'a wgpu::BindGroupLayout],
        vertex: &'a str,
    ) -> Self {
        Self {
            label,
            module,
            layouts,
            buffers: &[],
            vertex,
            fragment: None,
            target: None,
            blend: None,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull: false,
            depth: None,
            samples: 1,
            constants: &[],
        }
    }

    fn build(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let layouts: Vec<Option<&wgpu::BindGroupLayout>> =
            self.layouts.iter().copied().map(Some).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let compilation_options = wgpu::PipelineCompilationOptions {
            constants: self.constants,
            ..wgpu::PipelineCompilationOptions::default()
        };
        let targets = self.target.map(|format| wgpu::ColorTargetState {
            format,
            blend: self.blend,
            write_mask: wgpu::ColorWrites::ALL,
        });
        let targets: &[Option<wgpu::ColorTargetState>] =
            if targets.is_some() { &[targets] } else { &[] };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some(self.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState {
                topology: self.topology,
                cull_mode: self.cull.then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: self.depth.clone(),
            multisample: wgpu::MultisampleState {
                count: self.samples,
                ..wgpu::MultisampleState::default()
            },
            fragment: self.fragment.map(|entry| wgpu::FragmentState {
                module: self.module,
                entry_point: Some(entry),
                compilation_options,
                targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Depth that is tested, and written or not. `sign` is of the bias away from the sun, for shadow maps.
fn depth(compare: wgpu::CompareFunction, write: bool, bias: i32) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState {
            constant: bias,
            #[expect(clippy::cast_precision_loss, reason = "-1, 0 or 1")]
            slope_scale: bias.signum() as f32 * 1.5,
            clamp: 0.0,
        },
    }
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, samples: u32, output: wgpu::TextureFormat) -> Self {
        use wgpu::TextureViewDimension::D2;
        let layouts = Layouts::new(device);
        let comparison = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison);
        let nearest = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
        let frame = layout(
            device,
            "frame",
            &[
                (0, uniform()),
                (1, depth_texture()),
                (2, comparison),
                (3, nearest),
            ],
        );
        let cast_frame = layout(device, "frame of the shadow map", &[(0, uniform())]);
        let ground_frame = layout(
            device,
            "frame of the ground",
            &[(0, uniform()), (4, texture(D2))],
        );
        let pictures = layout(
            device,
            "pictures",
            &[(0, texture(D2)), (1, texture(D2)), (2, binding::sampler())],
        );

        let trees = shader::TREES.module(device);
        let ground = shader::GROUNDS.module(device);
        let present = shader::PRESENTS.module(device);
        let tree_buffers = [vertices(), sways(), origins(), instances()].map(Some);
        let lit = [&frame, &layouts.model, &layouts.material];
        let tree = |label, fragment| Recipe {
            buffers: &tree_buffers,
            fragment: Some(fragment),
            target: Some(LIGHT),
            depth: Some(depth(wgpu::CompareFunction::Greater, true, 0)),
            samples,
            ..Recipe::new(label, &trees, &lit, "vs_tree")
        };
        let casting = [&cast_frame, &layouts.model, &layouts.material];
        let cast = |label, fragment| Recipe {
            buffers: &tree_buffers,
            fragment,
            depth: Some(depth(wgpu::CompareFunction::Less, true, 2)),
            ..Recipe::new(label, &trees, &casting, "vs_cast")
        };
        let grounded = [&cast_frame, &layouts.ground];
        let encodes = f64::from(u8::from(output.is_srgb()));
        Self {
            bark: Recipe {
                cull: true,
                ..tree("bark", "fs_bark")
            }
            .build(device),
            foliage: tree("foliage", "fs_foliage").build(device),
            layers: Recipe {
                blend: Some(added()),
                depth: Some(depth(wgpu::CompareFunction::Always, false, 0)),
                ..tree("layers", "fs_layer")
            }
            .build(device),
            wires: Recipe {
                topology: wgpu::PrimitiveTopology::LineList,
                ..tree("wires", "fs_wire")
            }
            .build(device),
            bark_cast: cast("bark shadow", None).build(device),
            foliage_cast: cast("foliage shadow", Some("fs_cast")).build(device),
            backdrop: Recipe {
                fragment: Some("fs_backdrop"),
                target: Some(LIGHT),
                ..Recipe::new("backdrop", &ground, &[&ground_frame], "vs_screen")
            }
            .build(device),
            patches: Recipe {
                buffers: &[Some(instances())],
                fragment: Some("fs_patch"),
                target: Some(GROUND),
                blend: Some(multiplied()),
                ..Recipe::new("ground shadows", &ground, &grounded, "vs_patch")
            }
            .build(device),
            present: Recipe {
                fragment: Some("fs_present"),
                target: Some(output),
                constants: &[("target_encodes", encodes)],
                ..Recipe::new("present", &present, &[&cast_frame, &pictures], "vs_screen")
            }
            .build(device),
            layouts,
            frame,
            cast_frame,
            ground_frame,
            pictures,
        }
    }
}

impl Pipelines {
    /// Pipelines whose fourth bind group, of this layout, leads to the trees of a forest; those on the ground
    /// have nothing in the third.
    pub(super) fn forest(
        &self,
        device: &wgpu::Device,
        forest: &wgpu::BindGroupLayout,
        nothing: &wgpu::BindGroupLayout,
    ) -> ForestPipelines {
        let trees = shader::FORESTS.module(device);
        let ground = shader::FOREST_GROUNDS.module(device);
        let Layouts {
            model, material, ..
        } = &self.layouts;
        let buffers = [vertices(), sways(), origins()].map(Some);
        let lit = [&self.frame, model, material, forest];
        let tree = |label, fragment| Recipe {
            buffers: &buffers,
            fragment: Some(fragment),
            target: Some(LIGHT),
            depth: Some(depth(wgpu::CompareFunction::Greater, true, 0)),
            samples: SAMPLES,
            ..Recipe::new(label, &trees, &lit, "vs_forest")
        };
        let casting = [&self.cast_frame, model, material, forest];
        let cast = |label, fragment| Recipe {
            buffers: &buffers,
            fragment,
            depth: Some(depth(wgpu::CompareFunction::Less, true, 2)),
            ..Recipe::new(label, &trees, &casting, "vs_forest_cast")
        };
        let grounded = [&self.cast_frame, &self.layouts.ground, nothing, forest];
        ForestPipelines {
            bark: Recipe {
                cull: true,
                ..tree("forest bark", "fs_bark")
            }
            .build(device),
            foliage: tree("forest foliage", "fs_foliage").build(device),
            layers: Recipe {
                blend: Some(added()),
                depth: Some(depth(wgpu::CompareFunction::Always, false, 0)),
                ..tree("forest layers", "fs_layer")
            }
            .build(device),
            wires: Recipe {
                topology: wgpu::PrimitiveTopology::LineList,
                ..tree("forest wires", "fs_wire")
            }
            .build(device),
            bark_cast: cast("forest bark shadow", None).build(device),
            foliage_cast: cast("forest foliage shadow", Some("fs_cast")).build(device),
            patches: Recipe {
                fragment: Some("fs_patch"),
                target: Some(GROUND),
                blend: Some(multiplied()),
                ..Recipe::new(
                    "forest ground shadows",
                    &ground,
                    &grounded,
                    "vs_forest_patch",
                )
            }
            .build(device),
        }
    }
}

fn added() -> wgpu::BlendState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
}

fn multiplied() -> wgpu::BlendState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
}

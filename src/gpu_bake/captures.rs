//! Captures on an adapter: scenes gathered into groups, each drawn on one sheet and read back at once.

use super::group::{Group, List, Ready, area, count, too_large};
use super::layout::{self, Relief};
use super::upload::{self, Surfaces};
use super::{Baker, Tally};
use crate::capture::{BakeError, Pass, Picture, Shot};
use crate::gpu::{GpuError, shader};
use crate::image::{Image, Texel};
use crate::math::{Vec3, float};
use crate::mesh::Vertex;
use crate::report::{Cancelled, MachineFault, Progress};
use rayon::prelude::*;
use wgpu::{BindingResource, Buffer, BufferUsages, TextureFormat};

/// Words of a texel on its way back.
pub(super) const WORDS: u32 = 5;

/// Texels along the edge of a workgroup, as in `shaders/capture_texels.wgsl`.
const TILE: u32 = 8;

/// Bytes from one shot to the next among uniforms: what every adapter can step by.
const STRIDE: usize = 256;

/// Scenes that are made at a time.
const AT_A_TIME: usize = 32;

/// What is compiled once.
#[derive(Debug)]
pub(super) struct Pipelines {
    seen: wgpu::BindGroupLayout,
    bark: wgpu::RenderPipeline,
    foliage: wgpu::RenderPipeline,
    light: wgpu::ComputePipeline,
    texels: wgpu::ComputePipeline,
    texels_layout: wgpu::BindGroupLayout,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        use wgpu::{BufferBindingType as Kind, TextureSampleType as Sample};
        let draws = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let seen = upload::layout(
            device,
            draws,
            &[
                upload::data(Kind::Uniform, false),
                upload::data(Kind::Uniform, true),
                upload::image(Sample::Uint),
                upload::image(Sample::Uint),
                upload::image(Sample::Float { filterable: false }),
                upload::data(Kind::Storage { read_only: true }, false),
            ],
        );
        let texels_layout = upload::layout(
            device,
            wgpu::ShaderStages::COMPUTE,
            &[
                upload::data(Kind::Uniform, false),
                upload::data(Kind::Uniform, true),
                upload::image(Sample::Uint),
                upload::image(Sample::Depth),
                upload::data(Kind::Storage { read_only: true }, false),
                upload::data(Kind::Storage { read_only: false }, false),
            ],
        );
        let compute = |source: shader::Source, entry, layout: Option<&wgpu::PipelineLayout>| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(source.name),
                layout,
                module: &source.module(device),
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        };
        let module = shader::CAPTURES_SEEN.module(device);
        let [bark, foliage] =
            ["fs_bark", "fs_foliage"].map(|entry| seeing(device, &seen, &module, entry));
        let of_texels = upload::pipeline_layout(device, &texels_layout);
        Self {
            bark,
            foliage,
            seen,
            light: compute(shader::CAPTURES_LIGHT, "cs_light", None),
            texels: compute(shader::CAPTURES_TEXELS, "cs_texels", Some(&of_texels)),
            texels_layout,
        }
    }
}

fn seeing(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    fragment: &str,
) -> wgpu::RenderPipeline {
    let attributes = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2, 4 => Unorm8x4
    ];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(&upload::pipeline_layout(device, layout)),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vs_capture"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        // Of equal depths the first one stays, as on the processor.
        depth_stencil: Some(wgpu::DepthStencilState {
            format: TextureFormat::Depth32Float,
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
            targets: &[Some(TextureFormat::Rgba32Uint.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Draws all scenes of a pass.
pub(super) fn draw(
    baker: &Baker,
    pass: &Pass<'_>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Picture>>, BakeError> {
    let gpu = &baker.gpu;
    let stage = Stage {
        baker,
        pass,
        surfaces: Surfaces::new(gpu, pass).map_err(MachineFault::from)?,
    };
    baker.count(Tally {
        bytes_up: stage.surfaces.bytes(),
        ..Tally::default()
    });
    let mut exposed = Vec::new();
    let mut group = Group::new(gpu);
    for first in (0..pass.scenes).step_by(AT_A_TIME) {
        let scenes = first..pass.scenes.min(first + AT_A_TIME);
        let make = |index: usize| {
            if progress.cancelled() {
                return Err(Cancelled.into());
            }
            let ready = Ready::new((pass.scene)(index)?);
            progress.step();
            Ok(ready)
        };
        let ready: Result<Vec<Ready>, BakeError> = scenes.into_par_iter().map(make).collect();
        for scene in ready? {
            if let Some(scene) = group.add(scene) {
                let full = core::mem::replace(&mut group, Group::new(gpu));
                if let Some(scene) = group.add(scene) {
                    return Err(MachineFault::from(too_large(gpu, &scene)).into());
                }
                exposed.push(stage.expose(full).map_err(MachineFault::from)?);
            }
        }
    }
    if !group.scenes.is_empty() {
        exposed.push(stage.expose(group).map_err(MachineFault::from)?);
    }
    if progress.cancelled() {
        return Err(Cancelled.into());
    }
    Ok(developed(baker, exposed, pass.supersample).map_err(MachineFault::from)?)
}

/// A group whose texels are on their way back.
struct Exposed {
    /// By scene.
    shots: Vec<Vec<Shot>>,
    texels: Buffer,
}

/// A pass with its textures.
struct Stage<'a> {
    baker: &'a Baker,
    pass: &'a Pass<'a>,
    surfaces: Surfaces,
}

/// Buffers of a group.
struct Buffers {
    sheet: Buffer,
    shots: Buffer,
    vertices: Buffer,
    indices: Buffer,
    grids: Buffer,
    density: Buffer,
    open: Buffer,
    reliefs: Buffer,
    output: Buffer,
}

/// What each sample sees, and how near it is.
struct Seen {
    surface: wgpu::TextureView,
    near: wgpu::TextureView,
}

impl Stage<'_> {
    /// Hands over the drawing of a group.
    fn expose(&self, group: Group) -> Result<Exposed, GpuError> {
        let gpu = &self.baker.gpu;
        let list = List::of(&group);
        let buffers = self.buffers(&group, &list);
        let bytes_back = group.texels.max(1) * u64::from(WORDS) * 4;
        let texels = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("captures back"),
            size: bytes_back,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("captures"),
            });
        self.light(&mut encoder, &buffers, &list);
        let seen = self.seen(group.sheet.size());
        let calls = 1
            + self.see(&mut encoder, &buffers, &list, &seen)
            + self.texels(&mut encoder, &buffers, &list, &seen);
        encoder.copy_buffer_to_buffer(&buffers.output, 0, &texels, 0, Some(bytes_back));
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        self.baker.count(Tally {
            submits: 1,
            passes: 3,
            calls,
            bytes_up: group.bytes + group.cells * 4,
            bytes_back,
        });
        let scenes = group.scenes.into_iter();
        Ok(Exposed {
            shots: scenes.map(|ready| ready.scene.shots).collect(),
            texels,
        })
    }

    fn buffers(&self, group: &Group, list: &List) -> Buffers {
        let gpu = &self.baker.gpu;
        let scenes = &group.scenes;
        let vertices = || scenes.iter().flat_map(Ready::vertices);
        let indices = || scenes.iter().flat_map(Ready::indices);
        let vertex_count: usize = vertices().map(<[Vertex]>::len).sum();
        let index_count: usize = indices().map(<[u32]>::len).sum();
        let densities = scenes.iter().map(|r| r.scene.occlusion.density());
        let reliefs: Vec<Relief> = self.pass.textures.reliefs.iter().map(relief).collect();
        let [width, height] = group.sheet.size().map(float);
        let sheet = layout::Sheet {
            size: [width, height],
            supersample: self.pass.supersample,
            reliefs: count(reliefs.len()),
            bark: self.surfaces.bark.about,
            foliage: self.surfaces.foliage.about,
        };
        let mut shots = vec![0; list.shots.len() * STRIDE];
        for (shot, place) in list.shots.iter().zip(shots.chunks_exact_mut(STRIDE)) {
            place[..size_of::<layout::Shot>()].copy_from_slice(bytemuck::bytes_of(shot));
        }
        let output = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let (of_vertices, of_indices) = (BufferUsages::VERTEX, BufferUsages::INDEX);
        Buffers {
            sheet: upload::uniform(gpu, "sheet", &sheet),
            shots: crate::gpu::upload(gpu, "shots", &shots, BufferUsages::UNIFORM),
            vertices: upload::gathered(gpu, of_vertices, vertex_count as u64, vertices()),
            indices: upload::gathered(gpu, of_indices, index_count as u64, indices()),
            grids: upload::storage(gpu, "grids", &list.grids),
            density: upload::gathered(gpu, BufferUsages::STORAGE, group.cells, densities),
            open: upload::blank(gpu, "open", group.cells, BufferUsages::STORAGE),
            reliefs: upload::storage(gpu, "reliefs", &reliefs),
            output: upload::blank(gpu, "texels", group.texels * u64::from(WORDS), output),
        }
    }

    /// Records the light that reaches the cells of all grids.
    fn light(&self, encoder: &mut wgpu::CommandEncoder, buffers: &Buffers, list: &List) {
        let pipeline = &self.baker.captures.light;
        let group = self.bound(
            &pipeline.get_bind_group_layout(0),
            &[
                (0, buffers.grids.as_entire_binding()),
                (1, buffers.density.as_entire_binding()),
                (2, buffers.open.as_entire_binding()),
            ],
        );
        let cells = list.grids.iter().map(|g| g.size.iter().product::<u32>());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        let most = cells.max().unwrap_or(0).div_ceil(64);
        pass.dispatch_workgroups(most, count(list.grids.len()), 1);
    }

    /// The sheet's targets.
    fn seen(&self, [width, height]: [u32; 2]) -> Seen {
        let target = |format| {
            let texture = self
                .baker
                .gpu
                .device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some("sheet"),
                    size: wgpu::Extent3d {
                        width,
                        height,
                        depth_or_array_layers: 1,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                        | wgpu::TextureUsages::TEXTURE_BINDING,
                    view_formats: &[],
                });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Seen {
            surface: target(TextureFormat::Rgba32Uint),
            near: target(TextureFormat::Depth32Float),
        }
    }

    /// Records the surface that each sample sees; gives the number of draws.
    fn see(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        list: &List,
        seen: &Seen,
    ) -> u64 {
        let Pipelines { bark, foliage, .. } = &self.baker.captures;
        let group = self.bound(
            &self.baker.captures.seen,
            &[
                (0, buffers.sheet.as_entire_binding()),
                (1, one_shot(buffers)),
                (2, BindingResource::TextureView(&self.surfaces.bark.view)),
                (3, BindingResource::TextureView(&self.surfaces.foliage.view)),
                (4, BindingResource::TextureView(&self.surfaces.cutout.view)),
                (5, buffers.reliefs.as_entire_binding()),
            ],
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("captures"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &seen.surface,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &seen.near,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_vertex_buffer(0, buffers.vertices.slice(..));
        pass.set_index_buffer(buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
        let mut calls = 0;
        for (which, pipeline) in [(0, bark), (1, foliage)] {
            pass.set_pipeline(pipeline);
            for (number, (shot, parts)) in list.shots.iter().zip(&list.parts).enumerate() {
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

    /// Records the averages of all texels; gives the number of dispatches.
    fn texels(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        buffers: &Buffers,
        list: &List,
        seen: &Seen,
    ) -> u64 {
        let group = self.bound(
            &self.baker.captures.texels_layout,
            &[
                (0, buffers.sheet.as_entire_binding()),
                (1, one_shot(buffers)),
                (2, BindingResource::TextureView(&seen.surface)),
                (3, BindingResource::TextureView(&seen.near)),
                (4, buffers.open.as_entire_binding()),
                (5, buffers.output.as_entire_binding()),
            ],
        );
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.baker.captures.texels);
        for (number, shot) in list.shots.iter().enumerate() {
            pass.set_bind_group(0, &group, &[count(number * STRIDE)]);
            let [across, down] = shot.texels.map(|t| t.div_ceil(TILE));
            pass.dispatch_workgroups(across, down, 1);
        }
        list.shots.len() as u64
    }

    fn bound(
        &self,
        layout: &wgpu::BindGroupLayout,
        bindings: &[(u32, BindingResource<'_>)],
    ) -> wgpu::BindGroup {
        upload::bound(&self.baker.gpu, layout, bindings)
    }
}

/// One shot of all, chosen by an offset.
fn one_shot(buffers: &Buffers) -> BindingResource<'_> {
    BindingResource::Buffer(wgpu::BufferBinding {
        buffer: &buffers.shots,
        offset: 0,
        size: wgpu::BufferSize::new(STRIDE as u64),
    })
}

fn relief(relief: &crate::mesh::card::Relief) -> Relief {
    let uv = relief.uv;
    Relief {
        uv: [uv.u0, uv.v0, uv.u1, uv.v1],
        longer: relief.longer,
        unused: [0.0; 3],
    }
}

/// Waits for all groups and unpacks their texels.
fn developed(
    baker: &Baker,
    exposed: Vec<Exposed>,
    supersample: u32,
) -> Result<Vec<Vec<Picture>>, GpuError> {
    for group in &exposed {
        group.texels.map_async(wgpu::MapMode::Read, .., |_| ());
    }
    baker.gpu.finish()?;
    let mut scenes = Vec::new();
    for Exposed { shots, texels } in exposed {
        let bytes = texels
            .get_mapped_range(..)
            .map_err(|e| GpuError::Lost(e.to_string()))?;
        let words: &[[u32; WORDS as usize]] = bytemuck::try_cast_slice(&bytes[..])
            .map_err(|e| GpuError::Refused(format!("texels came back out of line: {e}")))?;
        let mut first = 0;
        let cut = |shot: &Shot| {
            let from = first;
            first += usize::try_from(area(shot.texels)).unwrap_or(usize::MAX);
            (*shot, &words[from..first])
        };
        let lengths: Vec<usize> = shots.iter().map(Vec::len).collect();
        let pieces: Vec<(Shot, &[[u32; WORDS as usize]])> =
            shots.iter().flatten().map(cut).collect();
        let mut pictures = pieces
            .into_par_iter()
            .map(|(shot, words)| picture(shot, words, supersample))
            .collect::<Vec<_>>()
            .into_iter();
        scenes.extend(
            lengths
                .into_iter()
                .map(|n| pictures.by_ref().take(n).collect::<Vec<_>>()),
        );
    }
    Ok(scenes)
}

fn picture(shot: Shot, words: &[[u32; WORDS as usize]], supersample: u32) -> Picture {
    let share = 1.0 / float(supersample * supersample);
    let texels = words.iter().map(|words| unpacked(*words, share));
    let [width, height] = shot.texels;
    Picture {
        shot,
        image: Image::from_texels(width, height, texels.collect()),
    }
}

fn unpacked(
    [red_green, blue_open, slopes, rest, depth]: [u32; WORDS as usize],
    share: f32,
) -> Texel {
    let [roughness, translucency, low, high] = rest.to_le_bytes();
    let count = u16::from_le_bytes([low, high]);
    if count == 0 {
        return Texel::EMPTY;
    }
    let halves = |word: u32| {
        let [a, b, c, d] = word.to_le_bytes();
        [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
    };
    let part = |half: u16| f32::from(half) / 65_535.0;
    let [r, g] = halves(red_green).map(part);
    let [b, occlusion] = halves(blue_open).map(part);
    let [x, y] = halves(slopes).map(|half| f32::from(half.cast_signed()) / 32_767.0);
    let byte = |byte: u8| f32::from(byte) / 255.0;
    let normal = Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
    Texel {
        albedo: [r, g, b],
        alpha: f32::from(count) * share,
        normal: normal.normalize_or(Vec3::Z).to_array(),
        occlusion,
        roughness: byte(roughness),
        translucency: byte(translucency),
        depth: f32::from_bits(depth),
    }
}

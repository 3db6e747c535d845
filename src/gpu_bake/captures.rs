//! Captures on an adapter: scenes gathered into groups, each drawn on one sheet and read back at once.

use super::develop::{Exposed, Sent, developed, row_bytes};
use super::group::{Group, List, Ready, too_large};
use super::passes::{Buffers, Recording, STRIDE, Size, Targets};
use super::upload::{self, Surfaces};
use super::{Baker, Tally, layout, passes};
use crate::capture::{BakeError, Pass, Picture};
use crate::gpu::GpuError;
use crate::math::float;
use crate::mesh::Vertex;
use crate::report::{Cancelled, MachineFault, Progress};
use rayon::prelude::*;
use wgpu::BufferUsages;

/// Scenes that are made at a time.
const AT_A_TIME: usize = 32;

/// Draws all scenes of a pass.
pub(super) fn draw(
    baker: &Baker,
    pass: &Pass<'_>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Picture>>, BakeError> {
    let gpu = &baker.gpu;
    let mut stage = Stage {
        baker,
        pass,
        surfaces: Surfaces::new(gpu, pass).map_err(MachineFault::from)?,
        targets: baker.kept_targets(),
    };
    baker.count(Tally {
        bytes_up: stage.surfaces.bytes(),
        ..Tally::default()
    });
    let exposed = expose_all(&mut stage, progress);
    // Also of a bake that an edit cancels: the next one is about to begin.
    baker.keep(stage.targets);
    let exposed = exposed?;
    if progress.cancelled() {
        return Err(Cancelled.into());
    }
    Ok(developed(gpu, exposed, pass.supersample).map_err(MachineFault::from)?)
}

/// Makes all scenes of a pass and hands them over, group by group.
fn expose_all(stage: &mut Stage<'_>, progress: &dyn Progress) -> Result<Vec<Exposed>, BakeError> {
    let (gpu, pass) = (&stage.baker.gpu, stage.pass);
    let mut exposed = Vec::new();
    let mut group = Group::new(gpu, pass.supersample);
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
                let full = core::mem::replace(&mut group, Group::new(gpu, pass.supersample));
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
    Ok(exposed)
}

/// A pass with its textures.
struct Stage<'a> {
    baker: &'a Baker,
    pass: &'a Pass<'a>,
    surfaces: Surfaces,
    /// What the last group was drawn into.
    targets: Option<Targets>,
}

impl Stage<'_> {
    /// Hands over the drawing of a group.
    fn expose(&mut self, group: Group) -> Result<Exposed, GpuError> {
        let gpu = &self.baker.gpu;
        let list = List::of(&group);
        let [width, height] = group.texels();
        let size = Size {
            samples: group.sheet.size(),
            texels: [width, height],
            grids: group.grids,
        };
        let targets = Targets::holding(gpu, self.targets.take(), size);
        let buffers = self.buffers(&group, &list, size.samples);
        let row = row_bytes(width);
        let bytes_back = u64::from(row) * u64::from(height);
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
        let mut recording = Recording {
            gpu,
            encoder: &mut encoder,
            buffers: &buffers,
            targets: &targets,
            samples: size.samples,
            list: &list,
        };
        let pipelines = &self.baker.captures;
        let calls = pipelines.light(&mut recording)
            + pipelines.see(&mut recording, &self.surfaces)
            + pipelines.texels(&mut recording, &self.surfaces, self.pass.supersample);
        encoder.copy_texture_to_buffer(
            targets.texels.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &texels,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
        );
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        self.baker.count(Tally {
            submits: 1,
            passes: 3,
            calls,
            bytes_up: group.bytes + group.bytes_of_grids(),
            bytes_back,
        });
        self.targets = Some(targets);
        Ok(Exposed {
            shots: self.sent(group, &list),
            texels,
            row,
        })
    }

    /// Where the shots of a group come back.
    fn sent(&self, group: Group, list: &List) -> Vec<Vec<Sent>> {
        let mut drawn = list.shots.iter();
        let sent = |(shot, drawn): (_, &layout::Shot)| Sent {
            shot,
            place: drawn.place.map(|n| n / self.pass.supersample),
            depth: drawn.depths(),
        };
        let scenes = group.scenes.into_iter();
        scenes
            .map(|ready| {
                let shots = ready.scene.shots.into_iter();
                shots.zip(drawn.by_ref()).map(sent).collect()
            })
            .collect()
    }

    fn buffers(&self, group: &Group, list: &List, samples: [u32; 2]) -> Buffers {
        let gpu = &self.baker.gpu;
        let scenes = &group.scenes;
        let vertices = || scenes.iter().flat_map(Ready::vertices);
        let indices = || scenes.iter().flat_map(Ready::indices);
        let vertex_count: usize = vertices().map(<[Vertex]>::len).sum();
        let index_count: usize = indices().map(<[u32]>::len).sum();
        let sheet = layout::Sheet {
            size: samples.map(float),
            supersample: self.pass.supersample,
            longest: self.surfaces.longest,
            bark: self.surfaces.bark.about,
            foliage: self.surfaces.foliage.about,
        };
        let mut shots = vec![0; list.shots.len() * STRIDE];
        for (shot, place) in list.shots.iter().zip(shots.chunks_exact_mut(STRIDE)) {
            place[..size_of::<layout::Shot>()].copy_from_slice(bytemuck::bytes_of(shot));
        }
        let (of_vertices, of_indices) = (BufferUsages::VERTEX, BufferUsages::INDEX);
        Buffers {
            sheet: upload::uniform(gpu, "sheet", &sheet),
            shots: crate::gpu::upload(gpu, "shots", &shots, BufferUsages::UNIFORM),
            vertices: upload::gathered(gpu, of_vertices, vertex_count as u64, vertices()),
            indices: upload::gathered(gpu, of_indices, index_count as u64, indices()),
            density: self.density(group),
        }
    }

    /// The grids side by side, of each one z below the other.
    fn density(&self, group: &Group) -> wgpu::TextureView {
        let gpu = &self.baker.gpu;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let format = wgpu::TextureFormat::R32Float;
        let texture = passes::texture(gpu, "density", format, group.grids, usage);
        let mut column = 0;
        for ready in &group.scenes {
            let occlusion = &ready.scene.occlusion;
            let [across, down, deep] = occlusion.size();
            let size = [across, down * deep];
            upload::write(gpu, &texture, [column, 0], size, occlusion.density());
            column += across;
        }
        passes::whole(&texture)
    }
}

//! A forest's buffers, and the passes that choose its trees.

use super::draw::Woods;
use super::plan::{Bin, Cull, Kind, MAX_MODELS, Plan, Use, index};
use super::{ForestTree, Lists};
use crate::gpu::{Gpu, GpuError, upload};
use crate::render::binding::group;
use bytemuck::{Pod, Zeroable};
use wgpu::BufferUsages;

/// Bytes of the arguments of a draw call with indices; one without leaves the last four unused.
const CALL: u64 = 20;
/// Calls of a bin: bark, foliage, edges of both. The first is the ground shadows' in their bins.
const CALLS: usize = 4;

/// `Bin` of `forest.wgsl`, in as many bytes as uniforms are apart.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct BinUniform {
    index: u32,
    lod: f32,
    crisp: f32,
    spare: f32,
}

/// Buffers and bind groups.
#[derive(Debug)]
pub(super) struct Device {
    cull: wgpu::Buffer,
    stand: wgpu::Buffer,
    states: wgpu::Buffer,
    list: wgpu::Buffer,
    bins: wgpu::Buffer,
    draws: wgpu::Buffer,
    choosing: wgpu::BindGroup,
    /// For each bin, what its vertex shader reads.
    drawing: Vec<wgpu::BindGroup>,
}

impl Device {
    /// `indices` are those of each bin's calls; `crisp` says how far the shadow map shades one.
    pub(super) fn new(
        gpu: &Gpu,
        woods: &Woods,
        plan: &Plan,
        trees: &[ForestTree],
        indices: &[[u32; CALLS]],
        crisp: &dyn Fn(&Bin) -> f32,
    ) -> Self {
        let device = &gpu.device;
        let filled = |label, contents: &[u8], usage| upload(gpu, label, contents, usage);
        let empty = |label, words: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: words.max(1) as u64 * 4,
                usage: BufferUsages::STORAGE | usage,
                mapped_at_creation: false,
            })
        };
        let groups = trees.len().div_ceil(super::plan::GROUP as usize);
        let bins = plan.bins.len();
        let records: &[ForestTree] = if trees.is_empty() {
            &[ForestTree::zeroed()]
        } else {
            trees
        };
        let records = filled(
            "forest",
            bytemuck::cast_slice(records),
            BufferUsages::STORAGE,
        );
        let uniform = BufferUsages::UNIFORM;
        let cull = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("culling"),
            size: size_of::<Cull>() as u64,
            usage: uniform | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut kinds = plan.kinds.clone();
        kinds.resize(MAX_MODELS, Kind::zeroed());
        let kinds = filled("kinds", bytemuck::cast_slice(&kinds), uniform);
        let states = empty("states", trees.len(), BufferUsages::COPY_DST);
        let choices = empty("choices", trees.len(), BufferUsages::empty());
        let counts = empty("counts", groups * bins, BufferUsages::empty());
        let both = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let list = empty("lists", trees.len() * 4, both);
        let totals = empty("bins", bins * 2, both);
        let draws = filled(
            "calls",
            bytemuck::cast_slice(&calls(plan, indices)),
            BufferUsages::STORAGE | BufferUsages::INDIRECT,
        );
        let choosing = group(
            device,
            &woods.choosing,
            &[
                (0, cull.as_entire_binding()),
                (1, kinds.as_entire_binding()),
                (2, records.as_entire_binding()),
                (3, states.as_entire_binding()),
                (4, choices.as_entire_binding()),
                (5, counts.as_entire_binding()),
                (6, list.as_entire_binding()),
                (7, totals.as_entire_binding()),
                (8, draws.as_entire_binding()),
            ],
        );
        let stand = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stand"),
            size: 16,
            usage: uniform | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let numbered = |(index, bin): (u32, &Bin)| {
            #[expect(clippy::cast_precision_loss, reason = "a handful of LODs")]
            let own = BinUniform {
                index,
                lod: bin.lod as f32,
                crisp: crisp(bin),
                spare: 0.0,
            };
            let own = filled("bin", bytemuck::bytes_of(&own), uniform);
            group(
                device,
                &woods.drawing,
                &[
                    (0, own.as_entire_binding()),
                    (1, stand.as_entire_binding()),
                    (2, records.as_entire_binding()),
                    (3, list.as_entire_binding()),
                    (4, totals.as_entire_binding()),
                ],
            )
        };
        let drawing = (0..).zip(&plan.bins).map(numbered).collect();
        Self {
            cull,
            stand,
            states,
            list,
            bins: totals,
            draws,
            choosing,
            drawing,
        }
    }

    pub(super) fn forget(&self, gpu: &Gpu) {
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&self.states, 0, None);
        gpu.queue.submit([encoder.finish()]);
    }

    /// Tells the shaders of the frame.
    pub(super) fn write(&self, gpu: &Gpu, cull: &Cull) {
        gpu.queue
            .write_buffer(&self.cull, 0, bytemuck::bytes_of(cull));
        let [x, z, half, _] = cull.shade;
        #[expect(clippy::cast_precision_loss, reason = "at most 255 bins")]
        let stand = [x, z, half, cull.counts[2] as f32];
        gpu.queue
            .write_buffer(&self.stand, 0, bytemuck::cast_slice(&stand));
    }

    /// The passes of `cull.wgsl`.
    pub(super) fn choose(&self, encoder: &mut wgpu::CommandEncoder, woods: &Woods, cull: &Cull) {
        let [_, groups, bins, _] = cull.counts;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("choice"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &self.choosing, &[]);
        let [choose, add_up, lay_out, scatter] = &woods.passes;
        for (pipeline, groups) in [
            (choose, groups),
            (add_up, bins),
            (lay_out, 1),
            (scatter, groups),
        ] {
            if groups > 0 {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
    }

    /// Puts lists that a processor made in the place of those of the passes.
    pub(super) fn put(&self, gpu: &Gpu, lists: &Lists) {
        let bins = lists.starts.len() - 1;
        gpu.queue
            .write_buffer(&self.list, 0, bytemuck::cast_slice(&lists.entries));
        gpu.queue.write_buffer(
            &self.bins,
            bins as u64 * 4,
            bytemuck::cast_slice(&lists.starts[..bins]),
        );
    }

    pub(super) fn bind(&self, pass: &mut wgpu::RenderPass<'_>, bin: usize) {
        pass.set_bind_group(3, &self.drawing[bin], &[]);
    }

    /// Where the arguments of a call of a bin stand.
    pub(super) fn call(&self, bin: usize, call: usize) -> (&wgpu::Buffer, u64) {
        (&self.draws, (bin * CALLS + call) as u64 * CALL)
    }

    pub(super) fn lists(&self, gpu: &Gpu, bins: usize) -> Result<Lists, GpuError> {
        let totals = read(gpu, &self.bins)?;
        let mut starts = totals[bins..].to_vec();
        let end = totals[..bins].iter().sum();
        starts.push(end);
        let mut entries = read(gpu, &self.list)?;
        entries.truncate(end as usize);
        Ok(Lists { entries, starts })
    }
}

/// Arguments of all calls, with no instance yet.
fn calls(plan: &Plan, indices: &[[u32; CALLS]]) -> Vec<u32> {
    let of_bin = |(bin, indices): (&Bin, &[u32; CALLS])| {
        let corners = [6, 0, 0, 0];
        let counts = match bin.of {
            Use::Ground => corners,
            Use::Draw | Use::Cast => *indices,
        };
        counts.map(|count| [count, 0, 0, 0, 0])
    };
    plan.bins
        .iter()
        .zip(indices)
        .flat_map(of_bin)
        .flatten()
        .chain([index(0); 5])
        .collect()
}

/// All words of a buffer.
fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u32>, GpuError> {
    let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: buffer.size(),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, Some(buffer.size()));
    gpu.queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.finish()?;
    let bytes = copy
        .get_mapped_range(..)
        .map_err(|e| GpuError::Lost(e.to_string()))?;
    Ok(bytemuck::cast_slice(&bytes).to_vec())
}

//! Ground shadows on an adapter: batches of samples marked in bit masks and summed.

use super::layout::{Job, Level, Projection};
use super::{Baker, Tally, upload};
use crate::gpu::{Gpu, GpuError, shader};
use crate::report::{Cancelled, MachineFault, Progress};
use crate::shadow::{BakeError, Coverage, Light, Work};
use wgpu::{Buffer, BufferUsages};

/// Bytes that the masks of a batch may have.
const MASK_BYTES: u64 = 64 << 20;

/// Triangles of a workgroup, and pairs of texels of one, as in `shaders/shadow_bake.wgsl`.
const GROUP: u32 = 64;

/// Workgroups along one axis: fewer than every adapter allows.
const ROW: u32 = 32_768;

/// What is compiled once.
#[derive(Debug)]
pub(super) struct Pipelines {
    hard: wgpu::ComputePipeline,
    sum: wgpu::ComputePipeline,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let module = shader::SHADOWS.module(device);
        let [hard, sum] = ["cs_hard", "cs_sum"].map(|entry| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        Self { hard, sum }
    }
}

/// The summed shares of every light.
pub(super) fn sums(
    baker: &Baker,
    work: &Work<'_>,
    progress: &dyn Progress,
) -> Result<Vec<Vec<u16>>, BakeError> {
    let bench = Bench::new(baker, work).map_err(MachineFault::from)?;
    let mut sums = Vec::new();
    let lights = bench.lights_at_a_time(work.lights.len());
    for lights in work.lights.chunks(lights) {
        if progress.cancelled() {
            return Err(Cancelled.into());
        }
        sums.extend(bench.sums(lights).map_err(MachineFault::from)?);
        let samples = lights.iter().flat_map(|light| &light.samples);
        samples.for_each(|_| progress.step());
    }
    Ok(sums)
}

/// What all lights share, on the adapter.
struct Bench<'a> {
    baker: &'a Baker,
    job: Job,
    points: Buffer,
    bark: Buffer,
    leaves: Buffer,
    levels: Buffer,
    coverage: Buffer,
}

impl<'a> Bench<'a> {
    fn new(baker: &'a Baker, work: &Work<'_>) -> Result<Self, GpuError> {
        let gpu = &baker.gpu;
        let casters = work.casters;
        check(gpu, work)?;
        let (levels, coverage) = packed(work.coverage);
        let bytes_up = size_of_val(&casters.points[..])
            + size_of_val(&casters.bark[..])
            + size_of_val(&casters.leaves[..])
            + size_of_val(&coverage[..]);
        baker.count(Tally {
            bytes_up: bytes_up as u64,
            ..Tally::default()
        });
        Ok(Self {
            baker,
            job: Job {
                size: work.size,
                row: work.size.div_ceil(32),
                bark: count(casters.bark.len()),
                leaves: count(casters.leaves.len()),
                samples: 0,
                first: 0,
                a_light: count(work.lights.first().map_or(0, |l| l.samples.len())),
                mips: count(levels.len()),
            },
            points: upload::storage(gpu, "points", &casters.points),
            bark: upload::storage(gpu, "bark", &casters.bark),
            leaves: upload::storage(gpu, "leaves", &casters.leaves),
            levels: upload::storage(gpu, "levels", &levels),
            coverage: upload::storage(gpu, "coverage", &coverage),
        })
    }

    /// Words of one light's sums, two texels each.
    fn pairs(&self) -> u64 {
        (u64::from(self.job.size) * u64::from(self.job.size)).div_ceil(2)
    }

    /// Lights whose sums fit one buffer.
    fn lights_at_a_time(&self, lights: usize) -> usize {
        let limits = self.baker.gpu.device.limits();
        let fit = limits.max_storage_buffer_binding_size / (self.pairs() * 4);
        usize::try_from(fit)
            .unwrap_or(usize::MAX)
            .clamp(1, lights.max(1))
    }

    fn sums(&self, lights: &[Light]) -> Result<Vec<Vec<u16>>, GpuError> {
        let gpu = &self.baker.gpu;
        let words = self.pairs() * lights.len() as u64;
        let all: Vec<Projection> = lights.iter().flat_map(projections).collect();
        let projections = upload::storage(gpu, "projections", &all);
        let a_mask = u64::from(self.job.row) * u64::from(self.job.size) * 4;
        let samples = usize::try_from(MASK_BYTES / a_mask).unwrap_or(1).max(1);
        let samples = samples.min(ROW as usize);
        let masks = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let at_a_time = samples.min(all.len()).max(1) as u64;
        let masks = upload::blank(gpu, "masks", a_mask / 4 * at_a_time, masks);
        let output = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let output = upload::blank(gpu, "sums", words, output);
        let back = BufferUsages::COPY_DST | BufferUsages::MAP_READ;
        let back = upload::blank(gpu, "shadows back", words, back);
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("shadows"),
            });
        let mut passes = 0;
        for (number, batch) in (0..).zip(all.chunks(samples)) {
            let job = Job {
                samples: count(batch.len()),
                first: number * count(samples),
                ..self.job
            };
            self.record(
                &mut encoder,
                &job,
                &projections,
                (&masks, &output),
                lights.len(),
            );
            passes += 2;
        }
        encoder.copy_buffer_to_buffer(&output, 0, &back, 0, None);
        gpu.queue.submit([encoder.finish()]);
        gpu.check()?;
        self.baker.count(Tally {
            submits: 1,
            passes,
            calls: passes,
            bytes_up: size_of_val(&all[..]) as u64,
            bytes_back: words * 4,
        });
        read(gpu, &back, (self.pairs(), self.job.size))
    }

    /// Records one batch of samples.
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        job: &Job,
        projections: &Buffer,
        (masks, output): (&Buffer, &Buffer),
        lights: usize,
    ) {
        let gpu = &self.baker.gpu;
        let Pipelines { hard, sum } = &self.baker.shadows;
        let uniform = upload::uniform(gpu, "shadow job", job);
        let of_hard = upload::bound(
            gpu,
            &hard.get_bind_group_layout(0),
            &[
                (0, uniform.as_entire_binding()),
                (1, projections.as_entire_binding()),
                (2, self.points.as_entire_binding()),
                (3, self.bark.as_entire_binding()),
                (4, self.leaves.as_entire_binding()),
                (5, self.levels.as_entire_binding()),
                (6, self.coverage.as_entire_binding()),
                (7, masks.as_entire_binding()),
            ],
        );
        let of_sum = upload::bound(
            gpu,
            &sum.get_bind_group_layout(0),
            &[
                (0, uniform.as_entire_binding()),
                (1, projections.as_entire_binding()),
                (7, masks.as_entire_binding()),
                (8, output.as_entire_binding()),
            ],
        );
        encoder.clear_buffer(masks, 0, None);
        let triangles = (job.bark + job.leaves).div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(hard);
        pass.set_bind_group(0, &of_hard, &[]);
        pass.dispatch_workgroups(triangles, count(lights), 1);
        drop(pass);
        let groups = count(usize::try_from(self.pairs()).unwrap_or(usize::MAX)).div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(sum);
        pass.set_bind_group(0, &of_sum, &[]);
        pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), count(lights));
    }
}

/// Refuses what the adapter's buffers cannot hold.
fn check(gpu: &Gpu, work: &Work<'_>) -> Result<(), GpuError> {
    let casters = work.casters;
    let binding = gpu.device.limits().max_storage_buffer_binding_size;
    let texels: usize = work.coverage.levels().iter().map(|l| l.texels.len()).sum();
    let leaves = size_of_val(&casters.leaves[..]).max(size_of_val(&casters.points[..]));
    let map = u64::from(work.size) * u64::from(work.size) * 2;
    for (what, size, limit) in [
        ("the foliage's coverage, bytes,", texels as u64, binding),
        ("what casts shadows, bytes,", leaves as u64, binding),
        ("a shadow map, bytes,", map, binding),
        (
            "what casts shadows, triangles,",
            (casters.bark.len() + casters.leaves.len()) as u64,
            u64::from(ROW * GROUP),
        ),
    ] {
        if size > limit {
            return Err(GpuError::TooLarge { what, size, limit });
        }
    }
    Ok(())
}

/// A number of things that fits 32 bits, as [`check`] has seen to.
fn count(things: usize) -> u32 {
    u32::try_from(things).unwrap_or(u32::MAX)
}

/// All mips in one list of bytes, four a word.
fn packed(coverage: &Coverage) -> (Vec<Level>, Vec<u32>) {
    let mut bytes = Vec::new();
    let level = |level: &crate::shadow::Level| {
        let first = count(bytes.len());
        bytes.extend_from_slice(&level.texels);
        Level {
            width: level.width,
            height: level.height,
            scale: level.scale,
            first,
            unused: 0,
        }
    };
    let levels = coverage.levels().iter().map(level).collect();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let words = bytes.as_chunks::<4>().0.iter();
    (levels, words.map(|w| u32::from_le_bytes(*w)).collect())
}

fn projections(light: &Light) -> impl Iterator<Item = Projection> {
    let samples = light.samples.iter().zip(&light.shares).zip(0..);
    samples.map(|((sample, &share), number)| Projection {
        origin: sample.origin.to_array(),
        a_metre: sample.a_metre.to_array(),
        lean: sample.lean.to_array(),
        along: light.stray.along.to_array(),
        across: light.stray.across.to_array(),
        share: u32::from(share),
        number,
    })
}

/// Waits for the sums of some lights.
fn read(gpu: &Gpu, back: &Buffer, (pairs, size): (u64, u32)) -> Result<Vec<Vec<u16>>, GpuError> {
    back.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.finish()?;
    let bytes = back
        .get_mapped_range(..)
        .map_err(|e| GpuError::Lost(e.to_string()))?;
    let a_light = usize::try_from(pairs * 4).unwrap_or(usize::MAX);
    let texels = size as usize * size as usize;
    let light = |bytes: &[u8]| {
        let halves = bytes.as_chunks::<2>().0.iter().take(texels);
        halves.map(|h| u16::from_le_bytes(*h)).collect()
    };
    Ok(bytes.chunks_exact(a_light).map(light).collect())
}

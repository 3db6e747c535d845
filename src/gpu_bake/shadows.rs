//! Ground shadows on an adapter: batches of samples marked in bit masks and summed.

use super::layout::{BATCH, Job, Projection};
use super::{Baker, Tally, passes, upload};
use crate::gpu::{Gpu, GpuError, shader};
use crate::math::{Vec2, floor_to_u32};
use crate::report::{Cancelled, MachineFault, Progress};
use crate::shadow::{BakeError, Coverage, Light, Work};
use bytemuck::Zeroable;
use rayon::prelude::*;
use wgpu::{Buffer, BufferUsages};

/// Bytes that the masks of a batch may have.
const MASK_BYTES: u64 = 64 << 20;

/// Threads of a workgroup that sums, as in `shaders/shadow_bake.wgsl`; on a card also of one that marks.
const GROUP: u32 = 64;

/// Loops that a thread may go through: a software driver ends it after 65,535, and samples of a light differ a little.
const LOOPS: u32 = 40_000;

/// Most workgroups along one axis on every adapter.
const MOST_GROUPS: u32 = 65_535;

/// Workgroups along one axis: fewer than every adapter allows.
const ROW: u32 = 32_768;

/// What is compiled once.
#[derive(Debug)]
pub(super) struct Pipelines {
    hard: wgpu::ComputePipeline,
    sum: wgpu::ComputePipeline,
    team: Team,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let device = &gpu.device;
        let module = shader::SHADOWS.module(device);
        let team = Team::of(gpu);
        let pipeline = |entry, constants: &[(&str, f64)]| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants,
                    ..wgpu::PipelineCompilationOptions::default()
                },
                cache: None,
            })
        };
        Self {
            hard: pipeline("cs_hard", &[("THREADS", team.threads.into())]),
            sum: pipeline("cs_sum", &[]),
            team,
        }
    }
}

/// How many threads share a batch's samples.
#[derive(Clone, Copy, Debug)]
struct Team {
    /// Threads of a workgroup that marks.
    threads: u32,
    /// Most samples of a thread.
    masks: u32,
}

impl Team {
    /// A card keeps many threads busy. On a software driver each of them reads a triangle by itself: as few as it runs
    /// at once then draw it for the whole batch, which takes half as long.
    fn of(gpu: &Gpu) -> Self {
        let threads = if gpu.is_software() { 8 } else { GROUP };
        let masks = if gpu.is_software() {
            count(BATCH).div_ceil(threads)
        } else {
            2
        };
        Self { threads, masks }
    }

    /// How many triangles a thread draws, and into how many masks: fewer of large ones. One that fills a map of more
    /// than 256 texels may still be too much for a software driver.
    fn shares(self, work: &Work<'_>) -> (u32, u32) {
        let casters = work.casters;
        let most = most_loops(work);
        let triangles = count(casters.bark.len() + casters.leaves.len());
        let least = triangles.div_ceil(MOST_GROUPS).max(1);
        let masks = (LOOPS / most.saturating_mul(least)).clamp(1, self.masks);
        let triangles = LOOPS / most.saturating_mul(masks);
        (triangles.clamp(1, 64), masks)
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
    coverage: wgpu::TextureView,
}

impl<'a> Bench<'a> {
    fn new(baker: &'a Baker, work: &Work<'_>) -> Result<Self, GpuError> {
        let gpu = &baker.gpu;
        let casters = work.casters;
        let (triangles, masks) = baker.shadows.team.shares(work);
        check(gpu, work, triangles)?;
        let groups = count(casters.bark.len() + casters.leaves.len()).div_ceil(triangles);
        let coverage = Mips::new(gpu, work.coverage)?;
        let bytes_up = size_of_val(&casters.points[..])
            + size_of_val(&casters.bark[..])
            + size_of_val(&casters.leaves[..]);
        baker.count(Tally {
            bytes_up: bytes_up as u64 + coverage.bytes,
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
                groups,
                coverage: coverage.size,
                mips: coverage.mips,
                masks,
            },
            points: upload::storage(gpu, "points", &casters.points),
            bark: upload::storage(gpu, "bark", &casters.bark),
            leaves: upload::storage(gpu, "leaves", &casters.leaves),
            coverage: coverage.view,
        })
    }

    /// Words of a mask.
    fn words(&self) -> u64 {
        u64::from(self.job.row) * u64::from(self.job.size)
    }

    /// Words of one light's sums, two texels each.
    fn pairs(&self) -> u64 {
        self.words() * 16
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
        let samples = usize::try_from(MASK_BYTES / (self.words() * 4)).unwrap_or(1);
        let samples = samples.clamp(1, BATCH);
        let masks = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let at_a_time = samples.min(all.len()).max(1) as u64;
        let masks = upload::blank(gpu, "masks", self.words() * at_a_time, masks);
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
            self.record(&mut encoder, (&job, batch), (&masks, &output), lights.len());
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
        (job, batch): (&Job, &[Projection]),
        (masks, output): (&Buffer, &Buffer),
        lights: usize,
    ) {
        let gpu = &self.baker.gpu;
        let Pipelines { hard, sum, team } = &self.baker.shadows;
        let uniform = upload::uniform(gpu, "shadow job", job);
        let mut samples = [Projection::zeroed(); BATCH];
        samples[..batch.len()].copy_from_slice(batch);
        let samples = upload::uniform(gpu, "samples", &samples);
        let of_hard = upload::bound(
            gpu,
            &hard.get_bind_group_layout(0),
            &[
                (0, uniform.as_entire_binding()),
                (1, samples.as_entire_binding()),
                (2, self.points.as_entire_binding()),
                (3, self.bark.as_entire_binding()),
                (4, self.leaves.as_entire_binding()),
                (5, wgpu::BindingResource::TextureView(&self.coverage)),
                (6, masks.as_entire_binding()),
            ],
        );
        let of_sum = upload::bound(
            gpu,
            &sum.get_bind_group_layout(0),
            &[
                (0, uniform.as_entire_binding()),
                (1, samples.as_entire_binding()),
                (7, masks.as_entire_binding()),
                (8, output.as_entire_binding()),
            ],
        );
        encoder.clear_buffer(masks, 0, None);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(hard);
        pass.set_bind_group(0, &of_hard, &[]);
        pass.dispatch_workgroups(
            job.groups,
            job.samples.div_ceil(team.threads * job.masks),
            1,
        );
        drop(pass);
        let halves = usize::try_from(self.words() * 2).unwrap_or(usize::MAX);
        let groups = count(halves).div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(sum);
        pass.set_bind_group(0, &of_sum, &[]);
        pass.dispatch_workgroups(groups.min(ROW), groups.div_ceil(ROW), count(lights));
    }
}

/// Loops that a thread goes through for the largest triangle of a sample, at least one.
fn most_loops(work: &Work<'_>) -> u32 {
    let casters = work.casters;
    let most = work.lights.par_iter().filter_map(|light| {
        let sample = light.samples.first()?;
        let shadow = |&at: &u32| {
            let [x, y, z] = casters.points[at as usize];
            Vec2::new(x, z) * sample.a_metre - sample.lean * y
        };
        let extent = |corners: &[u32; 3]| {
            let [a, b, c] = corners.each_ref().map(shadow);
            let [across, down] = (a.max(b).max(c) - a.min(b).min(c)).to_array();
            let within = |length: f32| floor_to_u32(length.max(0.0)).min(work.size) + 1;
            (within(across), within(down))
        };
        // The sample and its last look; rows; words, of which a span may touch one more; texels.
        let leaf = |(across, down): (u32, u32)| 2 + down.saturating_mul(across + across / 16 + 4);
        let solid = |(across, down): (u32, u32)| 2 + down.saturating_mul(across / 32 + 4);
        let leaves = casters.leaves.iter().map(|l| leaf(extent(&l.corners)));
        leaves
            .chain(casters.bark.iter().map(|c| solid(extent(c))))
            .max()
    });
    most.max().unwrap_or(1)
}

/// Refuses what the adapter's buffers cannot hold, and more triangles than its threads draw, so many each.
fn check(gpu: &Gpu, work: &Work<'_>, a_thread: u32) -> Result<(), GpuError> {
    let casters = work.casters;
    let binding = gpu.device.limits().max_storage_buffer_binding_size;
    let leaves = size_of_val(&casters.leaves[..]).max(size_of_val(&casters.points[..]));
    let map = u64::from(work.size.div_ceil(32) * work.size) * 64;
    for (what, size, limit) in [
        ("what casts shadows, bytes,", leaves as u64, binding),
        ("a shadow map, bytes,", map, binding),
        (
            "what casts shadows, triangles,",
            (casters.bark.len() + casters.leaves.len()) as u64,
            u64::from(MOST_GROUPS * a_thread),
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

/// All mips of the coverage, as those of captures lie, four texels a word.
struct Mips {
    view: wgpu::TextureView,
    size: [u32; 2],
    mips: u32,
    bytes: u64,
}

impl Mips {
    fn new(gpu: &Gpu, coverage: &Coverage) -> Result<Self, GpuError> {
        let levels = coverage.levels();
        let (width, height) = (levels[0].width, levels[0].height);
        let [across, down] = upload::size_with_mips(gpu, "foliage's coverage", [width, height])?;
        let levels = &levels[..upload::mips(levels.len(), [width, height])];
        let row = across.next_multiple_of(4);
        let mut texels = vec![0; row as usize * down as usize];
        for (number, level) in (0..).zip(levels) {
            let [x, y] = upload::corner_of_mip([width, height], number);
            let from = level.texels.chunks_exact(level.width as usize);
            let to = texels.chunks_exact_mut(row as usize).skip(y as usize);
            for (from, to) in from.zip(to) {
                to[x as usize..][..from.len()].copy_from_slice(from);
            }
        }
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST;
        let (format, words) = (wgpu::TextureFormat::R32Uint, [row / 4, down]);
        let texture = passes::texture(gpu, "coverage", format, words, usage);
        Ok(Self {
            bytes: upload::write(gpu, &texture, [0, 0], words, texels.as_chunks::<4>().0),
            view: passes::whole(&texture),
            size: [width, height],
            mips: count(levels.len()),
        })
    }
}

fn projections(light: &Light) -> impl Iterator<Item = Projection> {
    let samples = light.samples.iter().zip(&light.shares).zip(0..);
    samples.map(|((sample, &share), number)| Projection {
        origin: sample.origin.to_array(),
        lean: sample.lean.to_array(),
        a_metre: sample.a_metre.to_array(),
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
    let row = size.next_multiple_of(32) as usize * 2;
    let light = |bytes: &[u8]| {
        let rows = bytes.chunks_exact(row).map(|row| &row[..size as usize * 2]);
        let halves = rows.flat_map(|row| row.as_chunks::<2>().0);
        halves.map(|h| u16::from_le_bytes(*h)).collect()
    };
    Ok(bytes.par_chunks_exact(a_light).map(light).collect())
}

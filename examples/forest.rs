//! The paper's forest, then larger ones: `cargo run --release --features gpu --example forest -- [OPTION...]`.
//!
//! Draws the rows of Table II of Koniaris et al. 2009 with our trees at the same triangle budgets, at 1024x768, in
//! two ways in turn: a draw call for each tree, as in the paper, and instanced indirect calls whose trees the GPU
//! chooses. `detail` is set so that a row draws as many triangles as the paper's. Then forests of 100,000 and of
//! 1,000,000 trees, and full meshes against the chain of LODs at a mean FLIP of at most 0.05.
//!
//! Options: `--frames N` (11), `--rows 1,3` (rows of the table, from 1; all; 0 for none), `--most N` (1000000; larger forests are left out), `--full N` (300; trees of the
//! comparison with full meshes; 0 leaves it out), `--away X` (1; how many times farther these are seen from), `--pictures FOLDER` (writes what was drawn).

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use pleach::asset::TreeAsset;
use pleach::gpu::Gpu;
use pleach::image::{Image, png};
use pleach::math::{Vec3, float};
use pleach::measure::flip;
use pleach::pipeline::{self, Settings};
use pleach::render::forest::{Calls, Forest, Planting, Twin, plant};
use pleach::render::{Camera, Lens, Renderer, Scene};
use pleach::report::Quiet;
use pleach::species::{self, Beside};

type Failure = Box<dyn Error>;

const SIZE: [u32; 2] = [1024, 768];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A row of the paper's table: trees, triangles, budgets of the chain, frames a second.
const ROWS: [(u32, u64, &[u64], f64); 4] = [
    (5_929, 5_500_000, &[10_640, 836, 248, 4], 9.1),
    (5_929, 960_000, &[836, 248, 4], 14.3),
    (5_929, 370_000, &[248, 4], 18.2),
    (381, 5_500_000, &[52_000, 4], 30.0),
];

struct Options {
    frames: u32,
    rows: Vec<usize>,
    most: u32,
    full: u32,
    away: f32,
    pictures: Option<PathBuf>,
}

fn options() -> Result<Options, Failure> {
    let mut options = Options {
        frames: 11,
        rows: (1..=ROWS.len()).collect(),
        most: 1_000_000,
        full: 300,
        away: 1.0,
        pictures: None,
    };
    let mut args = std::env::args().skip(1);
    while let Some(name) = args.next() {
        let value = args.next().ok_or_else(|| format!("{name} needs a value"))?;
        match name.as_str() {
            "--frames" => options.frames = value.parse()?,
            "--rows" => {
                options.rows = value.split(',').map(str::parse).collect::<Result<_, _>>()?;
            }
            "--most" => options.most = value.parse()?,
            "--full" => options.full = value.parse()?,
            "--away" => options.away = value.parse()?,
            "--pictures" => options.pictures = Some(value.into()),
            _ => return Err(format!("unknown option {name}; see the head of this file").into()),
        }
    }
    options.frames = options.frames.max(1);
    Ok(options)
}

fn main() -> Result<(), Failure> {
    let options = options()?;
    let gpu = Gpu::headless()?;
    println!("{}", gpu.describe());
    println!("\n{HEAD}");
    for (row, &(trees, triangles, budgets, fps)) in ROWS.iter().enumerate() {
        if !options.rows.contains(&(row + 1)) {
            continue;
        }
        let mut bench = Bench::new(&gpu, budgets, false, trees)?;
        bench.aim(triangles);
        let calls = [Calls::EachTree, Calls::Indirect];
        let [each, indirect] = bench.compare(&options, calls)?;
        let reached = bench.reached.clone();
        println!("{}", line(&bench, fps, &each, &indirect));
        println!("      LODs of {reached:?} triangles, budgets {budgets:?}");
        bench.save(&options, &format!("row{row}"))?;
    }
    for trees in [100_000, 1_000_000]
        .into_iter()
        .filter(|&n| n <= options.most)
    {
        large(&gpu, &options, trees)?;
    }
    if options.full > 0 {
        against_full_meshes(&gpu, &options)?;
    }
    Ok(())
}

const HEAD: &str = "\
trees   triangles  | paper ms | a call a tree: calls  CPU ms  frame ms | indirect: calls  CPU ms  frame ms  GPU ms | CPU less  frame less";

fn line(bench: &Bench, fps: f64, each: &Times, indirect: &Times) -> String {
    format!(
        "{:>6} {:>10}  | {:>8.1} | {:>20} {:>7.2} {:>9.1} | {:>15} {:>7.3} {:>9.1} {:>7} | {:>7.1}x {:>9.2}x",
        bench.forest.trees().len(),
        bench.triangles(),
        1000.0 / fps,
        each.calls,
        each.cpu,
        each.frame,
        indirect.calls,
        indirect.cpu,
        indirect.frame,
        indirect.gpu.map_or("-".to_owned(), |ms| format!("{ms:.2}")),
        each.cpu / indirect.cpu,
        each.frame / indirect.frame,
    )
}

/// Medians, milliseconds.
#[derive(Default)]
struct Times {
    calls: u32,
    /// Encoding and submitting.
    cpu: f64,
    /// Until the picture is there.
    frame: f64,
    /// Between two timestamps around it, where the adapter has them.
    gpu: Option<f64>,
}

/// A forest with its renderer and a camera that sees all of it.
struct Bench {
    renderer: Renderer,
    forest: Forest,
    scene: Scene,
    output: wgpu::TextureView,
    /// Triangles of the LODs.
    reached: Vec<u64>,
}

fn grown(budgets: &[u64], full: bool) -> Result<TreeAsset, Failure> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("species");
    let text = std::fs::read_to_string(root.join("olive.ron"))?;
    let species = species::parse("olive.ron", &text, &Beside(root.clone()))?;
    let settings = Settings {
        budgets: Some(budgets.to_vec()),
        full,
        ..Settings::default()
    };
    Ok(pipeline::generate(
        &species,
        &settings,
        &Beside(root),
        &Quiet,
    )?)
}

impl Bench {
    fn new(gpu: &Gpu, budgets: &[u64], full: bool, trees: u32) -> Result<Self, Failure> {
        let asset = grown(budgets, full)?;
        let mut renderer = Renderer::new(gpu, FORMAT)?;
        renderer.add(&asset.drawable())?;
        let size = renderer.models()[0].bounds.size();
        let planting = Planting {
            trees,
            spacing_m: size.x.max(size.z) * 0.9,
            ..Planting::default()
        };
        let mut forest = renderer.forest(&plant(&planting))?;
        forest.settings.fade_seconds = 0.0;
        let half = planting.half_edge_m();
        let eye = Vec3::new(0.0, half * 0.25 + size.y, half * 1.75);
        let camera = Camera {
            eye,
            target: Vec3::new(0.0, 0.0, half * 0.1),
            lens: Lens::Perspective(0.8),
        };
        let scene = Scene {
            groups: Vec::new(),
            ..Scene::of_one(camera, 0, 0)
        };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: SIZE[0],
                height: SIZE[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Ok(Self {
            output: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            reached: asset.lods.iter().map(|l| l.mesh.triangles()).collect(),
            renderer,
            forest,
            scene,
        })
    }

    /// Triangles that a frame draws, without those of the shadow map.
    fn triangles(&self) -> u64 {
        let trees = self.forest.trees();
        let cull = self.forest.cull(&self.scene, SIZE);
        let mut twin = Twin::new(trees.len());
        let lists = twin.choose(self.forest.plan(), trees, &cull);
        self.forest.counts(lists, self.renderer.models()).triangles
    }

    /// Sets the detail so that a frame draws about so many triangles.
    fn aim(&mut self, triangles: u64) {
        let [mut low, mut high] = [1e-3_f32, 1e3];
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            self.forest.settings.detail = middle;
            if self.triangles() < triangles {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.forest.settings.detail = low;
    }

    /// Draws frames in turn in each of several ways.
    fn compare<const N: usize>(
        &mut self,
        options: &Options,
        ways: [Calls; N],
    ) -> Result<[Times; N], Failure> {
        let mut samples: [Vec<[f64; 3]>; N] = std::array::from_fn(|_| Vec::new());
        let mut times: [Times; N] = std::array::from_fn(|_| Times::default());
        // The first frame of each compiles its shaders.
        for frame in 0..=options.frames {
            for ((way, samples), times) in ways.iter().zip(&mut samples).zip(&mut times) {
                self.forest.settings.calls = *way;
                let sample = self.frame(frame)?;
                times.calls = self.forest.calls();
                if frame > 0 {
                    samples.push(sample);
                }
            }
        }
        for (samples, times) in samples.iter().zip(&mut times) {
            let of = |at: usize| median(samples.iter().map(|s| s[at]).collect());
            (times.cpu, times.frame) = (of(0), of(1));
            times.gpu = Some(of(2)).filter(|t| t.is_finite());
        }
        Ok(times)
    }

    /// One frame from a camera that turns a little: processor, whole, GPU, milliseconds.
    fn frame(&mut self, index: u32) -> Result<[f64; 3], Failure> {
        let gpu = self.renderer.gpu().clone();
        let mut scene = self.scene.clone();
        scene.camera.eye.x += float(index % 7) * 0.2;
        let clock = Clock::new(&gpu);
        gpu.finish()?;
        let start = Instant::now();
        let mut encoder =
            self.renderer
                .draw_forest(&mut self.forest, &scene, &self.output, SIZE)?;
        let [before, after] = clock.mark(&gpu, &mut encoder);
        let commands = before.into_iter().chain([encoder.finish()]).chain(after);
        gpu.queue.submit(commands);
        let cpu = start.elapsed();
        gpu.finish()?;
        let whole = start.elapsed();
        let ticks = clock.read(&gpu)?;
        Ok([ms(cpu), ms(whole), ticks])
    }

    fn picture(&mut self) -> Result<Image<[u8; 4]>, Failure> {
        let scene = self.scene.clone();
        self.forest.forget(&self.renderer.gpu().clone());
        Ok(self
            .renderer
            .picture_of_forest(&mut self.forest, &scene, SIZE)?)
    }

    fn save(&mut self, options: &Options, name: &str) -> Result<(), Failure> {
        if let Some(folder) = &options.pictures {
            std::fs::create_dir_all(folder)?;
            let picture = self.picture()?;
            std::fs::write(folder.join(format!("{name}.png")), png::encode(&picture)?)?;
        }
        Ok(())
    }
}

fn ms(time: std::time::Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Two timestamps around a frame, where the adapter has them.
struct Clock {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer, wgpu::Buffer)>,
}

impl Clock {
    fn new(gpu: &Gpu) -> Self {
        let has = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let queries = gpu.device.features().contains(has).then(|| {
            let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            let buffer = |usage| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: None,
                    size: 16,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
            let read = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
            (set, resolved, read)
        });
        Self { queries }
    }

    /// Commands to be submitted before; the stamp after goes to the end of the frame's own.
    fn mark(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
    ) -> [Option<wgpu::CommandBuffer>; 2] {
        let Some((set, resolved, read)) = &self.queries else {
            return [None, None];
        };
        let new = || {
            gpu.device
                .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
        };
        let (mut before, mut after) = (new(), new());
        before.write_timestamp(set, 0);
        encoder.write_timestamp(set, 1);
        after.resolve_query_set(set, 0..2, resolved, 0);
        after.copy_buffer_to_buffer(resolved, 0, read, 0, Some(16));
        [Some(before.finish()), Some(after.finish())]
    }

    /// Milliseconds between them; not a number without.
    fn read(&self, gpu: &Gpu) -> Result<f64, Failure> {
        let Some((_, _, read)) = &self.queries else {
            return Ok(f64::NAN);
        };
        read.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.finish()?;
        let bytes = read.get_mapped_range(..)?;
        let ticks: &[u64] = bytemuck::cast_slice(&bytes);
        let ticks = ticks[1].saturating_sub(ticks[0]);
        Ok(ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) / 1e6)
    }
}

/// A forest larger than the paper's.
fn large(gpu: &Gpu, options: &Options, trees: u32) -> Result<(), Failure> {
    let mut bench = Bench::new(gpu, &[10_640, 836, 248, 4], false, trees)?;
    let [times] = bench.compare(options, [Calls::Indirect])?;
    println!(
        "\n{trees} trees, {} triangles in {} calls: CPU {:.3} ms, frame {:.1} ms, GPU {} ms",
        bench.triangles(),
        times.calls,
        times.cpu,
        times.frame,
        times.gpu.map_or("-".to_owned(), |ms| format!("{ms:.2}")),
    );
    let mut passes = Vec::new();
    let mut twins = Vec::new();
    let records = bench.forest.trees().to_vec();
    let mut twin = Twin::new(records.len());
    for _ in 0..options.frames {
        let clock = Clock::new(gpu);
        let mut encoder = bench
            .renderer
            .choose_forest(&mut bench.forest, &bench.scene, SIZE);
        let [before, after] = clock.mark(gpu, &mut encoder);
        let start = Instant::now();
        gpu.queue
            .submit(before.into_iter().chain([encoder.finish()]).chain(after));
        gpu.finish()?;
        let wall = ms(start.elapsed());
        let ticks = clock.read(gpu)?;
        passes.push(if ticks.is_finite() { ticks } else { wall });
        let cull = bench.forest.cull(&bench.scene, SIZE);
        let start = Instant::now();
        twin.choose(bench.forest.plan(), &records, &cull);
        twins.push(ms(start.elapsed()));
    }
    println!(
        "      culling and LOD choice: {:.2} ms by the passes, {:.2} ms by the processor ({} threads)",
        median(passes),
        median(twins),
        std::thread::available_parallelism()?,
    );
    bench.save(options, &format!("trees{trees}"))
}

/// Full meshes against the chain of LODs, at equal error of the picture.
fn against_full_meshes(gpu: &Gpu, options: &Options) -> Result<(), Failure> {
    let budgets = [10_640, 2_000, 836, 248, 8];
    let mut bench = Bench::new(gpu, &budgets, true, options.full)?;
    bench.scene.camera.eye *= options.away;
    println!(
        "\n{} trees, LODs of {:?} triangles, seen from {:.0} m, full meshes against the chain:",
        options.full,
        bench.reached,
        bench.scene.camera.eye.length()
    );
    bench.forest.settings.lod = Some(0);
    let triangles = bench.triangles();
    let fewer = Options {
        frames: options.frames.min(3),
        rows: Vec::new(),
        pictures: None,
        ..*options
    };
    let [full] = bench.compare(&fewer, [Calls::Indirect])?;
    bench.save(options, "full")?;
    let reference = bench.picture()?;
    bench.scene.setting.backdrop = false;
    let alone = bench.picture()?;
    bench.scene.setting.backdrop = true;
    let covered: Vec<bool> = alone.texels().iter().map(|p| p[3] > 0).collect();
    bench.forest.settings.lod = None;
    println!(
        "      full: {triangles} triangles, frame {:.1} ms",
        full.frame
    );
    for detail in [4.0, 2.0, 1.0, 0.5, 0.25, 0.12] {
        bench.forest.settings.detail = detail;
        let [times] = bench.compare(options, [Calls::Indirect])?;
        let picture = bench.picture()?;
        let rgb = |image: &Image<[u8; 4]>| image.map(|&[r, g, b, _]| [r, g, b]);
        let errors = flip::flip(&rgb(&reference), &rgb(&picture), flip::PIXELS_PER_DEGREE)
            .ok_or("pictures of two sizes")?;
        let all = flip::masked_mean(&errors, &vec![true; covered.len()]);
        println!(
            "      detail {detail:>4}: {:>9} triangles, mean FLIP {all:.4} (where trees are {:.4}), frame {:>7.1} ms, \
             {:.1}x faster",
            bench.triangles(),
            flip::masked_mean(&errors, &covered),
            times.frame,
            full.frame / times.frame
        );
        bench.save(options, &format!("detail{detail}"))?;
    }
    Ok(())
}

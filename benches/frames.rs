//! Frames of a wood, on whatever adapter there is: what each filter costs, and what wind costs trees that are so
//! far away that nobody sees them lean.
//!
//! The wind's benches draw overdraw alone into a small picture, so that vertices and not pixels take the time, and
//! keep one LOD, so that the same vertices are drawn in all of them.

use divan::{Bencher, black_box};
use pleach::gpu::Gpu;
use pleach::math::Vec3;
use pleach::pipeline::{self, Settings};
use pleach::render::forest::{Forest, Planting, plant};
use pleach::render::{CALM, Camera, Filter, Lens, Renderer, Scene, ViewMode};
use pleach::report::Quiet;
use pleach::species::{self, NoFiles};
use pleach::wind::Wind;

/// What the pictures are drawn in.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Metres a second: leaves and twigs are always on the move.
const BREEZE: f32 = 6.0;

fn main() {
    match Gpu::headless() {
        Ok(gpu) => println!("adapter: {}", gpu.describe()),
        Err(error) => {
            println!("no adapter, nothing to measure: {error}");
            return;
        }
    }
    divan::main();
}

/// A wood and where it is seen from.
struct Wood {
    renderer: Renderer,
    forest: Forest,
    scene: Scene,
    output: wgpu::TextureView,
    size: [u32; 2],
}

impl Wood {
    /// So many olives, from so many edges of the wood away.
    fn new(trees: u32, away: f32, size: [u32; 2]) -> Self {
        let gpu = Gpu::headless().expect("there was one");
        let text = include_str!("../species/olive.ron");
        let species = species::parse("olive.ron", text, &NoFiles).expect("a sound script");
        let settings = Settings {
            budgets: Some(vec![10_640, 836, 248, 8]),
            full: false,
            ..Settings::default()
        };
        let asset = pipeline::generate(&species, &settings, &NoFiles, &Quiet).expect("it grows");
        let mut renderer = Renderer::new(&gpu, FORMAT).expect("a renderer");
        renderer.add(&asset.drawable()).expect("it fits");
        let planting = Planting {
            trees,
            spacing_m: renderer.models()[0].bounds.size().x * 0.9,
            ..Planting::default()
        };
        let mut forest = renderer.forest(&plant(&planting)).expect("it fits");
        forest.settings.fade_seconds = 0.0;
        let edge = 2.0 * planting.half_edge_m();
        let camera = Camera {
            eye: Vec3::new(0.0, edge * 0.2 * away + 4.0, edge * away),
            target: Vec3::new(0.0, 3.0, 0.0),
            lens: Lens::Perspective(0.8),
        };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        Self {
            output: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            scene: Scene {
                groups: Vec::new(),
                ..Scene::of_one(camera, 0, 0)
            },
            renderer,
            forest,
            size,
        }
    }

    fn draw(&mut self) {
        let Self {
            renderer,
            forest,
            scene,
            output,
            size,
        } = self;
        let encoder = renderer.draw_forest(forest, scene, output, *size);
        let encoder = encoder.expect("it draws");
        let gpu = renderer.gpu().clone();
        gpu.queue.submit([encoder.finish()]);
        gpu.finish().expect("it draws");
    }
}

#[divan::bench(args = [Filter::None, Filter::Bilinear, Filter::Alpha, Filter::Combined], sample_count = 8)]
fn filters(bencher: Bencher, filter: Filter) {
    let mut wood = Wood::new(400, 0.9, [1024, 768]);
    wood.scene.filter = filter;
    bencher.bench_local(|| black_box(&mut wood).draw());
}

/// Vertices of the second LOD, from as far as that LOD's pictures are one pixel and from near.
fn in_wind(bencher: Bencher, away: f32, speed_m_s: f32) {
    let mut wood = Wood::new(400, away, [160, 120]);
    wood.scene.view = ViewMode::Overdraw;
    wood.scene.wind = Wind { speed_m_s, ..CALM };
    wood.forest.settings.lod = Some(1);
    bencher.bench_local(|| {
        // The shadow map of a wood in the wind is drawn again in each frame; so that of a still one is too.
        wood.scene.time += 0.1;
        wood.scene.setting.sun.x += 1e-3;
        black_box(&mut wood).draw();
    });
}

#[divan::bench(args = [0.0, BREEZE], sample_count = 12)]
fn far_trees_in_wind(bencher: Bencher, speed_m_s: f32) {
    in_wind(bencher, 6.0, speed_m_s);
}

#[divan::bench(args = [0.0, BREEZE], sample_count = 12)]
fn near_trees_in_wind(bencher: Bencher, speed_m_s: f32) {
    in_wind(bencher, 0.5, speed_m_s);
}

//! What the tests that draw share: a tree that costs little, and how pictures are compared.

use libtest_mimic::Failed;
use pleach::asset::TreeAsset;
use pleach::gpu::{Gpu, GpuError};
use pleach::image::Image;
use pleach::measure::flip;
use pleach::pipeline::{self, Settings};
use pleach::render::{Orbit, PORTRAIT, Renderer, Scene};
use pleach::report::Quiet;
use pleach::species::schema::Species;
use pleach::species::{self, Beside};
use pleach::{capture, shadow};
use std::path::PathBuf;
use std::sync::OnceLock;

pub(crate) fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A shipped species, and the files beside it.
pub(crate) fn species(name: &str) -> (Species, Beside) {
    let path = root().join("species").join(name);
    let text = std::fs::read_to_string(&path).expect("species can be read");
    let files = Beside(root().join("species"));
    let species = species::parse(name, &text, &files).expect("species has no faults");
    (species, files)
}

/// A species with small textures.
pub(crate) fn grown(name: &str) -> TreeAsset {
    let (species, files) = species(name);
    let settings = Settings {
        full: true,
        captures: capture::Settings {
            atlas_size: 512,
            ..capture::Settings::default()
        },
        bark_size: 128,
        shadows: shadow::Settings {
            size: 128,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    pipeline::generate(&species, &settings, &files, &Quiet).expect("species grows")
}

/// The cheapest species.
pub(crate) fn palm() -> &'static TreeAsset {
    static PALM: OnceLock<TreeAsset> = OnceLock::new();
    PALM.get_or_init(|| grown("palm.ron"))
}

pub(crate) fn rgb(image: &Image<[u8; 4]>) -> Image<[u8; 3]> {
    image.map(|&[r, g, b, _]| [r, g, b])
}

/// Mean FLIP over the whole picture, at 67 pixels a degree.
pub(crate) fn mean_flip(a: &Image<[u8; 4]>, b: &Image<[u8; 4]>) -> f32 {
    let errors = flip::flip(&rgb(a), &rgb(b), flip::PIXELS_PER_DEGREE).expect("one size");
    flip::masked_mean(&errors, &vec![true; errors.texels().len()])
}

/// Width and height of small pictures, pixels.
pub(crate) const SIZE: [u32; 2] = [160, 200];

/// A renderer of its own with one tree.
pub(crate) fn renderer(asset: &TreeAsset) -> Result<Renderer, GpuError> {
    let mut renderer = Renderer::new(&Gpu::headless()?, wgpu::TextureFormat::Rgba8UnormSrgb)?;
    renderer.add(&asset.drawable())?;
    Ok(renderer)
}

/// The tree as a portrait.
pub(crate) fn scene(renderer: &Renderer, lod: usize) -> Scene {
    let orbit = Orbit::around(&renderer.models()[0].hull, 0.6, 0.1, PORTRAIT, 0.8);
    Scene::of_one(orbit.camera(), 0, lod)
}

/// Runs a compute shader over inputs, `count` numbers out for each.
pub(crate) fn computed<T: bytemuck::Pod>(
    gpu: &Gpu,
    files: &[&str],
    inputs: &[T],
    count: usize,
) -> Result<Vec<f32>, Failed> {
    use wgpu::util::DeviceExt as _;
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("test"),
        source: wgpu::ShaderSource::Wgsl(files.join("\n").into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("test"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(inputs),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let size = (inputs.len() * count * 4) as u64;
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    };
    let output = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: input.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: output.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(u32::try_from(inputs.len().div_ceil(64))?, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&output, 0, &read, 0, size);
    gpu.queue.submit([encoder.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |_| ());
    gpu.finish()?;
    let bytes = read.get_mapped_range(..).map_err(|e| e.to_string())?;
    Ok(bytemuck::cast_slice(&bytes).to_vec())
}

/// Covered part of a picture, by its alpha.
pub(crate) fn covered(picture: &Image<[u8; 4]>) -> f32 {
    let sum: u64 = picture.texels().iter().map(|p| u64::from(p[3])).sum();
    sum as f32 / 255.0 / picture.texels().len() as f32
}

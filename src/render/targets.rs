//! The pictures that a frame is drawn into on its way to the screen.

use super::model::extent;
use crate::gpu::{Gpu, GpuError};

/// Format of linear light.
pub(super) const LIGHT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Format of depth; reversed, 1 near and 0 far.
pub(super) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Format of the sunlight that baked shadows leave to the ground.
pub(super) const GROUND: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// Pictures of one size.
#[derive(Debug)]
pub(super) struct Targets {
    pub(super) size: [u32; 2],
    /// Trees in all samples, where there are several.
    pub(super) samples: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    /// Trees, premultiplied.
    pub(super) trees: wgpu::TextureView,
    /// What is behind them.
    pub(super) backdrop: wgpu::TextureView,
    pub(super) ground: wgpu::TextureView,
}

impl Targets {
    pub(super) fn new(gpu: &Gpu, size: [u32; 2], samples: u32) -> Result<Self, GpuError> {
        let [width, height] = size;
        gpu.check_edge("a picture", width.max(height))?;
        let view = |label, format, samples, usage| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(width, height, 1),
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let draw = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = draw | wgpu::TextureUsages::TEXTURE_BINDING;
        Ok(Self {
            size,
            samples: (samples > 1).then(|| view("samples", LIGHT, samples, draw)),
            depth: view("depth", DEPTH, samples, draw),
            trees: view("trees", LIGHT, 1, read),
            backdrop: view("backdrop", LIGHT, 1, read),
            ground: view("ground shadows", GROUND, 1, read),
        })
    }
}

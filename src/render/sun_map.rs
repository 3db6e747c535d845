//! The shadow map of the sun, and what it shows.

use super::binding::group;
use super::drawing::Cast;
use super::model::extent;
use super::pipelines::Pipelines;
use super::targets::DEPTH;

/// Texels along the edge of a shadow map, and of one for a picture that is wanted soon.
pub(super) const SHADOW_MAP: u32 = 2048;
pub(super) const SMALL_MAP: u32 = 512;

/// A shadow map.
#[derive(Debug)]
pub(super) struct SunMap {
    pub(super) view: wgpu::TextureView,
    /// Texels along its edge.
    pub(super) edge: u32,
    /// What it shows, so that a camera that moves alone does not draw it again.
    pub(super) cast: Option<Cast>,
    /// A frame that is shaded by it.
    pub(super) frame_group: wgpu::BindGroup,
}

impl SunMap {
    pub(super) fn new(
        device: &wgpu::Device,
        pipelines: &Pipelines,
        frame: &wgpu::Buffer,
        edge: u32,
    ) -> Self {
        let view = device
            .create_texture(&wgpu::TextureDescriptor {
                label: Some("shadow map"),
                size: extent(edge, edge, 1),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: DEPTH,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
            .create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = |filter, compare| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: filter,
                min_filter: filter,
                compare,
                ..wgpu::SamplerDescriptor::default()
            })
        };
        let less = Some(wgpu::CompareFunction::LessEqual);
        let comparison = sampler(wgpu::FilterMode::Linear, less);
        let nearest = sampler(wgpu::FilterMode::Nearest, None);
        let frame_group = group(
            device,
            &pipelines.frame,
            &[
                (0, frame.as_entire_binding()),
                (1, wgpu::BindingResource::TextureView(&view)),
                (2, wgpu::BindingResource::Sampler(&comparison)),
                (3, wgpu::BindingResource::Sampler(&nearest)),
            ],
        );
        Self {
            view,
            edge,
            cast: None,
            frame_group,
        }
    }
}

//! Bind groups in few words.

use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, Device, ShaderStages};

pub(super) fn uniform() -> BindingType {
    BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

pub(super) fn sampler() -> BindingType {
    BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
}

pub(super) fn texture(dimension: wgpu::TextureViewDimension) -> BindingType {
    BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: dimension,
        multisampled: false,
    }
}

pub(super) fn depth_texture() -> BindingType {
    BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Depth,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

/// A layout; all stages of drawing see all bindings.
pub(super) fn layout(
    device: &Device,
    label: &str,
    bindings: &[(u32, BindingType)],
) -> BindGroupLayout {
    let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
        .iter()
        .map(|&(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &entries,
    })
}

pub(super) fn group(
    device: &Device,
    layout: &BindGroupLayout,
    bindings: &[(u32, BindingResource<'_>)],
) -> BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = bindings
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

//! A finished picture, painted into egui's window.

use crate::gpu::shader;
use eframe::egui::{Color32, PaintCallbackInfo, Painter, Rect, Rgba};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState};

/// What paints pictures into one window.
#[derive(Clone, Debug)]
pub(super) struct Showing {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    /// True if the window's format encodes sRGB by itself.
    encodes: bool,
}

/// A picture that a window can show.
#[derive(Clone, Debug)]
pub(super) struct Paintable {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl Showing {
    pub(super) fn new(state: &RenderState) -> Self {
        let device = &state.device;
        let module = shader::SHOWS.module(device);
        let encodes = state.target_format.is_srgb();
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("show"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs_screen"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs_show"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("target_encodes", f64::from(u8::from(encodes)))],
                    ..wgpu::PipelineCompilationOptions::default()
                },
                targets: &[Some(state.target_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("show"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Self {
            pipeline,
            sampler,
            encodes,
        }
    }

    /// A colour as the window is to be cleared with.
    pub(super) fn background(&self, colour: Color32) -> [f32; 4] {
        if self.encodes {
            return Rgba::from(colour).to_array();
        }
        colour.to_normalized_gamma_f32()
    }

    /// A picture whose colours are encoded already.
    pub(super) fn of(&self, device: &wgpu::Device, picture: &wgpu::TextureView) -> Paintable {
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("show"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(picture),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&self.sampler),
                },
            ],
        });
        Paintable {
            pipeline: self.pipeline.clone(),
            group,
        }
    }
}

impl Paintable {
    /// Paints the picture so that it fills `rect`, which lies inside the window, as far as the painter may paint.
    pub(super) fn paint(&self, painter: &Painter, rect: Rect) {
        painter.add(Callback::new_paint_callback(rect, self.clone()));
    }
}

impl CallbackTrait for Paintable {
    fn paint(
        &self,
        _info: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

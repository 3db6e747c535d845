//! A tree on the window's device, and the picture of it that the window shows.

use super::subject::Subject;
use crate::gpu::{Gpu, GpuError};
use crate::image::Image;
use crate::math::{Vec3, float, round_to_u32};
use crate::render::{Renderer, Scene};
use eframe::egui::TextureId;
use eframe::egui_wgpu::RenderState;
use std::time::Instant;

/// What egui samples: bytes that are encoded already.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A renderer on the window's device.
#[derive(Debug)]
pub(super) struct Canvas {
    renderer: Renderer,
    window: Window,
    picture: Option<Picture>,
    /// What the picture shows, so that nothing is drawn twice.
    drawn: Option<(Scene, [u32; 2])>,
}

#[derive(Debug)]
struct Picture {
    view: wgpu::TextureView,
    id: TextureId,
    size: [u32; 2],
}

struct Window(RenderState);

impl std::fmt::Debug for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Window")
    }
}

impl Canvas {
    /// A canvas without a tree.
    ///
    /// # Errors
    /// What the driver says.
    pub(super) fn new(state: &RenderState) -> Result<Self, GpuError> {
        let info = state.adapter.get_info();
        let gpu = Gpu::from_parts(state.device.clone(), state.queue.clone(), info);
        Ok(Self {
            renderer: Renderer::new(&gpu, FORMAT)?,
            window: Window(state.clone()),
            picture: None,
            drawn: None,
        })
    }

    /// Name and driver of the adapter.
    #[must_use]
    pub(super) fn describe(&self) -> String {
        self.renderer.gpu().describe()
    }

    /// Shows this tree from now on. If the adapter cannot take it, the one before stays.
    ///
    /// # Errors
    /// Why not.
    pub(super) fn show(&mut self, subject: &Subject) -> Result<(), GpuError> {
        self.renderer.replace(0, &subject.drawable())?;
        self.drawn = None;
        Ok(())
    }

    /// Outermost points of the tree, metres.
    #[must_use]
    pub(super) fn hull(&self) -> &[Vec3] {
        self.renderer.models().first().map_or(&[], |m| &m.hull)
    }

    /// The largest size in pixels, of the same shape, that the adapter allows; 0 only where there is no area.
    #[must_use]
    pub(super) fn fitting(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let limit = self.renderer.gpu().device.limits().max_texture_dimension_2d;
        let longest = width.max(height);
        if longest <= limit {
            return [width, height];
        }
        let shrunk = |edge: u32| match edge {
            0 => 0,
            _ => round_to_u32(float(edge) * (float(limit) / float(longest))).clamp(1, limit),
        };
        [shrunk(width), shrunk(height)]
    }

    /// Draws a scene into the picture, unless that shows it already; says how many seconds it took.
    ///
    /// # Errors
    /// If the device fails.
    pub(super) fn draw(&mut self, scene: &Scene, size: [u32; 2]) -> Result<Option<f32>, GpuError> {
        let same = |(drawn, drawn_size): &(Scene, [u32; 2])| drawn == scene && *drawn_size == size;
        if size.contains(&0) || self.drawn.as_ref().is_some_and(same) {
            return Ok(None);
        }
        let begun = Instant::now();
        let view = self.target(size);
        let encoder = self.renderer.draw(scene, &view, size)?;
        let gpu = self.renderer.gpu();
        gpu.queue.submit([encoder.finish()]);
        // To be told how long it took, and so that no more than one frame waits to be drawn: the answer to a
        // drag would lag behind.
        gpu.finish()?;
        self.drawn = Some((scene.clone(), size));
        Ok(Some(begun.elapsed().as_secs_f32()))
    }

    /// What was drawn last.
    #[must_use]
    pub(super) fn picture(&self) -> Option<TextureId> {
        self.drawn.as_ref()?;
        Some(self.picture.as_ref()?.id)
    }

    /// A scene as a picture to keep.
    ///
    /// # Errors
    /// If the size is more than the adapter allows, or the device fails.
    pub(super) fn still(
        &mut self,
        scene: &Scene,
        size: [u32; 2],
    ) -> Result<Image<[u8; 4]>, GpuError> {
        self.renderer.picture(scene, size)
    }

    /// What the driver told of anything done since the last call, also by the window itself.
    ///
    /// # Errors
    /// That.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        self.renderer.gpu().check()
    }

    /// Takes the device away.
    pub(super) fn destroy_device(&self) {
        self.renderer.gpu().device.destroy();
    }

    /// The picture, in this size.
    fn target(&mut self, size: [u32; 2]) -> wgpu::TextureView {
        if let Some(picture) = self.picture.as_ref().filter(|p| p.size == size) {
            return picture.view.clone();
        }
        let device = &self.renderer.gpu().device;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("view"),
            size: wgpu::Extent3d {
                width: size[0],
                height: size[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut egui = self.window.0.renderer.write();
        let linear = wgpu::FilterMode::Linear;
        let id = match self.picture.take() {
            Some(Picture { id, .. }) => {
                egui.update_egui_texture_from_wgpu_texture(device, &view, linear, id);
                id
            }
            None => egui.register_native_texture(device, &view, linear),
        };
        drop(egui);
        self.picture = Some(Picture {
            view: view.clone(),
            id,
            size,
        });
        view
    }
}

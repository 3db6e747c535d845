//! The parts of a frame: what is drawn, onto what, and how settings are told to shaders.

use super::model::{Lod, Model};
use super::part::Part;
use super::scene::{Filter, Group, LightMode, Scene, Setting, ViewMode};
use super::uniforms::Frame;
use crate::math::{Bounds, Vec3, float};
use glam::{Mat4, Vec4};

/// Edge of the auxiliary picture of the bilinear filter, as a part of the screen's ("slightly smaller",
/// Candussi et al., section 2.3).
pub(super) const AUXILIARY: f32 = 0.85;

/// What decides a shadow map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cast {
    light: [[f32; 4]; 4],
    groups: Vec<Group>,
    /// Wind and time, where a wind blows.
    blown: Option<([f32; 4], f32)>,
    leaves_face_sun: bool,
}

impl Cast {
    pub(super) fn of(scene: &Scene, frame: &Frame) -> Self {
        Self {
            light: frame.light_projection,
            groups: scene.groups.clone(),
            blown: (scene.wind.speed_m_s != 0.0).then_some((frame.wind, scene.time)),
            leaves_face_sun: scene.setting.leaves_face_sun,
        }
    }
}

/// A group ready to be drawn.
pub(super) struct Drawn<'s> {
    pub(super) model: &'s Model,
    pub(super) lod: &'s Lod,
    pub(super) instances: wgpu::Buffer,
    pub(super) count: u32,
}

impl Drawn<'_> {
    fn draw_by(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        (part, material): (&Part, &wgpu::BindGroup),
        (indices, count): (&wgpu::Buffer, u32),
    ) {
        pass.set_bind_group(1, &self.model.group, &[]);
        pass.set_bind_group(2, material, &[]);
        pass.set_vertex_buffer(0, part.vertices.slice(..));
        pass.set_vertex_buffer(1, part.sway.slice(..));
        pass.set_vertex_buffer(2, part.origins.slice(..));
        pass.set_vertex_buffer(3, self.instances.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..count, 0, 0..self.count);
    }

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        part: Option<&Part>,
        material: &wgpu::BindGroup,
    ) {
        if let Some(part) = part {
            self.draw_by(pass, (part, material), (&part.indices, part.count));
        }
    }

    pub(super) fn draw_edges(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        part: Option<&Part>,
        material: &wgpu::BindGroup,
    ) {
        if let Some(part) = part {
            self.draw_by(pass, (part, material), (&part.edges, part.count * 2));
        }
    }
}

pub(super) fn colour_attachment<'v>(
    view: &'v wgpu::TextureView,
    resolve_target: Option<&'v wgpu::TextureView>,
    clear: wgpu::Color,
) -> wgpu::RenderPassColorAttachment<'v> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(clear),
            store: wgpu::StoreOp::Store,
        },
    }
}

pub(super) fn depth_attachment(
    view: &wgpu::TextureView,
    clear: f32,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(clear),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

/// Size of the auxiliary picture.
pub(super) fn inner_size(size: [u32; 2], filter: Filter) -> [u32; 2] {
    match filter {
        Filter::None | Filter::Alpha => size,
        Filter::Bilinear | Filter::Combined => {
            size.map(|n| crate::math::round_to_u32(float(n) * AUXILIARY).max(1))
        }
    }
}

/// World to the shadow map for a sun, and the edge in metres of what it shows.
pub(super) fn light_projection(bounds: &Bounds, sun: Vec3) -> (Mat4, f32) {
    let side = if sun.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
    let right = side.cross(sun).normalize_or(Vec3::X);
    let up = sun.cross(right);
    let centre = bounds.centre();
    let spread = |axis: Vec3| {
        let reach = bounds.corners().map(|c| (c - centre).dot(axis).abs());
        reach.into_iter().fold(1e-3, f32::max)
    };
    let half = spread(right).max(spread(up)) * 1.02;
    let deep = spread(sun) * 1.02;
    let row = |axis: Vec3, scale: f32, shift: f32| {
        (axis * scale).extend(shift - axis.dot(centre) * scale)
    };
    let matrix = Mat4::from_cols(
        row(right, 1.0 / half, 0.0),
        row(up, 1.0 / half, 0.0),
        // 0 is nearest to the sun.
        row(-sun, 0.5 / deep, 0.5),
        Vec4::W,
    );
    (matrix.transpose(), 2.0 * half)
}

pub(super) fn light_code(mode: LightMode) -> u32 {
    match mode {
        LightMode::Product => 0,
        LightMode::FourFactors => 1,
    }
}

pub(super) fn flags(setting: &Setting) -> u32 {
    u32::from(setting.leaves_face_sun)
}

pub(super) fn view_code(view: ViewMode) -> u32 {
    match view {
        ViewMode::Lit => 0,
        ViewMode::Lods => 1,
        ViewMode::Normals => 2,
        ViewMode::Albedo => 3,
        ViewMode::Overdraw => 4,
        ViewMode::Wire => 5,
        ViewMode::Levels => 6,
    }
}

pub(super) fn filter_code(filter: Filter) -> u32 {
    match filter {
        Filter::None => 0,
        Filter::Alpha => 1,
        Filter::Bilinear => 2,
        Filter::Combined => 3,
    }
}

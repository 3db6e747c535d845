//! Data on their way to the adapter.

use super::passes;
use crate::capture::{ALPHA_CUTOFF, Pass};
use crate::gpu::{self, Gpu, GpuError};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use crate::math::{byte_from_unit, float};
use bytemuck::Pod;
use rayon::prelude::*;
use wgpu::{Buffer, BufferUsages, TextureFormat};

/// A storage buffer of some items; of one blank item where there are none.
pub(super) fn storage<T: Pod>(gpu: &Gpu, label: &'static str, items: &[T]) -> Buffer {
    let blank = [T::zeroed()];
    let items = if items.is_empty() { &blank[..] } else { items };
    gpu::upload(
        gpu,
        label,
        bytemuck::cast_slice(items),
        BufferUsages::STORAGE,
    )
}

/// A uniform buffer.
pub(super) fn uniform<T: Pod>(gpu: &Gpu, label: &'static str, item: &T) -> Buffer {
    gpu::upload(gpu, label, bytemuck::bytes_of(item), BufferUsages::UNIFORM)
}

/// A buffer that the adapter alone fills, of so many words; at least one.
pub(super) fn blank(gpu: &Gpu, label: &str, words: u64, usage: BufferUsages) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: words.max(1) * 4,
        usage,
        mapped_at_creation: false,
    })
}

/// A buffer of at least one item, written in pieces without putting them together first.
pub(super) fn gathered<'a, T: Pod>(
    gpu: &Gpu,
    usage: BufferUsages,
    items: u64,
    pieces: impl Iterator<Item = &'a [T]>,
) -> Buffer {
    let words = items.max(1) * (size_of::<T>() as u64 / 4);
    let buffer = blank(gpu, "gathered", words, usage | BufferUsages::COPY_DST);
    let mut at = 0;
    for piece in pieces.filter(|p| !p.is_empty()) {
        gpu.queue
            .write_buffer(&buffer, at, bytemuck::cast_slice(piece));
        at += size_of_val(piece) as u64;
    }
    buffer
}

/// A buffer in a layout; `steps` if an offset chooses a part of it at each call.
pub(super) fn data(ty: wgpu::BufferBindingType, steps: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: steps,
        min_binding_size: None,
    }
}

/// A flat texture in a layout.
pub(super) fn image(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

/// A layout of bindings from 0 on.
pub(super) fn layout(
    device: &wgpu::Device,
    visibility: wgpu::ShaderStages,
    bindings: &[wgpu::BindingType],
) -> wgpu::BindGroupLayout {
    let entry = |(binding, &ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty,
        count: None,
    };
    let entries: Vec<_> = (0..).zip(bindings).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}

/// The layout of a pipeline with one group.
pub(super) fn pipeline_layout(
    device: &wgpu::Device,
    group: &wgpu::BindGroupLayout,
) -> wgpu::PipelineLayout {
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(group)],
        ..wgpu::PipelineLayoutDescriptor::default()
    })
}

/// The textures of a pass on the adapter.
pub(super) struct Surfaces {
    /// Bark, four words a texel.
    pub(super) bark: Mips,
    /// The atlas, two words a texel.
    pub(super) foliage: Mips,
    /// The slopes of the atlas, and where it has foliage.
    pub(super) outlines: Mips,
    /// The longest side of a card in the atlas, metres.
    pub(super) longest: f32,
}

/// All mips of an image in one texture: from the second on in a column beside the first.
pub(super) struct Mips {
    pub(super) view: wgpu::TextureView,
    /// Width and height of the finest mip, and number of mips, as the shaders read it.
    pub(super) about: [u32; 4],
    /// Bytes sent.
    pub(super) bytes: u64,
}

/// A part of an image, and the length of the longer side of the capture there; 0 if it is none.
type Part = (Rect, f32);

impl Surfaces {
    pub(super) fn new(gpu: &Gpu, pass: &Pass<'_>) -> Result<Self, GpuError> {
        let (bark, foliage) = (pass.textures.bark, pass.textures.foliage.mips());
        let whole = Rect {
            x: 0,
            y: 0,
            width: bark[0].width(),
            height: bark[0].height(),
        };
        let size = [foliage[0].width(), foliage[0].height()].map(float);
        let longer = |rect: &Rect| {
            let middle = [
                float(rect.x * 2 + rect.width) * 0.5 / size[0],
                float(rect.y * 2 + rect.height) * 0.5 / size[1],
            ];
            let relief = pass.textures.reliefs.iter().find(|r| r.uv.holds(middle));
            relief.map_or(0.0, |r| r.longer)
        };
        let parts = pass.parts.iter().map(|part| (part.outer(), longer(part)));
        let parts: Vec<Part> = parts.collect();
        let longest = parts.iter().fold(0.0, |most: f32, part| most.max(part.1));
        let scaled = parts
            .iter()
            .map(|(rect, longer)| (*rect, longer / longest.max(1e-12)));
        let scaled: Vec<Part> = scaled.collect();
        let [word, pair, four] = [
            TextureFormat::R32Uint,
            TextureFormat::Rg32Uint,
            TextureFormat::Rgba32Uint,
        ];
        Ok(Self {
            bark: Mips::new(gpu, ("bark", four), bark, &[(whole, 0.0)], |t, _| solid(t))?,
            foliage: Mips::new(gpu, ("foliage", pair), foliage, &scaled, flat)?,
            outlines: Mips::new(gpu, ("outlines", word), foliage, &parts, outline)?,
            longest,
        })
    }

    /// Bytes sent.
    pub(super) fn bytes(&self) -> u64 {
        self.bark.bytes + self.foliage.bytes + self.outlines.bytes
    }
}

impl Mips {
    /// Fills some parts of the finest mip, and what lies below them in the others. The parts begin and end where
    /// texels of all mips do, unless they are the whole.
    fn new<T: Pod + Send>(
        gpu: &Gpu,
        (label, format): (&'static str, TextureFormat),
        mips: &[Image<Texel>],
        parts: &[Part],
        texel: fn(&Texel, f32) -> T,
    ) -> Result<Self, GpuError> {
        let (width, height) = (mips[0].width(), mips[0].height());
        let size = size_with_mips(gpu, label, [width, height])?;
        let mips = &mips[..self::mips(mips.len(), [width, height])];
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = passes::texture(gpu, label, format, size, usage);
        let mut bytes = 0;
        for (level, mip) in (0_u32..).zip(mips) {
            let corner = corner_of_mip([width, height], level);
            for (part, longer) in parts {
                let (x, y) = (part.x >> level, part.y >> level);
                let edge = |length: u32| (length >> level).max(1);
                let part = Rect {
                    x,
                    y,
                    width: edge(part.width).min(mip.width() - x),
                    height: edge(part.height).min(mip.height() - y),
                };
                let row = |y: u32| {
                    let columns = part.x..part.x + part.width;
                    columns.map(move |x| texel(mip.at(x, y), *longer))
                };
                let rows = (part.y..part.y + part.height).into_par_iter();
                let texels: Vec<T> = rows.flat_map_iter(row).collect();
                let at = [corner[0] + part.x, corner[1] + part.y];
                bytes += write(gpu, &texture, at, [part.width, part.height], &texels);
            }
        }
        Ok(Self {
            view: passes::whole(&texture),
            about: [width, height, u32::try_from(mips.len()).unwrap_or(1), 0],
            bytes,
        })
    }
}

/// Size of a texture with all mips of an image: from the second on in a column beside the first.
pub(super) fn size_with_mips(
    gpu: &Gpu,
    what: &'static str,
    [width, height]: [u32; 2],
) -> Result<[u32; 2], GpuError> {
    let size = [width + (width / 2).max(1), height];
    for edge in size {
        gpu.check_edge(what, edge)?;
    }
    Ok(size)
}

/// Mips that such a texture has of a chain: the processor's may go on at a single texel.
pub(super) fn mips(chain: usize, [width, height]: [u32; 2]) -> usize {
    chain.min(width.min(height).ilog2() as usize + 1)
}

/// Where a mip begins in such a texture: each ends above the one after it, as `nearest` of
/// `shaders/capture_seen.wgsl` counts.
pub(super) fn corner_of_mip([width, height]: [u32; 2], level: u32) -> [u32; 2] {
    match level {
        0 => [0, 0],
        _ => [width, height - (height >> (level - 1))],
    }
}

/// Sends a part of a texture, row by row; gives the number of bytes.
pub(super) fn write<T: Pod>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    [x, y]: [u32; 2],
    [width, height]: [u32; 2],
    texels: &[T],
) -> u64 {
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x, y, z: 0 },
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: u32::try_from(width as usize * size_of::<T>()).ok(),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
    );
    bytes.len() as u64
}

/// A texel of bark, as `shaders/capture_seen.wgsl` reads it.
fn solid(texel: &Texel) -> [u32; 4] {
    let [r, g, b] = texel.albedo;
    let rest = [texel.roughness, texel.translucency].map(byte_from_unit);
    [
        two(unorm(r), unorm(g)),
        two(unorm(b), unorm(texel.occlusion)),
        slopes(texel),
        u32::from(u16::from_le_bytes(rest)),
    ]
}

/// A texel of foliage on a card whose longer side is such a part of the longest card's, as
/// `shaders/capture_texels.wgsl` reads it.
fn flat(texel: &Texel, part: f32) -> [u32; 2] {
    let [r, g, b] = texel.albedo.map(|c| byte_from_unit(c.max(0.0).sqrt()));
    let rest = [texel.roughness, texel.translucency].map(byte_from_unit);
    [
        u32::from_le_bytes([r, g, b, byte_from_unit(texel.occlusion)]),
        two(u16::from_le_bytes(rest), snorm(texel.depth * part)),
    ]
}

fn slopes(texel: &Texel) -> u32 {
    two(snorm(texel.normal[0]), snorm(texel.normal[1]))
}

/// The slopes, their lowest bit set where there is foliage.
fn outline(texel: &Texel, _longer: f32) -> u32 {
    let is_seen = texel.alpha >= ALPHA_CUTOFF;
    (slopes(texel) & !1) | u32::from(is_seen)
}

fn two(low: u16, high: u16) -> u32 {
    u32::from(low) | (u32::from(high) << 16)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=65,535.5 just before"
)]
fn unorm(x: f32) -> u16 {
    (x.clamp(0.0, 1.0) * 65_535.0 + 0.5) as u16
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "clamped to what 16 bits hold just before"
)]
fn snorm(x: f32) -> u16 {
    ((x.clamp(-1.0, 1.0) * 32_767.0).round() as i16).cast_unsigned()
}

/// A bind group in few words.
pub(super) fn bound(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    bindings: &[(u32, wgpu::BindingResource<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry<'_>> = bindings
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &entries,
    })
}

//! Data on their way to the adapter.

use crate::capture::{ALPHA_CUTOFF, Pass};
use crate::gpu::{Gpu, GpuError};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use bytemuck::Pod;
use rayon::prelude::*;
use wgpu::{Buffer, BufferUsages, TextureFormat};

/// A storage buffer of some items; of one blank item where there are none.
pub(super) fn storage<T: Pod>(gpu: &Gpu, label: &str, items: &[T]) -> Result<Buffer, GpuError> {
    let bytes: &[u8] = bytemuck::cast_slice(items);
    let size = bytes.len().max(size_of::<T>()) as u64;
    gathered(gpu, label, size, core::iter::once(bytes))
}

/// A uniform buffer.
pub(super) fn uniform<T: Pod>(gpu: &Gpu, label: &str, item: &T) -> Result<Buffer, GpuError> {
    let bytes = bytemuck::bytes_of(item);
    let size = bytes.len() as u64;
    filled(
        gpu,
        (label, BufferUsages::UNIFORM),
        size,
        core::iter::once(bytes),
    )
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

/// A storage buffer written in pieces, without putting them together first; zero where they end.
pub(super) fn gathered<'a>(
    gpu: &Gpu,
    label: &str,
    bytes: u64,
    pieces: impl Iterator<Item = &'a [u8]>,
) -> Result<Buffer, GpuError> {
    filled(gpu, (label, BufferUsages::STORAGE), bytes, pieces)
}

/// Unlike `create_buffer_init` of wgpu, it tells of a lost device instead of panicking.
fn filled<'a>(
    gpu: &Gpu,
    (label, usage): (&str, BufferUsages),
    bytes: u64,
    pieces: impl Iterator<Item = &'a [u8]>,
) -> Result<Buffer, GpuError> {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: bytes.max(4).next_multiple_of(4),
        usage,
        mapped_at_creation: true,
    });
    {
        let mut view = buffer.get_mapped_range_mut(..).map_err(|e| {
            let told = gpu.check().err();
            told.unwrap_or_else(|| GpuError::Lost(e.to_string()))
        })?;
        let mut at = 0;
        for piece in pieces.filter(|p| !p.is_empty()) {
            view.slice(at..at + piece.len()).copy_from_slice(piece);
            at += piece.len();
        }
    }
    buffer.unmap();
    Ok(buffer)
}

/// The textures of a pass on the adapter.
pub(super) struct Surfaces {
    /// Bark, four words a texel as [`packed`] has them.
    pub(super) bark: wgpu::TextureView,
    /// The atlas in the same form.
    pub(super) foliage: wgpu::TextureView,
    /// Where the atlas has foliage.
    pub(super) cutout: wgpu::TextureView,
    /// Bytes sent.
    pub(super) bytes: u64,
}

impl Surfaces {
    pub(super) fn new(gpu: &Gpu, pass: &Pass<'_>) -> Result<Self, GpuError> {
        let (bark, foliage) = (pass.textures.bark, pass.textures.foliage);
        gpu.check_edge("a bark texture", bark[0].width().max(bark[0].height()))?;
        gpu.check_edge("a foliage atlas", foliage[0].width())?;
        let whole = [Rect {
            x: 0,
            y: 0,
            width: bark[0].width(),
            height: bark[0].height(),
        }];
        let parts: Vec<Rect> = pass.parts.iter().map(Rect::outer).collect();
        let (bark, bark_bytes) =
            mipped(gpu, "bark", bark, &whole, TextureFormat::Rgba32Uint, packed);
        let (cutout, cutout_bytes) =
            mipped(gpu, "cutout", foliage, &parts, TextureFormat::R8Unorm, cut);
        let (foliage, foliage_bytes) = mipped(
            gpu,
            "foliage",
            foliage,
            &parts,
            TextureFormat::Rgba32Uint,
            packed,
        );
        Ok(Self {
            bark,
            foliage,
            cutout,
            bytes: bark_bytes + cutout_bytes + foliage_bytes,
        })
    }
}

/// A texture with mips, of which some parts of the finest one are filled. The parts begin and end where texels
/// of all mips do, unless they are the whole.
fn mipped<T: Pod + Send>(
    gpu: &Gpu,
    label: &str,
    mips: &[Image<Texel>],
    parts: &[Rect],
    format: TextureFormat,
    texel: fn(&Texel) -> T,
) -> (wgpu::TextureView, u64) {
    let size = wgpu::Extent3d {
        width: mips[0].width(),
        height: mips[0].height(),
        depth_or_array_layers: 1,
    };
    // The processor's chains may go on at a single texel.
    let mips = &mips[..mips
        .len()
        .min(size.width.max(size.height).ilog2() as usize + 1)];
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: u32::try_from(mips.len()).unwrap_or(1),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let mut bytes = 0;
    for (level, mip) in (0_u32..).zip(mips) {
        for part in parts {
            let edge = |length: u32| (length >> level).max(1);
            let (x, y) = (part.x >> level, part.y >> level);
            let width = edge(part.width).min(mip.width() - x);
            let height = edge(part.height).min(mip.height() - y);
            let texels: Vec<T> = (y..y + height)
                .into_par_iter()
                .flat_map_iter(|y| (x..x + width).map(move |x| texel(mip.at(x, y))))
                .collect();
            let texels: &[u8] = bytemuck::cast_slice(&texels);
            bytes += texels.len() as u64;
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: level,
                    origin: wgpu::Origin3d { x, y, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                texels,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: u32::try_from(texels.len()).ok().map(|b| b / height),
                    rows_per_image: None,
                },
                wgpu::Extent3d {
                    width,
                    height,
                    depth_or_array_layers: 1,
                },
            );
        }
    }
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    (view, bytes)
}

fn cut(texel: &Texel) -> u8 {
    if texel.alpha >= ALPHA_CUTOFF { 255 } else { 0 }
}

/// A texel in four words, as `unpacked` of `shaders/capture_texels.wgsl` reads it: red and green, blue and
/// occlusion, the normal's slopes, depth with roughness and translucency.
fn packed(texel: &Texel) -> [u32; 4] {
    let [r, g, b] = texel.albedo;
    let rest = [texel.roughness, texel.translucency].map(crate::math::byte_from_unit);
    [
        two(unorm(r), unorm(g)),
        two(unorm(b), unorm(texel.occlusion)),
        two(snorm(texel.normal[0]), snorm(texel.normal[1])),
        two(snorm(texel.depth), u16::from_le_bytes(rest)),
    ]
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

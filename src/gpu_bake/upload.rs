//! Data on their way to the adapter.

use crate::capture::{ALPHA_CUTOFF, Pass};
use crate::gpu::{self, Gpu, GpuError};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
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
    /// Bark, four words a texel as [`packed`] has them.
    pub(super) bark: Mips,
    /// The atlas in the same form.
    pub(super) foliage: Mips,
    /// Where the atlas has foliage.
    pub(super) cutout: Mips,
}

/// All mips of an image in one texture: from the second on in a column beside the first.
pub(super) struct Mips {
    pub(super) view: wgpu::TextureView,
    /// Width and height of the finest mip, and number of mips, as the shaders read it.
    pub(super) about: [u32; 4],
    /// Bytes sent.
    pub(super) bytes: u64,
}

impl Surfaces {
    pub(super) fn new(gpu: &Gpu, pass: &Pass<'_>) -> Result<Self, GpuError> {
        let (bark, foliage) = (pass.textures.bark, pass.textures.foliage.mips());
        let whole = [Rect {
            x: 0,
            y: 0,
            width: bark[0].width(),
            height: bark[0].height(),
        }];
        let parts: Vec<Rect> = pass.parts.iter().map(Rect::outer).collect();
        let words = TextureFormat::Rgba32Uint;
        Ok(Self {
            bark: Mips::new(gpu, ("bark", words), bark, &whole, packed)?,
            foliage: Mips::new(gpu, ("foliage", words), foliage, &parts, packed)?,
            cutout: Mips::new(
                gpu,
                ("cutout", TextureFormat::R8Unorm),
                foliage,
                &parts,
                cut,
            )?,
        })
    }

    /// Bytes sent.
    pub(super) fn bytes(&self) -> u64 {
        self.bark.bytes + self.foliage.bytes + self.cutout.bytes
    }
}

impl Mips {
    /// Fills some parts of the finest mip, and what lies below them in the others. The parts begin and end where
    /// texels of all mips do, unless they are the whole.
    fn new<T: Pod + Send>(
        gpu: &Gpu,
        (label, format): (&'static str, TextureFormat),
        mips: &[Image<Texel>],
        parts: &[Rect],
        texel: fn(&Texel) -> T,
    ) -> Result<Self, GpuError> {
        let (width, height) = (mips[0].width(), mips[0].height());
        gpu.check_edge(label, width + (width / 2).max(1))?;
        gpu.check_edge(label, height)?;
        // The processor's chains may go on at a single texel.
        let mips = &mips[..mips.len().min(width.min(height).ilog2() as usize + 1)];
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: width + (width / 2).max(1),
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let mut bytes = 0;
        let mut corner = [0, 0];
        for (level, mip) in (0_u32..).zip(mips) {
            for part in parts {
                let (x, y) = (part.x >> level, part.y >> level);
                let edge = |length: u32| (length >> level).max(1);
                let part = Rect {
                    x,
                    y,
                    width: edge(part.width).min(mip.width() - x),
                    height: edge(part.height).min(mip.height() - y),
                };
                bytes += write(gpu, &texture, corner, mip, &part, texel);
            }
            corner = if level == 0 {
                [width, 0]
            } else {
                [width, corner[1] + mip.height()]
            };
        }
        Ok(Self {
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            about: [width, height, u32::try_from(mips.len()).unwrap_or(1), 0],
            bytes,
        })
    }
}

/// Sends a part of a mip whose own corner is at `corner` of the texture; gives the number of bytes.
fn write<T: Pod + Send>(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    corner: [u32; 2],
    mip: &Image<Texel>,
    part: &Rect,
    texel: fn(&Texel) -> T,
) -> u64 {
    let columns = part.x..part.x + part.width;
    let texels: Vec<T> = (part.y..part.y + part.height)
        .into_par_iter()
        .flat_map_iter(|y| columns.clone().map(move |x| texel(mip.at(x, y))))
        .collect();
    let texels: &[u8] = bytemuck::cast_slice(&texels);
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d {
                x: corner[0] + part.x,
                y: corner[1] + part.y,
                z: 0,
            },
            aspect: wgpu::TextureAspect::All,
        },
        texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: u32::try_from(part.width as usize * size_of::<T>()).ok(),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width: part.width,
            height: part.height,
            depth_or_array_layers: 1,
        },
    );
    texels.len() as u64
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

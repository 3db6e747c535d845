//! Textures back from the device.

use super::{Gpu, GpuError};
use crate::image::Image;

/// Texels of a texture on their way back; [`Readback::wait`] gives them.
#[derive(Debug)]
pub struct Readback {
    buffer: wgpu::Buffer,
    size: [u32; 2],
    row: u32,
}

impl Readback {
    /// Adds the copy of the first mip and layer of a texture of four bytes a texel to the commands.
    #[must_use]
    pub fn record(gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) -> Self {
        let (width, height) = (texture.width(), texture.height());
        let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        Self {
            buffer,
            size: [width, height],
            row,
        }
    }

    /// The texels, once the commands were submitted.
    ///
    /// # Errors
    /// If the device was lost or refused a command.
    pub fn wait(self, gpu: &Gpu) -> Result<Image<[u8; 4]>, GpuError> {
        self.buffer.map_async(wgpu::MapMode::Read, .., |_| ());
        gpu.finish()?;
        let bytes = self
            .buffer
            .get_mapped_range(..)
            .map_err(|e| GpuError::Lost(e.to_string()))?;
        let [width, height] = self.size;
        let rows = bytes.chunks_exact(self.row as usize);
        let texels = rows
            .flat_map(|row| row[..width as usize * 4].as_chunks::<4>().0)
            .copied()
            .collect();
        Ok(Image::from_texels(width, height, texels))
    }
}

/// The first mip and layer of a texture of four bytes a texel.
///
/// # Errors
/// If the device was lost or refused a command.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Image<[u8; 4]>, GpuError> {
    let mut encoder = gpu
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let readback = Readback::record(gpu, &mut encoder, texture);
    gpu.queue.submit([encoder.finish()]);
    readback.wait(gpu)
}

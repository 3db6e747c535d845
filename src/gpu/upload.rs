//! Bytes to the device.

use super::Gpu;

/// A buffer that holds these bytes, a multiple of four of them. On a lost device the buffer is of no use, and
/// [`Gpu::check`] says why; nothing panics, as mapped creation would.
#[must_use]
pub fn upload(
    gpu: &Gpu,
    label: &'static str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (contents.len() as u64).max(4),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if !contents.is_empty() {
        gpu.queue.write_buffer(&buffer, 0, contents);
    }
    buffer
}

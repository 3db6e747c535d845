//! From texels as they come back to pictures.

use super::passes::STRIDE;
use crate::capture::{Picture, Shot};
use crate::gpu::{Gpu, GpuError};
use crate::image::{Image, Texel};
use crate::math::{Vec3, float};
use rayon::prelude::*;
use wgpu::Buffer;

/// Words of a texel on its way back.
const WORDS: usize = 4;

/// Bytes of a row of texels on its way back.
pub(super) fn row_bytes(width: u32) -> u32 {
    // Copies step by as much as uniforms do.
    (width * 16).next_multiple_of(u32::try_from(STRIDE).unwrap_or(256))
}

/// A group whose texels are on their way back.
pub(super) struct Exposed {
    /// By scene.
    pub(super) shots: Vec<Vec<Sent>>,
    pub(super) texels: Buffer,
    /// Bytes of a row.
    pub(super) row: u32,
}

/// A shot that was drawn.
pub(super) struct Sent {
    pub(super) shot: Shot,
    /// Where its first texel lies.
    pub(super) place: [u32; 2],
    /// The depth that 0 stands for, and that which 1 is more, metres.
    pub(super) depth: [f32; 2],
}

/// Waits for all groups and unpacks their texels.
pub(super) fn developed(
    gpu: &Gpu,
    exposed: Vec<Exposed>,
    supersample: u32,
) -> Result<Vec<Vec<Picture>>, GpuError> {
    for group in &exposed {
        group.texels.map_async(wgpu::MapMode::Read, .., |_| ());
    }
    gpu.finish()?;
    let mut scenes = Vec::new();
    for Exposed { shots, texels, row } in exposed {
        let bytes = texels
            .get_mapped_range(..)
            .map_err(|e| GpuError::Lost(e.to_string()))?;
        let words: &[[u32; WORDS]] = bytemuck::try_cast_slice(&bytes[..])
            .map_err(|e| GpuError::Refused(format!("texels came back out of line: {e}")))?;
        let pictures = |shots: Vec<Sent>| -> Vec<Picture> {
            let shots = shots.into_par_iter();
            shots
                .map(|sent| picture(&sent, words, row as usize / (4 * WORDS), supersample))
                .collect()
        };
        scenes.par_extend(shots.into_par_iter().map(pictures));
    }
    Ok(scenes)
}

fn picture(sent: &Sent, words: &[[u32; WORDS]], row: usize, supersample: u32) -> Picture {
    let share = 1.0 / float(supersample * supersample);
    let [width, height] = sent.shot.texels;
    let [x, y] = sent.place.map(|p| p as usize);
    let rows = words.chunks(row).skip(y).take(height as usize);
    let texels = rows.flat_map(|row| &row[x..x + width as usize]);
    Picture {
        shot: sent.shot,
        image: Image::from_texels(
            width,
            height,
            texels.map(|w| unpacked(*w, share, sent.depth)).collect(),
        ),
    }
}

fn unpacked(
    [red_green, blue_open, slopes, rest]: [u32; WORDS],
    share: f32,
    [low, range]: [f32; 2],
) -> Texel {
    let [count, ..] = slopes.to_le_bytes();
    if count == 0 {
        return Texel::EMPTY;
    }
    let halves = |word: u32| {
        let [a, b, c, d] = word.to_le_bytes();
        [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
    };
    let part = |half: u16| f32::from(half) / 65_535.0;
    let [r, g] = halves(red_green).map(part);
    let [b, occlusion] = halves(blue_open).map(part);
    // Twelve bits with a sign, at the upper end of sixteen.
    let slope = |half: u16| f32::from(half.cast_signed() >> 4) / 2047.0;
    let [low_slope, high_slope] = [slopes >> 4, slopes >> 16].map(|word| halves(word)[0]);
    let [x, y] = [low_slope & 0xfff0, high_slope & 0xfff0].map(slope);
    let [roughness, translucency, ..] = rest.to_le_bytes();
    let byte = |byte: u8| f32::from(byte) / 255.0;
    let normal = Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
    Texel {
        albedo: [r, g, b],
        alpha: f32::from(count) * share,
        normal: normal.normalize_or(Vec3::Z).to_array(),
        occlusion,
        roughness: byte(roughness),
        translucency: byte(translucency),
        depth: low + part(halves(rest)[1]) * range,
    }
}

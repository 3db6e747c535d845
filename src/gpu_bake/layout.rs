//! Structs that the baking shaders read, member by member.

use bytemuck::{Pod, Zeroable};

/// `Shot` of `shaders/capture.wgsl`, which says what each member means.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Shot {
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub toward: [f32; 4],
    pub centre: [f32; 4],
    pub half: [f32; 2],
    pub depth: [f32; 2],
    pub samples: [u32; 2],
    pub place: [u32; 2],
    pub texels: [u32; 2],
    pub first: u32,
    pub cells: u32,
    pub corner: [f32; 3],
    pub cell: f32,
    pub size: [u32; 3],
    pub unused: u32,
}

/// `Sheet` of `shaders/capture.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Sheet {
    pub size: [f32; 2],
    pub supersample: u32,
    pub reliefs: u32,
    pub bark: [u32; 4],
    pub foliage: [u32; 4],
}

/// `Relief` of `shaders/capture_seen.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Relief {
    pub uv: [f32; 4],
    pub longer: f32,
    pub unused: [f32; 3],
}

/// `Grid` of `shaders/capture_light.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Grid {
    pub size: [u32; 3],
    pub first: u32,
    pub cell: f32,
    pub unused: [u32; 3],
}

/// `Job` of `shaders/shadow_bake.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Job {
    pub size: u32,
    pub row: u32,
    pub bark: u32,
    pub leaves: u32,
    pub samples: u32,
    pub first: u32,
    pub a_light: u32,
    pub mips: u32,
}

/// `Projection` of `shaders/shadow_bake.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Projection {
    pub origin: [f32; 2],
    pub a_metre: [f32; 2],
    pub lean: [f32; 2],
    pub along: [f32; 2],
    pub across: [f32; 2],
    pub share: u32,
    pub number: u32,
}

/// `Level` of `shaders/shadow_bake.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Level {
    pub width: u32,
    pub height: u32,
    pub scale: [f32; 2],
    pub first: u32,
    pub unused: u32,
}

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
    pub corner: [f32; 3],
    pub cell: f32,
    pub size: [u32; 3],
    pub column: u32,
}

impl Shot {
    /// The depth that a finished texel's 0 stands for, and that which 1 is more, metres.
    pub(super) fn depths(&self) -> [f32; 2] {
        let reach = (1.0 / self.depth[1]).max(8.0 * self.half[0].max(self.half[1]));
        [self.depth[0] - reach, 3.0 * reach]
    }
}

/// `Sheet` of `shaders/capture.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Sheet {
    pub size: [f32; 2],
    pub supersample: u32,
    pub longest: f32,
    pub bark: [u32; 4],
    pub foliage: [u32; 4],
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
    pub groups: u32,
    pub coverage: [u32; 2],
    pub mips: u32,
    pub masks: u32,
}

/// `Projection` of `shaders/shadow_bake.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Projection {
    pub origin: [f32; 2],
    pub lean: [f32; 2],
    pub a_metre: [f32; 2],
    pub along: [f32; 2],
    pub across: [f32; 2],
    pub share: u32,
    pub number: u32,
}

/// Samples of a batch, as in `Batch` of `shaders/shadow_bake.wgsl`.
pub const BATCH: usize = 320;

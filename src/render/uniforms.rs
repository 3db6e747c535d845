//! Structs that the shaders read, member by member as in `shaders/frame.wgsl` and `shaders/tree.wgsl`.

use crate::wind::Rig;
use bytemuck::{Pod, Zeroable};

/// `Frame` of `frame.wgsl`, which says what each member means.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Frame {
    pub view_projection: [[f32; 4]; 4],
    pub inverse_view_projection: [[f32; 4]; 4],
    pub light_projection: [[f32; 4]; 4],
    pub eye: [f32; 4],
    pub forward: [f32; 4],
    pub sun: [f32; 4],
    pub sun_light: [f32; 4],
    pub sky_light: [f32; 4],
    pub ground_light: [f32; 4],
    pub zenith: [f32; 4],
    pub horizon: [f32; 4],
    pub ground: [f32; 4],
    pub wind: [f32; 4],
    pub clock: [f32; 4],
    pub viewport: [f32; 4],
    pub modes: [u32; 4],
}

/// `Model` of `tree.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
#[expect(missing_docs, reason = "the shader documents them")]
pub struct Model {
    pub centre: [f32; 4],
    pub extent: [f32; 4],
    pub volume_origin: [f32; 4],
    pub volume_scale: [f32; 4],
    pub shadow_rects: [[f32; 4]; 9],
    pub rig: Rig,
}

/// One tree: `Instance` of `tree.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Instance {
    /// Where its base stands, metres, and its size as a factor.
    pub place: [f32; 4],
    /// Cosine and sine of its turn about +Y; phase in the wind, 0..1; fade, -1..=1.
    pub turn: [f32; 4],
    /// Factor on its colours; the fourth is not used.
    pub tint: [f32; 4],
    /// Its LOD; how far the shadow map shades it, 0..=1; two that are not used.
    pub marks: [f32; 4],
}

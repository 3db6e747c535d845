// What all passes of capturing read: all shots lie side by side on one sheet of samples.

// One orthographic picture.
struct Shot {
    // Unit vectors to the right of the picture, up it, and toward the viewer.
    right: vec4<f32>,
    up: vec4<f32>,
    toward: vec4<f32>,
    // The point in its middle, metres.
    centre: vec4<f32>,
    // Half of its width and height, metres.
    half: vec2<f32>,
    // The smallest depth, metres toward the viewer, and one over the range of depths.
    depth: vec2<f32>,
    // Samples across and down, and where they lie on the sheet.
    samples: vec2<u32>,
    place: vec2<u32>,
    // The grid that darkens it: its corner, edge of a cell in metres, cells along x, y, z.
    corner: vec3<f32>,
    cell: f32,
    size: vec3<u32>,
    // The column where it begins in the picture of all grids, in which one z lies below the other.
    column: u32,
}

struct Sheet {
    // Samples across and down.
    size: vec2<f32>,
    // Samples along the edge of a texel.
    supersample: u32,
    // The longest side of a card in the atlas, metres.
    longest: f32,
    // Width and height of the finest mip, and number of mips.
    bark: vec4<u32>,
    foliage: vec4<u32>,
}

@group(0) @binding(0) var<uniform> sheet: Sheet;
@group(0) @binding(1) var<uniform> shot: Shot;

// A triangle that covers the whole viewport.
fn everywhere(vertex: u32) -> vec4<f32> {
    let corner = vec2<u32>(vertex, vertex >> 1u) & vec2<u32>(1u);
    return vec4<f32>(vec2<f32>(corner) * 4.0 - 1.0, 0.0, 1.0);
}

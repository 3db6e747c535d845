// Captures, the first half: which triangle each sample sees. All shots lie side by side on one sheet of samples.
// `src/capture/raster.rs` is the processor's twin.

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
    // Texels across and down, and the first one's place in the output.
    texels: vec2<u32>,
    first: u32,
    // The grid that darkens it: its first cell, corner, edge of a cell in metres, cells along x, y, z.
    cells: u32,
    corner: vec3<f32>,
    cell: f32,
    size: vec3<u32>,
    unused: u32,
}

struct Sheet {
    // Samples across and down.
    size: vec2<f32>,
    // Samples along the edge of a texel.
    supersample: u32,
    // Number of captures that the atlas holds.
    reliefs: u32,
    // Width and height of the finest mip, and number of mips.
    bark: vec4<u32>,
    foliage: vec4<u32>,
}

// A vertex of a mesh.
struct Vertex {
    position: array<f32, 3>,
    normal: array<f32, 3>,
    tangent: array<f32, 4>,
    uv: array<f32, 2>,
}

@group(0) @binding(0) var<uniform> sheet: Sheet;
@group(0) @binding(1) var<storage, read> shots: array<Shot>;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;

fn position_of(vertex: u32) -> vec3<f32> {
    let p = vertices[vertex].position;
    return vec3<f32>(p[0], p[1], p[2]);
}

// Where a point lies in a picture, samples to the right and down.
fn sample_of(shot: Shot, point: vec3<f32>) -> vec2<f32> {
    let p = point - shot.centre.xyz;
    let across = dot(p, shot.right.xyz) / shot.half.x;
    let up = dot(p, shot.up.xyz) / shot.half.y;
    return vec2<f32>(across * 0.5 + 0.5, 0.5 - up * 0.5) * vec2<f32>(shot.samples);
}

// The mip whose texels are about as large as the samples: from the area of a triangle in texels of the finest
// mip, and in samples.
fn mip_of(texels: f32, samples: f32, mips: u32) -> u32 {
    var ratio = texels / max(samples, 1e-6);
    var level = 0u;
    while ratio > 2.0 && level + 1u < mips {
        ratio *= 0.25;
        level += 1u;
    }
    return level;
}

// Where the nearest texel of a mip lies, clamped at its edges. All mips are in one texture, from the second on in a
// column beside the first: some drivers take one thread's level for all.
fn nearest(uv: vec2<f32>, image: vec4<u32>, level: u32) -> vec2<u32> {
    var corner = vec2<u32>(select(image.x, 0u, level == 0u), 0u);
    for (var above = 1u; above < level; above++) {
        corner.y += max(image.y >> above, 1u);
    }
    let size = max(image.xy >> vec2<u32>(level), vec2<u32>(1u));
    return corner + min(vec2<u32>(max(uv * vec2<f32>(size), vec2<f32>(0.0))), size - 1u);
}

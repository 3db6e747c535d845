// Captures, the first half: the surface that each sample sees, foliage alpha-tested. `src/capture/raster.rs` is the
// processor's twin.
//
// Foliage is drawn many times over, so as little as possible is worked out for it here: which texel is seen, how near it
// is, and the normal, which needs the triangle. The rest is looked up once it is known what is in front.

// Four words a texel: red and green; blue and occlusion; the normal's slopes; roughness.
@group(0) @binding(2) var bark: texture_2d<u32>;
// A word a texel of the atlas: the normal's slopes, their lowest bit 1 where there is foliage.
@group(0) @binding(3) var outlines: texture_2d<u32>;

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec4<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) tint: vec4<f32>,
}

// Normal and tangent are in view axes: to the right, up, toward the viewer.
struct Corner {
    @builtin(position) clip: vec4<f32>,
    // The normal, and u.
    @location(0) normal: vec4<f32>,
    // The tangent, and v.
    @location(1) tangent: vec4<f32>,
    // The tint of bark, and which way the bitangent goes.
    @location(2) tint: vec4<f32>,
}

fn seen_from_here(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(v, shot.right.xyz), dot(v, shot.up.xyz), dot(v, shot.toward.xyz));
}

@vertex
fn vs_capture(vertex: Vertex) -> Corner {
    let p = seen_from_here(vertex.position - shot.centre.xyz);
    let part = vec2<f32>(0.5) + vec2<f32>(p.x, -p.y) / shot.half * 0.5;
    let sample = (part * vec2<f32>(shot.samples) + vec2<f32>(shot.place)) / sheet.size;
    let depth = (p.z - shot.depth.x) * shot.depth.y;
    var out: Corner;
    out.clip = vec4<f32>(sample.x * 2.0 - 1.0, 1.0 - sample.y * 2.0, depth, 1.0);
    out.normal = vec4<f32>(seen_from_here(vertex.normal), vertex.uv.x);
    out.tangent = vec4<f32>(seen_from_here(vertex.tangent.xyz), vertex.uv.y);
    out.tint = vec4<f32>(vertex.tint.rgb, vertex.tangent.w);
    return out;
}

// The mip whose texels are about as large as the samples: the finest with at most two a sample. It is the same over
// all of a triangle, since the picture is orthographic.
fn mip_of(uv: vec2<f32>, image: vec4<u32>) -> u32 {
    let right = dpdx(uv);
    let down = dpdy(uv);
    let ratio = abs(right.x * down.y - right.y * down.x) * f32(image.x) * f32(image.y);
    let log2 = i32((bitcast<u32>(ratio) >> 23u) & 0xffu) - 127;
    return u32(clamp((log2 + 1) >> 1u, 0, i32(image.z) - 1));
}

// Where the nearest texel of a mip lies, clamped at its edges. All mips are in one texture, from the second on in a
// column beside the first: some drivers take one thread's level for all.
fn nearest(uv: vec2<f32>, image: vec4<u32>, level: u32) -> vec2<u32> {
    let beside = vec2<u32>(image.x, image.y - (image.y >> (max(level, 1u) - 1u)));
    let corner = select(beside, vec2<u32>(0u), level == 0u);
    let size = image.xy >> vec2<u32>(level);
    return corner + min(vec2<u32>(max(uv * vec2<f32>(size), vec2<f32>(0.0))), size - 1u);
}

// The mapped normal's slopes in view axes, facing the viewer.
fn view_slopes(in: Corner, slopes: vec2<f32>) -> vec2<f32> {
    let normal = in.normal.xyz * inverseSqrt(max(dot(in.normal.xyz, in.normal.xyz), 1e-30));
    let along = in.tangent.xyz - normal * dot(normal, in.tangent.xyz);
    let tangent = along * inverseSqrt(max(dot(along, along), 1e-30));
    let bitangent = cross(normal, tangent) * in.tint.w;
    // The far side of a card mirrors the near one: its slopes stay, only its plane faces about.
    let facing = select(normal, -normal, normal.z < 0.0);
    let steep = sqrt(max(1.0 - dot(slopes, slopes), 0.0));
    let mapped = tangent * slopes.x + bitangent * slopes.y + facing * steep;
    // A slope that leans past the horizon is seen at the horizon.
    let seen = vec3<f32>(mapped.xy, max(mapped.z, 0.02));
    return seen.xy * inverseSqrt(dot(seen, seen));
}

// Two words a sample, the highest bit of the first set. Colours are kept as their roots, which is about how fine
// differences are seen.
@fragment
fn fs_bark(in: Corner) -> @location(0) vec2<u32> {
    let uv = vec2<f32>(in.normal.w, in.tangent.w);
    let level = mip_of(uv, sheet.bark);
    let words = textureLoad(bark, nearest(uv - floor(uv), sheet.bark, level), 0);
    let blue_open = unpack2x16unorm(words.y);
    let colour = vec3<f32>(unpack2x16unorm(words.x), blue_open.x) * in.tint.rgb;
    let roots = vec3<u32>(sqrt(colour) * 255.0 + 0.5);
    let slopes = vec2<i32>(round(view_slopes(in, unpack2x16snorm(words.z)) * 2047.0));
    let leans = vec2<u32>(slopes) & vec2<u32>(0xfffu);
    let roughness = (words.w & 0xffu) >> 1u;
    return vec2<u32>(
        0x80000000u | roots.x | (roots.y << 8u) | (roots.z << 16u) | (roughness << 24u),
        leans.x | (leans.y << 12u) | (u32(blue_open.y * 255.0 + 0.5) << 24u),
    );
}

// Two words a sample: the texel's column and row, and bit 30 set; how near it is in 14 bits, and the normal's slopes in
// nine each.
@fragment
fn fs_foliage(in: Corner) -> @location(0) vec2<u32> {
    let uv = vec2<f32>(in.normal.w, in.tangent.w);
    let at = nearest(uv, sheet.foliage, mip_of(uv, sheet.foliage));
    let outline = textureLoad(outlines, at, 0).r;
    if (outline & 1u) == 0u {
        discard;
    }
    let slopes = vec2<i32>(round(view_slopes(in, unpack2x16snorm(outline)) * 255.0));
    let leans = vec2<u32>(slopes) & vec2<u32>(0x1ffu);
    let nearness = u32(clamp(in.clip.z, 0.0, 1.0) * 16383.0 + 0.5);
    return vec2<u32>(
        0x40000000u | at.x | (at.y << 15u),
        nearness | (leans.x << 14u) | (leans.y << 23u),
    );
}

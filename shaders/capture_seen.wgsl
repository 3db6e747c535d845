// Captures, the first half: the surface that each sample sees, foliage alpha-tested. `src/capture/raster.rs` is the
// processor's twin.

// A capture that the atlas holds: its place, and the length of its longer side, metres.
struct Relief {
    uv: vec4<f32>,
    longer: f32,
    unused: array<f32, 3>,
}

// Four words a texel: red and green; blue and occlusion; the normal's slopes; depth, roughness and translucency.
@group(0) @binding(2) var bark: texture_2d<u32>;
@group(0) @binding(3) var foliage: texture_2d<u32>;
// 1 where the atlas has foliage.
@group(0) @binding(4) var cutout: texture_2d<f32>;
@group(0) @binding(5) var<storage, read> reliefs: array<Relief>;

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec4<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) tint: vec4<f32>,
}

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec4<f32>,
    @location(3) tint: vec3<f32>,
}

@vertex
fn vs_capture(vertex: Vertex) -> Corner {
    let p = vertex.position - shot.centre.xyz;
    let across = dot(p, shot.right.xyz) / shot.half.x * 0.5 + 0.5;
    let down = 0.5 - dot(p, shot.up.xyz) / shot.half.y * 0.5;
    let at = vec2<f32>(across, down) * vec2<f32>(shot.samples) + vec2<f32>(shot.place);
    let sample = at / sheet.size;
    let depth = (dot(p, shot.toward.xyz) - shot.depth.x) * shot.depth.y;
    var out: Corner;
    out.clip = vec4<f32>(sample.x * 2.0 - 1.0, 1.0 - sample.y * 2.0, depth, 1.0);
    out.uv = vertex.uv;
    out.normal = vertex.normal;
    out.tangent = vertex.tangent;
    out.tint = vertex.tint.rgb;
    return out;
}

// The mip whose texels are about as large as the samples. It is the same over all of a triangle, since the picture
// is orthographic.
fn mip_of(right: vec2<f32>, down: vec2<f32>, image: vec4<u32>) -> u32 {
    var ratio = abs(right.x * down.y - right.y * down.x) * f32(image.x) * f32(image.y);
    var level = 0u;
    while ratio > 2.0 && level + 1u < image.z {
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

fn unit_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(other, v / max(size, 1e-30), size > 1e-30);
}

// The mapped normal in view axes, facing the viewer.
fn view_normal(in: Corner, slopes: vec2<f32>) -> vec3<f32> {
    let mapped = vec3<f32>(slopes, sqrt(max(1.0 - dot(slopes, slopes), 0.0)));
    let normal = unit_or(in.normal, vec3<f32>(0.0, 0.0, 1.0));
    let along = in.tangent.xyz - normal * dot(normal, in.tangent.xyz);
    let tangent = unit_or(along, vec3<f32>(1.0, 0.0, 0.0));
    let bitangent = cross(normal, tangent) * in.tangent.w;
    // The far side of a card mirrors the near one: its slopes stay, only its plane faces about.
    let facing = select(normal, -normal, dot(normal, shot.toward.xyz) < 0.0);
    let world = unit_or(tangent * mapped.x + bitangent * mapped.y + facing * mapped.z, facing);
    let local = vec3<f32>(
        dot(world, shot.right.xyz),
        dot(world, shot.up.xyz),
        max(dot(world, shot.toward.xyz), 0.02),
    );
    return unit_or(local, vec3<f32>(0.0, 0.0, 1.0));
}

// Length of the longer side of the capture at a place in the atlas; 0 where there is none.
fn longer_at(uv: vec2<f32>) -> f32 {
    for (var i = 0u; i < sheet.reliefs; i++) {
        let place = reliefs[i].uv;
        if all(uv >= place.xy) && all(uv <= place.zw) {
            return reliefs[i].longer;
        }
    }
    return 0.0;
}

// As in the textures, but the normal in view axes, and depth from the surface in parts of the reach.
fn packed(words: vec4<u32>, normal: vec3<f32>, depth: f32) -> vec4<u32> {
    let last = (words.w & 0xffff0000u) | (pack2x16snorm(vec2<f32>(depth / reach(), 0.0)) & 0xffffu);
    return vec4<u32>(words.xy, pack2x16snorm(normal.xy), last);
}

@fragment
fn fs_bark(in: Corner) -> @location(0) vec4<u32> {
    let level = mip_of(dpdx(in.uv), dpdy(in.uv), sheet.bark);
    let words = textureLoad(bark, nearest(in.uv - floor(in.uv), sheet.bark, level), 0);
    let normal = view_normal(in, unpack2x16snorm(words.z));
    let red_green = pack2x16unorm(unpack2x16unorm(words.x) * in.tint.rg);
    let blue_open = pack2x16unorm(unpack2x16unorm(words.y) * vec2<f32>(in.tint.b, 1.0));
    return packed(vec4<u32>(red_green, blue_open, words.z, words.w & 0x00ffffffu), normal, 0.0);
}

@fragment
fn fs_foliage(in: Corner) -> @location(0) vec4<u32> {
    let level = mip_of(dpdx(in.uv), dpdy(in.uv), sheet.foliage);
    let at = nearest(in.uv, sheet.foliage, level);
    if textureLoad(cutout, at, 0).r < 0.5 {
        discard;
    }
    let words = textureLoad(foliage, at, 0);
    let normal = view_normal(in, unpack2x16snorm(words.z));
    return packed(words, normal, unpack2x16snorm(words.w).x * longer_at(in.uv));
}

// Captures, the second half: samples averaged to texels, and shaded by the crown's density. `src/capture/cpu.rs` is
// the processor's twin.

// What each sample sees, and how near it is: 0 where it sees nothing.
@group(0) @binding(2) var seen: texture_2d<u32>;
@group(0) @binding(3) var near: texture_depth_2d;
// How much light reaches each cell of all grids.
@group(0) @binding(4) var<storage, read> open: array<f32>;
// Five words a texel: red and green; blue and occlusion; the normal's slopes; roughness, translucency and the
// number of samples that see something; depth in metres.
@group(0) @binding(5) var<storage, read_write> output: array<u32>;

const WORDS: u32 = 5u;

// How much light reaches a point, smooth between cells.
fn open_at(point: vec3<f32>) -> f32 {
    let p = (point - shot.corner) / shot.cell - 0.5;
    let base = floor(p);
    let part = p - base;
    let last = vec3<f32>(shot.size - 1u);
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let step = vec3<f32>(vec3<u32>(corner, corner >> 1u, corner >> 2u) & vec3<u32>(1u));
        let weight = mix(1.0 - part, part, step);
        let at = vec3<u32>(clamp(base + step, vec3<f32>(0.0), last));
        let index = (at.z * shot.size.y + at.y) * shot.size.x + at.x;
        sum += open[shot.cells + index] * weight.x * weight.y * weight.z;
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn cs_texels(@builtin(global_invocation_id) id: vec3<u32>) {
    let texel = id.xy;
    if any(texel >= shot.texels) {
        return;
    }
    let n = sheet.supersample;
    var count = 0u;
    // Albedo and occlusion; normal; roughness, translucency and depth.
    var colour = vec4<f32>(0.0);
    var normal = vec3<f32>(0.0);
    var rest = vec3<f32>(0.0);
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            let at = shot.place + texel * n + vec2<u32>(x, y);
            let nearness = textureLoad(near, at, 0);
            if nearness == 0.0 {
                continue;
            }
            let words = textureLoad(seen, at, 0);
            let slopes = unpack2x16snorm(words.z);
            let looks = unpack4x8unorm(words.w).zw;
            let offset = unpack2x16snorm(words.w).x * reach();
            let depth = shot.depth.x + nearness / shot.depth.y + offset;
            colour += vec4<f32>(unpack2x16unorm(words.x), unpack2x16unorm(words.y));
            normal += vec3<f32>(slopes, sqrt(max(1.0 - dot(slopes, slopes), 0.0)));
            rest += vec3<f32>(looks, depth);
            count++;
        }
    }
    let first = (shot.first + texel.y * shot.texels.x + texel.x) * WORDS;
    if count == 0u {
        output[first + 3u] = 0u;
        return;
    }
    let share = 1.0 / f32(count);
    colour *= share;
    rest *= share;
    let at = (vec2<f32>(texel) + 0.5) / vec2<f32>(shot.texels) * 2.0 - 1.0;
    let point = shot.centre.xyz + shot.right.xyz * (at.x * shot.half.x)
        - shot.up.xyz * (at.y * shot.half.y) + shot.toward.xyz * rest.z;
    colour.w *= open_at(point);
    normal /= max(length(normal), 1e-30);
    output[first] = pack2x16unorm(colour.xy);
    output[first + 1u] = pack2x16unorm(colour.zw);
    output[first + 2u] = pack2x16snorm(normal.xy);
    output[first + 3u] = pack4x8unorm(vec4<f32>(rest.xy, 0.0, 0.0)) | (count << 16u);
    output[first + 4u] = bitcast<u32>(rest.z);
}

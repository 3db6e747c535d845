// Captures, the second half: samples averaged to texels, and shaded by the crown's density. `src/capture/cpu.rs` is
// the processor's twin.

// What each sample sees, 0 where it sees nothing, and how near it is.
@group(0) @binding(2) var seen: texture_2d<u32>;
@group(0) @binding(3) var near: texture_depth_2d;
// How much light reaches each cell of all grids.
@group(0) @binding(4) var open: texture_2d<f32>;
// Two words a texel: the roots of its colour, and occlusion; roughness, translucency, and the depth from the surface
// as a part of the longest card's side.
@group(0) @binding(5) var foliage: texture_2d<u32>;

// How much light reaches a point, smooth between cells.
fn open_at(point: vec3<f32>) -> f32 {
    let p = (point - shot.corner) / shot.cell - 0.5;
    let base = floor(p);
    let part = p - base;
    let last = vec3<f32>(shot.size - 1u);
    let low = vec3<u32>(clamp(base, vec3<f32>(0.0), last));
    let high = vec3<u32>(clamp(base + 1.0, vec3<f32>(0.0), last));
    let lower = open_in_plane(low, high, part.xy, low.z);
    return mix(lower, open_in_plane(low, high, part.xy, high.z), part.z);
}

fn open_in_plane(low: vec3<u32>, high: vec3<u32>, part: vec2<f32>, z: u32) -> f32 {
    let left = shot.column + low.x;
    let right = shot.column + high.x;
    let above = z * shot.size.y + low.y;
    let below = z * shot.size.y + high.y;
    let upper = mix(open_of(left, above), open_of(right, above), part.x);
    return mix(upper, mix(open_of(left, below), open_of(right, below), part.x), part.y);
}

fn open_of(x: u32, y: u32) -> f32 {
    return textureLoad(open, vec2<u32>(x, y), 0).r;
}

// The surface that a sample sees.
struct Surface {
    // Albedo and occlusion.
    colour: vec4<f32>,
    slopes: vec2<f32>,
    // Roughness, translucency, and depth in metres.
    rest: vec3<f32>,
}

// The depth that lies so near.
fn depth_of(nearness: f32) -> f32 {
    return shot.depth.x + nearness / shot.depth.y;
}

// What the first half kept of bark.
fn of_bark(words: vec2<u32>, at: vec2<u32>) -> Surface {
    let roots = unpack4x8unorm(words.x).rgb;
    let slopes = vec2<i32>(vec2<u32>(words.y << 20u, words.y << 8u)) >> vec2<u32>(20u);
    let roughness = f32((words.x >> 24u) & 0x7fu) / 127.0;
    let occlusion = f32(words.y >> 24u) / 255.0;
    return Surface(
        vec4<f32>(roots * roots, occlusion),
        vec2<f32>(slopes) / 2047.0,
        vec3<f32>(roughness, 0.0, depth_of(textureLoad(near, at, 0))),
    );
}

fn of_foliage(words: vec2<u32>) -> Surface {
    let texel = textureLoad(foliage, vec2<u32>(words.x, words.x >> 15u) & vec2<u32>(0x7fffu), 0).xy;
    let colour = unpack4x8unorm(texel.x);
    let slopes = vec2<i32>(vec2<u32>(words.y << 9u, words.y)) >> vec2<u32>(23u);
    let depth = depth_of(f32(words.y & 0x3fffu) / 16383.0) + unpack2x16snorm(texel.y).y * sheet.longest;
    return Surface(
        vec4<f32>(colour.rgb * colour.rgb, colour.a),
        vec2<f32>(slopes) / 255.0,
        vec3<f32>(unpack4x8unorm(texel.y).xy, depth),
    );
}

@vertex
fn vs_texels(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return everywhere(vertex);
}

// Four words a texel: red and green; blue and occlusion; the number of samples that see something and the normal's
// slopes of twelve bits; roughness, translucency, and the depth, from one reach below the shot's to two above.
@fragment
fn fs_texels(@builtin(position) position: vec4<f32>) -> @location(0) vec4<u32> {
    let n = sheet.supersample;
    let first = vec2<u32>(position.xy) * n;
    var count = 0u;
    var colour = vec4<f32>(0.0);
    var normal = vec3<f32>(0.0);
    // Roughness, translucency and depth.
    var rest = vec3<f32>(0.0);
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            let at = first + vec2<u32>(x, y);
            let words = textureLoad(seen, at, 0).xy;
            if words.x == 0u {
                continue;
            }
            var surface: Surface;
            if words.x >= 0x80000000u {
                surface = of_bark(words, at);
            } else {
                surface = of_foliage(words);
            }
            let slopes = surface.slopes;
            colour += surface.colour;
            normal += vec3<f32>(slopes, sqrt(max(1.0 - dot(slopes, slopes), 0.0)));
            rest += surface.rest;
            count++;
        }
    }
    if count == 0u {
        return vec4<u32>(0u);
    }
    let share = 1.0 / f32(count);
    colour *= share;
    rest *= share;
    let middle = (position.xy * f32(n) - vec2<f32>(shot.place)) / vec2<f32>(shot.samples) * 2.0 - 1.0;
    let point = shot.centre.xyz + shot.right.xyz * (middle.x * shot.half.x)
        - shot.up.xyz * (middle.y * shot.half.y) + shot.toward.xyz * rest.z;
    colour.w *= open_at(point);
    let leans = vec2<u32>(vec2<i32>(round(normalize(normal).xy * 2047.0))) & vec2<u32>(0xfffu);
    let reach = max(1.0 / shot.depth.y, 8.0 * max(shot.half.x, shot.half.y));
    let depth = clamp(((rest.z - shot.depth.x) / reach + 1.0) / 3.0, 0.0, 1.0);
    return vec4<u32>(
        pack2x16unorm(colour.xy),
        pack2x16unorm(colour.zw),
        count | (leans.x << 8u) | (leans.y << 20u),
        (pack4x8unorm(vec4<f32>(rest.xy, 0.0, 0.0)) & 0xffffu) | (u32(depth * 65535.0 + 0.5) << 16u),
    );
}

// Sky, ground, and the nine baked shadows laid on it by projective texturing (Koniaris et al., section IV.F).

struct Model {
    centre: vec4<f32>,
    extent: vec4<f32>,
    volume_origin: vec4<f32>,
    volume_scale: vec4<f32>,
    shadow_rects: array<vec4<f32>, 9>,
    rig: WindRig,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Part of the sun that baked shadows leave to the ground, for each pixel.
@group(0) @binding(4) var ground_shadows: texture_2d<f32>;

@group(1) @binding(0) var<uniform> model: Model;
@group(1) @binding(1) var smooth_sampler: sampler;
@group(1) @binding(5) var baked_shadows: texture_2d_array<f32>;

struct Screen {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

// One triangle that covers the picture, behind everything.
@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> Screen {
    let at = vec2<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Screen(vec4<f32>(at, 0.0, 1.0), at);
}

fn unprojected(at: vec2<f32>, depth: f32) -> vec3<f32> {
    let p = frame.inverse_view_projection * vec4<f32>(at, depth, 1.0);
    return p.xyz / p.w;
}

// A number in 0..1 for each cell of a grid (Jarzynski and Olano 2020, pcg2d).
fn cell_noise(cell: vec2<f32>) -> f32 {
    var v = vec2<u32>(vec2<i32>(cell)) * 1664525u + 1013904223u;
    v += vec2<u32>(v.y, v.x) * 1664525u;
    v ^= v >> vec2<u32>(16u);
    v += vec2<u32>(v.y, v.x) * 1664525u;
    return f32((v.x ^ (v.x >> 16u)) & 0xffffu) / 65535.0;
}

// Slow changes over the ground, 0..1, so that it does not read as a sheet of paper.
fn mottle(p: vec2<f32>) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let u = f * f * (3.0 - 2.0 * f);
    return mix(
        mix(cell_noise(cell), cell_noise(cell + vec2<f32>(1.0, 0.0)), u.x),
        mix(cell_noise(cell + vec2<f32>(0.0, 1.0)), cell_noise(cell + vec2<f32>(1.0, 1.0)), u.x),
        u.y);
}

// Albedo of the ground: turf, drier here and there, with detail that fades before it could shimmer.
// `footprint` is the length of a pixel on it, metres.
fn turf(p: vec2<f32>, footprint: f32) -> vec3<f32> {
    var patches = 0.0;
    var tufts = 0.0;
    var scale = 0.045;
    for (var i = 0; i < 11; i++) {
        let part = saturate(1.65 - footprint * scale * 2.3);
        if part == 0.0 {
            break;
        }
        // Each octave is turned against the last, so that no grid shows.
        let turn = f32(i) * 0.9;
        let q = vec2<f32>(p.x * cos(turn) - p.y * sin(turn), p.x * sin(turn) + p.y * cos(turn));
        let noise = (mottle(q * scale + f32(i) * 17.3) - 0.5) * part;
        if i < 3 {
            patches += noise * 0.24;
        } else {
            // Grass is most uneven from blade to blade.
            tufts += noise * min(0.16 * f32(i - 2), 0.85);
        }
        scale *= 2.4;
    }
    let dried = vec3<f32>(0.124, 0.112, 0.056);
    let dry = smoothstep(-0.15, 0.5, patches + 0.2 * tufts) * 0.5;
    return mix(frame.ground.rgb, dried, dry) * (1.0 + 0.5 * patches) * clamp(1.0 + tufts, 0.2, 1.9);
}

// Fair-weather clouds: how much of them lies in a direction, 0..1, thin toward the horizon's haze.
fn clouds(direction: vec3<f32>) -> f32 {
    let p = direction.xz / (direction.y + 0.12) * 0.9;
    var sum = 0.0;
    var part = 0.5;
    var scale = 1.0;
    for (var i = 0; i < 5; i++) {
        sum += mottle(p * scale + vec2<f32>(f32(i) * 7.7, 3.1) + 40.0) * part;
        part *= 0.5;
        scale *= 2.17;
    }
    return smoothstep(0.5, 0.8, sum) * smoothstep(0.02, 0.25, direction.y);
}

@fragment
fn fs_backdrop(in: Screen) -> @location(0) vec4<f32> {
    // Reversed depth: 1 is near. An orthographic camera's rays start on its near plane.
    let near = unprojected(in.at, 1.0);
    let start = mix(near, frame.eye.xyz, frame.eye.w);
    let direction = mix(frame.forward.xyz, normalize(near - frame.eye.xyz), frame.eye.w);
    let sky = sky_colour(direction, frame);
    if direction.y >= -1e-4 {
        let white = frame.sky_light.rgb * 0.55 + frame.sun_light.rgb * 0.075;
        return vec4<f32>(mix(sky, white, 0.75 * clouds(direction)), 1.0) * frame.ground.w;
    }
    let way = -start.y / direction.y;
    if way <= 0.0 {
        return vec4<f32>(sky_colour(vec3<f32>(direction.x, -direction.y, direction.z), frame), 1.0) * frame.ground.w;
    }
    let at = start + direction * way;
    let lit = textureLoad(ground_shadows, vec2<i32>(in.clip.xy), 0).x;
    // Between the width and the length of what a pixel covers: by its length alone, turf would be a blur.
    let footprint = way * frame.viewport.w * 0.6 / sqrt(max(-direction.y, 0.01));
    let sun = frame.sun_light.rgb * max(frame.sun.y, 0.0) / PI * lit;
    let colour = turf(at.xz, footprint) * (sun + frame.sky_light.rgb * mix(0.72, 1.0, lit));
    // Distance along the ground, so that the horizon is a haze and not an edge.
    let far = sky_colour(normalize(vec3<f32>(direction.x, 0.0, direction.z) + vec3<f32>(0.0, 1e-5, 0.0)), frame);
    return vec4<f32>(mix(colour, far, haze_over(way, frame)), 1.0) * frame.ground.w;
}

struct Instance {
    @location(6) place: vec4<f32>,
    @location(7) turn: vec4<f32>,
    @location(8) tint: vec4<f32>,
    @location(9) marks: vec4<f32>,
}

struct Patch {
    @builtin(position) clip: vec4<f32>,
    // On the ground in the tree's frame, pulled in along the sun as far as its shadow is stretched.
    @location(0) at: vec2<f32>,
    @location(1) @interpolate(flat) to_sun: vec3<f32>,
}

// By how much a low sun makes shadows longer than the baked ones.
fn stretch_of(to_sun: vec3<f32>) -> f32 {
    return clamp(length(to_sun.xz) / max(to_sun.y, 1e-3), 1.0, 6.0);
}

// The ground that the shadows in use cover, stretched along the sun.
@vertex
fn vs_patch(@builtin(vertex_index) index: u32, instance: Instance) -> Patch {
    return patch_of(index, instance);
}

fn patch_of(index: u32, instance: Instance) -> Patch {
    let to_sun = turned_back(frame.sun.xyz, instance.turn.xy);
    let shares = nine_shares(to_sun);
    var rect = vec4<f32>(1e9, 1e9, -1e9, -1e9);
    for (var i = 0; i < 9; i++) {
        if share_of(shares, i) > 0.0 {
            rect = vec4<f32>(min(rect.xy, model.shadow_rects[i].xy), max(rect.zw, model.shadow_rects[i].zw));
        }
    }
    // Two triangles: corners 0 1 2, 3 2 1.
    let corner = select(index, 6u - index, index > 2u);
    let at = vec2<f32>(select(rect.x, rect.z, (corner & 1u) == 1u), select(rect.y, rect.w, (corner & 2u) == 2u));
    let along = to_sun.xz / max(length(to_sun.xz), 1e-6);
    let far = at + along * dot(at, along) * (stretch_of(to_sun) - 1.0);
    let world = instance.place.xyz
        + turned(vec3<f32>(far.x, 0.0, far.y) * instance.place.w, instance.turn.xy);
    return Patch(frame.view_projection * vec4<f32>(world.x, 0.0, world.z, 1.0), at, to_sun);
}

// Part of the sun that passes: multiplied into what other trees leave.
@fragment
fn fs_patch(in: Patch) -> @location(0) vec4<f32> {
    let shares = nine_shares(in.to_sun);
    var shadow = 0.0;
    for (var i = 0; i < 9; i++) {
        let rect = model.shadow_rects[i];
        let uv = (in.at - rect.xy) / (rect.zw - rect.xy);
        let inside = all(uv > vec2<f32>(0.0)) && all(uv < vec2<f32>(1.0));
        let texel = textureSample(baked_shadows, smooth_sampler, uv, i).x;
        shadow += select(0.0, texel, inside) * share_of(shares, i);
    }
    let low = saturate(in.to_sun.y * 12.0);
    return vec4<f32>(1.0 - shadow * frame.sun_light.w * low);
}

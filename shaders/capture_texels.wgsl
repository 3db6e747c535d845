// Captures, the second half: the surface at every sample, averaged to texels, and shaded by the crown's density.
// `src/capture/raster.rs` and `cpu.rs` are the processor's twins.

// A capture that the atlas holds: its place, and the length of its longer side, metres.
struct Relief {
    uv: vec4<f32>,
    longer: f32,
    unused: array<f32, 3>,
}

// What a surface is like.
struct Surface {
    albedo: vec3<f32>,
    normal: vec3<f32>,
    occlusion: f32,
    roughness: f32,
    translucency: f32,
    depth: f32,
}

@group(0) @binding(4) var seen: texture_2d<u32>;
// Eight by eight texels each: which shot, and which of its tiles across (low half) and down.
@group(0) @binding(5) var<storage, read> tiles: array<vec2<u32>>;
// How much light reaches each cell of all grids.
@group(0) @binding(6) var<storage, read> open: array<f32>;
@group(0) @binding(7) var<storage, read> reliefs: array<Relief>;
// Five words a texel: red and green; blue and occlusion; the normal's slopes; roughness, translucency and the
// number of samples that see something; depth in metres.
@group(0) @binding(8) var<storage, read_write> output: array<u32>;
@group(0) @binding(9) var bark: texture_2d<u32>;
@group(0) @binding(10) var foliage: texture_2d<u32>;

const WORDS: u32 = 5u;

fn unit_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(other, v / max(size, 1e-30), size > 1e-30);
}

fn unpacked(words: vec4<u32>) -> Surface {
    let red_green = unpack2x16unorm(words.x);
    let blue_open = unpack2x16unorm(words.y);
    let slope = unpack2x16snorm(words.z);
    let rest = unpack4x8unorm(words.w);
    var surface: Surface;
    surface.albedo = vec3<f32>(red_green, blue_open.x);
    surface.occlusion = blue_open.y;
    surface.normal = vec3<f32>(slope, sqrt(max(1.0 - dot(slope, slope), 0.0)));
    surface.depth = unpack2x16snorm(words.w).x;
    surface.roughness = rest.z;
    surface.translucency = rest.w;
    return surface;
}

// The mapped normal at a point of a triangle, in view axes, facing the viewer.
fn view_normal(shot: Shot, corners: vec3<u32>, b: vec3<f32>, mapped: vec3<f32>) -> vec3<f32> {
    var normal = vec3<f32>(0.0);
    var tangent = vec3<f32>(0.0);
    for (var i = 0u; i < 3u; i++) {
        let n = vertices[corners[i]].normal;
        let t = vertices[corners[i]].tangent;
        normal += vec3<f32>(n[0], n[1], n[2]) * b[i];
        tangent += vec3<f32>(t[0], t[1], t[2]) * b[i];
    }
    normal = unit_or(normal, vec3<f32>(0.0, 0.0, 1.0));
    tangent = unit_or(tangent - normal * dot(normal, tangent), vec3<f32>(1.0, 0.0, 0.0));
    let bitangent = cross(normal, tangent) * vertices[corners.x].tangent[3];
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

// The surface of the triangle that a sample sees.
fn surface_at(shot: Shot, id: u32, at: vec2<f32>) -> Surface {
    let is_foliage = (id & 1u) == 1u;
    let first = (id >> 1u) * 3u;
    let corners = vec3<u32>(indices[first], indices[first + 1u], indices[first + 2u]);
    let points = array<vec3<f32>, 3>(
        position_of(corners.x),
        position_of(corners.y),
        position_of(corners.z),
    );
    let a = sample_of(shot, points[0]);
    let to_b = sample_of(shot, points[1]) - a;
    let to_c = sample_of(shot, points[2]) - a;
    let area = to_b.x * to_c.y - to_b.y * to_c.x;
    var b = vec3<f32>(1.0, 0.0, 0.0);
    if area != 0.0 {
        let p = at - a;
        let at_b = (p.x * to_c.y - p.y * to_c.x) / area;
        let at_c = (to_b.x * p.y - to_b.y * p.x) / area;
        b = vec3<f32>(1.0 - at_b - at_c, at_b, at_c);
    }
    let uvs = array<vec2<f32>, 3>(
        vec2<f32>(vertices[corners.x].uv[0], vertices[corners.x].uv[1]),
        vec2<f32>(vertices[corners.y].uv[0], vertices[corners.y].uv[1]),
        vec2<f32>(vertices[corners.z].uv[0], vertices[corners.z].uv[1]),
    );
    let uv = uvs[0] * b.x + uvs[1] * b.y + uvs[2] * b.z;
    let edge_b = uvs[1] - uvs[0];
    let edge_c = uvs[2] - uvs[0];
    let patch_area = abs(edge_b.x * edge_c.y - edge_b.y * edge_c.x);
    var surface: Surface;
    if is_foliage {
        let level = mip_of(patch_area * area_of(sheet.foliage), abs(area), sheet.foliage.z);
        surface = unpacked(textureLoad(foliage, nearest(uv, sheet.foliage, level), 0));
        surface.depth *= longer_at(uv);
    } else {
        let level = mip_of(patch_area * area_of(sheet.bark), abs(area), sheet.bark.z);
        surface = unpacked(textureLoad(bark, nearest(uv - floor(uv), sheet.bark, level), 0));
        surface.depth = 0.0;
        surface.translucency = 0.0;
    }
    surface.normal = view_normal(shot, corners, b, surface.normal);
    let middle = points[0] * b.x + points[1] * b.y + points[2] * b.z - shot.centre.xyz;
    surface.depth += dot(middle, shot.toward.xyz);
    return surface;
}

// Texels of the finest mip.
fn area_of(image: vec4<u32>) -> f32 {
    return f32(image.x) * f32(image.y);
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

// How much light reaches a point, smooth between cells.
fn open_at(shot: Shot, point: vec3<f32>) -> f32 {
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
fn cs_texels(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
) {
    let number = group.y * groups.x + group.x;
    if number >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[number];
    let shot = shots[tile.x];
    let texel = vec2<u32>(tile.y & 0xffffu, tile.y >> 16u) * 8u + local.xy;
    if any(texel >= shot.texels) {
        return;
    }
    let n = sheet.supersample;
    var count = 0u;
    var mean: Surface;
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            let sample = texel * n + vec2<u32>(x, y);
            let id = textureLoad(seen, shot.place + sample, 0).r;
            if id == 0u {
                continue;
            }
            let one = surface_at(shot, id - 1u, vec2<f32>(sample) + 0.5);
            mean.albedo += one.albedo;
            mean.normal += one.normal;
            mean.occlusion += one.occlusion;
            mean.roughness += one.roughness;
            mean.translucency += one.translucency;
            mean.depth += one.depth;
            count++;
        }
    }
    let first = (shot.first + texel.y * shot.texels.x + texel.x) * WORDS;
    if count == 0u {
        output[first + 3u] = 0u;
        return;
    }
    let share = 1.0 / f32(count);
    let depth = mean.depth * share;
    let at = (vec2<f32>(texel) + 0.5) / vec2<f32>(shot.texels) * 2.0 - 1.0;
    let point = shot.centre.xyz + shot.right.xyz * (at.x * shot.half.x)
        - shot.up.xyz * (at.y * shot.half.y) + shot.toward.xyz * depth;
    let albedo = mean.albedo * share;
    let occlusion = mean.occlusion * share * open_at(shot, point);
    let normal = unit_or(mean.normal, vec3<f32>(0.0, 0.0, 1.0));
    let rest = vec4<f32>(mean.roughness * share, mean.translucency * share, 0.0, 0.0);
    output[first] = pack2x16unorm(albedo.xy);
    output[first + 1u] = pack2x16unorm(vec2<f32>(albedo.z, occlusion));
    output[first + 2u] = pack2x16snorm(normal.xy);
    output[first + 3u] = pack4x8unorm(rest) | (count << 16u);
    output[first + 4u] = bitcast<u32>(depth);
}

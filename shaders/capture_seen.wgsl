// Which triangle each sample sees: the nearest one, foliage alpha-tested.

// 1 where the atlas has foliage.
@group(0) @binding(4) var cutout: texture_2d<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) triangle: u32,
}

@vertex
fn vs_capture(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Corner {
    let shot = shots[index];
    let vertex = indices[corner];
    let point = position_of(vertex);
    let sample = (sample_of(shot, point) + vec2<f32>(shot.place)) / sheet.size;
    let depth = (dot(point - shot.centre.xyz, shot.toward.xyz) - shot.depth.x) * shot.depth.y;
    var out: Corner;
    out.clip = vec4<f32>(sample.x * 2.0 - 1.0, 1.0 - sample.y * 2.0, depth, 1.0);
    out.uv = vec2<f32>(vertices[vertex].uv[0], vertices[vertex].uv[1]);
    out.triangle = corner / 3u;
    return out;
}

// 0 is nothing; else twice the triangle, one more, and another one more for foliage.
@fragment
fn fs_bark(in: Corner) -> @location(0) u32 {
    return in.triangle * 2u + 1u;
}

@fragment
fn fs_foliage(in: Corner) -> @location(0) u32 {
    // The same over all of a triangle, since the picture is orthographic.
    let texels = vec2<f32>(sheet.foliage.xy);
    let right = dpdx(in.uv) * texels;
    let down = dpdy(in.uv) * texels;
    let level = mip_of(abs(right.x * down.y - right.y * down.x), 1.0, sheet.foliage.z);
    if textureLoad(cutout, nearest(in.uv, sheet.foliage, level), 0).r < 0.5 {
        discard;
    }
    return in.triangle * 2u + 2u;
}

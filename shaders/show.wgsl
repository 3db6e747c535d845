// A picture that is finished, shown in a window. The shader of the window's own toolkit can do more, and costs a
// software driver ten times as much.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var linear_sampler: sampler;

// 1 if the target encodes sRGB by itself, so that it must be given linear light.
override target_encodes: f32 = 0.0;

struct Screen {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> Screen {
    let at = vec2<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Screen(vec4<f32>(at, 0.0, 1.0), at * vec2<f32>(0.5, -0.5) + 0.5);
}

fn decoded(encoded: vec3<f32>) -> vec3<f32> {
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3<f32>(2.4));
    return select(high, low, encoded <= vec3<f32>(0.04045));
}

@fragment
fn fs_show(in: Screen) -> @location(0) vec4<f32> {
    // Some views cover their pixels in part: the rest is black.
    let texel = textureSampleLevel(picture, linear_sampler, in.uv, 0.0);
    let colour = texel.rgb * texel.a;
    if target_encodes > 0.5 {
        return vec4<f32>(decoded(colour), 1.0);
    }
    return vec4<f32>(colour, 1.0);
}

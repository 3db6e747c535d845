// From linear light to the screen: filters (Candussi et al., section 2.3), tone mapping, sRGB.

@group(0) @binding(0) var<uniform> frame: Frame;

@group(1) @binding(0) var trees: texture_2d<f32>;
@group(1) @binding(1) var backdrop: texture_2d<f32>;
@group(1) @binding(2) var linear_sampler: sampler;

// 1 if the target encodes sRGB by itself.
override target_encodes: f32 = 1.0;

struct Screen {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> Screen {
    let at = vec2<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return Screen(vec4<f32>(at, 0.0, 1.0), at * vec2<f32>(0.5, -0.5) + 0.5);
}

// Trees over their backdrop at a texel. With the alpha filter, the trees' alpha is the mean of nine; their
// colour is that of the covered ones among them, so that no dark fringe comes in.
fn composed(texel: vec2<i32>) -> vec4<f32> {
    let last = vec2<i32>(textureDimensions(trees)) - 1;
    let behind = textureLoad(backdrop, clamp(texel, vec2<i32>(0), last), 0);
    let own = textureLoad(trees, clamp(texel, vec2<i32>(0), last), 0);
    var front = own;
    if (frame.modes.z & FILTER_ALPHA) != 0u {
        var sum = vec4<f32>(0.0);
        for (var i = 0; i < 9; i++) {
            let at = clamp(texel + vec2<i32>(i % 3 - 1, i / 3 - 1), vec2<i32>(0), last);
            sum += textureLoad(trees, at, 0);
        }
        let alpha = sum.a / 9.0;
        let colour = select(sum.rgb / max(sum.a, 1e-4), own.rgb / max(own.a, 1e-4), own.a > 0.0);
        front = vec4<f32>(colour * alpha, alpha);
    }
    return vec4<f32>(front.rgb + behind.rgb * (1.0 - front.a), front.a + behind.a * (1.0 - front.a));
}

fn filtered(uv: vec2<f32>) -> vec4<f32> {
    let size = vec2<f32>(textureDimensions(trees));
    let at = uv * size;
    if (frame.modes.z & FILTER_BILINEAR) == 0u {
        return composed(vec2<i32>(at));
    }
    let low = floor(at - 0.5);
    let f = at - 0.5 - low;
    let t = vec2<i32>(low);
    return mix(
        mix(composed(t), composed(t + vec2<i32>(1, 0)), f.x),
        mix(composed(t + vec2<i32>(0, 1)), composed(t + vec2<i32>(1, 1)), f.x),
        f.y);
}

// Khronos's neutral tone mapper (2024): colours keep their hue; only what is bright is compressed.
fn neutral(light: vec3<f32>) -> vec3<f32> {
    let start = 0.8 - 0.04;
    let least = min(light.r, min(light.g, light.b));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    var c = light - offset;
    let peak = max(c.r, max(c.g, c.b));
    if peak < start {
        return c;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    c *= new_peak / peak;
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(c, vec3<f32>(new_peak), g);
}

fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let low = linear * 12.92;
    let high = 1.055 * pow(max(linear, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3<f32>(0.0031308));
}

@fragment
fn fs_present(in: Screen) -> @location(0) vec4<f32> {
    let light = filtered(in.uv);
    // What is see-through is mapped as if it were whole, and told with its alpha beside it.
    let alpha = saturate(light.a);
    let mapped = saturate(neutral(max(light.rgb / max(alpha, 1e-4), vec3<f32>(0.0)) * frame.forward.w));
    return vec4<f32>(select(encoded(mapped), mapped, target_encodes > 0.5), alpha);
}

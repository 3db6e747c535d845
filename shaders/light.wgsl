// Light as functions of plain numbers: no bindings.

// Shares of the nine baked lights for a sun between them; the same formula as `pleach::shadow::weights`.
struct NineShares {
    // The vertical light, then the ring's from +X toward +Z.
    first: vec4<f32>,
    second: vec4<f32>,
    third: f32,
}

fn nine_shares(to_sun: vec3<f32>) -> NineShares {
    let level = length(to_sun.xz);
    if level == 0.0 {
        return NineShares(vec4<f32>(1.0, 0.0, 0.0, 0.0), vec4<f32>(0.0), 0.0);
    }
    let ring = select(1.0, level / to_sun.y, to_sun.y > level);
    let at = fract(atan2(to_sun.z, to_sun.x) / (2.0 * PI)) * 8.0;
    let step = vec4<f32>(0.0, 1.0, 2.0, 3.0);
    // How near each light of the ring is, in steps of 45 degrees around it.
    let low = abs(step - at);
    let high = abs(step + 4.0 - at);
    let a = ring * max(1.0 - min(low, 8.0 - low), vec4<f32>(0.0));
    let b = ring * max(1.0 - min(high, 8.0 - high), vec4<f32>(0.0));
    return NineShares(vec4<f32>(1.0 - ring, a.x, a.y, a.z), vec4<f32>(a.w, b.x, b.y, b.z), b.w);
}

// One share by its light, 0..9.
fn share_of(shares: NineShares, light: i32) -> f32 {
    if light < 4 {
        return shares.first[light];
    }
    if light < 8 {
        return shares.second[light - 4];
    }
    return shares.third;
}

// Light from above and below on a surface of this normal.
fn sky_on(normal: vec3<f32>, sky: vec3<f32>, ground: vec3<f32>) -> vec3<f32> {
    return mix(ground, sky, 0.5 + 0.5 * normal.y);
}

// Highlight of a rough surface: GGX with Schlick's Fresnel and the visibility term of Karis 2013.
fn highlight(normal: vec3<f32>, to_eye: vec3<f32>, to_sun: vec3<f32>, roughness: f32) -> f32 {
    let half_way = normalize(to_eye + to_sun);
    let nh = max(dot(normal, half_way), 0.0);
    let nl = max(dot(normal, to_sun), 0.0);
    let nv = max(dot(normal, to_eye), 1e-3);
    let a = max(roughness * roughness, 0.03);
    let d = nh * nh * (a * a - 1.0) + 1.0;
    let k = 0.5 * a;
    let visible = 1.0 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k) * 4.0);
    let fresnel = 0.04 + 0.96 * pow(1.0 - max(dot(to_eye, half_way), 0.0), 5.0);
    return a * a / (PI * d * d) * visible * fresnel * nl;
}

struct Surface {
    albedo: vec3<f32>,
    normal: vec3<f32>,
    // Unit, from the middle of the crown outward.
    outward: vec3<f32>,
    roughness: f32,
    // Part of the sky that the surface sees, 0..1.
    open: f32,
    // Part of the sun that reaches it, 0..1.
    lit: f32,
    // How much light passes it, a factor; 0 for bark.
    translucency: f32,
}

// The default: sunlight and skylight, each with what stands in its way, and light that passes leaves.
fn light_product(s: Surface, frame: Frame, to_eye: vec3<f32>) -> vec3<f32> {
    let to_sun = frame.sun.xyz;
    let facing = dot(s.normal, to_sun);
    let through = s.translucency * max(-facing, 0.0) * vec3<f32>(1.15, 1.2, 0.5);
    let sun = frame.sun_light.rgb * s.lit;
    let sky = sky_on(s.normal, frame.sky_light.rgb, frame.ground_light.rgb) * s.open;
    let shine = highlight(s.normal, to_eye, to_sun, s.roughness);
    return s.albedo * (sun * (max(facing, 0.0) / PI + through / PI) + sky) + sun * shine;
}

// Candussi, Hoellerer and Candussi, section 2.1: the sum of four factors. Vertex light with the normals of a
// sphere, density, shadow map, and how far in front the occluder stands. They are weighted so that the sum
// cannot pass full light, which the paper leaves open.
fn light_four_factors(s: Surface, frame: Frame, occluder: f32) -> vec3<f32> {
    let vertex = max(dot(s.outward, frame.sun.xyz), 0.0);
    let sum = 0.35 * vertex + 0.25 * s.open + 0.25 * s.lit + 0.15 * occluder;
    let light = mix(frame.sky_light.rgb, frame.sun_light.rgb / PI, sum);
    return s.albedo * light * (0.25 + 0.75 * sum);
}

// The sky in a direction.
fn sky_colour(direction: vec3<f32>, frame: Frame) -> vec3<f32> {
    let up = saturate(direction.y);
    let base = mix(frame.horizon.rgb, frame.zenith.rgb, pow(up, 0.45));
    let toward = max(dot(direction, frame.sun.xyz), 0.0);
    let glow = 0.10 * pow(toward, 8.0) + 0.35 * pow(toward, 180.0);
    return base + frame.sun_light.rgb * glow * 0.25;
}

// How far the air hides what is this many metres away, 0..1.
fn haze_over(metres: f32, frame: Frame) -> f32 {
    let haze = 1.0 - exp(-metres / max(frame.horizon.w, 1e-3));
    return haze * haze;
}

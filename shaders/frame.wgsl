// What every shader of a frame reads. The structs mirror those of `src/render/uniforms.rs`, member by member.

const PI: f32 = 3.14159265359;

struct Frame {
    view_projection: mat4x4<f32>,
    inverse_view_projection: mat4x4<f32>,
    // World to the shadow map: x and y -1..1, z 0..1.
    light_projection: mat4x4<f32>,
    // Where the camera stands; w: 1 if it is a perspective one.
    eye: vec4<f32>,
    // Where it looks, unit; w: exposure, a factor on linear light.
    forward: vec4<f32>,
    // Toward the sun, unit; w: edge of a shadow map texel as a part of the map, 0 without a map.
    sun: vec4<f32>,
    // Linear colours. Sun: w: how dark baked shadows are, 0..1.
    sun_light: vec4<f32>,
    // Sky above: w: how far foliage normals bend to those of a round crown, 0..1.
    sky_light: vec4<f32>,
    // Light from the ground: w: how much light passes leaves, a factor.
    ground_light: vec4<f32>,
    // The picture's sky: w: unused.
    zenith: vec4<f32>,
    // And its horizon: w: distance at which the ground fades into it, metres.
    horizon: vec4<f32>,
    // Albedo of the ground: w: alpha of the background, 0..1.
    ground: vec4<f32>,
    // Wind: direction on the ground (x, z), speed in metres a second, gustiness 0..1.
    wind: vec4<f32>,
    // Time in seconds, samples of a pixel, length of a metre of depth bias, size of the aux texture.
    clock: vec4<f32>,
    // Width and height in pixels, and one over them.
    viewport: vec4<f32>,
    // Light mode, view mode, filter, flags.
    modes: vec4<u32>,
}

const LIGHT_PRODUCT: u32 = 0u;
const LIGHT_FOUR_FACTORS: u32 = 1u;

const VIEW_LIT: u32 = 0u;
const VIEW_LOD: u32 = 1u;
const VIEW_NORMALS: u32 = 2u;
const VIEW_ALBEDO: u32 = 3u;
const VIEW_OVERDRAW: u32 = 4u;
const VIEW_WIRE: u32 = 5u;
const VIEW_LEVELS: u32 = 6u;

// In the shadow map leaves are turned to face the sun (Candussi et al., section 2.1).
const FLAG_LEAVES_FACE_SUN: u32 = 1u;
// Air hides far trees.
const FLAG_AIR: u32 = 2u;

const FILTER_ALPHA: u32 = 1u;
const FILTER_BILINEAR: u32 = 2u;

// A number in 0..1 for each pixel, spread evenly among neighbours (Jimenez 2014, interleaved gradient noise).
fn pixel_noise(pixel: vec2<f32>) -> f32 {
    return fract(52.9829189 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// Turn about +Y by an angle given as its cosine and sine: from a tree's frame to the world's.
fn turned(v: vec3<f32>, turn: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(v.x * turn.x + v.z * turn.y, v.y, v.z * turn.x - v.x * turn.y);
}

// And back.
fn turned_back(v: vec3<f32>, turn: vec2<f32>) -> vec3<f32> {
    return turned(v, vec2<f32>(turn.x, -turn.y));
}

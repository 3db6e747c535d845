// Where the wind takes a vertex: functions only, no bindings, to be put before a shader that calls them.
//
// The same formula, names and constants as src/wind.rs, whose header tells of the paper (Candussi, Hollerer,
// Candussi 2005, section 2.2) and of the changes. A test holds the constants of the two against each other.
//
// Vertex data of a pack: `_WIND` (unorm8x4) goes to `sway`, `_WIND_LEAF` (snorm8x4) to `leaf`; `wind` of
// pack.json is WindRig. Names that begin with `wind_`, `Wind` or `WIND_` are this file's.

// Wind over a scene; 16 bytes.
struct Wind {
    // Whither it blows: x and z of a horizontal unit vector.
    direction: vec2<f32>,
    // Mean speed, metres a second.
    speed_m_s: f32,
    // 0 (steady) to 1 (gusty).
    gustiness: f32,
}

// How the attributes of one tree's meshes are to be read; 32 bytes.
struct WindRig {
    // By band: lean that a weight of 1 stands for at WIND_REFERENCE_SPEED_M_S, metres.
    amplitude_m: vec3<f32>,
    // Distance from its hinge that 1 stands for in a leaf's offset, metres.
    leaf_reach_m: f32,
    // By band: how often branches swing a second.
    frequency_hz: vec3<f32>,
    // Largest turn of leaves at WIND_REFERENCE_SPEED_M_S, radians.
    leaf_angle: f32,
}

const WIND_TAU: f32 = 6.2831855;
const WIND_REFERENCE_SPEED_M_S: f32 = 10.0;
const WIND_MOST_SPEED: f32 = 3.0;
const WIND_FRONT_M_S: f32 = 10.0;
const WIND_SCATTER_S: f32 = 7.0;
const WIND_GUST: f32 = 0.45;
const WIND_SWING: f32 = 0.35;
const WIND_ACROSS: f32 = 0.25;
const WIND_GUST_HZ: vec3<f32> = vec3<f32>(0.071, 0.113, 0.197);
const WIND_GUST_SHARE: vec3<f32> = vec3<f32>(0.5, 0.3, 0.2);
const WIND_SWING_RATIO: vec2<f32> = vec2<f32>(1.0, 1.37);
const WIND_ACROSS_RATIO: vec2<f32> = vec2<f32>(0.83, 1.19);
const WIND_SWING_SHARE: vec2<f32> = vec2<f32>(0.6, 0.4);
const WIND_ACROSS_LAG: f32 = 0.25;
const WIND_LEAF_HZ: vec2<f32> = vec2<f32>(1.7, 2.9);
const WIND_LEAF_SHARE: vec2<f32> = vec2<f32>(0.65, 0.35);
const WIND_LEAF_STEADY: f32 = 0.4;

// A sine of an angle in turns. The whole turns go first, so that late times do not cost precision.
fn wind_wave(turns: f32) -> f32 {
    return sin(WIND_TAU * fract(turns));
}

// Two waves of one phase, -1 to 1.
fn wind_pair(at: f32, ratio: vec2<f32>, share: vec2<f32>, phase: f32) -> f32 {
    return share.x * wind_wave(at * ratio.x + phase) + share.y * wind_wave(at * ratio.y + phase);
}

// Rise and fall of the wind, -1 to 1: the same for all vertices of a tree.
fn wind_gust(time_s: f32) -> f32 {
    return WIND_GUST_SHARE.x * wind_wave(WIND_GUST_HZ.x * time_s)
        + WIND_GUST_SHARE.y * wind_wave(WIND_GUST_HZ.y * time_s)
        + WIND_GUST_SHARE.z * wind_wave(WIND_GUST_HZ.z * time_s);
}

// How much later than at the origin gusts reach a tree whose foot is at `base`, seconds: subtract it from the
// time. `scatter` (0 to 1, one number a tree) keeps neighbours from swinging in step.
fn wind_delay_s(wind: Wind, base: vec3<f32>, scatter: f32) -> f32 {
    return dot(base.xz, wind.direction) / WIND_FRONT_M_S + scatter * WIND_SCATTER_S;
}

// The turn of a leaf about the axis of view; zero for what is no leaf.
fn wind_flutter(wind: Wind, rig: WindRig, time_s: f32, gust: f32, leaf: vec4<f32>, view_axis: vec3<f32>) -> vec3<f32> {
    let arm = leaf.xyz * rig.leaf_reach_m;
    let wave = wind_pair(time_s, WIND_LEAF_HZ, WIND_LEAF_SHARE, 0.5 * leaf.w);
    let liveliness = WIND_LEAF_STEADY + (1.0 - WIND_LEAF_STEADY) * wind.gustiness * (0.5 + 0.5 * gust);
    let speed = clamp(wind.speed_m_s / WIND_REFERENCE_SPEED_M_S, 0.0, WIND_MOST_SPEED);
    let turn = rig.leaf_angle * speed * liveliness * wave;
    return cross(view_axis, arm) * sin(turn) + (view_axis * dot(view_axis, arm) - arm) * (1.0 - cos(turn));
}

// Where the wind takes a vertex, metres from its place at rest, in the tree's frame (+Y up).
//
// `time_s`: the time at the tree, that is less wind_delay_s. `height_m`: how high the vertex stands above the
// tree's foot at rest. `view_axis`: unit vector along which the picture is taken (the light's for a shadow map).
// A tree that is scaled by s: give height_m unscaled, multiply the result by s. A tree that is turned: give
// `wind.direction` and `view_axis` in the tree's own frame.
fn wind_offset(wind: Wind, rig: WindRig, time_s: f32, height_m: f32, sway: vec4<f32>, leaf: vec4<f32>, view_axis: vec3<f32>) -> vec3<f32> {
    let speed = clamp(wind.speed_m_s / WIND_REFERENCE_SPEED_M_S, 0.0, WIND_MOST_SPEED);
    let strength = speed * sqrt(speed);
    let gust = wind_gust(time_s);
    let lean = sway.xyz * rig.amplitude_m;
    let at = rig.frequency_hz * time_s;
    let phase = vec3<f32>(0.0, sway.w, sway.w);
    let swing = vec3<f32>(
        wind_pair(at.x, WIND_SWING_RATIO, WIND_SWING_SHARE, phase.x),
        wind_pair(at.y, WIND_SWING_RATIO, WIND_SWING_SHARE, phase.y),
        wind_pair(at.z, WIND_SWING_RATIO, WIND_SWING_SHARE, phase.z),
    );
    let aside = vec3<f32>(
        wind_pair(at.x, WIND_ACROSS_RATIO, WIND_SWING_SHARE, phase.x + WIND_ACROSS_LAG),
        wind_pair(at.y, WIND_ACROSS_RATIO, WIND_SWING_SHARE, phase.y + WIND_ACROSS_LAG),
        wind_pair(at.z, WIND_ACROSS_RATIO, WIND_SWING_SHARE, phase.z + WIND_ACROSS_LAG),
    );
    let steady = vec3<f32>(1.0 + wind.gustiness * WIND_GUST * gust);
    let along = strength * dot(lean, steady + wind.gustiness * WIND_SWING * swing);
    let across = strength * wind.gustiness * WIND_ACROSS * dot(lean, aside);
    let away = sqrt(along * along + across * across);
    // A point at the end of a rod of this height, leaning so far, sinks by about so much.
    let sink = 0.5 * away * away / max(max(height_m, away), 0.0001);
    let d = wind.direction;
    let moved = vec3<f32>(d.x * along - d.y * across, -sink, d.y * along + d.x * across);
    return moved + wind_flutter(wind, rig, time_s, gust, leaf, view_axis);
}

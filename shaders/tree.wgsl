// Trees, drawn as instances of one LOD's mesh.

struct Model {
    // Middle of the crown and half of its edges, metres.
    centre: vec4<f32>,
    extent: vec4<f32>,
    // Corner of the light volume, and one over its edges.
    volume_origin: vec4<f32>,
    volume_scale: vec4<f32>,
    // Ground that each baked shadow covers: smallest x and z, largest x and z.
    shadow_rects: array<vec4<f32>, 9>,
    // How the sway of its vertices is to be read.
    rig: WindRig,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var depth_sampler: sampler;

@group(1) @binding(0) var<uniform> model: Model;
@group(1) @binding(1) var smooth_sampler: sampler;
// Part of the sky seen and of the first three of the nine lights; the next four; the last two.
@group(1) @binding(2) var volume_a: texture_3d<f32>;
@group(1) @binding(3) var volume_b: texture_3d<f32>;
@group(1) @binding(4) var volume_c: texture_3d<f32>;

@group(2) @binding(0) var albedo_map: texture_2d<f32>;
@group(2) @binding(1) var normal_map: texture_2d<f32>;
@group(2) @binding(2) var orm_map: texture_2d<f32>;
@group(2) @binding(3) var extra_map: texture_2d<f32>;
@group(2) @binding(4) var surface_sampler: sampler;

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) tangent: vec4<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) sway: vec4<f32>,
    @location(5) leaf: vec4<f32>,
    // Factor on the texture's colour.
    @location(10) tint: vec4<f32>,
    // The script's level that it belongs to, or `NO_LEVEL`.
    @location(11) level: u32,
    // The length that depth offsets of its capture are parts of, metres; 0 if it is of none.
    @location(12) relief: f32,
}

struct Instance {
    // Where the base stands, and the tree's size as a factor.
    @location(6) place: vec4<f32>,
    // Cosine and sine of its turn about +Y; its phase in the wind, 0..1; fade: above 0, the part of samples
    // it has; below 0, the part it has of those that a LOD fading in leaves.
    @location(7) turn: vec4<f32>,
    // Factor on its colours.
    @location(8) tint: vec4<f32>,
    // Its LOD; how far the shadow map shades it, 0..1: large quads would shade one another; how much of the light
    // trees around it take from its foot, 0..1.
    @location(9) marks: vec4<f32>,
}

struct Varyings {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) local: vec3<f32>,
    @location(2) normal: vec3<f32>,
    @location(3) tangent: vec4<f32>,
    // Within the part of the pixel that is covered: at the middle of the pixel, beside a slim card, there is
    // another part of the atlas.
    @location(4) @interpolate(perspective, centroid) uv: vec2<f32>,
    @location(5) @interpolate(flat) turn: vec4<f32>,
    // Factor on the colour, and the level: all corners of a triangle have the same.
    @location(6) tint: vec4<f32>,
    @location(7) @interpolate(flat) marks: vec4<f32>,
    // The same at the middle of the pixel, for its derivatives.
    @location(8) uv_middle: vec2<f32>,
    // Shares of the nine baked lights: one instance has one sun.
    @location(9) @interpolate(flat) first_shares: vec4<f32>,
    @location(10) @interpolate(flat) second_shares: vec4<f32>,
    @location(11) @interpolate(flat) third_share: f32,
    @location(12) relief: f32,
}

// What a pixel spans of the texture, along the picture and down it. Derivatives are taken where all pixels of a
// block come by, so that what is left out afterwards need not be lit.
struct Footprint {
    x: vec2<f32>,
    y: vec2<f32>,
}

fn footprint_of(uv: vec2<f32>) -> Footprint {
    return Footprint(dpdx(uv), dpdy(uv));
}

fn world_of(local: vec3<f32>, instance: Instance) -> vec3<f32> {
    return instance.place.xyz + turned(local * instance.place.w, instance.turn.xy);
}

// Part of a tree's sway that is drawn, 0..1: none where the farthest that it can lean is less than a third of a
// pixel, so that far trees cost no more in the wind than in a calm.
fn sway_seen(instance: Instance) -> f32 {
    let rows = transpose(frame.view_projection);
    let pixels_by_metre = 0.5 * frame.viewport.y * length(rows[1].xyz)
        / max(abs(dot(rows[3], vec4<f32>(instance.place.xyz, 1.0))), 1e-3);
    let speed = clamp(frame.wind.z / WIND_REFERENCE_SPEED_M_S, 0.0, WIND_MOST_SPEED);
    let lean = dot(model.rig.amplitude_m, vec3<f32>(1.5)) * speed * sqrt(speed) * instance.place.w;
    return smoothstep(0.3, 0.6, lean * pixels_by_metre);
}

// Where the wind takes a vertex, in the tree's own frame. `view_axis` is what leaves turn about.
//
// A calm is not asked for by itself: where uniforms alone decide that half of a vertex shader is not needed, a software
// driver compiles it again for each frame whose uniforms are others, which takes longer than all vertices.
fn swayed(vertex: Vertex, instance: Instance, view_axis: vec3<f32>) -> vec3<f32> {
    let seen = sway_seen(instance);
    if seen == 0.0 {
        return vertex.position;
    }
    let over_scene = Wind(frame.wind.xy, frame.wind.z, frame.wind.w);
    let time = frame.clock.x - wind_delay_s(over_scene, instance.place.xyz, instance.turn.z);
    let direction = turned_back(vec3<f32>(frame.wind.x, 0.0, frame.wind.y), instance.turn.xy).xz;
    let at_tree = Wind(direction, frame.wind.z, frame.wind.w);
    let axis = turned_back(view_axis, instance.turn.xy);
    let away = wind_offset(at_tree, model.rig, time, vertex.position.y, vertex.sway, vertex.leaf, axis);
    return vertex.position + away * seen;
}

@vertex
fn vs_tree(vertex: Vertex, instance: Instance) -> Varyings {
    return tree_drawn(vertex, instance);
}

fn tree_drawn(vertex: Vertex, instance: Instance) -> Varyings {
    var out: Varyings;
    out.local = swayed(vertex, instance, frame.forward.xyz);
    out.world = world_of(out.local, instance);
    out.clip = frame.view_projection * vec4<f32>(out.world, 1.0);
    out.normal = turned(vertex.normal, instance.turn.xy);
    out.tangent = vec4<f32>(turned(vertex.tangent.xyz, instance.turn.xy), vertex.tangent.w);
    out.uv = vertex.uv;
    out.uv_middle = vertex.uv;
    out.turn = instance.turn;
    out.tint = vec4<f32>(instance.tint.rgb * vertex.tint.rgb, f32(vertex.level));
    out.marks = instance.marks;
    let shares = nine_shares(turned_back(frame.sun.xyz, instance.turn.xy));
    out.first_shares = shares.first;
    out.second_shares = shares.second;
    out.third_share = shares.third;
    out.relief = vertex.relief;
    return out;
}

struct Covered {
    @location(0) colour: vec4<f32>,
    @builtin(sample_mask) samples: u32,
}

// The samples of a pixel that a surface of this alpha and fade has. As alpha to coverage, but which samples
// differs from pixel to pixel, and one LOD fades out on just those where the next one fades in.
fn samples_of(alpha: f32, fade: f32, pixel: vec2<f32>) -> u32 {
    let count = u32(frame.clock.y);
    let noise = pixel_noise(pixel);
    var mask = 0u;
    for (var i = 0u; i < count; i++) {
        let step = (f32(i) + noise) / f32(count);
        let other = fract(step * 7.0 + noise);
        let kept = select(other >= (1.0 + fade), (other < fade), (fade > 0.0));
        if alpha > step && kept {
            mask |= 1u << i;
        }
    }
    return mask;
}

// Colour and alpha of foliage. Samplers choose mips by the longer side of a pixel's footprint, and there slim
// leaves that are seen aslant, or whose card has far more texels along than across, wash out below the
// cutoff. So the footprint is narrowed here: to its area, and to the distance of samples, of which a pixel has
// four.
fn foliage_texel(uv: vec2<f32>, over: Footprint) -> vec4<f32> {
    let longer = max(max(dot(over.x, over.x), dot(over.y, over.y)), 1e-20);
    let area = max(abs(over.x.x * over.y.y - over.x.y * over.y.x), 1e-20);
    let narrowed = 0.7 * max(sqrt(area / longer), 0.25);
    return textureSampleGrad(albedo_map, surface_sampler, uv, over.x * narrowed, over.y * narrowed);
}

// Alpha that is steep about the cutoff whatever the distance (Golus 2017, anti-aliased alpha test), and a little
// high: leaves of a pixel's width have no straight edges, and would lose a twentieth of their area.
fn sharpened(alpha: f32) -> f32 {
    return saturate((alpha - 0.5) / max(fwidth(alpha), 1e-3) + 0.57);
}

// Large quads fade as they turn their edge to the eye, where they would be seen as lines.
fn edge_on(in: Varyings) -> f32 {
    let to_eye = mix(-frame.forward.xyz, normalize(frame.eye.xyz - in.world), frame.eye.w);
    let facing = abs(dot(normalize(in.normal), to_eye));
    return mix(smoothstep(0.04, 0.3, facing), 1.0, in.marks.y);
}

// The mapped normal; on the back of a card it is mirrored in the card's plane, so that light from above
// stays light from above.
fn mapped_normal(in: Varyings, over: Footprint, front: bool) -> vec3<f32> {
    let texel = textureSampleGrad(normal_map, surface_sampler, in.uv, over.x, over.y).xyz * 2.0 - 1.0;
    let n = normalize(in.normal);
    let t = normalize(in.tangent.xyz - n * dot(n, in.tangent.xyz));
    let b = cross(n, t) * in.tangent.w;
    let side = select(-1.0, 1.0, front);
    return normalize(t * texel.x + b * texel.y + n * (texel.z * side));
}

// Part of the sun that the shadow map lets through, and how far in front the occluder stands (x: lit, y:
// nearness), soft over four by four texels.
fn shadow_map_at(world: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let texel = frame.sun.w;
    if texel == 0.0 {
        return vec3<f32>(1.0, 1.0, 0.0);
    }
    let lifted = world + (normal * 0.5 + frame.sun.xyz) * frame.clock.z;
    let clip = frame.light_projection * vec4<f32>(lifted, 1.0);
    let uv = clip.xy * vec2<f32>(0.5, -0.5) + 0.5;
    let inside = all(uv > vec2<f32>(0.0)) && all(uv < vec2<f32>(1.0)) && clip.z > 0.0 && clip.z < 1.0;
    var lit = 0.0;
    for (var i = 0; i < 4; i++) {
        let step = vec2<f32>(f32(i & 1), f32(i >> 1u)) * 2.0 - 1.0;
        lit += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + step * texel * 0.75, clip.z);
    }
    let occluder = textureSampleLevel(shadow_map, depth_sampler, uv, 0);
    let behind = max(clip.z - occluder, 0.0);
    return vec3<f32>(select(1.0, lit * 0.25, inside), exp(-behind * 20.0), select(0.0, 1.0, inside));
}

// What the light volume holds at a point: part of the sky, part of the sun. No more than three of the nine lights
// have a share, so that textures of others need not be read.
fn volume_at(in: Varyings, surface: vec3<f32>) -> vec2<f32> {
    let at = (surface - model.volume_origin.xyz) * model.volume_scale.xyz;
    let a = textureSampleLevel(volume_a, smooth_sampler, at, 0.0);
    var lit = dot(in.first_shares.xyz, a.yzw);
    if any(vec4<f32>(in.first_shares.w, in.second_shares.xyz) != vec4<f32>(0.0)) {
        let b = textureSampleLevel(volume_b, smooth_sampler, at, 0.0);
        lit += in.first_shares.w * b.x + dot(in.second_shares.xyz, b.yzw);
    }
    if in.second_shares.w != 0.0 || in.third_share != 0.0 {
        let c = textureSampleLevel(volume_c, smooth_sampler, at, 0.0);
        lit += in.second_shares.w * c.x + in.third_share * c.y;
    }
    return vec2<f32>(a.x, lit);
}

// Where the surface was that a quad shows, in the tree's own frame: light there is not as it is in the middle of the
// crown, where the quad stands. The far side of a quad mirrors the near one.
fn surface_at(in: Varyings, depth: f32, front: bool) -> vec3<f32> {
    let toward = turned_back(normalize(in.normal), in.turn.xy) * select(-1.0, 1.0, front);
    return in.local + toward * ((depth * 255.0 - 128.0) / 127.5 * in.relief);
}

fn lit_colour(in: Varyings, over: Footprint, albedo: vec3<f32>, mapped: vec3<f32>, front: bool, foliage: f32) -> vec3<f32> {
    let orm = textureSampleGrad(orm_map, surface_sampler, in.uv, over.x, over.y).xyz;
    let extra = textureSampleGrad(extra_map, surface_sampler, in.uv, over.x, over.y).xyz;
    let surface = surface_at(in, extra.y, front);
    let outward = turned(normalize((surface - model.centre.xyz) / model.extent.xyz + vec3<f32>(0.0, 1e-4, 0.0)),
        in.turn.xy);
    let volume = volume_at(in, surface) * between_trees(in);
    var shadow = vec3<f32>(1.0, 1.0, 0.0);
    if in.marks.y > 0.0 || frame.modes.x == LIGHT_FOUR_FACTORS {
        shadow = shadow_map_at(in.world, normalize(in.normal));
    }
    var s: Surface;
    s.albedo = albedo * in.tint.rgb;
    s.normal = normalize(mix(mapped, outward, frame.sky_light.w * foliage));
    s.outward = outward;
    s.roughness = orm.y;
    s.open = volume.x * mix(1.0, orm.x, 0.6);
    s.lit = mix(volume.y, shadow.x, shadow.z * in.marks.y);
    s.translucency = extra.x * frame.ground_light.w * foliage;
    let to_eye = mix(-frame.forward.xyz, normalize(frame.eye.xyz - in.world), frame.eye.w);
    if frame.modes.x == LIGHT_FOUR_FACTORS {
        return hazy(light_four_factors(s, frame, shadow.y), in);
    }
    return hazy(light_product(s, frame, to_eye), in);
}

// Part of the sky and of the sun that the trees around leave to one, from its foot to its top.
fn between_trees(in: Varyings) -> f32 {
    let below = saturate(1.0 - in.local.y / (model.centre.y + model.extent.y));
    return 1.0 - in.marks.z * below * (2.0 - below);
}

// Air between the eye and a tree of a forest, as over the ground. A tree by itself is near.
fn hazy(colour: vec3<f32>, in: Varyings) -> vec3<f32> {
    if (frame.modes.w & FLAG_AIR) == 0u {
        return colour;
    }
    let way = in.world - frame.eye.xyz;
    let level = normalize(vec3<f32>(way.x, 0.0, way.z) + vec3<f32>(0.0, 1e-5, 0.0));
    return mix(colour, sky_colour(level, frame), haze_over(length(way), frame));
}

// A colour for each LOD, from the finest on.
fn lod_colour(lod: f32) -> vec3<f32> {
    let hue = fract(0.36 + lod * 0.17) * 6.0;
    return 0.15 + 0.6 * saturate(abs(vec3<f32>(hue - 3.0, hue - 2.0, hue - 4.0)) * vec3<f32>(1.0, -1.0, -1.0)
        + vec3<f32>(-1.0, 2.0, 2.0));
}

const NO_LEVEL: u32 = 255u;

// As in `src/render/scene.rs`, linear.
const LEVEL_COLOURS = array<vec3<f32>, 8>(
    vec3<f32>(0.6724, 0.2086, 0.0252),
    vec3<f32>(0.0931, 0.3813, 0.8070),
    vec3<f32>(0.8714, 0.6867, 0.0723),
    vec3<f32>(0.3419, 0.0887, 0.5520),
    vec3<f32>(0.1070, 0.5149, 0.1070),
    vec3<f32>(0.6867, 0.0648, 0.0762),
    vec3<f32>(0.0513, 0.5520, 0.4910),
    vec3<f32>(0.8550, 0.2874, 0.5149),
);

// A colour for each level, and grey for what is of none.
fn level_colour(level: u32) -> vec3<f32> {
    if level == NO_LEVEL {
        return vec3<f32>(0.25);
    }
    var colours = LEVEL_COLOURS;
    return colours[level % 8u];
}

fn viewed(in: Varyings, over: Footprint, albedo: vec3<f32>, front: bool, foliage: f32) -> vec3<f32> {
    let mapped = mapped_normal(in, over, front);
    let lit = lit_colour(in, over, albedo, mapped, front, foliage);
    switch frame.modes.y {
        case VIEW_LOD: {
            let grey = dot(lit, vec3<f32>(0.2126, 0.7152, 0.0722));
            return lod_colour(in.marks.x) * (0.35 + 2.5 * grey);
        }
        case VIEW_LEVELS: {
            // By the light that is there, not by how light the texture is: nothing is brighter than its colour.
            let grey = vec3<f32>(0.2126, 0.7152, 0.0722);
            let bright = dot(lit, grey) / max(dot(albedo * in.tint.rgb, grey), 0.02);
            return level_colour(u32(in.tint.w + 0.5)) * (0.4 + 0.6 * min(bright, 1.0));
        }
        case VIEW_NORMALS: {
            return (mapped * 0.5 + 0.5) * 0.8;
        }
        case VIEW_ALBEDO: {
            return albedo;
        }
        default: {
            return lit;
        }
    }
}

@fragment
fn fs_bark(in: Varyings, @builtin(front_facing) front: bool) -> Covered {
    let albedo = textureSample(albedo_map, surface_sampler, in.uv);
    let colour = viewed(in, footprint_of(in.uv_middle), albedo.rgb, front, 0.0);
    let samples = samples_of(1.0, in.turn.w, in.clip.xy);
    // Roots stay below the ground.
    if samples == 0u || in.world.y < 0.0 {
        discard;
    }
    return Covered(vec4<f32>(colour, 1.0), samples);
}

@fragment
fn fs_foliage(in: Varyings, @builtin(front_facing) front: bool) -> Covered {
    let over = footprint_of(in.uv_middle);
    let albedo = foliage_texel(in.uv, over);
    let alpha = sharpened(albedo.a) * edge_on(in);
    let samples = samples_of(alpha, in.turn.w, in.clip.xy);
    var colour = vec3<f32>(0.0);
    if samples == 0u || in.world.y < 0.0 {
        discard;
    } else {
        colour = viewed(in, over, albedo.rgb, front, 1.0);
    }
    return Covered(vec4<f32>(colour, 1.0), samples);
}

// One layer of whatever covers the pixel: added up, they are the overdraw.
@fragment
fn fs_layer(in: Varyings) -> @location(0) vec4<f32> {
    return vec4<f32>(0.06, 0.022, 0.008, 1.0);
}

// Edges of triangles, in the colour of their LOD.
@fragment
fn fs_wire(in: Varyings) -> @location(0) vec4<f32> {
    return vec4<f32>(lod_colour(in.marks.x), 1.0);
}

struct Cast {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

// A leaf turned about its hinge until it faces the light; what has no hinge stays as it is.
fn facing_sun(vertex: Vertex, local: vec3<f32>, instance: Instance) -> vec3<f32> {
    let arm = vertex.leaf.xyz * model.rig.leaf_reach_m;
    let to_sun = turned_back(frame.sun.xyz, instance.turn.xy);
    let toward = to_sun * select(-1.0, 1.0, dot(vertex.normal, to_sun) >= 0.0);
    // The shortest turn from the normal to the light or away from it.
    let axis = cross(vertex.normal, toward);
    let cosine = dot(vertex.normal, toward);
    let turned_arm = arm * cosine + cross(axis, arm) + axis * dot(axis, arm) / (1.0 + cosine);
    return local - arm + turned_arm;
}

// Depth from the sun.
@vertex
fn vs_cast(vertex: Vertex, instance: Instance) -> Cast {
    return tree_cast(vertex, instance);
}

fn tree_cast(vertex: Vertex, instance: Instance) -> Cast {
    var out: Cast;
    var local = swayed(vertex, instance, -frame.sun.xyz);
    if (frame.modes.w & FLAG_LEAVES_FACE_SUN) != 0u {
        local = facing_sun(vertex, local, instance);
    }
    out.clip = frame.light_projection * vec4<f32>(world_of(local, instance), 1.0);
    out.uv = vertex.uv;
    return out;
}

@fragment
fn fs_cast(in: Cast) {
    if textureSample(albedo_map, surface_sampler, in.uv).a < 0.5 {
        discard;
    }
}

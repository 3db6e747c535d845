// Soft ground shadows: hard shadows as bits, then summed. `src/shadow/raster.rs` and `cpu.rs` are the processor's
// twins, rule by rule; only rounding may differ.
//
// A thread draws some triangles into the masks of some samples. Its neighbours draw the same ones for other samples,
// nearly at the same places: they walk through the same rows together, and none waits for another's marks. What a
// triangle is made of is read once for all samples of a thread.

// Threads of a workgroup that marks; `src/gpu_bake/shadows.rs` sets it.
override THREADS: u32 = 64u;

struct Job {
    // Texels along the edge of a map, and words of 32 of them along a row.
    size: u32,
    row: u32,
    // Solid triangles and alpha-tested ones.
    bark: u32,
    leaves: u32,
    // Samples of this batch; the first one among all.
    samples: u32,
    first: u32,
    // Samples of a light.
    a_light: u32,
    // Workgroups that share the triangles.
    groups: u32,
    // The coverage's texels across and down, and its number of mips.
    coverage: vec2<u32>,
    mips: u32,
    // Samples into whose masks a thread draws: they lie as far apart as a workgroup has threads.
    masks: u32,
}

// The parallel projection of one sample's light, and what it has in common with the light's other samples.
struct Projection {
    // Where the world's origin falls, texels.
    origin: vec2<f32>,
    // Texels that a shadow's place moves back for a metre of height.
    lean: vec2<f32>,
    // Texels for a metre along X and Z.
    a_metre: vec2<f32>,
    // Stray of foliage along two directions, texels for a metre of height.
    along: vec2<f32>,
    across: vec2<f32>,
    // Its part of the sum; its number among its light's samples.
    share: u32,
    number: u32,
}

// Those of a batch: every adapter's uniforms hold them.
struct Batch {
    samples: array<Projection, 320>,
}

struct Leaf {
    corners: array<u32, 3>,
    uv: array<array<f32, 2>, 3>,
    uv_area: f32,
    last_level: i32,
    key: u32,
}

@group(0) @binding(0) var<uniform> job: Job;
@group(0) @binding(1) var<uniform> batch: Batch;
@group(0) @binding(2) var<storage, read> points: array<f32>;
@group(0) @binding(3) var<storage, read> bark: array<u32>;
@group(0) @binding(4) var<storage, read> leaves: array<Leaf>;
// All mips of the coverage, four texels a word: from the second on in a column beside the first.
@group(0) @binding(5) var coverage: texture_storage_2d<r32uint, read>;
// One bit a texel of each of the batch's samples.
@group(0) @binding(6) var<storage, read_write> masks: array<atomic<u32>>;

const GOLDEN: u32 = 0x9e3779b9u;
const SPREAD: u32 = 0xc13fa9a9u;
const STEP: u32 = 0xc13f91e1u;

fn whole(x: f32) -> u32 {
    return u32(max(x, 0.0));
}

// The first texel whose centre lies beyond x.
fn first_centre(x: f32) -> u32 {
    return whole(x + 0.5);
}

fn point(index: u32) -> vec3<f32> {
    return vec3<f32>(points[index * 3u], points[index * 3u + 1u], points[index * 3u + 2u]);
}

// Where a point's shadow falls in the map of a sample.
fn shadow(sample: Projection, at: vec3<f32>) -> vec2<f32> {
    return sample.origin + at.xz * sample.a_metre - at.y * sample.lean;
}

// How far a piece of foliage strays in a sample; samples come in pairs of opposite ones.
fn stray(sample: Projection, key: u32) -> vec2<f32> {
    let bits = key + (sample.number + 1u) / 2u * STEP;
    let along = (f32(bits & 0xffffu) + 0.5) / 65536.0 - 0.5;
    let across = (f32(bits >> 16u) + 0.5) / 65536.0 - 0.5;
    let stray = sample.along * along + sample.across * across;
    return select(-stray, stray, (sample.number & 1u) == 0u);
}

fn floor_log2(x: f32) -> i32 {
    return i32((bitcast<u32>(x) >> 23u) & 0xffu) - 127;
}

struct Edge {
    start: vec2<f32>,
    slope: f32,
}

fn edge(start: vec2<f32>, end: vec2<f32>) -> Edge {
    return Edge(start, (end.x - start.x) / (end.y - start.y));
}

fn at_row(edge: Edge, y: f32) -> f32 {
    return edge.start.x + (y - edge.start.y) * edge.slope;
}

// How the texture lies under a triangle.
struct Cut {
    // Place in texels of the mip at the first corner, change to the right, and down.
    origin: vec2<f32>,
    right: vec2<f32>,
    down: vec2<f32>,
    // The mip: where it lies, its last column and row.
    corner: vec2<u32>,
    last: vec2<u32>,
    threshold: u32,
    solid: bool,
}

fn covered(cut: Cut, at: vec2<f32>) -> bool {
    let place = cut.corner + min(vec2<u32>(max(at, vec2<f32>(0.0))), cut.last);
    let four = textureLoad(coverage, vec2<u32>(place.x / 4u, place.y)).r;
    return ((four >> (place.x % 4u * 8u)) & 0xffu) >= cut.threshold;
}

// Marks the covered texels of one row's span.
fn span(cut: Cut, corner: vec2<f32>, row: u32, y: u32, x0: u32, x1: u32) {
    let start = cut.origin - corner.x * cut.right + (f32(y) + 0.5 - corner.y) * cut.down;
    for (var word = x0 / 32u; word * 32u < x1; word++) {
        let first = max(x0, word * 32u) % 32u;
        let last = (min(x1, word * 32u + 32u) - 1u) % 32u;
        var bits = 0u;
        if cut.solid {
            bits = (0xffffffffu << first) & (0xffffffffu >> (31u - last));
        } else {
            for (var bit = first; bit <= last; bit++) {
                let place = start + (f32(word * 32u + bit) + 0.5) * cut.right;
                bits |= u32(covered(cut, place)) << bit;
            }
        }
        if bits != 0u {
            atomicOr(&masks[row + word], bits);
        }
    }
}

// Draws a triangle: rows between the edges, each edge from its upper end.
fn draw(cut: Cut, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, mask: u32) {
    var top = a;
    var middle = b;
    var bottom = c;
    if middle.y < top.y {
        let swap = top;
        top = middle;
        middle = swap;
    }
    if bottom.y < middle.y {
        let swap = middle;
        middle = bottom;
        bottom = swap;
        if middle.y < top.y {
            let swap = top;
            top = middle;
            middle = swap;
        }
    }
    let first = first_centre(top.y);
    let turn = min(first_centre(middle.y), job.size);
    let end = min(first_centre(bottom.y), job.size);
    let long = edge(top, bottom);
    let upper = edge(top, middle);
    let lower = edge(middle, bottom);
    for (var y = first; y < end; y++) {
        let centre = f32(y) + 0.5;
        let p = at_row(long, centre);
        var q = 0.0;
        if y < turn {
            q = at_row(upper, centre);
        } else {
            q = at_row(lower, centre);
        }
        let x0 = first_centre(min(p, q));
        let x1 = min(first_centre(max(p, q)), job.size);
        if x0 < x1 {
            span(cut, a, mask + y * job.row, y, x0, x1);
        }
    }
}

fn draw_bark(triangle: u32, first: u32) {
    let at_a = point(bark[triangle * 3u]);
    let at_b = point(bark[triangle * 3u + 1u]);
    let at_c = point(bark[triangle * 3u + 2u]);
    var cut: Cut;
    cut.solid = true;
    for (var i = first; i < min(first + job.masks * THREADS, job.samples); i += THREADS) {
        let sample = batch.samples[i];
        let mask = i * job.row * job.size;
        draw(cut, shadow(sample, at_a), shadow(sample, at_b), shadow(sample, at_c), mask);
    }
}

fn draw_leaf(triangle: u32, first: u32) {
    let leaf = leaves[triangle];
    let at_a = point(leaf.corners[0]);
    let at_b = point(leaf.corners[1]);
    let at_c = point(leaf.corners[2]);
    for (var i = first; i < min(first + job.masks * THREADS, job.samples); i += THREADS) {
        let sample = batch.samples[i];
        let away = stray(sample, leaf.key);
        let a = shadow(sample, at_a) - at_a.y * away;
        let b = shadow(sample, at_b) - at_b.y * away;
        let c = shadow(sample, at_c) - at_c.y * away;
        let to_b = b - a;
        let to_c = c - a;
        let area = to_b.x * to_c.y - to_c.x * to_b.y;
        let index = clamp(floor_log2(leaf.uv_area / abs(area)) >> 1u, 0, leaf.last_level);
        let level = min(u32(index), job.mips - 1u);
        let full = job.coverage;
        let size = full >> vec2<u32>(level);
        let scale = vec2<f32>(size) / vec2<f32>(full);
        let beside = vec2<u32>(full.x, full.y - (full.y >> (max(level, 1u) - 1u)));
        var cut: Cut;
        cut.solid = false;
        cut.corner = select(beside, vec2<u32>(0u), level == 0u);
        cut.last = size - 1u;
        cut.threshold = max((sample.number * GOLDEN + (triangle + 1u) * SPREAD) >> 24u, 1u);
        let uv_a = vec2<f32>(leaf.uv[0][0], leaf.uv[0][1]) * scale;
        let uv_b = vec2<f32>(leaf.uv[1][0], leaf.uv[1][1]) * scale - uv_a;
        let uv_c = vec2<f32>(leaf.uv[2][0], leaf.uv[2][1]) * scale - uv_a;
        cut.origin = uv_a;
        cut.right = (uv_b * to_c.y - uv_c * to_b.y) / area;
        cut.down = (uv_c * to_b.x - uv_b * to_c.x) / area;
        draw(cut, a, b, c, i * job.row * job.size);
    }
}

@compute @workgroup_size(THREADS)
fn cs_hard(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let sample = group.y * (job.masks * THREADS) + local.x;
    if sample >= job.samples {
        return;
    }
    // Each takes some of all kinds and places, so that none is done long before the others.
    var t = group.x;
    for (; t < job.bark; t += job.groups) {
        draw_bark(t, sample);
    }
    for (; t < job.bark + job.leaves; t += job.groups) {
        draw_leaf(t - job.bark, sample);
    }
}

// The masks again, now that nothing is marked any more.
@group(0) @binding(7) var<storage, read> marked: array<u32>;
// Two texels a word, row by row, as many as the masks have bits, light after light.
@group(0) @binding(8) var<storage, read_write> sums: array<u32>;

// The samples of the batch that belong to a light.
fn samples_of(light: u32) -> vec2<u32> {
    let first = max(light * job.a_light, job.first);
    let end = min((light + 1u) * job.a_light, job.first + job.samples);
    return vec2<u32>(first, max(first, end)) - job.first;
}

// Eight bits as eight numbers of sixteen bits.
fn spread(bits: u32) -> vec4<u32> {
    let pairs = vec4<u32>(bits) >> vec4<u32>(0u, 2u, 4u, 6u);
    return (pairs & vec4<u32>(1u)) | ((pairs & vec4<u32>(2u)) << vec4<u32>(15u));
}

// Sixteen texels, half a word of the masks.
@compute @workgroup_size(64)
fn cs_sum(@builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
) {
    let words = job.row * job.size;
    let half = (group.y * groups.x + group.x) * 64u + local.x;
    if half >= words * 2u {
        return;
    }
    let range = samples_of(group.z);
    var left = vec4<u32>(0u);
    var right = vec4<u32>(0u);
    for (var i = range.x; i < range.y; i++) {
        let bits = marked[i * words + half / 2u] >> (half % 2u * 16u);
        let share = batch.samples[i].share;
        left += spread(bits) * share;
        right += spread(bits >> 8u) * share;
    }
    let first = (group.z * words * 2u + half) * 8u;
    if any((left | right) != vec4<u32>(0u)) {
        for (var i = 0u; i < 4u; i++) {
            sums[first + i] += left[i];
            sums[first + 4u + i] += right[i];
        }
    }
}

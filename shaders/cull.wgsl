// Which trees of a forest are seen, by which LOD, and in what order they are drawn. Three passes over the trees:
// count them by bin and group, add the counts up, write each tree's number to its place. No place depends on
// which thread comes first, so one scene always gives one picture. `src/render/forest/twin.rs` is the same on a
// processor, number by number; the structs mirror those of `src/render/forest/plan.rs`.
//
// A bin is a list of trees that one draw call draws: one for each LOD of each model, one for each LOD that casts
// into the shadow map, one for the ground shadows of each model.

// Threads of a group. Bins must not be more.
const GROUP: u32 = 256u;
const MASK_WORDS: u32 = 8u;
const NO_BIN: u32 = 255u;
// A fade that is over.
const FADED: u32 = 255u;

struct Cull {
    // Inside is where dot(plane.xyz, p) + plane.w >= 0: left, right, below, above, near.
    planes: array<vec4<f32>, 5>,
    // Where the camera stands; w: its height above the ground, squared.
    eye: vec4<f32>,
    // The picture's height at a distance d, squared, is x * d * d + y. z: by how much larger than it is a tree is
    // taken to be before it may become coarser, squared; w: largest part by which trees differ in that.
    sight: vec4<f32>,
    // Middle of the shadow map on the ground (x, z), and half its edge, 0 without one. w: a pixel's part of the
    // picture's height, squared, for ground shadows; 0 for none of those.
    shade: vec4<f32>,
    // Trees, groups, bins; by how much a fade goes on in this frame, of 255.
    counts: vec4<u32>,
    // LOD that all trees have, plus 1; 0 to choose. By how much ground shadows are longer than baked, a float.
    orders: vec4<u32>,
}

struct Kind {
    // Height of the bounding sphere's middle, its radius, height of the tree, radius of its ground shadow; metres.
    shape: vec4<f32>,
    // First bin of its LODs, number of LODs, bin of its ground shadow, a bit for each LOD that casts.
    bins: vec4<u32>,
    // First bin of those that cast.
    casts: vec4<u32>,
    // One over the square of the part of the picture's height up to which each LOD may be shown.
    switches: array<vec4<f32>, 4>,
}

struct Planted {
    place: vec3<f32>,
    size: f32,
    // Cosine and sine of its turn, snorm; tint and phase, unorm.
    turn: u32,
    look: u32,
    kind: u32,
    crowded: f32,
}

@group(0) @binding(0) var<uniform> cull: Cull;
@group(0) @binding(1) var<uniform> kinds: array<Kind, 32>;
@group(0) @binding(2) var<storage, read> trees: array<Planted>;
// For each tree: its LOD plus 1 or 0 if it was not seen, the LOD it had before, how far it faded into the new one.
@group(0) @binding(3) var<storage, read_write> states: array<u32>;
// For each tree the bins that it is in: two LODs, one that casts, a ground shadow.
@group(0) @binding(4) var<storage, read_write> choices: array<u32>;
// For each bin, trees of each group; then trees of all groups before.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// Trees by bin: 23 bits of number, 9 of fade.
@group(0) @binding(6) var<storage, read_write> list: array<u32>;
// For each bin, trees in it; after all of those, where each begins in the list.
@group(0) @binding(7) var<storage, read_write> bins: array<u32>;
// For each bin, arguments of four draw calls of five numbers; all but the number of instances stand in it already.
@group(0) @binding(8) var<storage, read_write> draws: array<u32>;

// A number in 0..1 for each tree (Jarzynski and Olano 2020, pcg).
fn own_number(tree: u32) -> f32 {
    let state = tree * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

// The coarsest LOD that may be shown where a tree's height, squared, stands against the picture's.
fn coarsest(kind: u32, tree: f32, picture: f32) -> u32 {
    var lod = 0u;
    for (var i = 1u; i < kinds[kind].bins.y; i++) {
        if tree * kinds[kind].switches[i >> 2u][i & 3u] <= picture {
            lod = i;
        }
    }
    return lod;
}

fn is_inside(p: vec3<f32>, radius: f32) -> bool {
    for (var i = 0; i < 5; i++) {
        let plane = cull.planes[i];
        if plane.x * p.x + plane.y * p.y + plane.z * p.z + plane.w < -radius {
            return false;
        }
    }
    return true;
}

// The state of a tree that is seen, from that of the frame before.
fn next_state(state: u32, tree: u32, kind: u32, height: f32, away: f32) -> u32 {
    if cull.orders.x > 0u {
        return min(cull.orders.x, kinds[kind].bins.y) | (FADED << 16u);
    }
    let own = height * (1.0 + cull.sight.w * own_number(tree));
    let picture = cull.sight.x * away + cull.sight.y;
    let finest = coarsest(kind, own * own, picture);
    if (state & 255u) == 0u {
        return (finest + 1u) | (FADED << 16u);
    }
    let now = (state & 255u) - 1u;
    let fade = min((state >> 16u) + cull.counts.w, FADED);
    if (state >> 16u) < FADED && fade < FADED {
        return (state & 0xffffu) | (fade << 16u);
    }
    let margin = coarsest(kind, own * own * cull.sight.z, picture);
    // Finer at once where it must be, coarser only with some room.
    let next = select(max(now, margin), finest, now > finest);
    if next == now {
        return (now + 1u) | (FADED << 16u);
    }
    let begun = min(cull.counts.w, FADED);
    return (next + 1u) | (now << 8u) | (begun << 16u);
}

fn choice_of(tree: u32) -> u32 {
    let planted = trees[tree];
    let kind = planted.kind;
    let shape = kinds[kind].shape * planted.size;
    let middle = planted.place + vec3<f32>(0.0, shape.x, 0.0);
    let to_eye = middle - cull.eye.xyz;
    let away = to_eye.x * to_eye.x + to_eye.y * to_eye.y + to_eye.z * to_eye.z;
    let seen = is_inside(middle, shape.y);
    var chosen = vec4<u32>(NO_BIN);
    let across = abs(middle.xz - cull.shade.xy);
    let casts = max(across.x, across.y) <= cull.shade.z + shape.y && cull.shade.z > 0.0;
    var state = 0u;
    if seen || casts {
        state = next_state(states[tree], tree, kind, shape.z, away);
    }
    let lod = (state & 255u) - 1u;
    if seen {
        chosen.x = kinds[kind].bins.x + lod;
        if (state >> 16u) < FADED {
            chosen.y = kinds[kind].bins.x + ((state >> 8u) & 255u);
        }
    }
    if casts && (kinds[kind].bins.w >> lod & 1u) == 1u {
        chosen.z = kinds[kind].casts.x + countOneBits(kinds[kind].bins.w & ((1u << lod) - 1u));
    }
    // A ground shadow is seen at a slant: its height in the picture falls with the square of the distance.
    let reach = shape.w * bitcast<f32>(cull.orders.y);
    let flat = reach * reach * cull.eye.w;
    let ground = cull.sight.x * away + cull.sight.y;
    if is_inside(planted.place, reach) && flat >= cull.shade.w * ground * away && cull.shade.w > 0.0 {
        chosen.w = kinds[kind].bins.z;
    }
    states[tree] = state;
    return chosen.x | (chosen.y << 8u) | (chosen.z << 16u) | (chosen.w << 24u);
}

var<workgroup> tallies: array<atomic<u32>, GROUP>;

// First pass: what becomes of each tree, and how many of a group are in each bin.
@compute @workgroup_size(GROUP)
fn choose(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    atomicStore(&tallies[thread], 0u);
    workgroupBarrier();
    if id.x < cull.counts.x {
        let choice = choice_of(id.x);
        choices[id.x] = choice;
        for (var i = 0u; i < 4u; i++) {
            let bin = (choice >> (i * 8u)) & 255u;
            if bin != NO_BIN {
                atomicAdd(&tallies[bin], 1u);
            }
        }
    }
    workgroupBarrier();
    if thread < cull.counts.z {
        counts[thread * cull.counts.y + group.x] = atomicLoad(&tallies[thread]);
    }
}

var<workgroup> sums: array<u32, GROUP>;

// The sum of this thread's number and those of all threads before it.
fn sum_up_to(thread: u32, value: u32) -> u32 {
    sums[thread] = value;
    workgroupBarrier();
    for (var step = 1u; step < GROUP; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = sums[thread - step];
        }
        workgroupBarrier();
        sums[thread] += before;
        workgroupBarrier();
    }
    return sums[thread];
}

// Second pass, a group for each bin: trees of all groups before, and of all.
@compute @workgroup_size(GROUP)
fn add_up(
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) bin: vec3<u32>,
) {
    let first = bin.x * cull.counts.y;
    var before = 0u;
    for (var start = 0u; start < cull.counts.y; start += GROUP) {
        let at = start + thread;
        var own = 0u;
        if at < cull.counts.y {
            own = counts[first + at];
        }
        let sum = sum_up_to(thread, own);
        if at < cull.counts.y {
            counts[first + at] = before + sum - own;
        }
        before += sums[GROUP - 1u];
        workgroupBarrier();
    }
    if thread == 0u {
        bins[bin.x] = before;
    }
}

// Third pass, one group: where each bin begins, and the draw calls.
@compute @workgroup_size(GROUP)
fn lay_out(@builtin(local_invocation_index) thread: u32) {
    var own = 0u;
    if thread < cull.counts.z {
        own = bins[thread];
    }
    let end = sum_up_to(thread, own);
    if thread < cull.counts.z {
        bins[cull.counts.z + thread] = end - own;
        for (var i = 0u; i < 4u; i++) {
            draws[thread * 20u + i * 5u + 1u] = own;
        }
    }
}

// For each bin a bit for each thread of the group.
var<workgroup> masks: array<atomic<u32>, 2048>;

// Fourth pass: each tree to its places.
@compute @workgroup_size(GROUP)
fn scatter(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
    @builtin(workgroup_id) group: vec3<u32>,
) {
    for (var i = thread; i < cull.counts.z * MASK_WORDS; i += GROUP) {
        atomicStore(&masks[i], 0u);
    }
    workgroupBarrier();
    let word = thread / 32u;
    let bit = 1u << (thread % 32u);
    var choice = 0xffffffffu;
    if id.x < cull.counts.x {
        choice = choices[id.x];
        for (var i = 0u; i < 4u; i++) {
            let bin = (choice >> (i * 8u)) & 255u;
            if bin != NO_BIN {
                atomicOr(&masks[bin * MASK_WORDS + word], bit);
            }
        }
    }
    workgroupBarrier();
    if choice == 0xffffffffu {
        return;
    }
    let fade = states[id.x] >> 16u;
    for (var i = 0u; i < 4u; i++) {
        let bin = (choice >> (i * 8u)) & 255u;
        if bin == NO_BIN {
            continue;
        }
        var rank = countOneBits(atomicLoad(&masks[bin * MASK_WORDS + word]) & (bit - 1u));
        for (var w = 0u; w < word; w++) {
            rank += countOneBits(atomicLoad(&masks[bin * MASK_WORDS + w]));
        }
        let at = bins[cull.counts.z + bin] + counts[bin * cull.counts.y + group.x] + rank;
        // A LOD fading out has the complement of the one fading in.
        let code = select(select(511u, 256u + fade, i == 0u), fade, i == 1u);
        list[at] = id.x | (code << 23u);
    }
}

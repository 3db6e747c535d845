// Trees of a forest, drawn by bins: the instance's number leads through the list of its bin to the tree's record.

struct Bin {
    // Number of the bin, its LOD, and how far the shadow map shades that, 0..1.
    index: u32,
    lod: f32,
    crisp: f32,
    spare: f32,
}

// As in `cull.wgsl`, which says what each member means.
struct Planted {
    place: vec3<f32>,
    size: f32,
    turn: u32,
    look: u32,
    kind: u32,
    crowded: f32,
}

struct Stand {
    // Middle of the shadow map on the ground (x, z), half its edge; bins of the forest, a float.
    shade: vec4<f32>,
}

@group(3) @binding(0) var<uniform> bin: Bin;
@group(3) @binding(1) var<uniform> stand: Stand;
@group(3) @binding(2) var<storage, read> planted: array<Planted>;
@group(3) @binding(3) var<storage, read> list: array<u32>;
// For each bin, trees in it; after all of those, where each begins in the list.
@group(3) @binding(4) var<storage, read> bins: array<u32>;

fn instance_of(index: u32) -> Instance {
    let entry = list[bins[u32(stand.shade.w) + bin.index] + index];
    let tree = planted[entry & 0x7fffffu];
    let code = f32(entry >> 23u);
    let look = unpack4x8unorm(tree.look);
    // The shadow map ends somewhere: trees near its edge are shaded less and less by it.
    let away = length(tree.place.xz - stand.shade.xy) / max(stand.shade.z, 1e-3);
    var out: Instance;
    out.place = vec4<f32>(tree.place, tree.size);
    out.turn = vec4<f32>(unpack2x16snorm(tree.turn), look.w, select(code / 255.0 - 1.0, (code - 256.0) / 255.0, code > 255.5));
    out.tint = vec4<f32>(look.rgb * (255.0 / 128.0), 1.0);
    out.marks = vec4<f32>(bin.lod, bin.crisp * (1.0 - smoothstep(0.6, 0.95, away)), tree.crowded, 0.0);
    return out;
}

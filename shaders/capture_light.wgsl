// How much light from all around reaches each cell of the grids that darken the inside of crowns.
// `src/capture/occlusion.rs` is the processor's twin, and says why.

// Optical depth per metre of all grids, side by side.
@group(0) @binding(2) var density: texture_2d<f32>;

const DIAGONAL: f32 = 0.57735027;
const DIRECTIONS: u32 = 14u;

// Six axes and eight diagonals.
fn direction(index: u32) -> vec3<f32> {
    if index < 6u {
        let axis = index / 2u;
        let sign = 1.0 - 2.0 * f32(index & 1u);
        return vec3<f32>(vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u)) * sign;
    }
    let corner = vec3<u32>(index - 6u, (index - 6u) >> 1u, (index - 6u) >> 2u) & vec3<u32>(1u);
    return (vec3<f32>(corner) * 2.0 - 1.0) * DIAGONAL;
}

// The part of light that comes through; a cell does not shade itself.
fn transmittance(middle: vec3<f32>, direction: vec3<f32>) -> f32 {
    let size = vec3<f32>(shot.size);
    var depth = 0.0;
    var at = middle + direction * 1.2;
    while all(at >= vec3<f32>(0.0)) && all(at < size) && depth <= 6.0 {
        let cell = vec3<u32>(at);
        let place = vec2<u32>(shot.column + cell.x, cell.z * shot.size.y + cell.y);
        depth += textureLoad(density, place, 0).r * shot.cell;
        at += direction;
    }
    return exp(-depth);
}

@vertex
fn vs_light(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return everywhere(vertex);
}

@fragment
fn fs_light(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let place = vec2<u32>(at.xy);
    let cell = vec3<u32>(place.x - shot.column, place.y % shot.size.y, place.y / shot.size.y);
    let middle = vec3<f32>(cell) + 0.5;
    var sum = 0.0;
    for (var i = 0u; i < DIRECTIONS; i++) {
        sum += transmittance(middle, direction(i));
    }
    return sum / f32(DIRECTIONS);
}

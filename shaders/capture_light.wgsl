// How much light from all around reaches each cell of the grids that darken the inside of crowns.
// `src/capture/occlusion.rs` is the processor's twin, and says why.

struct Grid {
    // Cells along x, y and z.
    size: vec3<u32>,
    // The first cell's place among those of all grids.
    first: u32,
    // Edge of a cell, metres.
    cell: f32,
    unused: array<u32, 3>,
}

@group(0) @binding(0) var<storage, read> grids: array<Grid>;
// Optical depth per metre.
@group(0) @binding(1) var<storage, read> density: array<f32>;
@group(0) @binding(2) var<storage, read_write> open: array<f32>;

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
fn transmittance(grid: Grid, middle: vec3<f32>, direction: vec3<f32>) -> f32 {
    let size = vec3<f32>(grid.size);
    var depth = 0.0;
    var at = middle + direction * 1.2;
    while all(at >= vec3<f32>(0.0)) && all(at < size) {
        let cell = vec3<u32>(at);
        depth += density[grid.first + (cell.z * grid.size.y + cell.y) * grid.size.x + cell.x] * grid.cell;
        if depth > 6.0 {
            break;
        }
        at += direction;
    }
    return exp(-depth);
}

@compute @workgroup_size(64)
fn cs_light(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grids[id.y];
    if id.x >= grid.size.x * grid.size.y * grid.size.z {
        return;
    }
    let cell = vec3<u32>(
        id.x % grid.size.x,
        id.x / grid.size.x % grid.size.y,
        id.x / (grid.size.x * grid.size.y),
    );
    let middle = vec3<f32>(cell) + 0.5;
    var sum = 0.0;
    for (var i = 0u; i < DIRECTIONS; i++) {
        sum += transmittance(grid, middle, direction(i));
    }
    open[grid.first + id.x] = sum / f32(DIRECTIONS);
}

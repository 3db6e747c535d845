//! Colour under transparent texels.

use crate::image::{Image, Texel};

/// Gives transparent texels the values of a near leaf texel (two sweeps of nearest-source
/// propagation, after Danielsson 1980), keeping alpha 0; `colour` if there is no leaf at all.
pub(super) fn fill_transparent(image: &mut Image<Texel>, colour: [f32; 3]) {
    let (width, height) = (image.width(), image.height());
    let mut sources: Vec<Option<(u32, u32)>> = Vec::with_capacity(image.texels().len());
    for y in 0..height {
        for x in 0..width {
            sources.push((image.at(x, y).alpha > 0.0).then_some((x, y)));
        }
    }
    let forward = [(-1, 0), (-1, -1), (0, -1), (1, -1)];
    let backward = forward.map(|(dx, dy): (i32, i32)| (-dx, -dy));
    for y in 0..height {
        for x in 0..width {
            adopt(&mut sources, (width, height), (x, y), &forward);
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            adopt(&mut sources, (width, height), (x, y), &backward);
        }
    }
    for (index, source) in sources.into_iter().enumerate() {
        if image.texels()[index].alpha > 0.0 {
            continue;
        }
        let near = source.map_or(
            Texel {
                albedo: colour,
                ..Texel::EMPTY
            },
            |(x, y)| *image.at(x, y),
        );
        image.texels_mut()[index] = Texel { alpha: 0.0, ..near };
    }
}

/// Takes over the source of a neighbour if it is nearer than the texel's own.
fn adopt(
    sources: &mut [Option<(u32, u32)>],
    (width, height): (u32, u32),
    (x, y): (u32, u32),
    steps: &[(i32, i32)],
) {
    let index = |x: u32, y: u32| y as usize * width as usize + x as usize;
    let distance = |(sx, sy): (u32, u32)| {
        let (dx, dy) = (u64::from(sx.abs_diff(x)), u64::from(sy.abs_diff(y)));
        dx * dx + dy * dy
    };
    let own = index(x, y);
    let mut best = sources[own].map_or(u64::MAX, distance);
    for &(dx, dy) in steps {
        let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if nx >= width || ny >= height || best == 0 {
            continue;
        }
        if let Some(source) = sources[index(nx, ny)]
            && distance(source) < best
        {
            best = distance(source);
            sources[own] = Some(source);
        }
    }
}

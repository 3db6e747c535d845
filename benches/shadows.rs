//! Baking the nine soft shadows of a tree of 20,000 leaf cards, beside a plain version of the
//! same: float edge tests at every texel, the full-size alpha alone, sums in floats.

use divan::{Bencher, black_box};
use pleach::image::Image;
use pleach::image::scan::{Clip, triangle};
use pleach::math::{TAU, Vec2, Vec3, floor_to_u32};
use pleach::mesh::{Mesh, Primitive, Vertex};
use pleach::report::Quiet;
use pleach::shadow::{COUNT, Settings, bake, direction, samples};
use rayon::prelude::*;

const CARDS: u32 = 20_000;

fn main() {
    divan::main();
}

#[divan::bench(args = [256, 512], sample_count = 10)]
fn nine_maps(bencher: Bencher, size: u32) {
    let (mesh, alpha) = (tree(CARDS), ellipse(64));
    let settings = sized(size);
    bencher.bench(|| bake(black_box(&mesh), &alpha, 128, &settings, &Quiet));
}

#[divan::bench(sample_count = 10)]
fn nine_maps_on_one_thread(bencher: Bencher) {
    let (mesh, alpha) = (tree(CARDS), ellipse(64));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a thread can be started");
    let settings = sized(256);
    bencher.bench(|| one.install(|| bake(black_box(&mesh), &alpha, 128, &settings, &Quiet)));
}

#[divan::bench(args = [256, 512], sample_count = 3)]
fn nine_maps_plainly(bencher: Bencher, size: u32) {
    let (mesh, alpha) = (tree(CARDS), ellipse(64));
    let settings = sized(size);
    let rects = bake(&mesh, &alpha, 128, &settings, &Quiet).expect("nobody cancels");
    let rects: Vec<_> = rects.maps.iter().map(|map| map.ground_rect_m).collect();
    bencher.bench(|| {
        let maps = (0..COUNT).into_par_iter();
        let maps = maps.map(|i| plainly(black_box(&mesh), &alpha, i, rects[i], &settings));
        maps.collect::<Vec<_>>()
    });
}

fn sized(size: u32) -> Settings {
    Settings {
        size,
        ..Settings::default()
    }
}

fn plainly(
    mesh: &Mesh,
    alpha: &Image<u8>,
    index: usize,
    rect: [f32; 4],
    settings: &Settings,
) -> Image<f32> {
    let size = settings.size;
    let mut sums = Image::filled(size, size, 0.0);
    for sample in samples(direction(index), settings) {
        let mut mask = Image::filled(size, size, false);
        for (primitive, solid) in [(&mesh.bark, true), (&mesh.foliage, false)] {
            for corners in primitive.indices.as_chunks::<3>().0 {
                let corners = corners.map(|i| &primitive.vertices[i as usize]);
                let shadow = corners.map(|vertex| {
                    let p = Vec3::from(vertex.position);
                    let p = p - sample.to_light * (p.y / sample.to_light.y);
                    let [x0, z0, x1, z1] = rect;
                    Vec2::new((p.x - x0) / (x1 - x0), (p.z - z0) / (z1 - z0)) * size as f32
                });
                let clip = Clip {
                    x0: 0,
                    y0: 0,
                    x1: size,
                    y1: size,
                };
                triangle(shadow, clip, |x, y, b| {
                    let at = |axis: usize| {
                        let mix: f32 = (0..3).map(|i| corners[i].uv[axis] * b[i]).sum();
                        floor_to_u32(mix * alpha.width() as f32).min(alpha.width() - 1)
                    };
                    *mask.at_mut(x, y) |= solid || *alpha.at(at(0), at(1)) >= 128;
                });
            }
        }
        for (sum, hit) in sums.texels_mut().iter_mut().zip(mask.texels()) {
            *sum += f32::from(u8::from(*hit)) * sample.weight;
        }
    }
    sums
}

/// A leaf's outline: an ellipse that touches the image's edges.
fn ellipse(size: u32) -> Image<u8> {
    let centred = |i: u32| (i as f32 + 0.5) / size as f32 * 2.0 - 1.0;
    let inside = |i| Vec2::new(centred(i % size), centred(i / size)).length_squared() < 1.0;
    let texels = (0..size * size).map(|i| if inside(i) { 255 } else { 0 });
    Image::from_texels(size, size, texels.collect())
}

/// A tapered trunk of 6 m under cards of 12 by 6 cm, spread evenly in an ellipsoid 4 m across.
fn tree(cards: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for ring in 0..=12_u8 {
        let height = f32::from(ring) * 0.5;
        let radius = 0.15 * (1.0 - height / 6.5);
        for side in 0..12_u8 {
            let (sin, cos) = libm::sincosf(f32::from(side) * TAU / 12.0);
            let point = Vec3::new(cos * radius, height, sin * radius);
            mesh.bark.vertices.push(vertex(point, [0.0; 2]));
            if ring < 12 {
                let (a, b) = (u32::from(ring) * 12, u32::from((side + 1) % 12));
                let (side, next) = (a + u32::from(side), a + b);
                let quad = [side, side + 12, next, next, side + 12, next + 12];
                mesh.bark.indices.extend(quad);
            }
        }
    }
    let mut state = 1_u32;
    let mut draw = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = (state >> ((state >> 28) + 4) ^ state).wrapping_mul(277_803_737);
        ((word >> 22) ^ word) as f32 / u32::MAX as f32 * 2.0 - 1.0
    };
    let mut in_ball = || loop {
        let point = Vec3::new(draw(), draw(), draw());
        if (0.01..1.0).contains(&point.length_squared()) {
            return point;
        }
    };
    for _ in 0..cards {
        let centre = Vec3::new(0.0, 4.2, 0.0) + in_ball() * Vec3::new(2.0, 2.4, 2.0);
        let (long, other) = (in_ball().normalize_or(Vec3::X), in_ball());
        let wide = long.cross(other).normalize_or(long.any_orthogonal_vector());
        card(&mut mesh.foliage, centre, long * 0.06, wide * 0.03);
    }
    mesh
}

fn card(foliage: &mut Primitive, centre: Vec3, half_long: Vec3, half_wide: Vec3) {
    let first = u32::try_from(foliage.vertices.len()).expect("few cards");
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        let point = centre + half_long * (u * 2.0 - 1.0) + half_wide * (v * 2.0 - 1.0);
        foliage.vertices.push(vertex(point, [u, v]));
    }
    let indices = [0, 1, 2, 0, 2, 3].map(|i| first + i);
    foliage.indices.extend(indices);
}

fn vertex(point: Vec3, uv: [f32; 2]) -> Vertex {
    Vertex {
        position: point.to_array(),
        normal: [0.0, 1.0, 0.0],
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv,
        tint: pleach::mesh::WHITE,
    }
}

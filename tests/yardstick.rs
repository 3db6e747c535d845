//! Silhouettes cover the right pixels, and the yardstick knows what is larger, equal and to be scaled.

mod common;

use core::convert::Infallible;

use common::{cases, small, stand_ins};
use pleach::capture::View;
use pleach::image::scan::{self, Clip};
use pleach::image::{Image, Texel};
use pleach::lod::State;
use pleach::math::{Vec2, Vec3};
use pleach::measure::silhouette::{Cutouts, Silhouette, fragments};
use pleach::measure::yardstick::{Verdict, Yardstick};
use pleach::mesh::{Flattener, Mesh, Primitive, Vertex};
use proptest::prelude::*;

const SIZE: u32 = 64;

/// Samples one metre apart; x as in the picture, y from below.
const VIEW: View = View {
    centre: Vec3::new(32.0, 32.0, 0.0),
    right: Vec3::X,
    up: Vec3::Y,
    half: [32.0, 32.0],
    width: SIZE,
    height: SIZE,
};

fn opaque() -> Cutouts {
    Cutouts::of(&Image::filled(
        1,
        1,
        Texel {
            alpha: 1.0,
            ..Texel::EMPTY
        },
    ))
}

fn primitive(corners: &[([f32; 2], [f32; 2])], indices: &[u32]) -> Primitive {
    let vertex = |&([x, y], uv): &([f32; 2], [f32; 2])| Vertex {
        position: [x, y, 0.0],
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv,
        tint: pleach::mesh::WHITE,
    };
    Primitive {
        vertices: corners.iter().map(vertex).collect(),
        indices: indices.to_vec(),
        ..Primitive::default()
    }
}

fn bark(corners: &[[f32; 2]], indices: &[u32]) -> Mesh {
    let corners: Vec<_> = corners.iter().map(|&c| (c, [0.0; 2])).collect();
    Mesh {
        bark: primitive(&corners, indices),
        ..Mesh::default()
    }
}

const QUAD: [u32; 6] = [0, 1, 2, 0, 2, 3];

fn rectangle(x: f32, y: f32, width: f32, height: f32) -> [[f32; 2]; 4] {
    [
        [x, y],
        [x + width, y],
        [x + width, y + height],
        [x, y + height],
    ]
}

fn covered(mesh: &Mesh) -> Silhouette {
    Silhouette::of(mesh, &opaque(), &VIEW)
}

/// A point of the picture and a little around it, in hundredths.
fn point() -> impl Strategy<Value = [f32; 2]> {
    let hundredths = || (-800..7200_i16).prop_map(|h| f32::from(h) / 100.0);
    (hundredths(), hundredths()).prop_map(|(x, y)| [x, y])
}

/// Distance of a point from the nearest of a triangle's edges, as lines.
fn from_edges(corners: [Vec2; 3], point: Vec2) -> f32 {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| {
        let along = (corners[b] - corners[a]).normalize_or(Vec2::X);
        along.perp_dot(point - corners[a]).abs()
    });
    edges.into_iter().fold(f32::INFINITY, f32::min)
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn two_triangles_of_a_quad_share_no_pixel_and_leave_none_out(
        a in point(), b in point(), d in point(),
    ) {
        let c = [b[0] + d[0] - a[0], b[1] + d[1] - a[1]];
        let corners = [a, b, c, d];
        let [one, other] = [&QUAD[..3], &QUAD[3..]].map(|half| covered(&bark(&corners, half)));
        prop_assert_eq!(one.overlap(&other).0, 0, "shared pixels");
        // The same area cut along its other diagonal: none is left out along the cut.
        let turned = covered(&bark(&corners, &[0, 1, 3, 1, 2, 3]));
        let mut both = one;
        both.unite(&other);
        let missed = both.difference(&turned);
        prop_assert!(missed <= 2, "{missed} pixels depend on the diagonal");
    }

    #[test]
    fn triangles_cover_what_scan_conversion_covers(a in point(), b in point(), c in point()) {
        let corners = [a, b, c].map(|[x, y]| Vec2::new(x, 64.0 - y));
        let mut expected = vec![false; (SIZE * SIZE) as usize];
        let clip = Clip { x0: 0, y0: 0, x1: SIZE, y1: SIZE };
        scan::triangle(corners, clip, |x, y, _| expected[(y * SIZE + x) as usize] = true);
        let found = covered(&bark(&[a, b, c], &[0, 1, 2]));
        for (index, (found, expected)) in (0_u16..).zip(found.covered.iter().zip(expected)) {
            let middle = Vec2::new(f32::from(index % 64) + 0.5, f32::from(index / 64) + 0.5);
            let on_an_edge = from_edges(corners, middle) < 2e-3;
            prop_assert!(*found == expected || on_an_edge, "{middle}: {found}");
        }
    }
}

#[test]
fn rectangles_cover_their_area_and_nothing_outside_of_the_picture() {
    for (x, y, width, height, area) in [
        (3.0, 5.0, 10.0, 7.0, 70),
        (3.25, 5.25, 10.0, 7.0, 70),
        (0.0, 0.0, 64.0, 64.0, 4096),
        (-8.0, 60.0, 10.0, 10.0, 8),
        (70.0, 5.0, 10.0, 10.0, 0),
    ] {
        let mesh = bark(&rectangle(x, y, width, height), &QUAD);
        assert_eq!(covered(&mesh).area(), area, "{x} {y} {width} {height}");
        assert_eq!(fragments(&mesh, &VIEW), area);
    }
}

/// A card of 20 by 10 samples with the whole texture.
fn card() -> Mesh {
    let uv = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let corners = rectangle(8.0, 8.0, 20.0, 10.0);
    let corners: Vec<_> = corners.into_iter().zip(uv).collect();
    Mesh {
        foliage: primitive(&corners, &QUAD),
        ..Mesh::default()
    }
}

#[test]
fn half_transparent_cards_cover_their_opaque_half_but_cost_all_fragments() {
    let mut texture = Image::filled(40, 20, Texel::EMPTY);
    for y in 0..20 {
        for x in 0..20 {
            texture.at_mut(x, y).alpha = 1.0;
        }
    }
    let seen = Silhouette::of(&card(), &Cutouts::of(&texture), &VIEW);
    assert_eq!(seen.area(), 100);
    // The left half: columns 8 to 17 of rows 46 to 55.
    let is_left =
        |&index: &usize| (8..18).contains(&(index % 64)) && (46..56).contains(&(index / 64));
    let pixels = (0..seen.covered.len()).filter(|&i| seen.covered[i]);
    assert_eq!(pixels.filter(is_left).count(), 100);
    assert_eq!(fragments(&card(), &VIEW), 200);
}

#[test]
fn fragments_count_every_layer_and_silhouettes_only_one() {
    let one = bark(&rectangle(4.0, 4.0, 12.0, 9.0), &QUAD);
    let mut corners = rectangle(4.0, 4.0, 12.0, 9.0).to_vec();
    corners.extend(rectangle(10.0, 4.0, 12.0, 9.0));
    let two = bark(&corners, &[QUAD, QUAD.map(|i| i + 4)].concat());
    assert_eq!(fragments(&one, &VIEW), 108);
    assert_eq!(fragments(&two, &VIEW), 216);
    assert_eq!(covered(&two).area(), 18 * 9);
}

fn full() -> Mesh {
    let tree = small().tree();
    let form = stand_ins(&tree).form(&tree, &State::full(&tree), pleach::mesh::Coat::plain(0.5));
    Flattener::new(&tree, &form).tree().expect("small")
}

/// Larger about its middle.
fn grown(mesh: &Mesh, factor: f32) -> Mesh {
    let middle = mesh.bounds().centre();
    let mut grown = mesh.clone();
    for primitive in [&mut grown.bark, &mut grown.foliage] {
        for vertex in &mut primitive.vertices {
            let away = Vec3::from(vertex.position) - middle;
            vertex.position = (middle + away * factor).to_array();
        }
    }
    grown
}

#[test]
fn full_detail_matches_itself_exactly() {
    let mesh = full();
    let yardstick = Yardstick::new(&mesh, &opaque());
    let exact = Verdict {
        iou: 1.0,
        coverage: 1.0,
        error_m: 0.0,
    };
    assert_eq!(yardstick.judge(&mesh, &opaque()), exact);
    assert_eq!(yardstick.coverage(&mesh, &opaque()), 1.0);
}

#[test]
fn larger_meshes_cover_more_and_smaller_ones_less() {
    let mesh = full();
    let yardstick = Yardstick::new(&mesh, &opaque());
    let of = |factor: f32| yardstick.judge(&grown(&mesh, factor), &opaque());
    let [larger, smaller, tiny] = [1.1, 0.9, 0.6].map(of);
    // At most as the square, less where branches hide more of each other.
    assert!((1.1..1.3).contains(&larger.coverage), "{larger:?}");
    assert!((0.7..0.9).contains(&smaller.coverage), "{smaller:?}");
    assert!(
        tiny.iou < smaller.iou && smaller.iou < 1.0,
        "{tiny:?} {smaller:?}"
    );
    assert!(
        tiny.error_m > smaller.error_m && smaller.error_m > 0.0,
        "{tiny:?} {smaller:?}"
    );
    assert_eq!(yardstick.judge(&Mesh::default(), &opaque()).iou, 0.0);
}

#[test]
fn scale_undoes_a_known_scaling_and_stops_at_its_bounds() {
    let mesh = full();
    let yardstick = Yardstick::new(&mesh, &opaque());
    let scale = |factor: f32, bounds: [f32; 2]| {
        let mesh_at = |s: f32| Ok::<_, Infallible>(grown(&mesh, factor * s));
        yardstick
            .scale(&opaque(), bounds, mesh_at)
            .expect("cannot fail")
    };
    assert_eq!(scale(1.0, [0.5, 2.0]), 1.0);
    for factor in [0.8, 0.9, 1.1, 1.25] {
        let undone = scale(factor, [0.5, 2.0]) * factor;
        assert!((undone - 1.0).abs() < 0.01, "{factor}: {undone}");
    }
    assert_eq!(scale(0.5, [0.75, 1.3]), 1.3);
    assert_eq!(scale(2.0, [0.75, 1.3]), 0.75);
}

//! Clumps and stars of planes: everything is shown, and lies inside the rectangles that show it.

mod common;

use common::{small, stand_ins};
use pleach::impostor::planes::{self, Item, Plane};
use pleach::lod::State;
use pleach::math::{PI, Vec3};
use pleach::mesh::{Flattener, Mesh};

fn full() -> Mesh {
    let tree = small().tree();
    let form = stand_ins(&tree).form(&tree, &State::full(&tree), pleach::mesh::Coat::plain(0.5));
    Flattener::new(&tree, &form).tree().expect("small")
}

#[track_caller]
fn assert_inside(plane: &Plane, points: impl IntoIterator<Item = Vec3>) {
    for point in points {
        let away = point - plane.centre;
        let across = away.dot(plane.right).abs();
        let along = away.dot(plane.up).abs();
        assert!(
            across <= plane.half[0] + 1e-4,
            "{across} of {:?}",
            plane.half
        );
        assert!(along <= plane.half[1] + 1e-4, "{along} of {:?}", plane.half);
    }
}

/// How many planes show each item.
fn shown(items: &[Item], planes: &[Plane]) -> Vec<usize> {
    let mut shown = vec![0; items.len()];
    for &member in planes.iter().flat_map(|p| p.members.iter().flatten()) {
        shown[member as usize] += 1;
    }
    shown
}

#[test]
fn every_item_is_on_all_planes_of_one_clump_and_inside_their_rectangles() {
    let items = planes::items(&full());
    assert!(items.iter().any(|i| i.foliage) && items.iter().any(|i| !i.foliage));
    for (level, sides) in [(true, 3), (false, 2)] {
        for count in [1, 2, 7, 32] {
            let planes = planes::clumps(&items, count, 0.4, (level, true));
            assert_eq!(planes.len(), count * sides);
            assert_eq!(shown(&items, &planes), vec![sides; items.len()]);
            for clump in planes.chunks(sides) {
                for plane in clump {
                    assert_eq!(plane.members, clump[0].members);
                    let members = plane.members.iter().flatten();
                    assert_inside(plane, members.flat_map(|&m| items[m as usize].corners));
                }
                let normals: Vec<Vec3> = clump.iter().map(Plane::normal).collect();
                assert!(normals[0].dot(normals[1]).abs() < 1e-5, "crossed");
                assert!(
                    normals[0].y.abs() < 1e-5 && normals[1].y.abs() < 1e-5,
                    "upright"
                );
                assert!(
                    normals.get(2).is_none_or(|n| n.y > 0.999),
                    "seen from above"
                );
            }
        }
    }
}

#[test]
fn clumps_of_fewer_items_than_asked_for_are_one_an_item_and_none_of_nothing() {
    let items = planes::items(&full());
    assert!(planes::clumps(&[], 4, 0.0, (true, true)).is_empty());
    let planes = planes::clumps(&items[..3], 8, 0.0, (true, true));
    assert_eq!(planes.len(), 9);
    assert_eq!(shown(&items[..3], &planes), [3; 3]);
}

#[test]
fn the_planes_of_a_star_show_everything_and_are_evenly_turned() {
    let mesh = full();
    let vertices = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
    let points: Vec<Vec3> = vertices.map(|v| Vec3::from(v.position)).collect();
    let through = Vec3::new(0.3, 1.0, -0.2);
    for (upright, level) in [(2_u16, false), (2, true), (3, true)] {
        let planes = planes::star(&mesh, None, (through, upright), 0.5, level);
        assert_eq!(planes.len(), usize::from(upright) + usize::from(level));
        for plane in &planes {
            assert_eq!(plane.members, None);
            assert_inside(plane, points.iter().copied());
        }
        let (upright_planes, level_planes) = planes.split_at(usize::from(upright));
        for plane in upright_planes {
            assert!(
                plane.flattened(through).distance(through) < 1e-5,
                "passes through the point"
            );
            assert_eq!(plane.up, Vec3::Y);
        }
        for pair in upright_planes.windows(2) {
            let cosine = pair[0].right.dot(pair[1].right);
            assert!((cosine - libm::cosf(PI / f32::from(upright))).abs() < 1e-5);
        }
        assert!(level_planes.iter().all(|p| p.normal().y > 0.999));
    }
}

#[test]
fn a_bent_stem_is_on_the_one_plane_that_it_strays_from_least() {
    let mesh = full();
    let items = planes::items(&mesh);
    let first = items.iter().position(|i| !i.foliage).expect("bark");
    let mut stem = planes::Stem {
        // It leans along x, so the plane that looks along z shows it best.
        axis: vec![Vec3::ZERO, Vec3::new(0.6, 1.0, 0.1), Vec3::Y * 2.0],
        radius: 0.05,
        triangles: 6,
    };
    let star = |stem: &planes::Stem| planes::star(&mesh, Some(stem), (Vec3::Y, 2), 0.0, true);
    let planes = star(&stem);
    assert!(planes[0].normal().z.abs() > 0.999, "looks along z");
    assert_eq!(planes[0].members, None, "shows all");
    let stem_items: Vec<u32> = (0..6).map(|i| u32::try_from(first + i).unwrap()).collect();
    for plane in &planes[1..] {
        let members = plane.members.as_ref().expect("shows a part");
        assert_eq!(members.len(), items.len() - 6);
        assert!(stem_items.iter().all(|i| !members.contains(i)));
        assert_inside(
            plane,
            members.iter().flat_map(|&m| items[m as usize].corners),
        );
        let bare = planes::star(&mesh, None, (Vec3::Y, 2), 0.0, true);
        let same = bare.iter().find(|p| p.normal() == plane.normal());
        let same = same.expect("the same planes");
        let away = (same.centre - plane.centre).dot(plane.normal());
        assert!(away.abs() < 1e-4, "where they would stand without a stem");
    }
    // A straight one stands on all upright planes, but not on the level one.
    stem.axis = vec![Vec3::ZERO, Vec3::Y * 2.0];
    let planes = star(&stem);
    assert!(planes[0].members.is_none() && planes[1].members.is_none());
    assert!(planes[2].members.is_some());
}

//! Strips: straightening and bending cancel, flat fronds stay flat, and what comes out is a sound mesh.

mod common;

use common::{cases, scripts, small};
use pleach::impostor::planes::strips::{self, Bend, Fit, Strip};
use pleach::impostor::planes::{Item, Plane};
use pleach::math::{Quat, Similarity, Vec3};
use pleach::mesh::card::{self, Pane, Quad, UvRect};
use pleach::mesh::check;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::Beside;
use pleach::species::schema::ClosedForm;
use pleach::tree::{Branch, Part};
use proptest::prelude::*;

/// A bent branch of a small tree.
fn branch() -> Branch {
    let tree = small().tree();
    let Part::Branch(branch) = &tree.prototype(1, 0).part else {
        panic!("the second level of the sketch is a branch");
    };
    branch.clone()
}

fn straight() -> Branch {
    let mut branch = branch();
    for sample in &mut branch.axis {
        sample.position = Vec3::Y * (sample.t * branch.length);
        sample.frame = Quat::IDENTITY;
    }
    branch
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn bending_undoes_straightening_on_every_cross_section(
        t in 0.0_f32..=1.0, x in -0.5_f32..0.5, z in -0.5_f32..0.5,
    ) {
        let branch = branch();
        let sample = branch.at(t);
        let point = sample.position + sample.frame * Vec3::new(x, 0.0, z);
        let laid = strips::straightening(&branch, t).point(point);
        prop_assert!((laid.y - t * branch.length).abs() < 1e-4);
        let back = Bend::of(&branch).point(laid);
        prop_assert!(back.distance(point) < 1e-3, "{point} came back at {back}");
    }
}

/// Two rows of leaves in a shallow V along +Y.
fn frond(length: f32) -> Vec<Item> {
    let leaf = |i: u8| {
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let out = Vec3::new(side, 0.0, -0.3).normalize_or(Vec3::X);
        let (up, base) = (
            Vec3::Y * 0.02 * length,
            Vec3::Y * (f32::from(i) / 60.0 * length),
        );
        let tip = base + (out + Vec3::Y) * 0.2 * length;
        Item {
            corners: [base - up, base + up, tip - up, tip + up],
            area: 0.01,
            normal: Vec3::new(0.3 * side, 0.0, 1.0).normalize_or(Vec3::Z),
            indices: 0..0,
            foliage: true,
        }
    };
    (0..48).map(leaf).collect()
}

/// The same leaves where the branch takes them, each moved rigidly with its base.
fn bent(items: &[Item], branch: &Branch) -> Vec<Item> {
    let place = |item: &Item| {
        let base = (item.corners[0] + item.corners[1]) * 0.5;
        let back = strips::straightening(branch, base.y / branch.length).inverse();
        Item {
            corners: item.corners.map(|c| back.point(c)),
            ..item.clone()
        }
    };
    items.iter().map(place).collect()
}

fn positions(template: &pleach::mesh::Template) -> Vec<Vec3> {
    template
        .vertices
        .iter()
        .map(|v| v.axis + v.offset)
        .collect()
}

#[test]
fn strips_of_a_straight_branch_are_its_flat_planes() {
    let branch = straight();
    let items = frond(branch.length);
    let planes = strips::wings(&items, 2, 0.0);
    assert_eq!(planes.len(), 2);
    let fit = Fit {
        planes: &planes,
        bend: &Bend::of(&branch),
        items: &items,
        bent: &bent(&items, &branch),
    };
    let cuts = fit.cut(Vec::new(), 8);
    assert!(cuts.is_empty(), "nothing to be cut for: {cuts:?}");
    let quad = |plane: &Plane| Quad {
        centre: plane.centre,
        right: plane.right,
        up: plane.up,
        half: plane.half,
        thick: 0.0,
        captured_thickness: 1.0,
        pane: Pane::ALL,
    };
    let flat = card::quads(&planes.iter().map(quad).collect::<Vec<_>>());
    let strips = strips::template(&fit.strips(&cuts), &[UvRect::ALL; 2], &[1.0; 2]);
    assert_eq!(flat.indices, strips.indices);
    for (a, b) in flat.vertices.iter().zip(&strips.vertices) {
        assert!((a.axis - b.axis).length() < 2e-3, "{a:?} and {b:?}");
        assert!(a.normal.dot(b.normal) > 0.999 && a.tangent.dot(b.tangent) > 0.999);
        assert_eq!(a.uv, b.uv);
    }
}

#[test]
fn wings_show_each_leaf_once_from_the_branch_outward() {
    let items = frond(1.0);
    for count in 1..=4 {
        let planes = strips::wings(&items, count, 0.0);
        assert!((1..=count).contains(&planes.len()));
        let mut shown: Vec<u32> = planes
            .iter()
            .flat_map(|p| p.members.clone().unwrap())
            .collect();
        shown.sort_unstable();
        assert_eq!(shown, (0..48).collect::<Vec<u32>>());
        for plane in &planes {
            let axis = (Vec3::ZERO - plane.centre).dot(plane.right).abs();
            assert!(axis <= plane.half[0] + 1e-5, "the branch is on the wing");
            assert!(
                plane.normal().y.abs() < 1e-5 && plane.normal().z > 0.0,
                "upper side"
            );
        }
    }
    let two = strips::wings(&items, 2, 0.0);
    assert!(
        strips::spread(&items, &two) < 0.05,
        "both rows lie in their wings"
    );
}

#[test]
fn more_segments_bring_leaves_nearer_and_make_sound_meshes() {
    let branch = branch();
    let items = frond(branch.length);
    let planes = strips::wings(&items, 2, 0.0);
    let fit = Fit {
        planes: &planes,
        bend: &Bend::of(&branch),
        items: &items,
        bent: &bent(&items, &branch),
    };
    let (mut cuts, mut before) = (Vec::new(), f64::INFINITY);
    for segments in [1, 2, 4, 8] {
        cuts = fit.cut(cuts, segments);
        assert!(cuts.len() < segments && cuts.is_sorted());
        let strips = fit.strips(&cuts);
        let miss = fit.miss(&cuts);
        assert!(miss <= before, "{segments} segments: {miss} after {before}");
        before = miss;
        for scale in [0.8, 1.0, 1.3] {
            let template = strips::template(&strips, &[UvRect::ALL; 2], &[scale; 2]);
            assert!(positions(&template).iter().all(|p| p.is_finite()));
            let mesh = template.placed(&Similarity::IDENTITY, 1.0);
            check::mesh(&mesh).unwrap();
            let triangles: u64 = strips.iter().map(Strip::triangles).sum();
            assert_eq!(mesh.triangles(), triangles);
        }
    }
    assert!(cuts.len() > 1, "a bent branch is cut");
    let far = fit.mean_shift(&fit.strips(&cuts));
    assert!(far < 0.05 * branch.length, "{far} of {}", branch.length);
    assert!(fit.miss(&cuts) < 0.9 * fit.miss(&[]), "cuts are worth it");
}

#[test]
fn forced_strips_are_the_same_at_any_number_of_threads() {
    let palm = scripts().into_iter().find(|s| s.slug.contains("palm"));
    let palm = palm.expect("one of the species");
    let mut species = palm.species;
    species.lod.forms = vec![("fronds".to_owned(), ClosedForm::Strips(2, 3))];
    let mut settings = Settings {
        budgets: Some(vec![600]),
        bark_size: 64,
        ..Settings::default()
    };
    settings.captures.atlas_size = 512;
    (settings.shadows.size, settings.shadows.bands) = (16, 0);
    let files = Beside(palm.folder);
    let made = |threads| {
        let make =
            || pipeline::generate(&species, &settings, &files, &Quiet).expect("a sound species");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be started").install(make)
    };
    let (one, three) = (made(1), made(3));
    assert!(
        one.lods.iter().any(|l| l.state.contains("strips 2x3")),
        "{}",
        one.lods[0].state
    );
    for (a, b) in one.lods.iter().zip(&three.lods) {
        check::mesh(&a.mesh).unwrap();
        assert!(a.mesh == b.mesh && a.state == b.state, "{}", a.state);
    }
    assert!(
        one.foliage.albedo == three.foliage.albedo,
        "textures differ"
    );
}

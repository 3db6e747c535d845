//! Captures: how many there are, and that they show what they stand for.

mod common;

use common::{Sketch, cases, grown, sketches, small};
use pleach::capture::{
    Baked, Foliage, LeafArtwork, Plan, Settings, Source, Subject, Textures, VIEWS, View,
    Visibility, bake,
};
use pleach::image::atlas::Rect;
use pleach::image::dilate::dilate;
use pleach::image::{Image, Texel};
use pleach::impostor::cross_quad::RIGHT;
use pleach::lod::State;
use pleach::math::{Vec3, float};
use pleach::mesh::{Coat, Flattener, Mesh};
use pleach::report::{Quiet, Warning};
use pleach::species::schema::{Curve, LevelKind, Size};
use pleach::tree::{Kind, Part, Tree};
use proptest::prelude::*;

const BARK_HEIGHT: f32 = 0.5;

/// An ellipse on each card.
struct Ellipses(usize);

impl LeafArtwork for Ellipses {
    fn aspect(&self, _kind: usize) -> f32 {
        0.5
    }

    fn draw(&self, _kind: usize, width: u32, height: u32) -> Image<Texel> {
        let texel = |x: u32, y: u32| {
            let part = |at: u32, size: u32| (float(at) + 0.5) / float(size) * 2.0 - 1.0;
            let (x, y) = (part(x, width), part(y, height));
            Texel {
                albedo: [0.1, 0.3, 0.05],
                alpha: if x * x + y * y < 0.9 { 1.0 } else { 0.0 },
                ..Texel::EMPTY
            }
        };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y)));
        Image::from_texels(width, height, texels.collect())
    }

    fn kinds(&self) -> usize {
        self.0
    }
}

fn bark() -> Vec<Image<Texel>> {
    let brown = Texel {
        albedo: [0.2, 0.12, 0.06],
        alpha: 1.0,
        ..Texel::EMPTY
    };
    vec![Image::filled(4, 4, brown)]
}

fn baked(tree: &Tree, source: Source, atlas_size: u32) -> Baked {
    let settings = Settings {
        atlas_size,
        supersample: 2,
        source,
    };
    let plan = Plan::of(tree);
    bake(
        tree,
        &plan,
        &Ellipses(3),
        (&bark(), Coat::plain(BARK_HEIGHT)),
        &settings,
        &Quiet,
    )
    .expect("a small tree fits its atlas")
}

/// Distinct shapes of branches: each unlike the first of every shape before it. Near is no equivalence
/// (three in a row may differ little from each other, and the ends too much), so the first one counts.
fn branch_types(tree: &Tree) -> usize {
    let branches: Vec<_> = tree
        .levels
        .iter()
        .flat_map(|l| &l.prototypes)
        .filter_map(|p| match &p.part {
            Part::Branch(branch) => Some(branch),
            Part::Stool | Part::Leaf { .. } => None,
        })
        .collect();
    let same = |a: usize, b: usize| {
        let (a, b) = (branches[a], branches[b]);
        let scale = a.length / b.length;
        a.axis.len() == b.axis.len()
            && a.axis.iter().zip(&b.axis).all(|(p, q)| {
                p.position.distance(q.position * scale) < 1e-3 * a.length
                    && (p.radius - q.radius * scale).abs() < 1e-3 * a.length
            })
    };
    let mut firsts: Vec<usize> = Vec::new();
    for b in 0..branches.len() {
        if !firsts.iter().any(|&a| same(a, b)) {
            firsts.push(b);
        }
    }
    firsts.len()
}

#[test]
fn a_plain_chain_needs_the_captures_of_the_paper() {
    for branches in 1..=3 {
        let mut sketch = small();
        sketch.branches.truncate(branches);
        let tree = sketch.tree();
        let (levels, types) = (branches + 1, branch_types(&tree));
        assert_eq!(
            types, branches,
            "each level of the sketch has its own shape"
        );
        assert_eq!(Plan::of(&tree).captures(), (levels - 1 + types) * 2);
    }
}

/// Four levels, of which the two in the middle have one shape at two sizes.
fn twins() -> Tree {
    let mut species = Sketch { seed: 3, ..small() }.species();
    for (level, length) in [(1, 1.0), (2, 0.4)] {
        let LevelKind::Branch(branch) = &mut species.levels[level].kind else {
            panic!("levels 1 and 2 of the sketch are branches");
        };
        branch.splines = vec![(1, 1.0)];
        branch.gnarl = 0.0;
        branch.collar = 1.0;
        branch.length_vary = 0.0;
        branch.length = Size::Metres(length);
        branch.radius = Size::Metres(length * 0.01);
        branch.taper = Curve::constant(1.0);
        species.levels[level].placement.scale.vary = 0.0;
    }
    grown(&species, 3)
}

#[test]
fn two_levels_of_one_shape_share_its_captures() {
    let tree = twins();
    let plan = Plan::of(&tree);
    assert_eq!(branch_types(&tree), 2);
    assert_eq!(plan.captures(), (4 - 1 + 2) * 2);
    let (first, second) = (plan.branch_types[1][0], plan.branch_types[2][0]);
    let ((first, _), (second, factor)) = (first.expect("a branch"), second.expect("a branch"));
    assert_eq!(first, second);
    assert!((factor - 0.4).abs() < 1e-3, "{factor}");
    let quads = baked(&tree, Source::Direct, 256).quads;
    let [large, shared] = [1, 2].map(|l| quads.branches[l][0].expect("captured")[0]);
    assert_eq!(large.pane, shared.pane, "one place in the atlas");
    assert!((shared.half[1] / large.half[1] - 0.4).abs() < 1e-3);
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn variants_and_roots_are_captured_as_documented(sketch in sketches(true)) {
        let tree = sketch.tree();
        let plan = Plan::of(&tree);
        // Each prototype of a level that carries something, with all that grows on it.
        let combined: usize = (0..tree.levels.len())
            .filter(|&l| tree.levels[l].kind != Kind::Leaf && tree.has_children(l))
            .map(|l| tree.levels[l].prototypes.len())
            .sum();
        prop_assert_eq!(plan.captures(), (combined + branch_types(&tree)) * 2);
        for (l, level) in tree.levels.iter().enumerate() {
            for p in 0..level.prototypes.len() {
                let whole = plan.combined(l, p).is_some();
                prop_assert_eq!(whole, level.kind != Kind::Leaf && level.name != "roots");
                prop_assert_eq!(plan.branch_types[l][p].is_some(), level.kind == Kind::Branch);
            }
        }
    }
}

/// The texels of a rectangle without its border.
fn inside(rect: &Rect) -> impl Iterator<Item = (u32, u32)> + use<> {
    let Rect {
        x,
        y,
        width,
        height,
    } = *rect;
    (y + 1..y + height - 1).flat_map(move |y| (x + 1..x + width - 1).map(move |x| (x, y)))
}

#[test]
fn border_texels_of_every_rectangle_are_transparent() {
    for source in [Source::Direct, Source::Hierarchical] {
        let baked = baked(&small().tree(), source, 256);
        assert!(!baked.rects.is_empty());
        for rect in &baked.rects {
            let (right, bottom) = (rect.x + rect.width - 1, rect.y + rect.height - 1);
            let rows = (rect.x..=right).flat_map(|x| [(x, rect.y), (x, bottom)]);
            let columns = (rect.y..=bottom).flat_map(|y| [(rect.x, y), (right, y)]);
            for (x, y) in rows.chain(columns) {
                assert!(baked.atlas.at(x, y).alpha == 0.0, "{rect:?} at {x}, {y}");
            }
            let covered = inside(rect).filter(|&(x, y)| baked.atlas.at(x, y).alpha > 0.0);
            assert!(covered.count() > 0, "{rect:?} shows nothing");
        }
    }
}

#[test]
fn a_capture_covers_what_a_projection_covers() {
    let tree = small().tree();
    let plan = Plan::of(&tree);
    let baked = baked(&tree, Source::Direct, 512);
    let pyramid = Foliage::of(baked.atlas.clone(), 4);
    let bark = bark();
    let textures = Textures {
        bark: &bark,
        foliage: &pyramid,
        reliefs: &[],
    };
    let form = baked
        .quads
        .form(&tree, &State::full(&tree), Coat::plain(BARK_HEIGHT));
    let thickness = tree.mean_thickness();
    for (index, &subject) in plan.subjects.iter().enumerate() {
        let Subject::Combined { level, prototype } = subject else {
            continue;
        };
        let mut mesh = Mesh::default();
        Flattener::new(&tree, &form)
            .write(
                level,
                prototype,
                &pleach::math::Similarity::IDENTITY,
                thickness[level][prototype],
                &mut mesh,
            )
            .expect("small");
        let rect = &baked.rects[index * VIEWS];
        let bounds = mesh.bounds();
        let size = bounds.size();
        let view = View {
            centre: bounds.centre(),
            right: RIGHT[0],
            up: Vec3::Y,
            half: [size.x * 0.5, size.y * 0.5],
            width: (rect.width - 2) * 4,
            height: (rect.height - 2) * 4,
        };
        let seen = Visibility::draw(&mesh, textures, &view);
        let samples = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
        let covered = samples.filter(|&(x, y)| seen.depth(x, y).is_some()).count();
        let projected = covered as f64 / f64::from(view.width * view.height);
        let captured = mean_alpha(&baked.atlas, rect);
        eprintln!("{subject:?}: captured {captured:.4}, projected {projected:.4}");
        assert!((captured - projected).abs() < 0.025, "{subject:?}");
    }
}

fn mean_alpha(atlas: &Image<Texel>, rect: &Rect) -> f64 {
    let sum: f64 = inside(rect)
        .map(|(x, y)| f64::from(atlas.at(x, y).alpha))
        .sum();
    sum / inside(rect).count() as f64
}

#[test]
fn captures_from_captures_look_like_captures_from_meshes() {
    let tree = small().tree();
    let plan = Plan::of(&tree);
    let direct = baked(&tree, Source::Direct, 512);
    let hierarchical = baked(&tree, Source::Hierarchical, 512);
    assert_eq!(direct.rects, hierarchical.rects);
    let told = |b: &Baked| {
        let from_captures = |w: &&Warning| matches!(w, Warning::CapturesFromCaptures { .. });
        b.warnings.iter().filter(from_captures).count()
    };
    assert_eq!(
        (told(&direct), told(&hierarchical)),
        (0, 2),
        "{:?}",
        hierarchical.warnings
    );
    for (index, subject) in plan.subjects.iter().enumerate() {
        for rect in &direct.rects[index * VIEWS..][..VIEWS] {
            let difference: f64 = inside(rect)
                .map(|(x, y)| {
                    let alpha = |b: &Baked| f64::from(b.atlas.at(x, y).alpha);
                    (alpha(&direct) - alpha(&hierarchical)).abs()
                })
                .sum();
            let mean = difference / inside(rect).count() as f64;
            let covers = [&direct, &hierarchical].map(|b| mean_alpha(&b.atlas, rect));
            eprintln!("{subject:?}: mean difference {mean:.4}, coverage {covers:.3?}");
            match subject {
                Subject::Branch { .. } => assert!(mean == 0.0, "drawn the same way"),
                Subject::Combined { .. } => {
                    assert!(mean < MOST_ALPHA_DIFFERENCE, "{subject:?}: {mean}");
                }
            }
        }
    }
}

/// Mean absolute difference of alpha that drawing from captures may make. The whole small tree was
/// measured at 0.163, with two thirds of its coverage left: crossed quads show little of a limb that
/// points at the viewer.
const MOST_ALPHA_DIFFERENCE: f64 = 0.2;

#[test]
fn captured_normals_face_the_viewer_and_are_of_unit_length() {
    let baked = baked(&small().tree(), Source::Hierarchical, 256);
    let mut seen = 0;
    for (x, y) in baked.rects.iter().flat_map(inside) {
        let texel = baked.atlas.at(x, y);
        if texel.alpha > 0.0 {
            seen += 1;
            assert!(texel.normal[2] >= 0.0, "{texel:?} at {x}, {y}");
            let length = Vec3::from(texel.normal).length();
            assert!((length - 1.0).abs() < 1e-3, "{texel:?} at {x}, {y}");
            for part in [texel.alpha, texel.occlusion] {
                assert!((0.0..=1.000_001).contains(&part), "{texel:?} at {x}, {y}");
            }
            assert!((-1.0..=1.0).contains(&texel.depth));
        }
    }
    assert!(seen > 1000, "only {seen} texels are covered");
}

#[test]
fn the_dilated_atlas_has_colour_everywhere_and_the_same_alpha() {
    let baked = baked(&small().tree(), Source::Direct, 256);
    let mut dilated = baked.atlas.clone();
    dilate(&mut dilated);
    for (before, after) in baked.atlas.texels().iter().zip(dilated.texels()) {
        assert!(before.alpha == after.alpha);
        assert!(after.albedo.iter().sum::<f32>() > 0.05, "{after:?}");
        if before.alpha > 0.0 {
            assert_eq!(before, after);
        } else {
            assert!(Vec3::from(after.normal).length() > 0.5, "{after:?}");
        }
    }
}

#[test]
fn quads_stand_where_their_sub_tree_does() {
    let tree = small().tree();
    let baked = baked(&tree, Source::Direct, 256);
    let extents = tree.extents();
    for (level, prototypes) in baked.quads.combined.iter().enumerate() {
        for quads in prototypes.iter().flatten() {
            let bounds = extents[level][0].bounds(&pleach::math::Similarity::IDENTITY);
            let size = bounds.size();
            for (quad, width) in quads.iter().zip([size.x, size.z]) {
                let near = |a: f32, b: f32| (a - b).abs() < 0.12 * size.max_element();
                assert!(near(quad.half[0] * 2.0, width), "{quad:?} {bounds:?}");
                assert!(near(quad.half[1] * 2.0, size.y), "{quad:?} {bounds:?}");
                assert!(
                    near(quad.centre.y, bounds.centre().y),
                    "{quad:?} {bounds:?}"
                );
            }
        }
    }
}

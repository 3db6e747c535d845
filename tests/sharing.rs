//! The law of sharing: all nodes of one level and variant carry the same sub-tree, and what is
//! computed on the graph agrees with a walk over its nodes.

mod common;

use common::{Node, Sketch, grown, sketches, small, walk};
use pleach::math::{Bounds, Similarity, Vec3};
use pleach::mesh::{Flattener, Mesh};
use pleach::species::schema::{Curve, LevelKind, Size, Species};
use pleach::tree::{GrowError, Limits, Link, Part, Tree, grow};
use proptest::prelude::*;

/// Error of a product of four similarities in single precision, as a part of the tree's size.
const NEAR: f32 = 2e-5;

proptest! {
    #![proptest_config(common::cases(32))]

    #[test]
    fn sub_trees_of_one_level_and_variant_are_equal(sketch in sketches(false)) {
        let tree = sketch.tree();
        prop_assert!((0..tree.levels.len()).all(|level| !tree.turns_below(level)));
        shared(&tree)?;
    }

    #[test]
    fn sub_trees_below_the_last_turned_level_are_equal(sketch in sketches(true)) {
        shared(&sketch.tree())?;
    }

    #[test]
    fn counting_on_the_graph_is_counting_nodes(sketch in sketches(true)) {
        let tree = sketch.tree();
        let mut counted: Vec<Vec<u64>> =
            tree.levels.iter().map(|l| vec![0; l.prototypes.len()]).collect();
        let nodes = walk(&tree);
        for node in &nodes {
            counted[node.level][node.prototype] += 1;
        }
        prop_assert_eq!(&counted, &tree.nodes());
        let below = tree.nodes_below(0, 0).nodes;
        let sums: Vec<u64> = counted.iter().map(|level| level.iter().sum()).collect();
        prop_assert_eq!(below, sums.clone());
        for (level, expected) in products(&sketch) {
            let found = tree.levels.iter().position(|l| l.name == level).expect("a level");
            prop_assert_eq!(sums[found], expected, "level {}", level);
        }
    }

    #[test]
    fn extents_lie_within_the_tree_and_nearly_reach_its_bounds(sketch in sketches(false)) {
        let (outside, short) = extent_errors(&sketch);
        prop_assert!(outside < 1e-4, "outside by {outside} of the size");
        prop_assert!(short < 0.06, "short by {short} of the size");
    }

    #[test]
    fn a_seed_makes_one_tree_and_another_seed_another(sketch in sketches(true)) {
        let species = sketch.species();
        prop_assert_eq!(grown(&species, sketch.seed), grown(&species, sketch.seed));
        prop_assert_ne!(
            grown(&species, sketch.seed).levels,
            grown(&species, sketch.seed ^ 1).levels
        );
    }

    #[test]
    fn roots_reshuffle_nothing(sketch in sketches(true)) {
        let bare = Sketch { roots: false, ..sketch.clone() }.tree();
        let rooted = Sketch { roots: true, ..sketch }.tree();
        prop_assert_eq!(rooted.levels.len(), bare.levels.len() + 1);
        for level in &bare.levels {
            let twin = rooted.levels.iter().find(|l| l.name == level.name).expect("a level");
            for (mine, theirs) in level.prototypes.iter().zip(&twin.prototypes) {
                prop_assert_eq!(&mine.part, &theirs.part);
            }
            prop_assert_eq!(
                links_by_name(&bare, &level.name, "roots"),
                links_by_name(&rooted, &level.name, "roots")
            );
        }
    }

    #[test]
    fn an_edit_of_one_level_leaves_the_draws_of_the_others(
        sketch in sketches(true),
        level in any::<prop::sample::Index>(),
        edit in 0..EDITS.len(),
    ) {
        let mut before = sketch.species();
        let mut after = before.clone();
        let edited = 1 + level.index(after.levels.len() - 1);
        (EDITS[edit].1)(&mut after, edited);
        prop_assert_ne!(&before, &after);
        // What its places carry by skipping moves with them.
        for species in [&mut before, &mut after] {
            species.levels[edited].placement.skip = Curve::constant(0.0);
        }
        let name = &before.levels[edited].name;
        let (before, after) = (grown(&before, 9), grown(&after, 9));
        for level in &before.levels {
            prop_assert_eq!(
                links_by_name(&before, &level.name, name),
                links_by_name(&after, &level.name, name),
                "{} of {}", EDITS[edit].0, name
            );
        }
    }
}

type Edit = fn(&mut Species, usize);

/// Edits of one parameter of one level that move no other level's places.
const EDITS: [(&str, Edit); 6] = [
    ("around", |s, l| s.levels[l].placement.around.vary += 5.0),
    ("down", |s, l| s.levels[l].placement.down.vary += 5.0),
    ("scale", |s, l| s.levels[l].placement.scale.vary += 0.1),
    ("jitter", |s, l| s.levels[l].placement.jitter += 0.3),
    ("links", |s, l| s.levels[l].placement.links += 1),
    ("children", |s, l| s.levels[l].placement.children += 1),
];

/// Links on the prototypes of one level, with the levels that they lead to by name; those to `except`
/// are left out.
fn links_by_name(tree: &Tree, level: &str, except: &str) -> Vec<Vec<(String, Link)>> {
    let level = tree
        .levels
        .iter()
        .find(|l| l.name == level)
        .expect("a level");
    let named = |link: &Link| {
        let name = tree.levels[link.level as usize].name.clone();
        (name != except).then_some((name, Link { level: 0, ..*link }))
    };
    level
        .prototypes
        .iter()
        .map(|p| p.links.iter().filter_map(named).collect())
        .collect()
}

/// Nodes of each level by the law: the product of links and children down the levels.
fn products(sketch: &Sketch) -> Vec<(String, u64)> {
    let trunks = u64::from(sketch.stems.unwrap_or(1));
    let mut products = vec![("b0".to_owned(), trunks)];
    if sketch.roots {
        products.push(("roots".to_owned(), trunks * 3));
    }
    // Children at the places of a level that skip so many levels, for each that carries them.
    let children = |level: usize, skip: u32| {
        let branch = &sketch.branches[level];
        let last = f64::from((branch.links - 1).max(1));
        let skipped = |place: u32| (f64::from(place) / last * f64::from(branch.skip)).round();
        let places = (0..branch.links).filter(|&place| skipped(place) == f64::from(skip));
        places.count() as u64 * u64::from(branch.children)
    };
    let mut nodes = vec![trunks];
    for level in 1..sketch.branches.len() {
        let on = |skip: u32| {
            let places = level - skip as usize;
            nodes[places - 1] * children(places, skip)
        };
        let sum = (0..u32::try_from(level).expect("few")).map(on).sum();
        nodes.push(sum);
        products.push((format!("b{level}"), sum));
    }
    let leaves = nodes[nodes.len() - 1] * u64::from(sketch.leaves.links * sketch.leaves.children);
    products.push(("leaves".to_owned(), leaves));
    products
}

/// Compares every node's sub-tree, in the node's own frame, with that of the first of its kind.
fn shared(tree: &Tree) -> Result<(), TestCaseError> {
    let nodes = walk(tree);
    for (level, shared) in tree.levels.iter().enumerate() {
        if tree.turns_below(level) {
            continue;
        }
        for prototype in 0..shared.prototypes.len() {
            let mut of_kind = (0..nodes.len())
                .filter(|&i| (nodes[i].level, nodes[i].prototype) == (level, prototype));
            let Some(first) = of_kind.next() else {
                continue;
            };
            for other in of_kind {
                same_sub_tree(&nodes, first, other).map_err(TestCaseError::fail)?;
            }
        }
    }
    Ok(())
}

fn same_sub_tree(nodes: &[Node], first: usize, other: usize) -> Result<(), String> {
    let (a, b) = (&nodes[first], &nodes[other]);
    if a.end - first != b.end - other {
        return Err(format!(
            "nodes {first} and {other} carry different numbers of nodes"
        ));
    }
    let (from_a, from_b) = (a.place.inverse(), b.place.inverse());
    for (mine, theirs) in (first + 1..a.end).zip(other + 1..b.end) {
        let (mine, theirs) = (&nodes[mine], &nodes[theirs]);
        let part = |n: &Node| (n.level, n.prototype, n.thickness.to_bits());
        let (p, q) = (
            from_a.then_inner(&mine.place),
            from_b.then_inner(&theirs.place),
        );
        if part(mine) != part(theirs) || !near(&p, &q, a.place.scale.min(b.place.scale)) {
            return Err(format!(
                "nodes {first} and {other} carry different nodes: {mine:?} {theirs:?}: {p:?} {q:?}"
            ));
        }
    }
    Ok(())
}

/// True if two frames are equal but for rounding. A place in a small node is known only as well as
/// the tree's own coordinates, so its error grows as the node's `scale` falls.
fn near(a: &Similarity, b: &Similarity, scale: f32) -> bool {
    let size = 6.0 / scale;
    a.translation.distance(b.translation) < NEAR * size
        && (a.scale / b.scale - 1.0).abs() < 1e-4
        && [Vec3::X, Vec3::Y, Vec3::Z]
            .iter()
            .all(|&axis| (a.rotation * axis).distance(b.rotation * axis) < 2e-4)
}

/// How far extents reach out of the true bounds of their sub-trees, and how far they fall short, as
/// parts of the size: the worst over all prototypes.
fn extent_errors(sketch: &Sketch) -> (f32, f32) {
    let mut species = sketch.species();
    // As many corners as the extents look at, at every sample of the curve that matters.
    species.lod.tolerances = vec![1e-6];
    for level in &mut species.levels {
        if let LevelKind::Branch(branch) = &mut level.kind {
            branch.sides = 8;
        }
    }
    let mut tree = grown(&species, sketch.seed);
    for link in tree
        .levels
        .iter_mut()
        .flat_map(|l| &mut l.prototypes)
        .flat_map(|p| &mut p.links)
    {
        link.thickness = 1.0;
    }
    let form = common::stand_ins(&tree).form(
        &tree,
        &pleach::lod::State::full(&tree),
        pleach::mesh::Coat::plain(1.0),
    );
    let flattener = Flattener::new(&tree, &form);
    let mut worst = (0.0_f32, 0.0_f32);
    let mut mesh = Mesh::default();
    for (level, extents) in tree.extents().iter().enumerate() {
        for (prototype, extent) in extents.iter().enumerate() {
            flattener
                .write(level, prototype, &Similarity::IDENTITY, 1.0, &mut mesh)
                .expect("small");
            let truth = mesh.bounds();
            let (outside, short) = misses(&extent.bounds(&Similarity::IDENTITY), &truth);
            let size = truth.size().max_element();
            worst = (worst.0.max(outside / size), worst.1.max(short / size));
        }
    }
    worst
}

fn misses(bounds: &Bounds, truth: &Bounds) -> (f32, f32) {
    let out = (truth.min - bounds.min).max(bounds.max - truth.max);
    let short = (bounds.min - truth.min).max(truth.max - bounds.max);
    (out.max_element().max(0.0), short.max_element().max(0.0))
}

#[test]
fn sub_trees_above_a_turned_level_differ() {
    let mut sketch = small();
    sketch.branches[2].tropism = 0.6;
    let tree = sketch.tree();
    let nodes = walk(&tree);
    let limbs: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i].level == 1).collect();
    assert!(tree.turns_below(1) && !tree.turns_below(2));
    assert!(
        limbs[1..]
            .iter()
            .all(|&limb| same_sub_tree(&nodes, limbs[0], limb).is_err()),
        "turned twigs must not look the same on all limbs, or the law's test could not fail"
    );
}

#[test]
fn a_tree_of_millions_of_leaves_costs_kilobytes() {
    let mut sketch = small();
    for branch in &mut sketch.branches[1..] {
        (branch.links, branch.children) = (40, 3);
    }
    (sketch.leaves.links, sketch.leaves.children) = (60, 2);
    let tree = sketch.tree();
    let leaves: u64 = tree.nodes()[3].iter().sum();
    assert_eq!(leaves, 120 * 120 * 120);
    assert!(tree.bytes() < 64 << 10, "{} bytes", tree.bytes());
}

#[test]
fn every_prototype_is_a_branch_or_a_leaf_of_its_script() {
    let sketch = small();
    let species = sketch.species();
    for (script, level) in species.levels.iter().zip(&sketch.tree().levels) {
        for prototype in &level.prototypes {
            match (&script.kind, &prototype.part) {
                (LevelKind::Leaf(_), Part::Leaf { kind, length, .. }) => {
                    assert_eq!(*length, species.leaves[usize::from(*kind)].length_m);
                }
                (LevelKind::Branch(params), Part::Branch(branch)) => {
                    if let Size::Metres(length) = params.length {
                        assert!((branch.length / length - 1.0).abs() <= params.length_vary);
                    }
                }
                (kind, part) => panic!("{kind:?} became {part:?}"),
            }
        }
    }
}

#[test]
fn a_level_on_itself_or_on_a_later_one_is_refused() {
    for parent in [None, Some(1), Some(2), Some(99)] {
        let mut species = small().species();
        species.levels[1].parent = parent;
        let level = species.levels[1].name.clone();
        let grown = grow(&species, 1, &Limits::default());
        assert_eq!(grown, Err(GrowError::Incomplete { level }), "{parent:?}");
    }
}

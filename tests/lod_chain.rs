//! LOD chains: budgets are kept, every LOD is simpler than the one before, and what a state promises
//! is what the flattener writes.

mod common;

use common::{cases, descent, sketches, small, stand_ins};
use pleach::lod::{ChainLod, Form, Selector, State};
use pleach::mesh::Flattener;
use pleach::report::Warning;
use pleach::species::schema::{Lod, Simplification};
use pleach::tree::{Kind, Tree};
use proptest::prelude::*;

/// Budgets that fall strictly, from the size of a full tree down to one cross-quad.
fn falling_budgets() -> impl Strategy<Value = Vec<u64>> {
    prop::collection::btree_set(prop_oneof![4..200_u64, 200..40_000_u64], 1..8)
        .prop_map(|budgets| budgets.into_iter().rev().collect())
}

/// Any order of any of the three simplifications.
fn priorities() -> impl Strategy<Value = Vec<Simplification>> {
    use Simplification::{Branches, Levels, Splines};
    (
        Just(vec![Splines, Branches, Levels]).prop_shuffle(),
        1..=3_usize,
    )
        .prop_map(|(mut all, count)| {
            all.truncate(count);
            all
        })
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn a_chain_keeps_its_budgets_and_never_turns_back(
        sketch in sketches(true),
        budgets in falling_budgets(),
        priorities in priorities(),
        with_full in any::<bool>(),
    ) {
        let tree = sketch.tree();
        let lod = Lod { priorities, ..Lod::default() };
        let chain = Selector::new(&tree, &lod).chain(&budgets, with_full);
        for lod in &chain.lods {
            prop_assert!(lod.budget.is_none_or(|budget| lod.triangles.total() <= budget));
            prop_assert!((0.0..=1.0).contains(&lod.screen_size));
        }
        for pair in chain.lods.windows(2) {
            falls(&pair[0], &pair[1])?;
        }
        let made = chain.lods.len() - usize::from(with_full);
        prop_assert_eq!(made + chain.warnings.len(), budgets.len(), "each budget is answered once");
    }

    #[test]
    fn every_state_has_the_triangles_that_are_written(sketch in sketches(true)) {
        let tree = sketch.tree();
        let quads = stand_ins(&tree);
        for (state, triangles) in descent(&tree, &Lod::default()) {
            let form = quads.form(&tree, &state, pleach::mesh::Coat::plain(0.5));
            let flattener = Flattener::new(&tree, &form);
            let mesh = flattener.tree().expect("small");
            prop_assert_eq!(mesh.bark.triangles(), triangles.branches, "{}", state.describe(&tree));
            prop_assert_eq!(mesh.foliage.triangles(), triangles.foliage, "{}", state.describe(&tree));
            prop_assert_eq!(flattener.size(0, 0).triangles(), triangles.total());
        }
    }

    #[test]
    fn the_last_form_of_every_tree_is_one_cross_quad(
        sketch in sketches(true),
        priorities in priorities(),
    ) {
        let tree = sketch.tree();
        let lod = Lod { priorities, ..Lod::default() };
        let selector = Selector::new(&tree, &lod);
        prop_assert_eq!(selector.smallest_triangles(), 4);
        let chain = selector.chain(&[4], true);
        prop_assert_eq!(chain.lods.last().map(|l| l.triangles.total()), Some(4));
        prop_assert!(chain.warnings.is_empty());
    }

    #[test]
    fn budgets_below_one_cross_quad_give_a_warning_and_no_lod(
        sketch in sketches(true),
        budget in 0..4_u64,
    ) {
        let chain = Selector::new(&sketch.tree(), &Lod::default()).chain(&[budget], false);
        prop_assert!(chain.lods.is_empty());
        let expected = Warning::BudgetBelowSmallest { budget, smallest: 4 };
        prop_assert_eq!(chain.warnings, vec![expected]);
    }

    #[test]
    fn every_state_follows_both_rules_of_the_paper(
        sketch in sketches(true),
        priorities in priorities(),
    ) {
        let tree = sketch.tree();
        let lod = Lod { priorities, ..Lod::default() };
        for (state, _) in &descent(&tree, &lod)[1..] {
            spline_rules(&tree, &lod, state).map_err(TestCaseError::fail)?;
            collapse_rules(&tree, state).map_err(TestCaseError::fail)?;
        }
    }

    #[test]
    fn the_first_priority_is_used_up_before_the_second(sketch in sketches(true)) {
        use Simplification::{Branches, Levels, Splines};
        let tree = sketch.tree();
        let states = |priorities: &[Simplification]| {
            let lod = Lod { priorities: priorities.to_vec(), ..Lod::default() };
            descent(&tree, &lod).split_off(1)
        };
        for (state, _) in states(&[Splines, Branches, Levels]) {
            if quads(&tree, &state) > 0 && trunk(&tree, &state) != Form::Quads {
                prop_assert_eq!(trunk(&tree, &state), Form::Geometry(4), "{}", state.describe(&tree));
            }
        }
        for (state, _) in states(&[Branches, Splines, Levels]) {
            if let Form::Geometry(1..) = trunk(&tree, &state) {
                // Only the trunk is left as geometry.
                let geometry = branch_levels(&tree)
                    .filter(|&l| matches!(state.forms[l], Form::Geometry(_)))
                    .all(|l| tree.levels[l].depth == first_branch(&tree));
                prop_assert!(geometry, "{}", state.describe(&tree));
            }
        }
        for (state, _) in states(&[Splines, Levels]) {
            prop_assert_eq!(quads(&tree, &state), 0, "{}", state.describe(&tree));
        }
        for (state, _) in states(&[Branches, Levels]) {
            prop_assert!(
                !matches!(trunk(&tree, &state), Form::Geometry(1..)),
                "{}", state.describe(&tree)
            );
        }
    }
}

/// What must hold between two neighbours of a chain.
fn falls(before: &ChainLod, after: &ChainLod) -> Result<(), TestCaseError> {
    prop_assert!(after.triangles.total() < before.triangles.total());
    prop_assert_ne!(&after.state, &before.state);
    prop_assert!(after.state.nowhere_richer_than(&before.state));
    prop_assert!(
        after.error_m > before.error_m,
        "errors {} and {}",
        before.error_m,
        after.error_m
    );
    prop_assert!(
        after.screen_size < before.screen_size,
        "screen sizes {} and {}",
        before.screen_size,
        after.screen_size
    );
    Ok(())
}

fn branch_levels(tree: &Tree) -> impl Iterator<Item = usize> + '_ {
    (0..tree.levels.len()).filter(|&l| tree.levels[l].kind == Kind::Branch)
}

fn first_branch(tree: &Tree) -> usize {
    branch_levels(tree)
        .map(|l| tree.levels[l].depth)
        .min()
        .expect("a tree has a branch")
}

fn trunk(tree: &Tree, state: &State) -> Form {
    state.forms[branch_levels(tree).next().expect("a tree has a branch")]
}

/// Levels that are drawn branch by branch as quads though they carry something.
fn quads(tree: &Tree, state: &State) -> usize {
    branch_levels(tree)
        .filter(|&l| tree.has_children(l) && state.forms[l] == Form::Quads)
        .count()
}

/// Rule 1: the level nearest the root takes spline LOD i, each further out one step coarser. Rule 2:
/// the last geometry level takes the coarsest.
fn spline_rules(tree: &Tree, lod: &Lod, state: &State) -> Result<(), String> {
    let coarsest = u8::try_from(lod.tolerances.len() - 1).expect("few");
    let first = first_branch(tree);
    let geometry: Vec<(usize, u8)> = branch_levels(tree)
        .filter_map(|l| match state.forms[l] {
            Form::Geometry(spline) => Some((tree.levels[l].depth - first, spline)),
            _ => None,
        })
        .collect();
    let Some(&(_, root)) = geometry.iter().find(|(out, _)| *out == 0) else {
        return Ok(());
    };
    let last = geometry.iter().map(|&(out, _)| out).max().unwrap_or(0);
    for &(out, spline) in &geometry {
        let expected = if out == last && out > 0 {
            coarsest
        } else {
            (root + u8::try_from(out).expect("few")).min(coarsest)
        };
        if spline != expected {
            return Err(format!("{}: {out} levels out", state.describe(tree)));
        }
    }
    Ok(())
}

/// Everything on a collapsed node is inside it, nothing else is; leaves are cards.
fn collapse_rules(tree: &Tree, state: &State) -> Result<(), String> {
    for (l, level) in tree.levels.iter().enumerate() {
        let closed = |&c: &usize| matches!(state.forms[c], Form::Collapsed | Form::Inside);
        let hidden = level.parent.is_some() && level.carriers.iter().all(closed);
        let fits = match state.forms[l] {
            Form::Inside => hidden,
            Form::Collapsed => !hidden && tree.has_children(l),
            Form::Quads => !hidden && level.kind == Kind::Branch,
            Form::Geometry(lod) => !hidden && (level.kind == Kind::Branch || lod == 0),
        };
        if !fits {
            return Err(format!("{:?} at {}", state.forms, level.name));
        }
    }
    Ok(())
}

#[test]
fn a_budget_between_two_forms_takes_the_richest_that_fits() {
    let tree = small().tree();
    let lod = Lod::default();
    let selector = Selector::new(&tree, &lod);
    for (state, triangles) in &descent(&tree, &lod)[1..] {
        let chain = selector.chain(&[triangles.total()], false);
        assert!(chain.lods[0].triangles.total() <= triangles.total());
        assert!(
            !chain.lods[0].state.nowhere_richer_than(state) || chain.lods[0].state == *state,
            "{} though {} fits",
            chain.lods[0].state.describe(&tree),
            state.describe(&tree)
        );
    }
}

#[test]
fn a_budget_that_repeats_gives_a_warning() {
    let tree = small().tree();
    let chain = Selector::new(&tree, &Lod::default()).chain(&[4, 4], false);
    assert_eq!(chain.lods.len(), 1);
    assert_eq!(chain.warnings, [Warning::BudgetWithoutLod { budget: 4 }]);
}

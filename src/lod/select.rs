//! The level-wide selector: from full detail down to one cross-quad, by priorities.
//!
//! Source: Koniaris, Gaitatzes, Papaioannou 2009, section IV.E. Simplifications are applied in an order
//! of priority until the triangle count is at or below the budget; the next budget starts from the
//! state before it and simplifies at least once. Its two rules: the level nearest the root takes spline
//! LOD i and each level further out one step coarser; the last geometry level, hidden in foliage, takes
//! the coarsest.
//!
//! Changes versus the paper: the order is spelled out as a ladder of states that depends on the tree and
//! the script alone. At each collapse depth, from the outermost branch level inward, the script's
//! priorities say whether splines are coarsened first or branches turned to quads first; then the next
//! level collapses and the splines of what is left may be fine again, as long as no level is drawn
//! richer than in the LOD before. The first state of the ladder that fits the budget is taken, so a LOD
//! never gives up a level that it could have kept.

use super::error::{FormErrors, screen_size};
use super::{Counts, Form, State, Triangles};
use crate::math::Similarity;
use crate::report::Warning;
use crate::species::schema::{Lod, Simplification};
use crate::tree::{Kind, Tree};

/// One LOD of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct ChainLod {
    /// Budget that it meets; `None` for full detail.
    pub budget: Option<u64>,
    /// The forms.
    pub state: State,
    /// Triangles of the state.
    pub triangles: Triangles,
    /// Geometric error, metres; rises along the chain.
    pub error_m: f32,
    /// Part of the picture's height up to which the LOD may be shown; falls along the chain.
    pub screen_size: f32,
}

/// LODs from the finest to the coarsest: triangles fall strictly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    /// The LODs.
    pub lods: Vec<ChainLod>,
    /// Budgets that got no LOD of their own, or one above the budget.
    pub warnings: Vec<Warning>,
}

/// The ladder of states of one tree, ready to answer for any budget.
#[derive(Clone, Debug)]
pub struct Selector {
    full: (State, Triangles),
    ladder: Vec<(State, Triangles)>,
    errors: FormErrors,
    height: f32,
}

impl Selector {
    /// Builds the ladder; microseconds to milliseconds, whatever the number of nodes.
    #[must_use]
    pub fn new(tree: &Tree, lod: &Lod) -> Self {
        let counts = Counts::of(tree, lod.tolerances.len());
        let with_count = |state: State| {
            let triangles = counts.triangles(tree, &state);
            (state, triangles)
        };
        let extents = tree.extents();
        let height = extents[0][0].bounds(&Similarity::IDENTITY).size().y;
        Self {
            full: with_count(State::full(tree)),
            ladder: ladder(tree, lod).into_iter().map(with_count).collect(),
            errors: FormErrors::of(tree, &extents, &lod.tolerances),
            height,
        }
    }

    /// Triangles at full detail.
    #[must_use]
    pub fn full_triangles(&self) -> u64 {
        self.full.1.total()
    }

    /// Triangles of the smallest form.
    #[must_use]
    pub fn smallest_triangles(&self) -> u64 {
        self.ladder
            .iter()
            .map(|(_, t)| t.total())
            .min()
            .unwrap_or(0)
    }

    /// The first state of the ladder within `budget` that is nowhere richer than `previous` and has
    /// fewer triangles. Costs one pass over the ladder.
    #[must_use]
    pub fn select(
        &self,
        previous: &(State, Triangles),
        budget: u64,
    ) -> Option<&(State, Triangles)> {
        self.ladder.iter().find(|(state, triangles)| {
            triangles.total() <= budget
                && triangles.total() < previous.1.total()
                && state.nowhere_richer_than(&previous.0)
        })
    }

    /// The chain for falling budgets, led by full detail if `with_full`.
    #[must_use]
    pub fn chain(&self, budgets: &[u64], with_full: bool) -> Chain {
        let mut chain = Chain::default();
        let mut previous = self.full.clone();
        if with_full {
            chain.lods.push(self.lod(None, &previous, &chain.lods));
        }
        for &budget in budgets {
            let fits_whole = chain.lods.is_empty() && self.full.1.total() <= budget;
            let found = if fits_whole {
                Some(&self.full)
            } else {
                self.select(&previous, budget)
            };
            match found {
                Some(found) => {
                    chain.lods.push(self.lod(Some(budget), found, &chain.lods));
                    previous = found.clone();
                }
                None => chain.warnings.push(self.missed(budget)),
            }
        }
        chain
    }

    fn missed(&self, budget: u64) -> Warning {
        let smallest = self
            .ladder
            .iter()
            .map(|(_, t)| t.total())
            .min()
            .unwrap_or(0);
        if smallest > budget {
            Warning::BudgetBelowSmallest { budget, smallest }
        } else {
            Warning::BudgetWithoutLod { budget }
        }
    }

    fn lod(&self, budget: Option<u64>, form: &(State, Triangles), before: &[ChainLod]) -> ChainLod {
        let (state, triangles) = form.clone();
        // Errors must rise along a chain, or a viewer would skip LODs.
        let floor = before.last().map_or(0.0, |l| l.error_m * 1.01);
        let error_m = self.errors.of_state(&state).max(floor);
        let ceiling = before.last().map_or(1.0, |l| l.screen_size * 0.99);
        let screen_size = screen_size(error_m, self.height).min(ceiling);
        ChainLod {
            budget,
            state,
            triangles,
            error_m,
            screen_size,
        }
    }
}

/// All states below full detail, in the order in which they are tried.
fn ladder(tree: &Tree, lod: &Lod) -> Vec<State> {
    let coarsest = u8::try_from(lod.tolerances.len().saturating_sub(1)).unwrap_or(u8::MAX);
    let has = |what: Simplification| lod.priorities.contains(&what);
    let rank = |what: Simplification| lod.priorities.iter().position(|&p| p == what);
    let splines_first = rank(Simplification::Splines) <= rank(Simplification::Branches);
    let deepest = tree
        .levels
        .iter()
        .filter(|l| l.kind == Kind::Branch)
        .map(|l| l.depth + 1)
        .max()
        .unwrap_or(0);
    let last_spline = if has(Simplification::Splines) {
        coarsest
    } else {
        0
    };
    let mut states = Vec::new();
    for depth in (0..=deepest).rev() {
        // The trunk as a quad is worth it only when nothing but the trunk is left as geometry.
        let most_quads = match (has(Simplification::Branches), depth) {
            (false, _) | (_, 0) => 0,
            (true, 1) => 1,
            (true, _) => depth - 1,
        };
        let mut push = |spline: u8, quads: usize| {
            states.push(state(
                tree,
                &Rung {
                    depth,
                    spline,
                    quads,
                    coarsest,
                },
            ));
        };
        if splines_first {
            (0..=last_spline).for_each(|spline| push(spline, 0));
            (1..=most_quads).for_each(|quads| push(last_spline, quads));
        } else {
            (0..=most_quads).for_each(|quads| push(0, quads));
            (1..=last_spline).for_each(|spline| push(spline, most_quads));
        }
    }
    states.dedup();
    states
}

/// One step of the ladder.
struct Rung {
    /// Branch levels at this depth or deeper are collapsed.
    depth: usize,
    /// Spline LOD of the level nearest the root.
    spline: u8,
    /// How many of the outermost geometry levels are quads.
    quads: usize,
    /// Coarsest spline LOD.
    coarsest: u8,
}

fn state(tree: &Tree, rung: &Rung) -> State {
    let first_branch = tree
        .levels
        .iter()
        .filter(|l| l.kind == Kind::Branch)
        .map(|l| l.depth)
        .min()
        .unwrap_or(0);
    // The outermost level that is still geometry, all branch levels counted.
    let last_geometry = (rung.depth.saturating_sub(rung.quads)).checked_sub(1);
    let mut forms: Vec<Form> = Vec::with_capacity(tree.levels.len());
    for (index, level) in tree.levels.iter().enumerate() {
        let closed = |&c: &usize| matches!(forms[c], Form::Collapsed | Form::Inside);
        let hidden = !level.carriers.is_empty() && level.carriers.iter().all(closed);
        let form = if hidden {
            Form::Inside
        } else if level.kind == Kind::Leaf {
            Form::Geometry(0)
        } else if level.depth >= rung.depth {
            // A branch that carries nothing is its own sub-tree: its single-branch quads do.
            if tree.has_children(index) {
                Form::Collapsed
            } else {
                Form::Quads
            }
        } else if level.kind == Kind::Stool {
            Form::Geometry(0)
        } else if Some(level.depth) > last_geometry {
            Form::Quads
        } else if Some(level.depth) == last_geometry && level.depth > first_branch {
            Form::Geometry(rung.coarsest)
        } else {
            let out = u8::try_from(level.depth - first_branch).unwrap_or(u8::MAX);
            Form::Geometry(rung.spline.saturating_add(out).min(rung.coarsest))
        };
        forms.push(form);
    }
    State { forms }
}

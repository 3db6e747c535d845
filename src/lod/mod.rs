//! LOD states: in which form each level is drawn, how many triangles that makes, and how far it strays.
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, section IV.E (LOD information generation). A state's
//! triangle count is a closed form over the graph: nodes of a prototype times the triangles of its form.
//! Knows forms, not their geometry.

pub mod cut;
mod error;
mod select;

pub use error::{SWITCH_PIXELS, ScreenSizes, screen_size};
pub use select::{Chain, ChainLod, Selector};

use crate::tree::{Kind, Part, Tree};

/// Triangles of two crossed quads.
pub const CROSS_QUAD_TRIANGLES: u64 = 4;

/// In which form the nodes of one level are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Form {
    /// Geometry: tubes of the given spline LOD (0 the finest), leaf cards, or a stool's nothing.
    Geometry(u8),
    /// Each branch alone as two crossed quads; what grows on it is drawn by its own form.
    Quads,
    /// Each node, with all that grows on it, as two crossed quads.
    Collapsed,
    /// Not drawn: part of a collapsed node above.
    Inside,
}

/// One LOD state: a form for each level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// By level of the tree.
    pub forms: Vec<Form>,
}

impl State {
    /// Every level at its finest.
    #[must_use]
    pub fn full(tree: &Tree) -> Self {
        Self {
            forms: vec![Form::Geometry(0); tree.levels.len()],
        }
    }

    /// True if no level is drawn in a richer form than in `other`.
    #[must_use]
    pub fn nowhere_richer_than(&self, other: &Self) -> bool {
        self.forms
            .iter()
            .zip(&other.forms)
            .all(|(mine, theirs)| mine >= theirs)
    }

    /// True if what grows on a level's nodes is drawn.
    #[must_use]
    pub fn is_open(&self, level: usize) -> bool {
        matches!(self.forms[level], Form::Geometry(_) | Form::Quads)
    }

    /// A short text such as `trunk:spline1 limbs:quads twigs:cross-quads`.
    #[must_use]
    pub fn describe(&self, tree: &Tree) -> String {
        let parts = tree
            .levels
            .iter()
            .zip(&self.forms)
            .filter_map(|(level, form)| {
                let word = match (form, level.kind) {
                    (Form::Inside, _) | (Form::Geometry(_), Kind::Stool) => return None,
                    (Form::Geometry(_), Kind::Leaf) => "cards".to_owned(),
                    (Form::Geometry(lod), Kind::Branch) => format!("spline{lod}"),
                    (Form::Quads, _) => "quads".to_owned(),
                    (Form::Collapsed, _) => "cross-quads".to_owned(),
                };
                Some(format!("{}:{word}", level.name))
            });
        parts.collect::<Vec<_>>().join(" ")
    }
}

/// Triangle counts of states, from numbers gathered once per tree.
#[derive(Clone, Debug)]
pub struct Counts {
    /// By level, geometry LOD and prototype: triangles.
    geometry: Vec<Vec<Vec<u64>>>,
}

/// Triangles of a state, by material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Triangles {
    /// Opaque branch geometry.
    pub branches: u64,
    /// Textured cards and quads.
    pub foliage: u64,
}

impl Triangles {
    /// Both materials.
    #[must_use]
    pub fn total(self) -> u64 {
        self.branches + self.foliage
    }
}

impl Counts {
    /// Gathers the triangle counts of every branch LOD.
    #[must_use]
    pub fn of(tree: &Tree, spline_lods: usize) -> Self {
        let geometry = tree.levels.iter().map(|level| {
            let of_lod = |lod: usize| {
                let prototypes = level.prototypes.iter();
                prototypes.map(|p| triangles(&p.part, lod)).collect()
            };
            (0..spline_lods.max(1)).map(of_lod).collect()
        });
        Self {
            geometry: geometry.collect(),
        }
    }

    /// Triangles of a state.
    #[must_use]
    pub fn triangles(&self, tree: &Tree, state: &State) -> Triangles {
        let mut sum = Triangles::default();
        // Nodes of one level may hang on open and on closed ones.
        let seen = tree.nodes_where(|level| state.is_open(level));
        for (level, (form, nodes)) in state.forms.iter().zip(&seen).enumerate() {
            match form {
                Form::Geometry(lod) => {
                    let lods = &self.geometry[level];
                    let each = &lods[(*lod as usize).min(lods.len() - 1)];
                    let count: u64 = each.iter().zip(nodes).map(|(t, n)| t * n).sum();
                    match tree.levels[level].kind {
                        Kind::Leaf => sum.foliage += count,
                        Kind::Branch | Kind::Stool => sum.branches += count,
                    }
                }
                Form::Quads | Form::Collapsed => {
                    sum.foliage += CROSS_QUAD_TRIANGLES * nodes.iter().sum::<u64>();
                }
                Form::Inside => {}
            }
        }
        sum
    }
}

fn triangles(part: &Part, lod: usize) -> u64 {
    match part {
        Part::Branch(branch) => branch.triangles(lod),
        Part::Stool | Part::Leaf { .. } => part.full_triangles(),
    }
}

//! The tree as a graph: prototypes and links, not nodes.
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, sections III, IV.C and VI.A (self-similar hierarchy,
//! constrained randomisation). A node of a level, with all that grows on it, is the same sub-tree as
//! every other node of that level and variant, up to a [`Similarity`]. So a tree is one short list of
//! [`Prototype`]s a level, and memory is the sum of their links, whatever the number of nodes.
//!
//! Changes versus the paper: a level may have several prototypes (`variants`); levels form a tree of
//! levels, so that roots and limbs can share a trunk; stems of a multi-stemmed tree hang on a level
//! that has no part of its own; `tropism` turns nodes rigidly when they are placed (see
//! [`Tree::place`] for what that does to sharing).

mod branch;
mod count;
pub mod flex;
mod grow;
mod growth;
mod hosts;
mod limits;
mod links;
mod pipes;

pub use branch::{AxisSample, Branch};
pub use count::{Extent, SubtreeCounts};
pub use grow::{GrowError, grow};
pub use limits::Limits;

use crate::math::{Quat, Similarity, Vec3};

/// A grown tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Levels in script order (after the stool of a multi-stemmed tree); parents come first.
    pub levels: Vec<TreeLevel>,
    /// Seed it was grown from.
    pub seed: u64,
}

/// All prototypes of one branching level.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeLevel {
    /// Name from the script; the stool of a multi-stemmed tree is called `stool`.
    pub name: String,
    /// The level that carries this one; `None` for the first.
    pub parent: Option<usize>,
    /// All levels that carry it: `parent`, and those on which places skip levels (`skip` of a script).
    pub carriers: Vec<usize>,
    /// Levels from the first (0).
    pub depth: usize,
    /// What its nodes are.
    pub kind: Kind,
    /// Rigid turn of nodes when placed, -1 (straight down) ..= 1 (straight up).
    pub tropism: f32,
    /// At least one; leaf levels have one a leaf kind.
    pub prototypes: Vec<Prototype>,
}

/// What the nodes of a level are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing but links: the stool of a multi-stemmed tree.
    Stool,
    /// Branches.
    Branch,
    /// Leaf cards.
    Leaf,
}

/// The sub-tree that all nodes of one level and variant share, in its own frame: base at the origin,
/// growing along +Y.
#[derive(Clone, Debug, PartialEq)]
pub struct Prototype {
    /// What it is by itself.
    pub part: Part,
    /// What grows on it, by level, then position along it.
    pub links: Vec<Link>,
}

/// A prototype's own part.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// Nothing (a stool).
    Stool,
    /// A tapered tube along a curve.
    Branch(Branch),
    /// A textured card.
    Leaf {
        /// Index into the species' leaf kinds.
        kind: u16,
        /// Card length along +Y, metres.
        length: f32,
        /// Card width along X, metres.
        width: f32,
        /// Fold of each half, radians.
        fold: f32,
    },
}

/// One child of a prototype.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Level it leads to.
    pub level: u16,
    /// Prototype of that level.
    pub prototype: u16,
    /// Position along the parent, 0..=1 of its arc length.
    pub at: f32,
    /// Factor on the child's own tube radius, on top of the scale. Not inherited by what grows on it.
    pub thickness: f32,
    /// The child's frame in the parent's.
    pub place: Similarity,
}

impl Tree {
    /// One prototype.
    #[must_use]
    pub fn prototype(&self, level: usize, prototype: usize) -> &Prototype {
        &self.levels[level].prototypes[prototype]
    }

    /// The frame of the child at `link` of a node whose frame in the world is `node`.
    ///
    /// Where the child's level has a `tropism`, the child is turned about its base toward up or down.
    /// A rigid turn leaves all that grows on the child as it was, so sub-trees *at and below* the
    /// turned level stay identical and sharing there is exact. Sub-trees of levels *above* it differ
    /// from node to node by how their children turned; their captures show one representative.
    #[must_use]
    pub fn place(&self, node: &Similarity, link: &Link) -> Similarity {
        let mut place = node.then_inner(&link.place);
        let tropism = self.levels[link.level as usize].tropism;
        if tropism != 0.0 {
            place.rotation =
                (tropic_turn(place.rotation * Vec3::Y, tropism) * place.rotation).normalize();
        }
        place
    }

    /// True if some level at or below `level` turns its nodes when they are placed there.
    #[must_use]
    pub fn turns_below(&self, level: usize) -> bool {
        (0..self.levels.len())
            .any(|l| self.levels[l].tropism != 0.0 && l != level && self.is_below(l, level))
    }

    /// True if `level` is `ancestor` or hangs on it.
    #[must_use]
    pub fn is_below(&self, level: usize, ancestor: usize) -> bool {
        let mut at = Some(level);
        while let Some(l) = at {
            if l == ancestor {
                return true;
            }
            at = self.levels[l].parent;
        }
        false
    }

    /// True if something grows on the nodes of a level.
    #[must_use]
    pub fn has_children(&self, level: usize) -> bool {
        self.levels.iter().any(|l| l.parent == Some(level))
    }

    /// Bytes held by the graph: what a tree costs, whatever its number of nodes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let prototype = |p: &Prototype| {
            let part = match &p.part {
                Part::Branch(branch) => branch.bytes(),
                Part::Stool | Part::Leaf { .. } => 0,
            };
            size_of::<Prototype>() + part + p.links.len() * size_of::<Link>()
        };
        self.levels
            .iter()
            .map(|l| size_of::<TreeLevel>() + l.prototypes.iter().map(prototype).sum::<usize>())
            .sum()
    }
}

/// The turn that takes a unit `direction` part of the way to straight up (`tropism` 1) or down (-1).
///
/// The turned angle is `|tropism|` times the angle still to go, so nothing overshoots. A direction
/// that points exactly the opposite way has no preferred side and is left alone.
#[must_use]
pub fn tropic_turn(direction: Vec3, tropism: f32) -> Quat {
    let goal = if tropism > 0.0 { Vec3::Y } else { Vec3::NEG_Y };
    let axis = direction.cross(goal);
    let sine = axis.length();
    if sine < 1e-6 {
        return Quat::IDENTITY;
    }
    let angle = libm::atan2f(sine, direction.dot(goal));
    Quat::from_axis_angle(axis / sine, angle * tropism.abs().min(1.0))
}

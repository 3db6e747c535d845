//! Which captures a tree needs.
//!
//! Source: Koniaris, Gaitatzes, Papaioannou 2009, section IV.D: a tree of n levels with k branch types
//! needs (n - 1 + k) * 2 renderings: every branch level's node with all below it, and every branch type
//! alone, each from two perpendicular sides.
//!
//! Changes versus the paper: with `variants`, each prototype is captured; a branch level that carries
//! nothing (roots, say) is its own sub-tree and has no combined capture.

use crate::impostor::planes::Plane;
use crate::tree::{Branch, Kind, Part, Tree};

/// What one pair of captures shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A prototype with all that grows on it.
    Combined {
        /// Level of the tree.
        level: usize,
        /// Prototype of the level.
        prototype: usize,
    },
    /// A branch by itself, shown by one prototype that has its shape.
    Branch {
        /// Level of the tree.
        level: usize,
        /// Prototype of the level.
        prototype: usize,
    },
}

/// The captures of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Pairs of captures: combined levels from the root outward, then branch types.
    pub subjects: Vec<Subject>,
    /// By level and prototype: the subject that shows its branch type, and the factor from the captured
    /// prototype's size to its own.
    pub branch_types: Vec<Vec<Option<(usize, f32)>>>,
    /// By level and prototype: turn of its combined captures about +Y, radians; 0 looks along the axes.
    pub turns: Vec<Vec<f32>>,
    /// Sets of planes that are captured beside the crossed quads.
    pub sets: Vec<PlaneSet>,
    /// By subject: true if no LOD shows it, so that few texels are enough.
    pub small: Vec<bool>,
}

/// Planes that show a prototype with all that grows on it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSet {
    /// Level of the tree.
    pub level: usize,
    /// Prototype of the level.
    pub prototype: usize,
    /// The planes in the prototype's frame; their members count the items of the mesh that captures are
    /// drawn from ([`crate::impostor::planes::items`]).
    pub planes: Vec<Plane>,
    /// True if the planes are in the frame of the straightened prototype
    /// ([`crate::impostor::planes::strips`]).
    pub straightened: bool,
}

/// Two views a subject.
pub const VIEWS: usize = 2;

impl Plan {
    /// Lists the captures of a tree.
    #[must_use]
    pub fn of(tree: &Tree) -> Self {
        let mut subjects = Vec::new();
        for (level, shared) in tree.levels.iter().enumerate() {
            if shared.kind != Kind::Leaf && tree.has_children(level) {
                let prototypes = 0..shared.prototypes.len();
                subjects.extend(prototypes.map(|prototype| Subject::Combined { level, prototype }));
            }
        }
        let mut branch_types: Vec<Vec<Option<(usize, f32)>>> = tree
            .levels
            .iter()
            .map(|l| vec![None; l.prototypes.len()])
            .collect();
        let mut known: Vec<(usize, &Branch)> = Vec::new();
        for (level, shared) in tree.levels.iter().enumerate() {
            for (prototype, node) in shared.prototypes.iter().enumerate() {
                let Part::Branch(branch) = &node.part else {
                    continue;
                };
                let same = known.iter().find(|(_, other)| same_shape(branch, other));
                branch_types[level][prototype] = Some(match same {
                    Some(&(subject, other)) => (subject, branch.length / other.length),
                    None => {
                        known.push((subjects.len(), branch));
                        subjects.push(Subject::Branch { level, prototype });
                        (subjects.len() - 1, 1.0)
                    }
                });
            }
        }
        let turns = tree.levels.iter().map(|l| vec![0.0; l.prototypes.len()]);
        Self {
            small: vec![false; subjects.len()],
            subjects,
            branch_types,
            turns: turns.collect(),
            sets: Vec::new(),
        }
    }

    /// Number of renderings: (n - 1 + k) * 2 for a plain chain of n levels.
    #[must_use]
    pub fn captures(&self) -> usize {
        self.subjects.len() * VIEWS
    }

    /// Number of renderings for sets of planes, on top of [`Plan::captures`].
    #[must_use]
    pub fn plane_captures(&self) -> usize {
        self.sets.iter().map(|s| s.planes.len()).sum()
    }

    /// Index of the pair that shows a whole sub-tree.
    #[must_use]
    pub fn combined(&self, level: usize, prototype: usize) -> Option<usize> {
        self.subjects
            .iter()
            .position(|&s| s == Subject::Combined { level, prototype })
    }
}

/// True if two branches differ by a uniform scale only, to a thousandth of their length.
fn same_shape(a: &Branch, b: &Branch) -> bool {
    // Where there are no lobes, their phase is drawn all the same, and means nothing.
    let round = |b: &Branch| b.lobes.flutes.1 == 0.0 && b.lobes.buttresses.1 == 0.0;
    let same_section = a.lobes == b.lobes || (round(a) && round(b));
    if a.spline != b.spline || !same_section || a.axis.len() != b.axis.len() {
        return false;
    }
    let scale = a.length / b.length;
    let near = 1e-3 * a.length;
    a.axis.iter().zip(&b.axis).all(|(p, q)| {
        p.position.distance(q.position * scale) < near && (p.radius - q.radius * scale).abs() < near
    })
}

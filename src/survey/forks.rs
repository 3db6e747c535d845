//! How cross-sections are kept at forks (Leonardo's rule, the pipe model).
//!
//! A fork is a place of a branch at which other branches leave it. As in a survey by laser, each internode,
//! the piece between two forks, has one radius, that at its middle; a branch that leaves has its radius at the
//! base, without the collar. The ratio is (what goes on, squared, and all that leave, squared) over (what
//! comes, squared). Nodes are not walked: a branch's radii follow from its prototype and from the thickness
//! with which a link places it.

use crate::tree::{Branch, Link, Part, Prototype, Tree};

/// Branches that leave nearer to each other than this part of the length leave at one fork: a pair, a whorl.
const SAME_PLACE: f32 = 1e-4;

/// What is left of a branch beyond its last fork must be this part of its length to go on.
const TIP: f32 = 0.004;

/// The ratio of each fork, and how often it occurs in the tree.
#[must_use]
pub fn ratios(tree: &Tree) -> Vec<(f32, u64)> {
    let nodes = tree.nodes();
    let mut ratios = Vec::new();
    let mut add = |level: usize, prototype: usize, thickness: f32, count: u64| {
        if count > 0 {
            let forks = of_branch(tree, tree.prototype(level, prototype), thickness);
            ratios.extend(forks.into_iter().map(|ratio| (ratio, count)));
        }
    };
    if !tree.levels.is_empty() {
        add(0, 0, 1.0, 1);
    }
    for (level, counts) in tree.levels.iter().zip(&nodes) {
        for (prototype, &count) in level.prototypes.iter().zip(counts) {
            for link in &prototype.links {
                add(
                    usize::from(link.level),
                    usize::from(link.prototype),
                    link.thickness,
                    count,
                );
            }
        }
    }
    ratios
}

/// Part of the forks whose ratio is within `low..=high`; `None` without forks.
#[must_use]
#[expect(clippy::cast_precision_loss, reason = "a part needs no more digits")]
#[expect(clippy::cast_possible_truncation, reason = "a part of one")]
pub fn part_within(ratios: &[(f32, u64)], low: f32, high: f32) -> Option<f32> {
    let total: u64 = ratios.iter().map(|r| r.1).sum();
    let within = ratios.iter().filter(|r| (low..=high).contains(&r.0));
    let within: u64 = within.map(|r| r.1).sum();
    (total > 0).then(|| (within as f64 / total as f64) as f32)
}

/// The forks of one branch, from its base to its tip.
fn of_branch(tree: &Tree, prototype: &Prototype, thickness: f32) -> Vec<f32> {
    let Part::Branch(branch) = &prototype.part else {
        return Vec::new();
    };
    let forks = places(tree, prototype);
    let mut ratios = Vec::with_capacity(forks.len());
    let mut base = 0.0;
    for (index, (at, leaving)) in forks.iter().enumerate() {
        let before = internode(branch, base, *at) * thickness;
        let after = match forks.get(index + 1) {
            Some((next, _)) => internode(branch, *at, *next) * thickness,
            None if 1.0 - at > TIP => internode(branch, *at, 1.0) * thickness,
            None => 0.0,
        };
        base = *at;
        if before > 0.0 {
            ratios.push((after * after + leaving) / (before * before));
        }
    }
    ratios
}

/// Radius in the middle of an internode. Before a fork at the very foot, it is the foot's.
fn internode(branch: &Branch, from: f32, to: f32) -> f32 {
    if to < SAME_PLACE {
        branch.radius
    } else {
        branch.at((from + to) * 0.5).radius
    }
}

/// Places at which branches leave, rising, with the sum of the squared radii of those that do.
fn places(tree: &Tree, prototype: &Prototype) -> Vec<(f32, f32)> {
    let mut leaving: Vec<(f32, f32)> = prototype
        .links
        .iter()
        .filter_map(|link| Some((link.at, radius(tree, link)?)))
        .collect();
    leaving.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut places: Vec<(f32, f32)> = Vec::new();
    for (at, radius) in leaving {
        match places.last_mut() {
            Some(place) if at - place.0 < SAME_PLACE => place.1 += radius * radius,
            _ => places.push((at, radius * radius)),
        }
    }
    places
}

/// Base radius of the branch that a link leads to, in its parent's frame; `None` for leaves.
fn radius(tree: &Tree, link: &Link) -> Option<f32> {
    match &tree
        .prototype(usize::from(link.level), usize::from(link.prototype))
        .part
    {
        Part::Branch(branch) => Some(branch.radius * link.place.scale * link.thickness),
        Part::Stool | Part::Leaf { .. } => None,
    }
}

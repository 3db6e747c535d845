//! A tree as lines: what is drawn where a mesh would be too much.

use crate::math::{Similarity, Vec3};
use crate::tree::{Part, Tree};
use std::collections::VecDeque;

/// A node as a line.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    /// Its level in the tree.
    pub(super) level: usize,
    /// From its base to its tip, metres.
    pub(super) points: Vec<Vec3>,
}

/// Points of a branch's axis from one kept to the next.
const STRIDE: usize = 4;

/// The nodes of a tree as lines, levels near the trunk first, at most so many.
pub(super) fn lines(tree: &Tree, most: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut next = VecDeque::from([(0, 0, Similarity::IDENTITY)]);
    while let Some((level, prototype, node)) = next.pop_front() {
        let shared = tree.prototype(level, prototype);
        let points: Vec<Vec3> = match &shared.part {
            Part::Stool => Vec::new(),
            Part::Branch(branch) => {
                let last = branch.axis.len().saturating_sub(1);
                let kept = |at: &usize| at.is_multiple_of(STRIDE) || *at == last;
                let samples = (0..=last).filter(kept);
                samples
                    .map(|at| node.point(branch.axis[at].position))
                    .collect()
            }
            Part::Leaf { length, .. } => [0.0, *length].map(|y| node.point(Vec3::Y * y)).to_vec(),
        };
        if points.len() > 1 {
            lines.push(Line { level, points });
        }
        for link in &shared.links {
            if lines.len() + next.len() >= most {
                break;
            }
            let place = tree.place(&node, link);
            next.push_back((link.level.into(), link.prototype.into(), place));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, NoFiles};
    use crate::studio::templates::BLANK;
    use crate::tree::{Limits, grow};

    #[test]
    fn lines_start_at_the_ground_and_on_their_parents() {
        let species = species::parse("blank", BLANK, &NoFiles).unwrap();
        let tree = grow(&species, 1, &Limits::default()).unwrap();
        let all = lines(&tree, usize::MAX);
        let nodes: u64 = tree.nodes().iter().flatten().sum();
        assert_eq!(all.len() as u64, nodes);
        assert_eq!((all[0].level, all[0].points[0]), (0, Vec3::ZERO));
        let trunk = &all[0].points;
        for limb in all.iter().filter(|l| l.level == 1) {
            let near = trunk.windows(2).map(|pair| {
                let along = pair[1] - pair[0];
                let part = (limb.points[0] - pair[0]).dot(along) / along.length_squared();
                (pair[0] + along * part.clamp(0.0, 1.0)).distance(limb.points[0])
            });
            let near = near.fold(f32::MAX, f32::min);
            assert!(near < 0.1, "{near}");
        }
        let some = lines(&tree, 30);
        assert_eq!(some[..], all[..some.len()]);
        assert!((20..=30).contains(&some.len()), "{}", some.len());
    }
}

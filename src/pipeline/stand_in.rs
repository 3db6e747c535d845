//! A tree in few triangles, made in no time, that stands in for full detail while something moves: coarse tubes, and
//! fewer leaves and twigs, with each leaf as much larger.
//!
//! Nothing is measured, and branches keep their places, so that a hand sees what it does. Not a LOD: what is left out
//! is left out evenly, and seen when the picture rests.

use crate::lod::{Counts, Form, State};
use crate::tree::{Kind, Tree};

/// Triangles of what stands in for a sketch, falling. A software driver draws so many in time on two cores.
pub(super) const STAND_INS: [u64; 2] = [16_000, 5_000];

/// Largest factor on the length of a leaf: beyond it a crown would be a few balloons.
const LARGEST: f32 = 3.0;

/// The part of the triangles that leaves keep at least, before twigs are left out.
const LEAVES: f64 = 0.5;

/// A thinner tree, and the state in which it has at most about `most` triangles. It has the levels and prototypes of
/// the tree, with fewer links.
pub(super) fn thinned(tree: &Tree, splines: usize, most: u64) -> (Tree, State) {
    let coarsest = u8::try_from(splines.saturating_sub(1)).unwrap_or(u8::MAX);
    let form = |kind: Kind| Form::Geometry(if kind == Kind::Branch { coarsest } else { 0 });
    let state = State {
        forms: tree.levels.iter().map(|level| form(level.kind)).collect(),
    };
    let mut thin = tree.clone();
    let leaves = |tree: &Tree| -> u64 {
        let nodes = tree.nodes();
        let levels = tree.levels.iter().zip(&nodes);
        let of_leaves = levels.filter(|(level, _)| level.kind == Kind::Leaf);
        of_leaves.flat_map(|(_, nodes)| nodes).sum()
    };
    let before = leaves(tree);
    // Twice, as every branch keeps one of each at least, and so a step may leave out less than its share.
    #[expect(clippy::cast_precision_loss, reason = "a share needs few digits")]
    for (step, levels) in steps(tree).into_iter().chain(steps(tree)) {
        let now = Counts::of(&thin, splines).triangles(&thin, &state);
        if now.total() <= most {
            break;
        }
        let most = most as f64;
        let share = if step == 0 {
            (most - now.branches as f64).max(most * LEAVES) / now.foliage.max(1) as f64
        } else {
            most / now.total() as f64
        };
        thin_out(&mut thin, &levels, share);
    }
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "a factor needs few digits"
    )]
    let factor = (before as f64 / leaves(&thin).max(1) as f64).sqrt() as f32;
    enlarge(&mut thin, factor.min(LARGEST));
    (thin, state)
}

/// The steps of thinning out, with the levels of each: all leaves at step 0, then branches from the outermost inward,
/// but for those whose absence would be seen.
fn steps(tree: &Tree) -> Vec<(usize, Vec<usize>)> {
    (0..)
        .map_while(|step| Some((step, outermost(tree, step)?)))
        .collect()
}

fn outermost(tree: &Tree, step: usize) -> Option<Vec<usize>> {
    let of = |kind: Kind| {
        let levels = tree.levels.iter().enumerate();
        levels.filter(move |(_, level)| level.kind == kind)
    };
    if step == 0 {
        return Some(of(Kind::Leaf).map(|(index, _)| index).collect());
    }
    let first = of(Kind::Branch).map(|(_, level)| level.depth).min()?;
    let last = of(Kind::Branch).map(|(_, level)| level.depth).max()?;
    let depth = (last + 1).checked_sub(step).filter(|&d| d > first + 1)?;
    let levels = of(Kind::Branch).filter(|(_, level)| level.depth == depth);
    Some(levels.map(|(index, _)| index).collect())
}

/// Leaves so large a share of the links to some levels, on each prototype evenly, and one at least.
fn thin_out(tree: &mut Tree, levels: &[usize], share: f64) {
    for prototype in tree.levels.iter_mut().flat_map(|l| &mut l.prototypes) {
        for &level in levels {
            let is_it = |link: &crate::tree::Link| usize::from(link.level) == level;
            let all = prototype.links.iter().filter(|link| is_it(link)).count();
            #[expect(
                clippy::cast_precision_loss,
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 0 and the number of links"
            )]
            let kept = ((all as f64 * share.clamp(0.0, 1.0)).round() as usize).max(1);
            let mut index = 0;
            prototype.links.retain(|link| {
                if !is_it(link) {
                    return true;
                }
                index += 1;
                index * kept / all > (index - 1) * kept / all
            });
        }
    }
}

fn enlarge(tree: &mut Tree, factor: f32) {
    let is_leaf: Vec<bool> = tree.levels.iter().map(|l| l.kind == Kind::Leaf).collect();
    let prototypes = tree.levels.iter_mut().flat_map(|l| &mut l.prototypes);
    for link in prototypes.flat_map(|p| &mut p.links) {
        if is_leaf[usize::from(link.level)] {
            link.place.scale *= factor;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, NoFiles};
    use crate::tree::{Limits, grow};

    #[test]
    fn presets_are_thinned_to_about_as_many_triangles_and_keep_their_limbs_and_leaf_area() {
        for (text, name) in [
            (include_str!("../../species/olive.ron"), "olive"),
            (include_str!("../../species/english_oak.ron"), "oak"),
        ] {
            let species = species::parse(name, text, &NoFiles).expect("a sound script");
            let tree = grow(&species, 1, &Limits::default()).expect("it grows");
            let splines = species.lod.tolerances.len();
            for most in STAND_INS {
                let (thin, state) = thinned(&tree, splines, most);
                let now = Counts::of(&thin, splines).triangles(&thin, &state).total();
                assert!(now <= most * 3 / 2, "{name}: {now} of {most}");
                assert!(now * 4 >= most, "{name}: {now} of {most}");
                let [own, all] = [&thin, &tree].map(Tree::nodes);
                assert_eq!(own[..2], all[..2], "{name}: trunk and limbs");
            }
            let (same, _) = thinned(&tree, splines, u64::MAX);
            assert_eq!(same, tree);
        }
    }
}

//! Rivals: other ways to bring a full tree under a triangle budget, against which our LODs are judged.
//!
//! [`random`] is always there: a LOD that loses to leaves left out by chance is of no use. The rest is what
//! a user has without us, built with the feature `rivals`: the general mesh simplifier that most engines
//! ship, and the script of an afternoon on top of it. Each gets the full tree's flattened mesh and gives one
//! mesh; none of them makes or needs a texture of its own.

mod parts;
#[cfg(feature = "rivals")]
mod script;
#[cfg(feature = "rivals")]
mod simplify;
mod trivial;

#[cfg(feature = "rivals")]
pub use script::script;
pub use trivial::{leaf_scale, leaves, random};

#[cfg(feature = "rivals")]
use crate::mesh::Mesh;

/// One rival at one budget.
#[cfg(feature = "rivals")]
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// `simplify`, `simplify_prune_permissive`, `simplify_sloppy` or `script`.
    pub name: &'static str,
    /// How it was made, in words.
    pub settings: &'static str,
    /// What it made. More triangles than the budget if it was stuck above it.
    pub mesh: Mesh,
}

/// Every rival but [`random`], which wants a seed and a scale, at a budget of so many triangles.
///
/// A budget that the full mesh meets gives the full mesh. A rival that cannot go as low as the budget has
/// more triangles; which ones can depends on the mesh, so count them.
#[cfg(feature = "rivals")]
#[must_use]
pub fn all(full: &Mesh, budget: u64) -> Vec<Rival> {
    let rival = |name, settings, mesh| Rival {
        name,
        settings,
        mesh,
    };
    vec![
        rival(
            "simplify",
            "meshoptimizer simplify on bark and leaves in one index buffer; no options, error unbounded",
            simplify::plain(full, budget),
        ),
        rival(
            "simplify_prune_permissive",
            "meshoptimizer simplify on bark and leaves in one index buffer; Prune and Permissive, error \
             unbounded",
            simplify::prune_permissive(full, budget),
        ),
        rival(
            "simplify_sloppy",
            "meshoptimizer simplifySloppy on bark and leaves in one index buffer, error unbounded; \
             triangles between bark and leaf left out, those between different leaves kept; target raised \
             until the rest fills the budget",
            simplify::sloppy(full, budget),
        ),
        rival(
            "script",
            "bark by meshoptimizer simplify (Prune and Permissive) to its share of the triangles; leaves \
             thinned evenly and scaled by sqrt(all / kept) about their centres",
            script(full, budget, None),
        ),
    ]
}

#[cfg(test)]
mod samples;

#[cfg(all(test, feature = "rivals"))]
mod tests {
    use super::samples::olive;
    use super::*;
    use crate::mesh::check;

    #[test]
    fn all_rivals_keep_to_the_papers_budgets_on_the_olive() {
        for budget in [10_640, 836, 248] {
            let rivals = all(olive(), budget);
            let names: Vec<&str> = rivals.iter().map(|rival| rival.name).collect();
            let expected = [
                "simplify",
                "simplify_prune_permissive",
                "simplify_sloppy",
                "script",
            ];
            assert_eq!(names, expected);
            for rival in &rivals {
                check::mesh(&rival.mesh).unwrap_or_else(|f| panic!("{}: {f}", rival.name));
                let triangles = rival.mesh.triangles();
                // Each limb and branch is a tube of its own, which meshoptimizer by itself makes no
                // smaller than a few triangles.
                let stuck = rival.name == "simplify" && budget == 248 && triangles <= 340;
                assert!(stuck || triangles <= budget, "{}: {triangles}", rival.name);
                assert!(triangles > budget * 4 / 5, "{}: {triangles}", rival.name);
            }
            assert!(rivals == all(olive(), budget));
        }
    }

    #[test]
    fn no_rival_minds_an_empty_mesh() {
        for budget in [0, 4, u64::MAX] {
            for rival in all(&Mesh::default(), budget) {
                assert_eq!(rival.mesh, Mesh::default(), "{}", rival.name);
            }
        }
    }
}

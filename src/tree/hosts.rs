//! Which branches carry a level: those of its parent, and those further down on which places skip levels.
//!
//! Branches of one axis differ: near a young tip they have not branched as often as at the base, and where an axis
//! is strongest near its end, those further in have stayed small (physiological age, acrotony; Barthélémy and
//! Caraglio 2007). A place that skips a level carries a node of the level after it at once. The node is of the
//! same prototypes as all others of its level, so sharing stays whole, and an axis with many branches still falls
//! into streams of few (Strahler's ratio).

use crate::species::schema::{LevelKind, Species};

/// Branches that carry a level, and the places on them at which they do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Host {
    /// Script level of the branches.
    pub(super) level: usize,
    /// Script level whose places these are; the level itself on its own parent.
    pub(super) places: usize,
    /// How many levels those places skip.
    pub(super) skip: u32,
}

/// All that carry a level: its parent first, then further and further toward the trunk. The trunk has none.
pub(super) fn hosts(species: &Species, level: usize) -> Vec<Host> {
    let mut hosts = Vec::new();
    let (mut places, mut skip) = (level, 0);
    while let Some(parent) = species.levels[places].parent {
        hosts.push(Host {
            level: parent,
            places,
            skip,
        });
        if after(species, parent) != Some(places) {
            break;
        }
        (places, skip) = (parent, skip + 1);
    }
    hosts
}

/// The level that a place of a level carries instead if it skips it: the first of branches that grow on it.
fn after(species: &Species, level: usize) -> Option<usize> {
    species
        .levels
        .iter()
        .position(|l| l.parent == Some(level) && matches!(l.kind, LevelKind::Branch(_)))
}

/// How many levels there are to skip for the places of a level: no place skips more.
fn most(species: &Species, level: usize) -> u32 {
    let mut at = level;
    let mut most = 0;
    while let Some(next) = after(species, at) {
        (at, most) = (next, most + 1);
    }
    most
}

/// The places of a host, by index.
pub(super) fn places(species: &Species, host: Host) -> impl Iterator<Item = u32> + '_ {
    let placement = &species.levels[host.places].placement;
    let most = most(species, host.places);
    (0..placement.links).filter(move |&index| placement.skipped(index).min(most) == host.skip)
}

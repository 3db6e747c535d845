//! Age, habit and season: another tree of the kind from the same script.
//!
//! A script describes one tree, mature and grown in the open. A younger one is not that tree made smaller: it
//! is slimmer for its height, its branches are shorter and fewer, and its leaves are as large. How height and
//! crown go with the trunk's diameter is known (medians over the 169 species of the Urban Tree Database,
//! RDS-2016-0005, and over German forest trees): those exponents scale a script's levels here, before anything is
//! grown.
//!
//! In late autumn leaves that turn grow fewer, and in winter their levels are gone.
//!
//! Guarantees: age 1 in the open in summer is the script itself. The names and the order of levels stay as they are,
//! and so do the random draws of all links that remain. Cost: that of copying a script.

use crate::math::{float, round_to_u32};
use crate::species::schema::{Curve, Habit, LeafLook, LevelKind, Placement, Size, Species};
use std::borrow::Cow;

/// Height goes with the trunk's diameter to this power.
const HEIGHT_POWER: f32 = 0.575;

/// Crown width goes with the trunk's diameter to this power.
const CROWN_POWER: f32 = 0.72;

/// The same for a tree that is past its prime: its trunk goes on to thicken, the rest hardly grows.
const OLD_HEIGHT_POWER: f32 = 0.05;
const OLD_CROWN_POWER: f32 = 0.2;

/// Branches on a parent go with its length to this power: a shorter one has fewer, and they stand closer.
const LINKS_POWER: f32 = 0.7;

/// A forest tree is this much higher than one of the same kind in the open, at its diameter times the next.
const FOREST_HEIGHT: f32 = 1.2;
const FOREST_DIAMETER: f32 = 0.62;

/// Width of a forest tree's crown, as a part of what it is in the open at the same age.
const FOREST_CROWN: f32 = 0.62;

/// Seasons in which the first and the last leaf falls; 2 is autumn, 3 winter.
const FALL: [f32; 2] = [2.2, 2.8];

/// Where a forest tree's crown begins, as a part of the way from where it begins in the open to the top.
const FOREST_BOLE: f32 = 0.42;

/// The tree's measures as factors of the script's.
struct Factors {
    diameter: f32,
    height: f32,
    crown: f32,
    /// How far the first branches are moved up the trunk, 0..1 of the way that there is.
    bole: f32,
}

impl Factors {
    fn of(age: f32, habit: Habit) -> Self {
        let (height, crown) = if age <= 1.0 {
            (HEIGHT_POWER, CROWN_POWER)
        } else {
            (OLD_HEIGHT_POWER, OLD_CROWN_POWER)
        };
        let open = Self {
            diameter: age,
            height: libm::powf(age, height),
            crown: libm::powf(age, crown),
            bole: 0.0,
        };
        match habit {
            Habit::Open => open,
            Habit::Forest => Self {
                diameter: open.diameter * FOREST_DIAMETER,
                height: open.height * FOREST_HEIGHT,
                crown: open.crown * FOREST_CROWN,
                bole: FOREST_BOLE,
            },
        }
    }
}

/// The species as it is at its age and in its habit.
pub(super) fn grown_up(species: &Species) -> Cow<'_, Species> {
    #[expect(
        clippy::float_cmp,
        reason = "1 is what a script says if it says nothing"
    )]
    let as_written = species.age == 1.0 && species.habit == Habit::Open;
    let hanging = hanging(species.season);
    if as_written && hanging >= 1.0 {
        return Cow::Borrowed(species);
    }
    let factors = Factors::of(species.age, species.habit);
    let mut grown = species.clone();
    // How much longer each level's branches are than the script's, in metres.
    let mut longer: Vec<f32> = Vec::with_capacity(species.levels.len());
    for level in &mut grown.levels {
        let parent = level.parent.map(|p| longer.get(p).copied().unwrap_or(1.0));
        let Some(parent_longer) = parent else {
            if let LevelKind::Branch(trunk) = &mut level.kind {
                scale(&mut trunk.length, factors.height);
                scale(&mut trunk.radius, factors.diameter);
                if let Some(flare) = &mut trunk.flare {
                    flare.height_m *= factors.diameter;
                }
            }
            longer.push(factors.height);
            continue;
        };
        let on_trunk = level.parent == Some(0);
        let mut own = parent_longer;
        if let LevelKind::Branch(branch) = &mut level.kind {
            own = factors.crown;
            match &mut branch.length {
                Size::Metres(metres) => *metres *= own,
                Size::OfParent(part) => *part *= own / parent_longer,
            }
            if let Size::Metres(metres) = &mut branch.radius {
                *metres *= factors.diameter;
            }
        }
        fewer(&mut level.placement, parent_longer);
        if on_trunk {
            raise(&mut level.placement, factors.bole);
        }
        if let Some(envelope) = &mut level.placement.envelope {
            envelope.height_m *= factors.height;
            for (_, radius) in &mut envelope.radius_m.points {
                *radius *= factors.crown;
            }
        }
        longer.push(own);
    }
    if let Some(stems) = &mut grown.stems {
        stems.spread_m *= factors.crown;
    }
    if hanging < 1.0 {
        shed(&mut grown, hanging);
    }
    Cow::Owned(grown)
}

/// Part of the leaves that turn which still hang in a season.
fn hanging(season: f32) -> f32 {
    let [first, last] = FALL;
    ((last - season) / (last - first)).clamp(0.0, 1.0)
}

/// Takes leaves that turn in autumn off, but for a part of them.
fn shed(species: &mut Species, part: f32) {
    let turns = |kind: usize| match species.leaves.get(kind).map(|kind| &kind.look) {
        Some(LeafLook::Drawn(art)) => art.autumn.is_some(),
        _ => false,
    };
    let falls: Vec<bool> = species
        .levels
        .iter()
        .map(|level| match &level.kind {
            LevelKind::Leaf(leaf) => leaf.kinds.iter().all(|&(kind, _)| turns(kind)),
            LevelKind::Branch(_) => false,
        })
        .collect();
    // Nothing grows on leaves, so that only the numbers of what comes after them change.
    let mut kept = 0;
    let mut numbers = Vec::with_capacity(falls.len());
    for &falls in &falls {
        numbers.push(kept);
        kept += usize::from(!falls || part > 0.0);
    }
    let mut falling = falls.iter();
    species.levels.retain_mut(|level| {
        let falls = falling.next().copied().unwrap_or(false);
        level.parent = level.parent.map(|parent| numbers[parent]);
        if falls {
            let links = float(level.placement.links) * part;
            level.placement.links = round_to_u32(links).max(1);
        }
        !falls || part > 0.0
    });
}

fn scale(size: &mut Size, factor: f32) {
    match size {
        Size::Metres(value) | Size::OfParent(value) => *value *= factor,
    }
}

/// As many children as go with the parent's length; of few there stay as many as there are.
fn fewer(placement: &mut Placement, longer: f32) {
    let links = float(placement.links) * libm::powf(longer, LINKS_POWER);
    placement.links = round_to_u32(links).max(placement.links.min(2));
}

/// Moves the lowest branches up by a part of the way to the tip, and those above them closer together.
fn raise(placement: &mut Placement, part: f32) {
    if part == 0.0 || placement.end <= placement.start {
        return;
    }
    let (start, end) = (placement.start, placement.end);
    let first = start + (end - start) * part;
    let moved = |at: f32| {
        if at <= start || at >= end {
            at.max(first.min(end))
        } else {
            first + (at - start) / (end - start) * (end - first)
        }
    };
    placement.start = first;
    // What depends on the place goes with the branches, but for how they are spread over the crown.
    for param in [
        &mut placement.down,
        &mut placement.scale,
        &mut placement.sideways,
        &mut placement.thickness,
    ] {
        moved_to(&mut param.at, moved);
    }
}

/// The curve with its positions moved; those that fall together keep the last.
fn moved_to(curve: &mut Curve, moved: impl Fn(f32) -> f32) {
    for (at, _) in &mut curve.points {
        *at = moved(*at).min(1.0);
    }
    let mut points: Vec<(f32, f32)> = Vec::with_capacity(curve.points.len());
    for &(at, value) in &curve.points {
        match points.last_mut() {
            Some(last) if last.0 >= at => last.1 = value,
            _ => points.push((at, value)),
        }
    }
    curve.points = points;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::schema::Tissue;
    use crate::species::{NoFiles, parse};

    fn olive() -> Species {
        parse(
            "olive.ron",
            include_str!("../../species/olive.ron"),
            &NoFiles,
        )
        .expect("a sound script")
    }

    fn metres(size: Size) -> f32 {
        match size {
            Size::Metres(metres) => metres,
            Size::OfParent(_) => panic!("a trunk has a length of its own"),
        }
    }

    #[test]
    fn a_mature_tree_in_the_open_is_the_script() {
        assert!(matches!(grown_up(&olive()), Cow::Borrowed(_)));
    }

    #[test]
    fn a_young_tree_is_slim_for_its_height_and_has_fewer_twigs() {
        let (old, mut young) = (olive(), olive());
        young.age = 0.25;
        let young = grown_up(&young).into_owned();
        let trunk = |species: &Species| match &species.levels[0].kind {
            LevelKind::Branch(trunk) => (metres(trunk.length), metres(trunk.radius)),
            LevelKind::Leaf(_) => panic!("a trunk"),
        };
        let ((old_length, old_radius), (length, radius)) = (trunk(&old), trunk(&young));
        assert!((radius / old_radius - 0.25).abs() < 1e-6);
        let by_power = libm::powf(0.25, HEIGHT_POWER);
        assert!((length / old_length - by_power).abs() < 1e-6);
        assert!(length / radius > 1.5 * old_length / old_radius);
        for (young, old) in young.levels.iter().zip(&old.levels).skip(1) {
            let [young_links, old_links] = [young, old].map(|level| level.placement.links);
            assert!(young_links < old_links || old_links == 2, "{}", old.name);
            assert!(young_links >= 2, "{}", old.name);
            assert_eq!(young.placement.start, old.placement.start);
        }
    }

    #[test]
    fn only_leaves_that_turn_fall() {
        let mut evergreen = olive();
        evergreen.season = 3.0;
        assert_eq!(grown_up(&evergreen).levels.len(), olive().levels.len());
        let mut deciduous = evergreen.clone();
        let LeafLook::Drawn(art) = &mut deciduous.leaves[0].look else {
            panic!("the olive's leaves are drawn");
        };
        art.autumn = Some(Tissue::Yellow);
        // A level after the leaves, on the trunk, keeps its parent.
        let mut roots = deciduous.levels[1].clone();
        roots.name = "roots".to_owned();
        deciduous.levels.push(roots);
        let at = |season: f32| {
            let species = Species {
                season,
                ..deciduous.clone()
            };
            grown_up(&species).into_owned()
        };
        assert_eq!(
            at(2.0),
            Species {
                season: 2.0,
                ..deciduous.clone()
            }
        );
        let leaves = olive().levels.len() - 1;
        let [all, late] = [at(2.0), at(2.5)].map(|species| species.levels[leaves].placement.links);
        assert!(late < all && late > 0, "{late} of {all}");
        let bare = at(3.0);
        let mut wanted = deciduous.levels.clone();
        wanted.remove(leaves);
        let [names, wanted] = [&bare.levels, &wanted].map(|levels| -> Vec<_> {
            levels.iter().map(|l| (l.name.clone(), l.parent)).collect()
        });
        assert_eq!(names, wanted);
        assert_eq!(names[leaves], ("roots".to_owned(), Some(0)));
    }

    #[test]
    fn a_forest_tree_is_higher_and_narrower_and_its_crown_begins_higher() {
        let (open, mut forest) = (olive(), olive());
        forest.habit = Habit::Forest;
        let forest = grown_up(&forest).into_owned();
        let limbs = [&open, &forest].map(|species| &species.levels[1].placement);
        assert!(limbs[1].start > limbs[0].start + 0.1);
        assert_eq!(limbs[1].end, limbs[0].end);
        let envelope =
            [0, 1].map(|i: usize| limbs[i].envelope.as_ref().expect("the olive has one"));
        assert!(envelope[1].height_m > envelope[0].height_m);
        assert!(envelope[1].radius_m.max() < envelope[0].radius_m.max());
        for param in [&limbs[1].down, &limbs[1].scale] {
            let positions: Vec<f32> = param.at.points.iter().map(|p| p.0).collect();
            assert!(positions.is_sorted_by(|a, b| a < b), "{positions:?}");
            assert!(positions.iter().all(|p| (0.0..=1.0).contains(p)));
        }
    }
}

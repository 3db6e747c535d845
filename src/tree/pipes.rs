//! Radii by the pipe model: what comes to a fork has the cross-section of all that leaves it.
//!
//! Leonardo's rule, and Shinozaki, Yoda, Hozumi and Kira 1964: a stem is a bundle of pipes,
//! and each goes on to some leaf. A branch is therefore as thick between two forks as what goes on there and all
//! that leaves beyond. Here the rule says how a branch tapers; how thick its children are in it is the script's.
//!
//! Changes: the tip is not counted in pipes but worked out from the base, whose radius is the script's; and the
//! script's own taper may have a part in it.

use super::hosts::{self, Host};
use super::links::{self, THICKEST_CHILD};
use crate::rng::{Key, Parameter};
use crate::species::schema::{Curve, LevelKind, Size, Species};

/// Children nearer to each other than this part of the length leave at one fork.
const SAME_PLACE: f32 = 1e-4;

/// What is left of a branch beyond its last fork must be this part of its length to go on.
pub(super) const TIP: f32 = 0.004;

/// What leaves a trunk below this part of its length are roots.
const FOOT: f32 = 0.1;

/// A branch never gets thinner than this part of its base by the rule.
const THINNEST: f32 = 0.02;

/// Factors above this are no longer told apart, so that numbers stay finite whatever a script asks for.
const MOST: f32 = 1e30;

/// Radius at the very end of a branch that goes on beyond its last fork, as a part of what it is there.
const END: f32 = 0.5;

/// Branches that leave one place: what they take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Fork {
    /// Part of the length.
    at: f32,
    /// Sum of the squared ratios of radii, of those that go by their parent's radius.
    relative: f32,
    /// Sum of the squared radii, as parts of the base's, of those that have a radius of their own.
    absolute: f32,
}

/// The taper of one prototype: the script's, and by the part `pipe_model` the rule's. `radius` is that of the
/// base, metres.
pub(super) fn taper(
    species: &Species,
    level: usize,
    variant: u64,
    seed: Key,
    radius: f32,
) -> Option<Curve> {
    let LevelKind::Branch(params) = &species.levels[level].kind else {
        return None;
    };
    let part = params.pipe_model;
    if part <= 0.0 {
        return None;
    }
    let forks = forks(species, level, variant, seed, radius);
    let rule = by_rule(&forks)?;
    let mut at: Vec<f32> = rule.points.iter().map(|p| p.0).collect();
    if part < 1.0 {
        at.extend(params.taper.points.iter().map(|p| p.0));
        at.sort_by(f32::total_cmp);
        at.dedup_by(|b, a| *b - *a < SAME_PLACE);
    }
    let foot = params.taper.at(0.0);
    let blend = |t: f32| {
        let written = params.taper.at(t);
        (t, written + (rule.at(t) * foot - written) * part)
    };
    Some(Curve {
        points: at.into_iter().map(blend).collect(),
    })
}

/// All forks of a prototype, from the base on.
fn forks(species: &Species, level: usize, variant: u64, seed: Key, radius: f32) -> Vec<Fork> {
    let mut leaving: Vec<Fork> = Vec::new();
    for child in level + 1..species.levels.len() {
        let LevelKind::Branch(params) = &species.levels[child].kind else {
            continue;
        };
        if are_roots(species, child) {
            continue;
        }
        for host in hosts::hosts(species, child) {
            if host.level == level {
                leaving.extend(children(
                    species,
                    host,
                    params.radius,
                    variant,
                    seed,
                    radius,
                ));
            }
        }
    }
    leaving.sort_by(|a, b| a.at.total_cmp(&b.at));
    let mut forks: Vec<Fork> = Vec::new();
    for one in leaving {
        match forks.last_mut() {
            Some(fork) if one.at - fork.at < SAME_PLACE => {
                fork.relative += one.relative;
                fork.absolute += one.absolute;
            }
            _ => forks.push(one),
        }
    }
    forks
}

/// Roots take nothing of a trunk: what leaves at its very foot feeds it.
fn are_roots(species: &Species, level: usize) -> bool {
    let on_trunk = |parent: usize| species.levels[parent].parent.is_none();
    let level = &species.levels[level];
    level.parent.is_some_and(on_trunk) && level.placement.end <= FOOT
}

/// What the children at the places of a host take, one by one.
fn children(
    species: &Species,
    host: Host,
    size: Size,
    variant: u64,
    seed: Key,
    radius: f32,
) -> Vec<Fork> {
    let script = &species.levels[host.places];
    let key = seed.level(&script.name).with(variant);
    let p = &script.placement;
    let mut forks = Vec::new();
    for index in hosts::places(species, host) {
        let key = key.with(u64::from(index));
        let at = links::position(p, key, index);
        for around in 0..p.children {
            let key = key.with(u64::from(around));
            let asked = links::factor(&p.thickness, key, Parameter::Thickness, at);
            let mut fork = Fork {
                at,
                ..Fork::default()
            };
            match size {
                Size::OfParent(ratio) => {
                    let ratio = (asked * ratio).min(THICKEST_CHILD);
                    fork.relative = ratio * ratio;
                }
                Size::Metres(metres) => {
                    let scale = links::factor(&p.scale, key, Parameter::Scale, at);
                    let ratio = asked * metres * scale / radius.max(1e-9);
                    fork.absolute = ratio * ratio;
                }
            }
            forks.push(fork);
        }
    }
    forks
}

/// Radius by position, 1 at the base: in the middle of each internode what the rule asks for. `None` without
/// forks.
///
/// What leaves at the very end goes on in the branch's stead (see [`links::on_branch`]): that fork takes nothing.
/// A child that goes by its parent's radius sees about the mean of those before and after the fork. With `r` the
/// sum of squared ratios, `before^2 = after^2 + r ((before + after) / 2)^2`, so `before / after` is
/// `(1 + r / 4) / (1 - r / 4)`.
fn by_rule(forks: &[Fork]) -> Option<Curve> {
    let last = forks.last()?;
    let goes_on = 1.0 - last.at > TIP;
    let before_end = forks.partition_point(|fork| 1.0 - fork.at > TIP);
    let forks = &forks[..before_end];
    // Squared radius of each internode, the tip's first, as `grows * tip + adds`.
    let (mut grows, mut adds) = (1.0_f32, 0.0_f32);
    let mut internodes = vec![(grows, adds)];
    for fork in forks.iter().rev() {
        let quarter = (fork.relative * 0.25).min(0.9);
        let ratio = (1.0 + quarter) / (1.0 - quarter);
        grows = (grows * ratio * ratio).min(MOST);
        adds = (adds * ratio * ratio + fork.absolute).min(MOST);
        internodes.push((grows, adds));
    }
    internodes.reverse();
    let least = THINNEST * THINNEST;
    let tip = ((1.0 - adds) / grows).max(least);
    // Where children of their own radius ask for more than there is, all is thinner in the same measure.
    let whole = grows * tip + adds;
    let radii = internodes
        .iter()
        .map(|(grows, adds)| ((grows * tip + adds) / whole).sqrt().max(THINNEST));
    let ends = forks.iter().map(|f| f.at).chain([1.0]);
    let mut points: Vec<(f32, f32)> = vec![(0.0, 1.0)];
    let mut from = 0.0;
    let mut end = 1.0;
    for (radius, to) in radii.zip(ends) {
        let middle = (from + to) * 0.5;
        from = to;
        if middle - points[points.len() - 1].0 > SAME_PLACE * 0.5 && middle < 1.0 {
            points.push((middle, radius));
        }
        end = radius;
    }
    points.push((1.0, if goes_on { end * END } else { end }));
    Some(Curve { points })
}

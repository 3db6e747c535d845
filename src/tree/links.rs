//! Where the children of one prototype sit: positions, angles, sizes, thickness.

use super::pipes::TIP;
use super::{Branch, Link, Prototype};
use crate::math::{Quat, Similarity, Vec3, float};
use crate::rng::{Key, Parameter};
use crate::species::schema::{Envelope, Level, LevelKind, Param, Placement, Size, Species};

/// A child may be at most this part as thick as its parent where it leaves it.
pub(super) const THICKEST_CHILD: f32 = 0.95;

/// Smallest factor on a child's thickness and size: keeps frames invertible.
const SMALLEST_FACTOR: f32 = 0.02;

/// What links need to know of the level that they lead to.
pub(super) struct ChildLevel<'a> {
    pub(super) index: u16,
    /// What it is.
    pub(super) script: &'a Level,
    /// Where it grows: its own script but for places that skip levels.
    pub(super) places: &'a Level,
    /// The part that the pipe model has in the radii of what carries it.
    pub(super) pipe_model: f32,
    /// Length of a prototype at scale 1 without chance, metres.
    pub(super) length: f32,
    /// Radius at the base at scale 1, metres; 0 for leaves.
    pub(super) radius: f32,
    /// Weight of each prototype of the level.
    pub(super) weights: &'a [f32],
}

/// An angle of a script at one place, in radians.
pub(super) fn angle(param: &Param, key: Key, parameter: Parameter, at: f32, link: f32) -> f32 {
    let degrees = param.at.at(at) + param.step * link + param.vary * key.signed(parameter);
    degrees.to_radians()
}

/// A size of a script at one place.
pub(super) fn factor(param: &Param, key: Key, parameter: Parameter, at: f32) -> f32 {
    (param.at.at(at) * (1.0 + param.vary * key.signed(parameter))).max(SMALLEST_FACTOR)
}

/// Children of one level on one branch prototype at the given places, in order of position and then around it.
/// By the pipe model those at the very end take all of its cross-section, and so go on in its stead.
pub(super) fn on_branch(
    parent: &Branch,
    child: &ChildLevel<'_>,
    indices: impl Iterator<Item = u32>,
    seed: Key,
    parent_variant: u64,
) -> Vec<Link> {
    let placement = &child.places.placement;
    let level_key = seed.level(&child.places.name).with(parent_variant);
    let mut links = Vec::with_capacity(placement.links as usize * placement.children as usize);
    for index in indices {
        let link_key = level_key.with(u64::from(index));
        let at = position(placement, link_key, index);
        for around in 0..placement.children {
            let key = link_key.with(u64::from(around));
            links.push(one(parent, child, key, at, index, around));
        }
    }
    links
}

/// Position of link `index` on the parent.
#[expect(
    clippy::cast_precision_loss,
    reason = "link numbers are far below 2^24"
)]
pub(super) fn position(p: &Placement, key: Key, index: u32) -> f32 {
    let last = p.links.saturating_sub(1).max(1) as f32;
    let even = if p.links == 1 {
        1.0
    } else {
        index as f32 / last
    };
    let shifted = even + p.jitter * 0.5 * key.signed(Parameter::Position) / last;
    p.start + (p.end - p.start) * libm::powf(shifted.clamp(0.0, 1.0), p.crowding)
}

#[expect(
    clippy::cast_precision_loss,
    reason = "link numbers are far below 2^24"
)]
fn one(
    parent: &Branch,
    child: &ChildLevel<'_>,
    key: Key,
    at: f32,
    index: u32,
    around: u32,
) -> Link {
    let p = &child.places.placement;
    let link = index as f32;
    let turn = angle(&p.around, key, Parameter::Around, at, link)
        + crate::math::TAU * around as f32 / p.children as f32;
    let down = angle(&p.down, key, Parameter::Down, at, link);
    let sideways = angle(&p.sideways, key, Parameter::Sideways, at, link);
    let spin = angle(&p.spin, key, Parameter::Spin, at, link);
    // At the end of a blunt parent, start a little below it, so that the first ring stays inside.
    let end = parent.axis[parent.axis.len() - 1].radius;
    let sample = parent.at(at.min(1.0 - (0.8 * end / parent.length).min(0.5)));
    let heading = sample.frame * Quat::from_rotation_y(turn);
    // The half turn puts the child's +Z on the side of the parent's tip: its upper side.
    let rotation = (heading
        * Quat::from_rotation_z(sideways)
        * Quat::from_rotation_x(down)
        * Quat::from_rotation_y(core::f32::consts::PI + spin))
    .normalize();
    let (translation, mut scale) = match child.script.kind {
        LevelKind::Branch(_) => (sample.position, factor(&p.scale, key, Parameter::Scale, at)),
        // Leaf stalks start at the surface, a little below it so that no gap shows.
        LevelKind::Leaf(_) => (
            sample.position + heading * Vec3::Z * (sample.radius * 0.8),
            factor(&p.scale, key, Parameter::Scale, at),
        ),
    };
    if let Some(envelope) = &p.envelope {
        scale = fitted(
            envelope,
            translation,
            rotation * Vec3::Y * child.length,
            scale,
        );
    }
    Link {
        level: child.index,
        prototype: u16::try_from(key.pick(Parameter::Prototype, child.weights).unwrap_or(0))
            .unwrap_or(0),
        at,
        thickness: thickness(parent, child, key, at, scale),
        place: Similarity {
            rotation,
            translation,
            scale,
        },
    }
}

/// Factor on the child's own radius: follows the parent's taper, never outgrows the parent.
fn thickness(parent: &Branch, child: &ChildLevel<'_>, key: Key, at: f32, scale: f32) -> f32 {
    let LevelKind::Branch(params) = &child.script.kind else {
        return 1.0;
    };
    let placement = &child.places.placement;
    let asked = factor(&placement.thickness, key, Parameter::Thickness, at);
    // The first ring is drawn in to hide in *its* parent; what a child sees starts after it.
    let parent_radius = parent.at(at.max(parent.axis[1].t)).radius;
    let own = (child.radius * scale).max(1e-9);
    let wanted = match params.radius {
        Size::Metres(_) => asked,
        Size::OfParent(ratio) => {
            let ratio = asked * ratio;
            let pipes = if 1.0 - at > TIP {
                0.0
            } else {
                child.pipe_model
            };
            let whole = THICKEST_CHILD / float(placement.children).sqrt();
            (ratio + (whole - ratio) * pipes) * parent_radius / own
        }
    };
    wanted
        .min(THICKEST_CHILD * parent_radius / own)
        .max(SMALLEST_FACTOR)
}

/// The largest scale up to `scale` at which a straight child's tip stays within the envelope.
fn fitted(envelope: &Envelope, base: Vec3, reach: Vec3, scale: f32) -> f32 {
    let inside = |s: f32| {
        let tip = base + reach * s;
        let height = (tip.y / envelope.height_m).clamp(0.0, 1.0);
        tip.y <= envelope.height_m && libm::hypotf(tip.x, tip.z) <= envelope.radius_m.at(height)
    };
    if inside(scale) {
        return scale;
    }
    let (mut low, mut high) = (0.0, scale);
    // Twenty halvings: a millionth of the scale.
    for _ in 0..20 {
        let middle = (low + high) * 0.5;
        if inside(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low.max(0.1 * scale)
}

/// The stems of a multi-stemmed tree, on the stool.
#[expect(clippy::cast_precision_loss, reason = "at most 64 stems")]
pub(super) fn on_stool(species: &Species, child: &ChildLevel<'_>, seed: Key) -> Vec<Link> {
    let Some(stems) = &species.stems else {
        return Vec::new();
    };
    let key = seed.level(super::grow::STOOL);
    (0..stems.count)
        .map(|index| {
            let key = key.with(u64::from(index));
            let at = if stems.count == 1 {
                0.0
            } else {
                index as f32 / (stems.count - 1) as f32
            };
            // The golden angle spreads any number of stems without a visible order.
            let turn = (index as f32 * 137.5 + 40.0 * key.signed(Parameter::Stem)).to_radians();
            let lean = angle(&stems.lean, key, Parameter::Lean, at, 0.0);
            let heading = Quat::from_rotation_y(turn);
            let out = ((index as f32 + 0.5) / stems.count as f32).sqrt() * stems.spread_m;
            Link {
                level: child.index,
                prototype: u16::try_from(
                    key.pick(Parameter::Prototype, child.weights).unwrap_or(0),
                )
                .unwrap_or(0),
                at,
                thickness: 1.0,
                place: Similarity {
                    rotation: (heading * Quat::from_rotation_x(lean)).normalize(),
                    translation: heading * Vec3::Z * out,
                    scale: factor(&stems.scale, key, Parameter::Scale, at),
                },
            }
        })
        .collect()
}

/// Lowers, for each prototype of a level, the largest radius (at scale and thickness 1) of a first ring that
/// stays inside these parents at every link, however thin a parent's thinnest node is.
pub(super) fn hide(hidden: &mut [f32], parents: &[Prototype], parent_thinnest: &[f32], level: u16) {
    // Inside the circle inscribed in a three-sided tube, with a little to spare.
    const INSCRIBED: f32 = 0.45;
    for (parent, &thinnest) in parents.iter().zip(parent_thinnest) {
        let super::Part::Branch(branch) = &parent.part else {
            continue;
        };
        for link in parent.links.iter().filter(|l| l.level == level) {
            let parent_radius = branch.at(link.at).radius * thinnest;
            let radius = INSCRIBED * parent_radius / (link.place.scale * link.thickness);
            let slot = &mut hidden[link.prototype as usize];
            *slot = slot.min(radius);
        }
    }
}

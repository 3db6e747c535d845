//! How far branches bend in the wind, from their length and radii alone.
//!
//! A branch is a tapered cantilever under the drag of what it carries (beam theory, Euler and Bernoulli). The
//! drag grows with the leaves, and these with the cross-section of the wood that feeds them (the pipe model,
//! Shinozaki et al. 1964), so that no leaves need to be counted. It is spread evenly from where the first
//! child stands to the tip. With w newtons of drag a square metre of wood at the base, E the modulus, L the
//! length, r the radius and m the moment of the unit load, the tip of the branch bends by
//!
//! ```text
//! L * (4 w / E) * (L / r)^2 * integral of m(x) (1 - x) / (r(x) / r)^4 dx
//! ```
//!
//! Not guaranteed: species differ in E and in how leaves fold; figures are right to a factor of two or so.

use super::{Branch, Part, Prototype};

/// Drag a square metre of wood at a branch's base in a wind of 10 m/s, newtons: 4000 m2 of leaves, each at
/// 60 Pa of dynamic pressure, with a drag coefficient of 0.12 for leaves that shelter each other.
const DRAG: f32 = 30e3;

/// Young's modulus of green wood, pascals.
const MODULUS: f32 = 6e9;

/// Thinner parts of a branch bend as if they were this part of its base's radius: needle tips carry no load.
const THINNEST: f32 = 0.2;

/// The tip of a branch never bends farther than this part of its length at the reference wind.
const MOST: f32 = 0.16;

/// Where the tip of a prototype's own branch goes in a wind of 10 m/s, as a part of its length and before
/// [`tip_part`] has tamed it; 0 for what is no branch. The same for all nodes of the prototype but for their
/// thickness, because bending by length and slenderness knows no scale.
#[must_use]
pub fn flexure(prototype: &Prototype) -> f32 {
    let Part::Branch(branch) = &prototype.part else {
        return 0.0;
    };
    let first = prototype.links.iter().map(|l| l.at).fold(1.0, f32::min);
    let slenderness = branch.length / branch.radius.max(1e-6);
    4.0 * DRAG / MODULUS * slenderness * slenderness * compliance(branch, first)
}

/// The integral of the header over a branch's tapering radii.
fn compliance(branch: &Branch, first: f32) -> f32 {
    let mut sum = 0.0;
    for pair in branch.axis.windows(2) {
        let x = (pair[0].t + pair[1].t) * 0.5;
        // The very first ring is drawn in to hide inside the parent.
        let radius = pair[0].radius.max(pair[1].radius) / branch.radius.max(1e-6);
        let stiffness = radius.max(THINNEST);
        let stiffness = stiffness * stiffness * stiffness * stiffness;
        sum += moment(x, first) * (1.0 - x) / stiffness * (pair[1].t - pair[0].t);
    }
    sum
}

/// Moment at `x` of a load of 1 spread evenly over `first..=1`.
fn moment(x: f32, first: f32) -> f32 {
    if x < first {
        (first + 1.0) * 0.5 - x
    } else {
        (1.0 - x) * (1.0 - x) / (2.0 * (1.0 - first).max(1e-3))
    }
}

/// Where the tip of a node goes as a part of its length, from its prototype's [`flexure`] and the node's
/// thickness: a stem twice as thick bends a quarter as far.
#[must_use]
pub fn tip_part(flexure: f32, thickness: f32) -> f32 {
    let part = flexure / (thickness * thickness).max(1e-6);
    part / (1.0 + part / MOST)
}

/// How far a branch has bent at `t` (0 its base, 1 its tip), as a part of its tip's way: the deflection of an
/// evenly loaded cantilever. The slope at the base is 0.
#[must_use]
pub fn bend(t: f32) -> f32 {
    t * t * (6.0 - 4.0 * t + t * t) / 3.0
}

//! Branch tubes.
//!
//! A ring of vertices at each kept point of the branch's curve, in the rotation-minimising frames of
//! growth; the first ring is drawn in so that it hides inside the parent, the last one closes in an
//! apex. Bark coordinates do not swim between LODs: v is arc length over the bark's real height, u runs
//! over whole repeats around the stem, the same in every LOD.

use super::coat::Coat;
use super::template::{Material, Template, TemplateVertex};
use crate::math::{PI, TAU, Vec3};
use crate::tree::{AxisSample, Branch};

/// Builds the tube of a branch at a geometry LOD, in its bark.
#[must_use]
pub fn tube(branch: &Branch, lod: usize, coat: Coat) -> Template {
    let rings = branch.tube(lod);
    let repeats = (TAU * branch.radius / coat.height_m).round().max(1.0);
    let mut template = Template {
        material: Material::Bark,
        ..Template::default()
    };
    for (ring, sides) in rings.clone() {
        for side in 0..=sides {
            let vertex = on_ring(branch, ring, side, sides, repeats, coat);
            template.vertices.push(vertex);
        }
    }
    let last = branch.axis.len() - 1;
    let rim = rings.clone().last().map_or(0, |(_, sides)| sides);
    for side in 0..rim {
        template
            .vertices
            .push(apex(branch, last, side, rim, repeats, coat));
    }
    let mut lower = 0;
    for ((_, sides), (_, next)) in rings.clone().zip(rings.skip(1)) {
        let upper = lower + sides + 1;
        stitch((lower, sides), (upper, next), &mut template.indices);
        lower = upper;
    }
    for side in 0..rim {
        let edge = lower + side;
        template.indices.extend([edge, edge + 1, edge + rim + 1]);
    }
    template
}

/// The band between two rings, each given by its first vertex and its corners: a triangle on each edge of both,
/// and a diagonal from the lower ring's edge to the upper one's end where both edges are alike.
fn stitch((lower, sides): (u32, u32), (upper, next): (u32, u32), indices: &mut Vec<u32>) {
    let (mut i, mut j) = (0, 0);
    while i < sides || j < next {
        // The edge that ends first is next; ends are compared as fractions of the way round.
        if j == next || (i < sides && (i + 1) * next <= (j + 1) * sides) {
            let ahead = u32::from(j < next && (i + 1) * next == (j + 1) * sides);
            indices.extend([lower + i, lower + i + 1, upper + j + ahead]);
            if ahead == 1 {
                indices.extend([lower + i, upper + j + 1, upper + j]);
                j += 1;
            }
            i += 1;
        } else {
            indices.extend([lower + i, upper + j + 1, upper + j]);
            j += 1;
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few dozen corners")]
fn on_ring(
    branch: &Branch,
    at: usize,
    side: u32,
    sides: u32,
    repeats: f32,
    coat: Coat,
) -> TemplateVertex {
    let sample = &branch.axis[at];
    let part = side as f32 / sides as f32;
    let along = sample.t * branch.length;
    // The seam's two vertices must agree to the bit, so both take the angle of side 0.
    let angle = if side == sides { 0.0 } else { TAU * part };
    let (sine, cosine) = libm::sincosf(angle);
    let (lobe, lobe_slope) = branch.lobes.at(angle, sample.t, along);
    let out = sample.frame * Vec3::new(sine, 0.0, cosine);
    let around = sample.frame * Vec3::new(cosine, 0.0, -sine);
    let up = sample.frame * Vec3::Y;
    let normal =
        (out - around * (lobe_slope / lobe) - up * slope(&branch.axis, at)).normalize_or(out);
    TemplateVertex {
        axis: sample.position,
        offset: out * (sample.radius * lobe * widened(sides)),
        normal,
        tangent: (around - normal * around.dot(normal)).normalize_or(around),
        uv: [part * repeats, -along / coat.height_m],
        tint: coat.tint(sample.radius),
    }
}

/// How much larger a ring's corners stand off so that it is seen as wide as the round branch, mean over
/// directions: the mean width of a convex outline is its perimeter over pi (Cauchy's formula). Corners on the
/// branch itself would lose a sixth of it with three sides.
#[expect(clippy::cast_precision_loss, reason = "a few dozen corners")]
fn widened(sides: u32) -> f32 {
    let sides = sides.max(3) as f32;
    PI / (sides * libm::sinf(PI / sides))
}

/// Change of the radius per metre along the branch.
fn slope(axis: &[AxisSample], at: usize) -> f32 {
    let (before, after) = (
        &axis[at.saturating_sub(1)],
        &axis[(at + 1).min(axis.len() - 1)],
    );
    let distance = before.position.distance(after.position);
    if distance > 0.0 {
        (after.radius - before.radius) / distance
    } else {
        0.0
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few dozen corners")]
fn apex(
    branch: &Branch,
    at: usize,
    side: u32,
    sides: u32,
    repeats: f32,
    coat: Coat,
) -> TemplateVertex {
    let sample = &branch.axis[at];
    let part = (side as f32 + 0.5) / sides as f32;
    let (sine, cosine) = libm::sincosf(TAU * part);
    let out = sample.frame * Vec3::new(sine, 0.0, cosine);
    let around = sample.frame * Vec3::new(cosine, 0.0, -sine);
    let up = sample.frame * Vec3::Y;
    // A dome of half the radius on a blunt end; a cone's tip is the curve's end itself.
    let dome = if branch.blunt {
        sample.radius * 0.5
    } else {
        0.0
    };
    let normal = if branch.blunt {
        (up * 2.0 + out).normalize_or(up)
    } else {
        out
    };
    TemplateVertex {
        axis: sample.position,
        offset: up * dome,
        normal,
        tangent: (around - normal * around.dot(normal)).normalize_or(around),
        uv: [part * repeats, -(branch.length + dome) / coat.height_m],
        tint: coat.tint(sample.radius),
    }
}

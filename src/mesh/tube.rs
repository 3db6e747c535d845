//! Branch tubes.
//!
//! A ring of vertices at each kept point of the branch's curve, in the rotation-minimising frames of
//! growth; the first ring is drawn in so that it hides inside the parent, the last one closes in an
//! apex. Bark coordinates do not swim between LODs: v is arc length over the bark's real height, u runs
//! over whole repeats around the stem, the same in every LOD.

use super::template::{Material, Template, TemplateVertex};
use crate::math::{TAU, Vec3};
use crate::tree::{AxisSample, Branch};

/// Builds the tube of a branch at a geometry LOD; `bark_height` is the real height of one repeat, metres.
#[must_use]
pub fn tube(branch: &Branch, lod: usize, bark_height: f32) -> Template {
    let lod = lod.min(branch.rings.len() - 1);
    let (full, sides) = branch.tube(lod);
    let repeats = (TAU * branch.radius / bark_height).round().max(1.0);
    let mut template = Template {
        material: Material::Bark,
        ..Template::default()
    };
    for &ring in &branch.rings[lod][..full] {
        for side in 0..=sides {
            template.vertices.push(on_ring(
                branch,
                ring as usize,
                side,
                sides,
                repeats,
                bark_height,
            ));
        }
    }
    let last = branch.axis.len() - 1;
    for side in 0..sides {
        template
            .vertices
            .push(apex(branch, last, side, sides, repeats, bark_height));
    }
    let row = sides + 1;
    for ring in 0..u32::try_from(full).unwrap_or(u32::MAX) - 1 {
        for side in 0..sides {
            let a = ring * row + side;
            let (b, c, d) = (a + 1, a + row, a + row + 1);
            template.indices.extend([a, b, d, a, d, c]);
        }
    }
    let rim = (u32::try_from(full).unwrap_or(u32::MAX) - 1) * row;
    for side in 0..sides {
        template
            .indices
            .extend([rim + side, rim + side + 1, rim + row + side]);
    }
    template
}

#[expect(clippy::cast_precision_loss, reason = "a few dozen corners")]
fn on_ring(
    branch: &Branch,
    at: usize,
    side: u32,
    sides: u32,
    repeats: f32,
    height: f32,
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
        offset: out * (sample.radius * lobe),
        normal,
        tangent: (around - normal * around.dot(normal)).normalize_or(around),
        uv: [part * repeats, -along / height],
    }
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
    height: f32,
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
        uv: [part * repeats, -(branch.length + dome) / height],
    }
}

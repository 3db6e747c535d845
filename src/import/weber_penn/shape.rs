//! The model's formulas: how long branches are, where they point, how they bend, and what is pruned.

use super::Parameters;
use crate::math::{float, round_to_u32};

/// Length of limbs over their position: `ratio` is 1 at the crown's base and 0 at the tree's top.
pub(super) fn shape_ratio(shape: u32, ratio: f32) -> f32 {
    let r = ratio.clamp(0.0, 1.0);
    match shape {
        0 => 0.2 + 0.8 * r,
        1 => 0.2 + 0.8 * libm::sinf(core::f32::consts::PI * r),
        2 => 0.2 + 0.8 * libm::sinf(core::f32::consts::FRAC_PI_2 * r),
        4 => 0.5 + 0.5 * r,
        5 if r <= 0.7 => r / 0.7,
        5 => (1.0 - r) / 0.3,
        6 => 1.0 - 0.8 * r,
        7 if r <= 0.7 => 0.5 + 0.5 * r / 0.7,
        7 => 0.5 + 0.5 * (1.0 - r) / 0.3,
        // A cylinder, and the envelope, which pruning makes.
        _ => 1.0,
    }
}

/// The name of a shape.
pub(super) fn shape_name(shape: u32) -> &'static str {
    match shape {
        0 => "conical",
        1 => "spherical",
        2 => "hemispherical",
        3 => "cylindrical",
        4 => "tapered cylindrical",
        5 => "flame",
        6 => "inverse conical",
        7 => "tend flame",
        _ => "envelope",
    }
}

/// Angle from the parent's axis at a part of the way from the first to the last branch, degrees.
pub(super) fn down_angle(angle: f32, vary: f32, way: f32) -> f32 {
    if vary < 0.0 {
        angle + vary * (1.0 - 2.0 * shape_ratio(0, 1.0 - way))
    } else {
        angle
    }
}

/// Bend of a stem at the middle of each of its segments, degrees from its first direction; positive is away
/// from its parent's axis.
pub(super) fn bends(p: &Parameters, level: usize) -> Vec<f32> {
    let segments = round_to_u32(p.of(level, "CurveRes")).clamp(2, 8);
    let (curve, back) = (p.of(level, "Curve"), p.of(level, "CurveBack"));
    let each = 1.0 / float(segments);
    let mut bend = 0.0;
    (0..segments)
        .map(|segment| {
            let middle = (float(segment) + 0.5) * each;
            let step = if back == 0.0 {
                curve * each
            } else if middle < 0.5 {
                2.0 * curve * each
            } else {
                2.0 * back * each
            };
            bend += step;
            bend - step * 0.5
        })
        .collect()
}

/// A stem of length 1 as a curve in a plane: (along its first direction, to its upper side).
pub(super) fn curve(bends: &[f32]) -> Vec<(f32, f32)> {
    let each = 1.0 / float(u32::try_from(bends.len()).unwrap_or(1).max(1));
    let mut at = (0.0, 0.0);
    let mut points = vec![at];
    for bend in bends {
        let (sine, cosine) = libm::sincosf(bend.to_radians());
        at = (at.0 + cosine * each, at.1 - sine * each);
        points.push(at);
    }
    points
}

/// Points of a stem of length 1 that leaves an upright parent at an angle: (outward, upward).
pub(super) fn leaving(bends: &[f32], down_deg: f32) -> Vec<(f32, f32)> {
    let (sine, cosine) = libm::sincosf(down_deg.to_radians());
    curve(bends)
        .into_iter()
        .map(|(along, upper)| (along * sine - upper * cosine, along * cosine + upper * sine))
        .collect()
}

/// How far from the axis stems may reach at a height, as a part of the tree's scale.
pub(super) fn envelope(p: &Parameters, height: f32) -> f32 {
    let scale = p.get("Scale");
    let ratio = (scale - height) / (scale * (1.0 - p.get("BaseSize")).max(1e-3));
    if !(0.0..=1.0).contains(&ratio) {
        return 0.0;
    }
    let peak = p.get("PruneWidthPeak");
    let part = if ratio < 1.0 - peak {
        libm::powf(ratio / (1.0 - peak), p.get("PrunePowerHigh"))
    } else {
        libm::powf((1.0 - ratio) / peak.max(1e-3), p.get("PrunePowerLow"))
    };
    part * p.get("PruneWidth")
}

/// Largest part of its length at which a limb stays within the envelope; its foot is at (distance from the
/// axis, height).
pub(super) fn pruned(
    p: &Parameters,
    foot: (f32, f32),
    length: f32,
    bends: &[f32],
    down_deg: f32,
) -> f32 {
    let scale = p.get("Scale");
    let points = leaving(bends, down_deg);
    let inside = |factor: f32| {
        points.iter().skip(1).all(|(out, up)| {
            let (out, up) = (
                foot.0 + out * length * factor,
                foot.1 + up * length * factor,
            );
            out.abs() <= scale * envelope(p, up)
        })
    };
    let longest = (1..=20)
        .rev()
        .map(|step| float(step) / 20.0)
        .find(|&factor| inside(factor))
        .unwrap_or(0.05);
    let ratio = p.get("PruneRatio");
    1.0 - ratio + ratio * longest
}

/// Sideways wander of a spline's control points for a `CurveV`: a walk of turns by chance drifts by this part
/// of the length at its end; a quarter of it, point by point, looks alike.
pub(super) fn gnarl(p: &Parameters, level: usize) -> f32 {
    let segments = p.of(level, "CurveRes").max(1.0);
    let walk = p.of(level, "CurveV").abs().to_radians() / (3.0 * segments.sqrt());
    (0.25 * walk).min(0.12)
}

/// Radius along a stem for a `Taper`, as (position, factor).
pub(super) fn taper(taper: f32) -> Vec<(f32, f32)> {
    // A thread of a tip, since nothing has no thickness.
    let thin = |factor: f32| factor.max(0.03);
    if taper <= 1.0 {
        vec![(0.0, 1.0), (1.0, thin(1.0 - taper))]
    } else if taper <= 2.0 {
        // From a cone to a cylinder, with a rounded end.
        let end = taper - 1.0;
        let at = 0.92;
        vec![
            (0.0, 1.0),
            (at, thin(1.0 - (1.0 - end) * at)),
            (1.0, thin(end * 0.5)),
        ]
    } else {
        // Beads; a cylinder stands for them.
        vec![(0.0, 1.0), (1.0, 1.0)]
    }
}

//! Teeth: cut into runs of an outline, along their arc length.

use super::outline::Run;
use crate::math::{Vec2, float, round_to_u32, smoothstep};
use crate::species::schema::{Margin, MarginKind};

/// Points of one tooth.
const TOOTH_POINTS: u32 = 8;
/// Where in a tooth its tip is; the teeth of a run point to its end.
const TIP: f32 = 0.75;

/// The runs one after another with their teeth, from the foot to the tip. `half` is half the blade's
/// width.
pub(super) fn cut(runs: &[Run], margin: &Margin, half: f32) -> Vec<Vec2> {
    let lengths: Vec<f32> = runs.iter().map(|run| length(&run.points)).collect();
    let total: f32 = lengths.iter().sum::<f32>().max(1e-6);
    let mut outline = Vec::new();
    for (run, &length) in runs.iter().zip(&lengths) {
        let teeth = if margin.kind == MarginKind::Entire || margin.depth <= 0.0 {
            0
        } else {
            round_to_u32(float(margin.teeth) * length / total)
        };
        let mut points = if teeth == 0 {
            run.points.clone()
        } else {
            toothed(run, margin, teeth, half)
        };
        if run.falling {
            points.reverse();
        }
        outline.extend(points);
    }
    outline
}

fn length(points: &[Vec2]) -> f32 {
    points
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .sum()
}

/// One run with its teeth.
fn toothed(run: &Run, margin: &Margin, teeth: u32, half: f32) -> Vec<Vec2> {
    let points = &run.points;
    // A run that is passed backward has the blade on its other side.
    let side = if run.falling { -1.0 } else { 1.0 };
    let steps = (teeth * TOOTH_POINTS * if teeth < 40 { 3 } else { 1 }).max(64);
    let smooth = resampled(points, steps);
    let spacing = length(points) / float(teeth);
    // No deeper than a tooth is long, or teeth would cross.
    let depth = (margin.depth * half).min(1.4 * spacing);
    (0..=steps as usize)
        .map(|i| {
            let way = i as f32 / steps as f32;
            let before = smooth[i.saturating_sub(1)];
            let after = smooth[(i + 1).min(steps as usize)];
            let tangent = (after - before).normalize_or(Vec2::X);
            let inward = tangent.perp() * -side;
            // The first tooth of a run is slight: runs meet in the hollow without a step.
            let first = smoothstep(0.1, 0.9, way * float(teeth));
            let here = smoothstep(0.02, 0.14, way).min(first) * (1.0 - smoothstep(0.94, 1.0, way));
            // Narrow parts have small teeth: no tooth reaches the midrib.
            let room = (smooth[i].y.abs() / half.max(1e-6) * 1.6).min(1.0);
            let room = (depth * here * room).min(0.3 * (1.0 - way) * spacing * float(teeth));
            let cut = room * missing(margin.kind, way * float(teeth));
            let point = smooth[i] + inward * cut;
            Vec2::new(point.x, point.y.max(0.0))
        })
        .collect()
}

/// How much of a tooth's depth is cut away at a place along it; whole numbers are between teeth.
fn missing(kind: MarginKind, place: f32) -> f32 {
    let saw = |place: f32| {
        let at = place - place.floor();
        if at < TIP {
            1.0 - at / TIP
        } else {
            (at - TIP) / (1.0 - TIP)
        }
    };
    let at = place - place.floor();
    match kind {
        MarginKind::Entire => 0.0,
        MarginKind::Serrate => saw(place),
        MarginKind::DoublySerrate => 0.68 * saw(place) + 0.32 * saw(place * 3.0),
        MarginKind::Crenate => {
            let x = 2.0 * at - 1.0;
            1.0 - (1.0 - x * x).max(0.0).sqrt()
        }
        MarginKind::Dentate => {
            // A narrow point between wide hollows.
            let x = (2.0 * at - 1.0).abs();
            1.0 - (1.0 - x) * (1.0 - x)
        }
        MarginKind::Wavy => 0.5 + 0.5 * libm::cosf(core::f32::consts::TAU * at),
    }
}

/// `steps + 1` points evenly along a line.
fn resampled(points: &[Vec2], steps: u32) -> Vec<Vec2> {
    let total = length(points);
    let mut out = Vec::with_capacity(steps as usize + 1);
    let (mut index, mut passed) = (0, 0.0);
    for i in 0..=steps {
        let target = total * float(i) / float(steps);
        while index + 2 < points.len() {
            let piece = points[index].distance(points[index + 1]);
            if passed + piece >= target {
                break;
            }
            passed += piece;
            index += 1;
        }
        let (a, b) = (points[index], points[index + 1]);
        let piece = a.distance(b).max(1e-9);
        out.push(a.lerp(b, ((target - passed) / piece).clamp(0.0, 1.0)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saw_teeth_point_to_the_tip_and_crenate_ones_are_even() {
        assert_eq!(missing(MarginKind::Serrate, 3.75), 0.0);
        assert!(missing(MarginKind::Serrate, 3.5) < missing(MarginKind::Serrate, 3.25));
        for x in [0.1, 0.3, 0.45] {
            let (low, high) = (
                missing(MarginKind::Crenate, x),
                missing(MarginKind::Crenate, 1.0 - x),
            );
            assert!((low - high).abs() < 1e-5);
        }
        assert!(missing(MarginKind::Dentate, 0.25) > 0.7);
    }

    #[test]
    fn resampling_spaces_points_evenly() {
        let points = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(1.0, 3.0)];
        let even = resampled(&points, 8);
        assert_eq!(even.len(), 9);
        for pair in even.windows(2) {
            assert!((pair[0].distance(pair[1]) - 0.5).abs() < 1e-5);
        }
    }
}

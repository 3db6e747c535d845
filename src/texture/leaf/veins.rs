//! Main and side veins of a blade as lines with a width, by type.
//!
//! Side veins are walked from where they leave a main vein until the outline stops them, so they fit
//! any outline: lobes, heart bases, oblique halves.

use super::distance::Segment;
use super::outline::{axes, lobe_ends};
use crate::math::{PI, Vec2, lerp};
use crate::species::schema::{Blade, Lobes, Veins};

/// Half width of a midrib at its foot and at its tip, in blade lengths, where the blade is wide.
const MIDRIB: [f32; 2] = [0.0105, 0.0028];
/// Half width of a side vein at its foot and its end, in blade lengths.
const SIDE: [f32; 2] = [0.0052, 0.0022];
/// Steps of a side vein.
const STEPS: u32 = 28;
/// How close a looping vein comes to the margin, as a part of half the blade's width.
const LOOP_GAP: f32 = 0.16;

/// All veins of a blade; `depth` is how deep inside the outline a point is (negative outside).
pub(super) fn veins(blade: &Blade, depth: &impl Fn(Vec2) -> f32) -> Vec<Segment> {
    let mut lines = Lines {
        segments: Vec::new(),
        half: 0.5 * blade.width,
        depth,
    };
    let lobed = matches!(blade.lobes, Lobes::Palmate { .. });
    match blade.veins {
        Veins::Midrib => {
            lines.main(0.0, 0.99);
        }
        Veins::Pinnate { angle_deg, .. } if matches!(blade.lobes, Lobes::Pinnate { .. }) => {
            lines.main(0.0, 0.97);
            lines.lobe_veins(&lobe_ends(blade), angle_deg.to_radians());
        }
        Veins::Pinnate { pairs, angle_deg } if !lobed => {
            let length = lines.main(0.0, 0.99);
            lines.sides(0.0, length, pairs, angle_deg.to_radians(), None);
        }
        Veins::Looping { pairs, angle_deg } if !lobed => {
            let length = lines.main(0.0, 0.99);
            let gap = LOOP_GAP * lines.half;
            lines.sides(0.0, length, pairs, angle_deg.to_radians(), Some(gap));
        }
        Veins::Parallel { count } => {
            lines.main(0.0, 0.99);
            lines.parallel(count);
        }
        Veins::Pinnate { pairs, .. } | Veins::Looping { pairs, .. } => {
            lines.palmate(blade, 5, pairs);
        }
        Veins::Palmate { count, pairs } => lines.palmate(blade, count, pairs),
    }
    lines.segments
}

struct Lines<'f, F> {
    segments: Vec<Segment>,
    half: f32,
    depth: &'f F,
}

impl<F: Fn(Vec2) -> f32> Lines<'_, F> {
    fn line(&mut self, points: &[Vec2], radius: [f32; 2]) {
        let last = points.len().saturating_sub(1).max(1) as f32;
        for (i, pair) in points.windows(2).enumerate() {
            let at = |i: usize| lerp(radius[0], radius[1], i as f32 / last);
            self.segments.push(Segment {
                from: pair[0],
                to: pair[1],
                radius: [at(i), at(i + 1)],
            });
        }
    }

    /// A straight main vein from the foot; returns its length.
    fn main(&mut self, angle: f32, length: f32) -> f32 {
        let (sine, cosine) = libm::sincosf(angle);
        let direction = Vec2::new(cosine, sine);
        // As far as the blade reaches.
        let mut reach = 0.0;
        let mut points = Vec::new();
        for i in 0..=40_u8 {
            let at = length * f32::from(i) / 40.0;
            if i > 2 && (self.depth)(direction * at) < 0.0 {
                break;
            }
            points.push(direction * at);
            reach = at;
        }
        let slim = (self.half * 0.14).min(MIDRIB[0]);
        self.line(&points, [slim, MIDRIB[1].min(slim)]);
        reach
    }

    /// Side veins of a main vein to both sides.
    fn sides(&mut self, axis: f32, length: f32, pairs: u32, angle: f32, gap: Option<f32>) {
        let (sine, cosine) = libm::sincosf(axis);
        let along = Vec2::new(cosine, sine);
        let slim = (self.half * 0.05).min(1.0);
        for pair in 0..pairs {
            for side in [-1.0, 1.0] {
                let shift = if side < 0.0 { 0.22 } else { 0.5 };
                let way = (pair as f32 + shift) / (pairs as f32 + 0.35);
                let start = along * (length * lerp(0.02, 0.94, way));
                // The upper ones are steeper.
                let turn = axis + side * angle * lerp(1.1, 0.72, way);
                self.side(start, turn, -side, length, gap, slim * lerp(1.0, 0.5, way));
            }
        }
    }

    /// A side vein to the end of each lobe.
    fn lobe_veins(&mut self, ends: &[Vec2], angle: f32) {
        // Lobes lie flatter than free side veins: so do those that run into them.
        let cotangent = 0.6 / libm::tanf(angle.clamp(0.3, 1.5));
        for end in ends {
            let start = Vec2::new((end.x - cotangent * end.y).max(0.02), 0.0);
            for side in [-1.0, 1.0] {
                let points: Vec<Vec2> = (0..=16_u8)
                    .map(|i| {
                        let way = 0.94 * f32::from(i) / 16.0;
                        let straight = start.lerp(*end, way);
                        // Arched a little toward the tip.
                        let arch = 0.05 * (end.y) * 4.0 * way * (1.0 - way);
                        Vec2::new(straight.x - arch, side * straight.y)
                    })
                    .collect();
                self.line(&points, [1.15 * SIDE[0], SIDE[1]]);
            }
        }
    }

    /// One side vein, bending toward the tip as it goes: `bend` is the sign of its turn.
    fn side(
        &mut self,
        start: Vec2,
        turn: f32,
        bend: f32,
        length: f32,
        gap: Option<f32>,
        slim: f32,
    ) {
        let step = 0.026 * length.max(0.2);
        let mut turn = turn;
        let mut point = start;
        let mut points = vec![start];
        let mut looped = 0;
        for i in 0..STEPS * 2 {
            let (sine, cosine) = libm::sincosf(turn);
            let next = point + Vec2::new(cosine, sine) * step;
            let depth = (self.depth)(next);
            if depth < 0.0 {
                break;
            }
            let near = gap.is_some_and(|gap| i > 2 && depth < gap);
            if near || looped > 0 {
                // Round inside the margin to meet the next vein, and no further.
                turn += bend * 0.2;
                looped += 1;
                if looped > 7 {
                    break;
                }
            } else {
                turn += bend * if gap.is_some() { 0.022 } else { 0.011 };
            }
            point = next;
            points.push(point);
        }
        let radius = [SIDE[0], SIDE[1]].map(|radius| radius.min(slim * radius / SIDE[0]));
        self.line(&points, radius);
    }

    /// Veins beside the midrib, each at its part of the half width.
    fn parallel(&mut self, count: u32) {
        let mut widths = Vec::new();
        for i in 0..=40_u8 {
            let u = lerp(0.01, 0.985, f32::from(i) / 40.0);
            // Outward until the outline.
            let mut low = 0.0;
            let mut high = self.half * 1.2;
            for _ in 0..12 {
                let middle = 0.5 * (low + high);
                if (self.depth)(Vec2::new(u, middle)) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            widths.push((u, low));
        }
        let slim = (0.25 * self.half / (count as f32 + 1.0)).min(0.5 * SIDE[0]);
        for i in 1..=count {
            let part = i as f32 / (count as f32 + 0.6);
            for side in [-1.0, 1.0] {
                let points: Vec<Vec2> = widths
                    .iter()
                    .map(|&(u, w)| Vec2::new(u, side * w * part))
                    .collect();
                self.line(&points, [slim, 0.7 * slim]);
            }
        }
    }

    /// Main veins from the foot with side veins.
    fn palmate(&mut self, blade: &Blade, count: u32, pairs: u32) {
        let mains: Vec<(f32, f32)> = if let Lobes::Palmate { .. } = blade.lobes {
            let axes = axes(blade);
            axes.iter()
                .map(|axis| (axis.angle, 0.97 * axis.length))
                .collect()
        } else {
            let count = count.clamp(1, 15);
            let middle = ((count as f32 - 1.0) * 0.5).max(1.0);
            (0..count)
                .map(|i| (i as f32 - (count as f32 - 1.0) * 0.5) / middle)
                // Fanned over a right angle and a half, none below the foot.
                .map(|way| (way * 0.42 * PI, lerp(0.99, 0.75, way.abs())))
                .collect()
        };
        for &(angle, length) in &mains {
            let length = self.main(angle, length);
            let pairs = if angle.abs() < 0.1 {
                pairs
            } else {
                (pairs * 2).div_ceil(3)
            };
            // From a third on, so that side veins do not cross near the foot.
            self.palmate_sides(angle, length, pairs);
        }
    }

    fn palmate_sides(&mut self, axis: f32, length: f32, pairs: u32) {
        let (sine, cosine) = libm::sincosf(axis);
        let along = Vec2::new(cosine, sine);
        for pair in 0..pairs {
            for side in [-1.0, 1.0] {
                let shift = if side < 0.0 { 0.3 } else { 0.6 };
                let way = (pair as f32 + shift) / (pairs as f32 + 0.3);
                let start = along * (length * lerp(0.3, 0.95, way));
                let slim = (self.half * 0.05).min(1.0) * lerp(0.9, 0.5, way);
                self.side(start, axis + side * 0.75, -side, 0.6 * length, None, slim);
            }
        }
    }
}

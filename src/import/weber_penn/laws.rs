//! The model's laws over the position on a parent: length, thickness, angle.

use super::levels::Planner;
use super::shape::{bends, down_angle, leaving, pruned, shape_ratio, taper};
use super::words::angle;
use crate::math::{float, round_to_u32};
use crate::species::schema::Curve;

/// Positions at which laws over the parent are kept.
const STEPS: u32 = 5;

/// Positions from `start` to the tip, and the way of each, 0..=1.
pub(super) fn positions(start: f32) -> Vec<(f32, f32)> {
    (0..STEPS)
        .map(|step| {
            let way = float(step) / float(STEPS - 1);
            (start + (1.0 - start) * way, way)
        })
        .collect()
}

impl Planner<'_> {
    /// Length of a level's nodes over their position, as a part of the longest.
    pub(super) fn scales(&self, level: usize, at: &[(f32, f32)], bent: &[f32]) -> Vec<(f32, f32)> {
        let p = self.p;
        let shape = round_to_u32(p.get("Shape"));
        let tree = p.get("Scale") * p.get("ZScale") * p.of(0, "Length");
        at.iter()
            .map(|&(x, way)| {
                let scale = if level == 1 {
                    let mut ratio = shape_ratio(shape, 1.0 - way);
                    if p.get("PruneRatio") > 0.0 {
                        let height = tree * (self.base() + (1.0 - self.base()) * x);
                        let down = down_angle(p.of(1, "DownAngle"), p.of(1, "DownAngleV"), way);
                        let length = tree * p.of(1, "Length") * ratio;
                        ratio *= pruned(p, height, length, bent, down);
                    }
                    ratio
                } else {
                    (1.0 - 0.6 * x) * self.above_ground(level, x)
                };
                (x, scale.max(0.05))
            })
            .collect()
    }

    /// Height of the foot of the limbs' carrier, as a part of the trunk.
    pub(super) fn base(&self) -> f32 {
        if self.leaders > 1 { self.bole } else { 0.0 }
    }

    /// Part of its length at which a branch that hangs from a low limb ends above the ground.
    pub(super) fn above_ground(&self, level: usize, x: f32) -> f32 {
        let p = self.p;
        if level != 2 || p.get("AttractionUp") >= -0.5 {
            return 1.0;
        }
        let tree = p.get("Scale") * p.get("ZScale") * p.of(0, "Length");
        // A limb a fifth of the way up the crown stands for the lower ones.
        let way = 0.2;
        let place = self.start(1) + (1.0 - self.start(1)) * way;
        let foot = tree * (self.base() + (1.0 - self.base()) * place);
        let down = down_angle(p.of(1, "DownAngle"), p.of(1, "DownAngleV"), way);
        let limb = tree * p.of(1, "Length") * shape_ratio(round_to_u32(p.get("Shape")), 1.0 - way);
        let points = leaving(&bends(p, 1), down);
        let last = u32::try_from(points.len() - 1).unwrap_or(1);
        let index = round_to_u32(x * float(last)).min(last) as usize;
        let height = foot + points.get(index).map_or(0.0, |point| point.1) * limb;
        let free = 0.9 * height - p.get("BaseSize").max(0.08) * p.get("Scale");
        let hanging = limb * p.of(2, "Length") * (1.0 - 0.6 * x);
        (free / hanging.max(1e-3)).clamp(0.1, 1.0)
    }

    /// Thickness beside `radius_of_parent`: the model's radius goes with a power of the length, and not with
    /// the parent's where the branch leaves it.
    pub(super) fn thickness(
        &self,
        level: usize,
        at: &[(f32, f32)],
        scale: &[(f32, f32)],
        lengths: f32,
    ) -> Vec<(f32, f32)> {
        let p = self.p;
        let parent = Curve {
            points: if level == 1 && self.leaders > 1 {
                self.trunk_taper(self.bole, 1.0)
            } else {
                taper(p.of(level - 1, "Taper"))
            },
        };
        // Above a length of 1 the radius stays the parent's.
        let over = libm::powf(lengths.max(1.0), p.get("RatioPower"));
        at.iter()
            .zip(scale)
            .map(|(&(x, _), &(_, scale))| {
                let wanted = libm::powf(scale, p.get("RatioPower")) * over;
                (x, (wanted / parent.at(x).max(0.03)).clamp(0.05, 6.0))
            })
            .collect()
    }

    pub(super) fn down(&self, level: usize, at: &[(f32, f32)]) -> String {
        let p = self.p;
        let (down, vary) = (p.of(level, "DownAngle"), p.of(level, "DownAngleV"));
        if vary < 0.0 {
            let (first, last) = (at.first(), at.last());
            let ends: Vec<(f32, f32)> = first
                .into_iter()
                .chain(last)
                .map(|&(x, way)| (x, down_angle(down, vary, way)))
                .collect();
            angle(&ends, 4.0)
        } else {
            angle(&[(0.0, down)], vary)
        }
    }
}

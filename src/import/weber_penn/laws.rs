//! The model's laws over the position on a parent: length, thickness, angle.

use super::levels::Planner;
use super::shape::{bends, down_angle, leaving, pruned, shape_ratio, taper};
use super::words::angle;
use crate::math::{float, round_to_u32};
use crate::species::schema::Curve;

/// Height over the ground at which hanging branches end at the least, as a part of the tree's scale.
const CLEAR: f32 = 0.13;
/// What is left of heights by chance, of angles and of bends.
const UPRIGHT: f32 = 0.9;
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
                        let (sine, cosine) = libm::sincosf(self.lean().to_radians());
                        let along = tree * (1.0 - self.base()) * x;
                        let foot = (along * sine, tree * self.base() + along * cosine);
                        let length = tree * p.of(1, "Length") * ratio;
                        ratio *= pruned(p, foot, length, bent, self.limb_down(way));
                    }
                    ratio * self.low_limb(way)
                } else {
                    (1.0 - 0.6 * x) * if level == 2 { self.hanging(x) } else { 1.0 }
                };
                (x, scale.max(0.05))
            })
            .collect()
    }

    /// Height of the foot of the limbs' carrier, as a part of the trunk.
    pub(super) fn base(&self) -> f32 {
        if self.leaders > 1 { self.bole } else { 0.0 }
    }

    /// True if branches on limbs hang down.
    fn weeps(&self) -> bool {
        self.p.get("AttractionUp") < -0.5 && self.p.get("Levels") > 2.5
    }

    /// Angle from the upright of a limb on the outer side of its leader or trunk, degrees.
    fn limb_down(&self, way: f32) -> f32 {
        let (down, vary) = (self.p.of(1, "DownAngle"), self.p.of(1, "DownAngleV"));
        self.lean() + down_angle(down, vary, way)
    }

    /// A limb part of the way up the crown: height of its foot, its length, and how high each part of its way
    /// lies above the foot, metres.
    fn limb(&self, way: f32) -> (f32, f32, Vec<f32>) {
        let p = self.p;
        let tree = p.get("Scale") * p.get("ZScale") * p.of(0, "Length");
        let place = self.start(1) + (1.0 - self.start(1)) * way;
        let upright = libm::cosf(self.lean().to_radians());
        let foot = tree * (self.base() + (1.0 - self.base()) * place * upright);
        let down = self.limb_down(way);
        let shape = round_to_u32(p.get("Shape"));
        let length = tree * p.of(1, "Length") * shape_ratio(shape, 1.0 - way);
        let points = leaving(&bends(p, 1), down);
        let rises = points.iter().map(|point| point.1 * length).collect();
        (foot, length, rises)
    }

    /// Part of its length at which a branch that hangs from a limb in the middle of the crown, at `x` of the
    /// limb's way, ends above the ground.
    fn hanging(&self, x: f32) -> f32 {
        if !self.weeps() {
            return 1.0;
        }
        let (foot, length, rises) = self.limb(0.5);
        let free = UPRIGHT * (foot + at(&rises, x)) - self.clear();
        (free / self.longest(length, x).max(1e-3)).clamp(0.1, 1.0)
    }

    /// Part of its size at which a limb below the middle of the crown keeps what hangs on it off the ground.
    fn low_limb(&self, way: f32) -> f32 {
        if !self.weeps() || way >= 0.5 {
            return 1.0;
        }
        let (foot, length, rises) = self.limb(way);
        let fits = |x: f32| {
            let hangs = self.longest(length, x) * self.hanging(x) - UPRIGHT * at(&rises, x);
            let free = UPRIGHT * foot - self.clear();
            if hangs > free { free / hangs } else { 1.0 }
        };
        let least = (1..=5_u8).map(|fifth| fits(f32::from(fifth) * 0.2));
        least.fold(1.0, f32::min).max(0.1)
    }

    /// Length of a branch at `x` of the way of a limb of this length, with the leaves at its end.
    fn longest(&self, limb: f32, x: f32) -> f32 {
        let longest = self.length_of_parent(2, self.p.of(2, "Length"));
        limb * longest * (1.0 - 0.6 * x) * 1.1
    }

    fn clear(&self) -> f32 {
        self.p.get("BaseSize").max(CLEAR) * self.p.get("Scale")
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

/// The value at part `x` of a list's length.
fn at(list: &[f32], x: f32) -> f32 {
    let last = u32::try_from(list.len().saturating_sub(1)).unwrap_or(0);
    let index = round_to_u32(x * float(last)).min(last) as usize;
    list.get(index).copied().unwrap_or(0.0)
}

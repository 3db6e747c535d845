//! What lies on a card: copies of blades and pieces of stems, in the card's plane.
//!
//! Card coordinates: x to the right from the middle, y up from the lower edge, in card lengths.

use super::blade::{BladeMap, PAD};
use crate::math::{Vec2, lerp};

/// How far the shade of a blade reaches over those below it, in card lengths.
pub(super) const SHADE_REACH: f32 = 0.03;

/// What a thing is painted as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Paint {
    /// Green tissue of a blade.
    Leaf,
    /// A leaf stalk or a rachis: between leaf and wood.
    Stalk,
    /// A twig.
    Wood,
    /// A petal.
    Petal,
    /// The middle of a flower.
    Eye,
}

/// One copy of a blade.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    /// Which blade: 0 leaf, 1 petal.
    pub(super) map: usize,
    /// Where its foot is.
    pub(super) base: Vec2,
    /// Unit vector along the midrib at the base.
    pub(super) along: Vec2,
    /// Length, card lengths.
    pub(super) length: f32,
    /// Sideways bow of the midrib, in blade lengths.
    pub(super) bow: f32,
    /// Width factor of a blade seen partly edge-on.
    pub(super) narrow: f32,
    /// Slope of the whole blade along card x and y.
    pub(super) tilt: Vec2,
    /// Factors on the colour.
    pub(super) tint: [f32; 3],
    /// True if the paler underside shows.
    pub(super) underside: bool,
    /// How early it turns in autumn, -1..1.
    pub(super) haste: f32,
    /// Shift of spots and holes, 0..1.
    pub(super) shift: f32,
}

/// A straight piece of a twig or stalk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stem {
    pub(super) from: Vec2,
    pub(super) to: Vec2,
    /// Radius at both ends, card lengths.
    pub(super) radius: [f32; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Blade(Pose),
    Stem(Stem),
}

/// One thing on the card.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) shape: Shape,
    pub(super) paint: Paint,
    /// Height above the twig (0): what is higher lies on top.
    pub(super) rank: f32,
    /// Smallest and largest corner.
    pub(super) low: Vec2,
    pub(super) high: Vec2,
}

impl Pose {
    /// The point in the blade's frame, `u` along and `v` across, in blade lengths.
    pub(super) fn local(&self, point: Vec2) -> Vec2 {
        let from_base = point - self.base;
        let u = from_base.dot(self.along) / self.length;
        let v = self.along.perp_dot(from_base) / self.length;
        // An arc to both sides of the chord, so that a bow moves base and tip nowhere.
        let way = u.clamp(0.0, 1.0);
        Vec2::new(u, (v - self.bow * 4.0 * way * (1.0 - way)) / self.narrow)
    }

    /// The inverse of [`Self::local`].
    fn card_point(&self, local: Vec2) -> Vec2 {
        let way = local.x.clamp(0.0, 1.0);
        let across = local.y * self.narrow + self.bow * 4.0 * way * (1.0 - way);
        self.base + (self.along * local.x + self.along.perp() * across) * self.length
    }

    /// A slope in the blade's frame as one along card x and y.
    pub(super) fn card_slope(&self, slope: Vec2) -> Vec2 {
        self.along * slope.x + self.along.perp() * slope.y + self.tilt
    }

    /// How far the blade's shade reaches, card lengths: small things cast small shades.
    pub(super) fn shade_reach(&self) -> f32 {
        SHADE_REACH.min(PAD * self.length)
    }
}

impl Stem {
    /// Way past its side, and the place across it, -1..=1 on it; negative on the stem.
    pub(super) fn outside(&self, point: Vec2) -> (f32, f32) {
        let along = self.to - self.from;
        let from = point - self.from;
        let way = (from.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let radius = lerp(self.radius[0], self.radius[1], way);
        let distance = (from - along * way).length();
        let side = along.normalize_or(Vec2::Y).perp_dot(from);
        (distance - radius, -side / radius.max(1e-9))
    }
}

impl Element {
    pub(super) fn new(shape: Shape, paint: Paint, rank: f32, maps: &[BladeMap]) -> Self {
        let mut element = Self {
            shape,
            paint,
            rank,
            low: Vec2::ZERO,
            high: Vec2::ZERO,
        };
        element.measure(maps);
        element
    }

    fn measure(&mut self, maps: &[BladeMap]) {
        match &self.shape {
            Shape::Blade(pose) => {
                self.low = pose.base;
                self.high = pose.base;
                for &point in &maps[pose.map].rim {
                    let point = pose.card_point(point);
                    self.low = self.low.min(point);
                    self.high = self.high.max(point);
                }
            }
            Shape::Stem(stem) => {
                let pad = Vec2::splat(stem.radius[0].max(stem.radius[1]));
                self.low = stem.from.min(stem.to) - pad;
                self.high = stem.from.max(stem.to) + pad;
            }
        }
    }

    /// Makes it `factor` times as large about a point, and then moves it.
    pub(super) fn scale(&mut self, about: Vec2, factor: f32, shift: Vec2) {
        let moved = |point: Vec2| about + (point - about) * factor + shift;
        match &mut self.shape {
            Shape::Blade(pose) => {
                pose.base = moved(pose.base);
                pose.length = (pose.length * factor).max(1e-4);
            }
            Shape::Stem(stem) => {
                stem.from = moved(stem.from);
                stem.to = moved(stem.to);
                stem.radius = stem.radius.map(|radius| radius * factor);
            }
        }
        self.low = moved(self.low);
        self.high = moved(self.high);
    }

    /// Way past the outline, card lengths; negative on it. Beyond the shade's reach only roughly.
    pub(super) fn outside(&self, maps: &[BladeMap], point: Vec2) -> f32 {
        match &self.shape {
            Shape::Blade(pose) => {
                let local = pose.local(point);
                let map = &maps[pose.map];
                let beyond = (map.low - local).max(local - map.high).max_element();
                if beyond > PAD {
                    return beyond * pose.length;
                }
                map.outside(local.x, local.y).max(beyond) * pose.length
            }
            Shape::Stem(stem) => stem.outside(point).0,
        }
    }

    /// How far its shade reaches, card lengths.
    pub(super) fn shade_reach(&self) -> f32 {
        match &self.shape {
            Shape::Blade(pose) => pose.shade_reach(),
            Shape::Stem(_) => 0.0,
        }
    }
}

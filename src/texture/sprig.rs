//! Where the blades of a leaf card are: a list of blades in the card's plane, topmost first.
//!
//! Card coordinates: x to the right from the middle, y up from the lower edge, in card lengths.

use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::blade::Outline;
use crate::math::{PI, Vec2, lerp};
use crate::rng::{Key, Parameter, unit_from_bits};
use crate::species::schema::{Arrangement, LeafArt};

/// Blades on one card beyond this are left out: they could not be told apart.
const MOST_BLADES: u32 = 128;
/// Radius of the twig at its foot and at its tip, in card lengths.
const TWIG: [f32; 2] = [0.008, 0.0045];
/// Radius of a petiole, in blade lengths.
pub(super) const PETIOLE_RADIUS: f32 = 0.011;
/// How far the shade of a blade reaches over those below it, in card lengths.
pub(super) const SHADE_REACH: f32 = 0.03;

/// One blade on the card.
#[derive(Clone, Debug)]
pub(super) struct PlacedBlade {
    /// Where its petiole starts.
    base: Vec2,
    /// Unit vector along the midrib at the base.
    along: Vec2,
    /// Length without the petiole, card lengths.
    length: f32,
    /// Petiole, in blade lengths.
    petiole: f32,
    /// Sideways bow of the midrib, in blade lengths.
    bow: f32,
    /// Width factor of a blade seen partly edge-on.
    narrow: f32,
    /// Slope of the whole blade along card x and y.
    pub(super) tilt: Vec2,
    /// Factors on the colour.
    pub(super) tint: [f32; 3],
    /// True if the paler underside shows.
    pub(super) underside: bool,
    /// Shift of the veins, 0..1.
    pub(super) shift: f32,
    /// Smallest and largest corner, shade included.
    low: Vec2,
    high: Vec2,
}

/// The twig that carries the blades.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twig {
    /// Height of its tip, card lengths.
    top: f32,
    /// Sideways bow, card lengths.
    bow: f32,
}

/// All that is on a card.
pub(super) struct Sprig {
    /// Topmost first.
    pub(super) blades: Vec<PlacedBlade>,
    /// How many of the blades lie above the twig.
    pub(super) above_twig: usize,
    pub(super) twig: Option<Twig>,
}

impl PlacedBlade {
    /// The point in the blade's frame, `u` along and `v` across, in blade lengths.
    pub(super) fn local(&self, point: Vec2) -> (f32, f32) {
        let from_base = point - self.base;
        let u = from_base.dot(self.along) / self.length - self.petiole;
        let v = self.along.perp_dot(from_base) / self.length;
        // An arc to both sides of the chord, so that a bow moves base and tip nowhere.
        let way = u.clamp(0.0, 1.0);
        (u, (v - self.bow * 4.0 * way * (1.0 - way)) / self.narrow)
    }

    /// The inverse of [`Self::local`].
    fn card_point(&self, u: f32, v: f32) -> Vec2 {
        let way = u.clamp(0.0, 1.0);
        let across = v * self.narrow + self.bow * 4.0 * way * (1.0 - way);
        self.base + (self.along * (u + self.petiole) + self.along.perp() * across) * self.length
    }

    /// A slope in the blade's frame as one along card x and y.
    pub(super) fn card_slope(&self, slope: Vec2) -> Vec2 {
        self.along * slope.x + self.along.perp() * slope.y + self.tilt
    }

    /// Way past the outline, in card lengths; `None` on the blade or its petiole.
    pub(super) fn outside(&self, outline: &Outline, u: f32, v: f32) -> Option<f32> {
        let past_side = v.abs() - outline.half_at(u.clamp(0.0, 1.0));
        let past_end = (-u).max(u - 1.0);
        let on_petiole = u < 0.0 && u >= -self.petiole && v.abs() * self.narrow < PETIOLE_RADIUS;
        if on_petiole || (past_end <= 0.0 && past_side < 0.0) {
            return None;
        }
        let (x, y) = (past_end.max(0.0), past_side.max(0.0));
        Some((x * x + y * y).sqrt() * self.length)
    }

    /// True if the point's neighbourhood may hold part of the blade or its shade.
    pub(super) fn near(&self, point: Vec2, margin: f32) -> bool {
        point.x > self.low.x - margin
            && point.y > self.low.y - margin
            && point.x < self.high.x + margin
            && point.y < self.high.y + margin
    }

    fn measure(&mut self, outline: &Outline) {
        self.low = self.base;
        self.high = self.base;
        for i in 0..=32_u8 {
            let u = f32::from(i) / 32.0;
            let half = outline.half_at(u).max(PETIOLE_RADIUS);
            for v in [-half, half] {
                let point = self.card_point(u, v);
                self.low = self.low.min(point);
                self.high = self.high.max(point);
            }
        }
    }

    /// Shortens the blade until it stays within the card.
    fn fit(&mut self, outline: &Outline, half_width: f32, top: f32, foot: f32) {
        for _ in 0..4 {
            self.measure(outline);
            let ratio = |reach: f32, room: f32| {
                if reach > room {
                    room.max(0.0) / reach
                } else {
                    1.0
                }
            };
            let shrink = ratio(self.high.x - self.base.x, half_width - self.base.x)
                .min(ratio(self.base.x - self.low.x, half_width + self.base.x))
                .min(ratio(self.high.y - self.base.y, top - self.base.y))
                .min(ratio(self.base.y - self.low.y, self.base.y - foot));
            if shrink >= 1.0 {
                break;
            }
            self.length = (self.length * shrink * 0.995).max(1e-4);
        }
        self.measure(outline);
        self.low -= Vec2::splat(SHADE_REACH);
        self.high += Vec2::splat(SHADE_REACH);
    }
}

impl Twig {
    fn middle(&self, y: f32) -> f32 {
        let way = (y / self.top).clamp(0.0, 1.0);
        self.bow * way * (1.0 - way) * 4.0
    }

    /// Place across the twig, -1..=1; `None` beside it.
    pub(super) fn across(&self, point: Vec2, foot: f32) -> Option<f32> {
        if point.y < foot || point.y > self.top {
            return None;
        }
        let radius = lerp(TWIG[0], TWIG[1], point.y / self.top);
        let across = (point.x - self.middle(point.y)) / radius;
        (across.abs() <= 1.0).then_some(across)
    }
}

/// What the builder needs to know of the card: sizes in card lengths.
pub(super) struct Card {
    /// Half the card's width.
    pub(super) half_width: f32,
    /// Free border along the sides, and along the ends.
    pub(super) border: Vec2,
}

/// The blades of a card; `outline` must be that of its blade.
pub(super) fn sprig(art: &LeafArt, outline: &Outline, card: &Card, seed: u64) -> Sprig {
    let key = Key::of_seed(seed).level("leaf");
    match art.arrangement {
        Arrangement::Single => single(outline, card, key),
        Arrangement::Opposite {
            pairs,
            angle_deg,
            blade,
        } => {
            let nodes = pairs.min(MOST_BLADES / 2);
            Builder::new(art, outline, card, key, blade).grow(nodes, 2, angle_deg)
        }
        Arrangement::Alternate {
            count,
            angle_deg,
            blade,
        } => {
            let nodes = count.min(MOST_BLADES);
            Builder::new(art, outline, card, key, blade).grow(nodes, 1, angle_deg)
        }
    }
}

/// One blade from the lower border to the upper one.
fn single(outline: &Outline, card: &Card, key: Key) -> Sprig {
    let length = 1.0 - 2.0 * card.border.y;
    // The bow takes little of the width, which the outline already leaves free.
    let bow = key.signed(Parameter::Texture) * 0.015 * outline.half();
    let mut blade = PlacedBlade {
        base: Vec2::new(0.0, card.border.y),
        along: Vec2::Y,
        length,
        petiole: 0.0,
        bow,
        narrow: 1.0,
        tilt: Vec2::ZERO,
        tint: [1.0; 3],
        underside: false,
        shift: key.with(1).unit(Parameter::Texture),
        low: Vec2::ZERO,
        high: Vec2::ZERO,
    };
    blade.measure(outline);
    Sprig {
        blades: vec![blade],
        above_twig: 1,
        twig: None,
    }
}

/// Grows a twig with blades.
struct Builder<'a> {
    art: &'a LeafArt,
    outline: &'a Outline,
    card: &'a Card,
    key: Key,
    /// Length of a blade, card lengths.
    blade: f32,
}

impl<'a> Builder<'a> {
    fn new(art: &'a LeafArt, outline: &'a Outline, card: &'a Card, key: Key, blade: f32) -> Self {
        Self {
            art,
            outline,
            card,
            key,
            blade: blade.clamp(0.02, 0.95),
        }
    }

    fn grow(&self, nodes: u32, per_node: u32, angle_deg: f32) -> Sprig {
        let petiole = if per_node == 2 { 0.06 } else { 0.22 };
        let twig = Twig {
            top: (1.0 - self.card.border.y - self.blade * 0.92 * (1.0 + petiole * 0.5)).max(0.04),
            bow: self.key.signed(Parameter::Texture) * 0.03,
        };
        let mut ranked: Vec<(f32, PlacedBlade)> = Vec::new();
        let first = if nodes > 1 { 0.14 } else { 0.5 };
        for node in 0..nodes {
            let way = (node as f32 + 0.5) / nodes as f32;
            for side in 0..per_node {
                let mut draws = self.draws(node, side);
                let turn = if per_node == 2 { side } else { node };
                let sign = if turn.is_multiple_of(2) { -1.0 } else { 1.0 };
                // Blades spread less toward the tip, and are smaller there and at the foot.
                let angle =
                    angle_deg.to_radians() * lerp(1.15, 0.75, way) + 0.16 * signed(&mut draws);
                let y = twig.top * (lerp(first, 0.97, way) + 0.02 * signed(&mut draws));
                let size = self.blade
                    * (1.0 - 0.35 * (way - 0.4).max(0.0) - 0.3 * (0.35 - way).max(0.0))
                    * (1.0 + 0.1 * signed(&mut draws));
                let base = Vec2::new(twig.middle(y), y);
                let blade = self.blade_at(base, sign * angle, size, petiole, &mut draws);
                // Pairs stand crosswise: every other one lies more to the front.
                let front = if node.is_multiple_of(2) { 0.35 } else { -0.35 };
                ranked.push((front + signed(&mut draws), blade));
            }
        }
        let mut draws = self.draws(nodes, 2);
        let angle = 0.12 * signed(&mut draws);
        let size = self.blade * 0.92;
        let base = Vec2::new(twig.middle(twig.top), twig.top - 0.004);
        let tip = self.blade_at(base, angle, size, petiole * 0.5, &mut draws);
        ranked.push((0.2 * signed(&mut draws), tip));
        // Stable, so that equal ranks keep their order.
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        Sprig {
            above_twig: ranked.iter().filter(|(rank, _)| *rank > 0.0).count(),
            blades: ranked.into_iter().map(|(_, blade)| blade).collect(),
            twig: Some(twig),
        }
    }

    fn draws(&self, node: u32, side: u32) -> Pcg64Mcg {
        let key = self.key.with(u64::from(node)).with(u64::from(side));
        key.stream(Parameter::Texture)
    }

    /// A blade that leaves `base` at `angle` from straight up, clockwise.
    fn blade_at(
        &self,
        base: Vec2,
        angle: f32,
        length: f32,
        petiole: f32,
        draws: &mut Pcg64Mcg,
    ) -> PlacedBlade {
        let along = Vec2::new(libm::sinf(angle), libm::cosf(angle));
        let outward = along.x;
        let value = 1.0 + self.art.colour_vary * signed(draws);
        let warm = 0.8 * self.art.colour_vary.min(0.4) * signed(draws);
        let roll = 0.5 * signed(draws);
        let pitch = 0.3 * signed(draws);
        let mut blade = PlacedBlade {
            base,
            along,
            length,
            petiole: petiole * (1.0 + 0.3 * signed(draws)),
            // Side blades bow up toward the light.
            bow: -0.05 * outward + 0.03 * signed(draws),
            narrow: libm::cosf(roll * PI * 0.3),
            tilt: along.perp() * roll + along * pitch - Vec2::new(0.22 * outward, 0.06),
            tint: [
                value * (1.0 + 0.7 * warm),
                value,
                value * (1.0 - 0.2 * warm),
            ],
            underside: unit_from_bits(draws.next_u32()) < 0.14,
            shift: unit_from_bits(draws.next_u32()),
            low: base,
            high: base,
        };
        let half_width = self.card.half_width - self.card.border.x;
        let top = 1.0 - self.card.border.y;
        blade.fit(self.outline, half_width, top, self.card.border.y);
        blade
    }
}

fn signed(draws: &mut Pcg64Mcg) -> f32 {
    unit_from_bits(draws.next_u32()) * 2.0 - 1.0
}

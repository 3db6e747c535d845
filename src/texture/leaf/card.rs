//! Sets leaves on a card: the twig, its side shoots, and where on them leaves stand.

use rand::Rng;
use rand_pcg::Pcg64Mcg;

use super::blade::BladeMap;
use super::place::{Element, Paint, Pose, Shape, Stem};
use crate::math::{PI, TAU, Vec2, float, lerp, round_to_u32};
use crate::rng::{Key, Parameter, unit_from_bits};
use crate::species::schema::{Arrangement, Flowers, Form, LeafArt, Spray};

/// Things on one card beyond this are left out: they could not be told apart.
const MOST: usize = 6000;
/// Radius of a twig at its foot and at its tip, card lengths, where leaves are large.
const TWIG: [f32; 2] = [0.008, 0.0045];
/// What may hang below the foot of a card: the round end of a stalk.
const FOOT: f32 = 0.015;
/// The golden angle, radians: from one needle to the next around a twig.
const GOLDEN: f32 = 2.399_963_2;

/// What is known of the card: sizes in card lengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Card {
    /// Half the card's width.
    pub(super) half_width: f32,
    /// Free border along the sides, and along the ends.
    pub(super) border: Vec2,
}

/// All that is on a card, topmost first.
pub(super) fn elements(
    art: &LeafArt,
    maps: &[BladeMap],
    card: &Card,
    single: Option<Pose>,
    seed: u64,
) -> Vec<Element> {
    let key = Key::of_seed(seed).level("leaf");
    let mut plot = Plot {
        art,
        maps,
        card,
        key,
        elements: Vec::new(),
    };
    match (art.arrangement, single) {
        (Arrangement::Single, Some(pose)) => {
            plot.petiole_to(pose.base);
            plot.push(Shape::Blade(pose), Paint::Leaf, 0.1);
        }
        (Arrangement::Single, None) => plot.single(),
        _ => plot.twig(),
    }
    if let Some(flowers) = art.flowers {
        plot.flowers(&flowers);
    }
    let mut elements = plot.elements;
    // Stable, so that equal ranks keep their order.
    elements.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    elements
}

/// Grows a card.
pub(super) struct Plot<'a> {
    pub(super) art: &'a LeafArt,
    maps: &'a [BladeMap],
    card: &'a Card,
    key: Key,
    elements: Vec<Element>,
}

/// A shoot, straight but for its bow.
#[derive(Clone, Copy, Debug)]
struct Shoot {
    foot: Vec2,
    /// From straight up, clockwise.
    angle: f32,
    length: f32,
    bow: f32,
    /// How many more times it may branch.
    orders: u32,
}

impl Shoot {
    fn along(&self) -> Vec2 {
        let (sine, cosine) = libm::sincosf(self.angle);
        Vec2::new(sine, cosine)
    }

    fn at(&self, way: f32) -> Vec2 {
        let along = self.along();
        let bow = self.bow * 4.0 * way * (1.0 - way);
        self.foot + along * (self.length * way) - along.perp() * bow
    }
}

impl Plot<'_> {
    pub(super) fn push(&mut self, shape: Shape, paint: Paint, rank: f32) {
        if self.elements.len() < MOST {
            self.elements
                .push(Element::new(shape, paint, rank, self.maps));
        }
    }

    pub(super) fn stem(&mut self, from: Vec2, to: Vec2, radius: [f32; 2], paint: Paint, rank: f32) {
        self.push(Shape::Stem(Stem { from, to, radius }), paint, rank);
    }

    fn draws(&self, place: u64, part: u64) -> Pcg64Mcg {
        self.key.with(place).with(part).stream(Parameter::Texture)
    }

    /// A stalk from the middle of the lower edge.
    fn petiole_to(&mut self, top: Vec2) {
        let foot = Vec2::new(0.0, self.card.border.y);
        if top.y > foot.y + 1e-3 {
            self.stem(foot, top, [0.0075, 0.0058], Paint::Stalk, 0.0);
        }
    }

    /// One compound leaf from edge to edge.
    fn single(&mut self) {
        let foot = Vec2::new(0.0, self.card.border.y);
        let mut draws = self.draws(0, 0);
        self.leaf(
            foot,
            0.0,
            1.0,
            self.art.petiole.unwrap_or(0.0),
            0.0,
            &mut draws,
        );
        // Leaflets may hang below the foot: then the stalk is as much longer.
        let low = self.elements.iter().map(|e| e.low.y).fold(foot.y, f32::min);
        let lift = Vec2::new(0.0, foot.y - low);
        if lift.y > 1e-3 {
            for element in &mut self.elements {
                element.scale(foot, 1.0, lift);
            }
            self.stem(foot, foot + lift, [0.012, 0.01], Paint::Stalk, 0.0);
        }
        self.fit(0, foot);
    }

    /// A twig up the card with all that it carries.
    fn twig(&mut self) {
        let (_, _, blade) = self.numbers();
        let petiole = self.petiole();
        let room = match self.art.arrangement {
            Arrangement::Brush { angle_deg, .. } => {
                0.9 * blade * libm::cosf(0.5 * angle_deg.to_radians()).max(0.2)
            }
            _ => blade * 0.92 * (1.0 + petiole * 0.5) * self.reach(),
        };
        let top = (1.0 - self.card.border.y - room).max(0.04);
        let bow = self.key.signed(Parameter::Texture) * 0.03;
        let shoot = Shoot {
            foot: Vec2::new(0.0, self.card.border.y),
            angle: 0.0,
            length: top - self.card.border.y,
            bow,
            orders: self.art.spray.map_or(0, |spray| spray.orders.min(2)),
        };
        self.shoot(&shoot, top, self.key);
    }

    /// How far a blade reaches ahead of its foot, in blade lengths.
    fn reach(&self) -> f32 {
        match self.art.form {
            Form::Simple => self.maps[0].high.x,
            _ => 1.0,
        }
    }

    /// Leaves at places along the main twig: how many places, leaves at each, and their length.
    fn numbers(&self) -> (u32, u32, f32) {
        match self.art.arrangement {
            Arrangement::Single => (1, 1, 1.0),
            Arrangement::Opposite { pairs, blade, .. } => (pairs.min(200), 2, blade),
            Arrangement::Alternate { count, blade, .. } => (count.min(400), 1, blade),
            Arrangement::Brush {
                count,
                bundle,
                blade,
                ..
            } => (count.min(1000), bundle.min(8), blade),
            Arrangement::Tufts {
                count,
                leaves,
                blade,
                ..
            } => (count.min(100), leaves.min(200), blade),
            Arrangement::Scales { pairs, blade } => (pairs.min(200), 2, blade),
        }
    }

    fn petiole(&self) -> f32 {
        self.art.petiole.unwrap_or(match self.art.arrangement {
            Arrangement::Opposite { .. } => 0.06,
            Arrangement::Alternate { .. } => 0.22,
            _ => 0.0,
        })
    }

    /// One shoot: its wood, its side shoots, its leaves. `whole` is the main twig's length.
    fn shoot(&mut self, shoot: &Shoot, whole: f32, key: Key) {
        let (places, each, blade) = self.numbers();
        let blade = blade.clamp(0.004, 0.95);
        let thin = ((0.0022 + 0.04 * blade) / TWIG[0]).min(1.0);
        let order = if shoot.length < whole * 0.99 {
            0.65
        } else {
            1.0
        };
        let radius = TWIG.map(|radius| radius * thin * order);
        let scaly = matches!(self.art.arrangement, Arrangement::Scales { .. });
        let paint = if scaly { Paint::Stalk } else { Paint::Wood };
        for i in 0..8_u8 {
            let way = [f32::from(i) / 8.0, f32::from(i + 1) / 8.0];
            let [from, to] = way.map(|way| shoot.at(way));
            self.stem(
                from,
                to,
                way.map(|way| lerp(radius[0], radius[1], way)),
                paint,
                0.0,
            );
        }
        if let Some(spray) = self.art.spray
            && shoot.orders > 0
        {
            self.side_shoots(shoot, &spray, whole, key);
        }
        let share = shoot.length / whole.max(1e-3);
        let places = round_to_u32(float(places) * share).max(1);
        self.key = key;
        match self.art.arrangement {
            Arrangement::Brush { angle_deg, .. } => {
                self.brush(shoot, (places, each), angle_deg, blade);
            }
            Arrangement::Tufts { spread_deg, .. } => {
                self.tufts(shoot, (places, each), spread_deg, blade);
            }
            Arrangement::Scales { .. } => self.scales(shoot, places, blade),
            Arrangement::Opposite { angle_deg, .. } | Arrangement::Alternate { angle_deg, .. } => {
                self.sprig(shoot, (places, each), angle_deg, blade);
            }
            Arrangement::Single => {}
        }
    }

    fn side_shoots(&mut self, shoot: &Shoot, spray: &Spray, whole: f32, key: Key) {
        let share = (shoot.length / whole.max(1e-3)).min(1.0);
        let count = round_to_u32(float(spray.shoots) * share).max(1);
        let (_, _, blade) = self.numbers();
        for i in 0..count {
            let way = (i as f32 + 0.5) / count as f32;
            for side in 0..if spray.opposite { 2 } else { 1 } {
                let below = key.with(100 + u64::from(i)).with(u64::from(side));
                let turn = if spray.opposite { side } else { i };
                let sign = if turn.is_multiple_of(2) { -1.0 } else { 1.0 };
                let mut draws = below.stream(Parameter::Texture);
                let angle = sign * spray.angle_deg.to_radians() * lerp(1.1, 0.85, way);
                let mut side_shoot = Shoot {
                    foot: shoot.at(lerp(0.1, 0.92, way)),
                    angle: shoot.angle + angle + 0.07 * signed(&mut draws),
                    length: shoot.length
                        * spray.length
                        * lerp(1.0, 0.3, way)
                        * (1.0 - 0.45 * (0.3 - way).max(0.0) / 0.3)
                        * (1.0 + 0.1 * signed(&mut draws)),
                    bow: 0.0,
                    orders: shoot.orders - 1,
                };
                // Stays on the card with room for its last leaf.
                let along = side_shoot.along();
                let room = self.card.half_width - self.card.border.x - 0.5 * blade;
                let reach = (room - side_shoot.foot.x * along.x.signum()).max(0.02);
                let most = reach / along.x.abs().max(1e-3);
                side_shoot.length = side_shoot.length.min(most);
                // Side shoots bow toward the tip of the card.
                side_shoot.bow = 0.06 * side_shoot.length * sign;
                if side_shoot.length > 0.02 {
                    self.shoot(&side_shoot, whole, below);
                }
            }
        }
    }

    /// Pairs or single leaves along a shoot, and one at its tip.
    fn sprig(&mut self, shoot: &Shoot, (nodes, per_node): (u32, u32), angle_deg: f32, leaf: f32) {
        let petiole = self.petiole();
        // Many small leaves in two ranks are needles: even, or they would look torn.
        let order = if nodes * per_node > 24 { 0.35 } else { 1.0 };
        let first = if nodes > 1 { 0.14 } else { 0.5 };
        let first = if order < 1.0 || self.art.spray.is_some() {
            0.04
        } else {
            first
        };
        for node in 0..nodes {
            let way = (node as f32 + 0.5) / nodes as f32;
            for side in 0..per_node {
                let mut draws = self.draws(u64::from(node), u64::from(side));
                let turn = if per_node == 2 { side } else { node };
                let sign = if turn.is_multiple_of(2) { -1.0 } else { 1.0 };
                // Leaves spread less toward the tip, and are smaller there and at the foot.
                let angle = angle_deg.to_radians() * lerp(1.15, 0.75, way)
                    + 0.16 * order * signed(&mut draws);
                let place = lerp(first, 0.97, way) + 0.02 * order * signed(&mut draws);
                let size = leaf
                    * (1.0 - 0.35 * (way - 0.4).max(0.0) - 0.3 * (0.35 - way).max(0.0))
                    * (1.0 + 0.1 * order * signed(&mut draws));
                // Pairs stand crosswise: every other one lies more to the front.
                let front = if node.is_multiple_of(2) { 0.35 } else { -0.35 };
                let rank = front + signed(&mut draws);
                let foot = shoot.at(place.clamp(0.0, 1.0));
                self.leaf_fitted(
                    foot,
                    shoot.angle + sign * angle,
                    size,
                    petiole,
                    rank,
                    &mut draws,
                );
            }
        }
        let mut draws = self.draws(u64::from(nodes), 2);
        let angle = shoot.angle + 0.12 * signed(&mut draws);
        let rank = 0.2 * signed(&mut draws);
        let foot = shoot.at(1.0) - shoot.along() * 0.004;
        self.leaf_fitted(foot, angle, leaf * 0.92, petiole * 0.5, rank, &mut draws);
    }

    /// Bundles of needles all around a shoot.
    fn brush(&mut self, shoot: &Shoot, (places, bundle): (u32, u32), angle_deg: f32, needle: f32) {
        for place in 0..=places {
            let last = place == places;
            let way = (place as f32 + 0.5) / places as f32;
            let mut around = self.draws(u64::from(place), 8);
            let azimuth = GOLDEN * place as f32 + 0.3 * signed(&mut around);
            let down = angle_deg.to_radians() * lerp(1.1, 0.62, way) + 0.1 * signed(&mut around);
            let down = if last { 0.1 } else { down };
            let (sine, cosine) = libm::sincosf(down);
            let (depth, across) = libm::sincosf(azimuth);
            // The bundle in the plane of the card; what points at the eye is short.
            let flat = Vec2::new(sine * across, cosine);
            let foot = shoot.at(lerp(0.03, 1.0, way.min(1.0)));
            for part in 0..bundle {
                let mut draws = self.draws(u64::from(place), 16 + u64::from(part));
                let apart = if bundle > 1 {
                    0.17 * (part as f32 / (bundle - 1) as f32 - 0.5) + 0.03 * signed(&mut draws)
                } else {
                    0.0
                };
                let angle = shoot.angle + libm::atan2f(flat.x, flat.y) + apart;
                let size = needle * flat.length().max(0.25) * (1.0 + 0.12 * signed(&mut draws));
                let rank = depth * sine + 0.1 * signed(&mut draws);
                self.leaf_fitted(foot, angle, size, 0.0, rank, &mut draws);
            }
        }
    }

    /// Rosettes on short shoots along a shoot, and one at its tip.
    fn tufts(&mut self, shoot: &Shoot, (tufts, leaves): (u32, u32), spread_deg: f32, leaf: f32) {
        for tuft in 0..tufts {
            let last = tuft + 1 == tufts;
            let way = if last {
                1.0
            } else {
                (tuft as f32 + 0.6) / tufts as f32
            };
            let mut around = self.draws(u64::from(tuft), 9);
            let sign = if tuft.is_multiple_of(2) { -1.0 } else { 1.0 };
            let lean = if last {
                0.0
            } else {
                sign * (1.05 + 0.25 * signed(&mut around))
            };
            let axis = shoot.angle + lean;
            let foot = shoot.at(way);
            let (sine, cosine) = libm::sincosf(axis);
            let spur = foot + Vec2::new(sine, cosine) * if last { 0.0 } else { 0.12 * leaf };
            if !last {
                self.stem(foot, spur, [0.004, 0.0045], Paint::Wood, 0.02);
            }
            for part in 0..leaves {
                let mut draws = self.draws(u64::from(tuft), 32 + u64::from(part));
                let turn = (part as f32 + 0.5) / leaves as f32 * 2.0 - 1.0;
                let angle = axis + 0.5 * spread_deg.to_radians() * turn + 0.12 * signed(&mut draws);
                let front = signed(&mut draws);
                let size = leaf * (1.0 - 0.45 * front * front) * (1.0 + 0.08 * signed(&mut draws));
                self.leaf_fitted(spur, angle, size, 0.0, front, &mut draws);
            }
        }
    }

    /// Scales that hide a shoot: pairs to the sides and to the front by turns.
    fn scales(&mut self, shoot: &Shoot, pairs: u32, scale: f32) {
        for pair in 0..pairs * 2 {
            let way = (pair as f32 + 0.5) / (pairs * 2) as f32;
            let foot = shoot.at(way);
            let rank = 0.2 + 0.5 * (1.0 - way);
            let sides: &[f32] = if pair.is_multiple_of(2) {
                &[-0.5, 0.5]
            } else {
                &[0.0]
            };
            for (part, &lean) in (0_u64..).zip(sides) {
                let mut draws = self.draws(u64::from(pair), 64 + part);
                let size = scale * lerp(1.0, 0.7, way) * (1.0 + 0.1 * signed(&mut draws));
                let front = if lean == 0.0 { 0.3 } else { 0.0 };
                self.leaf_fitted(
                    foot,
                    shoot.angle + lean,
                    size,
                    0.0,
                    rank + front,
                    &mut draws,
                );
            }
        }
    }

    /// Flowers on stalks, above the leaves.
    fn flowers(&mut self, flowers: &Flowers) {
        let top = self.card.half_width.min(0.5);
        for flower in 0..flowers.count.min(200) {
            let mut draws = self.draws(u64::from(flower), 1000);
            let way = (flower as f32 + 0.5) / flowers.count as f32;
            let foot = Vec2::new(0.0, lerp(0.15, 0.75, way) + 0.03 * signed(&mut draws));
            let angle = GOLDEN * flower as f32 + signed(&mut draws);
            let (sine, cosine) = libm::sincosf(angle);
            let most = (top - self.card.border.x - 0.5 * flowers.size).max(0.0);
            let reach = lerp(0.12, 0.42, unit_from_bits(draws.next_u32()));
            let middle = (foot + Vec2::new(sine, 0.6 * cosine) * reach).clamp(
                Vec2::new(-most, self.card.border.y + 0.5 * flowers.size),
                Vec2::new(most, 1.0 - self.card.border.y - 0.5 * flowers.size),
            );
            let rank = 2.0 + 0.1 * flower as f32;
            self.stem(foot, middle, [0.003, 0.0025], Paint::Stalk, 1.5);
            let turn = TAU * unit_from_bits(draws.next_u32());
            // Seen aslant, a flower is narrower one way.
            let aslant = 1.0 - 0.3 * unit_from_bits(draws.next_u32());
            for petal in 0..flowers.petals {
                let angle = turn + TAU * petal as f32 / flowers.petals as f32;
                let (sine, cosine) = libm::sincosf(angle);
                let along = Vec2::new(sine, cosine * aslant);
                let mut pose = pose(
                    middle,
                    0.0,
                    0.5 * flowers.size * along.length(),
                    0.06,
                    &mut draws,
                );
                pose.map = 1;
                pose.along = along.normalize_or(Vec2::Y);
                pose.underside = false;
                pose.bow = 0.0;
                let over = 0.01 * (petal % 2) as f32;
                self.push(Shape::Blade(pose), Paint::Petal, rank + over);
            }
            let eye = 0.055 * flowers.size;
            self.stem(middle, middle, [eye, eye], Paint::Eye, rank + 0.05);
        }
    }

    /// A leaf that keeps to the card.
    fn leaf_fitted(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        petiole: f32,
        rank: f32,
        draws: &mut Pcg64Mcg,
    ) {
        let first = self.elements.len();
        self.leaf(foot, angle, length, petiole, rank, draws);
        self.fit(first, foot);
    }

    /// Shrinks what was added from `first` on about `foot` until it keeps to the card.
    fn fit(&mut self, first: usize, foot: Vec2) {
        let side = self.card.half_width - self.card.border.x;
        let (low, high) = self.elements[first..]
            .iter()
            .fold((foot, foot), |(low, high), e| {
                (low.min(e.low), high.max(e.high))
            });
        let ratio = |reach: f32, room: f32| {
            if reach > room {
                room.max(0.0) / reach
            } else {
                1.0
            }
        };
        let above = foot.y - self.card.border.y;
        let slack = if above < 1e-3 { FOOT } else { 0.0 };
        let shrink = ratio(high.x - foot.x, side - foot.x)
            .min(ratio(foot.x - low.x, side + foot.x))
            .min(ratio(high.y - foot.y, 1.0 - self.card.border.y - foot.y))
            .min(ratio(foot.y - low.y, above + slack));
        if shrink < 1.0 {
            for element in &mut self.elements[first..] {
                element.scale(foot, shrink * 0.999, Vec2::ZERO);
            }
        }
    }

    /// One blade of a leaf.
    pub(super) fn blade(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        rank: f32,
        draws: &mut Pcg64Mcg,
    ) {
        let mut pose = pose(foot, angle, length, self.art.colour_vary, draws);
        // Scales lie on their twig: nobody sees their undersides.
        pose.underside &= !matches!(self.art.arrangement, Arrangement::Scales { .. });
        self.push(Shape::Blade(pose), Paint::Leaf, rank);
    }
}

/// A blade that leaves `base` at `angle` from straight up, clockwise.
fn pose(base: Vec2, angle: f32, length: f32, vary: f32, draws: &mut Pcg64Mcg) -> Pose {
    let (sine, cosine) = libm::sincosf(angle);
    let along = Vec2::new(sine, cosine);
    let outward = along.x;
    let value = 1.0 + vary * signed(draws);
    let warm = 0.8 * vary.min(0.4) * signed(draws);
    let roll = 0.5 * signed(draws);
    let pitch = 0.3 * signed(draws);
    Pose {
        map: 0,
        base,
        along,
        length: length.max(1e-4),
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
        haste: signed(draws),
        shift: unit_from_bits(draws.next_u32()),
    }
}

pub(super) fn signed(draws: &mut Pcg64Mcg) -> f32 {
    unit_from_bits(draws.next_u32()) * 2.0 - 1.0
}

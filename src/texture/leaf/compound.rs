//! Makes a leaf of blades: stalk, rachis, leaflets.

use rand_pcg::Pcg64Mcg;

use super::card::{Plot, signed};
use super::place::Paint;
use crate::math::{Vec2, lerp};
use crate::species::schema::Form;

/// Radius of a leaf stalk, as a part of the leaf's length.
const STALK: f32 = 0.011;
/// Radius of a rachis at its foot, as a part of its length.
const RACHIS: f32 = 0.007;

/// Leaflets in pairs along a rachis.
#[derive(Clone, Copy)]
struct Feather {
    pairs: u32,
    /// Leaflet length over the rachis's with its end leaflet.
    leaflet: f32,
    angle: f32,
    bare: f32,
    taper: f32,
}

impl Plot<'_> {
    /// One leaf from `foot`, at `angle` from straight up, clockwise; lengths in card lengths.
    pub(super) fn leaf(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        petiole: f32,
        rank: f32,
        draws: &mut Pcg64Mcg,
    ) {
        let along = direction(angle);
        let stalk = length * petiole * (1.0 + 0.3 * signed(draws));
        let base = foot + along * stalk;
        if stalk > 0.0 {
            let radius = STALK * length.min(0.6);
            self.stem(
                foot,
                base,
                [radius, 0.8 * radius],
                Paint::Stalk,
                rank - 1e-3,
            );
        }
        match self.art.form {
            Form::Simple => self.blade(base, angle, length, rank, draws),
            Form::Pinnate {
                pairs,
                leaflet,
                angle_deg,
                bare,
                taper,
            } => {
                let feather = Feather {
                    pairs: pairs.min(200),
                    leaflet,
                    angle: angle_deg.to_radians(),
                    bare,
                    taper,
                };
                self.feather(base, angle, length, feather, rank, draws);
            }
            Form::Bipinnate {
                pinnae,
                pinna,
                pairs,
                leaflet,
            } => self.bipinnate(
                base,
                angle,
                length,
                (pinnae, pinna),
                (pairs, leaflet),
                (rank, draws),
            ),
            Form::Palmate {
                leaflets,
                spread_deg,
                outer,
                costa,
            } => {
                let spread = spread_deg.to_radians();
                self.fan(
                    base,
                    angle,
                    length,
                    (leaflets.min(200), spread, outer, costa),
                    (rank, draws),
                );
            }
        }
    }

    fn feather(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        feather: Feather,
        rank: f32,
        draws: &mut Pcg64Mcg,
    ) {
        let end = feather.leaflet * (1.0 - feather.taper);
        let along = direction(angle);
        let rachis = length * (1.0 - 0.9 * end).max(0.1);
        let bow = 0.05 * rachis * signed(draws) * if self.lone() { 0.3 } else { 1.0 };
        let at = |way: f32| {
            foot + along * (rachis * way) + along.perp() * (bow * 4.0 * way * (1.0 - way))
        };
        let radius = RACHIS * rachis.min(0.7);
        for i in 0..6_u8 {
            let way = [f32::from(i) / 6.0, f32::from(i + 1) / 6.0];
            let thick = way.map(|way| radius * lerp(1.0, 0.35, way));
            self.stem(at(way[0]), at(way[1]), thick, Paint::Stalk, rank + 0.3);
        }
        let order = if feather.pairs > 12 { 0.35 } else { 1.0 };
        for pair in 0..feather.pairs {
            let way = (pair as f32 + 0.35) / feather.pairs as f32;
            for side in [-1.0, 1.0] {
                // Longest at a third, shorter to both ends.
                let size = feather.leaflet
                    * lerp(1.0, 1.0 - feather.taper, (way - 0.35).max(0.0) / 0.65)
                    * (1.0 - 0.35 * (0.25 - way).max(0.0) / 0.25)
                    * (1.0 + 0.06 * signed(draws));
                let lean = feather.angle * lerp(1.12, 0.72, way) + 0.08 * order * signed(draws);
                let base = at(lerp(feather.bare, 0.985, way));
                let above = rank + 0.2 * signed(draws);
                self.blade(base, angle + side * lean, length * size, above, draws);
            }
        }
        self.blade(
            at(1.0),
            angle + 0.05 * signed(draws),
            length * end,
            rank + 0.25,
            draws,
        );
    }

    fn bipinnate(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        (pinnae, pinna): (u32, f32),
        (pairs, leaflet): (u32, f32),
        (rank, draws): (f32, &mut Pcg64Mcg),
    ) {
        let along = direction(angle);
        let rachis = length * (1.0 - 0.55 * pinna).max(0.2);
        let tip = foot + along * rachis;
        self.stem(
            foot,
            tip,
            [RACHIS * rachis, 0.4 * RACHIS * rachis],
            Paint::Stalk,
            rank + 0.3,
        );
        let feather = Feather {
            pairs: pairs.min(60),
            leaflet,
            angle: 1.2,
            bare: 0.06,
            taper: 0.3,
        };
        for pair in 0..pinnae.min(40) {
            let way = (pair as f32 + 0.6) / pinnae as f32;
            for side in [-1.0, 1.0] {
                let size = pinna * (1.0 - 0.45 * (2.0 * way - 1.0) * (2.0 * way - 1.0));
                let lean = side * lerp(1.25, 0.3, way) + 0.06 * signed(draws);
                let base = foot + along * (rachis * lerp(0.2, 1.0, way));
                self.feather(base, angle + lean, length * size, feather, rank, draws);
            }
        }
    }

    fn fan(
        &mut self,
        foot: Vec2,
        angle: f32,
        length: f32,
        (leaflets, spread, outer, costa): (u32, f32, f32, f32),
        (rank, draws): (f32, &mut Pcg64Mcg),
    ) {
        let along = direction(angle);
        if costa > 0.0 {
            let end = foot + along * (costa * length);
            self.stem(
                foot,
                end,
                [0.012 * length, 0.002 * length],
                Paint::Stalk,
                rank + 0.3,
            );
        }
        let order = if leaflets > 12 { 0.25 } else { 1.0 };
        let middle = (leaflets as f32 - 1.0) * 0.5;
        for i in 0..leaflets {
            let way = if leaflets > 1 {
                i as f32 / middle - 1.0
            } else {
                0.0
            };
            let size =
                lerp(1.0, outer, libm::powf(way.abs(), 1.5)) * (1.0 + 0.05 * order * signed(draws));
            let turn = angle + 0.5 * spread * way + 0.05 * order * signed(draws);
            // Those of the middle leave the midrib last.
            let up = costa * length * (1.0 - way.abs());
            let above = rank + 0.1 * (1.0 - way.abs());
            self.blade(
                foot + along * up,
                turn,
                length * size - 0.7 * up,
                above,
                draws,
            );
        }
    }

    /// True if one leaf has the card to itself.
    fn lone(&self) -> bool {
        self.art.arrangement == crate::species::schema::Arrangement::Single
    }
}

fn direction(angle: f32) -> Vec2 {
    let (sine, cosine) = libm::sincosf(angle);
    Vec2::new(sine, cosine)
}

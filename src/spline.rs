//! Catmull-Rom curves and their polyline LODs.
//!
//! Home of: Koniaris, Gaitatzes, Papaioannou 2009, section IV.B and Table I (maximum-distance
//! refinement). The curve itself: Catmull and Rom 1974, evaluated by Barry and Goldman's pyramid (1988).
//!
//! Changes versus the paper: the radius is a fourth coordinate of the refined curve, so that a
//! tapering or flaring straight branch gets rings where its outline needs them; distance is to the
//! chord, not to its infinite line; the curve is searched at a fixed number of samples a span, so
//! "farthest" is exact to that sampling ([`SAMPLES_PER_SPAN`]).
//!
//! One refinement run yields every LOD: the points kept for a tolerance are a prefix of one insertion
//! order, so the LODs nest and no vertex moves between them.

use crate::math::Vec3;
use crate::species::schema::Knots;

/// Curve samples between two control points: the resolution at which the farthest point is sought.
/// 16 puts the chord error of the sampling itself under 1/400 of a span for a quarter circle.
pub const SAMPLES_PER_SPAN: usize = 16;

/// A Catmull-Rom curve through its control points.
#[derive(Clone, Debug)]
pub struct CatmullRom {
    /// Control points with one reflected point added at each end.
    points: Vec<Vec3>,
    /// Knot of each entry of `points`.
    knots: Vec<f32>,
}

impl CatmullRom {
    /// A curve through `control` points; neighbours that coincide are merged.
    ///
    /// Returns `None` if fewer than two distinct points are left.
    #[must_use]
    pub fn new(control: &[Vec3], knots: Knots) -> Option<Self> {
        let mut inner = control.to_vec();
        inner.dedup_by(|a, b| a.distance_squared(*b) < 1e-16);
        let [first, second, ..] = inner[..] else {
            return None;
        };
        let last = inner[inner.len() - 1];
        let before_last = inner[inner.len() - 2];
        let mut points = Vec::with_capacity(inner.len() + 2);
        points.push(first * 2.0 - second);
        points.extend(&inner);
        points.push(last * 2.0 - before_last);
        let mut at = 0.0;
        let mut values = vec![at];
        for pair in points.windows(2) {
            let distance = pair[0].distance(pair[1]);
            at += match knots {
                Knots::Uniform => 1.0,
                Knots::Centripetal => distance.sqrt(),
                Knots::Chordal => distance,
            };
            values.push(at);
        }
        Some(Self {
            points,
            knots: values,
        })
    }

    /// Number of spans, one less than the number of control points.
    #[must_use]
    pub fn spans(&self) -> usize {
        self.points.len() - 3
    }

    /// The point at part `t` (0..=1) of span `span`; the ends are the control points exactly.
    #[must_use]
    pub fn point(&self, span: usize, t: f32) -> Vec3 {
        let p = &self.points[span..span + 4];
        let k = &self.knots[span..span + 4];
        if t <= 0.0 {
            return p[1];
        }
        if t >= 1.0 {
            return p[2];
        }
        let u = k[1] + (k[2] - k[1]) * t;
        let mix = |a: Vec3, b: Vec3, ka: f32, kb: f32| (a * (kb - u) + b * (u - ka)) / (kb - ka);
        let a1 = mix(p[0], p[1], k[0], k[1]);
        let a2 = mix(p[1], p[2], k[1], k[2]);
        let a3 = mix(p[2], p[3], k[2], k[3]);
        let b1 = mix(a1, a2, k[0], k[2]);
        let b2 = mix(a2, a3, k[1], k[3]);
        mix(b1, b2, k[1], k[2])
    }

    /// The whole curve as a dense polyline, [`SAMPLES_PER_SPAN`] steps a span, ends included.
    #[must_use]
    pub fn samples(&self) -> Vec<Vec3> {
        let mut samples = Vec::with_capacity(self.spans() * SAMPLES_PER_SPAN + 1);
        for span in 0..self.spans() {
            for step in 0..SAMPLES_PER_SPAN {
                #[expect(clippy::cast_precision_loss, reason = "small whole numbers")]
                let t = step as f32 / SAMPLES_PER_SPAN as f32;
                samples.push(self.point(span, t));
            }
        }
        samples.push(self.point(self.spans() - 1, 1.0));
        samples
    }
}

/// The insertion order of a refinement: which samples enter the polyline, and how far the polyline
/// still was from the curve before each entered.
#[derive(Clone, Debug, PartialEq)]
pub struct Refinement {
    /// Sample indices: the control points in order, then one farthest point after the other.
    order: Vec<u16>,
    /// How many of `order` are control points.
    control: usize,
    /// For each point after the control points, the greatest distance at the time it was inserted.
    distances: Vec<f32>,
}

impl Refinement {
    /// Table I: inserts farthest points until the greatest distance is at most `tolerance`.
    ///
    /// `curve` is a dense polyline of (x, y, z, radius) with at most 65,535 samples, `control` the
    /// indices of the control points among them, rising, with the first and the last sample.
    #[must_use]
    pub fn run(curve: &[[f32; 4]], control: &[u16], tolerance: f32) -> Self {
        let mut order = control.to_vec();
        let mut distances = Vec::new();
        let mut chords: Vec<Chord> = control
            .windows(2)
            .map(|pair| Chord::new(curve, pair[0], pair[1]))
            .collect();
        loop {
            // The first of equals wins, so ties are broken by position along the curve.
            let mut farthest = 0;
            for (index, chord) in chords.iter().enumerate() {
                if chord.distance > chords[farthest].distance {
                    farthest = index;
                }
            }
            let Some(&chord) = chords.get(farthest) else {
                break;
            };
            if chord.distance <= tolerance || chord.distance <= 0.0 {
                break;
            }
            order.push(chord.at);
            distances.push(chord.distance);
            chords[farthest] = Chord::new(curve, chord.from, chord.at);
            chords.insert(farthest + 1, Chord::new(curve, chord.at, chord.to));
        }
        Self {
            order,
            control: control.len(),
            distances,
        }
    }

    /// How many points of the insertion order a tolerance needs.
    #[must_use]
    pub fn count(&self, tolerance: f32) -> usize {
        let enough = self
            .distances
            .iter()
            .position(|&distance| distance <= tolerance);
        self.control + enough.unwrap_or(self.distances.len())
    }

    /// The polyline for a tolerance: sample indices, rising.
    #[must_use]
    pub fn points(&self, tolerance: f32) -> Vec<u16> {
        let mut points = self.order[..self.count(tolerance)].to_vec();
        points.sort_unstable();
        points
    }

    /// Sample indices in insertion order, the control points first.
    #[must_use]
    pub fn order(&self) -> &[u16] {
        &self.order
    }
}

/// A piece of the polyline with the curve sample farthest from it.
#[derive(Clone, Copy, Debug)]
struct Chord {
    from: u16,
    to: u16,
    at: u16,
    distance: f32,
}

impl Chord {
    fn new(curve: &[[f32; 4]], from: u16, to: u16) -> Self {
        let mut chord = Self {
            from,
            to,
            at: from,
            distance: 0.0,
        };
        for at in from + 1..to {
            let distance =
                distance_to_chord(curve[at as usize], curve[from as usize], curve[to as usize]);
            if distance > chord.distance {
                chord.at = at;
                chord.distance = distance;
            }
        }
        chord
    }
}

/// Distance of `p` from the segment `a`..`b`, in four dimensions.
fn distance_to_chord(p: [f32; 4], a: [f32; 4], b: [f32; 4]) -> f32 {
    let sub = |p: [f32; 4], q: [f32; 4]| -> [f32; 4] { core::array::from_fn(|i| p[i] - q[i]) };
    let dot = |p: [f32; 4], q: [f32; 4]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
    let along = sub(b, a);
    let to_p = sub(p, a);
    let length_squared = dot(along, along);
    let t = if length_squared > 0.0 {
        (dot(to_p, along) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let rest: [f32; 4] = core::array::from_fn(|i| to_p[i] - along[i] * t);
    dot(rest, rest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn curve_of(points: &[(f32, f32, f32)], knots: Knots) -> (Vec<[f32; 4]>, Vec<u16>) {
        let control: Vec<Vec3> = points.iter().map(|&(x, y, z)| Vec3::new(x, y, z)).collect();
        let spline = CatmullRom::new(&control, knots).unwrap();
        let curve: Vec<[f32; 4]> = spline
            .samples()
            .iter()
            .map(|p| [p.x, p.y, p.z, 0.1])
            .collect();
        let control = (0..=spline.spans())
            .map(|i| u16::try_from(i * SAMPLES_PER_SPAN).unwrap())
            .collect();
        (curve, control)
    }

    #[test]
    fn a_curve_passes_through_its_control_points() {
        let control = [
            Vec3::ZERO,
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::new(0.0, 3.0, 1.0),
        ];
        for knots in [Knots::Centripetal, Knots::Uniform, Knots::Chordal] {
            let curve = CatmullRom::new(&control, knots).unwrap();
            let samples = curve.samples();
            assert_eq!(samples[0], control[0]);
            assert_eq!(samples[SAMPLES_PER_SPAN], control[1]);
            assert_eq!(samples[2 * SAMPLES_PER_SPAN], control[2]);
        }
    }

    #[test]
    fn straight_points_give_a_straight_curve_that_needs_no_refinement() {
        let (curve, control) = curve_of(
            &[(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 2.5, 0.0)],
            Knots::Centripetal,
        );
        let refinement = Refinement::run(&curve, &control, 1e-5);
        assert_eq!(refinement.order(), control);
    }

    #[test]
    fn a_curve_needs_two_distinct_points() {
        assert!(CatmullRom::new(&[Vec3::ONE, Vec3::ONE], Knots::Uniform).is_none());
        assert!(CatmullRom::new(&[], Knots::Uniform).is_none());
    }

    proptest! {
        #[test]
        fn refinement_keeps_control_points_meets_the_tolerance_and_nests(
            points in proptest::collection::vec((-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0), 2..7),
            coarse in 0.02_f32..0.8,
            ratio in 0.05_f32..1.0,
        ) {
            let mut points = points;
            for (i, point) in points.iter_mut().enumerate() {
                point.1 += i as f32 * 7.0; // keeps them distinct
            }
            let (curve, control) = curve_of(&points, Knots::Centripetal);
            let refinement = Refinement::run(&curve, &control, coarse * ratio);
            let few = refinement.points(coarse);
            let many = refinement.points(coarse * ratio);
            prop_assert!(control.iter().all(|c| few.contains(c)));
            prop_assert!(few.iter().all(|p| many.contains(p)), "coarse LOD is not part of the fine one");
            for (tolerance, kept) in [(coarse, &few), (coarse * ratio, &many)] {
                for pair in kept.windows(2) {
                    prop_assert!(Chord::new(&curve, pair[0], pair[1]).distance <= tolerance);
                }
            }
        }
    }
}

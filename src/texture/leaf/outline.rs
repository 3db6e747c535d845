//! The outline of one blade as a closed polygon: profile, base, tip, lobes; [`super::margin`] cuts the
//! teeth.
//!
//! The blade's frame: `x` (u) runs along the midrib, 0 where the stalk joins and 1 at the tip, `y` (v)
//! across it to the left, all in parts of the blade's length. One half is made, as runs from a hollow
//! (the base, or the bottom of a cut) to a tip (of a lobe, or of the blade); the other mirrors it.
//!
//! The profile is a beta function, `w(u) ~ u^a (1-u)^b`. A palmate blade is
//! the union of such profiles about the foot, in polar form: with `a <= 1` each is a star about it.

use super::margin;
use crate::math::{PI, Vec2, lerp, smoothstep};
use crate::species::schema::{Blade, Lobes};

/// Points of one run before teeth are cut.
const RUN_POINTS: u16 = 160;
/// Rays of half a palmate outline.
const RAYS: u16 = 720;
/// Blends two lobes where they meet, in blade lengths: a cut ends round, not in a needle's eye.
const SINUS: f32 = 0.018;
/// Length of the lobe at the end of a blade, in lobes.
const END_LOBE: f32 = 0.75;
/// Added to the exponent of a fully drawn-out end.
const DRAWN_OUT: f32 = 2.6;

/// One side of the outline from a hollow to a tip.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// From the hollow on.
    pub(super) points: Vec<Vec2>,
    /// True if it is passed from its tip to its hollow on the way from base to tip.
    pub(super) falling: bool,
}

/// The axis of a lobe of a palmate blade, or the midrib of any other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    /// Angle from the midrib, radians; positive to the left.
    pub(super) angle: f32,
    /// Length, blade lengths.
    pub(super) length: f32,
}

/// A closed polygon, anticlockwise from the foot; it does not repeat its first point.
pub(super) fn polygon(blade: &Blade) -> Vec<Vec2> {
    let half = 0.5 * blade.width;
    let runs = match blade.lobes {
        Lobes::Palmate { .. } => palmate_runs(blade),
        _ => vec![Run {
            points: side(blade),
            falling: false,
        }],
    };
    let toothed = margin::cut(&runs, &blade.margin, half);
    let lift = |point: Vec2, sign: f32| {
        // One half begins lower along the midrib, and is a little fuller.
        let foot = (1.0 - point.x).max(0.0);
        let low = 0.11 * blade.oblique * sign * foot * foot * smoothstep(0.0, 0.7, point.y / half);
        Vec2::new(point.x - low, sign * point.y)
    };
    let mut polygon: Vec<Vec2> = toothed.iter().map(|&point| lift(point, -1.0)).collect();
    polygon.extend(toothed.iter().rev().skip(1).map(|&point| lift(point, 1.0)));
    polygon.dedup_by(|a, b| (*a - *b).length_squared() < 1e-12);
    polygon
}

/// Main axes of a blade, the midrib first.
pub(super) fn axes(blade: &Blade) -> Vec<Axis> {
    let mut axes = vec![Axis {
        angle: 0.0,
        length: 1.0,
    }];
    if let Lobes::Palmate {
        count,
        spread_deg,
        outer,
        ..
    } = blade.lobes
    {
        axes.clear();
        let count = count.clamp(1, 15);
        let middle = (count as f32 - 1.0) * 0.5;
        for i in 0..count {
            let way = if count == 1 {
                0.0
            } else {
                (i as f32 - middle) / middle
            };
            axes.push(Axis {
                angle: 0.5 * spread_deg.to_radians() * way,
                length: lerp(1.0, outer, way * way),
            });
        }
        axes.sort_by(|a, b| a.angle.abs().total_cmp(&b.angle.abs()));
    }
    axes
}

/// The two exponents of a blade's profile.
fn exponents(blade: &Blade, widest: f32) -> (f32, f32) {
    let twice = 2.0 * blade.sharpness;
    (
        (twice * widest).max(0.02),
        (twice * (1.0 - widest)).max(0.02),
    )
}

/// A beta profile, 1 at the widest.
fn profile((a, b): (f32, f32), u: f32) -> f32 {
    let beta = |u: f32| libm::powf(u.max(0.0), a) * libm::powf((1.0 - u).max(0.0), b);
    beta(u) / beta(a / (a + b)).max(1e-6)
}

/// The right half of a blade without palmate lobes, `y` positive, from the foot to the tip.
fn side(blade: &Blade) -> Vec<Vec2> {
    let half = 0.5 * blade.width;
    let width_at = width(blade);
    let steps = RUN_POINTS * 4;
    (0..=steps)
        .map(|i| {
            // Closer at the ends, where a profile may rise steeply.
            let way = f32::from(i) / f32::from(steps);
            let u = 0.5 - 0.5 * libm::cosf(PI * way);
            shaped(blade, half, u, width_at(u))
        })
        .collect()
}

/// The ends of a pinnately lobed blade's lobes, `y` positive, from the foot on; none for other blades.
pub(super) fn lobe_ends(blade: &Blade) -> Vec<Vec2> {
    let Lobes::Pinnate { pairs, .. } = blade.lobes else {
        return Vec::new();
    };
    let width_at = width(blade);
    (0..pairs)
        .map(|lobe| {
            let u = (lobe as f32 + 0.57) / (pairs as f32 + END_LOBE);
            shaped(blade, 0.5 * blade.width, u, width_at(u))
        })
        .collect()
}

/// The half width of a blade by place, in half widths, before it is lobed.
fn width(blade: &Blade) -> impl Fn(f32) -> f32 + '_ {
    let exponents = exponents(blade, blade.widest);
    // A factor that leaves the widest place alone and makes an end hollow: the power rises toward it.
    let hollow = move |way: f32, much: f32| {
        let way = way.clamp(0.0, 1.0);
        libm::powf(1.0 - way, DRAWN_OUT * much * way * way)
    };
    move |u: f32| {
        let mut w = profile(exponents, u);
        if blade.tip > 0.0 {
            w *= hollow((u - blade.widest) / (1.0 - blade.widest), blade.tip);
        }
        if blade.base > 0.0 {
            w *= hollow(1.0 - u / blade.widest, blade.base);
        }
        w
    }
}

/// Lobes, ears, heart base and notch on a point of the profile; `w` in half widths.
fn shaped(blade: &Blade, half: f32, u: f32, w: f32) -> Vec2 {
    let mut point = Vec2::new(u, half * w);
    if let Lobes::Pinnate {
        pairs,
        depth,
        sharp,
    } = blade.lobes
    {
        let turns = u * (pairs as f32 + END_LOBE);
        let wave = (0.5 - 0.5 * libm::cosf(2.0 * PI * turns)).clamp(0.0, 1.0);
        let round = lerp(
            1.0 - libm::powf(1.0 - wave, 2.4),
            libm::powf(wave, 1.4),
            sharp,
        );
        // Cuts are shallower toward the tip and leave the foot alone.
        let depth = depth * smoothstep(0.02, 0.2, u) * lerp(1.0, 0.6, u * u);
        let width = half * w;
        point.y = width * (1.0 - depth * (1.0 - round));
        // Lobes lean to the tip: their ends move on, the bottoms of the cuts stay.
        point.x += 0.5 * (point.y - width * (1.0 - depth)).max(0.0) * (1.0 - u);
    }
    if blade.auricles > 0.0 {
        let x = (u - 0.03) / 0.03;
        let ear = 0.3 * half * blade.auricles * (1.0 - x * x).max(0.0).sqrt();
        if ear > point.y {
            point = Vec2::new(u - 0.03 * blade.auricles * (1.0 - 0.3 * x), ear);
        }
    }
    let heart = (-blade.base).max(0.0);
    if heart > 0.0 && u < 0.6 {
        let out = (point.y / half).min(1.0);
        let bump = libm::sinf(PI * libm::powf(out, 0.62));
        point.x -= heart * 0.55 * half * bump * (1.0 - smoothstep(0.1, 0.6, u));
    }
    let notch = (-blade.tip).max(0.0);
    if notch > 0.0 && u > 0.6 {
        let x = point.y / (0.42 * half);
        point.x -= notch * 0.5 * half / (1.0 + x * x * x * x);
    }
    point
}

/// The right half of a palmate blade, `y` positive, run by run from the foot to the tip.
fn palmate_runs(blade: &Blade) -> Vec<Run> {
    let Lobes::Palmate { depth, .. } = blade.lobes else {
        return Vec::new();
    };
    let axes = axes(blade);
    let gap = axes
        .iter()
        .map(|axis| axis.angle.abs())
        .filter(|&angle| angle > 1e-3)
        .fold(PI, f32::min);
    // With an even number no lobe is on the midrib: the gap is twice the smallest angle.
    let gap = if axes[0].angle.abs() > 1e-3 {
        2.0 * gap
    } else {
        gap
    };
    let (a, b) = exponents(blade, blade.widest);
    let exponents = (a.min(0.95), b);
    let meet = ((1.0 - depth) * libm::cosf(0.5 * gap).max(0.05)).clamp(0.02, 0.98);
    let half = meet * libm::tanf((0.5 * gap).min(1.4)) / profile(exponents, meet).max(1e-3);
    // One lobe in polar form: angle falling from a right angle to 0, and radius.
    let lobe: Vec<(f32, f32)> = (1..=RAYS)
        .map(|i| {
            let u = f32::from(i) / f32::from(RAYS);
            let v = half * profile(exponents, u);
            (libm::atan2f(v, u), (u * u + v * v).sqrt())
        })
        .collect();
    let radius = |angle: f32| {
        let mut best = [0.0_f32; 2];
        for axis in &axes {
            let r = axis.length * lobe_radius(&lobe, (angle - axis.angle).abs());
            if r > best[0] {
                best = [r, best[0]];
            } else if r > best[1] {
                best[1] = r;
            }
        }
        soft_max(best[0], best[1], SINUS)
    };
    let mut angles: Vec<f32> = axes
        .iter()
        .map(|axis| axis.angle)
        .filter(|&x| x > -1e-3)
        .collect();
    angles.sort_by(|a, b| b.total_cmp(a));
    let last = angles.first().copied().unwrap_or(0.0) + 0.5 * PI;
    let mut runs = Vec::new();
    let mut from = last.min(PI);
    for (i, &tip) in angles.iter().enumerate() {
        runs.push(run(&radius, from, tip.max(0.0), false));
        let Some(&next) = angles.get(i + 1) else {
            if tip > 1e-3 {
                // No lobe on the midrib: the last cut lies on it.
                runs.push(run(&radius, 0.0, tip, true));
            }
            break;
        };
        let cut = lowest(&radius, next, tip);
        runs.push(run(&radius, cut, tip, true));
        from = cut;
    }
    runs
}

/// Radius of a lobe at an angle from its axis; `lobe` has falling angles.
fn lobe_radius(lobe: &[(f32, f32)], angle: f32) -> f32 {
    let after = lobe.partition_point(|&(at, _)| at > angle);
    match (after.checked_sub(1).map(|i| lobe[i]), lobe.get(after)) {
        (Some((high, r0)), Some(&(low, r1))) => {
            lerp(r0, r1, (high - angle) / (high - low).max(1e-9))
        }
        (Some((_, r)), None) => r,
        // Beyond the foot's own tangent the lobe closes quickly.
        (None, Some(&(high, r))) => r * (1.0 - (angle - high) / 0.15).max(0.0),
        (None, None) => 0.0,
    }
}

fn run(radius: &impl Fn(f32) -> f32, hollow: f32, tip: f32, falling: bool) -> Run {
    let points = (0..=RUN_POINTS)
        .map(|i| {
            let angle = lerp(hollow, tip, f32::from(i) / f32::from(RUN_POINTS));
            let (sine, cosine) = libm::sincosf(angle);
            Vec2::new(cosine, sine) * radius(angle)
        })
        .collect();
    Run { points, falling }
}

/// The angle of the smallest radius between two.
fn lowest(radius: &impl Fn(f32) -> f32, low: f32, high: f32) -> f32 {
    let mut best = (f32::INFINITY, low);
    for i in 0..=64_u8 {
        let angle = lerp(low, high, f32::from(i) / 64.0);
        let r = radius(angle);
        if r < best.0 {
            best = (r, angle);
        }
    }
    best.1
}

/// The larger of two, rounded over where they are within `blend` of each other.
fn soft_max(a: f32, b: f32, blend: f32) -> f32 {
    let near = (blend - (a - b).abs()).max(0.0) / blend;
    a.max(b) + 0.25 * near * near * blend
}

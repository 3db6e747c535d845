//! A branch prototype's own part: a curve with frames and radii, and the rings of its geometry LODs.

use crate::math::{Quat, Vec3, float, round_to_u32, smoothstep};
use crate::species::schema::{Curve, Flare, Flutes, Knots};
use crate::spline::{CatmullRom, Refinement, SAMPLES_PER_SPAN};

/// The tube of one branch prototype.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Index of the spline it was made from.
    pub spline: u16,
    /// Length along the curve at scale 1, metres.
    pub length: f32,
    /// Radius at the base without collar and flare, at scale 1, metres.
    pub radius: f32,
    /// The curve, densely: what children are placed on.
    pub axis: Vec<AxisSample>,
    /// Rings of each geometry LOD, as indices into `axis`, rising; LOD 0 is the finest.
    pub rings: Vec<Vec<u16>>,
    /// Corners of each full ring of each geometry LOD, at least 3; never more than those of the ring before.
    pub sides: Vec<Vec<u8>>,
    /// True if the end is closed by a dome rather than drawn out to a point.
    pub blunt: bool,
    /// Lobes of the cross-section.
    pub lobes: Lobes,
}

/// One point of a branch's curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSample {
    /// Part of the arc length, 0..=1.
    pub t: f32,
    /// In the prototype's frame, metres.
    pub position: Vec3,
    /// Rotation-minimising frame: +Y along the curve.
    pub frame: Quat,
    /// Radius of the tube there, metres, collar and flare included.
    pub radius: f32,
}

/// How the cross-section differs from a circle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// Lengthwise flutes: count, depth as a part of the radius, twist in radians over the length.
    pub flutes: (f32, f32, f32),
    /// Buttresses at the foot: count, depth as a part of the radius, height in metres.
    pub buttresses: (f32, f32, f32),
    /// Phase of both, radians.
    pub phase: f32,
}

impl Lobes {
    /// Factor on the radius, and its derivative by the angle, at `angle` (radians about the axis),
    /// `t` of the length and `height` metres along it.
    #[must_use]
    pub fn at(&self, angle: f32, t: f32, height: f32) -> (f32, f32) {
        let (count, depth, twist) = self.flutes;
        let at = count * (angle + self.phase + twist * t);
        let mut factor = 1.0 + depth * libm::cosf(at);
        let mut slope = -depth * count * libm::sinf(at);
        let (count, depth, reach) = self.buttresses;
        if depth > 0.0 && reach > 0.0 {
            let depth = depth * (1.0 - smoothstep(0.0, reach, height));
            let at = count * angle + self.phase;
            factor += depth * libm::cosf(at);
            slope -= depth * count * libm::sinf(at);
        }
        (factor.max(0.1), slope)
    }
}

/// What a branch's curve and radii are made from.
pub(super) struct Recipe<'a> {
    pub(super) spline: u16,
    /// Control points in any unit; scaled to `length`.
    pub(super) control: &'a [Vec3],
    pub(super) knots: Knots,
    pub(super) length: f32,
    pub(super) radius: f32,
    pub(super) taper: &'a Curve,
    /// Factor at the collar (1 is none) and the parent's radius at the junction, metres.
    pub(super) collar: (f32, f32),
    /// Largest radius of the very first ring that stays hidden in every parent, metres.
    pub(super) hidden: f32,
    /// True to stand upright at the base whatever the curve does: a trunk on the ground.
    pub(super) upright: bool,
    pub(super) flare: Option<Flare>,
    pub(super) flutes: Option<Flutes>,
    pub(super) phase: f32,
    pub(super) sides: u32,
    /// Rising parts of the length, one a geometry LOD.
    pub(super) tolerances: &'a [f32],
}

/// An end thicker than this part of the base is closed by a dome, not drawn out to a point.
const BLUNT_ABOVE: f32 = 0.25;

impl Branch {
    /// Builds the curve, frames, radii and ring LODs. `None` if the control points coincide.
    pub(super) fn build(recipe: &Recipe<'_>) -> Option<Self> {
        let curve = CatmullRom::new(recipe.control, recipe.knots)?;
        let mut axis = framed(&curve.samples(), recipe.length, recipe.upright)?;
        for sample in &mut axis {
            sample.radius = recipe.radius_at(sample.t);
        }
        let shape: Vec<[f32; 4]> = axis
            .iter()
            .map(|s| [s.position.x, s.position.y, s.position.z, s.radius])
            .collect();
        let control: Vec<u16> = (0..=curve.spans())
            .map(|i| u16::try_from(i * SAMPLES_PER_SPAN).unwrap_or(u16::MAX))
            .collect();
        let finest = recipe.tolerances.first().copied().unwrap_or(0.01);
        let refinement = Refinement::run(&shape, &control, finest * recipe.length);
        let rings: Vec<Vec<u16>> = recipe
            .tolerances
            .iter()
            .map(|&t| refinement.points(t * recipe.length))
            .collect();
        let end = recipe.taper.at(1.0);
        let blunt = end > BLUNT_ABOVE * recipe.taper.max();
        let sides = |(lod, rings): (usize, &Vec<u16>)| {
            // A pointed branch ends in an apex where the last ring would be.
            let full = if blunt { rings.len() } else { rings.len() - 1 };
            recipe.corners(lod, &axis, &rings[..full])
        };
        let sides: Vec<Vec<u8>> = rings.iter().enumerate().map(sides).collect();
        let flutes = recipe.flutes.map_or((0.0, 0.0, 0.0), |f| {
            (count(f.count), f.depth, f.twist_turns * crate::math::TAU)
        });
        let buttresses = recipe.flare.map_or((0.0, 0.0, 0.0), |f| {
            (
                count(f.lobes),
                if f.lobes == 0 {
                    0.0
                } else {
                    f.depth * f.amount * 0.5
                },
                f.height_m,
            )
        });
        Some(Self {
            spline: recipe.spline,
            length: recipe.length,
            radius: recipe.radius,
            axis,
            rings,
            sides,
            blunt,
            lobes: Lobes {
                flutes,
                buttresses,
                phase: recipe.phase,
            },
        })
    }

    /// The curve at part `t` of its length, between samples if need be.
    #[must_use]
    pub fn at(&self, t: f32) -> AxisSample {
        let after = self
            .axis
            .partition_point(|s| s.t <= t)
            .clamp(1, self.axis.len() - 1);
        let (a, b) = (&self.axis[after - 1], &self.axis[after]);
        let part = ((t - a.t) / (b.t - a.t)).clamp(0.0, 1.0);
        AxisSample {
            t,
            position: a.position.lerp(b.position, part),
            frame: a.frame.slerp(b.frame, part).normalize(),
            radius: a.radius + (b.radius - a.radius) * part,
        }
    }

    /// The rings of a geometry LOD that are full circles, as indices into `axis`, with their corners. LODs past
    /// the last are the last.
    pub fn tube(&self, lod: usize) -> impl ExactSizeIterator<Item = (usize, u32)> + Clone + '_ {
        let lod = lod.min(self.rings.len() - 1);
        let rings = self.rings[lod].iter().zip(&self.sides[lod]);
        rings.map(|(&ring, &sides)| (usize::from(ring), u32::from(sides)))
    }

    /// Triangles of a geometry LOD.
    #[must_use]
    pub fn triangles(&self, lod: usize) -> u64 {
        // Between two rings a triangle stands on each edge of both; the apex stands on the last ring.
        let sides = self.tube(lod).map(|(_, sides)| u64::from(sides));
        let first = sides.clone().next().unwrap_or(0);
        2 * sides.sum::<u64>() - first
    }

    /// Vertices of a geometry LOD: each ring has a seam, the apex one vertex a side.
    #[must_use]
    pub fn vertices(&self, lod: usize) -> u64 {
        let sides = self.tube(lod).map(|(_, sides)| u64::from(sides));
        let last = sides.clone().last().unwrap_or(0);
        sides.map(|sides| sides + 1).sum::<u64>() + last
    }

    pub(super) fn bytes(&self) -> usize {
        self.axis.len() * size_of::<AxisSample>()
            + self.rings.iter().map(|r| r.len() * 2).sum::<usize>()
            + self.sides.iter().map(Vec::len).sum::<usize>()
    }
}

impl Recipe<'_> {
    /// Corners of the full rings of a geometry LOD.
    ///
    /// The outline of a ring with n corners errs by its radius over n squared, so a given number of corners errs
    /// least in sum if n goes with the cube root of the radius over the tolerance. The finest LOD, and what is
    /// not round, has as many from base to tip.
    fn corners(&self, lod: usize, axis: &[AxisSample], rings: &[u16]) -> Vec<u8> {
        let most = float(self.sides) * libm::cbrtf(self.tolerances[0] / self.tolerances[lod]);
        let tapers = lod > 0 && self.flutes.is_none() && self.flare.is_none_or(|f| f.lobes == 0);
        let mut corners = Vec::with_capacity(rings.len());
        let mut widest = 0.0_f32;
        for &ring in rings.iter().rev() {
            // Corners never grow in number from the base to the tip.
            widest = widest.max(axis[usize::from(ring)].radius);
            corners.push(widest);
        }
        let share = |radius: f32| {
            if tapers {
                libm::cbrtf(radius / widest)
            } else {
                1.0
            }
        };
        let count = |radius: f32| {
            let count = round_to_u32(most * share(radius)).max(3);
            u8::try_from(count).unwrap_or(u8::MAX)
        };
        corners.into_iter().rev().map(count).collect()
    }

    fn radius_at(&self, t: f32) -> f32 {
        let along = t * self.length;
        let mut radius = self.radius * self.taper.at(t);
        let (collar, parent) = self.collar;
        if collar > 1.0 && parent > 0.0 {
            // Fades from the parent's surface over three radii of the child.
            radius *= 1.0
                + (collar - 1.0)
                    * (1.0 - smoothstep(0.8 * parent, parent + 3.0 * self.radius, along));
        }
        if let Some(flare) = self.flare {
            let u = (along / flare.height_m.max(1e-4)).min(1.0);
            radius *= 1.0 + flare.amount * (1.0 - u) * (1.0 - u);
        }
        if t == 0.0 {
            radius.min(self.hidden)
        } else {
            radius
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few lobes")]
fn count(lobes: u32) -> f32 {
    lobes as f32
}

/// Scales a polyline to `length`, moves its start to the origin and gives each point its part of the
/// arc length and a rotation-minimising frame (double reflection: Wang et al. 2008).
fn framed(points: &[Vec3], length: f32, upright: bool) -> Option<Vec<AxisSample>> {
    let raw: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    if !(raw > 0.0 && raw.is_finite()) {
        return None;
    }
    let scale = length / raw;
    let first = points[0];
    let at: Vec<Vec3> = points.iter().map(|&p| (p - first) * scale).collect();
    let tangent = |i: usize| {
        if upright && i == 0 {
            return Vec3::Y;
        }
        let before = at[i.saturating_sub(1)];
        let after = at[(i + 1).min(at.len() - 1)];
        (after - before).normalize_or(Vec3::Y)
    };
    let start = tangent(0);
    let mut side = crate::math::rotation_from_y(start) * Vec3::X;
    let mut samples = Vec::with_capacity(at.len());
    let mut along = 0.0;
    for i in 0..at.len() {
        let forward = tangent(i);
        if i > 0 {
            along += at[i].distance(at[i - 1]);
            side = transported(side, tangent(i - 1), forward, at[i] - at[i - 1]);
        }
        let across = side.cross(forward).normalize_or(Vec3::Z);
        let side = forward.cross(across);
        let frame = Quat::from_mat3(&glam::Mat3::from_cols(side, forward, across)).normalize();
        samples.push(AxisSample {
            t: along / length,
            position: at[i],
            frame,
            radius: 0.0,
        });
    }
    if let Some(last) = samples.last_mut() {
        last.t = 1.0;
    }
    Some(samples)
}

/// One step of double reflection.
fn transported(side: Vec3, from: Vec3, to: Vec3, step: Vec3) -> Vec3 {
    let c1 = step.dot(step);
    if c1 <= 0.0 {
        return side;
    }
    let reflect = |v: Vec3| v - step * (2.0 / c1 * step.dot(v));
    let (side, from) = (reflect(side), reflect(from));
    let v2 = to - from;
    let c2 = v2.dot(v2);
    if c2 <= 1e-12 {
        side
    } else {
        side - v2 * (2.0 / c2 * v2.dot(side))
    }
}

//! What casts the shadow, and where on the ground its map lies.

use crate::math::Vec2;
use crate::mesh::{Mesh, Primitive};
use crate::shadow::coverage::Coverage;
use crate::shadow::directions::Sample;

/// Lit texels around the shadow. Two are promised; snapping the trunk base to a texel's centre and
/// the shifts of the samples' grids each take less than one.
const MARGIN: f32 = 4.0;

/// Further texels for the filter that takes grain off, on maps that it is used on.
const FILTER_MARGIN: f32 = 2.0;

/// The shorter side of the ground rectangle is at least this part of the longer one: texels that
/// are much longer than wide look streaky and defeat a renderer's mips. Arbitrary.
const LEAST_ASPECT: f32 = 0.25;

/// Side of the ground rectangle of a tree without size, metres. Arbitrary.
const EMPTY_SIDE_M: f32 = 1.0;

/// The parts of a mesh that can cast a shadow on the ground.
#[derive(Clone, Debug)]
pub struct Casters {
    /// Vertices at or above the ground, metres; bark first, then foliage.
    pub points: Vec<[f32; 3]>,
    /// Solid triangles, as places in `points`.
    pub bark: Vec<[u32; 3]>,
    /// Alpha-tested triangles.
    pub leaves: Vec<Leaf>,
}

/// An alpha-tested triangle: twelve words without padding.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Leaf {
    /// Places in [`Casters::points`].
    pub corners: [u32; 3],
    /// Corners in texels of the full-size coverage.
    pub uv: [[f32; 2]; 3],
    /// Twice the triangle's area in the texture, square texels.
    pub uv_area: f32,
    /// Smallest mip on which the triangle is still told from its neighbours in the atlas.
    pub last_level: i32,
    /// Random number of the connected piece of foliage that it belongs to.
    pub key: u32,
}

impl Casters {
    /// Leaves out triangles wholly below the ground, with a vertex that is not finite, or with an
    /// index out of range.
    pub(super) fn new(mesh: &Mesh, coverage: &Coverage) -> Self {
        let vertices = mesh.bark.vertices.iter().chain(&mesh.foliage.vertices);
        let points = vertices.map(|v| [v.position[0], v.position[1].max(0.0), v.position[2]]);
        // Above 2^32 vertices no index of 32 bits could tell them anyway.
        let pieces = pieces(&mesh.foliage);
        let offset = u32::try_from(mesh.bark.vertices.len()).unwrap_or(u32::MAX);
        Self {
            points: points.collect(),
            bark: standing(&mesh.bark).collect(),
            leaves: standing(&mesh.foliage)
                .map(|corners| Leaf {
                    key: mix(pieces[corners[0] as usize]),
                    ..leaf(&mesh.foliage, corners, offset, coverage)
                })
                .collect(),
        }
    }

    fn corners(&self) -> impl Iterator<Item = [f32; 3]> {
        let leaves = self.leaves.iter().map(|leaf| leaf.corners);
        let triangles = self.bark.iter().copied().chain(leaves);
        triangles.flatten().map(|i| self.points[i as usize])
    }
}

/// Triangles that can cast a shadow.
fn standing(primitive: &Primitive) -> impl Iterator<Item = [u32; 3]> {
    let (triangles, _) = primitive.indices.as_chunks::<3>();
    let finite = |i: &u32| {
        let vertex = primitive.vertices.get(*i as usize);
        vertex.is_some_and(|v| v.position.iter().all(|x| x.is_finite()))
    };
    let above = |i: &u32| primitive.vertices[*i as usize].position[1] >= 0.0;
    let stands = move |t: &[u32; 3]| t.iter().all(finite) && t.iter().any(above);
    triangles.iter().copied().filter(stands)
}

fn leaf(primitive: &Primitive, corners: [u32; 3], offset: u32, coverage: &Coverage) -> Leaf {
    let [width, height] = coverage.size();
    let uv = corners.map(|i| {
        let [u, v] = primitive.vertices[i as usize].uv;
        [u * width, v * height]
    });
    let [a, b, c] = uv.map(Vec2::from_array);
    let size = a.max(b).max(c) - a.min(b).min(c);
    let levels = i32::try_from(coverage.count()).unwrap_or(i32::MAX);
    Leaf {
        corners: corners.map(|i| i.saturating_add(offset)),
        uv,
        uv_area: (b - a).perp_dot(c - a).abs(),
        // Two texels along the shorter side blend the least with what lies beside in the atlas.
        last_level: (floor_log2(size.min_element()) - 1).clamp(0, levels - 1),
        key: 0,
    }
}

/// For every vertex, one vertex of the connected piece that it belongs to, the same for all of it.
fn pieces(primitive: &Primitive) -> Vec<u32> {
    let count = u32::try_from(primitive.vertices.len()).unwrap_or(u32::MAX);
    let mut parents: Vec<u32> = (0..count).collect();
    for [a, b, c] in standing(primitive) {
        let root = root(&mut parents, a);
        for other in [b, c] {
            let other = self::root(&mut parents, other);
            parents[other as usize] = root;
        }
    }
    (0..count).map(|i| root(&mut parents, i)).collect()
}

fn root(parents: &mut [u32], mut place: u32) -> u32 {
    while parents[place as usize] != place {
        let parent = parents[place as usize];
        parents[place as usize] = parents[parent as usize];
        place = parent;
    }
    place
}

/// A number that looks random and differs between different inputs.
fn mix(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// How far from the samples' lights each piece of foliage may stray: changes of the shadow's place for half of
/// the freedom to either side, texels for a metre of height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stray {
    /// Along the first of two directions.
    pub along: Vec2,
    /// Along the second.
    pub across: Vec2,
}

impl Stray {
    /// The stray of a piece in one sample: change of the shadow's place, texels for a metre of
    /// height. Two samples after each other have opposite strays, so that a piece stays in place.
    #[inline]
    pub(super) fn of(&self, key: u32, sample: usize) -> Vec2 {
        /// Halves are 2^16 over the plastic number's powers: points that fill a square evenly.
        const STEP: u32 = 0xc13f_91e1;
        #[expect(clippy::cast_possible_truncation, reason = "at most 64 * 256 samples")]
        let pair = sample.div_ceil(2) as u32;
        let [a, b, c, d] = key.wrapping_add(pair.wrapping_mul(STEP)).to_le_bytes();
        let part = |bits| (f32::from(u16::from_le_bytes(bits)) + 0.5) / 65_536.0 - 0.5;
        let stray = self.along * part([a, b]) + self.across * part([c, d]);
        if sample.is_multiple_of(2) {
            stray
        } else {
            -stray
        }
    }
}

/// The parallel projection of one sample's light onto the texels of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where the world's origin falls, texels.
    pub origin: Vec2,
    /// Texels for a metre along X and Z.
    pub a_metre: Vec2,
    /// Texels that a shadow's place moves back for a metre of height.
    pub lean: Vec2,
}

impl Projection {
    /// Where a point's shadow falls, texels.
    #[inline]
    pub(super) fn shadow(&self, [x, y, z]: [f32; 3]) -> [f32; 2] {
        let Self {
            origin,
            a_metre,
            lean,
        } = self;
        [
            origin.x + x * a_metre.x - y * lean.x,
            origin.y + z * a_metre.y - y * lean.y,
        ]
    }
}

/// Floor of the binary logarithm, from the exponent's bits; below -126 for zero.
#[inline]
pub(super) fn floor_log2(x: f32) -> i32 {
    let exponent = (x.to_bits() >> 23) & 0xff;
    exponent.cast_signed() - 127
}

/// The part of the ground that a map covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    /// Smallest X and Z, metres.
    low_m: Vec2,
    /// Texel size along X and Z, metres.
    texel_m: Vec2,
    size: u32,
    /// Texel whose centre is the origin.
    pub(super) trunk_base: [u16; 2],
}

impl Ground {
    /// Holds the shadows of all samples and the origin, with a lit border.
    pub(super) fn around(casters: &Casters, samples: &[Sample], step: f32, size: u32) -> Self {
        let (low, high) = extent(casters, samples, step);
        let longest = (high - low).max_element();
        let least = if longest > 1e-6 {
            longest * LEAST_ASPECT
        } else {
            EMPTY_SIDE_M
        };
        let spare = (Vec2::splat(least) - (high - low)).max(Vec2::ZERO) * 0.5;
        let (low, high) = (low - spare, high + spare);
        let margin = if size >= super::bake::FILTERED_FROM {
            MARGIN + FILTER_MARGIN
        } else {
            MARGIN
        };
        #[expect(clippy::cast_precision_loss, reason = "maps have at most 8192 columns")]
        let texel_m = (high - low) / (size as f32 - 2.0 * margin);
        let base = (margin - low / texel_m).floor();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between the margins of a map of at most 8192 columns"
        )]
        let trunk_base = [base.x as u16, base.y as u16];
        Self {
            low_m: -(base + 0.5) * texel_m,
            texel_m,
            size,
            trunk_base,
        }
    }

    /// Smallest X, smallest Z, largest X, largest Z, metres.
    pub(super) fn rect_m(&self) -> [f32; 4] {
        #[expect(clippy::cast_precision_loss, reason = "maps have at most 8192 columns")]
        let high = self.low_m + self.texel_m * self.size as f32;
        [self.low_m.x, self.low_m.y, high.x, high.y]
    }

    /// The freedom of foliage around the samples of a light, when bands are `step` radians apart.
    pub(super) fn stray(&self, light: &Sample, step: f32) -> Stray {
        let [along, across] = tangents(light, step).map(|tangent| tangent / self.texel_m);
        Stray { along, across }
    }

    /// Where shadows fall in the light of `sample`, on a grid shifted by `shift` texels.
    pub(super) fn projection(&self, sample: &Sample, shift: Vec2) -> Projection {
        let a_metre = 1.0 / self.texel_m;
        Projection {
            origin: shift - self.low_m * a_metre,
            a_metre,
            lean: lean(sample) * a_metre,
        }
    }
}

/// How far the light of a sample has gone along X and Z after falling by one metre, backward.
fn lean(sample: &Sample) -> Vec2 {
    Vec2::new(sample.to_light.x, sample.to_light.z) / sample.to_light.y
}

/// Changes of the lean when the light turns by `step` radians, along two directions square to it
/// and to each other.
fn tangents(sample: &Sample, step: f32) -> [Vec2; 2] {
    let (a, b) = sample.to_light.any_orthonormal_pair();
    [a, b].map(|side| {
        let level = Vec2::new(side.x, side.z);
        (level - lean(sample) * side.y) * (step / sample.to_light.y)
    })
}

/// The corners, X and Z, of what the shadows of all samples cover together with the origin.
fn extent(casters: &Casters, samples: &[Sample], step: f32) -> (Vec2, Vec2) {
    // A point's shadow is linear in the lean, so that its extremes are those of the lean.
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    let stray = samples
        .first()
        .map_or([Vec2::ZERO; 2], |light| tangents(light, step));
    let stray = (stray[0].abs() + stray[1].abs()) * 0.5;
    for lean in samples.iter().map(lean) {
        (least, most) = (least.min(lean - stray), most.max(lean + stray));
    }
    let whole = (Vec2::ZERO, Vec2::ZERO);
    casters.corners().fold(whole, |(low, high), [x, y, z]| {
        let foot = Vec2::new(x, z);
        (low.min(foot - most * y), high.max(foot - least * y))
    })
}

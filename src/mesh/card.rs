//! Leaf cards and the quads of cross-quads.

use super::WHITE;
use super::template::{Material, Template, TemplateVertex};
use crate::image::trim::{Corners, WHOLE};
use crate::math::Vec3;

/// Part of a texture: `u0, v0` its upper left corner, `u1, v1` its lower right, in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvRect {
    /// Left.
    pub u0: f32,
    /// Top.
    pub v0: f32,
    /// Right.
    pub u1: f32,
    /// Bottom.
    pub v1: f32,
}

impl UvRect {
    /// The whole texture.
    pub const ALL: Self = Self {
        u0: 0.0,
        v0: 0.0,
        u1: 1.0,
        v1: 1.0,
    };

    /// True for a place inside or on the edge.
    #[must_use]
    pub fn holds(&self, [u, v]: [f32; 2]) -> bool {
        (self.u0..=self.u1).contains(&u) && (self.v0..=self.v1).contains(&v)
    }
}

/// A picture in a texture: its part, and the outline of what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane {
    /// Its part of the texture.
    pub uv: UvRect,
    /// The outline's corners; see [`trimmed`](crate::image::trim::trimmed).
    pub corners: Corners,
}

impl Pane {
    /// A whole texture, untrimmed.
    pub const ALL: Self = Self {
        uv: UvRect::ALL,
        corners: WHOLE,
    };

    /// Texture coordinates of a place that reaches from -1 to 1, y up.
    fn uv_at(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let UvRect { u0, v0, u1, v1 } = self.uv;
        // Exact at the ends.
        let mix = |a: f32, b: f32, part: f32| a * (0.5 - 0.5 * part) + b * (0.5 + 0.5 * part);
        [mix(u0, u1, x), mix(v1, v0, y)]
    }
}

/// How far the normals at a leaf card's two long edges lean outward, radians: rounds the shading of a
/// flat card a little, as a real blade's cross-section does.
const EDGE_LEAN: f32 = 0.35;

/// A leaf card: stalk at the origin, along +Y, upper side toward +Z; folded up along its midrib by
/// `fold` radians (4 triangles) or flat (2 triangles), trimmed to what it shows.
#[must_use]
pub fn leaf(length: f32, width: f32, fold: f32, pane: &Pane) -> Template {
    let corners = &pane.corners;
    // Columns of two corners each.
    let columns: Vec<[[f32; 2]; 2]> = if fold == 0.0 {
        vec![[corners[0], corners[2]], [corners[1], corners[3]]]
    } else {
        // A fold is straight: the box around the outline, on both sides of it.
        let all = |axis: usize| corners.iter().map(move |c| c[axis]);
        let [left, bottom] = [0, 1].map(|axis| all(axis).fold(1.0_f32, f32::min));
        let [right, top] = [0, 1].map(|axis| all(axis).fold(-1.0_f32, f32::max));
        let columns = [left.min(-NARROWEST), 0.0, right.max(NARROWEST)];
        columns.map(|x| [[x, bottom], [x, top]]).to_vec()
    };
    let (fold_sine, fold_cosine) = libm::sincosf(fold);
    let mut template = Template {
        material: Material::Foliage,
        ..Template::default()
    };
    for &[x, y] in columns.iter().flatten() {
        let side = x * width * 0.5;
        let (sine, cosine) = libm::sincosf(x * (EDGE_LEAN - fold));
        let out = Vec3::new(side * fold_cosine, 0.0, side.abs() * fold_sine);
        template.vertices.push(TemplateVertex {
            axis: out + Vec3::Y * (length * (y * 0.5 + 0.5)),
            offset: Vec3::ZERO,
            normal: Vec3::new(sine, 0.0, cosine),
            tangent: Vec3::new(cosine, 0.0, -sine),
            uv: pane.uv_at([x, y]),
            tint: WHITE,
        });
    }
    for column in 0..u32::try_from(columns.len()).unwrap_or(2) - 1 {
        let a = column * 2;
        template.indices.extend([a, a + 2, a + 3, a, a + 3, a + 1]);
    }
    template
}

/// Least half of a folded card, as a part of its half width.
const NARROWEST: f32 = 0.05;

/// One captured quad of a cross-quad or of a set of planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Middle of the quad, metres in the prototype's frame.
    pub centre: Vec3,
    /// Unit vector along rising u.
    pub right: Vec3,
    /// Unit vector up the image, at right angles to `right`.
    pub up: Vec3,
    /// Half of the width and half of the height, metres.
    pub half: [f32; 2],
    /// The part of the half width that a node's thickness multiplies, metres.
    pub thick: f32,
    /// Thickness of the node that was captured: at this thickness the quad has its half width.
    pub captured_thickness: f32,
    /// Its picture in the atlas.
    pub pane: Pane,
}

impl Quad {
    /// The same picture on a quad `factor` times as large about its middle.
    #[must_use]
    pub fn scaled(&self, factor: f32) -> Self {
        Self {
            half: self.half.map(|h| h * factor),
            thick: self.thick * factor,
            ..*self
        }
    }

    /// The same, but an upright quad of the first level grows in width only: it stands on the ground, and
    /// must neither sink nor rise.
    #[must_use]
    pub fn scaled_on(&self, level: usize, factor: f32) -> Self {
        let scaled = self.scaled(factor);
        if level == 0 && self.up == Vec3::Y {
            Self {
                half: [scaled.half[0], self.half[1]],
                ..scaled
            }
        } else {
            scaled
        }
    }
}

/// One capture's place in the atlas and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// Place in the atlas.
    pub uv: UvRect,
    /// Length of its longer side at scale 1, metres: the unit of its depth offsets.
    pub longer: f32,
}

/// The quads of one node, each 2 triangles, seen from both sides, trimmed to what they show.
#[must_use]
pub fn quads(quads: &[Quad]) -> Template {
    let mut template = Template {
        material: Material::Foliage,
        ..Template::default()
    };
    for quad in quads {
        let base = u32::try_from(template.vertices.len()).unwrap_or(u32::MAX);
        let normal = quad.right.cross(quad.up);
        for [x, y] in quad.pane.corners {
            let across = quad.right * x;
            template.vertices.push(TemplateVertex {
                axis: quad.centre
                    + across * (quad.half[0] - quad.thick)
                    + quad.up * (y * quad.half[1]),
                offset: across * (quad.thick / quad.captured_thickness),
                normal,
                tangent: quad.right,
                uv: quad.pane.uv_at([x, y]),
                tint: WHITE,
            });
        }
        template
            .indices
            .extend([0, 1, 3, 0, 3, 2].map(|i| base + i));
    }
    template
}

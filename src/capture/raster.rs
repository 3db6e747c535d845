//! The CPU rasteriser: which triangle is seen at each sample, and what its surface is like there.
//!
//! A visibility buffer (depth and triangle per sample) is filled first, with foliage alpha-tested; the
//! surface is worked out once per visible sample afterwards. Triangles are drawn in order and ties in
//! depth go to the first, so the result is the same bytes however the rows are split between threads.

pub use crate::image::cutouts::ALPHA_CUTOFF;
use crate::image::cutouts::Cutouts;
use crate::image::scan::{self, Clip};
use crate::image::{Image, Texel, mips};
use crate::math::{Vec2, Vec3, float, floor_to_u32};
use crate::mesh::card::Relief;
use crate::mesh::{Mesh, Primitive, Vertex, WHITE};
use rayon::prelude::*;

/// An orthographic camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Point in the middle of the picture.
    pub centre: Vec3,
    /// Unit vector to the right of the picture.
    pub right: Vec3,
    /// Unit vector up the picture.
    pub up: Vec3,
    /// Half of the picture's width and height, metres.
    pub half: [f32; 2],
    /// Samples across.
    pub width: u32,
    /// Samples down.
    pub height: u32,
}

impl View {
    /// Unit vector toward the viewer.
    #[must_use]
    pub fn toward(&self) -> Vec3 {
        self.right.cross(self.up)
    }

    /// Sample position (x right, y down) and depth (metres toward the viewer from the centre).
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "picture sizes are far below 2^24"
    )]
    pub fn project(&self, point: Vec3) -> (Vec2, f32) {
        let p = point - self.centre;
        let x = (p.dot(self.right) / self.half[0] * 0.5 + 0.5) * self.width as f32;
        let y = (0.5 - p.dot(self.up) / self.half[1] * 0.5) * self.height as f32;
        (Vec2::new(x, y), p.dot(self.toward()))
    }

    /// The point at a sample position and depth.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        reason = "picture sizes are far below 2^24"
    )]
    pub fn unproject(&self, sample: Vec2, depth: f32) -> Vec3 {
        let x = (sample.x / self.width as f32 - 0.5) * 2.0 * self.half[0];
        let y = (0.5 - sample.y / self.height as f32) * 2.0 * self.half[1];
        self.centre + self.right * x + self.up * y + self.toward() * depth
    }
}

/// An atlas ready to be drawn.
#[derive(Clone, Debug)]
pub struct Foliage {
    mips: Vec<Image<Texel>>,
    /// Of each mip.
    cutouts: Vec<Cutouts>,
}

impl Foliage {
    /// An atlas and at most `levels - 1` smaller mips, their covered area kept.
    #[must_use]
    pub fn of(atlas: Image<Texel>, levels: usize) -> Self {
        let mips = mips::chain(atlas, levels, ALPHA_CUTOFF);
        let cutouts = mips.iter().map(Cutouts::of).collect();
        Self { mips, cutouts }
    }

    /// The mips, finest first.
    #[must_use]
    pub fn mips(&self) -> &[Image<Texel>] {
        &self.mips
    }

    /// The atlas that this was made of.
    #[must_use]
    pub fn into_atlas(mut self) -> Image<Texel> {
        self.mips.swap_remove(0)
    }
}

/// Texture mips, finest first, with texels in the wanted form.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    /// Repeats in both directions.
    pub bark: &'a [Image<Texel>],
    /// The atlas; alpha-tested.
    pub foliage: &'a Foliage,
    /// The captures in the atlas: what lies on them stands out of its plane by its depth offset.
    pub reliefs: &'a [Relief],
}

/// The surface seen at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Normal in *view* axes (right, up, toward the viewer), depth in metres toward the viewer.
    pub texel: Texel,
    /// True if it lies on a capture, whose occlusion is that of all it shows.
    pub captured: bool,
    /// Which of the [`Textures::reliefs`] it lies on.
    pub relief: Option<usize>,
}

/// What each sample sees.
#[derive(Debug)]
pub struct Visibility {
    /// Metres toward the viewer; minus infinity where nothing is.
    depth: Vec<f32>,
    /// Triangle, its lowest bit 1 for foliage; `NOTHING` where nothing is.
    seen: Vec<u32>,
    /// Sample positions of the vertices of bark and foliage.
    screen: [Vec<(Vec2, f32)>; 2],
    width: u32,
}

const NOTHING: u32 = u32::MAX;

/// Rows that one thread fills at a time. Each band looks at every triangle, so few are better.
const BAND: usize = 512;

impl Visibility {
    /// Draws a mesh.
    #[must_use]
    pub fn draw(mesh: &Mesh, textures: Textures<'_>, view: &View) -> Self {
        let count = view.width as usize * view.height as usize;
        let mut depth = vec![f32::NEG_INFINITY; count];
        let mut seen = vec![NOTHING; count];
        let project = |primitive: &Primitive| -> Vec<(Vec2, f32)> {
            primitive
                .vertices
                .iter()
                .map(|v| view.project(Vec3::from(v.position)))
                .collect()
        };
        let (bark, foliage) = (project(&mesh.bark), project(&mesh.foliage));
        let width = view.width as usize;
        let rows = BAND * width;
        depth
            .par_chunks_mut(rows)
            .zip(seen.par_chunks_mut(rows))
            .enumerate()
            .for_each(|(band, (depth, seen))| {
                let top = band * BAND;
                let mut target = Band {
                    depth,
                    seen,
                    clip: Clip {
                        x0: 0,
                        y0: u32::try_from(top).unwrap_or(u32::MAX),
                        x1: view.width,
                        y1: u32::try_from(top + BAND)
                            .unwrap_or(u32::MAX)
                            .min(view.height),
                    },
                };
                target.opaque(&bark, &mesh.bark.indices);
                target.tested(&foliage, &mesh.foliage, textures.foliage);
            });
        Self {
            depth,
            seen,
            screen: [bark, foliage],
            width: view.width,
        }
    }

    /// Depth at a sample, metres toward the viewer; `None` where nothing is.
    #[must_use]
    pub fn depth(&self, x: u32, y: u32) -> Option<f32> {
        let at = y as usize * self.width as usize + x as usize;
        (self.seen[at] != NOTHING).then(|| self.depth[at])
    }

    /// The surface seen at a sample, its normal facing the viewer. `None` where nothing is.
    #[must_use]
    pub fn surface(
        &self,
        x: u32,
        y: u32,
        mesh: &Mesh,
        textures: Textures<'_>,
        view: &View,
    ) -> Option<Seen> {
        let at = y as usize * self.width as usize + x as usize;
        let seen = self.seen[at];
        if seen == NOTHING {
            return None;
        }
        let is_foliage = seen & 1 == 1;
        let primitive = if is_foliage {
            &mesh.foliage
        } else {
            &mesh.bark
        };
        let first = (seen >> 1) as usize * 3;
        let at_corner = |i: usize| primitive.indices[first + i] as usize;
        let corners: [&Vertex; 3] = core::array::from_fn(|i| &primitive.vertices[at_corner(i)]);
        let projected = &self.screen[usize::from(is_foliage)];
        let screen = core::array::from_fn(|i| projected[at_corner(i)].0);
        #[expect(
            clippy::cast_precision_loss,
            reason = "picture sizes are far below 2^24"
        )]
        let sample = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let b = barycentric(screen, sample);
        let mips = if is_foliage {
            textures.foliage.mips()
        } else {
            textures.bark
        };
        let level = mip_level(screen, corners.map(|c| c.uv), mips);
        let uv: [f32; 2] = core::array::from_fn(|k| {
            corners[0].uv[k] * b[0] + corners[1].uv[k] * b[1] + corners[2].uv[k] * b[2]
        });
        let mut texel = *fetch(&mips[level], uv, is_foliage);
        texel.normal = view_normal(corners, b, &texel, view).to_array();
        let relief = if is_foliage {
            relief(textures.reliefs, uv)
        } else {
            None
        };
        let longer = relief.map_or(0.0, |r| textures.reliefs[r].longer);
        texel.depth = self.depth[at] + texel.depth * longer;
        texel.alpha = 1.0;
        if !is_foliage {
            texel.translucency = 0.0;
        }
        if corners.iter().any(|c| c.tint != WHITE) {
            for (channel, part) in texel.albedo.iter_mut().enumerate() {
                let at = |i: usize| f32::from(corners[i].tint[channel]) * b[i];
                *part *= (at(0) + at(1) + at(2)) / 255.0;
            }
        }
        Some(Seen {
            texel,
            captured: relief.is_some(),
            relief,
        })
    }
}

/// The capture that a place in the atlas belongs to.
fn relief(reliefs: &[Relief], uv: [f32; 2]) -> Option<usize> {
    reliefs.iter().position(|r| r.uv.holds(uv))
}

/// The mapped normal of a point on a triangle, in view axes, facing the viewer.
fn view_normal(corners: [&Vertex; 3], b: [f32; 3], texel: &Texel, view: &View) -> Vec3 {
    let mix =
        |f: fn(&Vertex) -> Vec3| f(corners[0]) * b[0] + f(corners[1]) * b[1] + f(corners[2]) * b[2];
    let normal = mix(|v| Vec3::from(v.normal)).normalize_or(Vec3::Z);
    let tangent = mix(|v| Vec3::new(v.tangent[0], v.tangent[1], v.tangent[2]));
    let tangent = (tangent - normal * normal.dot(tangent)).normalize_or(Vec3::X);
    let bitangent = normal.cross(tangent) * corners[0].tangent[3];
    let [x, y, z] = texel.normal;
    // The far side of a card mirrors the near one: its slopes stay, only its plane faces about. (A viewer
    // that negates the whole normal, as glTF asks, would light the backs of quads from below.)
    let facing = if normal.dot(view.toward()) < 0.0 {
        -normal
    } else {
        normal
    };
    let world = (tangent * x + bitangent * y + facing * z).normalize_or(facing);
    let local = Vec3::new(
        world.dot(view.right),
        world.dot(view.up),
        world.dot(view.toward()),
    );
    // A slope that leans past the horizon is seen at the horizon.
    Vec3::new(local.x, local.y, local.z.max(0.02)).normalize_or(Vec3::Z)
}

/// One thread's rows.
struct Band<'a> {
    depth: &'a mut [f32],
    seen: &'a mut [u32],
    clip: Clip,
}

impl Band<'_> {
    fn opaque(&mut self, screen: &[(Vec2, f32)], indices: &[u32]) {
        let mut triangle = 0;
        for corner in indices.chunks_exact(3) {
            let corners = [corner[0], corner[1], corner[2]].map(|i| screen[i as usize]);
            if self.touches(&corners) {
                self.triangle(corners, triangle, |_| true);
            }
            triangle += 2;
        }
    }

    fn tested(&mut self, screen: &[(Vec2, f32)], primitive: &Primitive, atlas: &Foliage) {
        let mut triangle = 1;
        for corner in primitive.indices.chunks_exact(3) {
            let [i, j, k] = [corner[0], corner[1], corner[2]].map(|i| i as usize);
            let corners = [screen[i], screen[j], screen[k]];
            if self.touches(&corners) {
                let uv = [i, j, k].map(|i| primitive.vertices[i].uv);
                let level = mip_level(corners.map(|c| c.0), uv, &atlas.mips);
                let (cutouts, mip) = (&atlas.cutouts[level], &atlas.mips[level]);
                let [width, height] = [mip.width(), mip.height()].map(float);
                self.triangle(corners, triangle, |b| {
                    let at: [f32; 2] = core::array::from_fn(|k| {
                        uv[0][k] * b[0] + uv[1][k] * b[1] + uv[2][k] * b[2]
                    });
                    let [x, y] = [at[0] * width, at[1] * height].map(floor_to_u32);
                    cutouts.at(i64::from(x), i64::from(y))
                });
            }
            triangle += 2;
        }
    }

    /// False if a triangle's box holds no sample of the rows: most triangles of a far crown.
    #[inline]
    fn touches(&self, corners: &[(Vec2, f32); 3]) -> bool {
        let [a, b, c] = corners.map(|(p, _)| p);
        let (low, high) = (a.min(b).min(c) + 0.5, a.max(b).max(c) + 0.5);
        let first = floor_to_u32(low.y).max(self.clip.y0);
        low.x.floor() != high.x.floor() && first < floor_to_u32(high.y).min(self.clip.y1)
    }

    #[inline]
    fn triangle(&mut self, corners: [(Vec2, f32); 3], id: u32, covers: impl Fn([f32; 3]) -> bool) {
        let (depth, seen, clip) = (&mut *self.depth, &mut *self.seen, self.clip);
        let depths = corners.map(|c| c.1);
        scan::triangle(corners.map(|c| c.0), clip, |x, y, b| {
            let at = (y - clip.y0) as usize * clip.x1 as usize + x as usize;
            let z = depths[0] * b[0] + depths[1] * b[1] + depths[2] * b[2];
            if z > depth[at] && covers(b) {
                depth[at] = z;
                seen[at] = id;
            }
        });
    }
}

fn barycentric([a, b, c]: [Vec2; 3], p: Vec2) -> [f32; 3] {
    let area = (b - a).perp_dot(c - a);
    if area == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let wb = (p - a).perp_dot(c - a) / area;
    let wc = (b - a).perp_dot(p - a) / area;
    [1.0 - wb - wc, wb, wc]
}

/// The mip whose texels are about as large as the samples, from the areas of the triangle in both.
#[expect(
    clippy::cast_precision_loss,
    reason = "texture sizes are far below 2^24"
)]
pub(crate) fn mip_level<P>([a, b, c]: [Vec2; 3], uv: [[f32; 2]; 3], mips: &[Image<P>]) -> usize {
    let size = Vec2::new(mips[0].width() as f32, mips[0].height() as f32);
    let [ta, tb, tc] = uv.map(|uv| Vec2::from(uv) * size);
    let texels = (tb - ta).perp_dot(tc - ta).abs();
    let samples = (b - a).perp_dot(c - a).abs().max(1e-6);
    // Each level quarters the area; change over at the geometric mean of neighbouring levels.
    let mut ratio = texels / samples;
    let mut level = 0;
    while ratio > 2.0 && level + 1 < mips.len() {
        ratio *= 0.25;
        level += 1;
    }
    level
}

/// The nearest texel; foliage clamps at the edge, bark repeats.
#[expect(
    clippy::cast_precision_loss,
    reason = "texture sizes are far below 2^24"
)]
fn fetch(image: &Image<Texel>, [u, v]: [f32; 2], clamp: bool) -> &Texel {
    let (u, v) = if clamp {
        (u, v)
    } else {
        (u - u.floor(), v - v.floor())
    };
    let x = floor_to_u32(u * image.width() as f32).min(image.width() - 1);
    let y = floor_to_u32(v * image.height() as f32).min(image.height() - 1);
    image.at(x, y)
}

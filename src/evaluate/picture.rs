//! Pictures of a mesh under the evaluation's lights: what an eye, and FLIP, compare.
//!
//! A plain grey behind, and no ground: nothing that would hide an edge or be compared beside the tree.

use super::light::{LIGHTS, Light};
use crate::asset::Surface;
use crate::capture::{ALPHA_CUTOFF, Foliage, Textures, View, Visibility};
use crate::image::{Image, Texel, mips};
use crate::math::{Vec2, Vec3, float, srgb_from_linear};
use crate::measure::silhouette::{Cutouts, Silhouette};
use crate::mesh::card::{Relief, UvRect};
use crate::mesh::{Mesh, Primitive};
use std::borrow::Cow;

/// Greys behind the tree, linear, as they are seen, one for each light: a middle one, before which neither a
/// light nor a dark crown vanishes, and a dark one, on which the bright edges of leaves and quads stand out.
const BACKGROUNDS: [f32; LIGHTS] = [0.184, 0.012];

/// Rows of samples from which sorting leaves costs less than the texels that it spares.
const WORTH_SORTING: u32 = 400;

/// Mips of the foliage atlas: its gutters stand four halvings.
const FOLIAGE_MIPS: usize = 5;

/// Mips of the bark, which repeats.
const BARK_MIPS: usize = 10;

/// Textures of a model, ready to be fetched.
pub(super) struct Skin {
    bark: Vec<Image<Texel>>,
    foliage: Foliage,
    reliefs: Vec<Relief>,
    /// Which texels of the atlas are there.
    pub(super) cutouts: Cutouts,
}

impl Skin {
    pub(super) fn of(foliage: &Surface, bark: &Surface, reliefs: &[Relief]) -> Self {
        // Packs hold no alpha of the bark, so none may count.
        let mut opaque = bark.texels();
        opaque.texels_mut().iter_mut().for_each(|t| t.alpha = 1.0);
        let foliage = foliage.texels();
        Self {
            cutouts: Cutouts::of(&foliage),
            bark: mips::chain(opaque, BARK_MIPS, ALPHA_CUTOFF),
            foliage: Foliage::of(foliage, FOLIAGE_MIPS),
            reliefs: reliefs.to_vec(),
        }
    }

    /// The captures that a mesh shows: fewer to look through for each sample than all of the atlas.
    fn reliefs_of(&self, mesh: &Mesh) -> Vec<Relief> {
        let shown = |relief: &&Relief| {
            let UvRect { u0, v0, u1, v1 } = relief.uv;
            let vertices = mesh.foliage.vertices.iter();
            let mut places = vertices.map(|v| v.uv);
            places.any(|[u, v]| (u0..=u1).contains(&u) && (v0..=v1).contains(&v))
        };
        self.reliefs.iter().filter(shown).copied().collect()
    }
}

/// What is drawn.
pub(super) struct Sitter<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) skin: &'a Skin,
    reliefs: Vec<Relief>,
}

impl<'a> Sitter<'a> {
    pub(super) fn new(mesh: &'a Mesh, skin: &'a Skin) -> Self {
        Self {
            mesh,
            skin,
            reliefs: skin.reliefs_of(mesh),
        }
    }
}

/// One model from one view.
pub(super) struct Picture {
    /// sRGB, by light.
    pub(super) colours: [Image<[u8; 3]>; LIGHTS],
    /// Covered where at least half of the samples are.
    pub(super) silhouette: Silhouette,
    /// True where any sample is covered: where the colour is not the background's alone.
    pub(super) touched: Vec<bool>,
    /// Unit normals in view axes, means of the samples; zero where nothing is.
    pub(super) normals: Vec<Vec3>,
}

impl Picture {
    /// Draws a mesh with `n` by `n` samples in each pixel of `view`.
    pub(super) fn draw(sitter: &Sitter<'_>, light: &Light, view: &View, n: u32) -> Self {
        let samples = View {
            width: view.width * n,
            height: view.height * n,
            ..*view
        };
        let mesh = if samples.height < WORTH_SORTING {
            Cow::Borrowed(sitter.mesh)
        } else {
            Cow::Owned(near_first(sitter.mesh, view))
        };
        let textures = Textures {
            bark: &sitter.skin.bark,
            foliage: &sitter.skin.foliage,
            reliefs: &sitter.reliefs,
        };
        let seen = Visibility::draw(&mesh, textures, &samples);
        let count = view.width as usize * view.height as usize;
        let mut picture = Self {
            colours: BACKGROUNDS
                .map(|grey| Image::filled(view.width, view.height, [srgb_from_linear(grey); 3])),
            silhouette: Silhouette::empty(view),
            touched: vec![false; count],
            normals: vec![Vec3::ZERO; count],
        };
        for (y, x) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (y, x))) {
            let corner = (x * n, y * n);
            let sample = |i: u32, j: u32| {
                let found = seen.surface(i, j, &mesh, textures, &samples)?;
                let at = Vec2::new(float(i) + 0.5, float(j) + 0.5);
                let point = samples.unproject(at, found.texel.depth);
                let light = light.on(&found, point, &samples).map(tone_mapped);
                Some((light, Vec3::from(found.texel.normal)))
            };
            let pixel = Pixel::of(n, corner, |i, j| seen.depth(i, j).is_some(), sample);
            if let Some(pixel) = pixel {
                picture.set(y as usize * view.width as usize + x as usize, &pixel);
            }
        }
        picture
    }

    fn set(&mut self, at: usize, pixel: &Pixel) {
        let backs = pixel.light.into_iter().zip(BACKGROUNDS);
        for (colour, (light, background)) in self.colours.iter_mut().zip(backs) {
            let light = light.lerp(Vec3::splat(background), 1.0 - pixel.covered);
            colour.texels_mut()[at] = light.to_array().map(srgb_from_linear);
        }
        self.silhouette.covered[at] = pixel.covered >= 0.5;
        self.touched[at] = true;
        self.normals[at] = pixel.normal;
    }
}

/// What is seen in one pixel.
struct Pixel {
    /// Part of the samples that are covered, above 0.
    covered: f32,
    /// Means over what is covered, by light.
    light: [Vec3; LIGHTS],
    /// Unit, in view axes.
    normal: Vec3,
}

impl Pixel {
    /// A pixel of `n` by `n` samples from `corner` on; none if nothing covers it.
    ///
    /// Every sample counts for the coverage. Colour is taken from every second one, as on a chessboard, and from
    /// the others only where those see nothing: the eye's own blur is wider than a pixel.
    fn of(
        n: u32,
        (x, y): (u32, u32),
        is_covered: impl Fn(u32, u32) -> bool,
        sample: impl Fn(u32, u32) -> Option<([Vec3; LIGHTS], Vec3)>,
    ) -> Option<Self> {
        let all = || (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let covered = all().filter(|(i, j)| is_covered(x + i, y + j)).count();
        if covered == 0 {
            return None;
        }
        let (mut light, mut normal, mut count) = ([Vec3::ZERO; LIGHTS], Vec3::ZERO, 0);
        for colour in [0, 1] {
            for (i, j) in all().filter(|(i, j)| (i + j) % 2 == colour) {
                if let Some((sample_light, sample_normal)) = sample(x + i, y + j) {
                    for (sum, sample) in light.iter_mut().zip(sample_light) {
                        *sum += sample;
                    }
                    normal += sample_normal;
                    count += 1;
                }
            }
            if count > 0 {
                break;
            }
        }
        let covered = u32::try_from(covered).unwrap_or(u32::MAX);
        Some(Self {
            covered: float(covered) / float(n * n),
            light: light.map(|sum| sum / float(count)),
            normal: normal.normalize_or(Vec3::Z),
        })
    }
}

/// The same mesh with its leaves and quads in the order of their distance: what is hidden then needs no texture.
fn near_first(mesh: &Mesh, view: &View) -> Mesh {
    let toward = view.toward();
    let depths: Vec<f32> = mesh
        .foliage
        .vertices
        .iter()
        .map(|v| Vec3::from(v.position).dot(toward))
        .collect();
    let depth = |t: &[u32; 3]| {
        t.iter()
            .map(|&i| depths[i as usize])
            .fold(f32::MIN, f32::max)
    };
    let corners = mesh.foliage.indices.chunks_exact(3);
    let mut triangles: Vec<(f32, [u32; 3])> = corners
        .map(|c| [c[0], c[1], c[2]])
        .map(|t| (depth(&t), t))
        .collect();
    // Stable, so that the order of what is equally near is the mesh's.
    triangles.sort_by(|a, b| b.0.total_cmp(&a.0));
    Mesh {
        bark: mesh.bark.clone(),
        foliage: Primitive {
            vertices: mesh.foliage.vertices.clone(),
            indices: triangles.into_iter().flat_map(|(_, t)| t).collect(),
            ..Primitive::default()
        },
    }
}

/// A soft shoulder without a toe: what lies in the shade is compared too.
fn tone_mapped(light: Vec3) -> Vec3 {
    let x = light * 0.85;
    (x * (x * 0.22 + 1.0)) / (x * (x * 0.25 + 1.0) + 0.35) * 1.04
}

/// Part of a picture: columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Crop {
    pub(super) x0: usize,
    pub(super) y0: usize,
    pub(super) x1: usize,
    pub(super) y1: usize,
}

impl Crop {
    /// The smallest part that holds all that the pictures touch, with so many pixels of air where the picture
    /// has them; none if nothing is touched. All pictures have the size of the first.
    pub(super) fn around(pictures: &[&Picture], air: usize) -> Option<Self> {
        let first = pictures.first()?;
        let (width, height) = (
            first.silhouette.width as usize,
            first.silhouette.height as usize,
        );
        let touches = |at: usize| pictures.iter().any(|p| p.touched[at]);
        let row = |&y: &usize| (0..width).any(|x| touches(y * width + x));
        let (y0, y1) = ((0..height).find(row)?, (0..height).rev().find(row)?);
        let column = |&x: &usize| (y0..=y1).any(|y| touches(y * width + x));
        let (x0, x1) = ((0..width).find(column)?, (0..width).rev().find(column)?);
        Some(Self {
            x0: x0.saturating_sub(air),
            y0: y0.saturating_sub(air),
            x1: (x1 + 1 + air).min(width),
            y1: (y1 + 1 + air).min(height),
        })
    }

    /// That part of rows of `width` texels.
    pub(super) fn of<P: Copy>(self, texels: &[P], width: u32) -> Vec<P> {
        (self.y0..self.y1)
            .flat_map(|y| {
                let row = y * width as usize;
                texels[row + self.x0..row + self.x1].iter().copied()
            })
            .collect()
    }

    /// That part of an image.
    pub(super) fn image<P: Copy>(self, image: &Image<P>) -> Image<P> {
        let edge = |low: usize, high: usize| u32::try_from(high - low).unwrap_or(0);
        Image::from_texels(
            edge(self.x0, self.x1),
            edge(self.y0, self.y1),
            self.of(image.texels(), image.width()),
        )
    }
}

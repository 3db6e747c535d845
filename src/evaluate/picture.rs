//! Pictures of a mesh under the evaluation's one light: what an eye, and FLIP, compare.
//!
//! A sun and a sky as in [`crate::preview`], shade from the full tree's density for every model alike, a
//! plain mid-grey behind. A model that lost its leaves is not lit more brightly for it.

use crate::asset::Surface;
use crate::capture::{ALPHA_CUTOFF, Occlusion, Seen, Textures, View, Visibility};
use crate::image::{Image, Texel, mips};
use crate::math::{Vec2, Vec3, float, srgb_from_linear};
use crate::measure::silhouette::Silhouette;
use crate::mesh::Mesh;
use crate::mesh::card::Relief;

/// Linear light of the sun.
const SUN: Vec3 = Vec3::new(3.1, 2.9, 2.55);

/// Linear light from above.
const SKY: Vec3 = Vec3::new(0.62, 0.74, 0.95);

/// Linear light from below.
const GROUND: Vec3 = Vec3::new(0.26, 0.24, 0.19);

/// Toward the sun: from the front right as the first views see it, from behind for others.
const TOWARD_SUN: Vec3 = Vec3::new(0.75, 1.0, 0.45);

/// Mid-grey, linear, as it is seen: neither a light nor a dark crown vanishes before it.
pub(super) const BACKGROUND: f32 = 0.184;

/// Cells of the grid that shades the crown, along its longest edge.
const SHADE_CELLS: u32 = 40;

/// Mips of the foliage atlas: its gutters stand four halvings.
const FOLIAGE_MIPS: usize = 5;

/// Mips of the bark, which repeats.
const BARK_MIPS: usize = 10;

/// Textures of a model, ready to be fetched.
pub(super) struct Skin {
    bark: Vec<Image<Texel>>,
    pub(super) foliage: Vec<Image<Texel>>,
    reliefs: Vec<Relief>,
}

impl Skin {
    pub(super) fn of(foliage: &Surface, bark: &Surface, reliefs: &[Relief]) -> Self {
        // Packs hold no alpha of the bark, so none may count.
        let mut opaque = bark.texels();
        opaque.texels_mut().iter_mut().for_each(|t| t.alpha = 1.0);
        Self {
            bark: mips::chain(opaque, BARK_MIPS, ALPHA_CUTOFF),
            foliage: mips::chain(foliage.texels(), FOLIAGE_MIPS, ALPHA_CUTOFF),
            reliefs: reliefs.to_vec(),
        }
    }

    fn textures(&self) -> Textures<'_> {
        Textures {
            bark: &self.bark,
            foliage: &self.foliage,
            reliefs: &self.reliefs,
        }
    }
}

/// What falls on every model.
pub(super) struct Light {
    shade: Occlusion,
    sun: Vec3,
}

impl Light {
    /// Shade as the full tree casts it on itself.
    pub(super) fn of(full: &Mesh) -> Self {
        let mut shade = Occlusion::of(full);
        shade.refine(full, SHADE_CELLS);
        Self {
            shade,
            sun: TOWARD_SUN.normalize_or(Vec3::Y),
        }
    }

    fn on(&self, seen: &Seen, point: Vec3, view: &View) -> Vec3 {
        let texel = &seen.texel;
        let [x, y, z] = texel.normal;
        let normal = view.right * x + view.up * y + view.toward() * z;
        let facing = normal.dot(self.sun);
        // A capture knows how much sky its parts see; single leaves and branches do not.
        let open = if seen.captured {
            1.0
        } else {
            self.shade.open(point)
        };
        let sun = self.shade.transmittance(point, self.sun);
        let lit = facing.max(0.0) + texel.translucency * (-facing).max(0.0);
        let sky = normal.y * 0.5 + 0.5;
        let ambient = (SKY * sky + GROUND * (1.0 - sky)) * (texel.occlusion * open);
        Vec3::from(texel.albedo) * (SUN * (sun * lit) + ambient)
    }
}

/// One model from one view.
pub(super) struct Picture {
    /// sRGB.
    pub(super) colour: Image<[u8; 3]>,
    /// Covered where at least half of the samples are.
    pub(super) silhouette: Silhouette,
    /// True where any sample is covered: where the colour is not the background's alone.
    pub(super) touched: Vec<bool>,
    /// Unit normals in view axes, means of the samples; zero where nothing is.
    pub(super) normals: Vec<Vec3>,
}

impl Picture {
    /// Draws a mesh with `n` by `n` samples in each pixel of `view`.
    pub(super) fn draw(mesh: &Mesh, skin: &Skin, light: &Light, view: &View, n: u32) -> Self {
        let samples = View {
            width: view.width * n,
            height: view.height * n,
            ..*view
        };
        let textures = skin.textures();
        let seen = Visibility::draw(mesh, textures, &samples);
        let count = view.width as usize * view.height as usize;
        let mut picture = Self {
            colour: Image::filled(view.width, view.height, [srgb_from_linear(BACKGROUND); 3]),
            silhouette: Silhouette::empty(view),
            touched: vec![false; count],
            normals: vec![Vec3::ZERO; count],
        };
        for (y, x) in (0..view.height).flat_map(|y| (0..view.width).map(move |x| (y, x))) {
            let mut pixel = Pixel::default();
            for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j))) {
                if let Some(seen) = seen.surface(i, j, mesh, textures, &samples) {
                    let at = Vec2::new(float(i) + 0.5, float(j) + 0.5);
                    let point = samples.unproject(at, seen.texel.depth);
                    pixel.covered += 1;
                    pixel.normal += Vec3::from(seen.texel.normal);
                    pixel.light += tone_mapped(light.on(&seen, point, &samples));
                }
            }
            if pixel.covered > 0 {
                picture.set(y as usize * view.width as usize + x as usize, &pixel, n * n);
            }
        }
        picture
    }

    fn set(&mut self, at: usize, pixel: &Pixel, samples: u32) {
        let empty = float(samples - pixel.covered) * BACKGROUND;
        let light = (pixel.light + empty) / float(samples);
        self.colour.texels_mut()[at] = light.to_array().map(srgb_from_linear);
        self.silhouette.covered[at] = 2 * pixel.covered >= samples;
        self.touched[at] = true;
        self.normals[at] = pixel.normal.normalize_or(Vec3::Z);
    }
}

/// Sums over the samples of one pixel.
#[derive(Default)]
struct Pixel {
    covered: u32,
    light: Vec3,
    normal: Vec3,
}

/// A soft shoulder, the same as the preview's.
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
            first.colour.width() as usize,
            first.colour.height() as usize,
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

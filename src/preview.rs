//! Pictures of a tree, drawn by the CPU rasteriser: a pack's preview and LOD strips.
//!
//! Orthographic, one sun, sky light dimmed by a density grid of the crown, a ground that receives the nine
//! baked shadows. Meant to show the shapes and textures honestly, not to be a renderer.
//!
//! The curve of tones: Narkowicz, *ACES Filmic Tone Mapping Curve*, 2016.

pub mod closeups;
pub mod sheets;

use crate::asset::Drawable;
use crate::capture::{ALPHA_CUTOFF, Foliage, Occlusion, Seen, Textures, View, Visibility};
use crate::image::{Image, Texel, mips};
use crate::math::{Bounds, Vec2, Vec3, float, lerp, smoothstep, srgb_from_linear};
use crate::report::{Cancelled, Progress};
use crate::shadow;
use rayon::prelude::*;

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Which LOD; the coarsest if there are not so many.
    pub lod: usize,
    /// Turn of the camera about the tree, radians; 0 looks along -Z.
    pub azimuth: f32,
    /// Height of the camera above the horizon, radians.
    pub elevation: f32,
    /// Vector toward the sun.
    pub sun: Vec3,
    /// Samples along each edge of a pixel.
    pub supersample: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [512, 640],
            lod: 0,
            azimuth: 0.6,
            elevation: 0.16,
            sun: Vec3::new(0.75, 1.0, 0.45),
            supersample: 2,
        }
    }
}

/// Linear colours of the set.
const SUN: Vec3 = Vec3::new(3.1, 2.9, 2.55);
const SKY: Vec3 = Vec3::new(0.62, 0.74, 0.95);
const GROUND_LIGHT: Vec3 = Vec3::new(0.26, 0.24, 0.19);
const GROUND: Vec3 = Vec3::new(0.33, 0.31, 0.26);
const BACKDROP: [Vec3; 2] = [Vec3::new(0.52, 0.60, 0.68), Vec3::new(0.80, 0.81, 0.79)];

/// Cells of the grid that shades the crown from the sun.
const SHADE_CELLS: u32 = 40;

/// One picture of one LOD, framed around the tree's bounds.
#[must_use]
pub fn picture(tree: &Drawable<'_>, settings: &Settings) -> Image<[u8; 3]> {
    let stage = Stage::new(tree, settings);
    stage.draw(&framed(tree, settings), settings.lod)
}

/// A picture of each LOD under the same camera, the finest first, whichever `settings` names.
///
/// # Errors
/// If `progress` was cancelled.
pub fn pictures(
    tree: &Drawable<'_>,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Vec<Image<[u8; 3]>>, Cancelled> {
    progress.begin("pictures", tree.lods.len() as u64);
    let stage = Stage::new(tree, settings);
    let view = framed(tree, settings);
    let drawn = (0..tree.lods.len()).map(|lod| {
        if progress.cancelled() {
            return Err(Cancelled);
        }
        let picture = stage.draw(&view, lod);
        progress.step();
        Ok(picture)
    });
    drawn.collect()
}

/// The samples of such a picture: a camera framed around the finest LOD as it is seen.
#[must_use]
pub fn framed(tree: &Drawable<'_>, settings: &Settings) -> View {
    let Settings {
        size: [width, height],
        azimuth,
        elevation,
        supersample,
        ..
    } = *settings;
    let (sine, cosine) = libm::sincosf(azimuth);
    let (lift, level) = libm::sincosf(elevation);
    let right = Vec3::new(cosine, 0.0, -sine);
    let toward = Vec3::new(sine * level, lift, cosine * level);
    let up = toward.cross(right);
    let mesh = tree.lods[0].0;
    let points = mesh
        .bark
        .vertices
        .iter()
        .chain(&mesh.foliage.vertices)
        .map(|v| Vec3::from(v.position));
    let seen = Bounds::of_points(points.map(|p| Vec3::new(p.dot(right), p.dot(up), p.dot(toward))));
    let (middle, size) = (seen.centre(), seen.size());
    let aspect = float(width) / float(height);
    // A little air around the tree.
    let half_height = (size.y * 0.53).max(size.x * 0.53 / aspect);
    View {
        centre: right * middle.x + up * middle.y + toward * middle.z,
        right,
        up,
        half: [half_height * aspect, half_height],
        width: width * supersample,
        height: height * supersample,
    }
}

/// All LODs side by side under the same camera, the finest on the left.
#[must_use]
pub fn strip(tree: &Drawable<'_>, settings: &Settings) -> Image<[u8; 3]> {
    let pictures: Vec<Image<[u8; 3]>> = (0..tree.lods.len())
        .map(|lod| picture(tree, &Settings { lod, ..*settings }))
        .collect();
    side_by_side(&pictures)
}

/// Joins pictures of one height into one.
#[must_use]
pub fn side_by_side(pictures: &[Image<[u8; 3]>]) -> Image<[u8; 3]> {
    let height = pictures.iter().map(Image::height).min().unwrap_or(0);
    let width = pictures.iter().map(Image::width).sum();
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for picture in pictures {
            let row = y as usize * picture.width() as usize;
            texels.extend_from_slice(&picture.texels()[row..row + picture.width() as usize]);
        }
    }
    Image::from_texels(width, height, texels)
}

/// What all pixels of a picture need.
struct Stage<'a> {
    tree: &'a Drawable<'a>,
    settings: &'a Settings,
    foliage: Foliage,
    bark: Vec<Image<Texel>>,
    shade: Occlusion,
    /// Part of the sun that reaches each cell of it.
    sunlit: Vec<f32>,
    sun: Vec3,
    shadow_weights: [(usize, f32); 3],
}

impl<'a> Stage<'a> {
    fn new(tree: &'a Drawable<'a>, settings: &'a Settings) -> Self {
        // The finest LOD shades all of them, so that a strip compares shapes and not light.
        let mut shade = Occlusion::of(tree.lods[0].0);
        shade.refine(tree.lods[0].0, SHADE_CELLS);
        let sun = settings.sun.normalize_or(Vec3::Y);
        Self {
            tree,
            settings,
            foliage: Foliage::of(tree.foliage.texels(), 5),
            bark: mips::chain(tree.bark.texels(), 10, ALPHA_CUTOFF),
            sunlit: shade.lit_from(sun),
            shade,
            sun,
            shadow_weights: shadow::weights(sun),
        }
    }

    fn draw(&self, view: &View, lod: usize) -> Image<[u8; 3]> {
        let mesh = self.tree.lods[lod.min(self.tree.lods.len() - 1)].0;
        debug_assert!(!mesh.bounds().is_empty(), "a LOD draws something");
        let textures = Textures {
            bark: &self.bark,
            foliage: &self.foliage,
            reliefs: self.tree.reliefs,
        };
        let seen = Visibility::draw(mesh, textures, view);
        let n = self.settings.supersample;
        let [width, height] = self.settings.size;
        let pixel = |x: u32, y: u32| {
            let mut sum = Vec3::ZERO;
            for (sx, sy) in (0..n).flat_map(|j| (0..n).map(move |i| (x * n + i, y * n + j))) {
                let sample = Vec2::new(float(sx) + 0.5, float(sy) + 0.5);
                let light = match seen.surface(sx, sy, mesh, textures, view) {
                    Some(seen) => self.lit(&seen, view.unproject(sample, seen.texel.depth), view),
                    None => self.backdrop(sample, view),
                };
                sum += tone_mapped(light);
            }
            (sum / float(n * n)).to_array().map(srgb_from_linear)
        };
        let row = |y: u32| (0..width).map(move |x| pixel(x, y));
        Image::from_texels(
            width,
            height,
            (0..height).into_par_iter().flat_map_iter(row).collect(),
        )
    }

    fn lit(&self, seen: &Seen, point: Vec3, view: &View) -> Vec3 {
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
        let sun = self.shade.between(&self.sunlit, point);
        let front = facing.max(0.0);
        let through = texel.translucency * (-facing).max(0.0);
        let sky = lerp(0.0, 1.0, normal.y * 0.5 + 0.5);
        let ambient = (SKY * sky + GROUND_LIGHT * (1.0 - sky)) * texel.occlusion * open;
        Vec3::from(texel.albedo) * (SUN * sun * (front + through) + ambient)
    }

    /// The ground, fading into a plain backdrop away from the tree.
    fn backdrop(&self, sample: Vec2, view: &View) -> Vec3 {
        let at = view.unproject(sample, 0.0);
        let toward = view.toward();
        let backdrop = BACKDROP[0].lerp(BACKDROP[1], sample.y / float(view.height));
        let down = at.y / toward.y.max(1e-3);
        let ground = at - toward * down;
        let reach = view.half[0].max(view.half[1]);
        let away = libm::hypotf(ground.x, ground.z);
        let near = 1.0 - smoothstep(0.35 * reach, 1.7 * reach, away);
        let shadow: f32 = self
            .shadow_weights
            .iter()
            .map(|&(map, weight)| weight * self.shadow_at(map, ground))
            .sum();
        let lit = GROUND * (SUN * self.sun.y * (1.0 - shadow) + SKY * (1.0 - 0.4 * shadow));
        backdrop.lerp(lit, near)
    }

    /// One baked shadow at a point of the ground, 0..=1, between texels.
    fn shadow_at(&self, map: usize, ground: Vec3) -> f32 {
        // A sketch has none.
        let Some(map) = self.tree.shadows.maps.get(map) else {
            return 0.0;
        };
        let [x0, z0, x1, z1] = map.ground_rect_m;
        let (width, height) = (map.image.width(), map.image.height());
        let u = (ground.x - x0) / (x1 - x0) * float(width) - 0.5;
        let v = (ground.z - z0) / (z1 - z0) * float(height) - 0.5;
        let texel = |x: f32, y: f32| {
            // The first row is empty by contract, and holds the code of the trunk base.
            if x < 0.0 || y < 1.0 || x >= float(width) || y >= float(height) {
                return 0.0;
            }
            let at = map
                .image
                .at(crate::math::floor_to_u32(x), crate::math::floor_to_u32(y));
            f32::from(*at) / 255.0
        };
        let (x, y) = (u.floor(), v.floor());
        let top = lerp(texel(x, y), texel(x + 1.0, y), u - x);
        let bottom = lerp(texel(x, y + 1.0), texel(x + 1.0, y + 1.0), u - x);
        lerp(top, bottom, v - y)
    }
}

/// A film's curve, with a toe: without one, shade is lifted and greens turn pale. A fit of the ACES
/// reference transform, a little greyer, since it saturates by channel.
fn tone_mapped(light: Vec3) -> Vec3 {
    /// Part of the colour that stays beside grey.
    const COLOUR: f32 = 0.86;
    let grey = Vec3::splat(light.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    let x = grey.lerp(light, COLOUR);
    ((x * (x * 2.51 + 0.03)) / (x * (x * 2.43 + 0.59) + 0.14)).min(Vec3::ONE)
}

//! Tone: every LOD in the mean as light and as coloured as full detail.
//!
//! A capture knows how dark it is inside of the sub-tree that it shows, but not how much shade the rest of the
//! crown adds; and one normal a texel is lit unlike the many leaves that it stands for. So the finished LODs are
//! laid over full detail from the calibration views, under a plain day with the sun from another side in
//! each, and for each capture two things are measured where it is seen: the light from all around that
//! reaches full detail there, and the light that full detail sends back. The first becomes a factor on the
//! capture's occlusion, the second one on its albedo.
//!
//! Leaves and bark that stay geometry get the mean occlusion of the crown in their textures, so that a
//! viewer that knows nothing of the tree sees no step between geometry and captures.

use crate::asset::{AssetLod, Tone};
use crate::capture::{Foliage, Occlusion, Textures, View, Visibility};
use crate::image::atlas::Rect;
use crate::image::{Image, Texel};
use crate::impostor::cross_quad::CrossQuads;
use crate::math::{TAU, Vec2, Vec3, float, lerp};
use crate::measure::silhouette::seen_bounds;
use crate::measure::views::{Direction, calibration};
use crate::mesh::Mesh;
use crate::mesh::card::{Relief, UvRect};
use rayon::prelude::*;

/// Samples along the height of the tree, by view: about where most LODs of a chain are seen. More than one size,
/// since a card is lit otherwise in each of its mips, by up to a twentieth.
const SAMPLES: [f32; 3] = [208.0, 160.0, 112.0];

/// Mips that the samples need.
const MIPS: usize = 5;

/// Cells of the grid that shades the crown from the sun, along its longest edge.
const SHADE_CELLS: u32 = 40;

/// Linear light of a plain day.
const SUN: Vec3 = Vec3::new(3.0, 2.85, 2.6);
const SKY: Vec3 = Vec3::new(0.65, 0.75, 0.92);
const GROUND: Vec3 = Vec3::new(0.26, 0.24, 0.2);

/// Height of the sun, radians.
const SUN_HEIGHT: f32 = 0.8;

/// Turn of the first sun from the first viewer and from one view to the next, radians: the golden angle, so
/// that few views see it from all sides.
const SUN_TURNS: [f32; 2] = [0.9, 2.399_963_2];

/// Suns around each view, each with its part of the light.
const SUNS: usize = 3;
const SUN_SHARE: f32 = 3.0;

/// Rounds over all LODs in which the tints are made to agree.
const ROUNDS: usize = 40;

/// Bounds of the factors on albedo. Beyond them a capture is not what it stands for, and no tint would help.
const TINTS: [f32; 2] = [0.75, 1.3];

/// Bounds of the factors on occlusion.
const SHADES: [f32; 2] = [0.2, 1.5];

/// A capture that is seen in fewer samples keeps its colour.
const FEWEST: f32 = 100.0;

/// Tones of all captures, and what becomes of the rest.
pub(super) struct Tones {
    /// Captures that show the same sub-tree, by their places in the atlas.
    groups: Vec<(Vec<UvRect>, Tone)>,
    /// Factor on the occlusion of leaves and bark.
    geometry: f32,
}

/// Sums over samples in which a capture and full detail are both seen.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f32,
    /// Occlusion of the capture, and of full detail.
    open: [f32; 2],
    /// The capture's light from all around and from the sun.
    light: [Vec3; 2],
    /// Full detail's light.
    full: Vec3,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        for side in 0..2 {
            self.open[side] += other.open[side];
            self.light[side] += other.light[side];
        }
        self.full += other.full;
    }

    /// None if it is hardly seen.
    fn tone(&self) -> Option<Tone> {
        if self.count < FEWEST {
            return None;
        }
        let [low, high] = SHADES;
        let shade = (self.open[1] / self.open[0].max(1e-6)).clamp(low, high);
        let light = self.light[0] * shade + self.light[1];
        let [low, high] = TINTS;
        let tint =
            (self.full / light.max(Vec3::splat(1e-6))).clamp(Vec3::splat(low), Vec3::splat(high));
        Some(Tone {
            shade,
            tint: tint.to_array(),
        })
    }
}

/// What a sample of full detail or of a LOD is like.
struct Sample {
    open: f32,
    /// Light from all around and from the sun.
    light: [Vec3; 2],
    relief: Option<usize>,
}

/// The light of one view.
struct Day<'a> {
    shade: &'a Occlusion,
    mean_open: f32,
    view: View,
    suns: [Vec3; SUNS],
}

impl Day<'_> {
    fn sample(&self, mesh: &Mesh, textures: Textures<'_>) -> Vec<Option<Sample>> {
        let seen = Visibility::draw(mesh, textures, &self.view);
        let [width, height] = [self.view.width, self.view.height];
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let sample = |(x, y)| {
            let seen = seen.surface(x, y, mesh, textures, &self.view)?;
            let texel = &seen.texel;
            let at = Vec2::new(float(x) + 0.5, float(y) + 0.5);
            let point = self.view.unproject(at, texel.depth);
            let [nx, ny, nz] = texel.normal;
            let normal = self.view.right * nx + self.view.up * ny + self.view.toward() * nz;
            let lit = |&sun: &Vec3| {
                let facing = normal.dot(sun);
                let lit = facing.max(0.0) + texel.translucency * (-facing).max(0.0);
                lit * self.shade.transmittance(point, sun)
            };
            let around = if seen.captured {
                1.0
            } else {
                self.shade.open(point) * self.mean_open
            };
            let open = texel.occlusion * around;
            let albedo = Vec3::from(texel.albedo);
            let ambient = GROUND.lerp(SKY, lerp(0.5, 1.0, normal.y));
            let sun = self.suns.iter().map(lit).sum::<f32>() / SUN_SHARE;
            Some(Sample {
                open,
                light: [albedo * ambient * open, albedo * SUN * sun],
                relief: seen.relief,
            })
        };
        places.map(sample).collect()
    }
}

/// Measures the tones of all captures that `lods` show against `full`.
pub(super) fn measure(
    full: &Mesh,
    lods: &[AssetLod],
    (atlas, bark): (&Image<Texel>, &[Image<Texel>]),
    quads: &CrossQuads,
) -> Tones {
    let groups = groups(quads);
    let reliefs = quads.reliefs();
    let group_of: Vec<usize> = reliefs.iter().map(|r| group(&groups, r)).collect();
    let mut shade = Occlusion::of(full);
    let mean_open = shade.mean_open();
    shade.refine(full, SHADE_CELLS);
    let foliage = Foliage::of(atlas.clone(), MIPS);
    let textures = Textures {
        bark,
        foliage: &foliage,
        reliefs: &reliefs,
    };
    let size = full.bounds().size();
    let of_view = |(index, direction): (usize, &Direction)| {
        let samples = SAMPLES[index % SAMPLES.len()];
        let edge = (size.y / samples)
            .max(size.max_element() / (4.0 * samples))
            .max(1e-6);
        let day = Day {
            shade: &shade,
            mean_open,
            view: direction.view(&seen_bounds(full, direction), edge),
            suns: suns(index, direction),
        };
        let reference = day.sample(full, textures);
        let compared = lods.iter().map(|lod| {
            let mut sums = vec![Sums::default(); groups.len() + 1];
            let samples = day.sample(&lod.mesh, textures);
            for (full, seen) in reference.iter().zip(&samples) {
                let (Some(full), Some(seen)) = (full, seen) else {
                    continue;
                };
                let group = seen.relief.map_or(groups.len(), |r| group_of[r]);
                sums[group].add(&Sums {
                    count: 1.0,
                    open: [seen.open, full.open],
                    light: seen.light,
                    full: full.light[0] + full.light[1],
                });
            }
            sums
        });
        compared.collect()
    };
    let views = calibration();
    let views: Vec<Vec<Vec<Sums>>> = views.par_iter().enumerate().map(of_view).collect();
    let mut sums = vec![vec![Sums::default(); groups.len() + 1]; lods.len()];
    for part in &views {
        for (sum, part) in sums.iter_mut().flatten().zip(part.iter().flatten()) {
            sum.add(part);
        }
    }
    let tones = agreed(&sums, groups.len());
    Tones {
        groups: groups.into_iter().zip(tones).collect(),
        geometry: mean_open,
    }
}

/// Tones of groups of captures: what each needs where it is seen, changed as little as makes every LOD as light
/// as full detail (Kaczmarz's method). `sums` are by LOD and group, the last group being geometry.
fn agreed(sums: &[Vec<Sums>], groups: usize) -> Vec<Tone> {
    let mut all = Sums::default();
    let mut of_group = vec![Sums::default(); groups];
    for lod in sums {
        for (sum, part) in of_group.iter_mut().zip(lod) {
            sum.add(part);
            all.add(part);
        }
    }
    // A capture that no LOD shows gets what the others get in the mean.
    let usual = Tone {
        shade: all.tone().map_or(1.0, |t| t.shade),
        tint: [1.0; 3],
    };
    let seen: Vec<Option<Tone>> = of_group.iter().map(Sums::tone).collect();
    let mut tones: Vec<Tone> = seen.iter().map(|t| t.unwrap_or(usual)).collect();
    let [low, high] = TINTS.map(Vec3::splat);
    for _ in 0..ROUNDS {
        for lod in sums {
            let lit = |g: usize| lod[g].light[0] * tones[g].shade + lod[g].light[1];
            let light: Vec<Vec3> = (0..groups).map(lit).collect();
            let mut missing = lod[groups].full - lod[groups].light[0] - lod[groups].light[1];
            let mut weight = Vec3::splat(1e-9);
            for (g, &light) in light.iter().enumerate() {
                missing += lod[g].full - light * Vec3::from(tones[g].tint);
                if seen[g].is_some() {
                    weight += light * light;
                }
            }
            for (g, &light) in light.iter().enumerate().filter(|(g, _)| seen[*g].is_some()) {
                let tint = Vec3::from(tones[g].tint) + missing * light / weight;
                tones[g].tint = tint.clamp(low, high).to_array();
            }
        }
    }
    tones
}

/// Toward the suns: never twice on the same side of the viewer.
fn suns(index: usize, direction: &Direction) -> [Vec3; SUNS] {
    let [first, step] = SUN_TURNS;
    let count = |n: usize| float(u32::try_from(n).unwrap_or(0));
    core::array::from_fn(|sun| {
        let turn = first + step * count(index) + TAU * count(sun) / SUN_SHARE;
        let (sine, cosine) = libm::sincosf(direction.azimuth + turn);
        let (lift, level) = libm::sincosf(SUN_HEIGHT);
        Vec3::new(sine * level, lift, cosine * level)
    })
}

/// Captures that show the same thing from several sides: one tint for them all, or quads that cross would part.
fn groups(quads: &CrossQuads) -> Vec<Vec<UvRect>> {
    let pairs = quads
        .combined
        .iter()
        .chain(&quads.branches)
        .flatten()
        .flatten();
    let pairs = pairs.map(|pair| pair.iter().map(|q| q.pane.uv).collect::<Vec<_>>());
    let sets = quads
        .sets
        .iter()
        .map(|set| set.iter().map(|q| q.pane.uv).collect());
    let mut groups: Vec<Vec<UvRect>> = Vec::new();
    for group in pairs.chain(sets) {
        // Levels whose branches have one shape share its captures.
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups
}

fn group(groups: &[Vec<UvRect>], relief: &Relief) -> usize {
    let found = groups.iter().position(|g| g.contains(&relief.uv));
    found.unwrap_or(0)
}

impl Tones {
    /// Gives all captures and leaves their tones.
    pub(super) fn apply(&self, atlas: &mut Image<Texel>, leaves: &[Rect]) {
        let size = float(atlas.width());
        for (places, tone) in &self.groups {
            for place in places {
                let texel = |part: f32| crate::math::floor_to_u32(part * size + 0.5);
                let columns = texel(place.u0)..texel(place.u1);
                for y in texel(place.v0)..texel(place.v1) {
                    for x in columns.clone() {
                        let texel = atlas.at_mut(x, y);
                        texel.occlusion = (texel.occlusion * tone.shade).min(1.0);
                        for (albedo, tint) in texel.albedo.iter_mut().zip(tone.tint) {
                            *albedo = (*albedo * tint).min(1.0);
                        }
                    }
                }
            }
        }
        for rect in leaves {
            for y in rect.y..rect.y + rect.height {
                for x in rect.x..rect.x + rect.width {
                    atlas.at_mut(x, y).occlusion *= self.geometry;
                }
            }
        }
    }

    /// Gives the bark its tone.
    pub(super) fn apply_to_bark(&self, bark: &Image<Texel>) -> Image<Texel> {
        bark.map(|texel| Texel {
            occlusion: texel.occlusion * self.geometry,
            ..*texel
        })
    }

    /// What was measured of each sub-tree that has captures.
    pub(super) fn tones(&self) -> Vec<Tone> {
        self.groups.iter().map(|(_, tone)| *tone).collect()
    }
}

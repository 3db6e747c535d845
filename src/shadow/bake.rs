//! The nine soft shadows: hard shadows of all samples, summed.

use crate::image::Image;
use crate::math::{Vec2, Vec3};
use crate::mesh::Mesh;
use crate::report::{Cancelled, Progress};
use crate::shadow::backend::{Backend, BakeError, Light, Work};
use crate::shadow::coverage::Coverage;
use crate::shadow::cpu;
use crate::shadow::directions::{COUNT, Sample, band_step, direction, samples};
use crate::shadow::ground::{Casters, Ground};
use crate::shadow::{Settings, ShadowMap, Shadows};

/// Sum of a texel in the shadow of all samples: 256 steps a byte, and no overflow of 16 bits.
const FULL: u16 = 255 * 256;

/// Casts the soft shadows of a mesh on the ground from all nine lights, drawn by the processor.
///
/// Bark is solid. Foliage casts where `alpha`, the foliage atlas's coverage (uv 0..=1, v down,
/// nearest texel beyond), is at least `cutoff`. An empty mesh has maps all lit. The same bytes at
/// any number of threads.
///
/// # Errors
/// [`Cancelled`] if `progress` said so before the last sample.
pub fn bake(
    mesh: &Mesh,
    alpha: &Image<u8>,
    cutoff: u8,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Shadows, Cancelled> {
    with_sums(mesh, (alpha, cutoff), settings, progress, |work| {
        cpu::sums(work, progress)
    })
}

/// The same, drawn by a backend.
///
/// # Errors
/// If `progress` cancels, or the backend's machine fails.
pub fn bake_with(
    backend: &dyn Backend,
    mesh: &Mesh,
    (alpha, cutoff): (&Image<u8>, u8),
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Shadows, BakeError> {
    with_sums(mesh, (alpha, cutoff), settings, progress, |work| {
        backend.sums(work, progress)
    })
}

fn with_sums<E>(
    mesh: &Mesh,
    (alpha, cutoff): (&Image<u8>, u8),
    settings: &Settings,
    progress: &dyn Progress,
    sums: impl FnOnce(&Work<'_>) -> Result<Vec<Vec<u16>>, E>,
) -> Result<Shadows, E> {
    let settings = settings.clamped();
    let coverage = Coverage::new(alpha, cutoff);
    let casters = Casters::new(mesh, &coverage);
    let a_map = 1 + u64::from(settings.bands) * u64::from(settings.samples);
    progress.begin("shadows", COUNT as u64 * a_map);
    let places: Vec<Place> = (0..COUNT)
        .map(|index| Place::new(&casters, direction(index), &settings))
        .collect();
    let lights: Vec<Light> = places.iter().map(Place::light).collect();
    let sums = sums(&Work {
        casters: &casters,
        coverage: &coverage,
        lights: &lights,
        size: settings.size,
    })?;
    let maps = places.iter().zip(sums);
    Ok(Shadows {
        maps: maps.map(|(place, sums)| place.map(&sums)).collect(),
    })
}

/// Where one light's shadow lies.
struct Place {
    to_light: Vec3,
    samples: Vec<Sample>,
    ground: Ground,
    /// Angle between bands, radians.
    step: f32,
    size: u32,
}

impl Place {
    fn new(casters: &Casters, to_light: Vec3, settings: &Settings) -> Self {
        let samples = samples(to_light, settings);
        let size = settings.size;
        let step = band_step(settings);
        Self {
            to_light,
            ground: Ground::around(casters, &samples, step, size),
            step,
            samples,
            size,
        }
    }

    fn light(&self) -> Light {
        let shifts = shifts(&self.samples);
        let pairs = self.samples.iter().zip(shifts);
        Light {
            samples: pairs
                .map(|(sample, shift)| self.ground.projection(sample, shift))
                .collect(),
            shares: shares(&self.samples),
            stray: self.ground.stray(&self.samples[0], self.step),
        }
    }

    fn map(&self, sums: &[u16]) -> ShadowMap {
        let soft;
        let sums = if self.samples.len() > 1 && self.size >= FILTERED_FROM {
            soft = smoothed(sums, self.size as usize);
            &soft
        } else {
            sums
        };
        let bytes = sums.iter().map(|sum| ((sum + 128) >> 8).to_le_bytes()[0]);
        let mut image = Image::from_texels(self.size, self.size, bytes.collect());
        let trunk_base = self.ground.trunk_base;
        let code = trunk_base.iter().flat_map(|x| x.to_le_bytes());
        for (texel, byte) in image.texels_mut().iter_mut().zip(code) {
            *texel = byte;
        }
        ShadowMap {
            direction: self.to_light,
            image,
            ground_rect_m: self.ground.rect_m(),
            trunk_base,
        }
    }
}

/// Maps of this many texels along an edge are filtered; on smaller ones two texels are too much.
pub(super) const FILTERED_FROM: u32 = 128;

/// A soft map with its grain taken off: few samples of many small leaves leave a grain of single texels,
/// which a binomial filter two texels wide removes at a cost in sharpness far below the penumbra's.
fn smoothed(sums: &[u16], size: usize) -> Vec<u16> {
    let rows = filtered(sums, size, 1);
    filtered(&rows, size, size)
}

/// One direction of the filter; neighbours are `step` apart. The border is lit, so edges may clamp.
fn filtered(sums: &[u16], size: usize, step: usize) -> Vec<u16> {
    const WEIGHTS: [u32; 5] = [1, 4, 6, 4, 1];
    let at = |place: usize, tap: usize| {
        let along = if step == 1 {
            place % size
        } else {
            place / size
        };
        let to = (along + tap).saturating_sub(2).min(size - 1);
        u32::from(sums[place - along * step + to * step])
    };
    let mean = |place: usize| {
        let sum: u32 = WEIGHTS
            .iter()
            .enumerate()
            .map(|(tap, w)| w * at(place, tap))
            .sum();
        u16::try_from((sum + 8) / 16).unwrap_or(u16::MAX)
    };
    (0..sums.len()).map(mean).collect()
}

/// The samples' weights as integers that sum to [`FULL`].
fn shares(samples: &[Sample]) -> Vec<u16> {
    let total: f64 = samples.iter().map(|s| f64::from(s.weight)).sum();
    let mut sum = 0.0;
    let mut given = 0;
    let share = |sample: &Sample| {
        sum += f64::from(sample.weight);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and FULL"
        )]
        let until = (sum / total * f64::from(FULL)).round() as u16;
        let share = until - given;
        given = until;
        share
    };
    samples.iter().map(share).collect()
}

/// Shifts of the samples' grids that fill a texel evenly (Roberts's R2 sequence), and whose
/// weighted mean is zero, so that the shadow stays in its place. Each is less than a texel.
fn shifts(samples: &[Sample]) -> Vec<Vec2> {
    const STEP: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);
    #[expect(clippy::cast_precision_loss, reason = "at most 64 * 256 samples")]
    let raw = (0..samples.len()).map(|i| (STEP * i as f32 + 0.5).fract() - 0.5);
    let raw: Vec<Vec2> = raw.collect();
    let pairs = raw.iter().zip(samples);
    let mean: Vec2 = pairs.map(|(&shift, sample)| shift * sample.weight).sum();
    raw.into_iter().map(|shift| shift - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::TAU;
    use crate::mesh::{Primitive, Vertex};
    use crate::report::Quiet;

    fn vertex(point: Vec3, uv: [f32; 2]) -> Vertex {
        Vertex {
            position: point.to_array(),
            normal: [0.0, 1.0, 0.0],
            tangent: [1.0, 0.0, 0.0, 1.0],
            uv,
            tint: crate::mesh::WHITE,
        }
    }

    fn card(primitive: &mut Primitive, centre: Vec3, across: Vec3, down: Vec3) {
        let first = u32::try_from(primitive.vertices.len()).unwrap();
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let point = centre + across * (u - 0.5) + down * (v - 0.5);
            primitive.vertices.push(vertex(point, [u, v]));
        }
        primitive
            .indices
            .extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }

    /// A level square of 1 m, at a height of 2 m above the point (1, 0).
    fn square() -> Mesh {
        let mut mesh = Mesh::default();
        card(
            &mut mesh.foliage,
            Vec3::new(1.0, 2.0, 0.0),
            Vec3::X,
            Vec3::Z,
        );
        mesh
    }

    /// A tapered post of 2 m with a ball of cards on top.
    fn little_tree() -> Mesh {
        let mut mesh = Mesh::default();
        for side in 0..6_u8 {
            let rim = |side: u8, radius: f32, height: f32| {
                let (sin, cos) = libm::sincosf(f32::from(side) * TAU / 6.0);
                vertex(Vec3::new(cos * radius, height, sin * radius), [0.0; 2])
            };
            let first = u32::try_from(mesh.bark.vertices.len()).unwrap();
            let foot = [rim(side, 0.15, 0.0), rim(side + 1, 0.15, 0.0)];
            mesh.bark.vertices.extend(foot);
            mesh.bark.vertices.push(rim(0, 0.0, 2.0));
            mesh.bark.indices.extend([0, 1, 2].map(|i| first + i));
        }
        for index in 0..300_u16 {
            let up = (f32::from(index) + 0.5) / 150.0 - 1.0;
            let (sin, cos) = libm::sincosf(f32::from(index) * 2.4);
            let out = (1.0 - up * up).sqrt();
            let normal = Vec3::new(cos * out, up, sin * out);
            let (across, down) = normal.any_orthonormal_pair();
            let centre = normal * 0.8 + Vec3::Y * 2.2;
            card(&mut mesh.foliage, centre, across * 0.2, down * 0.2);
        }
        mesh
    }

    fn opaque() -> Image<u8> {
        Image::filled(4, 4, 255)
    }

    fn baked(mesh: &Mesh, settings: &Settings) -> Shadows {
        bake(mesh, &opaque(), 128, settings, &Quiet).unwrap()
    }

    fn hard(size: u32) -> Settings {
        Settings {
            size,
            bands: 0,
            ..Settings::default()
        }
    }

    /// Area in shadow, square metres, and its middle on the ground.
    fn mass(map: &ShadowMap) -> (f32, Vec2) {
        let [x0, z0, x1, z1] = map.ground_rect_m;
        let size = map.image.width() as f32;
        let texel = Vec2::new(x1 - x0, z1 - z0) / size;
        let image = map.image_without_code();
        let mut total = 0.0;
        let mut moment = Vec2::ZERO;
        for y in 0..map.image.height() {
            for x in 0..map.image.width() {
                let share = f32::from(*image.at(x, y)) / 255.0;
                let place = Vec2::new(x0, z0) + Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * texel;
                total += share;
                moment += place * share;
            }
        }
        (total * texel.x * texel.y, moment / total)
    }

    #[test]
    fn a_level_square_casts_itself_under_the_zenith_and_is_shifted_away_from_a_low_light() {
        let shadows = baked(&square(), &hard(256));
        for (index, middle) in [(0, (1.0, 0.0)), (1, (-1.0, 0.0)), (3, (1.0, -2.0))] {
            let map = &shadows.maps[index];
            let [x0, z0, x1, z1] = map.ground_rect_m;
            let texel = Vec2::new(x1 - x0, z1 - z0) / 256.0;
            let image = map.image_without_code();
            for y in 0..256 {
                for x in 0..256 {
                    let place =
                        Vec2::new(x0, z0) + Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * texel;
                    let off = (place - Vec2::new(middle.0, middle.1)).abs() - 0.5;
                    // The texel on the outline may go either way.
                    if (off / texel).max_element().abs() > 0.6 || off.max_element() > 0.1 {
                        let shade = *image.at(x, y);
                        assert_eq!(shade == 255, off.max_element() < 0.0, "{index}: {place}");
                        assert!(shade == 0 || shade == 255);
                    }
                }
            }
        }
    }

    #[test]
    fn softness_moves_shadow_about_but_neither_adds_nor_takes_any() {
        for bands in [0, 1, 3] {
            let settings = Settings {
                bands,
                ..Settings::default()
            };
            let solid = Mesh {
                bark: square().foliage,
                foliage: Primitive::default(),
            };
            let solid = baked(&solid, &settings);
            for (map, solid) in baked(&square(), &settings).maps.iter().zip(&solid.maps) {
                let (area, strayed) = mass(map);
                assert!((area - 1.0).abs() < 0.02, "{bands} bands: {area} m2");
                let (area, middle) = mass(solid);
                assert!((area - 1.0).abs() < 0.02, "{bands} bands: {area} m2");
                // Strays come in opposite pairs, all but that of the middle sample.
                assert!(
                    (strayed - middle).length() < 0.14 / (bands + 1) as f32,
                    "{strayed} {middle}"
                );
                let to_light = map.direction;
                let expected =
                    Vec2::new(1.0, 0.0) - Vec2::new(to_light.x, to_light.z) * (2.0 / to_light.y);
                // A cone of light is cut by the ground a little off its axis.
                assert!(
                    (middle - expected).length() < 0.03,
                    "{bands} bands: {middle}"
                );
            }
        }
    }

    #[test]
    fn more_bands_make_a_smoother_edge() {
        let steepest = |bands: u32| {
            let settings = Settings {
                bands,
                samples: 16,
                ..Settings::default()
            };
            // Bark: it does not stray, so that its edge has one step a sample.
            let mesh = Mesh {
                bark: square().foliage,
                foliage: Primitive::default(),
            };
            let map = &baked(&mesh, &settings).maps[1];
            let image = map.image_without_code();
            let row: Vec<u8> = (0..256)
                .map(|x| *image.at(x, u32::from(map.trunk_base[1])))
                .collect();
            let steps = row.windows(2).map(|pair| pair[0].abs_diff(pair[1]));
            steps.max().unwrap_or(0)
        };
        let steps = [0, 1, 3].map(steepest);
        assert!(steps.windows(2).all(|pair| pair[1] < pair[0]), "{steps:?}");
        assert_eq!(steps[0], 255);
        assert!(steps[2] < 20, "{steps:?}");
    }

    #[test]
    fn one_thread_and_two_give_the_same_bytes() {
        let settings = Settings {
            size: 64,
            ..Settings::default()
        };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| baked(&little_tree(), &settings))
        };
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn an_empty_mesh_is_lit_everywhere() {
        for map in baked(&Mesh::default(), &Settings::default()).maps {
            assert_eq!((map.image.width(), map.image.height()), (256, 256));
            assert!(map.image_without_code().texels().iter().all(|&t| t == 0));
            let [x0, z0, x1, z1] = map.ground_rect_m;
            assert!(x0 < 0.0 && z0 < 0.0 && x1 > 0.0 && z1 > 0.0);
            assert!((0.9..1.2).contains(&(x1 - x0)));
        }
    }

    #[test]
    fn the_first_four_bytes_tell_the_texel_whose_centre_is_the_origin() {
        for map in baked(&little_tree(), &hard(300)).maps {
            let code = &map.image.texels()[..4];
            let told = [[code[0], code[1]], [code[2], code[3]]].map(u16::from_le_bytes);
            assert_eq!(told, map.trunk_base);
            let [x0, z0, x1, z1] = map.ground_rect_m;
            let texel = Vec2::new(x1 - x0, z1 - z0) / 300.0;
            let centre = Vec2::from(map.trunk_base.map(f32::from)) + 0.5;
            assert!((Vec2::new(x0, z0) + centre * texel).length() < 1e-5);
        }
    }

    #[test]
    fn the_trunk_joins_its_shadow_and_two_texels_around_are_lit() {
        for size in [16, 64, 257] {
            let settings = Settings {
                size,
                ..Settings::default()
            };
            for map in baked(&little_tree(), &settings).maps {
                let [x, y] = map.trunk_base.map(u32::from);
                if size > 16 {
                    let shade = *map.image.at(x, y);
                    assert!(shade > 200, "{}: {shade}", map.direction);
                }
                let image = map.image_without_code();
                let border = |i: u32| i < 2 || i >= size - 2;
                for (place, &shade) in (0..).zip(image.texels()) {
                    assert!(shade == 0 || !border(place % size) && !border(place / size));
                }
            }
        }
    }

    #[test]
    fn foliage_finer_than_a_texel_casts_its_mean_coverage() {
        // One texel in four is leaf, in a texture with far more texels than the shadow.
        let mut alpha = Image::filled(512, 512, 0);
        for place in 0..256 * 256 {
            *alpha.at_mut(place % 256 * 2, place / 256 * 2) = 255;
        }
        let mut mesh = Mesh::default();
        for place in 0..100_u8 {
            let (x, z) = (f32::from(place % 10) * 0.1, f32::from(place / 10) * 0.1);
            let centre = Vec3::new(x, 2.0, z);
            card(&mut mesh.foliage, centre, Vec3::X * 0.1, Vec3::Z * 0.1);
        }
        for bands in [0, 1, 3] {
            let settings = Settings {
                size: 64,
                bands,
                ..Settings::default()
            };
            let shadows = bake(&mesh, &alpha, 128, &settings, &Quiet).unwrap();
            for map in &shadows.maps {
                let (area, _) = mass(map);
                assert!((area - 0.25).abs() < 0.025, "{area}");
            }
        }
    }

    #[test]
    fn what_is_below_ground_or_broken_casts_nothing() {
        let mut mesh = Mesh::default();
        card(&mut mesh.bark, Vec3::new(0.0, -0.5, 0.0), Vec3::X, Vec3::Z);
        card(
            &mut mesh.foliage,
            Vec3::new(f32::NAN, 1.0, 0.0),
            Vec3::X,
            Vec3::Z,
        );
        mesh.bark.indices.extend([0, 1, 77]);
        let empty = baked(&Mesh::default(), &Settings::default());
        assert_eq!(baked(&mesh, &Settings::default()), empty);
    }

    #[test]
    fn wild_settings_are_taken_as_the_nearest_in_range() {
        let wild = Settings {
            size: 0,
            bands: 0,
            samples: 0,
            spread_deg: f32::NAN,
        };
        assert_eq!(baked(&square(), &wild), baked(&square(), &hard(16)));
    }

    #[test]
    fn cancelling_ends_the_work() {
        struct Never;
        impl Progress for Never {
            fn begin(&self, _stage: &'static str, _steps: u64) {}
            fn step(&self) {}
            fn cancelled(&self) -> bool {
                true
            }
        }
        let result = bake(&square(), &opaque(), 128, &Settings::default(), &Never);
        assert_eq!(result, Err(Cancelled));
    }

    #[test]
    fn the_atlas_holds_every_map_in_index_order() {
        let shadows = baked(&little_tree(), &hard(32));
        let (atlas, rects) = shadows.atlas();
        assert_eq!((atlas.width(), atlas.height()), (96, 96));
        for (map, rect) in shadows.maps.iter().zip(rects) {
            for y in 0..32 {
                for x in 0..32 {
                    assert_eq!(atlas.at(rect.x0 + x, rect.y0 + y), map.image.at(x, y));
                }
            }
        }
        assert_eq!((rects[4].x0, rects[4].y0, rects[5].x0), (32, 32, 64));
    }

    #[test]
    fn a_little_tree_lit_from_plus_x_throws_its_crown_toward_minus_x() {
        let settings = Settings {
            size: 32,
            ..Settings::default()
        };
        let map = &baked(&little_tree(), &settings).maps[1];
        let image = map.image_without_code();
        let ink = |shade: &u8| char::from(b" .:-=+*#%@"[usize::from(*shade) * 10 / 256]);
        let rows = image.texels().chunks(32);
        let drawn: Vec<String> = rows.map(|row| row.iter().map(ink).collect()).collect();
        let drawn = drawn
            .iter()
            .map(|row| row.trim_end())
            .collect::<Vec<_>>()
            .join("\n");
        assert_eq!(drawn.trim(), GOLDEN_TREE.trim(), "\n{drawn}");
    }

    const GOLDEN_TREE: &str = "
           ...:::.
          ..:-+++-.
         .:=+####*=.
         .:+#%@@%%*+.
        :=+%%@@@@@@#=.
        :**%@@@@@@@%*:
       .-+#%@@@@@@@@#-
       .-#%@@@@@@@@@%=.
       .=#%@@@@@@@@@%*---+##
       .=#%@@@@@@@@@%%%@@@@@:
       .=*%@@@@@@@@@@*=-=+#%
       .=*%@@@@@@@@@%=.
       .:+%@@@@@@@@@%-
       .:+#%@@@@@@@%+:
         =+%%@@@@@%#-.
        .:=+%%%%%%%+:
         .:=++*%#*+:
          .::--+=-.
            .:::..";
}

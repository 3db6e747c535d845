//! Bark as one tile that repeats around the stem and along it.
//!
//! Each pattern is a height field from periodic noise whose cells are sized in metres, so a taller
//! tile holds more ridges and not larger ones. Normal and occlusion follow from the height field at
//! its real depth; colour follows from height, grain and blotches. The top of the image is up the
//! stem. Cost: about 15 noise samples a texel, and two blurs of the height field.

use rand::Rng;
use rayon::prelude::*;

use super::noise::Periodic;
use super::texels_from_rows;
use crate::image::{Image, Texel};
use crate::math::{lerp, round_to_u32, smoothstep};
use crate::rng::{Key, Parameter};
use crate::species::schema::{BarkArt, BarkPattern};

/// Radii of the two occlusion blurs, metres: the furrow's own width, and the nearer surroundings.
const OCCLUSION_RADII_M: [f32; 2] = [0.006, 0.02];
/// Occlusion never falls below this: a furrow is open at its top.
const OCCLUSION_FLOOR: f32 = 0.35;
/// Steepest slope that a normal shows; steeper walls would alias into sparkle.
const STEEPEST: f32 = 2.2;

/// A seamless tile of bark, `size` by `size` texels; `height_m` high and wide in reality.
///
/// Texels are opaque (alpha 1) with translucency and depth 0. Any size is valid; 0 gives an empty
/// plane. Heights and depths that are not positive give flat bark.
#[must_use]
pub fn bark(art: &BarkArt, seed: u64, size: u32) -> Image<Texel> {
    let pattern = Pattern::new(art, seed);
    let texel_uv = 1.0 / size.max(1) as f32;
    let place = |x: u32, y: u32| {
        (
            (x as f32 + 0.5) * texel_uv,
            1.0 - (y as f32 + 0.5) * texel_uv,
        )
    };
    let relief = texels_from_rows(size, size, Relief::default(), |x, y| {
        let (u, v) = place(x, y);
        pattern.relief(u, v)
    });
    let height = Plane {
        size,
        values: relief.iter().map(|relief| relief.height).collect(),
    };
    let texel_m = art.height_m.max(1e-3) * texel_uv;
    let depth_m = art.depth_m.max(0.0);
    let blurs = OCCLUSION_RADII_M.map(|radius_m| height.blurred(round_to_u32(radius_m / texel_m)));
    let texels = texels_from_rows(size, size, Texel::EMPTY, |x, y| {
        let (u, v) = place(x, y);
        let index = height.index(x, y);
        let cavity: f32 = blurs
            .iter()
            .zip(OCCLUSION_RADII_M)
            .map(|(blur, radius_m)| {
                (blur.values[index] - height.values[index]).max(0.0) * depth_m / radius_m
            })
            .sum();
        let occlusion = (1.0 - 0.55 * cavity).max(OCCLUSION_FLOOR);
        Texel {
            albedo: pattern.colour(&relief[index], u, v),
            alpha: 1.0,
            normal: height.normal(x, y, depth_m / texel_m),
            occlusion,
            roughness: (pattern.roughness + 0.06 * (1.0 - occlusion)).min(1.0),
            translucency: 0.0,
            depth: 0.0,
        }
    });
    Image::from_texels(size, size, texels)
}

/// What a pattern says of one point.
#[derive(Clone, Copy, Default)]
struct Relief {
    /// 0 at the bottom of the deepest furrow ..= 1 on the highest ridge.
    height: f32,
    /// 0 the dark colour ..= 1 the light colour.
    tone: f32,
}

/// The noise fields of one bark.
struct Pattern<'a> {
    art: &'a BarkArt,
    /// Slow bends of everything, sideways and along.
    bend: [Periodic; 2],
    /// Quick wobbles of the bent pattern.
    wobble: [Periodic; 2],
    /// The main ridges or rings.
    main: Periodic,
    /// Smaller forms on them.
    minor: Periodic,
    /// Where something is stronger or weaker.
    mask: Periodic,
    /// Cracks.
    crack: Periodic,
    /// Grain of a few millimetres.
    grain: Periodic,
    /// Blotches of colour.
    blotch: Periodic,
    /// Rings in the tile.
    rings: f32,
    /// Height and width of one main cell, as parts of the tile.
    cell: [f32; 2],
    /// Roughness in the open.
    roughness: f32,
}

impl<'a> Pattern<'a> {
    fn new(art: &'a BarkArt, seed: u64) -> Self {
        let mut draws = Key::of_seed(seed).level("bark").stream(Parameter::Texture);
        // Cells of the given width and height in millimetres, a whole number of them in the tile.
        let mut field = |width_mm: f32, height_mm: f32| {
            let cells = |mm: f32| round_to_u32(art.height_m * 1000.0 / mm).clamp(2, 4096);
            Periodic::new(draws.next_u32(), [cells(width_mm), cells(height_mm)])
        };
        let (main_mm, minor_mm, crack_mm, roughness) = match art.pattern {
            BarkPattern::Ridged => ([50.0, 210.0], [12.0, 45.0], [34.0, 30.0], 0.9),
            BarkPattern::Gnarled => ([44.0, 95.0], [18.0, 30.0], [13.0, 22.0], 0.87),
            BarkPattern::Smooth => ([120.0, 90.0], [90.0, 7.0], [60.0, 30.0], 0.85),
            BarkPattern::Rings => ([160.0, 58.0], [45.0, 40.0], [13.0, 90.0], 0.88),
        };
        let mut pair = |width_mm: f32, height_mm: f32| {
            [field(width_mm, height_mm), field(width_mm, height_mm)]
        };
        let bend = pair(main_mm[0] * 2.2, main_mm[1] * 1.1);
        let wobble = pair(main_mm[0] * 0.5, main_mm[0] * 0.8);
        let main = field(main_mm[0], main_mm[1]);
        Self {
            art,
            bend,
            wobble,
            main,
            minor: field(minor_mm[0], minor_mm[1]),
            mask: field(90.0, 130.0),
            crack: field(crack_mm[0], crack_mm[1]),
            grain: field(5.0, 8.0),
            blotch: field(110.0, 90.0),
            rings: main.cells()[1] as f32,
            cell: main.cells().map(|cells| 1.0 / cells as f32),
            roughness,
        }
    }

    fn relief(&self, u: f32, v: f32) -> Relief {
        let relief = match self.art.pattern {
            BarkPattern::Ridged => self.ridged(u, v),
            BarkPattern::Gnarled => self.gnarled(u, v),
            BarkPattern::Smooth => self.smooth(u, v),
            BarkPattern::Rings => self.ringed(u, v),
        };
        Relief {
            height: relief.height.clamp(0.0, 1.0),
            tone: relief.tone.clamp(0.0, 1.0),
        }
    }

    /// (u, v) pushed about, in parts of a main cell: slowly `sideways` and `along`, and by quick
    /// wobbles.
    fn warped(&self, u: f32, v: f32, sideways: f32, along: f32, quick: f32) -> (f32, f32) {
        let x = sideways * self.bend[0].at(u, v) + quick * self.wobble[0].at(u, v);
        let y = along * self.bend[1].at(u, v) + 0.5 * quick * self.wobble[1].at(u, v);
        (u + self.cell[0] * x, v + self.cell[1] * y)
    }

    /// Long cells as ridges, the borders between them as furrows; where the mask closes a furrow
    /// two ridges join, which braids them into diamonds.
    fn ridged(&self, u: f32, v: f32) -> Relief {
        let (x, y) = self.warped(u, v, 0.8, 0.3, 0.22);
        let plate = self.main.cell(x, y);
        let mask = self.mask.fbm(u, v, 2);
        let fissure = self.minor.at(x, y);
        let width = lerp(0.2, 0.4, smoothstep(-0.5, 0.6, mask + 0.4 * fissure));
        let wall = smoothstep(0.01, width, plate.border + 0.05 * fissure);
        let closed = smoothstep(0.1, 0.55, -mask) * 0.7;
        let ridge = lerp(wall, 0.9, closed) * (0.85 + 0.15 * smoothstep(0.0, 0.5, plate.border));
        let cracked = smoothstep(-0.1, 0.5, mask + fissure * 0.5) * smoothstep(0.4, 0.9, ridge);
        let cut = if cracked > 0.0 {
            let crossing = self.crack.cell(x, v + 0.5 * self.cell[0] * mask);
            cracked * (1.0 - smoothstep(0.0, 0.14, crossing.border))
        } else {
            0.0
        };
        let grain = self.grain.fbm(u, v, 2);
        let height = 0.08 + 0.68 * ridge + 0.16 * fissure * (0.25 + ridge) - 0.16 * cut
            + 0.12 * (plate.id - 0.5) * wall
            + 0.09 * grain * (0.4 + 0.6 * ridge);
        Relief {
            height,
            tone: 0.08 + 0.85 * height + 0.1 * grain + 0.16 * (plate.id - 0.5) * wall,
        }
    }

    /// Rounded twisted ridges with soft furrows, partly broken into scales, with pits.
    fn gnarled(&self, u: f32, v: f32) -> Relief {
        let (x, y) = self.warped(u, v, 0.75, 0.35, 0.3);
        let knot = self.main.cell(x, y);
        let mask = self.mask.fbm(u, v, 2);
        let swell = self.minor.fbm(x, y, 2);
        let ridge = smoothstep(-0.05, 0.5, knot.border + 0.1 * swell);
        let scale = self.crack.cell(x + 0.1 * self.cell[0] * swell, y);
        let broken = smoothstep(-0.3, 0.35, mask + 0.5 * (knot.id - 0.5));
        let furrow = (1.0 - smoothstep(0.0, 0.22, scale.border)) * broken;
        let pit = (1.0 - smoothstep(0.05, 0.4, scale.centre)) * smoothstep(0.88, 0.93, scale.id);
        let grain = self.grain.fbm(u, v, 2);
        let height = 0.2 + 0.5 * ridge + 0.18 * swell - 0.17 * furrow - 0.3 * pit
            + 0.14 * (scale.id - 0.5) * broken * smoothstep(0.0, 0.25, scale.border)
            + 0.2 * (knot.id - 0.5) * smoothstep(0.0, 0.3, knot.border)
            + 0.12 * grain;
        Relief {
            height,
            tone: 0.2 + 0.78 * height + 0.16 * grain + 0.1 * mask - 0.1 * furrow - 0.1 * pit,
        }
    }

    /// Nearly flat: slow swellings, faint wrinkles across the stem, scattered lenticels, and
    /// patches of crust lichen with soft edges.
    fn smooth(&self, u: f32, v: f32) -> Relief {
        let (x, y) = self.warped(u, v, 0.25, 0.25, 0.05);
        let swell = self.main.fbm(x, y, 3);
        let mask = self.mask.fbm(u, v, 2);
        let grain = self.grain.fbm(u, v, 3);
        let wrinkle = self.minor.ridge(x, y) * smoothstep(-0.4, 0.5, mask);
        let spot = self.crack.cell(x, y);
        let lenticel = (1.0 - smoothstep(0.04, 0.16, spot.centre)) * smoothstep(0.6, 0.65, spot.id);
        let lichen = smoothstep(0.05, 0.3, swell + 0.25 * grain);
        let height = 0.45 + 0.2 * swell + 0.12 * wrinkle + 0.2 * lenticel + 0.14 * grain;
        let tone = 0.5 + 0.15 * mask + 0.25 * lichen + 0.2 * grain;
        Relief {
            height,
            tone: tone - 0.12 * wrinkle - 0.3 * lenticel,
        }
    }

    /// Rings of leaf scars: each rises to a ledge at its top, then falls into a groove; fine
    /// cracks along the stem, which the ledges interrupt.
    fn ringed(&self, u: f32, v: f32) -> Relief {
        let wave = 0.3 * self.bend[0].at(u, v) + 0.1 * self.wobble[0].at(u, v);
        // Unevenly spaced: the same shift all around, from a row of noise.
        let uneven = 0.42 * self.main.at(0.123, v);
        let along = v * self.rings + wave + uneven;
        let ring = along.floor();
        let way = along - ring;
        // By the ring's number within the tile, so that the shift too repeats.
        let shift = 0.618 * (ring - self.rings * (ring / self.rings).floor());
        let mask = self.mask.fbm(u, v, 2);
        let ledge = smoothstep(0.0, 0.16, way) * (1.0 - smoothstep(0.9, 1.0, way));
        let scar = smoothstep(0.62, 0.72, way) * (1.0 - smoothstep(0.9, 0.98, way));
        let up = v + shift;
        let split = self.crack.ridge(u, up);
        let open = smoothstep(-0.25, 0.4, self.minor.at(u, up) + 0.5 * mask);
        let crack = smoothstep(0.72, 0.98, split)
            * open
            * smoothstep(0.08, 0.2, way)
            * (1.0 - smoothstep(0.55, 0.75, way));
        let grain = self.grain.fbm(u, v, 2);
        let height = 0.28 + ledge * (0.2 + 0.24 * way) + 0.1 * scar - 0.22 * crack
            + 0.08 * mask
            + 0.1 * grain;
        Relief {
            height,
            tone: 0.26 + 0.3 * ledge + 0.14 * scar - 0.24 * crack + 0.26 * mask + 0.2 * grain,
        }
    }

    /// Colour by tone, with slow blotches (algae and weather: a little greener or browner).
    fn colour(&self, relief: &Relief, u: f32, v: f32) -> [f32; 3] {
        let blotch = self.blotch.fbm(u, v, 2);
        let value = 1.0 + 0.1 * blotch;
        let tint = [1.0 + 0.03 * blotch, 1.0, 1.0 - 0.04 * blotch];
        let mixed = |i: usize| lerp(self.art.dark[i], self.art.light[i], relief.tone);
        [0, 1, 2].map(|i| (mixed(i) * value * tint[i]).clamp(0.0, 1.0))
    }
}

/// A square plane of numbers that repeats in both directions.
struct Plane {
    size: u32,
    values: Vec<f32>,
}

impl Plane {
    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.size as usize + x as usize
    }

    /// Normal at a texel; `slope` is the real height of one unit over the width of one texel.
    fn normal(&self, x: u32, y: u32, slope: f32) -> [f32; 3] {
        let after = |at: u32| if at + 1 == self.size { 0 } else { at + 1 };
        let before = |at: u32| if at == 0 { self.size - 1 } else { at - 1 };
        let at = |x: u32, y: u32| self.values[self.index(x, y)];
        let dx = 0.5 * slope * (at(after(x), y) - at(before(x), y));
        // Rows run down, +Y runs up.
        let dy = 0.5 * slope * (at(x, before(y)) - at(x, after(y)));
        let steep = (dx * dx + dy * dy).sqrt();
        let ease = 1.0 / (1.0 + steep / STEEPEST);
        let (nx, ny) = (-dx * ease, -dy * ease);
        let length = (nx * nx + ny * ny + 1.0).sqrt();
        [nx / length, ny / length, 1.0 / length]
    }

    /// Mean over about `radius` texels around each; two box passes each way.
    fn blurred(&self, radius: u32) -> Self {
        let radius = radius.clamp(1, (self.size / 2).max(1));
        let mut plane = self.transposed_blur(radius);
        for _ in 0..3 {
            plane = plane.transposed_blur(radius);
        }
        plane
    }

    /// One box pass along the columns, written as rows: called an even number of times, the
    /// transpositions cancel.
    fn transposed_blur(&self, radius: u32) -> Self {
        let size = self.size as usize;
        let width = 2 * radius + 1;
        let scale = 1.0 / width as f32;
        let mut values = vec![0.0; self.values.len()];
        values
            .par_chunks_mut(size.max(1))
            .enumerate()
            .for_each(|(x, out)| {
                let at = |y: usize| self.values[y * size + x];
                let next = |y: usize| if y + 1 == size { 0 } else { y + 1 };
                let reach = radius as usize;
                let mut leaving = (size * 2 - reach) % size;
                let mut entering = leaving;
                let mut sum = 0.0;
                for _ in 0..width {
                    sum += at(entering);
                    entering = next(entering);
                }
                for value in out.iter_mut() {
                    *value = sum * scale;
                    sum += at(entering) - at(leaving);
                    entering = next(entering);
                    leaving = next(leaving);
                }
            });
        Self {
            size: self.size,
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATTERNS: [BarkPattern; 4] = [
        BarkPattern::Ridged,
        BarkPattern::Gnarled,
        BarkPattern::Smooth,
        BarkPattern::Rings,
    ];

    fn art(pattern: BarkPattern) -> BarkArt {
        BarkArt {
            pattern,
            light: [0.25, 0.22, 0.18],
            dark: [0.06, 0.045, 0.03],
            height_m: 0.5,
            depth_m: 0.01,
        }
    }

    /// Mean difference between each line of texels and the next, the last being the wrap.
    fn steps(tile: &Image<Texel>, across: bool) -> Vec<f32> {
        let size = tile.width();
        let at = |line: u32, i: u32| {
            *if across {
                tile.at(line, i)
            } else {
                tile.at(i, line)
            }
        };
        (0..size)
            .map(|line| {
                let difference: f32 = (0..size)
                    .map(|i| {
                        let (a, b) = (at(line, i), at((line + 1) % size, i));
                        (a.albedo[1] - b.albedo[1]).abs() * 4.0
                            + (a.normal[0] - b.normal[0]).abs()
                            + (a.normal[1] - b.normal[1]).abs()
                            + (a.occlusion - b.occlusion).abs()
                    })
                    .sum();
                difference / size as f32
            })
            .collect()
    }

    #[test]
    fn every_pattern_is_as_smooth_over_its_seams_as_inside() {
        for pattern in PATTERNS {
            let tile = bark(&art(pattern), 5, 96);
            for across in [true, false] {
                let mut steps = steps(&tile, across);
                let seam = steps.pop().unwrap();
                let most = steps.iter().fold(0.0, |a: f32, &b| a.max(b));
                assert!(seam <= most * 1.05, "{pattern:?} {across}: {seam} {most}");
            }
        }
    }

    #[test]
    fn texels_are_opaque_with_unit_normals_and_fair_colours() {
        for pattern in PATTERNS {
            let tile = bark(&art(pattern), 5, 64);
            let mut mean = 0.0;
            for texel in tile.texels() {
                let [x, y, z] = texel.normal;
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-4 && z > 0.2);
                assert_eq!(
                    (texel.alpha, texel.translucency, texel.depth),
                    (1.0, 0.0, 0.0)
                );
                assert!((OCCLUSION_FLOOR..=1.0).contains(&texel.occlusion));
                assert!((0.84..=0.96).contains(&texel.roughness));
                mean += texel.albedo[1] / 4096.0;
            }
            assert!((0.1..0.2).contains(&mean), "{pattern:?} {mean}");
        }
    }

    #[test]
    fn the_seed_alone_decides_whatever_the_threads() {
        let draw = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| bark(&art(BarkPattern::Ridged), seed, 48))
        };
        assert_eq!(draw(1, 8), draw(3, 8));
        assert_ne!(draw(1, 8), draw(1, 9));
    }

    #[test]
    fn deeper_relief_tilts_normals_more_and_none_leaves_them_flat() {
        let tilt = |depth_m: f32| -> f32 {
            let art = BarkArt {
                depth_m,
                ..art(BarkPattern::Gnarled)
            };
            let tile = bark(&art, 1, 64);
            tile.texels()
                .iter()
                .map(|texel| 1.0 - texel.normal[2])
                .sum()
        };
        assert_eq!(tilt(0.0), 0.0);
        assert!(tilt(0.02) > 1.5 * tilt(0.005));
    }

    #[test]
    fn tiny_tiles_are_drawn_too() {
        for size in 0..4 {
            let tile = bark(&art(BarkPattern::Rings), 1, size);
            assert_eq!(tile.texels().len(), (size * size) as usize);
        }
    }
}

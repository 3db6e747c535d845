use super::*;
use crate::math::float;

const PATTERNS: [BarkPattern; 10] = [
    BarkPattern::Ridged {
        braid: 0.5,
        flat: 0.4,
        cracks: 0.5,
    },
    BarkPattern::Gnarled { scales: 0.5 },
    BarkPattern::Smooth {
        wrinkles: 0.6,
        lenticels: 0.5,
        scars: 0.6,
    },
    BarkPattern::Papery {
        lenticels: 0.8,
        peel: 0.5,
        diamonds: 0.6,
    },
    BarkPattern::Banded {
        lenticels: 0.7,
        peel: 0.4,
    },
    BarkPattern::Plates {
        flakes: 0.7,
        lift: 0.4,
    },
    BarkPattern::Mosaic { shed: 0.6 },
    BarkPattern::Fibrous { shreds: 0.4 },
    BarkPattern::Rings { fissures: 0.6 },
    BarkPattern::Lattice { boots: 0.6 },
];

fn art(pattern: BarkPattern) -> BarkArt {
    BarkArt {
        pattern,
        light: [0.25, 0.22, 0.18],
        dark: [0.06, 0.045, 0.03],
        accent: [0.2, 0.15, 0.1],
        young: [0.2, 0.2, 0.12],
        mature_radius_m: 0.0,
        height_m: 0.6,
        depth_m: 0.01,
        width_m: 0.06,
        length_m: 0.1,
        age: 1.0,
        roughness: 0.8,
        lichen: 0.3,
        moss: 0.3,
    }
}

fn aged(pattern: BarkPattern, age: f32) -> BarkArt {
    BarkArt {
        age,
        ..art(pattern)
    }
}

/// Mean difference between each line of texels and the next, the last being the wrap.
fn steps(tile: &Image<Texel>, around: bool) -> Vec<f32> {
    let size = tile.width();
    let at = |line: u32, i: u32| {
        *if around {
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
                        + (a.roughness - b.roughness).abs()
                })
                .sum();
            difference / float(size)
        })
        .collect()
}

#[test]
fn every_pattern_at_every_age_is_as_smooth_over_its_seams_as_inside() {
    for pattern in PATTERNS {
        for age in [0.5, 1.0] {
            let tile = bark(&aged(pattern, age), 5, 96);
            for around in [true, false] {
                let mut steps = steps(&tile, around);
                let seam = steps.pop().unwrap();
                let most = steps.iter().fold(0.0, |a: f32, &b| a.max(b));
                assert!(seam <= most * 1.05, "{pattern:?} {around}: {seam} {most}");
            }
        }
    }
}

#[test]
fn every_pattern_repeats_exactly_after_one_tile() {
    for pattern in PATTERNS {
        let art = aged(pattern, 0.6);
        let drawing = Drawing::new(&art, 3);
        for i in 0..200 {
            // Sixty-fourths, so that adding a whole tile changes no digit.
            let (u, v) = (float(i * 7 % 64) / 64.0, float(i * 23 % 61) / 64.0);
            let here = drawing.at(u, v).point;
            for (du, dv) in [(1.0, 0.0), (0.0, 1.0)] {
                let there = drawing.at(u + du, v + dv).point;
                let apart = (here.height - there.height).abs() + (here.tone - there.tone).abs();
                // A warp's last digit may tip a cell's edge.
                assert!(apart < 0.02, "{pattern:?} at {u} {v}: {here:?} {there:?}");
            }
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
            assert!(
                (0.6..=1.0).contains(&texel.roughness),
                "{pattern:?} {texel:?}"
            );
            assert!(
                texel.albedo.iter().all(|x| (0.0..0.4).contains(x)),
                "{pattern:?}"
            );
            mean += texel.albedo[1] / 4096.0;
        }
        assert!((0.07..0.21).contains(&mean), "{pattern:?} {mean}");
    }
}

#[test]
fn the_seed_alone_decides_whatever_the_threads() {
    let draw = |threads: usize, seed: u64, pattern| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bark(&aged(pattern, 0.7), seed, 48))
    };
    for pattern in PATTERNS {
        assert_eq!(draw(1, 8, pattern), draw(3, 8, pattern), "{pattern:?}");
        assert_ne!(draw(1, 8, pattern), draw(1, 9, pattern), "{pattern:?}");
    }
}

#[test]
fn normals_lean_away_from_rising_heights() {
    for pattern in PATTERNS {
        let art = art(pattern);
        let size = 64;
        let tile = bark(&art, 2, size);
        let (_, height) = Drawing::new(&art, 2).relief(size);
        let at = |x: u32, y: u32| height.values[height.index(x % size, y % size)];
        for y in 0..size {
            for x in 0..size {
                let [nx, ny, _] = tile.at(x, y).normal;
                let right = at(x + 1, y) - at(x + size - 1, y);
                let up = at(x, y + size - 1) - at(x, y + 1);
                assert!(nx * right <= 0.0 && ny * up <= 0.0, "{pattern:?} {x} {y}");
            }
        }
    }
}

#[test]
fn deeper_relief_tilts_normals_more_and_none_leaves_them_flat() {
    for pattern in PATTERNS {
        let tilt = |depth_m: f32| {
            let art = BarkArt {
                depth_m,
                ..art(pattern)
            };
            tilt(&bark(&art, 1, 64))
        };
        assert_eq!(tilt(0.0), 0.0);
        assert!(tilt(0.02) > 1.5 * tilt(0.005), "{pattern:?}");
    }
}

fn tilt(tile: &Image<Texel>) -> f32 {
    tile.texels()
        .iter()
        .map(|texel| 1.0 - texel.normal[2])
        .sum()
}

#[test]
fn relief_grows_with_age_and_a_twig_shows_its_young_colour() {
    let ridged = PATTERNS[0];
    let deep = BarkArt {
        depth_m: 0.03,
        lichen: 0.0,
        moss: 0.0,
        ..art(ridged)
    };
    let spread = |age: f32| {
        let art = BarkArt {
            age,
            ..deep.clone()
        };
        let (_, height) = Drawing::new(&art, 4).relief(96);
        let count = height.values.len() as f32;
        let mean = height.values.iter().sum::<f32>() / count;
        let squares: f32 = height.values.iter().map(|h| (h - mean) * (h - mean)).sum();
        (squares / count).sqrt()
    };
    let spreads: Vec<f32> = [0.0, 0.25, 0.5, 0.75, 1.0]
        .into_iter()
        .map(spread)
        .collect();
    assert!(spreads.is_sorted(), "{spreads:?}");
    assert!(spreads[4] > 8.0 * spreads[0], "{spreads:?}");
    let twig = bark(&BarkArt { age: 0.0, ..deep }, 4, 64);
    for i in 0..3 {
        let mean = twig.texels().iter().map(|t| t.albedo[i]).sum::<f32>() / 4096.0;
        let young = art(ridged).young[i];
        assert!((0.8..1.25).contains(&(mean / young)), "{i} {mean}");
    }
}

#[test]
fn what_has_grown_old_stays_old() {
    let art = aged(PATTERNS[0], 0.0);
    for patch in [-1.0, -0.4, 0.0, 0.3, 1.0] {
        let grown: Vec<f32> = (0..=50)
            .map(|i| {
                let art = BarkArt {
                    age: float(i) / 50.0,
                    ..art.clone()
                };
                Drawing::new(&art, 1).skin.grown(patch)
            })
            .collect();
        assert!(grown.is_sorted(), "{patch}: {grown:?}");
        assert_eq!((grown[0], grown[50]), (0.0, 1.0));
    }
}

/// Times that the heights along a column rise through `level`, over all columns and around the tile.
fn crossings(art: &BarkArt, size: u32, level: f32, around: bool) -> f32 {
    let (_, height) = Drawing::new(art, 6).relief(size);
    let mut count = 0;
    for line in 0..size {
        let at = |i: u32| {
            let i = i % size;
            let index = if around {
                height.index(i, line)
            } else {
                height.index(line, i)
            };
            height.values[index]
        };
        count += (0..size)
            .filter(|&i| at(i) < level && at(i + 1) >= level)
            .count();
    }
    count as f32 / float(size)
}

#[test]
fn rings_stand_as_far_apart_as_the_script_says() {
    let rings = |height_m: f32, length_m: f32| {
        let art = BarkArt {
            height_m,
            length_m,
            ..art(BarkPattern::Rings { fissures: 0.0 })
        };
        crossings(&art, 256, 0.36, false)
    };
    // Grain may split a crossing, or a shallow groove miss the level.
    for (height_m, length_m, expected) in [(0.6, 0.1, 6.0), (0.6, 0.05, 12.0), (1.2, 0.1, 12.0)] {
        let found = rings(height_m, length_m);
        assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
    }
}

#[test]
fn parts_keep_their_size_in_metres_when_the_tile_grows() {
    for pattern in [PATTERNS[0], PATTERNS[5], PATTERNS[9]] {
        // The same texels to the metre.
        let count = |height_m: f32, size: u32, width_m: f32| {
            let art = BarkArt {
                height_m,
                width_m,
                ..art(pattern)
            };
            crossings(&art, size, 0.3, true)
        };
        let once = count(0.6, 192, 0.06);
        let twice = count(1.2, 384, 0.06);
        assert!(
            (1.6..2.5).contains(&(twice / once)),
            "{pattern:?} {once} {twice}"
        );
        let wider = count(0.6, 192, 0.15);
        assert!(wider < 0.7 * once, "{pattern:?} {once} {wider}");
    }
}

#[test]
fn a_mosaic_sheds_its_oldest_layer() {
    let old = |shed: f32| {
        let art = BarkArt {
            light: [1.0, 0.0, 0.0],
            dark: [0.0, 0.0, 1.0],
            accent: [0.0, 1.0, 0.0],
            lichen: 0.0,
            moss: 0.0,
            ..art(BarkPattern::Mosaic { shed })
        };
        let tile = bark(&art, 3, 128);
        [0, 1, 2]
            .map(|i| tile.texels().iter().filter(|t| t.albedo[i] > 0.5).count() as f32 / 16384.0)
    };
    let (young, ripe, bare) = (old(0.1), old(0.6), old(1.0));
    assert!(young[2] > 0.7 && bare[2] < 0.2, "{young:?} {bare:?}");
    assert!(ripe.iter().all(|share| *share > 0.1), "{ripe:?}");
}

#[test]
fn lichen_lies_on_the_heights_and_moss_in_the_hollows() {
    let bare = BarkArt {
        light: [0.0; 3],
        dark: [0.0; 3],
        accent: [0.0; 3],
        lichen: 0.0,
        moss: 0.0,
        ..art(PATTERNS[0])
    };
    let mean_height = |art: &BarkArt| {
        let tile = bark(art, 3, 128);
        let (_, height) = Drawing::new(art, 3).relief(128);
        let covered = |i: &usize| tile.texels()[*i].albedo[1] > 0.02;
        let heights: Vec<f32> = (0..16384)
            .filter(covered)
            .map(|i| height.values[i])
            .collect();
        let count = heights.len() as f32;
        (heights.iter().sum::<f32>() / count, count / 16384.0)
    };
    let (high, lichen) = mean_height(&BarkArt {
        lichen: 0.5,
        ..bare.clone()
    });
    let (low, moss) = mean_height(&BarkArt { moss: 0.5, ..bare });
    assert!(high > low + 0.15, "{high} {low}");
    assert!(
        (0.05..0.8).contains(&lichen) && (0.05..0.8).contains(&moss),
        "{lichen} {moss}"
    );
}

#[test]
fn tiny_tiles_and_odd_sizes_are_drawn_too() {
    for pattern in PATTERNS {
        for size in 0..4 {
            let tile = bark(&art(pattern), 1, size);
            assert_eq!(tile.texels().len(), (size * size) as usize);
        }
        let odd = BarkArt {
            height_m: 0.01,
            width_m: 10.0,
            length_m: 0.002,
            depth_m: 0.5,
            ..art(pattern)
        };
        let tile = bark(&odd, 1, 16);
        let fine = |t: &Texel| {
            t.albedo.iter().chain(&t.normal).all(|x| x.is_finite())
                && t.occlusion.is_finite()
                && t.roughness.is_finite()
        };
        assert!(tile.texels().iter().all(fine), "{pattern:?}");
    }
}

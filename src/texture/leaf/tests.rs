//! Whole cards.

use super::*;
use crate::species::schema::{Flowers, LeafLook, Margin, MarginKind, Spray, Tissue};

const COLOUR: [f32; 3] = [0.06, 0.12, 0.03];

const OPPOSITE: Arrangement = Arrangement::Opposite {
    pairs: 5,
    angle_deg: 45.0,
    blade: 0.4,
};

const ALTERNATE: Arrangement = Arrangement::Alternate {
    count: 7,
    angle_deg: 60.0,
    blade: 0.35,
};

const BRUSH: Arrangement = Arrangement::Brush {
    count: 40,
    bundle: 2,
    angle_deg: 55.0,
    blade: 0.3,
};

fn slim(arrangement: Arrangement) -> LeafArt {
    LeafArt {
        arrangement,
        blade: Blade {
            width: 0.25,
            widest: 0.5,
            sharpness: 0.5,
            ..Blade::default()
        },
        colour: Some(COLOUR),
        colour_vary: 0.1,
        stalk_colour: [0.15, 0.12, 0.08],
        gloss: 0.4,
        translucency: Some(0.5),
        ..LeafArt::default()
    }
}

fn drawn(art: &LeafArt, state: LeafState, seed: u64, width: u32, height: u32) -> Image<Texel> {
    let kind = LeafKind {
        name: String::from("leaf"),
        length_m: 0.12,
        width_m: 0.08,
        fold_deg: 0.0,
        look: LeafLook::Drawn(art.clone()),
    };
    leaf(&kind, art, state, seed, width, height)
}

fn card(arrangement: Arrangement, seed: u64, width: u32, height: u32) -> Image<Texel> {
    drawn(
        &slim(arrangement),
        LeafState::default(),
        seed,
        width,
        height,
    )
}

/// Share of a card that is covered.
fn coverage(card: &Image<Texel>) -> f32 {
    let covered: f32 = card.texels().iter().map(|texel| texel.alpha).sum();
    covered / card.texels().len() as f32
}

/// One of each: arrangements, forms, lobes, margins, flowers.
fn all_sorts() -> Vec<LeafArt> {
    let lobed = |lobes| {
        let mut art = slim(Arrangement::Single);
        art.blade.lobes = lobes;
        art.blade.margin = Margin {
            kind: MarginKind::Dentate,
            teeth: 12,
            depth: 0.2,
        };
        art
    };
    let formed = |arrangement, form| LeafArt {
        form,
        ..slim(arrangement)
    };
    vec![
        slim(Arrangement::Single),
        slim(OPPOSITE),
        slim(ALTERNATE),
        slim(BRUSH),
        slim(Arrangement::Tufts {
            count: 6,
            leaves: 20,
            spread_deg: 180.0,
            blade: 0.15,
        }),
        LeafArt {
            spray: Some(Spray {
                shoots: 6,
                opposite: false,
                angle_deg: 45.0,
                length: 0.5,
                orders: 2,
            }),
            ..slim(Arrangement::Scales {
                pairs: 30,
                blade: 0.06,
            })
        },
        lobed(Lobes::Pinnate {
            pairs: 5,
            depth: 0.5,
            sharp: 0.0,
        }),
        lobed(Lobes::Palmate {
            count: 5,
            spread_deg: 200.0,
            depth: 0.5,
            outer: 0.6,
        }),
        formed(
            ALTERNATE,
            Form::Pinnate {
                pairs: 5,
                leaflet: 0.4,
                angle_deg: 60.0,
                bare: 0.2,
                taper: 0.2,
            },
        ),
        formed(
            Arrangement::Single,
            Form::Bipinnate {
                pinnae: 6,
                pinna: 0.5,
                pairs: 10,
                leaflet: 0.2,
            },
        ),
        formed(
            Arrangement::Single,
            Form::Palmate {
                leaflets: 7,
                spread_deg: 250.0,
                outer: 0.6,
                costa: 0.1,
            },
        ),
        LeafArt {
            flowers: Some(Flowers {
                count: 8,
                petals: 5,
                size: 0.15,
                colour: [0.8, 0.6, 0.65],
            }),
            ..slim(ALTERNATE)
        },
    ]
}

#[test]
fn an_elliptic_blade_covers_the_area_of_an_ellipse() {
    let share = coverage(&card(Arrangement::Single, 4, 192, 288));
    let ellipse = crate::math::PI / 4.0;
    assert!((0.94..=1.0).contains(&(share / ellipse)), "{share}");
}

#[test]
fn every_sort_keeps_off_the_border_and_covers_something() {
    for (index, art) in all_sorts().iter().enumerate() {
        let card = drawn(art, LeafState::default(), 5, 64, 96);
        for y in 0..96 {
            for x in 0..64 {
                let border = x == 0 || y == 0 || x == 63 || y == 95;
                assert!(!border || card.at(x, y).alpha == 0.0, "{index}: {x} {y}");
            }
        }
        let share = coverage(&card);
        assert!((0.1..0.85).contains(&share), "{index}: {share}");
        // It begins at the foot and fills the height, or the width before that.
        let seen = |y: u32| (0..64).any(|x| card.at(x, y).alpha > 0.1);
        assert!((80..94).any(seen), "{index}");
        assert!((2..48).any(seen), "{index}");
    }
}

#[test]
fn values_are_in_range_whatever_the_season_and_health() {
    let states = [(0.0, 1.0), (1.0, 0.2), (1.6, 1.0), (3.0, 0.0)];
    for mut art in all_sorts() {
        art.autumn = Some(Tissue::Orange);
        for (season, health) in states {
            let state = LeafState {
                season,
                age: 0.5,
                health,
            };
            for texel in drawn(&art, state, 2, 24, 36).texels() {
                let [x, y, z] = texel.normal;
                assert!((x * x + y * y + z * z - 1.0).abs() < 1e-4 && z > 0.0);
                assert!(texel.albedo.iter().all(|c| (0.0..=1.0).contains(c)));
                assert!((0.0..=1.0).contains(&texel.occlusion));
                assert!((0.0..=1.0).contains(&texel.roughness));
                assert!((0.0..=1.0).contains(&texel.translucency));
            }
        }
    }
}

#[test]
fn hidden_texels_have_leaf_colours() {
    for texel in card(OPPOSITE, 2, 48, 72).texels() {
        assert!((0.03..0.3).contains(&texel.albedo[1]), "{texel:?}");
    }
}

#[test]
fn green_leaves_are_as_dark_as_measured_and_turn_with_the_season() {
    let art = LeafArt {
        colour: None,
        autumn: Some(Tissue::Yellow),
        colour_vary: 0.0,
        ..slim(Arrangement::Single)
    };
    let mean = |season: f32| {
        let state = LeafState {
            season,
            ..LeafState::default()
        };
        let card = drawn(&art, state, 3, 64, 96);
        let seen: Vec<&Texel> = card.texels().iter().filter(|t| t.alpha > 0.9).collect();
        let sum: Vec3 = seen.iter().map(|t| Vec3::from_array(t.albedo)).sum();
        sum / seen.len() as f32
    };
    let (spring, summer, autumn) = (mean(0.0), mean(1.0), mean(2.0));
    let measured = Vec3::from_array(reflectance(Tissue::MidGreen));
    assert!(
        (summer / measured - Vec3::ONE).abs().max_element() < 0.2,
        "{summer}"
    );
    assert!(spring.y > 1.2 * summer.y, "{spring}");
    let yellow = Vec3::from_array(reflectance(Tissue::Yellow));
    assert!(
        (autumn / yellow - Vec3::ONE).abs().max_element() < 0.25,
        "{autumn}"
    );
}

#[test]
fn ill_leaves_have_holes_and_brown_spots() {
    let art = slim(Arrangement::Single);
    let ill = LeafState {
        health: 0.1,
        ..LeafState::default()
    };
    let (whole, eaten) = (
        drawn(&art, LeafState::default(), 3, 96, 144),
        drawn(&art, ill, 3, 96, 144),
    );
    let lost = 1.0 - coverage(&eaten) / coverage(&whole);
    assert!((0.01..0.4).contains(&lost), "{lost}");
    let brown = |card: &Image<Texel>| {
        let red = |texel: &&Texel| texel.alpha > 0.9 && texel.albedo[0] > texel.albedo[1];
        card.texels().iter().filter(red).count()
    };
    assert!(brown(&whole) == 0 && brown(&eaten) > 500);
}

#[test]
fn leaves_of_a_pair_are_opposite_and_single_ones_alternate() {
    let feet = |arrangement| {
        let art = slim(arrangement);
        let maps = [BladeMap::new(&art.blade, 64.0)];
        let card = Card {
            half_width: 0.33,
            border: Vec2::splat(0.01),
        };
        let mut feet: Vec<(f32, f32)> = card::elements(&art, &maps, &card, None, 7)
            .iter()
            .filter_map(|element| match element.shape {
                Shape::Blade(pose) if pose.along.x.abs() > 0.25 => {
                    Some((pose.base.y, pose.along.x.signum()))
                }
                _ => None,
            })
            .collect();
        feet.sort_by(|a, b| a.0.total_cmp(&b.0));
        feet
    };
    let pairs = feet(OPPOSITE);
    assert_eq!(pairs.len(), 10);
    for pair in pairs.chunks(2) {
        assert_ne!(pair[0].1, pair[1].1);
        assert!(pair[1].0 - pair[0].0 < 0.05);
    }
    let single = feet(ALTERNATE);
    assert_eq!(single.len(), 7);
    assert!(single.windows(2).all(|pair| pair[0].1 != pair[1].1));
}

#[test]
fn needles_stand_all_around_their_twig() {
    let card = card(BRUSH, 3, 96, 144);
    let share = |left: u32, right: u32| {
        let columns = (left..right).flat_map(|x| (0..144).map(move |y| (x, y)));
        columns.map(|(x, y)| card.at(x, y).alpha).sum::<f32>() / 144.0
    };
    let (left, right) = (share(0, 48), share(48, 96));
    assert!((left / right - 1.0).abs() < 0.2, "{left} {right}");
    // Some stand before the twig: it does not show through all along.
    let hidden = (30..100)
        .filter(|&y| card.at(48, y).translucency > 0.1)
        .count();
    assert!(hidden > 10, "{hidden}");
}

#[test]
fn blades_of_a_sprig_do_not_shade_as_one_flat_card() {
    let dense = Arrangement::Opposite {
        pairs: 6,
        angle_deg: 40.0,
        blade: 0.45,
    };
    let card = card(dense, 2, 64, 96);
    let seen = || card.texels().iter().filter(|texel| texel.alpha > 0.9);
    let count = seen().count() as f32;
    let mean: f32 = seen().map(|texel| texel.normal[0]).sum::<f32>() / count;
    let spread: f32 = seen().map(|texel| (texel.normal[0] - mean).abs()).sum();
    assert!(spread / count > 0.1, "{}", spread / count);
    assert!(seen().any(|texel| texel.occlusion < 0.75));
}

#[test]
fn the_seed_alone_decides_whatever_the_threads() {
    let draw = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| card(ALTERNATE, seed, 32, 48))
    };
    assert_eq!(draw(1, 8), draw(3, 8));
    assert_ne!(draw(1, 8), draw(1, 9));
}

#[test]
fn degenerate_cards_are_drawn_without_fault() {
    for size in 0..5 {
        for art in all_sorts() {
            let card = drawn(&art, LeafState::default(), 1, size, size);
            assert_eq!(card.texels().len(), (size * size) as usize);
        }
    }
    let none = Arrangement::Alternate {
        count: 0,
        angle_deg: 400.0,
        blade: 9.0,
    };
    let card = card(none, 1, 16, 16);
    assert!(card.texels().iter().all(|texel| texel.alpha <= 1.0));
}

/// FNV-1a over the bits of all values of a card.
fn fingerprint(card: &Image<Texel>) -> u64 {
    let values = card.texels().iter().flat_map(|texel| {
        let Texel {
            albedo: [r, g, b],
            alpha,
            normal: [x, y, z],
            occlusion,
            roughness,
            translucency,
            depth,
        } = *texel;
        [
            r,
            g,
            b,
            alpha,
            x,
            y,
            z,
            occlusion,
            roughness,
            translucency,
            depth,
        ]
    });
    let bytes = values.flat_map(|value| value.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    })
}

#[test]
fn bits_are_the_same_on_every_machine() {
    let hashes: Vec<u64> = all_sorts()
        .iter()
        .map(|art| {
            let state = LeafState {
                season: 1.5,
                age: 0.5,
                health: 0.6,
            };
            let art = LeafArt {
                autumn: Some(Tissue::Yellow),
                ..art.clone()
            };
            fingerprint(&drawn(&art, state, 11, 32, 48))
        })
        .collect();
    assert_eq!(hashes, EXPECTED, "{hashes:#x?}");
}

/// Change these only with a change that is meant to alter pictures.
const EXPECTED: [u64; 12] = [
    0x2a75_0ac2_6f86_45e0,
    0x7ec6_2175_26f3_6d39,
    0xcaf3_c366_237e_b56c,
    0xeb36_e5be_374c_db3a,
    0x9b7b_ccb5_68ed_4089,
    0x4ad6_57bc_df2e_dd94,
    0x20c4_18d8_ce15_ba40,
    0x0437_b22f_8270_cc64,
    0x7c21_70e9_d2b5_7152,
    0x1426_6e7e_cb48_9ffc,
    0x5ff9_4e92_f38b_d01c,
    0x990e_46e6_f612_61d3,
];

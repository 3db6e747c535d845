use super::*;

type Picture = Image<[u8; 3]>;

fn picture(width: u32, height: u32, mut colour: impl FnMut(u32, u32) -> [u8; 3]) -> Picture {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = places.map(|(x, y)| colour(x, y)).collect();
    Image::from_texels(width, height, texels)
}

fn noise(width: u32, height: u32, seed: u32) -> Picture {
    let mut state = seed;
    picture(width, height, |_, _| {
        core::array::from_fn(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state.to_be_bytes()[0]
        })
    })
}

/// Dabs of green before a sky: pictures of the kind that LODs give.
fn dabs(seed: u32, shift: u32) -> Picture {
    let mut dice = noise(4, 260, seed)
        .texels()
        .to_vec()
        .into_iter()
        .map(|t| t.map(u32::from));
    let mut image = picture(120, 140, |_, _| [180, 205, 235]);
    while let (Some(place), Some([r, g, b])) = (dice.next(), dice.next()) {
        let (x0, y0) = (20 + place[0] * 70 / 255 + shift, 10 + place[1] * 100 / 255);
        let size = 2 + place[2] / 40;
        for (x, y) in (y0..y0 + size).flat_map(|y| (x0..x0 + size).map(move |x| (x, y))) {
            *image.at_mut(x, y) =
                [r / 3, 60 + g / 2, b / 5].map(|c| byte_from_unit(float(c) / 255.0));
        }
    }
    image
}

fn pairs() -> Vec<(&'static str, Picture, Picture)> {
    let grey = [90, 100, 110];
    let slanted = |at: u32| {
        picture(131, 97, |x, y| {
            if x + y / 2 < at {
                [20, 40, 10]
            } else {
                [230, 220, 240]
            }
        })
    };
    let bars = |wide: u32, inside: [u8; 3], outside: [u8; 3]| {
        picture(120, 45, |x, _| if x % 40 < wide { inside } else { outside })
    };
    let ramp = |x: u32, y: u32| [x, y].map(|c| byte_from_unit(float(c) / 100.0));
    vec![
        ("noise", noise(67, 83, 1), noise(67, 83, 2)),
        ("shifted dabs", dabs(5, 0), dabs(5, 2)),
        ("other dabs", dabs(5, 0), dabs(6, 0)),
        ("shifted edge", slanted(80), slanted(83)),
        (
            "changed colours",
            picture(100, 100, |x, y| [ramp(x, y)[0], ramp(x, y)[1], 128]),
            picture(100, 100, |x, y| [ramp(x, y)[1], ramp(x, y)[0], 128]),
        ),
        (
            "blue and yellow",
            bars(20, [255, 255, 0], [0, 0, 255]),
            bars(13, [255, 255, 0], [0, 0, 255]),
        ),
        (
            "dark blue",
            bars(20, [0, 0, 200], [0; 3]),
            bars(18, [0, 0, 90], [0; 3]),
        ),
        (
            "points",
            picture(90, 80, |_, _| grey),
            picture(90, 80, |x, y| {
                if x % 17 == 3 && y % 13 == 5 {
                    [255; 3]
                } else {
                    grey
                }
            }),
        ),
        ("a few pixels", noise(3, 2, 7), noise(3, 2, 8)),
    ]
}

fn mean(errors: &Image<f32>) -> f32 {
    masked_mean(errors, &vec![true; errors.texels().len()])
}

#[test]
fn errors_agree_with_the_authors_program() {
    for (name, reference, test) in pairs() {
        let theirs = |image: &Picture| {
            let bytes = image.texels().as_flattened();
            nv_flip::FlipImageRgb8::with_data(image.width(), image.height(), bytes)
        };
        for scale in [PIXELS_PER_DEGREE, 30.0, 120.0] {
            let ours = flip(&reference, &test, scale).unwrap();
            let theirs = nv_flip::flip(theirs(&reference), theirs(&test), scale).to_vec();
            let off = ours
                .texels()
                .iter()
                .zip(&theirs)
                .map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f32::max);
            let theirs = Image::from_texels(ours.width(), ours.height(), theirs);
            let mean_off = (mean(&ours) - mean(&theirs)).abs();
            assert!(off < 5e-4, "{name} at {scale}: one pixel is {off} off");
            assert!(
                mean_off < 5e-5,
                "{name} at {scale}: the mean is {mean_off} off"
            );
        }
    }
}

#[test]
fn the_metric_does_not_drift() {
    let errors = flip(&dabs(5, 0), &dabs(5, 2), PIXELS_PER_DEGREE).unwrap();
    // The same bits on every machine and at every level of optimisation.
    assert_eq!(mean(&errors), 0.212_039_95);
}

#[test]
fn equal_pictures_have_no_error_at_all() {
    for (name, image, _) in pairs() {
        let errors = flip(&image, &image, PIXELS_PER_DEGREE).unwrap();
        assert!(errors.texels().iter().all(|&error| error == 0.0), "{name}");
    }
}

#[test]
fn errors_lie_within_bounds_and_do_not_depend_on_the_order() {
    for (name, a, b) in pairs() {
        for scale in [4.0, PIXELS_PER_DEGREE, f32::NAN, -1.0] {
            let errors = flip(&a, &b, scale).unwrap();
            assert!(
                errors
                    .texels()
                    .iter()
                    .all(|error| (0.0..=1.0).contains(error)),
                "{name}"
            );
            assert_eq!(errors, flip(&b, &a, scale).unwrap(), "{name}");
        }
    }
}

#[test]
fn the_widest_contrasts_have_errors_near_one() {
    let plain = |colour: [u8; 3]| picture(30, 20, |_, _| colour);
    let error = |a, b| mean(&flip(&plain(a), &plain(b), PIXELS_PER_DEGREE).unwrap());
    assert!(error([0; 3], [255; 3]) > 0.96);
    assert!(error([0, 255, 0], [0, 0, 255]) > 0.9999);
    assert!(error([100; 3], [104; 3]) < 0.1);
}

#[test]
fn a_point_is_seen_as_far_as_the_filters_reach_and_no_further() {
    let plain = picture(61, 61, |_, _| [128; 3]);
    let mut test = plain.clone();
    *test.at_mut(30, 30) = [255, 0, 0];
    let errors = flip(&plain, &test, PIXELS_PER_DEGREE).unwrap();
    for (x, y) in (0..61_u32).flat_map(|y| (0..61_u32).map(move |x| (x, y))) {
        let away = x.abs_diff(30).max(y.abs_diff(30));
        if away > 10 {
            assert_eq!(*errors.at(x, y), 0.0, "at {x}, {y}");
        } else if away <= 3 {
            assert!(*errors.at(x, y) > 0.01, "at {x}, {y}");
        }
    }
}

#[test]
fn mirrored_pictures_have_mirrored_errors() {
    let mirrored = |image: &Picture| {
        picture(image.width(), image.height(), |x, y| {
            *image.at(image.width() - 1 - x, y)
        })
    };
    let turned = |image: &Picture| picture(image.height(), image.width(), |x, y| *image.at(y, x));
    let (a, b) = (noise(37, 30, 3), noise(37, 30, 4));
    let plain = flip(&a, &b, PIXELS_PER_DEGREE).unwrap();
    let mirror = flip(&mirrored(&a), &mirrored(&b), PIXELS_PER_DEGREE).unwrap();
    let turn = flip(&turned(&a), &turned(&b), PIXELS_PER_DEGREE).unwrap();
    for y in 0..30 {
        for x in 0..37 {
            assert!((plain.at(x, y) - mirror.at(36 - x, y)).abs() < 1e-4);
            assert!((plain.at(x, y) - turn.at(y, x)).abs() < 1e-4);
        }
    }
}

#[test]
fn pictures_of_any_size_are_compared_but_not_of_two_sizes() {
    for (width, height) in [(0, 0), (0, 3), (5, 0), (1, 1), (1, 40), (33, 1), (16, 2)] {
        let black = picture(width, height, |_, _| [0; 3]);
        let white = picture(width, height, |_, _| [255; 3]);
        let errors = flip(&black, &white, PIXELS_PER_DEGREE).unwrap();
        assert_eq!((errors.width(), errors.height()), (width, height));
        assert!(errors.texels().iter().all(|&error| error > 0.96));
    }
    assert_eq!(
        flip(&noise(4, 6, 1), &noise(6, 4, 1), PIXELS_PER_DEGREE),
        None
    );
}

#[test]
fn a_masked_mean_counts_only_what_the_mask_shows() {
    let errors = Image::from_texels(2, 2, vec![0.25, 1.0, 0.75, 1.0]);
    assert_eq!(masked_mean(&errors, &[true, false, true, false]), 0.5);
    assert_eq!(masked_mean(&errors, &[false; 4]), 0.0);
}

#[test]
fn magma_agrees_with_the_authors_table() {
    let table = nv_flip::magma_lut().to_vec();
    let errors = Image::from_texels(256, 1, (0..256).map(|i| float(i) / 255.0).collect());
    for (i, (ours, theirs)) in magma(&errors)
        .texels()
        .iter()
        .zip(table.chunks(3))
        .enumerate()
    {
        let off = ours.iter().zip(theirs).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(off <= Some(3), "{i}: {ours:?} is not {theirs:?}");
    }
}

#[test]
fn roots_and_powers_are_those_of_the_library() {
    for i in 1..5000 {
        let x = float(i * i) * 3e-5;
        let root = libm::cbrtf(x);
        assert!((cube_root(x) - root).abs() <= 2.5e-7 * root, "{x}");
        for exponent in [0.0, 0.013, 0.5, COLOUR_POWER, 1.0] {
            let exact = libm::powf(x, exponent);
            assert!(
                (power(x, exponent) - exact).abs() <= 1e-6 * exact,
                "{x}^{exponent}"
            );
        }
    }
    assert_eq!(power(0.0, 0.0), 0.0);
    assert_eq!(power(1.0, 0.3), 1.0);
}

//! How the adapter lights trees and ground. Without an adapter, these tests show as ignored; with
//! `PLEACH_REQUIRE_GPU=1` that is a failure.

mod common;

use common::adapter::{self, Outcome, Test};
use common::gpu::{SIZE, computed, palm, renderer, scene, species};
use libtest_mimic::Failed;
use pleach::capture;
use pleach::gpu::{Gpu, GpuError};
use pleach::image::Image;
use pleach::math::Vec3;
use pleach::pipeline::{self, Settings};
use pleach::render::LightMode;
use pleach::report::Quiet;
use pleach::shadow;
use std::process::ExitCode;

fn main() -> ExitCode {
    let tests: [Test; 5] = [
        (
            "shares_of_the_nine_shadows_agree_with_the_library",
            shares_agree,
        ),
        (
            "the_ground_is_dark_where_the_baked_shadow_lies",
            ground_shadow,
        ),
        (
            "the_sum_of_four_factors_lights_the_side_of_the_sun",
            four_factors,
        ),
        (
            "leaves_that_face_the_sun_cast_more_shadow",
            leaves_face_the_sun,
        ),
        (
            "the_middle_of_few_quads_is_as_light_as_the_crown",
            light_core,
        ),
    ];
    adapter::run(&tests)
}

fn shares_agree() -> Outcome {
    let suns: Vec<Vec3> = (0..400)
        .map(|i| {
            let turn = i as f32 * 2.399_963;
            let up = (i as f32 + 0.5) / 400.0;
            let level = (1.0 - up * up).sqrt();
            Vec3::new(libm::cosf(turn) * level, up, libm::sinf(turn) * level)
        })
        .chain((0..9).map(shadow::direction))
        .collect();
    let shares = shares_in_shader(&Gpu::headless()?, &suns)?;
    for (sun, shares) in suns.iter().zip(&shares) {
        let mut expected = [0.0; 9];
        for (light, share) in shadow::weights(*sun) {
            expected[light] += share;
        }
        for light in 0..9 {
            if (expected[light] - shares[light]).abs() > 2e-4 {
                return Err(format!("sun {sun}: {shares:?} in the shader, {expected:?}").into());
            }
        }
    }
    Ok(())
}

/// What `nine_shares` of `light.wgsl` gives.
fn shares_in_shader(gpu: &Gpu, suns: &[Vec3]) -> Result<Vec<[f32; 9]>, Failed> {
    const MAIN: &str = "
        @group(0) @binding(0) var<storage, read> suns: array<vec4<f32>>;
        @group(0) @binding(1) var<storage, read_write> shares: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < arrayLength(&suns) {
                let found = nine_shares(suns[id.x].xyz);
                for (var i = 0; i < 9; i++) {
                    shares[id.x * 9u + u32(i)] = share_of(found, i);
                }
            }
        }";
    let files = pleach::gpu::shader::TREES.files;
    let wide: Vec<[f32; 4]> = suns.iter().map(|s| s.extend(0.0).to_array()).collect();
    let numbers = computed(gpu, &[files[0], files[1], MAIN], &wide, 9)?;
    Ok(numbers.as_chunks::<9>().0.to_vec())
}

fn leaves_face_the_sun() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    scene.setting.ground_shadows = 0.0;
    scene.setting.backdrop = false;
    let mut brightness = |leaves_face_sun: bool| -> Result<u64, GpuError> {
        scene.setting.leaves_face_sun = leaves_face_sun;
        let picture = renderer.picture(&scene, SIZE)?;
        let of = |p: &[u8; 4]| u64::from(p[1]) * u64::from(p[3]);
        Ok(picture.texels().iter().map(of).sum())
    };
    let (facing, hanging) = (brightness(true)?, brightness(false)?);
    let part = facing as f32 / hanging as f32;
    println!("{part:.3} of the light with leaves that face the sun in the shadow map");
    if (0.5..0.985).contains(&part) {
        return Ok(());
    }
    Err(format!("leaves that face the sun leave {part} of the light").into())
}

fn ground_shadow() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    // From above, with the tree itself left out: what is dark is shadow.
    scene.camera.eye = Vec3::new(0.0, 60.0, 0.1);
    scene.camera.target = Vec3::ZERO;
    scene.setting.sun = shadow::direction(1);
    let mut alone = scene.clone();
    alone.setting.ground_shadows = 0.0;
    let dark = renderer.picture(&scene, SIZE)?;
    let bright = renderer.picture(&alone, SIZE)?;
    let brightness = |p: &[u8; 4]| p[..3].iter().map(|&c| f32::from(c)).sum::<f32>();
    let mut sums = [0.0_f32; 2];
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let lost = brightness(bright.at(x, y)) - brightness(dark.at(x, y));
            sums[usize::from(x < SIZE[0] / 2)] += lost;
        }
    }
    // The sun stands at +X, to the right, so the shadow falls to the left.
    let [right, left] = sums;
    println!("darkened: {left:.0} to the left, {right:.0} to the right");
    if left > 500.0 && left > 4.0 * right {
        return Ok(());
    }
    Err(format!("the shadow is not to the left: {left} there, {right} to the right").into())
}

fn four_factors() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    scene.setting.backdrop = false;
    scene.setting.light = LightMode::FourFactors;
    let [right, _] = scene.camera.sides();
    let mut sides = |sun: Vec3| -> Result<f32, GpuError> {
        scene.setting.sun = sun;
        let picture = renderer.picture(&scene, SIZE)?;
        let mut sums = [(0.0, 0.0); 2];
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let [_, g, _, a] = *picture.at(x, y);
                let side = &mut sums[usize::from(x < SIZE[0] / 2)];
                side.0 += f32::from(g) * f32::from(a);
                side.1 += f32::from(a);
            }
        }
        let [r, l] = sums.map(|(light, weight)| light / weight);
        Ok(r / l)
    };
    let (from_right, from_left) = (
        sides(right + Vec3::Y * 0.7)?,
        sides(-right + Vec3::Y * 0.7)?,
    );
    println!("right over left: {from_right:.3} with the sun there, {from_left:.3} without");
    if from_right > 1.05 * from_left {
        return Ok(());
    }
    Err(format!("the sunny side is not the brighter one: {from_right} {from_left}").into())
}

/// Mean brightness of what covers the middle of a picture, of 255.
fn brightness_in_the_middle(picture: &Image<[u8; 4]>) -> f32 {
    let [width, height] = SIZE;
    let (mut sum, mut weight) = (0.0, 0.0);
    for y in height * 4 / 10..height * 6 / 10 {
        for x in width * 4 / 10..width * 6 / 10 {
            let [_, g, _, a] = picture.at(x, y).map(f32::from);
            sum += g * a;
            weight += a;
        }
    }
    sum / weight
}

fn light_core() -> Outcome {
    let (species, files) = species("olive.ron");
    let settings = Settings {
        full: true,
        budgets: Some(vec![8]),
        captures: capture::Settings {
            atlas_size: 512,
            ..capture::Settings::default()
        },
        bark_size: 128,
        shadows: shadow::Settings {
            size: 64,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    let mut asset = pipeline::generate(&species, &settings, &files, &Quiet)?;
    let parts = |asset: &pleach::asset::TreeAsset| -> Result<[f32; 2], GpuError> {
        let mut renderer = renderer(asset)?;
        let mut of = |lod| {
            let mut scene = scene(&renderer, lod);
            scene.setting.backdrop = false;
            let picture = renderer.picture(&scene, SIZE)?;
            Ok(brightness_in_the_middle(&picture))
        };
        Ok([of(0)?, of(1)?])
    };
    let [full, quads] = parts(&asset)?;
    // As if nobody knew how deep the captures are: light at the planes themselves, amid the crown.
    asset.reliefs.clear();
    let [_, flat] = parts(&asset)?;
    let [quads, flat] = [quads, flat].map(|light| light / full);
    println!(
        "{quads:.2} of full detail's light in the middle of the crown, {flat:.2} on the planes"
    );
    if (0.75..1.25).contains(&quads) && flat < 0.9 * quads {
        return Ok(());
    }
    Err(format!("the middle of the quads has {quads} of the light; on the planes {flat}").into())
}

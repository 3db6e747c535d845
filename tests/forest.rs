//! Forests: the passes against their twin on the processor, and what is drawn of their lists.

mod common;

use common::adapter::{self, Outcome};
use common::gpu::{covered, mean_flip, palm};
use libtest_mimic::Failed;
use pleach::asset::Drawable;
use pleach::gpu::{Gpu, GpuError};
use pleach::math::{PI, TAU, Vec2, Vec3};
use pleach::render::forest::{
    Calls, Clearing, Forest, ForestError, ForestTree, Lists, Planting, Twin, Use, plant,
};
use pleach::render::{Camera, Lens, Renderer, Scene};
use std::process::ExitCode;

fn main() -> ExitCode {
    adapter::run(&[
        ("the_passes_give_the_lists_of_their_twin", twin_agrees),
        ("a_seen_tree_has_one_lod_or_two_that_share_it", shared_out),
        ("no_tree_in_sight_is_lost_and_none_out_of_it_kept", culled),
        ("a_camera_that_comes_back_finds_the_same_trees", hysteresis),
        ("trees_switch_one_after_the_other", jitter),
        ("a_fade_covers_as_much_as_its_lods", fades),
        ("a_forest_may_be_empty_or_one_tree_or_of_one_lod", small),
        ("a_tree_of_a_forest_looks_as_one_alone", like_one_alone),
        ("a_forest_gives_the_same_picture_twice", same_twice),
        ("draw_calls_do_not_grow_with_the_trees", calls),
        ("what_makes_no_forest_is_refused_in_words", refused),
        (
            "an_adapter_without_optional_features_draws_the_same",
            plain_adapter,
        ),
    ])
}

const SIZE: [u32; 2] = [200, 150];

/// The palm with all of its LODs, with its coarsest one alone, and with three in the middle.
fn renderer() -> Result<Renderer, GpuError> {
    renderer_on(&Gpu::headless()?)
}

fn renderer_on(gpu: &Gpu) -> Result<Renderer, GpuError> {
    let mut renderer = Renderer::new(gpu, wgpu::TextureFormat::Rgba8UnormSrgb)?;
    let whole = palm().drawable();
    let last = whole.lods.len() - 1;
    for part in [0..=last, last..=last, 1..=3] {
        renderer.add(&Drawable {
            lods: whole.lods[part].to_vec(),
            ..whole.clone()
        })?;
    }
    Ok(renderer)
}

fn planted(trees: u32) -> Vec<ForestTree> {
    plant(&Planting {
        trees,
        shares: vec![2.0, 1.0, 1.0],
        spacing_m: 6.0,
        clearings: vec![Clearing {
            middle: Vec2::new(8.0, 5.0),
            radius: 14.0,
        }],
        ..Planting::default()
    })
}

fn seen_from(camera: Camera) -> Scene {
    Scene {
        groups: Vec::new(),
        ..Scene::of_one(camera, 0, 0)
    }
}

/// Views from within, from far above and without perspective, in an order in which neighbours differ little.
fn cameras() -> Vec<Camera> {
    let walk = (0..24_u8).map(|i| {
        let t = f32::from(i);
        let (sine, cosine) = libm::sincosf(t * 0.37);
        let eye = Vec3::new(8.0 + 3.0 * t, 1.7 + t * t * 0.2, 5.0 - 2.0 * t);
        Camera {
            eye,
            target: eye + Vec3::new(cosine, -0.02 * t, sine) * 30.0,
            lens: Lens::Perspective(0.3 + 0.04 * t),
        }
    });
    let flat = [3.0, 20.0, 300.0].map(|half| Camera {
        eye: Vec3::new(40.0, 60.0, 80.0),
        target: Vec3::ZERO,
        lens: Lens::Orthographic(half),
    });
    walk.chain(flat).collect()
}

fn chosen(renderer: &mut Renderer, forest: &mut Forest, scene: &Scene) -> Result<Lists, Failed> {
    let encoder = renderer.choose_forest(forest, scene, SIZE);
    renderer.gpu().queue.submit([encoder.finish()]);
    Ok(forest.lists(renderer.gpu())?)
}

fn twin_agrees() -> Outcome {
    let mut renderer = renderer()?;
    // More than a group of groups, so that sums go over their edges; and not a whole number of groups.
    let trees = planted(70_001);
    let mut forest = renderer.forest(&trees)?;
    forest.settings.frame_seconds = 0.07;
    let mut twin = Twin::new(trees.len());
    let mut used = vec![0; forest.plan().bins.len()];
    for (index, camera) in cameras().into_iter().enumerate() {
        let scene = seen_from(camera);
        let cull = forest.cull(&scene, SIZE);
        let expected = twin.choose(forest.plan(), &trees, &cull).clone();
        let lists = chosen(&mut renderer, &mut forest, &scene)?;
        for (bin, used) in used.iter_mut().enumerate() {
            *used += lists.bin(bin).len();
        }
        if lists != expected {
            let differs = |bin: &usize| lists.bin(*bin) != expected.bin(*bin);
            let bins: Vec<usize> = (0..used.len()).filter(differs).collect();
            return Err(format!("camera {index}: bins {bins:?} differ").into());
        }
    }
    let idle = used.iter().filter(|&&n| n == 0).count();
    println!("{used:?}");
    if idle > used.len() / 4 {
        return Err(format!("{idle} of {} bins were never used: {used:?}", used.len()).into());
    }
    Ok(())
}

/// For each tree, 255ths of it that are drawn, and with how many LODs.
fn drawn(forest: &Forest, lists: &Lists) -> Vec<(i32, u32)> {
    let mut drawn = vec![(0, 0); forest.trees().len()];
    for (index, bin) in forest.plan().bins.iter().enumerate() {
        if bin.of != Use::Draw {
            continue;
        }
        for entry in lists.trees(index) {
            let (part, lods) = &mut drawn[entry.tree as usize];
            *part += entry.fade.abs();
            *lods += 1;
        }
    }
    drawn
}

fn shared_out() -> Outcome {
    let mut renderer = renderer()?;
    let mut forest = renderer.forest(&planted(8_000))?;
    let mut fading = 0;
    for step in 0..30_u8 {
        let eye = Vec3::new(8.0, 2.0 + f32::from(step), 5.0);
        let scene = seen_from(Camera {
            eye,
            target: eye + Vec3::new(1.0, -0.1, 0.3),
            lens: Lens::Perspective(0.9),
        });
        let lists = chosen(&mut renderer, &mut forest, &scene)?;
        let drawn = drawn(&forest, &lists);
        for (tree, &(part, lods)) in drawn.iter().enumerate() {
            if lods > 0 && (part != 255 || lods > 2) {
                return Err(format!("tree {tree}: {part} of 255 by {lods} LODs").into());
            }
        }
        fading += drawn.iter().filter(|d| d.1 == 2).count();
    }
    println!("{fading} fades seen");
    if fading < 50 {
        return Err(format!("only {fading} trees were seen to fade").into());
    }
    Ok(())
}

fn culled() -> Outcome {
    let mut renderer = renderer()?;
    let trees = planted(8_000);
    for camera in cameras() {
        let mut forest = renderer.forest(&trees)?;
        let scene = seen_from(camera);
        let lists = chosen(&mut renderer, &mut forest, &scene)?;
        let drawn = drawn(&forest, &lists);
        let clip = camera.view_projection(4.0 / 3.0);
        let mut outside = 0;
        for (index, (tree, &(_, lods))) in trees.iter().zip(&drawn).enumerate() {
            let model = &renderer.models()[tree.model as usize];
            let turn = libm::atan2f(f32::from(tree.turn[1]), f32::from(tree.turn[0]));
            let (sine, cosine) = libm::sincosf(turn);
            let corner = |p: &Vec3| {
                let p = *p * tree.size;
                let turned = Vec3::new(p.x * cosine + p.z * sine, p.y, p.z * cosine - p.x * sine);
                (clip * (turned + Vec3::from(tree.place)).extend(1.0)).to_array()
            };
            let points: Vec<[f32; 4]> = model.hull.iter().map(corner).collect();
            let within = |[x, y, z, w]: &[f32; 4]| {
                let shown = w.abs() * (1.0 - 1e-4);
                x.abs() < shown && y.abs() < shown && *z < *w && *w > 0.0
            };
            if lods == 0 && points.iter().any(within) {
                return Err(format!("tree {index} is in sight and not drawn").into());
            }
            // A sphere holds much air about a palm: what is farther away than a tree's size must be gone.
            let far = |p: &[f32; 4], side: f32, axis: usize| side * p[axis] > p[3].abs();
            let beyond = |axis: usize, side: f32| points.iter().all(|p| far(p, side, axis));
            let out = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
            if lods > 0 && out.iter().any(|&(axis, side)| beyond(axis, side)) {
                outside += 1;
            }
        }
        let seen = drawn.iter().filter(|d| d.1 > 0).count();
        println!("{seen} drawn, {outside} of them out of sight");
        if outside * 3 > seen + 60 {
            return Err(format!("{outside} of {seen} trees drawn are out of sight").into());
        }
    }
    Ok(())
}

/// For each tree, the bin that it is drawn from.
fn lods(forest: &Forest, lists: &Lists) -> Vec<Option<usize>> {
    let mut lods = vec![None; forest.trees().len()];
    for (index, bin) in forest.plan().bins.iter().enumerate() {
        for entry in lists.trees(index).filter(|_| bin.of == Use::Draw) {
            lods[entry.tree as usize] = Some(index);
        }
    }
    lods
}

fn hysteresis() -> Outcome {
    let mut renderer = renderer()?;
    // Close together, so that many are near a switch.
    let trees = plant(&Planting {
        trees: 8_000,
        shares: vec![2.0, 1.0, 1.0],
        spacing_m: 0.6,
        ..Planting::default()
    });
    let mut changes = [0, 0];
    for (change, room) in changes.iter_mut().zip([0.08, 0.0]) {
        let mut forest = renderer.forest(&trees)?;
        forest.settings.hysteresis = room;
        forest.settings.fade_seconds = 0.0;
        let at = |away: f32| {
            // From high above the middle all trees are about as far.
            seen_from(Camera {
                eye: Vec3::new(0.0, 55.0 * away, 1.0),
                target: Vec3::ZERO,
                lens: Lens::Perspective(1.2),
            })
        };
        let first = chosen(&mut renderer, &mut forest, &at(1.0))?;
        chosen(&mut renderer, &mut forest, &at(1.02))?;
        let back = chosen(&mut renderer, &mut forest, &at(1.0))?;
        if back != first {
            return Err("a step back and forth changed what is drawn".into());
        }
        // A first step nearer makes some finer; after that, nothing may change any more.
        chosen(&mut renderer, &mut forest, &at(0.98))?;
        let near = chosen(&mut renderer, &mut forest, &at(1.0))?;
        chosen(&mut renderer, &mut forest, &at(0.98))?;
        let again = chosen(&mut renderer, &mut forest, &at(1.0))?;
        if near != again {
            return Err("the same step, twice, gave two sets of trees".into());
        }
        let closer = chosen(&mut renderer, &mut forest, &at(0.98))?;
        let [far, near] = [&again, &closer].map(|lists| lods(&forest, lists));
        *change = (0..trees.len())
            .filter(|&t| far[t].is_some() && near[t].is_some() && far[t] != near[t])
            .count();
    }
    println!(
        "flips at each step: {} with room, {} without",
        changes[0], changes[1]
    );
    if changes[0] != 0 || changes[1] < 20 {
        return Err(format!("{changes:?} trees flip, with room and without").into());
    }
    Ok(())
}

fn jitter() -> Outcome {
    let mut renderer = renderer()?;
    let mut largest = [0, 0];
    for (largest, jitter) in largest.iter_mut().zip([0.2, 0.0]) {
        let trees = vec![ForestTree::at(Vec3::ZERO, 0.0, 1.0, 0); 1000];
        let mut forest = renderer.forest(&trees)?;
        forest.settings.jitter = jitter;
        forest.settings.fade_seconds = 0.0;
        let height = renderer.models()[0].bounds.size().y;
        let switch = renderer.models()[0].lods[2].screen_size;
        let mut coarse = 0;
        for step in 0..40_u8 {
            // From half as large as at the switch, to one and a half.
            let size = switch * (1.4 - 0.02 * f32::from(step));
            let scene = seen_from(Camera {
                eye: Vec3::new(0.0, height * 0.5, height / size / 2.0 / libm::tanf(0.4)),
                target: Vec3::new(0.0, height * 0.5, 0.0),
                lens: Lens::Perspective(0.8),
            });
            forest.forget(renderer.gpu());
            let lists = chosen(&mut renderer, &mut forest, &scene)?;
            let now: usize = (2..renderer.models()[0].lods.len())
                .map(|lod| lists.bin(lod).len())
                .sum();
            if now < coarse {
                return Err(format!("step {step}: {now} are coarse, {coarse} were").into());
            }
            *largest = (*largest).max(now - coarse);
            coarse = now;
        }
        if coarse != 1000 {
            return Err(format!("{coarse} of 1000 trees switched").into());
        }
    }
    println!(
        "at most {} switch at once with jitter, {} without",
        largest[0], largest[1]
    );
    if largest[0] > 200 || largest[1] != 1000 {
        return Err(format!("{largest:?} of 1000 trees switch at once").into());
    }
    Ok(())
}

/// A palm alone in a forest, so large that LOD 1 or 2 may be shown.
fn one(renderer: &mut Renderer) -> Result<(Forest, Scene), Failed> {
    let forest = renderer.forest(&[ForestTree::at(Vec3::ZERO, 0.3, 1.0, 0)])?;
    let height = renderer.models()[0].bounds.size().y;
    let mut scene = seen_from(Camera {
        eye: Vec3::new(0.0, height * 0.5, height * 2.5),
        target: Vec3::new(0.0, height * 0.5, 0.0),
        lens: Lens::Perspective(0.5),
    });
    scene.setting.backdrop = false;
    scene.setting.shadow_map = false;
    Ok((forest, scene))
}

fn fades() -> Outcome {
    let mut renderer = renderer()?;
    let (mut forest, scene) = one(&mut renderer)?;
    let mut areas = Vec::new();
    let mut whole = |lod| -> Result<_, Failed> {
        let (mut forest, scene) = one(&mut renderer)?;
        forest.settings.lod = Some(lod);
        Ok(renderer.picture_of_forest(&mut forest, &scene, SIZE)?)
    };
    let [fine, coarse] = [whole(0)?, whole(2)?];
    // In detail so high that the finest is shown, then as coarse as may be.
    forest.settings.fade_seconds = 1.0;
    forest.settings.frame_seconds = 0.2;
    forest.settings.detail = 100.0;
    let start = renderer.picture_of_forest(&mut forest, &scene, SIZE)?;
    forest.settings.detail = 1.0;
    let height = renderer.models()[0].bounds.size().y;
    let size = height / scene.camera.height_at(Vec3::new(0.0, height * 0.5, 0.0));
    forest.settings.detail = renderer.models()[0].lods[2].screen_size / size * 0.7;
    for _ in 0..5 {
        let picture = renderer.picture_of_forest(&mut forest, &scene, SIZE)?;
        areas.push((covered(&picture), picture));
    }
    if start != fine {
        return Err("a tree in full detail is not drawn by its finest LOD".into());
    }
    let least = covered(&fine).min(covered(&coarse));
    let most = covered(&fine).max(covered(&coarse));
    println!(
        "{least:.4} to {most:.4}, fading {:?}",
        areas.iter().map(|a| a.0).collect::<Vec<_>>()
    );
    for (area, _) in &areas {
        if !(least * 0.95..=most * 1.25).contains(area) {
            return Err(
                format!("covers {area} in a fade, {least} to {most} before or after").into(),
            );
        }
    }
    if areas.last().map(|a| &a.1) != Some(&coarse) {
        return Err("a fade does not end with the coarse LOD alone".into());
    }
    let middle = &areas[1].1;
    if *middle == fine || *middle == coarse {
        return Err("nothing faded".into());
    }
    Ok(())
}

fn small() -> Outcome {
    let mut renderer = renderer()?;
    let scene = one(&mut renderer)?.1;
    let mut picture = |trees: &[ForestTree]| -> Result<f32, Failed> {
        let mut forest = renderer.forest(trees)?;
        Ok(covered(&renderer.picture_of_forest(
            &mut forest,
            &scene,
            SIZE,
        )?))
    };
    let [none, tree, flat] = [
        picture(&[])?,
        picture(&[ForestTree::at(Vec3::ZERO, 0.0, 1.0, 0)])?,
        picture(&[ForestTree::at(Vec3::ZERO, 0.0, 1.0, 1)])?,
    ];
    if none != 0.0 || tree < 0.02 || flat < 0.02 {
        return Err(
            format!("{none} covered by none, {tree} by one, {flat} by one of one LOD").into(),
        );
    }
    Ok(())
}

fn like_one_alone() -> Outcome {
    let mut renderer = renderer()?;
    for lod in 0..renderer.models()[0].lods.len() {
        let (mut forest, mut scene) = one(&mut renderer)?;
        scene.setting.backdrop = true;
        forest.settings.lod = u32::try_from(lod).ok();
        // As far as the ground is seen about one tree, whatever its turn.
        let bounds = renderer.models()[0].bounds;
        let wide = bounds.corners().map(|c| libm::hypotf(c.x, c.z));
        let wide = 2.0 * wide.into_iter().fold(0.0, f32::max);
        forest.settings.air_m = Vec3::new(wide, bounds.size().y, wide).length() * 12.0;
        let planted = renderer.picture_of_forest(&mut forest, &scene, SIZE)?;
        let mut alone = Scene::of_one(scene.camera, 0, lod);
        alone.setting = scene.setting;
        alone.groups[0].trees[0] = pleach::render::Instance::at(Vec3::ZERO, 0.3, 1.0);
        let alone = renderer.picture(&alone, SIZE)?;
        let error = mean_flip(&planted, &alone);
        println!("lod {lod}: mean FLIP {error:.4}");
        if error > 0.02 {
            let folder = common::gpu::root().join("target");
            std::fs::create_dir_all(&folder)?;
            let png = |p| pleach::image::png::encode(p).map_err(|e| e.to_string());
            std::fs::write(folder.join("forest-one.png"), png(&planted)?)?;
            std::fs::write(folder.join("forest-alone.png"), png(&alone)?)?;
            return Err(
                format!("LOD {lod} of a forest is unlike one alone: FLIP {error:.4}").into(),
            );
        }
    }
    Ok(())
}

fn same_twice() -> Outcome {
    let mut renderer = renderer()?;
    let trees = planted(3_000);
    let scene = seen_from(cameras()[3]);
    let mut pictures = Vec::new();
    for calls in [Calls::Indirect, Calls::Indirect, Calls::EachTree] {
        let mut forest = renderer.forest(&trees)?;
        forest.settings.calls = calls;
        pictures.push(renderer.picture_of_forest(&mut forest, &scene, SIZE)?);
    }
    if pictures[0] != pictures[1] {
        return Err("two forests of the same trees give two pictures".into());
    }
    // One by one, bark and foliage of a tree come together: another one is in front where two are equally far.
    let error = mean_flip(&pictures[0], &pictures[2]);
    println!("one by one: mean FLIP {error:.5}");
    if error > 0.006 {
        return Err(format!("trees drawn one by one give another picture: FLIP {error:.5}").into());
    }
    let mut forest = renderer.forest(&trees)?;
    renderer.picture_of_forest(&mut forest, &seen_from(cameras()[9]), SIZE)?;
    forest.forget(renderer.gpu());
    if renderer.picture_of_forest(&mut forest, &scene, SIZE)? != pictures[0] {
        return Err("a forest that forgot remembers".into());
    }
    Ok(())
}

fn plain_adapter() -> Outcome {
    let scene = seen_from(cameras()[3]);
    let picture = |renderer: &mut Renderer| -> Result<_, Failed> {
        let mut forest = renderer.forest(&planted(3_000))?;
        Ok(renderer.picture_of_forest(&mut forest, &scene, SIZE)?)
    };
    if picture(&mut renderer()?)? == picture(&mut renderer_on(&adapter::plain()?)?)? {
        return Ok(());
    }
    Err("two pictures of one forest differ".into())
}

fn calls() -> Outcome {
    let mut renderer = renderer()?;
    let scene = seen_from(cameras()[3]);
    let mut counts = Vec::new();
    for (trees, calls) in [
        (10, Calls::Indirect),
        (10_000, Calls::Indirect),
        (10_000, Calls::EachTree),
    ] {
        let mut forest = renderer.forest(&planted(trees))?;
        forest.settings.calls = calls;
        renderer.picture_of_forest(&mut forest, &scene, [40, 30])?;
        counts.push(forest.calls());
    }
    println!("{counts:?}");
    if counts[0] != counts[1] || counts[0] > 60 || counts[2] < 1_000 {
        return Err(format!("{counts:?} calls: 10 trees, 10,000, and 10,000 one by one").into());
    }
    Ok(())
}

fn refused() -> Outcome {
    let mut renderer = renderer()?;
    let stray = ForestTree::at(Vec3::ZERO, PI, 1.0, 3);
    match renderer.forest(&[ForestTree::at(Vec3::ZERO, TAU, 1.0, 2), stray]) {
        Err(error @ ForestError::NoSuchModel { .. })
            if error.to_string() == "tree 1 is of model 3, and there are 3" => {}
        other => return Err(format!("{other:?}").into()),
    }
    Ok(())
}

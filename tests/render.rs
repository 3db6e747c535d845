//! What the GPU draws, on whatever adapter there is. Without one, these tests show as ignored; with
//! `PLEACH_REQUIRE_GPU=1` that is a failure.

mod cli_common;
mod common;

use common::adapter::{self, Outcome, Test};
use common::gpu::{SIZE, computed, covered, mean_flip, palm, renderer, root, scene};
use libtest_mimic::Failed;
use pleach::capture;
use pleach::gpu::{Gpu, GpuError};
use pleach::image::{Image, png};
use pleach::math::{Vec3, round_to_u32};
use pleach::render::{Filter, Instance, LightMode, Renderer, Scene, ViewMode, level_colour};
use pleach::wind::{self, Rig, Wind};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let tests: [Test; 16] = [
        ("a_scene_gives_the_same_picture_twice", same_picture_twice),
        (
            "a_scene_after_others_is_drawn_as_if_it_came_first",
            after_others,
        ),
        ("pictures_look_as_they_did", pictures_look_as_they_did),
        ("the_tree_covers_what_the_rasteriser_says", covers_the_same),
        (
            "far_lods_look_like_full_detail_where_they_are_shown",
            lods_look_alike,
        ),
        ("trees_alone_stand_on_nothing", transparent),
        ("filters_soften_edges_and_keep_the_covered_area", filters),
        ("every_view_shows_the_tree", views),
        ("every_level_has_its_colour_in_every_lod", levels),
        ("a_window_without_height_draws_nothing", no_height),
        (
            "what_the_adapter_cannot_take_is_refused_in_words",
            too_large,
        ),
        ("a_lost_device_is_told_and_not_a_panic", lost),
        ("the_shader_sways_vertices_as_the_library_does", sways_agree),
        ("lods_lean_downwind_together", lods_lean_together),
        ("the_program_draws_a_wood_of_scripts", wood_by_the_program),
        (
            "an_adapter_without_optional_features_draws_the_same",
            plain_adapter,
        ),
    ];
    adapter::run(&tests)
}

fn wood_by_the_program() -> Outcome {
    use cli_common::{nursery, pleach, utf8};
    let (dir, script) = nursery();
    let draw = |name: &str, trees: &str| {
        let out = dir.path().join(name);
        let mut args = vec!["render", utf8(&script), "--out", utf8(&out)];
        args.extend(["--what", "forest", "--trees", trees, "--size", "320x180"]);
        pleach(&args).ends(0, &[name]);
        std::fs::read(&out)
    };
    let wood = draw("wood.png", "400")?;
    if draw("again.png", "400")? != wood {
        return Err("the same wood is another picture".into());
    }
    let picture = png::decode(&wood, 1 << 20)?;
    if (picture.width(), picture.height()) != (320, 180) {
        return Err(format!("{} x {}", picture.width(), picture.height()).into());
    }
    // Trees change the picture below the horizon, and hardly reach into the sky above it.
    let lone = png::decode(&draw("lone.png", "1")?, 1 << 20)?;
    let differs = |rows: std::ops::Range<u32>| {
        let texels = rows.flat_map(|y| (0..320).map(move |x| (x, y)));
        let other = texels.filter(|&(x, y)| picture.at(x, y) != lone.at(x, y));
        other.count()
    };
    let (sky, trees) = (differs(0..20), differs(60..180));
    if sky > 100 || trees < 2_000 {
        return Err(format!("{sky} pixels of the sky differ, and {trees} below").into());
    }
    pleach(&["render", utf8(&script), "--out", "none/wood.png"]).ends(2, &["--out", "none"]);
    Ok(())
}

fn same_picture_twice() -> Outcome {
    let mut renderer = renderer(palm())?;
    let scene = scene(&renderer, 0);
    let first = renderer.picture(&scene, SIZE)?;
    if renderer.picture(&scene, SIZE)? == first {
        return Ok(());
    }
    Err("two pictures of one scene differ".into())
}

fn plain_adapter() -> Outcome {
    let mut welcome = renderer(palm())?;
    let mut plain = Renderer::new(&adapter::plain()?, wgpu::TextureFormat::Rgba8UnormSrgb)?;
    plain.add(&palm().drawable())?;
    let scene = scene(&plain, 0);
    if plain.picture(&scene, SIZE)? == welcome.picture(&scene, SIZE)? {
        return Ok(());
    }
    Err("two pictures of one scene differ".into())
}

/// A change of a scene.
type Change<'a> = &'a mut dyn FnMut(&mut Scene);

fn after_others() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    renderer.picture(&scene, SIZE)?;
    let mut steps: [(&str, Change<'_>); 5] = [
        ("the camera", &mut |s| s.camera.eye.x += 1.0),
        ("the sun", &mut |s| {
            s.setting.sun = Vec3::new(-0.5, 0.4, 0.2);
        }),
        ("the LOD", &mut |s| s.groups[0].lod = 1),
        ("a tree", &mut |s| {
            let tree = Instance::at(Vec3::new(1.5, 0.0, -1.0), 1.0, 0.7);
            s.groups[0].trees.push(tree);
        }),
        ("the shadow map", &mut |s| s.setting.shadow_map = false),
    ];
    for (what, change) in &mut steps {
        change(&mut scene);
        let mut fresh = self::renderer(palm())?;
        if renderer.picture(&scene, SIZE)? != fresh.picture(&scene, SIZE)? {
            return Err(format!("{what} is not drawn as it is now").into());
        }
    }
    // Another tree in the place of this one.
    scene.setting.shadow_map = true;
    scene.groups[0].lod = 0;
    renderer.picture(&scene, SIZE)?;
    let mut other = palm().drawable();
    other.lods.remove(0);
    renderer.replace(0, &other)?;
    let mut fresh = Renderer::new(&Gpu::headless()?, wgpu::TextureFormat::Rgba8UnormSrgb)?;
    fresh.add(&other)?;
    if renderer.picture(&scene, SIZE)? != fresh.picture(&scene, SIZE)? {
        return Err("a tree in the place of another is not drawn as it is".into());
    }
    Ok(())
}

fn pictures_look_as_they_did() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    for (name, view, light) in [
        ("lit", ViewMode::Lit, LightMode::Product),
        ("four-factors", ViewMode::Lit, LightMode::FourFactors),
        ("normals", ViewMode::Normals, LightMode::Product),
    ] {
        scene.view = view;
        scene.setting.light = light;
        let picture = renderer.picture(&scene, SIZE)?;
        let path = root().join(format!("tests/golden/render-palm-{name}.png"));
        if std::env::var_os("UPDATE_GOLDENS").is_some() {
            std::fs::write(&path, png::encode(&picture).map_err(|e| e.to_string())?)?;
        }
        let expected = png::decode(&read(&path)?, 1 << 20)?;
        let error = mean_flip(&expected, &picture);
        if error > 0.03 {
            let seen = root().join(format!("target/render-palm-{name}.png"));
            std::fs::write(&seen, png::encode(&picture).map_err(|e| e.to_string())?)?;
            return Err(format!(
                "{name}: mean FLIP {error:.4} from {}; the picture is in {}; if it is right, run again with \
                 UPDATE_GOLDENS=1",
                path.display(),
                seen.display()
            )
            .into());
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>, Failed> {
    std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()).into())
}

fn covers_the_same() -> Outcome {
    use pleach::measure::silhouette::{Cutouts, Silhouette};
    use pleach::render::{Camera, Lens};
    let asset = palm();
    let mut renderer = renderer(asset)?;
    let bounds = renderer.models()[0].bounds;
    let half = bounds.size().max_element() * 0.6;
    let cutouts = Cutouts::of(&asset.foliage.texels());
    for lod in [0, 2] {
        let camera = Camera {
            eye: bounds.centre() + Vec3::Z * 50.0,
            target: bounds.centre(),
            lens: Lens::Orthographic(half),
        };
        let mut scene = Scene::of_one(camera, 0, lod);
        scene.setting.backdrop = false;
        let drawn = covered(&renderer.picture(&scene, [512, 512])?);
        let view = capture::View {
            centre: bounds.centre(),
            right: Vec3::X,
            up: Vec3::Y,
            half: [half, half],
            width: 512,
            height: 512,
        };
        let silhouette = Silhouette::of(&asset.lods[lod].mesh, &cutouts, &view);
        let expected = silhouette.area() as f32 / (512.0 * 512.0);
        let off = drawn / expected - 1.0;
        println!(
            "lod {lod}: {drawn:.4} of the picture, {expected:.4} by the rasteriser, {off:+.3}"
        );
        if off.abs() > 0.08 {
            return Err(
                format!("lod {lod}: covers {drawn}, the rasteriser says {expected}").into(),
            );
        }
    }
    Ok(())
}

fn lods_look_alike() -> Outcome {
    let mut renderer = renderer(palm())?;
    let full = scene(&renderer, 0);
    let (mut last, mut judged) = (0.0, 0);
    for lod in 1..renderer.models()[0].lods.len() {
        // As large as it is at most shown in a picture 1080 high.
        let height = round_to_u32((1080.0 * renderer.models()[0].lods[lod].screen_size).min(300.0));
        if height < 24 {
            // Filters of FLIP are as wide as such a picture.
            continue;
        }
        judged += 1;
        let size = [height * 4 / 5, height];
        let expected = renderer.picture(&full, size)?;
        let mut coarse = full.clone();
        coarse.groups[0].lod = lod;
        let error = mean_flip(&expected, &renderer.picture(&coarse, size)?);
        println!("lod {lod} at {height} pixels: mean FLIP {error:.4}");
        if error > 0.08 {
            return Err(format!("lod {lod} at {height} pixels: mean FLIP {error:.4}").into());
        }
        last = error;
    }
    if last == 0.0 || judged < 3 {
        return Err("LODs cannot be told from full detail at all: the test sees nothing".into());
    }
    Ok(())
}

/// A vertex in a wind: what `wind_offset` of `wind.wgsl` takes.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Blown {
    wind: Wind,
    rig: Rig,
    sway: [f32; 4],
    leaf: [f32; 4],
    /// Unit; then the time.
    axis: [f32; 4],
    /// Height, and three that fill up.
    height: [f32; 4],
}

fn sways_agree() -> Outcome {
    const MAIN: &str = "
        struct Blown {
            wind: Wind,
            rig: WindRig,
            sway: vec4<f32>,
            leaf: vec4<f32>,
            axis: vec4<f32>,
            height: vec4<f32>,
        }
        @group(0) @binding(0) var<storage, read> vertices: array<Blown>;
        @group(0) @binding(1) var<storage, read_write> moved: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            if id.x < arrayLength(&vertices) {
                let v = vertices[id.x];
                let to = wind_offset(v.wind, v.rig, v.axis.w, v.height.x, v.sway, v.leaf, v.axis.xyz);
                for (var i = 0u; i < 3u; i++) {
                    moved[id.x * 3u + i] = to[i];
                }
            }
        }";
    let asset = palm();
    let mut expected = Vec::new();
    let mut vertices = Vec::new();
    for (index, sway) in [&asset.lods[0].mesh.bark, &asset.lods[0].mesh.foliage]
        .iter()
        .flat_map(|p| p.sway.iter().step_by(41))
        .enumerate()
    {
        let n = index as f32;
        let wind = Wind {
            direction: pleach::math::Vec2::new(0.6, 0.8),
            speed_m_s: n % 35.0,
            gustiness: (n % 11.0) / 10.0,
        };
        let axis = Vec3::new(0.48, 0.6, 0.64);
        let (time, height) = (n * 0.37, n % 23.0);
        expected.push(wind::displacement(
            &wind,
            &asset.wind,
            time,
            height,
            *sway,
            axis,
        ));
        vertices.push(Blown {
            wind,
            rig: asset.wind,
            sway: sway.weights(),
            leaf: sway.turns(),
            axis: axis.extend(time).to_array(),
            height: [height, 0.0, 0.0, 0.0],
        });
    }
    let wgsl = include_str!("../shaders/wind.wgsl");
    let moved = computed(&Gpu::headless()?, &[wgsl, MAIN], &vertices, 3)?;
    let (mut worst, mut farthest) = (0.0_f32, 0.0_f32);
    for (&to, expected) in moved.as_chunks::<3>().0.iter().zip(&expected) {
        worst = worst.max(Vec3::from(to).distance(*expected));
        farthest = farthest.max(expected.length());
    }
    println!(
        "{} vertices, up to {farthest:.2} m away, {worst:.6} m apart",
        vertices.len()
    );
    if vertices.len() > 200 && farthest > 0.5 && worst < 2e-3 {
        return Ok(());
    }
    Err(format!("{worst} m apart, {farthest} m away").into())
}

/// Mean place of what a picture shows, in pixels from the left.
fn middle(picture: &Image<[u8; 4]>) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            let alpha = f32::from(picture.at(x, y)[3]);
            sum += alpha * x as f32;
            weight += alpha;
        }
    }
    sum / weight
}

fn lods_lean_together() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut shifts = Vec::new();
    for lod in 0..renderer.models()[0].lods.len() {
        let mut scene = scene(&renderer, lod);
        scene.setting.backdrop = false;
        let [right, _] = scene.camera.sides();
        scene.wind.direction = pleach::math::Vec2::new(right.x, right.z);
        scene.time = 3.0;
        let still = renderer.picture(&scene, SIZE)?;
        scene.wind.speed_m_s = 14.0;
        let blown = renderer.picture(&scene, SIZE)?;
        scene.time += 0.7;
        if renderer.picture(&scene, SIZE)? == blown {
            return Err(format!("lod {lod} stands still in the wind").into());
        }
        shifts.push(middle(&blown) - middle(&still));
    }
    println!("shifted to the right by {shifts:.2?} pixels");
    let full = shifts[0];
    if full > 2.0 && shifts.iter().all(|s| (s / full - 1.0).abs() < 0.3) {
        return Ok(());
    }
    Err(format!("LODs do not lean together: {shifts:?} pixels").into())
}

fn transparent() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    scene.setting.backdrop = false;
    let picture = renderer.picture(&scene, SIZE)?;
    let corner = picture.at(0, 0)[3];
    let part = covered(&picture);
    let opaque = picture.texels().iter().any(|p| p[3] == 255 && p[1] > 20);
    if corner == 0 && (0.02..0.5).contains(&part) && opaque {
        return Ok(());
    }
    Err(format!("corner {corner}, covered {part}, opaque pixels: {opaque}").into())
}

/// Mean difference between neighbours: how hard a picture's edges are.
fn hardness(picture: &Image<[u8; 4]>) -> f32 {
    let mut sum = 0.0;
    for y in 0..picture.height() {
        for x in 1..picture.width() {
            let (a, b) = (picture.at(x - 1, y)[3], picture.at(x, y)[3]);
            let step = f32::from(a.abs_diff(b));
            sum += step * step;
        }
    }
    sum
}

fn filters() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    scene.setting.backdrop = false;
    let mut draw = |filter| {
        scene.filter = filter;
        renderer
            .picture(&scene, SIZE)
            .map(|p| (covered(&p), hardness(&p)))
    };
    let plain = draw(Filter::None)?;
    let soft = [Filter::Bilinear, Filter::Alpha, Filter::Combined].map(&mut draw);
    let [bilinear, alpha, both] = soft;
    let (bilinear, alpha, both) = (bilinear?, alpha?, both?);
    println!("covered, hardness: {plain:?}, {bilinear:?}, {alpha:?}, {both:?}");
    for (name, (part, hard)) in [("bilinear", bilinear), ("alpha", alpha), ("both", both)] {
        if (part / plain.0 - 1.0).abs() > 0.09 || hard >= plain.1 {
            return Err(
                format!("{name}: covered {part}, hardness {hard}; {plain:?} without").into(),
            );
        }
    }
    if both.1 >= alpha.1.min(bilinear.1) {
        return Err("both filters are not softer than either".into());
    }
    Ok(())
}

fn views() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 1);
    let mut seen: Vec<Image<[u8; 4]>> = Vec::new();
    for view in [
        ViewMode::Lit,
        ViewMode::Lods,
        ViewMode::Levels,
        ViewMode::Normals,
        ViewMode::Albedo,
        ViewMode::Overdraw,
        ViewMode::Wire,
    ] {
        scene.view = view;
        let picture = renderer.picture(&scene, SIZE)?;
        let middle = picture.part(SIZE[0] / 4, SIZE[1] / 8, SIZE[0] / 2, SIZE[1] / 2);
        let bright = middle.texels().iter().filter(|p| p[1] > 40).count();
        if bright < 200 || seen.contains(&picture) {
            return Err(format!("{view:?}: {bright} bright pixels, or the same as another").into());
        }
        seen.push(picture);
    }
    Ok(())
}

/// Hue of a colour, degrees; none for greys.
fn hue(colour: [u8; 3]) -> Option<f32> {
    let [r, g, b] = colour.map(pleach::math::linear_from_srgb);
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let spread = high - low;
    let turn = match high {
        _ if spread < 0.2 * high => return None,
        h if h == r => (g - b) / spread,
        h if h == g => 2.0 + (b - r) / spread,
        _ => 4.0 + (r - g) / spread,
    };
    Some((turn * 60.0).rem_euclid(360.0))
}

/// Pixels of a picture by the level whose hue they have, and those that have none of them.
fn by_level(picture: &Image<[u8; 4]>, levels: usize) -> (Vec<usize>, usize) {
    let (mut counts, mut others) = (vec![0; levels], 0);
    for &[r, g, b, a] in picture.texels() {
        if a < 255 {
            continue;
        }
        let away = |level: &usize| -> Option<f32> {
            let turn = (hue([r, g, b])? - hue(level_colour(*level))?).rem_euclid(360.0);
            Some(turn.min(360.0 - turn))
        };
        match (0..levels).find(|level| away(level).is_some_and(|away| away < 9.0)) {
            Some(level) => counts[level] += 1,
            None => others += 1,
        }
    }
    (counts, others)
}

fn levels() -> Outcome {
    let mut renderer = renderer(palm())?;
    let levels = palm().tree.levels.len();
    for lod in 0..palm().lods.len() {
        let mut scene = scene(&renderer, lod);
        scene.setting.backdrop = false;
        scene.view = ViewMode::Levels;
        let (counts, others) = by_level(&renderer.picture(&scene, SIZE)?, levels);
        let told = format!("LOD {lod}: {counts:?}, {others} of no level");
        println!("{told}");
        let seen = counts.iter().sum::<usize>();
        // Pixels of two levels are mixed of both.
        let drawn = counts.iter().filter(|&&count| count > 20).count();
        if others > seen || drawn == 0 || (lod == 0 && drawn < 3) {
            return Err(told.into());
        }
    }
    // A pack does not tell levels.
    let mut meshes: Vec<(pleach::mesh::Mesh, f32)> = Vec::new();
    for lod in &palm().lods {
        let mut mesh = lod.mesh.clone();
        mesh.bark.levels.clear();
        mesh.foliage.levels.clear();
        meshes.push((mesh, lod.screen_size));
    }
    renderer.replace(
        0,
        &pleach::asset::Drawable {
            lods: meshes.iter().map(|(mesh, size)| (mesh, *size)).collect(),
            ..palm().drawable()
        },
    )?;
    let mut scene = scene(&renderer, 0);
    scene.setting.backdrop = false;
    scene.view = ViewMode::Levels;
    let (counts, others) = by_level(&renderer.picture(&scene, SIZE)?, levels);
    if others > 1_000 && counts.iter().sum::<usize>() == 0 {
        return Ok(());
    }
    Err(format!("without levels: {counts:?}, {others} of no level").into())
}

fn no_height() -> Outcome {
    let mut renderer = renderer(palm())?;
    let scene = scene(&renderer, 0);
    let texture = renderer
        .gpu()
        .device
        .create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: 4,
                height: 4,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    for size in [[0, 0], [4, 0], [4, 4], [0, 4]] {
        let encoder = renderer.draw(&scene, &view, size)?;
        renderer.gpu().queue.submit([encoder.finish()]);
        renderer.gpu().finish()?;
    }
    Ok(())
}

fn too_large() -> Outcome {
    let mut renderer = renderer(palm())?;
    let scene = scene(&renderer, 0);
    match renderer.picture(&scene, [1 << 20, 4]) {
        Err(error @ GpuError::TooLarge { .. }) if error.to_string().contains("1048576") => Ok(()),
        other => Err(format!("{other:?}").into()),
    }
}

fn lost() -> Outcome {
    let mut renderer = renderer(palm())?;
    let mut scene = scene(&renderer, 0);
    scene.groups[0].trees.push(Instance::at(Vec3::X, 1.0, 0.5));
    renderer.gpu().device.destroy();
    match renderer.picture(&scene, SIZE) {
        Err(_) => Ok(()),
        Ok(_) => Err("a destroyed device drew a picture".into()),
    }
}

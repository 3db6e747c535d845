//! The window of `pleach preview`, driven by what its widgets are called, without a screen. Without a graphics
//! adapter, these tests show as ignored; with `PLEACH_REQUIRE_GPU=1` that is a failure.

mod common;

use common::adapter::{self, Outcome};
use common::gpu::mean_flip;
use eframe::egui::accesskit::Role;
use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2,
    vec2,
};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use libtest_mimic::Failed;
use pleach::image::{Image, png};
use pleach::pipeline::{self, Settings};
use pleach::render::ViewMode;
use pleach::report::Quiet;
use pleach::species::{self, Beside};
use pleach::viewer::level::Choice;
use pleach::viewer::rig::Stance;
use pleach::viewer::settings::Arrangement;
use pleach::viewer::{self, App, Legacy, Source, Start};
use pleach::{capture, pack, shadow};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    adapter::run(&[
        ("the_panel_chooses_lods_and_says_what_is_shown", lods),
        ("every_view_and_arrangement_is_in_the_panel", pictures),
        ("sun_and_wind_are_set_in_the_panel", sun_and_wind),
        ("keys_do_what_the_help_says", keys),
        ("the_mouse_moves_camera_and_sun", mouse),
        ("held_keys_walk_on_the_ground", walking),
        (
            "a_broken_script_keeps_the_tree_and_a_mended_one_grows",
            hot_reload,
        ),
        ("a_screenshot_has_all_pixels_of_the_view", screenshot),
        ("at_rest_nothing_is_drawn", rest),
        ("a_window_without_room_for_the_view_goes_on", no_room),
        ("a_lost_device_closes_the_window_and_leaves_its_state", lost),
        (
            "a_device_lost_while_a_tree_loads_closes_the_window_too",
            lost_while_loading,
        ),
        ("the_window_looks_as_it_did", looks),
    ])
}

type Window = Harness<'static, App>;

/// Longest that a tree may take to grow.
const PATIENCE: Duration = Duration::from_secs(120);

/// The window in all tests but that of its looks: half of it is the panel.
const SIZE: [f32; 2] = [560.0, 900.0];

fn species_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("species")
}

/// Small textures: a tree that grows in no time.
fn small() -> Settings {
    Settings {
        full: true,
        captures: capture::Settings {
            atlas_size: 256,
            ..capture::Settings::default()
        },
        bark_size: 64,
        shadows: shadow::Settings {
            size: 64,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    }
}

/// A palm, grown once for all tests, as a pack.
fn palm() -> &'static Path {
    static PALM: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, folder) = PALM.get_or_init(|| {
        let text = fs::read_to_string(species_folder().join("palm.ron")).expect("a script");
        let files = Beside(species_folder());
        let species = species::parse("palm.ron", &text, &files).expect("no faults");
        let asset = pipeline::generate(&species, &small(), &files, &Quiet).expect("it grows");
        let files = pack::build(&asset, text.as_bytes(), pack::Options::default());
        let dir = tempfile::tempdir().expect("a folder");
        let files = files.expect("files");
        let folder = pack::write(dir.path(), "palm-1", &files, pack::Replace::OwnPacks);
        (dir, folder.expect("a pack"))
    });
    folder
}

fn window_with(start: Start, size: [f32; 2]) -> Window {
    let state = create_render_state(viewer::setup(), RendererOptions::PREDICTABLE);
    let app = App::new(&state, start, || ()).expect("the window begins");
    Harness::builder()
        .with_size(vec2(size[0], size[1]))
        .with_max_steps(64)
        .with_context_setup(viewer::panel::style)
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(|ui, app: &mut App| app.ui(ui), app)
}

/// A window on the palm, once the palm is there.
fn window() -> Result<Window, Failed> {
    let start = Start::new(Source::Pack(palm().to_owned()), PathBuf::from("."));
    let mut window = window_with(start, SIZE);
    until(&mut window, "the palm", |app| app.subject.is_some())?;
    Ok(window)
}

/// Lets the window run until something is so.
fn until(window: &mut Window, what: &str, so: impl Fn(&App) -> bool) -> Outcome {
    let begun = Instant::now();
    while !so(window.state()) {
        if begun.elapsed() > PATIENCE {
            return Err(format!("waited in vain for {what}: {:?}", window.state().fault()).into());
        }
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    window.run_steps(2);
    Ok(())
}

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click_accesskit();
    window.run_steps(2);
}

fn press(window: &mut Window, key: Key) {
    window.key_press(key);
    window.run_steps(2);
}

fn slide(window: &mut Window, label: &str, value: f64) {
    let slider = window.get_by_role_and_label(Role::Slider, label);
    slider.set_value_accesskit(value);
    window.run_steps(2);
}

/// The picture of the whole window.
fn seen(window: &mut Window) -> Result<Image<[u8; 4]>, Failed> {
    let picture = window.render()?;
    let (width, height) = picture.dimensions();
    let texels = picture.into_raw().as_chunks::<4>().0.to_vec();
    Ok(Image::from_texels(width, height, texels))
}

/// The middle of the view, left of the panel.
const MIDDLE: Pos2 = pos2(150.0, 450.0);

fn ensure(so: bool, what: impl Into<String>) -> Outcome {
    if so { Ok(()) } else { Err(what.into().into()) }
}

fn lods() -> Outcome {
    let mut window = window()?;
    let count = window.state().subject.as_ref().map_or(0, |s| s.lods.len());
    for lod in (0..count).rev() {
        let name = format!("LOD {lod}: ");
        window.get_by_label_contains(&name).click_accesskit();
        window.run_steps(2);
        let app = window.state();
        ensure(
            app.settings.choice == Choice::Fixed(lod),
            format!("LOD {lod} is not chosen"),
        )?;
        let triangles = app.subject.as_ref().map_or(0, |s| s.lods[lod].triangles);
        ensure(
            app.view.shown.triangles == triangles,
            format!("{:?}", app.view.shown),
        )?;
        window.get_by_label_contains(&format!("Shown: LOD {lod}, "));
    }
    click(&mut window, "LOD by distance");
    let near = window.state().view.shown.clone();
    window.state_mut().view.rig.zoom(30.0);
    window.run_steps(3);
    let far = window.state().view.shown.clone();
    ensure(
        far.triangles < near.triangles && far.part < near.part,
        format!("near {near:?}, far {far:?}"),
    )?;
    window.get_by_label_contains("The tree fills ");
    Ok(())
}

fn pictures() -> Outcome {
    let mut window = window()?;
    let mut before = seen(&mut window)?;
    for (view, name) in viewer::settings::VIEWS.into_iter().skip(1) {
        click(&mut window, name);
        ensure(window.state().settings.view == view, name)?;
        let now = seen(&mut window)?;
        ensure(
            differs(&before, &now),
            format!("{name} looks like the view before"),
        )?;
        before = now;
    }
    click(&mut window, "Lit");
    for (name, arrangement) in [
        ("LOD strip", Arrangement::Strip),
        ("Forest", Arrangement::Forest),
        ("One tree", Arrangement::Single),
    ] {
        click(&mut window, name);
        let app = window.state();
        ensure(app.settings.arrangement == arrangement, name)?;
        let trees: usize = app.view.shown.trees.iter().sum();
        let lods = app.subject.as_ref().map_or(0, |s| s.lods.len());
        let expected = match arrangement {
            Arrangement::Single => 1..=1,
            Arrangement::Strip => lods..=lods,
            // Those that are seen, twice where one LOD fades into another.
            Arrangement::Forest => 20..=app.settings.trees * 2,
        };
        ensure(expected.contains(&trees), format!("{name}: {trees} trees"))?;
        let now = seen(&mut window)?;
        ensure(
            differs(&before, &now),
            format!("{name} looks like what was before"),
        )?;
        before = now;
    }
    click(&mut window, "Light and filter");
    for name in ["Four factors", "Combined"] {
        click(&mut window, name);
        let now = seen(&mut window)?;
        ensure(differs(&before, &now), format!("{name} changes nothing"))?;
        before = now;
    }
    Ok(())
}

/// True if many pixels of the view, left of the panel, are others.
fn differs(a: &Image<[u8; 4]>, b: &Image<[u8; 4]>) -> bool {
    let far = |x: &[u8; 4], y: &[u8; 4]| (0..3).any(|c| x[c].abs_diff(y[c]) > 8);
    let mut others = 0;
    for y in 0..a.height() {
        for x in 0..290 {
            others += usize::from(far(a.at(x, y), b.at(x, y)));
        }
    }
    others > 300
}

fn sun_and_wind() -> Outcome {
    let mut window = window()?;
    let before = seen(&mut window)?;
    slide(&mut window, "Azimuth", 250.0);
    slide(&mut window, "Elevation", 12.0);
    let sun = window.state().settings.sun;
    ensure(
        (sun.azimuth, sun.elevation) == (250.0, 12.0),
        format!("{sun:?}"),
    )?;
    ensure(
        differs(&before, &seen(&mut window)?),
        "the sun changes nothing",
    )?;
    click(&mut window, "Wind blows");
    for (name, value) in [
        ("Direction", 90.0),
        ("Wind speed", 9.0),
        ("Gustiness", 0.25),
    ] {
        slide(&mut window, name, value);
    }
    let breeze = window.state().settings.breeze;
    ensure(breeze.on && breeze.time > 0.0, format!("{breeze:?}"))?;
    ensure(
        (breeze.direction, breeze.speed, breeze.gustiness) == (90.0, 9.0, 0.25),
        format!("{breeze:?}"),
    )?;
    click(&mut window, "Pause");
    let held = window.state().settings.breeze.time;
    window.run_steps(4);
    ensure(
        window.state().settings.breeze.time == held,
        "the clock goes on when it is held",
    )?;
    window.get_by_label("Play");
    let scene = window.state_mut().scene().ok_or("no scene")?;
    ensure(
        scene.wind.speed_m_s == 9.0 && scene.time == held,
        format!("{:?}", scene.wind),
    )?;
    click(&mut window, "Wind blows");
    let scene = window.state_mut().scene().ok_or("no scene")?;
    ensure(scene.wind.speed_m_s == 0.0, "wind that is off blows")
}

fn keys() -> Outcome {
    let mut window = window()?;
    press(&mut window, Key::H);
    window.get_by_label("Keys and mouse");
    window.get_by_label("walk, 1.7 m over the ground");
    press(&mut window, Key::Escape);
    ensure(
        window.query_by_label("Keys and mouse").is_none(),
        "Esc leaves the help open",
    )?;
    click(&mut window, "Help");
    click(&mut window, "Close help");
    ensure(
        !window.state().settings.help,
        "the help's button leaves it open",
    )?;
    press(&mut window, Key::V);
    ensure(window.state().settings.view == ViewMode::Lods, "V")?;
    press(&mut window, Key::Num2);
    ensure(window.state().settings.choice == Choice::Fixed(1), "2")?;
    press(&mut window, Key::Num0);
    ensure(window.state().settings.choice == Choice::ByDistance, "0")?;
    press(&mut window, Key::L);
    ensure(
        window.state().settings.arrangement == Arrangement::Strip,
        "L",
    )?;
    press(&mut window, Key::G);
    ensure(
        window.state().settings.arrangement == Arrangement::Forest,
        "G",
    )?;
    press(&mut window, Key::G);
    ensure(
        window.state().settings.arrangement == Arrangement::Single,
        "G again",
    )?;
    press(&mut window, Key::Space);
    ensure(window.state().settings.breeze.on, "space")?;
    press(&mut window, Key::Space);
    press(&mut window, Key::T);
    let turned = window.state().view.rig.orbit.azimuth;
    window.run_steps(3);
    ensure(window.state().view.rig.orbit.azimuth != turned, "T")?;
    press(&mut window, Key::T);
    let speed = window.state().view.rig.walker.speed;
    press(&mut window, Key::E);
    ensure(window.state().view.rig.walker.speed == speed * 2.0, "E")?;
    press(&mut window, Key::Q);
    ensure(window.state().view.rig.walker.speed == speed, "Q")?;
    let framed = window.state().view.rig.orbit.distance;
    window.state_mut().view.rig.zoom(0.2);
    press(&mut window, Key::F);
    let again = window.state().view.rig.orbit.distance;
    ensure(
        (again / framed - 1.0).abs() < 0.2,
        format!("F: {framed}, {again}"),
    )?;
    press(&mut window, Key::N);
    ensure(
        window.query_by_label("Wind blows").is_none(),
        "N leaves the panel",
    )
}

/// Drags from the middle of the view with a button held.
fn drag(window: &mut Window, button: PointerButton, modifiers: Modifiers, by: [f32; 2]) {
    window.event(Event::ModifiersChanged(modifiers));
    let pressed = |pos, pressed| Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers,
    };
    window.hover_at(MIDDLE);
    window.event(pressed(MIDDLE, true));
    window.step();
    for part in [0.3, 0.6, 1.0] {
        window.hover_at(MIDDLE + vec2(by[0], by[1]) * part);
        window.step();
    }
    window.event(pressed(MIDDLE + vec2(by[0], by[1]), false));
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run_steps(2);
}

fn mouse() -> Outcome {
    let mut window = window()?;
    let (rig, sun) = (window.state().view.rig, window.state().settings.sun);
    drag(
        &mut window,
        PointerButton::Primary,
        Modifiers::NONE,
        [60.0, 30.0],
    );
    let turned = window.state().view.rig;
    ensure(
        turned.orbit.azimuth < rig.orbit.azimuth && turned.orbit.elevation > rig.orbit.elevation,
        "a left drag does not orbit",
    )?;
    ensure(turned.orbit.target == rig.orbit.target, "a left drag pans")?;
    for button in [PointerButton::Secondary, PointerButton::Middle] {
        let before = window.state().view.rig.orbit;
        drag(&mut window, button, Modifiers::NONE, [40.0, 0.0]);
        let after = window.state().view.rig.orbit;
        ensure(
            after.target != before.target && after.azimuth == before.azimuth,
            format!("{button:?} does not pan"),
        )?;
    }
    ensure(
        window.state().settings.sun == sun,
        "the sun moves by itself",
    )?;
    let before = window.state().view.rig;
    drag(
        &mut window,
        PointerButton::Primary,
        Modifiers::COMMAND,
        [40.0, -40.0],
    );
    let after = window.state().settings.sun;
    ensure(
        after.azimuth != sun.azimuth && after.elevation > sun.elevation,
        format!("{sun:?}, then {after:?}"),
    )?;
    ensure(
        window.state().view.rig == before,
        "moving the sun moves the camera",
    )?;
    window.hover_at(MIDDLE);
    window.event(Event::MouseWheel {
        source: MouseWheelSource::Wheel,
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        phase: TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    window.run_steps(6);
    ensure(
        window.state().view.rig.orbit.distance < before.orbit.distance,
        "the wheel does not zoom",
    )
}

fn walking() -> Outcome {
    let mut window = window()?;
    let before = window.state().view.rig.camera().eye;
    window.key_down(Key::W);
    window.run_steps(4);
    window.key_up(Key::W);
    window.run_steps(2);
    let rig = window.state().view.rig;
    let after = rig.camera().eye;
    ensure(
        rig.stance == Stance::Walk && after.y == viewer::rig::EYE,
        format!("{rig:?}"),
    )?;
    let way = (after - before).with_y(0.0).length();
    ensure(way > 0.2, format!("walked {way} m"))?;
    let stood = window.state().view.rig;
    window.run_steps(3);
    ensure(
        window.state().view.rig == stood,
        "a key that is up walks on",
    )?;
    click(&mut window, "Orbit");
    ensure(
        window.state().view.rig.stance == Stance::Orbit,
        "the panel does not end the walk",
    )
}

fn hot_reload() -> Outcome {
    let dir = tempfile::tempdir()?;
    for name in ["palm.ron", "palm_trunk.spline"] {
        fs::copy(species_folder().join(name), dir.path().join(name))?;
    }
    let path = dir.path().join("palm.ron");
    let good = fs::read_to_string(&path)?;
    let source = Source::Script {
        path: path.clone(),
        settings: Box::new(small()),
    };
    let mut window = window_with(Start::new(source, PathBuf::from(".")), SIZE);
    until(&mut window, "a first tree", |app| app.subject.is_some())?;
    let first = window.state().subject.clone().ok_or("no tree")?;
    window.state_mut().view.rig.turn(0.3, 0.1);
    window.run_steps(2);
    let camera = window.state().view.rig;

    fs::write(&path, good.replacen("levels:", "levles:", 1))?;
    until(&mut window, "the fault", |app| app.fault().is_some())?;
    let kept = window.state().subject.clone().ok_or("no tree")?;
    ensure(Arc::ptr_eq(&first, &kept), "a fault takes the tree away")?;
    let fault = window.state().fault().unwrap_or_default().to_owned();
    ensure(
        fault.contains("levles")
            && fault.contains("did you mean `levels`")
            && fault.contains("-->"),
        fault.clone(),
    )?;
    window.get_by_label_contains("the last good tree is shown");
    window.get_by_label_contains("levles");

    // Mended, and another tree: in a file that the script names.
    let spline = dir.path().join("palm_trunk.spline");
    fs::write(
        &spline,
        fs::read_to_string(&spline)? + "\n# the same shape\n",
    )?;
    fs::write(&path, good.replacen("seed: ", "seed: 1", 1))?;
    until(&mut window, "the mended tree", |app| {
        app.fault().is_none() && !Arc::ptr_eq(app.subject.as_ref().unwrap_or(&first), &first)
    })?;
    ensure(
        window.query_by_label_contains("levles").is_none(),
        "the fault is still shown",
    )?;
    ensure(
        window.state().view.rig == camera,
        "a new tree moves the camera",
    )?;
    Ok(())
}

fn screenshot() -> Outcome {
    let dir = tempfile::tempdir()?;
    let start = Start::new(Source::Pack(palm().to_owned()), dir.path().to_owned());
    let mut window = window_with(start, SIZE);
    until(&mut window, "the palm", |app| app.subject.is_some())?;
    click(&mut window, "Screenshot");
    press(&mut window, Key::F12);
    let mut names: Vec<String> = fs::read_dir(dir.path())?
        .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
        .collect::<Result<_, std::io::Error>>()?;
    names.sort();
    let slug = window
        .state()
        .subject
        .as_ref()
        .map_or("", |s| &s.slug)
        .to_owned();
    let expected = [format!("{slug}-001.png"), format!("{slug}-002.png")];
    ensure(names == expected, format!("{names:?}"))?;
    let said = window.state().message().unwrap_or_default().to_owned();
    ensure(said.contains(&expected[1]), said)?;
    let picture = png::decode(&fs::read(dir.path().join(&names[0]))?, 1 << 24)?;
    let size = window.state().view.size;
    ensure(
        [picture.width(), picture.height()] == size,
        format!("{size:?}"),
    )?;
    ensure(
        picture.texels().iter().all(|p| p[3] == 255),
        "it is see-through",
    )?;
    let rect = window.get_by_role(Role::Canvas).rect();
    let [x, y] = [rect.left(), rect.top()].map(pleach::math::round_to_u32);
    // Without what is written over the view at its upper and lower edge.
    let part = [0, 60, size[0], size[1] - 120];
    let [u, v, width, height] = part;
    let shown = seen(&mut window)?.part(x + u, y + v, width, height);
    let error = mean_flip(&shown, &picture.part(u, v, width, height));
    ensure(
        error < 0.02,
        format!("the screenshot is not what is shown: mean FLIP {error}"),
    )
}

fn rest() -> Outcome {
    let mut window = window()?;
    window.run_steps(4);
    let drawn = window.state().view.frames.drawn();
    for step in 0..8_u8 {
        // The mouse alone moves nothing.
        window.hover_at(MIDDLE + vec2(f32::from(step) * 5.0, 0.0));
        window.step();
    }
    ensure(
        window.state().view.frames.drawn() == drawn,
        "pictures are drawn at rest",
    )?;
    // The window's own loop comes to an end: nothing asks to be drawn for ever.
    window.try_run().map_err(|e| e.to_string())?;
    window.state_mut().view.rig.turn(0.1, 0.0);
    window.step();
    ensure(
        window.state().view.frames.drawn() > drawn,
        "a turn is not drawn",
    )
}

fn no_room() -> Outcome {
    let mut window = window()?;
    for size in [
        [256.0, 900.0],
        [100.0, 40.0],
        [0.0, 0.0],
        [257.0, 2.0],
        SIZE,
    ] {
        window.set_size(vec2(size[0], size[1]));
        window.run_steps(3);
        let app = window.state();
        ensure(
            app.fault().is_none() && !app.is_lost(),
            format!("{size:?}: {:?}", app.fault()),
        )?;
    }
    seen(&mut window)?;
    Ok(())
}

fn lost_while_loading() -> Outcome {
    let legacy = Legacy::default();
    let start = Start {
        legacy: legacy.clone(),
        ..Start::new(Source::Pack(palm().to_owned()), PathBuf::from("."))
    };
    let mut window = window_with(start, SIZE);
    // Before the thread that reads the pack puts it on the device: it is the first to be told.
    window.state().view.destroy_device();
    until(&mut window, "the end", App::is_lost)?;
    let left = legacy.lock().map_err(|e| e.to_string())?.is_some();
    ensure(left, "nothing is left for the next window")
}

fn lost() -> Outcome {
    let legacy = Legacy::default();
    let start = Start {
        legacy: Arc::clone(&legacy),
        ..Start::new(Source::Pack(palm().to_owned()), PathBuf::from("."))
    };
    let mut window = window_with(start, SIZE);
    until(&mut window, "the palm", |app| app.subject.is_some())?;
    window.state_mut().settings.view = ViewMode::Normals;
    window.state_mut().view.rig.turn(0.2, 0.1);
    window.state().view.destroy_device();
    window.state_mut().view.rig.turn(0.2, 0.1);
    window.run_steps(3);
    ensure(
        window.state().is_lost(),
        format!("{:?}", window.state().fault()),
    )?;
    let kept = legacy
        .lock()
        .map_err(|e| e.to_string())?
        .clone()
        .ok_or("nothing is left")?;
    ensure(kept.reason.contains("lost"), kept.reason.clone())?;
    // The next window goes on from there, and says why.
    let start = Start {
        kept: Some(kept.clone()),
        ..Start::new(Source::Pack(palm().to_owned()), PathBuf::from("."))
    };
    let mut next = window_with(start, SIZE);
    until(&mut next, "the palm", |app| app.subject.is_some())?;
    ensure(next.state().view.rig == kept.rig, "the camera is another")?;
    ensure(
        next.state().settings.view == ViewMode::Normals,
        "the settings are others",
    )?;
    ensure(
        next.state().message() == Some(kept.reason.as_str()),
        "nobody says why",
    )
}

/// Most bytes of a picture that tests compare with.
const MOST_BYTES: u64 = 64 << 10;

fn looks() -> Outcome {
    let start = Start::new(Source::Pack(palm().to_owned()), PathBuf::from("."));
    let mut window = window_with(start, [400.0, 260.0]);
    until(&mut window, "the palm", |app| app.subject.is_some())?;
    // Until it rests and is drawn in full, on a busy machine too.
    for _ in 0..24 {
        window.run_steps(1);
        std::thread::sleep(Duration::from_millis(20));
    }
    let picture = seen(&mut window)?.part(0, 0, 400, 200);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/window.png");
    if std::env::var_os("UPDATE_GOLDENS").is_some() {
        fs::write(&path, png::encode(&picture).map_err(|e| e.to_string())?)?;
    }
    let bytes = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    ensure(
        bytes.len() as u64 <= MOST_BYTES,
        format!("{} bytes", bytes.len()),
    )?;
    let error = mean_flip(&png::decode(&bytes, 1 << 20)?, &picture);
    if error <= 0.03 {
        return Ok(());
    }
    let seen = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/window.png");
    fs::write(&seen, png::encode(&picture).map_err(|e| e.to_string())?)?;
    Err(format!(
        "mean FLIP {error:.4} from {}; the picture is in {}; if it is right, run again with UPDATE_GOLDENS=1",
        path.display(),
        seen.display()
    )
    .into())
}

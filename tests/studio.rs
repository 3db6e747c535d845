//! The studio, driven by what its widgets are called, without a screen. Without a graphics adapter, these tests
//! show as ignored; with `PLEACH_REQUIRE_GPU=1` that is a failure.

mod common;
mod studio_manners;

use common::adapter::{self, Outcome};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, vec2};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use libtest_mimic::Failed;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::{self, NoFiles};
use pleach::studio::document::Document;
use pleach::studio::{Begin, Studio, recovery, templates};
use pleach::{pack, viewer};
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    adapter::run(&[
        ("a_tree_of_ones_own_is_made_saved_and_exported", own_tree),
        ("levels_are_added_copied_moved_and_deleted", levels),
        ("a_fault_in_the_script_keeps_the_last_tree", faults),
        ("what_a_killed_window_had_is_recovered", killed),
        (
            "changes_of_the_file_outside_are_taken_merged_or_asked_about",
            outside,
        ),
        ("leaving_something_unsaved_is_asked_about", unsaved),
        ("every_template_shows_all_its_pages", pages),
        (
            "a_sketch_follows_the_hand_and_the_whole_tree_comes_after",
            sketches,
        ),
        ("the_atlas_and_the_shadows_are_shown_and_named", pictures),
        (
            "a_script_is_opened_from_the_list_of_its_folder",
            studio_manners::browsing,
        ),
        (
            "saving_over_another_file_is_asked_about",
            studio_manners::replacing,
        ),
        (
            "variations_are_exported_as_the_library_makes_them",
            studio_manners::variations,
        ),
        (
            "an_export_that_is_cancelled_leaves_no_part_of_a_pack",
            studio_manners::cancelling,
        ),
        (
            "the_palette_finds_and_runs_a_command",
            studio_manners::palette,
        ),
        (
            "looks_hints_and_recent_files_are_kept_over_a_restart",
            studio_manners::kept,
        ),
        (
            "dropped_pictures_become_those_of_the_page_that_is_shown",
            studio_manners::dropped,
        ),
    ])
}

type Window = Harness<'static, Studio>;

/// Longest that a tree may take to grow.
const PATIENCE: Duration = Duration::from_secs(120);

fn window(begin: Begin) -> Window {
    let state = create_render_state(viewer::setup(), RendererOptions::PREDICTABLE);
    let studio = Studio::new(&state, begin, || ()).expect("the window begins");
    Harness::builder()
        .with_size(vec2(1280.0, 720.0))
        .with_max_steps(64)
        .with_context_setup(viewer::panel::style)
        .renderer(WgpuTestRenderer::from_render_state(state))
        .build_ui_state(|ui, studio: &mut Studio| studio.ui(ui), studio)
}

fn on(text: &str) -> Window {
    window(Begin::new(Document::new(text.to_owned())))
}

/// Lets the window run until something is so.
fn until(window: &mut Window, what: &str, so: impl Fn(&Studio) -> bool) -> Outcome {
    let begun = Instant::now();
    while !so(window.state()) {
        if begun.elapsed() > PATIENCE {
            let message = window.state().message().map(str::to_owned);
            return Err(format!("waited in vain for {what}; it says {message:?}").into());
        }
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    window.run_steps(2);
    Ok(())
}

fn click(window: &mut Window, label: &str) {
    let nodes: Vec<_> = window.get_all_by_label(label).collect();
    nodes[0].click_accesskit();
    drop(nodes);
    window.run_steps(3);
}

fn set(window: &mut Window, label: &str, value: f64) {
    let field = window.get_by_role_and_label(Role::SpinButton, label);
    field.set_value_accesskit(value);
    window.run_steps(3);
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(3);
}

fn text(window: &Window) -> &str {
    window.state().document().text()
}

/// Undoes all that was done.
fn undo_all(window: &mut Window) {
    while window.state().document().history().undoable().is_some() {
        press(window, Modifiers::COMMAND, Key::Z);
    }
}

fn own_tree() -> Outcome {
    let dir = tempfile::tempdir()?;
    let mut begin = Begin::new(Document::new(templates::BLANK.to_owned()));
    begin.out = dir.path().join("packs");
    let mut window = window(begin);
    click(&mut window, "limbs");
    set(&mut window, "links", 9.0);
    assert!(
        text(&window).contains("name: \"limbs\", links: 9,"),
        "{}",
        text(&window)
    );
    set(&mut window, "tropism", 0.25);
    assert!(text(&window).contains("tropism: 0.25"), "{}", text(&window));
    click(&mut window, "Leave out tropism");
    assert!(!text(&window).contains("tropism"));
    click(&mut window, "trunk");
    click(&mut window, "Add flare");
    assert!(text(&window).contains("flare: (height_m: 1, amount: 0.5)"));
    // The comment that heads the script is still there.
    assert!(text(&window).starts_with(templates::BLANK.lines().next().unwrap_or("?")));
    let made = text(&window).to_owned();
    undo_all(&mut window);
    assert_eq!(text(&window), templates::BLANK);
    while window.state().document().history().redoable().is_some() {
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!(text(&window), made);

    let path = dir.path().join("my_tree.ron");
    save_as(&mut window, &path)?;
    assert_eq!(fs::read_to_string(&path)?, made);
    assert!(!window.state().document().is_unsaved());

    until(&mut window, "the tree", |s| s.subject().is_some())?;
    press(&mut window, Modifiers::COMMAND, Key::E);
    click(&mut window, "Export");
    let pack = dir.path().join("packs/my-tree-1");
    until(&mut window, "the pack", |_| pack.join("pack.json").exists())?;
    // The same as the program makes of the same script.
    let species = species::parse("my_tree.ron", &made, &NoFiles).expect("no faults");
    let asset = pipeline::generate(&species, &Settings::default(), &NoFiles, &Quiet)?;
    for file in pack::build(&asset, made.as_bytes(), pack::Options::default())? {
        assert!(
            fs::read(pack.join(&file.path))? == file.bytes,
            "{}",
            file.path
        );
    }
    let again = Document::open(&path)?;
    assert_eq!(again.text(), made);
    picture(&mut window, "own_tree")
}

fn save_as(window: &mut Window, path: &Path) -> Outcome {
    press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    window
        .get_by_role_and_label(Role::TextInput, "Save as")
        .focus();
    window.run_steps(2);
    press(window, Modifiers::COMMAND, Key::A);
    window
        .get_by_role_and_label(Role::TextInput, "Save as")
        .type_text(&path.display().to_string());
    window.run_steps(2);
    click(window, "Save");
    Ok(())
}

fn levels() -> Outcome {
    let mut window = on(templates::BLANK);
    click(&mut window, "Add branches");
    let places = ["\"limbs\", links", "\"branches\"", "\"leaves\""].map(|p| text(&window).find(p));
    assert!(
        places.is_sorted() && places[0].is_some(),
        "{}",
        text(&window)
    );
    assert!(window.state().document().reading().species.is_ok());
    click(&mut window, "Move branches up");
    let places = ["\"branches\"", "\"limbs\", links", "\"leaves\""].map(|p| text(&window).find(p));
    assert!(
        places.is_sorted() && places[0].is_some(),
        "{}",
        text(&window)
    );
    click(&mut window, "Duplicate branches");
    assert!(text(&window).contains("\"branches2\""), "{}", text(&window));
    click(&mut window, "Delete branches2");
    assert!(!text(&window).contains("branches2"));
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    undo_all(&mut window);
    assert_eq!(text(&window), templates::BLANK);
    Ok(())
}

fn faults() -> Outcome {
    let mut window = on(templates::BLANK);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let field = window.get_by_role_and_label(Role::MultilineTextInput, "Script");
    field.focus();
    window.run_steps(2);
    window
        .get_by_role_and_label(Role::MultilineTextInput, "Script")
        .type_text("?");
    window.run_steps(3);
    assert_eq!(
        text(&window).len(),
        templates::BLANK.len() + 1,
        "{}",
        text(&window)
    );
    assert!(window.state().document().reading().species.is_err());
    assert!(
        window.state().subject().is_none(),
        "the tree is not the text's"
    );
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK);
    until(&mut window, "the tree again", |s| s.subject().is_some())
}

fn killed() -> Outcome {
    let dir = tempfile::tempdir()?;
    let (script, notes) = (dir.path().join("a.ron"), dir.path().join("notes"));
    fs::write(&script, templates::BLANK)?;
    let begin = || -> Result<Begin, Failed> {
        Ok(Begin {
            notes: Some(notes.clone()),
            left: recovery::left(&notes),
            ..Begin::new(Document::open(&script)?)
        })
    };
    let mut window = window_at(begin()?);
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    let unsaved = text(&window).to_owned();
    assert!(recovery::left(&notes).is_empty(), "its window is open");
    drop(window);
    let mut window = window_at(begin()?);
    assert_eq!(text(&window), templates::BLANK);
    click(&mut window, "Recover");
    assert_eq!(text(&window), unsaved);
    assert_eq!(window.state().document().path(), Some(&*script));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert_eq!(fs::read_to_string(&script)?, unsaved);
    drop(window);
    assert!(recovery::left(&notes).is_empty(), "nothing is unsaved");
    let untouched = window_at(Begin {
        notes: Some(notes.clone()),
        ..Begin::new(Document::new(templates::BLANK.to_owned()))
    });
    drop(untouched);
    assert!(recovery::left(&notes).is_empty(), "nothing was done");
    Ok(())
}

fn window_at(begin: Begin) -> Window {
    let mut window = window(begin);
    window.run_steps(2);
    window
}

fn outside() -> Outcome {
    let dir = tempfile::tempdir()?;
    let script = dir.path().join("a.ron");
    fs::write(&script, templates::BLANK)?;
    let mut window = window_at(Begin::new(Document::open(&script)?));
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let seven = templates::BLANK.replace("length_m: 6", "length_m: 7.25");
    fs::write(&script, &seven)?;
    until(&mut window, "the file", |s| s.document().text() == seven)?;
    assert!(!window.state().document().is_unsaved());
    // Both changed, in different places.
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let named = seven.replace("My tree", "Your tree");
    fs::write(&script, &named)?;
    let both = named.replace("links: 18", "links: 5");
    until(&mut window, "both changes", |s| s.document().text() == both)?;
    // Both changed, at one place.
    fs::write(&script, named.replace("links: 18", "links: 30"))?;
    let begun = Instant::now();
    while window.query_by_label("Keep this one").is_none() {
        assert!(begun.elapsed() < PATIENCE, "it is not asked");
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    click(&mut window, "Keep this one");
    assert_eq!(text(&window), both);
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert_eq!(fs::read_to_string(&script)?, both);
    Ok(())
}

fn unsaved() -> Outcome {
    let mut window = on(templates::BLANK);
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    let changed = text(&window).to_owned();
    new_blank(&mut window);
    click(&mut window, "Cancel");
    assert_eq!(text(&window), changed);
    new_blank(&mut window);
    click(&mut window, "Discard");
    assert_eq!(text(&window), templates::BLANK);
    Ok(())
}

fn new_blank(window: &mut Window) {
    for label in ["File", "New", "Blank"] {
        window.get_by_label_contains(label).click();
        window.run_steps(4);
    }
}

fn pages() -> Outcome {
    for (name, script) in templates::ALL.iter().filter(|(name, _)| {
        [
            "English oak",
            "Canary date palm",
            "Norway spruce",
            "Weeping willow",
        ]
        .contains(name)
    }) {
        let mut window = on(script);
        window.run_steps(2);
        let root = window
            .state()
            .document()
            .reading()
            .root
            .clone()
            .expect("a tree of values");
        let pages = pleach::studio::outline::pages(&root);
        let titles: Vec<String> = pages.iter().map(|p| p.title.clone()).collect();
        for title in titles {
            let mut found = window.get_all_by_label(&title);
            found.next().expect("a page").click_accesskit();
            drop(found);
            window.run_steps(2);
            assert_eq!(
                text(&window),
                *script,
                "{name}: looking at {title} changes nothing"
            );
        }
    }
    Ok(())
}

fn sketches() -> Outcome {
    let (_, oak) = templates::ALL
        .iter()
        .find(|(name, _)| *name == "English oak")
        .expect("an oak");
    let mut window = on(oak);
    until(&mut window, "the sketch", Studio::is_up_to_date)?;
    // A full tree takes seconds: what is shown has come before it.
    assert!(window.state().subject().is_none(), "it was no sketch");
    click(&mut window, "limbs");
    set(&mut window, "links", 9.0);
    assert!(!window.state().is_up_to_date());
    until(&mut window, "the next sketch", Studio::is_up_to_date)?;
    assert!(window.state().subject().is_none(), "it was no sketch");
    until(&mut window, "the whole tree", |s| s.subject().is_some())?;
    let lods = window.state().subject().map_or(0, |s| s.lods.len());
    assert!(lods > 2, "{lods} LODs");
    Ok(())
}

fn pictures() -> Outcome {
    let mut window = on(templates::BLANK);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    for (tab, shown) in [("Atlas", "Foliage atlas"), ("Shadows", "Nine shadows")] {
        assert!(window.query_by_label(shown).is_none());
        window.get_by_label(tab).click();
        window.run_steps(4);
        let place = window.get_by_label(shown).rect();
        assert!(place.width() > 100.0, "{place:?}");
        picture(&mut window, tab)?;
    }
    // The first part is the last level's sub-tree, or a branch's.
    window.get_by_label("Atlas").click();
    window.run_steps(4);
    let corner = window.get_by_label("Foliage atlas").rect().min;
    window.hover_at(corner + vec2(8.0, 8.0));
    window.run_steps(4);
    let named = window.query_all_by_label_contains("texels").count();
    assert_eq!(named, 1);
    picture(&mut window, "atlas_named")
}

/// Writes the window as a picture where `STUDIO_PICTURES` says, to be looked at.
fn picture(window: &mut Window, name: &str) -> Outcome {
    let picture = window.render()?;
    if let Some(folder) = std::env::var_os("STUDIO_PICTURES") {
        picture.save(Path::new(&folder).join(format!("{name}.png")))?;
    }
    Ok(())
}

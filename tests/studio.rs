//! The studio, driven by what its widgets are called, without a screen. Without a graphics adapter, these tests
//! show as ignored; with `PLEACH_REQUIRE_GPU=1` that is a failure.

mod common;
mod studio_hands;
mod studio_looks;
mod studio_manners;
mod studio_view;

use common::adapter::{self, Outcome};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers, vec2};
use eframe::egui_wgpu::RendererOptions;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state};
use libtest_mimic::Failed;
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::{self, NoFiles};
use pleach::studio::document::Document;
use pleach::studio::{Begin, Studio, recovery, templates};
use pleach::viewer::split;
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
        ("a_tree_is_chosen_and_kept_from_a_grid_of_seeds", seeds),
        ("a_spline_is_edited_by_hand_and_by_numbers", splines),
        ("leaf_and_bark_are_seen_from_near", near),
        ("pointing_at_a_field_draws_what_it_does", drawings),
        (
            "what_is_clicked_in_the_picture_is_selected",
            studio_view::picks,
        ),
        (
            "handles_in_the_picture_change_a_level",
            studio_view::handles,
        ),
        ("the_envelope_is_dragged_in_the_picture", studio_view::crown),
        (
            "levels_of_a_large_tree_are_shown_in_the_picture",
            studio_view::oak,
        ),
        (
            "captures_of_sketches_are_whose_they_are_asked_of",
            studio_view::bakers,
        ),
        ("lods_are_measured_and_their_budgets_changed", lods),
        ("two_lods_are_compared_beside_a_line", compared),
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
        ("what_is_being_typed_is_saved", studio_manners::typing),
        (
            "a_file_that_was_changed_just_now_is_not_replaced_unasked",
            studio_manners::outran,
        ),
        (
            "of_two_texts_that_were_left_none_is_lost",
            studio_manners::both_left,
        ),
        (
            "panels_look_as_they_did_in_both_themes",
            studio_looks::panels,
        ),
        (
            "points_of_a_spline_are_moved_in_the_picture",
            studio_view::spline,
        ),
        (
            "the_ring_about_a_branch_makes_it_thicker",
            studio_hands::ring,
        ),
        ("the_top_of_an_envelope_is_raised", studio_hands::top),
        (
            "points_in_a_file_are_brought_into_the_script",
            studio_hands::file,
        ),
        (
            "panes_stand_where_they_were_put_until_they_are_reset",
            studio_hands::layout,
        ),
        (
            "no_two_fields_of_a_page_are_called_the_same",
            studio_hands::names,
        ),
        ("levels_have_colours_with_names", studio_hands::colours),
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
    // By the mouse, to the upper half of the limbs, and back, and by a button.
    drag(&mut window, "branches", "limbs");
    assert!(text(&window).find("\"branches\"") < text(&window).find("\"limbs\", links"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    click(&mut window, "branches");
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

/// Drags the row of one part to the upper edge of another's.
fn drag(window: &mut Window, from: &str, to: &str) {
    let place = |window: &Window, label| {
        let rows: Vec<_> = window.get_all_by_label(label).collect();
        rows[0].rect()
    };
    window.drag_at(place(window, from).center());
    window.run_steps(2);
    let to = place(window, to);
    for part in [0.5, 0.3, 0.2] {
        window.hover_at(to.left_top() + vec2(20.0, to.height() * part));
        window.run_steps(2);
    }
    window.drop_at(to.left_top() + vec2(20.0, to.height() * 0.2));
    window.run_steps(3);
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
    until(&mut window, "captures and shadows", Studio::is_furnished)?;
    assert!(
        window.state().subject().is_none(),
        "they come before the LODs"
    );
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

fn seeds() -> Outcome {
    let mut window = on(templates::BLANK);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    window.get_by_label("Seeds").click();
    window.run_steps(4);
    until(&mut window, "sixteen trees", Studio::has_all_seeds)?;
    picture(&mut window, "seeds")?;
    click(&mut window, "Take seed 5");
    assert!(text(&window).contains("seed: 5,"), "{}", text(&window));
    // The pictures are still those of the species.
    assert!(window.state().has_all_seeds());
    click(&mut window, "Keep seed 7");
    let kept = "(name: \"kept\", seed: 7)";
    assert!(text(&window).contains(kept), "{}", text(&window));
    click(&mut window, "Keep seed 9");
    assert!(text(&window).contains("(name: \"kept2\", seed: 9)"));
    assert!(window.query_by_label("Keep seed 9").is_none(), "it is kept");
    assert!(window.state().document().reading().species.is_ok());
    click(&mut window, "later");
    assert!(window.query_by_label("Take seed 17").is_some());
    undo_all(&mut window);
    assert_eq!(text(&window), templates::BLANK);
    Ok(())
}

fn splines() -> Outcome {
    let mut window = on(templates::BLANK);
    click(&mut window, "limb");
    let before = text(&window).to_owned();
    set(&mut window, "x of point 1", 0.25);
    assert!(
        text(&window).contains("(0.25, 1, 0.1)"),
        "{}",
        text(&window)
    );
    click(&mut window, "Add a point after 1");
    click(&mut window, "Take away point 0");
    assert!(window.state().document().reading().species.is_ok());
    undo_all(&mut window);
    assert_eq!(text(&window), before);
    // By hand: the tip is dragged aside.
    let view = window.get_by_label("Spline from the front").rect();
    let tip = window
        .state()
        .document()
        .reading()
        .species
        .as_ref()
        .map(|s| s.splines[1].points.clone());
    let tip = tip.expect("no faults");
    let last = tip[tip.len() - 1];
    let scale = view.height() / (last[1] * 1.16);
    let at = view.center_bottom() - vec2(0.0, (last[1] * 1.06) * scale);
    window.drag_at(at);
    window.run_steps(2);
    window.hover_at(at + vec2(20.0, 0.0));
    window.run_steps(2);
    window.drop_at(at + vec2(20.0, 0.0));
    window.run_steps(2);
    let dragged = window
        .state()
        .document()
        .reading()
        .species
        .as_ref()
        .map(|s| s.splines[1].points.clone());
    let dragged = dragged.expect("no faults");
    assert!(dragged[dragged.len() - 1][0] > 0.05, "{dragged:?}");
    picture(&mut window, "spline")?;
    // One step for the whole way.
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), before);
    Ok(())
}

fn near() -> Outcome {
    let (_, oak) = templates::ALL
        .iter()
        .find(|(name, _)| *name == "English oak")
        .expect("an oak");
    let mut window = on(oak);
    until(&mut window, "the sketch", Studio::is_up_to_date)?;
    click(&mut window, "Bark");
    let place = window.get_by_label("From near").rect();
    assert!(place.width() > 80.0, "{place:?}");
    picture(&mut window, "bark")?;
    click(&mut window, "normals");
    let root = window.state().document().reading().root.clone();
    let pages = pleach::studio::outline::pages(&root.expect("values"));
    let leaf = pages.iter().find(|p| p.path == "leaves.0").expect("a leaf");
    click(&mut window, &leaf.title);
    click(&mut window, "from behind");
    picture(&mut window, "leaf")?;
    assert_eq!(text(&window), *oak, "looking changes nothing");
    Ok(())
}

fn drawings() -> Outcome {
    let mut window = on(templates::BLANK);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    click(&mut window, "limbs");
    let links = window
        .get_by_role_and_label(Role::Label, "links")
        .rect()
        .center();
    window.hover_at(links);
    let begun = Instant::now();
    while window.query_by_label("27").is_none() || begun.elapsed() < Duration::from_secs(2) {
        assert!(begun.elapsed() < PATIENCE, "nothing is drawn");
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    // Half as many, as many, and half as many again.
    for caption in ["9", "18", "27"] {
        assert!(window.query_all_by_label(caption).count() > 0, "{caption}");
    }
    picture(&mut window, "drawings")?;
    assert_eq!(text(&window), templates::BLANK, "looking changes nothing");
    Ok(())
}

/// Writes the window as a picture where `STUDIO_PICTURES` says, to be looked at.
fn picture(window: &mut Window, name: &str) -> Outcome {
    let picture = window.render()?;
    if let Some(folder) = std::env::var_os("STUDIO_PICTURES") {
        picture.save(Path::new(&folder).join(format!("{name}.png")))?;
    }
    Ok(())
}

/// Opens the pane of LODs and waits for all that is in it.
fn judged(window: &mut Window) -> Outcome {
    let shown = |window: &Window| {
        window
            .query_by_label("quick: 6 views at 128 to 16 px")
            .is_some()
    };
    let begun = Instant::now();
    while !shown(window) {
        if begun.elapsed() > PATIENCE {
            return Err("waited in vain for figures".into());
        }
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    window.run_steps(4);
    Ok(())
}

/// Budgets of the LODs of the last whole tree.
fn budgets(studio: &Studio) -> Vec<Option<u64>> {
    let lods = studio.subject().map(|subject| &subject.lods);
    lods.into_iter().flatten().map(|lod| lod.budget).collect()
}

fn lods() -> Outcome {
    let mut window = on(templates::BLANK);
    window.get_by_label("LODs").click();
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let made = budgets(window.state());
    assert!(made.contains(&Some(2_000)), "{made:?}");
    judged(&mut window)?;
    picture(&mut window, "lods")?;
    assert_eq!(text(&window), templates::BLANK, "looking changes nothing");
    // A part of the silhouette for each LOD, and none for a rival.
    let figures = |window: &Window| window.query_all_by_label_contains("0.").count();
    assert!(figures(&window) >= 2 * made.len(), "{}", figures(&window));

    set(&mut window, "Budget 2", 900.0);
    assert!(
        text(&window).contains("lod: (budgets: [10000, 900, 400, 8])"),
        "{}",
        text(&window)
    );
    picture(&mut window, "lods_stale")?;
    until(&mut window, "the new chain", |s| {
        budgets(s).contains(&Some(900))
    })?;
    judged(&mut window)?;
    // Budgets fall: what is beyond a neighbour ends before it.
    set(&mut window, "Budget 2", 50_000.0);
    assert!(
        text(&window).contains("[10000, 9999, 400, 8]"),
        "{}",
        text(&window)
    );
    click(&mut window, "Add a budget after 2");
    click(&mut window, "Remove budget 5");
    window.get_by_label("Try Branches earlier").scroll_to_me();
    window.run_steps(8);
    picture(&mut window, "lods_lower")?;
    click(&mut window, "Try Branches earlier");
    assert!(
        text(&window).contains("priorities: [Branches, Splines, Levels]"),
        "{}",
        text(&window)
    );
    // By the mouse: the first onto the last.
    let place = |window: &Window, label: &str| window.get_by_label(label).rect().center();
    let [from, to] = ["Branches, place 1 of 3", "Levels, place 3 of 3"].map(|l| place(&window, l));
    window.drag_at(from);
    window.run_steps(2);
    window.hover_at(from + vec2(20.0, 2.0));
    window.run_steps(2);
    window.hover_at(to);
    window.run_steps(2);
    picture(&mut window, "lods_dragged")?;
    window.drop_at(to);
    window.run_steps(3);
    assert!(
        text(&window).contains("priorities: [Splines, Levels, Branches]"),
        "{}",
        text(&window)
    );
    let species = &window.state().document().reading().species;
    let found = species.as_ref().map(|s| s.lod.budgets.clone());
    assert_eq!(found.ok(), Some(vec![10_000, 9_999, 1_999, 400]));
    undo_all(&mut window);
    assert_eq!(text(&window), templates::BLANK);
    until(&mut window, "the first chain", |s| budgets(s) == made)
}

fn compared() -> Outcome {
    let mut window = on(templates::BLANK);
    window.get_by_label("LODs").click();
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    judged(&mut window)?;
    let last = budgets(window.state()).len() - 1;
    click(&mut window, &format!("Show LOD {last}"));
    let line = |window: &Window| -> Option<f64> {
        let line = window.query_by_label(split::NAME);
        line.and_then(|line| line.accesskit_node().numeric_value())
    };
    assert_eq!(line(&window), None);
    click(&mut window, "Compare with the finest LOD");
    assert_eq!(line(&window), Some(0.5));
    picture(&mut window, "compared")?;
    window.get_by_label(split::NAME).focus();
    window.run_steps(2);
    for _ in 0..5 {
        press(&mut window, Modifiers::NONE, Key::ArrowLeft);
    }
    let moved = line(&window).expect("a line");
    assert!((moved - 0.4).abs() < 1e-3, "{moved}");
    // By the mouse, and no further than the view.
    let at = window.get_by_label(split::NAME).rect().center();
    window.drag_at(at);
    window.run_steps(2);
    window.hover_at(at + vec2(90.0, 30.0));
    window.run_steps(2);
    let dragged = line(&window).expect("a line");
    assert!(dragged > moved + 0.05, "{dragged}");
    picture(&mut window, "compared_dragged")?;
    window.hover_at(at - vec2(2_000.0, 0.0));
    window.run_steps(2);
    window.drop_at(at - vec2(2_000.0, 0.0));
    window.run_steps(2);
    assert_eq!(line(&window), Some(0.0));
    window.get_by_label(split::NAME).set_value_accesskit(0.75);
    window.run_steps(2);
    assert_eq!(line(&window), Some(0.75));
    click(&mut window, "Compare with the finest LOD");
    assert_eq!(line(&window), None);
    Ok(())
}

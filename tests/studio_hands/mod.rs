//! What hands do since panes can be moved: layouts, rings, tops, splines from files, names of widgets.

use super::studio_manners::{has, on_file, write};
use super::studio_view::{drag, drop_at, grown, handle, wait};
use super::*;
use eframe::egui::Pos2;
use pleach::species::fields::SPECIES;
use pleach::studio::kept::Keeper;
use std::collections::BTreeMap;

/// A number of the script behind some words.
fn number(window: &Window, behind: &str) -> f64 {
    let rest = text(window).split(behind).nth(1).unwrap_or_default();
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
    rest[..end.unwrap_or(0)].parse().unwrap_or(f64::NAN)
}

/// The ring about a branch is drawn wider, by the mouse and by keys.
pub(super) fn ring() -> Outcome {
    let mut window = grown(templates::BLANK)?;
    click(&mut window, "limb");
    wait(&mut window, "the ring", |w| {
        handle(w, "Radius at point 1").is_some()
    })?;
    let field = "radius_of_parent: ";
    let before = number(&window, field);
    assert!(before > 0.0, "{}", text(&window));
    let at = handle(&window, "Radius at point 1").expect("it is there");
    window.hover_at(at);
    wait(&mut window, "what it means", |w| {
        has(w, "all limbs get as much thicker")
    })?;
    picture(&mut window, "ring")?;
    let by = vec2(6.0, 0.0);
    drag(&mut window, at, by);
    picture(&mut window, "ring_dragged")?;
    drop_at(&mut window, at + by);
    let wide = number(&window, field);
    assert!(wide > 1.2 * before, "{wide} after {before}");
    let held = handle(&window, "Radius at point 1").expect("it is there");
    // A limb gets no thicker than the trunk that bears it lets it.
    assert!(held.x > at.x + 1.0, "{held} from {at}");
    // The tree that follows is as thick as the ring told.
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    window.run_steps(4);
    picture(&mut window, "ring_grown")?;
    let undoable = window.state().document().history().undoable();
    assert_eq!(undoable, Some("Set radius of parent"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK, "it was more than one step");
    until(&mut window, "the tree", Studio::is_up_to_date)?;

    window
        .get_by_role_and_label(Role::Slider, "Radius at point 1")
        .focus();
    window.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    let nudged = number(&window, field);
    assert!((nudged / before - 1.02).abs() < 0.005, "{nudged}");
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    assert!(number(&window, field) < nudged);
    undo_all(&mut window);
    // The ring goes where the hand was last.
    window
        .get_by_role_and_label(Role::Button, "Point 2 of limb")
        .focus();
    wait(&mut window, "the other ring", |w| {
        handle(w, "Radius at point 2").is_some()
    })?;
    // The trunk's own radius is in metres.
    let splines: Vec<_> = window.get_all_by_label("trunk").collect();
    splines[splines.len() - 1].click_accesskit();
    drop(splines);
    wait(&mut window, "the trunk's ring", |w| {
        handle(w, "Radius at point 2").is_some()
    })?;
    let at = handle(&window, "Radius at point 2").expect("it is there");
    drag(&mut window, at, by);
    drop_at(&mut window, at + by);
    assert!(number(&window, "radius_m: ") > 0.15, "{}", text(&window));
    assert_eq!(
        window.state().document().history().undoable(),
        Some("Set radius")
    );
    Ok(())
}

/// The top of an envelope is raised and lowered.
pub(super) fn top() -> Outcome {
    let envelope = "envelope: (height_m: 7, radius_m: [(0.2, 1), (0.5, 2.2), (1, 0.3)])";
    let script = templates::BLANK.replace("start: 0.3,", &format!("start: 0.3, {envelope},"));
    let mut window = grown(&script)?;
    click(&mut window, "limbs");
    let label = "Height of the envelope";
    wait(&mut window, "the envelope", |w| handle(w, label).is_some())?;
    let at = handle(&window, label).expect("it is there");
    let by = vec2(0.0, 60.0);
    drag(&mut window, at, by);
    picture(&mut window, "top_dragged")?;
    drop_at(&mut window, at + by);
    let low = number(&window, "height_m: ");
    assert!((3.0..6.5).contains(&low), "{low}");
    let now = handle(&window, label).expect("it is there");
    // The top was above the picture at first, its handle at the edge.
    assert!(now.y > at.y + 20.0, "{now} from {at}");
    assert!(text(&window).contains("radius_m: [(0.2, 1), (0.5, 2.2), (1, 0.3)]"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), script, "it was more than one step");
    window.get_by_role_and_label(Role::Slider, label).focus();
    window.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    assert!(
        text(&window).contains("height_m: 7.1,"),
        "{}",
        text(&window)
    );
    Ok(())
}

/// Points in a file have no handles until they are brought into the script.
pub(super) fn file() -> Outcome {
    let dir = tempfile::tempdir()?;
    let points = "points: [(0, 0, 0), (0.1, 1, 0.1), (0, 2, 0.4)]";
    let script = templates::BLANK.replace(points, "file: \"limb.spline\"");
    assert_ne!(script, templates::BLANK);
    let spline = dir.path().join("limb.spline");
    fs::write(&spline, "0 0 0\n0.1 1 0.1\n0 2 0.4\n")?;
    let mut window = on_file(&dir.path().join("a.ron"), &script)?;
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    click(&mut window, "limb");
    window.run_steps(4);
    let point = |window: &Window| {
        let found = window.query_by_role_and_label(Role::Button, "Point 2 of limb");
        found.is_some()
    };
    assert!(!point(&window));
    // Said in the picture and on the page.
    let said = window.query_all_by_label_contains("are in the file limb.spline");
    assert_eq!(said.count(), 2);
    picture(&mut window, "spline_file")?;
    let offers: Vec<_> = window
        .get_all_by_label("Bring them into the script")
        .collect();
    assert_eq!(offers.len(), 2);
    offers[1].click();
    drop(offers);
    window.run_steps(4);
    assert!(text(&window).contains(points), "{}", text(&window));
    assert!(!text(&window).contains("limb.spline"));
    wait(&mut window, "handles", point)?;
    assert!(!has(&window, "are in the file"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), script);
    assert_eq!(fs::read_to_string(&spline)?, "0 0 0\n0.1 1 0.1\n0 2 0.4\n");
    Ok(())
}

fn tab(window: &Window, name: &str) -> Pos2 {
    // Above what is called the same in it.
    let all = window
        .get_all_by_label(name)
        .map(|node| node.rect().center());
    let upper = all.min_by(|a, b| a.y.total_cmp(&b.y));
    upper.expect("a tab")
}

fn command(window: &mut Window, words: &str) {
    press(window, Modifiers::NONE, Key::F1);
    write(window, "Shortcuts", words);
    press(window, Modifiers::NONE, Key::Enter);
}

/// Panes that were put elsewhere stand there in the next window, until the layout is reset.
pub(super) fn layout() -> Outcome {
    let dir = tempfile::tempdir()?;
    let file = dir.path().join("studio.ron");
    let begin = || Begin {
        kept: Keeper::open(Some(file.clone())),
        ..Begin::new(Document::new(templates::BLANK.to_owned()))
    };
    let mut window = window_at(begin());
    click(&mut window, "Got it");
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    let first = tab(&window, "Seeds");
    let script = tab(&window, "Script");
    // From among the fields to beside the script.
    drag(&mut window, first, script - first + vec2(30.0, 0.0));
    picture(&mut window, "layout_dragged")?;
    drop_at(&mut window, script + vec2(30.0, 0.0));
    window.run_steps(8);
    let moved = tab(&window, "Seeds");
    assert!((moved.y - script.y).abs() < 2.0, "{moved} {script}");
    picture(&mut window, "layout_moved")?;
    drop(window);
    assert!(!Keeper::open(Some(file.clone())).now.dock.is_empty());

    let mut window = window_at(begin());
    window.run_steps(4);
    let again = tab(&window, "Seeds");
    assert!(again.distance(moved) < 2.0, "{again} {moved}");
    command(&mut window, "reset");
    window.run_steps(4);
    let reset = tab(&window, "Seeds");
    assert!(reset.distance(first) < 2.0, "{reset} {first}");
    drop(window);
    assert_eq!(Keeper::open(Some(file.clone())).now.dock, "");

    // What is damaged or of another program stops no window.
    for dock in [
        "Row([(1.0,Pane(Tree",
        "Tabs([Pane(Moon)],0)",
        "\\u{0}",
        "Pane(Tree)",
    ] {
        fs::write(
            &file,
            format!("(scale: 1.2, dock: \"{dock}\", hints: false)"),
        )?;
        let mut window = window_at(begin());
        window.run_steps(4);
        let whole = ["Parts", "Tree", "Fields", "Script"];
        let names = whole.map(|name| window.query_all_by_label(name).count());
        assert!(names.iter().all(|&count| count > 0), "{dock}: {names:?}");
        let scale = window.ctx.zoom_factor();
        assert!((scale - 1.2).abs() < 1e-3, "the rest is kept: {scale}");
    }
    Ok(())
}

/// On no page are two things called the same that can be set.
pub(super) fn names() -> Outcome {
    let (_, oak) = templates::ALL
        .iter()
        .find(|(name, _)| *name == "English oak")
        .expect("an oak");
    for script in [templates::BLANK, oak] {
        let mut window = on(script);
        window.run_steps(2);
        let root = window.state().document().reading().root.clone();
        let pages = pleach::studio::outline::pages(&root.expect("values"));
        for page in pages.iter().filter(|page| page.table.name != SPECIES.name) {
            click(&mut window, &page.title);
            let mut seen: BTreeMap<String, usize> = BTreeMap::new();
            for role in [Role::SpinButton, Role::ComboBox, Role::ColorWell] {
                for node in window.query_all_by_role(role) {
                    let name = node.accesskit_node().label().unwrap_or_default();
                    *seen.entry(name).or_default() += 1;
                }
            }
            seen.retain(|_, count| *count > 1);
            assert!(seen.is_empty(), "{}: {seen:?}", page.title);
        }
    }
    let mut window = on(templates::BLANK);
    click(&mut window, "limbs");
    set(&mut window, "vary of down", 4.0);
    assert!(text(&window).contains("vary: 4)"), "{}", text(&window));
    click(&mut window, "Species");
    click(&mut window, "Lock the seed");
    assert_eq!(
        text(&window),
        templates::BLANK.replace("vary: 10)", "vary: 4)")
    );
    Ok(())
}

/// Levels have colours in the picture, and names beside them.
pub(super) fn colours() -> Outcome {
    let mut window = grown(templates::BLANK)?;
    window
        .get_all_by_label("View")
        .last()
        .expect("a tab")
        .click();
    window.run_steps(4);
    let before = window.query_all_by_label("limbs").count();
    click(&mut window, "Level colours");
    window.run_steps(8);
    assert_eq!(window.query_all_by_label("limbs").count(), before + 1);
    picture(&mut window, "levels")
}

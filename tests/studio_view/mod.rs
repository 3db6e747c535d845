//! The picture of the tree as a place to work in: picking, handles, the envelope and the person.

use super::{Outcome, PATIENCE, Window, click, on, picture, press, text, until, window};
use eframe::egui::accesskit::Role;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, Rect, Vec2, vec2};
use egui_kittest::kittest::Queryable as _;
use pleach::studio::document::Document;
use pleach::studio::{Begin, SketchBaker, Studio, templates};
use std::time::{Duration, Instant};

/// A window on a script whose tree is there.
pub(super) fn grown(script: &str) -> Result<Window, libtest_mimic::Failed> {
    let mut window = on(script);
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    window.run_steps(4);
    Ok(window)
}

fn view(window: &Window) -> Rect {
    window.get_by_label("View of My tree").rect()
}

/// Lets the window run until the threads have brought something about.
pub(super) fn wait(window: &mut Window, what: &str, so: impl Fn(&Window) -> bool) -> Outcome {
    let begun = Instant::now();
    while !so(window) {
        if begun.elapsed() > PATIENCE {
            return Err(format!("waited in vain for {what}").into());
        }
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    window.run_steps(2);
    Ok(())
}

pub(super) fn handle(window: &Window, label: &str) -> Option<Pos2> {
    let found = window.query_by_role_and_label(Role::Slider, label);
    found.map(|node| node.rect().center())
}

/// Drags from one point of the window to another, in a few steps.
pub(super) fn drag(window: &mut Window, from: Pos2, by: Vec2) {
    window.hover_at(from);
    window.run_steps(2);
    window.drag_at(from);
    window.run_steps(2);
    for step in 1..=4_u8 {
        window.hover_at(from + by * (f32::from(step) / 4.0));
        window.run_steps(2);
    }
}

pub(super) fn drop_at(window: &mut Window, at: Pos2) {
    window.drop_at(at);
    window.run_steps(3);
}

/// A click in the picture selects the level of what is there, and hovering tells of it.
pub(super) fn picks() -> Outcome {
    let mut window = grown(templates::BLANK)?;
    let rect = view(&window);
    click(&mut window, "limbs");
    wait(&mut window, "handles", |w| {
        handle(w, "Handle of start").is_some()
    })?;
    let links = |window: &Window| {
        let field = window.query_by_role_and_label(Role::SpinButton, "links");
        field.is_some()
    };
    assert!(links(&window), "it is the limbs' page");
    // Below the first limb there is nothing but the trunk.
    let first = handle(&window, "Handle of start").expect("it is there");
    let foot = first + vec2(-4.0, 70.0);
    window.hover_at(foot);
    wait(&mut window, "what is under the pointer", |w| {
        w.query_by_label("6.00 m long, radius 14 cm").is_some()
    })?;
    picture(&mut window, "hovered")?;
    window.drag_at(foot);
    window.run_steps(1);
    drop_at(&mut window, foot);
    window.hover_at(rect.left_top() + vec2(20.0, 20.0));
    window.run_steps(8);
    // Only a trunk has no links.
    assert!(window.query_by_label("Add flare").is_some());
    assert!(!links(&window), "it is not the trunk's page");
    // There is nothing in the sky, and looking changes nothing.
    assert!(window.query_by_label_contains(" long, ").is_none());
    assert_eq!(text(&window), templates::BLANK);
    picture(&mut window, "picked")
}

/// Handles change a level's angles and positions; each drag is one step, and the camera stays.
pub(super) fn handles() -> Outcome {
    let mut window = grown(templates::BLANK)?;
    click(&mut window, "limbs");
    wait(&mut window, "handles", |w| {
        handle(w, "Handle of down").is_some()
    })?;
    picture(&mut window, "handles")?;
    let still = handle(&window, "Handle of start");
    let at = handle(&window, "Handle of down").expect("it is there");
    let by = vec2(0.0, 40.0);
    drag(&mut window, at, by);
    picture(&mut window, "dragged")?;
    drop_at(&mut window, at + by);
    let down = "(at: [(0.3, 70), (1, 25)], vary: 10)";
    assert!(!text(&window).contains(down), "{}", text(&window));
    let kept = text(&window).matches(", vary: 10),").count();
    assert_eq!(kept, 1, "{}", text(&window));
    assert_eq!(
        handle(&window, "Handle of start"),
        still,
        "the camera turned"
    );
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK, "it was more than one step");

    wait(&mut window, "the handle of start", |w| {
        handle(w, "Handle of start") == still
    })?;
    let at = still.expect("it is there");
    let by = vec2(0.0, -50.0);
    drag(&mut window, at, by);
    drop_at(&mut window, at + by);
    let start = text(&window).split("start: ").nth(1);
    let start: f32 = start
        .and_then(|rest| rest.split(',').next())
        .and_then(|number| number.parse().ok())
        .expect("a number");
    assert!((0.35..0.6).contains(&start), "{start}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK);

    // Keys move it, too.
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    picture(&mut window, "undone")?;
    window
        .get_by_role_and_label(Role::Slider, "Handle of around")
        .focus();
    window.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    assert!(
        text(&window).contains("around: (at: 1, step: 137.5)"),
        "{}",
        text(&window)
    );
    press(&mut window, Modifiers::COMMAND, Key::Z);
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    click(&mut window, "leaves");
    wait(&mut window, "the leaves' handles", |w| {
        handle(w, "Handle of down").is_some_and(|now| now.distance(at) > 5.0)
    })?;
    picture(&mut window, "leaves")?;
    window.get_by_label("show the selected level").click();
    window.run_steps(4);
    assert_eq!(handle(&window, "Handle of around"), None);
    Ok(())
}

/// Points of a crown envelope are dragged on both sides of the trunk.
pub(super) fn crown() -> Outcome {
    let envelope = "envelope: (height_m: 7, radius_m: [(0.2, 1), (0.5, 2.2), (1, 0.3)])";
    let script = templates::BLANK.replace("start: 0.3,", &format!("start: 0.3, {envelope},"));
    let mut window = grown(&script)?;
    click(&mut window, "limbs");
    wait(&mut window, "the envelope", |w| {
        handle(w, "Envelope point 2, right").is_some()
    })?;
    picture(&mut window, "crown")?;
    for (label, by) in [
        ("Envelope point 2, right", vec2(-30.0, 0.0)),
        ("Envelope point 2, left", vec2(30.0, 0.0)),
    ] {
        let at = handle(&window, label).expect("it is there");
        drag(&mut window, at, by);
        drop_at(&mut window, at + by);
        let moved = handle(&window, label).expect("it is there");
        assert!(moved.distance(at + by) < 4.0, "{label}: {moved} from {at}");
        let radius = text(&window).split("radius_m: [(0.2, 1), (0.").nth(1);
        assert!(
            radius.is_some() && text(&window).contains("(1, 0.3)])"),
            "{}",
            text(&window)
        );
        assert!(!text(&window).contains("2.2"), "{}", text(&window));
        press(&mut window, Modifiers::COMMAND, Key::Z);
        assert_eq!(text(&window), script, "{label}");
        until(&mut window, "the tree", Studio::is_up_to_date)?;
    }
    Ok(())
}

/// A large tree is worked on in the same way: its levels are shown, and what is under the pointer is told.
pub(super) fn oak() -> Outcome {
    let (_, script) = templates::ALL
        .iter()
        .find(|(name, _)| *name == "English oak")
        .expect("an oak");
    let mut window = on(script);
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    for level in ["trunk", "limbs", "branchlets", "twigs", "tufts"] {
        click(&mut window, level);
        wait(&mut window, "handles", |w| {
            level == "trunk" || handle(w, "Handle of down").is_some()
        })?;
        picture(&mut window, &format!("oak_{level}"))?;
    }
    if std::env::var_os("STUDIO_PICTURES").is_some() {
        // That of the README.
        click(&mut window, "limbs");
        until(&mut window, "the whole tree", |s| s.subject().is_some())?;
        // Until it rests, and is drawn in full.
        window.run_steps(90);
        picture(&mut window, "oak")?;
    }
    Ok(())
}

fn point(window: &Window, label: &str) -> Option<Pos2> {
    let found = window.query_by_role_and_label(Role::Button, label);
    found.map(|node| node.rect().center())
}

/// Points of a spline are moved, added and taken away on a branch that was grown from it.
pub(super) fn spline() -> Outcome {
    let mut window = grown(templates::BLANK)?;
    click(&mut window, "limb");
    wait(&mut window, "handles", |w| {
        point(w, "Point 2 of limb").is_some()
    })?;
    assert_eq!(point(&window, "Point 0 of limb"), None, "that is the base");
    let at = point(&window, "Point 2 of limb").expect("it is there");
    window.hover_at(at);
    wait(&mut window, "the radius", |w| {
        w.query_by_label_contains("has a radius of").is_some()
    })?;
    picture(&mut window, "spline_points")?;

    // A drag is one step, and the point stays where it was let go of.
    // The tip can be turned, but not drawn out: across the branch.
    let one = point(&window, "Point 1 of limb").expect("it is there");
    let along = (at - one).normalized();
    let by = vec2(-along.y, along.x) * 24.0;
    drag(&mut window, at, by);
    picture(&mut window, "spline_dragged")?;
    let held = point(&window, "Point 2 of limb").expect("it is there");
    assert!(held.distance(at + by) < 8.0, "{held} from {at}");
    drop_at(&mut window, at + by);
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    window.run_steps(4);
    let begins = "(name: \"limb\", points: [(0, 0, 0), (0.1, 1, 0.1), (";
    assert!(text(&window).contains(begins), "{}", text(&window));
    assert_ne!(text(&window), templates::BLANK);
    let now = point(&window, "Point 2 of limb").expect("it is there");
    assert!(now.distance(held) < 2.0, "{now} is not {held}");
    picture(&mut window, "spline_bent")?;
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK, "it was more than one step");
    until(&mut window, "the tree", Studio::is_up_to_date)?;

    // Keys move, add and take away; the focus goes on to the new point.
    window
        .get_by_role_and_label(Role::Button, "Point 1 of limb")
        .focus();
    window.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    assert!(!text(&window).contains("(0.1, 1, 0.1)"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    until(&mut window, "the tree", Studio::is_up_to_date)?;
    press(&mut window, Modifiers::NONE, Key::Insert);
    let added = "(0.1, 1, 0.1), (0.05, 1.5, 0.25), (0, 2, 0.4)]";
    assert!(text(&window).contains(added), "{}", text(&window));
    wait(&mut window, "the new point", |w| {
        let new = w.query_by_role_and_label(Role::Button, "Point 3 of limb");
        let focused = w.query_by_role_and_label(Role::Button, "Point 2 of limb");
        new.is_some() && focused.is_some_and(|node| node.is_focused())
    })?;
    picture(&mut window, "spline_added")?;
    press(&mut window, Modifiers::NONE, Key::Delete);
    assert_eq!(text(&window), templates::BLANK);
    wait(&mut window, "the points", |w| {
        point(w, "Point 2 of limb").is_some()
    })?;

    // A double click on the line adds a point; it neither frames the tree nor selects a level.
    let [one, two] = ["Point 1 of limb", "Point 2 of limb"].map(|l| point(&window, l));
    let (one, two) = (one.expect("there"), two.expect("there"));
    let middle = one + (two - one) * 0.5;
    window.hover_at(middle);
    window.run_steps(2);
    for _ in 0..2 {
        for pressed in [true, false] {
            let pos = middle;
            window.input_mut().events.push(Event::PointerButton {
                pos,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::NONE,
            });
        }
    }
    window.run_steps(3);
    let count = |window: &Window| {
        let species = window.state().document().reading().species.as_ref();
        species.map_or(0, |species| species.splines[1].points.len())
    };
    assert_eq!(count(&window), 4, "{}", text(&window));
    wait(&mut window, "the new point", |w| {
        point(w, "Point 3 of limb").is_some()
    })?;
    let new = point(&window, "Point 2 of limb").expect("there");
    assert!(new.distance(middle) < 8.0, "{new} {middle}");
    // And a right click takes one away.
    for pressed in [true, false] {
        window.input_mut().events.push(Event::PointerButton {
            pos: new,
            button: PointerButton::Secondary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    window.run_steps(3);
    assert_eq!(text(&window), templates::BLANK);

    // The trunk's spline is on the trunk.
    let splines: Vec<_> = window.get_all_by_label("trunk").collect();
    splines[splines.len() - 1].click_accesskit();
    drop(splines);
    wait(&mut window, "the trunk's points", |w| {
        point(w, "Point 3 of trunk").is_some()
    })?;
    let at = point(&window, "Point 1 of trunk").expect("there");
    window.hover_at(at);
    wait(&mut window, "the radius", |w| {
        w.query_by_label_contains(" cm\nDrag it").is_some()
    })?;
    picture(&mut window, "spline_trunk")
}

/// Captures and shadows of sketches are the adapter's or the processor's; whole trees are always the processor's.
pub(super) fn bakers() -> Outcome {
    let (_, oak) = templates::ALL
        .iter()
        .find(|(name, _)| *name == "English oak")
        .expect("an oak");
    for (baker, adapters) in [(SketchBaker::Gpu, true), (SketchBaker::Cpu, false)] {
        let mut window = window(Begin {
            baker,
            ..Begin::new(Document::new((*oak).to_owned()))
        });
        until(&mut window, "captures and shadows", Studio::is_furnished)?;
        let studio = window.state();
        assert!(studio.subject().is_none(), "they come before the LODs");
        assert_eq!(studio.baker().is_some(), adapters, "{baker:?}");
        until(&mut window, "the whole tree", |s| s.subject().is_some())?;
        assert_eq!(window.state().baker(), None, "as in packs");
    }
    Ok(())
}

//! The studio's manners around documents: lists of folders, exports, the palette, what is kept, dropped files.

use super::studio_view::wait;
use super::*;
use eframe::egui::{DroppedFile, DroppedFileHandle};
use pleach::species::edit;
use pleach::studio::kept::{Keeper, Theme};
use std::path::PathBuf;
use std::sync::Arc;

/// Words that are still being typed are saved, too.
pub(super) fn typing() -> Outcome {
    let dir = tempfile::tempdir()?;
    let path = dir.path().join("a.ron");
    let mut window = on_file(&path, templates::BLANK)?;
    click(&mut window, "limbs");
    window
        .get_by_role_and_label(Role::TextInput, "splines")
        .focus();
    window.run_steps(2);
    press(&mut window, Modifiers::COMMAND, Key::A);
    write(&mut window, "splines", "[\"trunk\"]");
    press(&mut window, Modifiers::COMMAND, Key::S);
    let expected = templates::BLANK.replace("splines: [\"limb\"]", "splines: [\"trunk\"]");
    assert_eq!(text(&window), expected);
    assert_eq!(fs::read_to_string(&path)?, expected);
    Ok(())
}

/// What another program has written is asked about before it is replaced, also if nobody has looked at it yet.
pub(super) fn outran() -> Outcome {
    let dir = tempfile::tempdir()?;
    let path = dir.path().join("a.ron");
    let mut window = on_file(&path, templates::BLANK)?;
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    let theirs = templates::BLANK.replace("links: 18", "links: 30");
    fs::write(&path, &theirs)?;
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert_eq!(fs::read_to_string(&path)?, theirs);
    click(&mut window, "Keep this one");
    press(&mut window, Modifiers::COMMAND, Key::S);
    let ours = templates::BLANK.replace("links: 18", "links: 5");
    assert_eq!(fs::read_to_string(&path)?, ours);
    Ok(())
}

/// Of two texts that were left, one is recovered, and the other stays for the next window.
pub(super) fn both_left() -> Outcome {
    let dir = tempfile::tempdir()?;
    let notes = dir.path().join("notes");
    let begin = |left| Begin {
        notes: Some(notes.clone()),
        left,
        ..Begin::new(Document::new(templates::BLANK.to_owned()))
    };
    let mut windows = [begin(Vec::new()), begin(Vec::new())].map(window_at);
    let mut texts = Vec::new();
    for (window, links) in windows.iter_mut().zip([5.0, 7.0]) {
        click(window, "limbs");
        set(window, "links", links);
        texts.push(text(window).to_owned());
    }
    drop(windows);
    let mut found = Vec::new();
    for _ in 0..2 {
        let left = recovery::left(&notes);
        assert_eq!(left.len(), 2 - found.len());
        let mut window = window_at(begin(left));
        click(&mut window, "Recover");
        found.push(text(&window).to_owned());
        let path = dir.path().join(format!("{}.ron", found.len()));
        save_as(&mut window, &path)?;
    }
    found.sort();
    texts.sort();
    assert_eq!(found, texts);
    assert!(recovery::left(&notes).is_empty());
    Ok(())
}

/// The blank template with two variations.
fn varied() -> String {
    let variations = "seed: 1,\n    variations: [\n        (name: \"young\", seed: 3, age: 0.4),\n        \
                      (name: \"other\", seed: 5),\n    ],\n";
    templates::BLANK.replacen("seed: 1,\n", variations, 1)
}

pub(super) fn on_file(path: &Path, text: &str) -> Result<Window, Failed> {
    fs::write(path, text)?;
    Ok(window_at(Begin::new(Document::open(path)?)))
}

pub(super) fn write(window: &mut Window, field: &str, text: &str) {
    window
        .get_by_role_and_label(Role::TextInput, field)
        .type_text(text);
    window.run_steps(3);
}

pub(super) fn has(window: &Window, part: &str) -> bool {
    window.query_all_by_label_contains(part).count() > 0
}

pub(super) fn browsing() -> Outcome {
    let dir = tempfile::tempdir()?;
    fs::create_dir(dir.path().join("sub"))?;
    let oak = dir.path().join("sub/oak.ron");
    fs::write(&oak, templates::BLANK)?;
    let mut window = on_file(&dir.path().join("a.ron"), templates::BLANK)?;
    press(&mut window, Modifiers::COMMAND, Key::O);
    wait(&mut window, "the list", |w| {
        has(w, "a.ron") && has(w, "sub/")
    })?;
    picture(&mut window, "browser")?;
    write(&mut window, "Open a script", "nothing");
    assert!(!has(&window, "sub/"));
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(has(&window, "There is no file"));
    picture(&mut window, "browser_fault")?;
    for _ in 0.."nothing".len() {
        press(&mut window, Modifiers::NONE, Key::Backspace);
    }
    write(&mut window, "Open a script", "SU");
    // By keys into the folder, and out of the list of it the script.
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::Enter);
    wait(&mut window, "the script", |w| has(w, "oak.ron"))?;
    click(&mut window, "oak.ron");
    click(&mut window, "Open");
    assert_eq!(window.state().document().path(), Some(&*oak));
    Ok(())
}

pub(super) fn replacing() -> Outcome {
    let dir = tempfile::tempdir()?;
    let (own, other) = (dir.path().join("a.ron"), dir.path().join("b.ron"));
    fs::write(&other, "another's")?;
    let mut window = on_file(&own, templates::BLANK)?;
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    // Its own file is not asked about.
    save_as(&mut window, &own)?;
    assert!(!has(&window, "Replace it?") && !window.state().document().is_unsaved());
    save_as(&mut window, &other)?;
    assert!(has(&window, "Replace it?"));
    assert_eq!(fs::read_to_string(&other)?, "another's");
    picture(&mut window, "replace")?;
    click(&mut window, "Back");
    assert!(!has(&window, "Replace it?"));
    click(&mut window, "Save");
    click(&mut window, "Replace");
    assert_eq!(fs::read_to_string(&other)?, text(&window));
    assert_eq!(window.state().document().path(), Some(&*other));
    Ok(())
}

pub(super) fn variations() -> Outcome {
    let dir = tempfile::tempdir()?;
    let script = varied();
    let mut begin = Begin::new(Document::new(script.clone()));
    begin.out = dir.path().join("packs");
    let mut window = window_at(begin);
    press(&mut window, Modifiers::COMMAND, Key::E);
    click(&mut window, "Its variations");
    click(&mut window, "Mips of the atlas that keep its coverage");
    picture(&mut window, "export")?;
    click(&mut window, "Export");
    let options = pack::Options {
        mips: true,
        ..pack::Options::default()
    };
    let species = species::parse("script", &script, &NoFiles).expect("no faults");
    let mut made = Vec::new();
    for variation in &species.variations {
        let text = edit::vary(&script, &species, variation)?;
        let species = species::parse("script", &text, &NoFiles).expect("no faults");
        let asset = pipeline::generate(&species, &Settings::default(), &NoFiles, &Quiet)?;
        let name = pack::folder_name(&asset.slug, asset.seed);
        made.push((name, pack::build(&asset, text.as_bytes(), options)?));
    }
    let packs = dir.path().join("packs");
    let begun = Instant::now();
    while !has(&window, "2 packs are written into") {
        assert!(begun.elapsed() < PATIENCE, "{:?}", window.state().message());
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    assert_eq!(made[0].0, "my-tree-young-3");
    for (name, files) in made {
        for file in files {
            assert!(
                fs::read(packs.join(&name).join(&file.path))? == file.bytes,
                "{name}: {}",
                file.path
            );
        }
    }
    picture(&mut window, "exported")?;
    click(&mut window, "Close");
    assert!(!has(&window, "packs are written"));
    Ok(())
}

pub(super) fn cancelling() -> Outcome {
    let dir = tempfile::tempdir()?;
    let mut begin = Begin::new(Document::new(varied()));
    begin.out = dir.path().join("packs");
    let mut window = window_at(begin);
    press(&mut window, Modifiers::COMMAND, Key::E);
    click(&mut window, "Its variations");
    click(&mut window, "Export");
    assert!(has(&window, "writing"));
    picture(&mut window, "exporting")?;
    click(&mut window, "Cancel the export");
    assert!(!has(&window, "Cancel the export"));
    let told = window.state().message().unwrap_or_default();
    assert!(told.contains("cancelled"), "{told}");
    // The next one waits for the thread to be done with this one.
    press(&mut window, Modifiers::COMMAND, Key::E);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let begun = Instant::now();
    while !has(&window, "is written") {
        assert!(begun.elapsed() < PATIENCE, "{:?}", window.state().message());
        std::thread::sleep(Duration::from_millis(20));
        window.step();
    }
    for entry in fs::read_dir(dir.path().join("packs"))? {
        let path = entry?.path();
        assert!(path.join("pack.json").exists(), "{}", path.display());
    }
    Ok(())
}

pub(super) fn palette() -> Outcome {
    let mut window = on(templates::BLANK);
    click(&mut window, "limbs");
    set(&mut window, "links", 5.0);
    press(&mut window, Modifiers::NONE, Key::F1);
    picture(&mut window, "palette")?;
    write(&mut window, "Shortcuts", "und");
    assert!(!has(&window, "Save as"));
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(!has(&window, "Shortcuts"));
    assert_eq!(text(&window), templates::BLANK);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    write(&mut window, "Shortcuts", "theme");
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(!window.ctx.global_style().visuals.dark_mode, "the second");
    press(&mut window, Modifiers::NONE, Key::F1);
    write(&mut window, "Shortcuts", "view");
    picture(&mut window, "palette_view")?;
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!has(&window, "Shortcuts"));
    Ok(())
}

pub(super) fn kept() -> Outcome {
    let dir = tempfile::tempdir()?;
    let (file, script) = (dir.path().join("studio.ron"), dir.path().join("a.ron"));
    fs::write(&script, templates::BLANK)?;
    let begin = || -> Result<Begin, Failed> {
        Ok(Begin {
            kept: Keeper::open(Some(file.clone())),
            ..Begin::new(Document::open(&script)?)
        })
    };
    let mut window = window_at(begin()?);
    assert!(has(&window, "Pick a part"));
    until(&mut window, "the tree", |s| s.subject().is_some())?;
    picture(&mut window, "hints")?;
    click(&mut window, "Got it");
    assert!(!has(&window, "Pick a part"));
    press(&mut window, Modifiers::COMMAND, Key::Plus);
    press(&mut window, Modifiers::COMMAND, Key::Plus);
    press(&mut window, Modifiers::NONE, Key::F1);
    write(&mut window, "Shortcuts", "light");
    press(&mut window, Modifiers::NONE, Key::Enter);
    let scale = |window: &Window| (window.ctx.zoom_factor() * 100.0).round();
    assert_eq!(scale(&window), 120.0);
    drop(window);
    let kept = Keeper::open(Some(file.clone())).now.clone();
    assert_eq!((kept.theme, kept.hints), (Theme::Light, false));
    assert_eq!(kept.recent, std::slice::from_ref(&script));

    let mut window = window_at(begin()?);
    window.run_steps(3);
    assert_eq!(scale(&window), 120.0);
    assert!(!has(&window, "Pick a part"));
    assert!(!window.ctx.global_style().visuals.dark_mode);
    for _ in 0..20 {
        press(&mut window, Modifiers::COMMAND, Key::Plus);
    }
    assert_eq!(scale(&window), 200.0);
    press(&mut window, Modifiers::COMMAND, Key::E);
    picture(&mut window, "export_large")?;
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::COMMAND, Key::Num0);
    assert_eq!(scale(&window), 100.0);
    for label in ["File", "Open recent"] {
        window.get_by_label_contains(label).click();
        window.run_steps(4);
    }
    assert!(has(&window, "a.ron  in"));
    picture(&mut window, "recent_light")
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        fs::read(&self.0).map_err(|error| error.to_string())
    }
}

fn drop_on(window: &mut Window, paths: &[&Path]) {
    for path in paths {
        let file: DroppedFileHandle = Arc::new(Dropped((*path).to_owned()));
        window.input_mut().dropped_files.push(file);
    }
    window.run_steps(3);
}

pub(super) fn dropped() -> Outcome {
    let (dir, elsewhere) = (tempfile::tempdir()?, tempfile::tempdir()?);
    let leaf = pleach::image::Image::from_texels(4, 4, vec![[60, 120, 40, 255]; 16]);
    let bytes = pleach::image::png::encode(&leaf)?;
    let (near, far) = (
        dir.path().join("near.png"),
        elsewhere.path().join("far.png"),
    );
    fs::write(&near, &bytes)?;
    fs::write(&far, &bytes)?;
    let mut window = on_file(&dir.path().join("a.ron"), templates::BLANK)?;
    drop_on(&mut window, &[&near]);
    assert_eq!(text(&window), templates::BLANK, "no leaf kind was picked");
    click(&mut window, "shoot");
    drop_on(&mut window, &[&near]);
    assert!(
        text(&window).contains("image: \"near.png\""),
        "{}",
        text(&window)
    );
    assert!(window.state().document().reading().species.is_ok());
    drop_on(&mut window, &[&far]);
    assert!(has(&window, "Copy it beside the script?"));
    picture(&mut window, "copy")?;
    click(&mut window, "Copy");
    until(&mut window, "the copy", |s| {
        s.document().text().contains("image: \"far.png\"")
    })?;
    assert_eq!(fs::read(dir.path().join("far.png"))?, bytes);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&window), templates::BLANK, "each was one step");
    let script = elsewhere.path().join("b.ron");
    fs::write(&script, templates::BLANK)?;
    drop_on(&mut window, &[&far, &script, &near.with_file_name("a.ron")]);
    assert_eq!(window.state().document().path(), Some(&*script));
    let told = window.state().message().unwrap_or_default();
    assert!(told.contains("2 scripts were dropped"), "{told}");
    Ok(())
}

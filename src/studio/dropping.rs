//! Files that are dropped on the window: scripts are opened, and pictures become those of the leaf kind or of the
//! bark whose page is shown.

use super::app::{Next, Order, Studio};
use super::document::Edit;
use super::form::{Change, quoted};
use super::outline::{self, Page, Section};
use super::questions::Question;
use crate::disk;
use crate::image::{Image, png};
use crate::species::edit::{self, EditError};
use crate::species::fields::DRAWN_LEAF;
use crate::species::syntax::Node;
use crate::viewer::loader::Polled;
use eframe::egui::Ui;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Real height of one repeat of a bark's picture until its author says better, metres.
const REPEAT: &str = "1";

/// A picture to be copied beside the script, and the page that it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Copy {
    pub(super) file: PathBuf,
    page: String,
}

impl Copy {
    /// True for a picture that has to be made a PNG, which is what scripts take.
    pub(super) fn converts(&self) -> bool {
        !has_ending(&self.file, &["png"])
    }
}

/// A picture that stands beside the script now.
#[derive(Debug)]
pub(super) struct Copied {
    page: String,
    path: String,
}

impl Studio {
    /// Takes in files that are dropped on the window.
    pub(super) fn drops(&mut self, ui: &Ui) {
        let dropped = ui.input(|i| i.raw.dropped_files.clone());
        let paths: Vec<PathBuf> = dropped.iter().map(|f| f.path().to_owned()).collect();
        if paths.is_empty() || self.question.is_some() {
            return;
        }
        let of = |endings: &[&str]| {
            let found = paths.iter().filter(|path| has_ending(path, endings));
            found.cloned().collect::<Vec<_>>()
        };
        let scripts = of(&["ron"]);
        if let Some(first) = scripts.first() {
            if scripts.len() > 1 {
                let (count, name) = (scripts.len(), first.display());
                self.say(
                    ui,
                    format!("{count} scripts were dropped; the first is {name}"),
                );
            }
            self.obey(ui, Order::Ask(Next::Open(first.clone())));
        } else if let Some(picture) = of(&["png", "jpg", "jpeg"]).first() {
            self.drop_picture(ui, picture);
        } else {
            self.say(
                ui,
                "scripts (.ron) and pictures (.png, .jpg) can be dropped here",
            );
        }
    }

    fn drop_picture(&mut self, ui: &Ui, picture: &Path) {
        let pages = self.document.reading().root.as_ref().map(outline::pages);
        let pages = pages.unwrap_or_default();
        let page = pages.iter().find(|page| page.path == *self.selected());
        let Some(page) = page.filter(|page| takes_picture(page)) else {
            return self.say(
                ui,
                "pick a leaf kind or the bark first; the picture is then for it",
            );
        };
        if self.document.path().is_none() {
            return self.say(ui, "save the script first: its pictures stand beside it");
        }
        let copy = Copy {
            file: picture.to_owned(),
            page: page.path.clone(),
        };
        match relative(&self.document.folder(), picture) {
            Some(path) if !copy.converts() => self.take_picture(ui, &copy.page, &path),
            _ => self.question = Some(Question::Copy(copy)),
        }
    }

    /// Makes a picture beside the script that of a page.
    fn take_picture(&mut self, ui: &Ui, page: &str, path: &str) {
        let root = self.document.reading().root.as_ref();
        let text = root.and_then(|root| Some((outline::at(root, page)?, page)));
        let text = text.map(|place| with_picture(self.document.text(), place, path));
        match text {
            Some(Ok(text)) => {
                let change = Change::Edit(format!("Take {path}"), None, Edit::Text(text));
                self.obey(ui, Order::Change(change));
            }
            Some(Err(error)) => self.say(ui, error.to_string()),
            None => self.say(ui, "the part that the picture was for is gone"),
        }
    }

    /// Copies a picture beside the script, in the thread for that.
    pub(super) fn copy_picture(&mut self, copy: Copy) {
        let folder = self.document.folder();
        self.copier.ask(Box::new(move |progress| {
            progress.begin("copying", 0);
            let name = copied(&copy, &folder)?;
            Ok(Copied {
                page: copy.page,
                path: name,
            })
        }));
    }

    /// Takes in what was copied.
    pub(super) fn copied(&mut self, ui: &Ui, polled: Polled) {
        if polled.good
            && let Some(done) = self.copier.good().cloned()
        {
            self.take_picture(ui, &done.page, &done.path);
        } else if polled.changed
            && let Some(fault) = self.copier.fault().map(str::to_owned)
        {
            self.say(ui, fault);
        }
    }
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().unwrap_or_default();
    endings.iter().any(|one| ending.eq_ignore_ascii_case(one))
}

fn takes_picture(page: &Page) -> bool {
    matches!(page.section, Section::Leaves | Section::Bark)
}

/// How a script in `folder` names a file; none if it cannot, since the file is elsewhere.
fn relative(folder: &Path, file: &Path) -> Option<String> {
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let (here, file) = (fs::canonicalize(here).ok()?, fs::canonicalize(file).ok()?);
    let parts = file.strip_prefix(here).ok()?.components();
    let parts: Option<Vec<&str>> = parts.map(|part| part.as_os_str().to_str()).collect();
    let path = parts?.join("/");
    // Such names mean something else on other systems, and scripts refuse them.
    let is_odd = path.contains([':', '\\']) || path.chars().any(char::is_control);
    (!path.is_empty() && !is_odd).then_some(path)
}

/// A script whose leaf kind or bark at a path is a picture.
fn with_picture(text: &str, (node, at): (&Node, &str), path: &str) -> Result<String, EditError> {
    let value = quoted(path);
    if at != Section::Bark.field() {
        let mut text = text.to_owned();
        // What is drawn means nothing beside a picture, and is a fault there.
        for field in DRAWN_LEAF
            .iter()
            .filter(|f| outline::field(node, f.name).is_some())
        {
            text = edit::remove(&text, &format!("{at}.{}", field.name))?;
        }
        return edit::set(&text, &format!("{at}.image"), &value);
    }
    match outline::variant(node) {
        Some("Image") => edit::set(text, &format!("{at}.path"), &value),
        _ => edit::set(
            text,
            at,
            &format!("Image(path: {value}, height_m: {REPEAT})"),
        ),
    }
}

/// Puts a picture into a folder, as a PNG under a name that is free there; that name.
fn copied(copy: &Copy, folder: &Path) -> Result<String, String> {
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", copy.file.display());
    let mut bytes = fs::read(&copy.file).map_err(|e| told(&e))?;
    if copy.converts() {
        let format = ::image::ImageFormat::Jpeg;
        let picture = ::image::load_from_memory_with_format(&bytes, format);
        let picture = picture.map_err(|e| told(&e))?.into_rgba8();
        let (width, height) = picture.dimensions();
        let texels = picture.pixels().map(|pixel| pixel.0).collect();
        bytes = png::encode(&Image::from_texels(width, height, texels)).map_err(|e| told(&e))?;
    }
    let stem = copy.file.file_stem().unwrap_or_default().to_string_lossy();
    let is_fine = |c: char| c.is_alphanumeric() || "-_ .".contains(c);
    let stem: String = stem
        .chars()
        .map(|c| if is_fine(c) { c } else { '_' })
        .collect();
    for number in 1.. {
        let name = match number {
            1 => format!("{stem}.png"),
            _ => format!("{stem}-{number}.png"),
        };
        let place = folder.join(&name);
        match disk::write_new(&place, &bytes) {
            Ok(()) => return Ok(name),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                if fs::read(&place).is_ok_and(|there| there == bytes) {
                    return Ok(name);
                }
            }
            Err(error) => return Err(told(&error)),
        }
    }
    unreachable!("numbers do not end")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::{self, Beside};
    use crate::studio::templates::BLANK;

    fn picture() -> Vec<u8> {
        png::encode(&Image::from_texels(2, 2, vec![[90, 80, 70, 255]; 4])).unwrap()
    }

    #[test]
    fn a_file_is_named_only_from_beside_or_below_the_script() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("trees");
        fs::create_dir_all(folder.join("pictures")).unwrap();
        for name in ["trees/a.png", "trees/pictures/b.png", "c.png"] {
            fs::write(dir.path().join(name), "").unwrap();
        }
        let named = |name: &str| relative(&folder, &dir.path().join(name));
        assert_eq!(named("trees/a.png").as_deref(), Some("a.png"));
        assert_eq!(
            named("trees/pictures/b.png").as_deref(),
            Some("pictures/b.png")
        );
        assert_eq!((named("c.png"), named("trees/none.png")), (None, None));
    }

    #[test]
    fn leaves_and_barks_become_pictures_and_stay_sound() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a.png"), picture()).unwrap();
        let files = Beside(dir.path().to_owned());
        let bark = BLANK.replace("seed: 1,", "seed: 1, bark: Smooth(),");
        let sound = |text: &str| species::parse("script", text, &files).map(|_| ());
        let root = |text: &str| species::syntax::parse(text).0.unwrap();
        for (text, at) in [(BLANK, "leaves.0"), (&bark, "bark")] {
            let tree = root(text);
            let taken = with_picture(text, (outline::at(&tree, at).unwrap(), at), "a.png").unwrap();
            assert!(taken.contains("\"a.png\""), "{taken}");
            assert!(sound(&taken).is_ok(), "{taken}");
            // A picture takes the place of another.
            let tree = root(&taken);
            let again =
                with_picture(&taken, (outline::at(&tree, at).unwrap(), at), "b.png").unwrap();
            assert_eq!(again, taken.replace("a.png", "b.png"));
        }
    }

    #[test]
    fn copies_take_no_name_that_another_picture_has() {
        let dir = tempfile::tempdir().unwrap();
        let (there, folder) = (dir.path().join("a.png"), dir.path().join("trees"));
        fs::create_dir(&folder).unwrap();
        fs::write(&there, picture()).unwrap();
        fs::write(folder.join("a.png"), "another").unwrap();
        let copy = Copy {
            file: there,
            page: "bark".to_owned(),
        };
        assert_eq!(copied(&copy, &folder).as_deref(), Ok("a-2.png"));
        assert_eq!(
            copied(&copy, &folder).as_deref(),
            Ok("a-2.png"),
            "it is there"
        );
        assert_eq!(fs::read(folder.join("a-2.png")).unwrap(), picture());
        assert_eq!(fs::read(folder.join("a.png")).unwrap(), b"another");
    }

    #[test]
    fn a_photograph_becomes_a_png() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("bark.JPG");
        let photograph = ::image::RgbImage::from_pixel(8, 8, ::image::Rgb([200, 100, 50]));
        photograph
            .save_with_format(&file, ::image::ImageFormat::Jpeg)
            .unwrap();
        let copy = Copy {
            file,
            page: "bark".to_owned(),
        };
        assert_eq!(copied(&copy, dir.path()).as_deref(), Ok("bark.png"));
        let read = png::decode(&fs::read(dir.path().join("bark.png")).unwrap(), 1 << 20).unwrap();
        assert_eq!((read.width(), read.height(), read.at(3, 3)[3]), (8, 8, 255));
    }
}

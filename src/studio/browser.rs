//! A path to read from or to write to: typed, or picked from the list of its folder under the field.

use super::asking::{self, Answer, PATIENCE};
use super::folder::{Entry, Found, Listing, Wants, absolute, found, matching, parted};
use eframe::egui::text::{CCursor, CCursorRange};
use eframe::egui::text_edit::TextEditState;
use eframe::egui::{self, Key, Modifiers, RichText, Ui};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Most entries of a folder that are listed: more are found by typing a part of their name.
const MOST: usize = 500;

/// Smallest and largest height of the list, points.
const LIST: [f32; 2] = [80.0, 200.0];

/// Part of the window's height that the list takes in between.
const PART: f32 = 0.28;

/// How often it is looked whether a slow folder has answered.
const AGAIN: Duration = Duration::from_millis(50);

/// The entry that leads out of a folder.
const UP: &str = "..";

/// A field and a list for a path.
#[derive(Debug)]
pub(super) struct Browser {
    wants: Wants,
    text: String,
    /// The folder that is listed.
    folder: PathBuf,
    listing: Answer<Listing>,
    /// What was typed of a name since the folder was entered.
    filter: String,
    /// Name of the entry that Enter takes.
    chosen: Option<String>,
    fault: Option<String>,
    /// True if the cursor is to stand at the end of the text.
    moved: bool,
    /// True if the chosen entry is to be brought into sight.
    scrolls: bool,
    /// True until the field was shown.
    is_new: bool,
}

/// What is done with a path.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Done {
    Take(PathBuf),
    Cancel,
}

impl Browser {
    /// A list of `folder`, with a file's `name` to begin with.
    pub(super) fn new(wants: Wants, folder: &Path, name: &str) -> Self {
        let mut browser = Self {
            wants,
            text: String::new(),
            folder: PathBuf::new(),
            listing: Answer::Never,
            filter: String::new(),
            chosen: None,
            fault: None,
            moved: true,
            scrolls: false,
            is_new: true,
        };
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        browser.read(absolute(folder));
        browser.text = browser.joined(name);
        if wants == Wants::Folder {
            browser.text = browser.folder.display().to_string();
        }
        browser
    }

    fn read(&mut self, folder: PathBuf) {
        let (wants, place) = (self.wants, folder.clone());
        self.listing = Answer::to(move || Listing::of(&place, wants));
        self.folder = folder;
        self.chosen = None;
        self.filter = String::new();
    }

    /// Goes into a folder; the name of a file that is to be written stays.
    fn enter(&mut self, folder: PathBuf) {
        let name = match self.wants {
            Wants::NewScript => parted(&self.text).1,
            Wants::Script | Wants::Folder => String::new(),
        };
        self.read(folder);
        self.text = self.joined(&name);
        self.moved = true;
    }

    fn joined(&self, name: &str) -> String {
        // With a name of nothing, the separator stands at the end: what is typed then is a name.
        self.folder.join(name).display().to_string()
    }

    /// Takes in what was typed.
    fn typed(&mut self) {
        let (folder, name) = parted(&self.text);
        if folder != self.folder {
            self.read(folder);
        }
        (self.filter, self.chosen, self.fault) = (name, None, None);
    }

    /// What the folder holds, so far as that is known.
    fn entries(&self) -> &[Entry] {
        let listing = self.listing.get().map(|listing| &listing.entries);
        let entries = listing.and_then(|entries| entries.as_deref().ok());
        entries.unwrap_or_default()
    }

    /// The entries that are shown.
    fn shown(&self) -> Vec<Entry> {
        let up = self.folder.parent().is_some().then(|| Entry {
            name: UP.to_owned(),
            is_folder: true,
        });
        let up = up.filter(|_| self.filter.is_empty());
        let found = matching(self.entries(), &self.filter);
        up.into_iter().chain(found.cloned()).collect()
    }

    fn choose(&mut self, name: &str) {
        let place = self.place(name);
        // The name of a file that is to be written is not lost on the way to its folder.
        let stays = match self.wants {
            Wants::Folder => false,
            Wants::Script => name == UP,
            Wants::NewScript => {
                let is_it = |entry: &Entry| entry.is_folder && entry.name == name;
                name == UP || self.entries().iter().any(is_it)
            }
        };
        if !stays {
            self.text = place.display().to_string();
        }
        self.chosen = Some(name.to_owned());
        self.fault = None;
        self.moved = true;
    }

    fn place(&self, name: &str) -> PathBuf {
        match name {
            UP => self.folder.parent().unwrap_or(&self.folder).to_owned(),
            name => self.folder.join(name),
        }
    }

    /// Chooses the entry that stands so many after the chosen one.
    fn step(&mut self, by: isize) {
        let shown = self.shown();
        let at = |name: &String| shown.iter().position(|entry| entry.name == *name);
        let next = match self.chosen.as_ref().and_then(at) {
            Some(index) => index.saturating_add_signed(by),
            None if by > 0 => 0,
            None => return,
        };
        if let Some(entry) = shown.get(next) {
            self.choose(&entry.name);
            self.scrolls = true;
        }
    }

    /// Goes into the folder that is chosen or typed, or takes the path. A folder that is wanted is taken with its
    /// button and entered otherwise.
    fn take(&mut self, by_button: bool) -> Option<PathBuf> {
        let path = match &self.chosen {
            Some(name) => self.place(name),
            None => PathBuf::from(self.text.trim()),
        };
        let path = absolute(&path);
        let enters = match self.wants {
            Wants::Folder => self.chosen.is_some() && !by_button,
            Wants::Script | Wants::NewScript => true,
        };
        let (wants, typed, place) = (self.wants, self.text.clone(), path.clone());
        let look = move || found(wants, &typed, place, enters);
        match asking::within(PATIENCE, look) {
            Some(Found::Enter(folder)) => {
                self.enter(folder);
                None
            }
            Some(Found::Take(path)) => Some(path),
            Some(Found::Fault(fault)) => {
                self.fault = Some(fault);
                None
            }
            None => {
                self.fault = Some(format!("{} does not answer.", path.display()));
                None
            }
        }
    }

    /// The field, the list, `more`, and the buttons.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        (heading, verb): (&str, &str),
        more: impl FnOnce(&mut Ui),
    ) -> Option<Done> {
        self.listing.poll();
        if self.listing.is_awaited() {
            ui.ctx().request_repaint_after(AGAIN);
        }
        let label = ui.heading(heading);
        let mut done = self.field(ui, label.id).map(Done::Take);
        if let Some(fault) = &self.fault {
            ui.label(RichText::new(fault).color(ui.visuals().error_fg_color));
        }
        ui.add_space(4.0);
        if let Some(path) = self.list(ui) {
            done = Some(Done::Take(path));
        }
        more(ui);
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let named = !self.text.trim().is_empty();
            if ui.add_enabled(named, egui::Button::new(verb)).clicked() {
                done = self.take(true).map(Done::Take);
            }
            if ui.button("Cancel").clicked() {
                done = Some(Done::Cancel);
            }
        });
        done
    }

    fn field(&mut self, ui: &mut Ui, label: egui::Id) -> Option<PathBuf> {
        let id = egui::Id::unique("studio path");
        if ui.memory(|m| m.has_focus(id)) {
            for (key, by) in [(Key::ArrowDown, 1), (Key::ArrowUp, -1)] {
                if ui.input_mut(|i| i.consume_key(Modifiers::NONE, key)) {
                    self.step(by);
                }
            }
        }
        if std::mem::take(&mut self.moved) {
            let mut state = TextEditState::load(ui.ctx(), id).unwrap_or_default();
            let end = CCursor::new(self.text.chars().count());
            state.cursor.set_char_range(Some(CCursorRange::one(end)));
            state.store(ui.ctx(), id);
        }
        let edit = egui::TextEdit::singleline(&mut self.text).id(id);
        let edit = edit.desired_width(f32::INFINITY);
        let response = ui.add(edit).labelled_by(label);
        if response.changed() {
            self.typed();
        }
        if std::mem::take(&mut self.is_new) {
            response.request_focus();
        }
        let entered = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        if !entered || self.text.trim().is_empty() {
            return None;
        }
        let taken = self.take(false);
        if taken.is_none() {
            response.request_focus();
        }
        taken
    }

    /// The folder's entries; a path that was taken.
    fn list(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let shown = self.shown();
        let [least, most] = LIST;
        let height = (ui.ctx().content_rect().height() * PART).clamp(least, most);
        let scrolls = std::mem::take(&mut self.scrolls);
        let mut clicked = None;
        let frame = egui::Frame::NONE.fill(ui.visuals().extreme_bg_color);
        frame.inner_margin(4.0).show(ui, |ui| {
            let area = egui::ScrollArea::vertical().auto_shrink(false);
            area.max_height(height).show(ui, |ui| {
                let layout = egui::Layout::top_down_justified(egui::Align::LEFT);
                ui.with_layout(layout, |ui| {
                    for entry in shown.iter().take(MOST) {
                        let is_chosen = self.chosen.as_ref() == Some(&entry.name);
                        let response = ui.selectable_label(is_chosen, shown_as(entry));
                        if is_chosen && scrolls {
                            response.scroll_to_me(None);
                        }
                        if response.double_clicked() {
                            clicked = Some((entry.name.clone(), true));
                        } else if response.clicked() {
                            clicked = Some((entry.name.clone(), false));
                        }
                    }
                    if let Some(words) = self.remark(shown.len()) {
                        ui.weak(words);
                    }
                });
            });
        });
        let (name, twice) = clicked?;
        self.choose(&name);
        if twice { self.take(false) } else { None }
    }

    /// What is to be said under the entries.
    fn remark(&self, shown: usize) -> Option<String> {
        let Some(listing) = self.listing.get() else {
            return Some("Waiting for the disk ...".to_owned());
        };
        match &listing.entries {
            Err(_) if self.wants == Wants::Folder && !listing.is_there => {
                Some("This folder will be made.".to_owned())
            }
            Err(fault) => Some(format!("Cannot be listed: {fault}")),
            Ok(_) if shown > MOST => {
                Some(format!("{} more: type a part of the name", shown - MOST))
            }
            Ok(entries) if entries.is_empty() => Some("Nothing here.".to_owned()),
            Ok(_) if shown == 0 => Some("Nothing here is called so.".to_owned()),
            Ok(_) => None,
        }
    }
}

fn shown_as(entry: &Entry) -> String {
    match (&*entry.name, entry.is_folder) {
        (UP, _) => ".. (the folder above)".to_owned(),
        (name, true) => format!("{name}/"),
        (name, false) => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn folder() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for name in ["Oak.ron", "ash.RON", "bark.png", ".hidden.ron"] {
            fs::write(dir.path().join(name), "()").unwrap();
        }
        for name in ["packs", "Old", ".git"] {
            fs::create_dir(dir.path().join(name)).unwrap();
        }
        dir
    }

    fn names(browser: &Browser) -> Vec<String> {
        browser.shown().into_iter().map(|e| e.name).collect()
    }

    fn typed(browser: &mut Browser, text: impl Into<String>) {
        browser.text = text.into();
        browser.typed();
    }

    #[test]
    fn folders_come_first_then_scripts_and_what_is_typed_narrows_them() {
        let dir = folder();
        let mut browser = Browser::new(Wants::Script, dir.path(), "");
        assert_eq!(
            names(&browser),
            ["..", "Old", "packs", "ash.RON", "Oak.ron"]
        );
        let text = browser.text.clone();
        assert!(text.ends_with(std::path::is_separator), "{text}");
        typed(&mut browser, format!("{text}O"));
        assert_eq!(names(&browser), ["Old", "ash.RON", "Oak.ron"]);
        typed(&mut browser, format!("{text}oa"));
        assert_eq!(names(&browser), ["Oak.ron"]);
        typed(&mut browser, format!("{text}.h"));
        assert_eq!(names(&browser), [".hidden.ron"]);
        typed(&mut browser, format!("{text}packs/"));
        assert_eq!(names(&browser), [".."]);
        let folders = Browser::new(Wants::Folder, dir.path(), "");
        assert_eq!(names(&folders), ["..", "Old", "packs"]);
        assert_eq!(folders.take_again(), dir.path());
    }

    impl Browser {
        fn take_again(mut self) -> PathBuf {
            self.take(false).unwrap()
        }
    }

    #[test]
    fn keys_walk_the_list_and_enter_folders() {
        let dir = folder();
        let mut browser = Browser::new(Wants::Script, &dir.path().join("packs"), "");
        browser.step(-1);
        assert_eq!(browser.chosen, None);
        browser.step(1);
        assert_eq!(browser.chosen.as_deref(), Some(".."));
        assert_eq!(browser.take(false), None);
        assert_eq!(browser.folder, dir.path());
        for _ in 0..20 {
            browser.step(1);
        }
        assert_eq!(browser.take(false), Some(dir.path().join("Oak.ron")));
        browser.step(-2);
        assert_eq!(
            (browser.take(true), names(&browser)),
            (None, vec!["..".to_owned()])
        );
    }

    #[test]
    fn a_path_that_leads_nowhere_is_told_and_stays() {
        let dir = folder();
        let mut browser = Browser::new(Wants::Script, dir.path(), "");
        typed(
            &mut browser,
            dir.path().join("elm.ron").display().to_string(),
        );
        assert_eq!(browser.take(false), None);
        let fault = browser.fault.clone().unwrap();
        assert!(fault.contains("elm.ron"), "{fault}");
        typed(
            &mut browser,
            dir.path().join("elm.ro").display().to_string(),
        );
        assert_eq!(browser.fault, None);
    }

    #[test]
    fn a_new_file_keeps_its_name_from_folder_to_folder_and_gets_its_ending() {
        let dir = folder();
        let mut browser = Browser::new(Wants::NewScript, dir.path(), "elm.ron");
        assert_eq!(names(&browser).len(), 5, "its name filters nothing");
        typed(&mut browser, dir.path().join("elm").display().to_string());
        browser.choose("packs");
        assert_eq!(browser.take(true), None);
        assert_eq!(browser.take(true), Some(dir.path().join("packs/elm.ron")));
        typed(
            &mut browser,
            dir.path().join("no/elm").display().to_string(),
        );
        assert_eq!(browser.take(true), None);
        assert!(browser.fault.clone().unwrap().contains("no folder"));
        typed(
            &mut browser,
            dir.path().join("packs/").display().to_string() + "/",
        );
        assert_eq!(browser.take(true), None);
    }

    #[test]
    fn a_folder_to_be_made_may_be_taken_and_a_file_may_not() {
        let dir = folder();
        let mut browser = Browser::new(Wants::Folder, &dir.path().join("new/packs"), "");
        assert_eq!(browser.take(true), Some(dir.path().join("new/packs")));
        typed(
            &mut browser,
            dir.path().join("bark.png/x").display().to_string(),
        );
        assert_eq!(browser.take(true), None);
        assert!(browser.fault.unwrap().contains("bark.png is no folder"));
    }
}

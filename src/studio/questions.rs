//! Questions that are to be answered before anything else, over the window.

use super::app::{Next, Order, Studio};
use super::asking::{self, PATIENCE};
use super::browser::{Browser, Done};
use super::dropping::Copy;
use super::export::{Asked, Form};
use super::palette::Palette;
use super::recovery::Left;
use eframe::egui::{self, Ui};
use std::path::{Path, PathBuf};

/// Room around a question, points.
const MARGIN: f32 = 12.0;

/// A question that is to be answered before anything else.
#[derive(Debug)]
pub(super) enum Question {
    /// What killed windows have left.
    Recover(Vec<Left>),
    /// Something is unsaved, and is to be left for this.
    Unsaved(Next),
    /// The file was changed outside where it was changed here; its text.
    Conflict(String),
    /// A path to read from, or to write to.
    Open(Browser),
    SaveAs(Browser, Option<Next>),
    /// Another file stands at the path that was picked.
    Replace(Browser, PathBuf, Option<Next>),
    Export(Box<Form>),
    /// A picture does not stand beside the script.
    Copy(Copy),
    Palette(Palette),
    /// What the program is, and what draws for it.
    About(String),
}

impl Studio {
    /// The question that is to be answered, if there is one.
    pub(super) fn asking(&mut self, ui: &Ui) {
        let Some(question) = self.question.take() else {
            return;
        };
        let mut answer = None;
        let frame = egui::Frame::popup(ui.style()).inner_margin(MARGIN);
        let room = ui.ctx().content_rect().size() - egui::Vec2::splat(4.0 * MARGIN);
        let modal = egui::Modal::new(egui::Id::unique("studio question")).frame(frame);
        let modal = modal.show(ui.ctx(), |ui| {
            ui.set_max_width(width(&question).min(room.x));
            ui.set_max_height(room.y);
            let area = egui::ScrollArea::vertical().max_height(room.y);
            area.show(ui, |ui| answer = asked(ui, question));
        });
        let Some(answer) = answer else {
            return;
        };
        match answer {
            Answer::Keep(question) => {
                if !modal.should_close() || !may_be_left(&question) {
                    self.question = Some(question);
                }
            }
            Answer::Cancel => {}
            Answer::Go(next) => self.go_on(ui, next),
            Answer::SaveAnd(next) => self.save(ui, None, Some(next)),
            Answer::Settle(theirs, take) => {
                self.document.settle(theirs, take);
                self.renew();
            }
            Answer::SaveTo(browser, path, next) => {
                let (there, own) = (path.clone(), self.document.path().map(Path::to_owned));
                let is_other = move || there.exists() && !is_same(&there, own.as_deref());
                match asking::within(PATIENCE, is_other) {
                    Some(true) => self.question = Some(Question::Replace(browser, path, next)),
                    Some(false) => self.save(ui, Some(&path), next),
                    None => {
                        self.say(ui, format!("{} does not answer", path.display()));
                        self.question = Some(Question::SaveAs(browser, next));
                    }
                }
            }
            Answer::Replace(path, next) => self.save(ui, Some(&path), next),
            Answer::Back(question) => self.question = Some(question),
            Answer::Obey(order) => self.obey(ui, order),
            Answer::Export(out, asked) => self.export(ui, out, asked),
            Answer::Copy(copy) => self.copy_picture(copy),
            Answer::Recover(left, rest) => {
                self.take_over(left);
                // One window holds one text: the next one offers the others.
                if !rest.is_empty() {
                    let count = rest.len();
                    self.say(
                        ui,
                        format!("{count} more can be recovered: open the studio again"),
                    );
                }
            }
            Answer::Forget(left, rest) => {
                let _ = left.discard();
                self.question = (!rest.is_empty()).then_some(Question::Recover(rest));
            }
        }
    }
}

/// True for questions that Escape may leave unanswered.
fn may_be_left(question: &Question) -> bool {
    !matches!(question, Question::Recover(_) | Question::Conflict(_))
}

/// True if a path leads to the document's own file.
fn is_same(path: &Path, own: Option<&Path>) -> bool {
    let whole = |path: &Path| path.canonicalize().ok();
    own.is_some_and(|own| whole(own).is_some() && whole(own) == whole(path))
}

/// Width of a question, points: lists have more room than words.
fn width(question: &Question) -> f32 {
    match question {
        Question::Open(_) | Question::SaveAs(..) | Question::Export(_) | Question::Palette(_) => {
            560.0
        }
        _ => 460.0,
    }
}

/// What was answered.
enum Answer {
    /// Nothing yet.
    Keep(Question),
    Cancel,
    Go(Next),
    SaveAnd(Next),
    Settle(String, bool),
    SaveTo(Browser, PathBuf, Option<Next>),
    Replace(PathBuf, Option<Next>),
    /// Another question is asked again.
    Back(Question),
    Obey(Order),
    Export(PathBuf, Asked),
    Copy(Copy),
    Recover(Left, Vec<Left>),
    Forget(Left, Vec<Left>),
}

fn asked(ui: &mut Ui, question: Question) -> Option<Answer> {
    Some(match question {
        Question::Unsaved(next) => {
            ui.heading("Save the changes?");
            ui.label("What was changed since the last save is lost otherwise.");
            match choice(ui, &["Save", "Discard", "Cancel"]) {
                Some(0) => Answer::SaveAnd(next),
                Some(1) => Answer::Go(next),
                Some(_) => Answer::Cancel,
                None => Answer::Keep(Question::Unsaved(next)),
            }
        }
        Question::Conflict(theirs) => {
            ui.heading("The file was changed outside");
            ui.label(
                "Another program has changed it where it was changed here, too. Taking the file's text can be \
                 undone; keeping this one replaces the file at the next save.",
            );
            match choice(ui, &["Take the file's", "Keep this one"]) {
                Some(answer) => Answer::Settle(theirs, answer == 0),
                None => Answer::Keep(Question::Conflict(theirs)),
            }
        }
        Question::Recover(mut left) => {
            let first = left.pop()?;
            ui.heading("Recover what was not saved?");
            let name = first.note.path.as_ref().map(|p| p.display().to_string());
            let name = name.unwrap_or_else(|| "a new species".to_owned());
            ui.label(format!(
                "A window ended without saving {name}. Its text is still there."
            ));
            match choice(ui, &["Recover", "Discard"]) {
                Some(0) => Answer::Recover(first, left),
                Some(_) => Answer::Forget(first, left),
                None => {
                    left.push(first);
                    Answer::Keep(Question::Recover(left))
                }
            }
        }
        Question::Open(mut browser) => match browser.ui(ui, ("Open a script", "Open"), |_| {}) {
            Some(Done::Take(path)) => Answer::Obey(Order::Ask(Next::Open(path))),
            Some(Done::Cancel) => Answer::Cancel,
            None => Answer::Keep(Question::Open(browser)),
        },
        Question::SaveAs(mut browser, next) => match browser.ui(ui, ("Save as", "Save"), |_| {}) {
            Some(Done::Take(path)) => Answer::SaveTo(browser, path, next),
            Some(Done::Cancel) => Answer::Cancel,
            None => Answer::Keep(Question::SaveAs(browser, next)),
        },
        Question::Replace(browser, path, next) => {
            ui.heading("Replace it?");
            ui.label(format!("There is a file {} already.", path.display()));
            match choice(ui, &["Replace", "Back"]) {
                Some(0) => Answer::Replace(path, next),
                Some(_) => Answer::Back(Question::SaveAs(browser, next)),
                None => Answer::Keep(Question::Replace(browser, path, next)),
            }
        }
        Question::Export(mut form) => match form.ui(ui) {
            Some(Done::Take(out)) => Answer::Export(out, form.asked()),
            Some(Done::Cancel) => Answer::Cancel,
            None => Answer::Keep(Question::Export(form)),
        },
        Question::Copy(copy) => {
            ui.heading("Copy it beside the script?");
            let what = if copy.converts() {
                "Scripts take PNG pictures; the copy is one."
            } else {
                "Scripts look for pictures in their own folder and below."
            };
            ui.label(copy.file.display().to_string());
            ui.label(what);
            match choice(ui, &["Copy", "Cancel"]) {
                Some(0) => Answer::Copy(copy),
                Some(_) => Answer::Cancel,
                None => Answer::Keep(Question::Copy(copy)),
            }
        }
        Question::Palette(mut palette) => match palette.ui(ui) {
            Some(order) => Answer::Obey(order),
            None => Answer::Keep(Question::Palette(palette)),
        },
        Question::About(adapter) => match Studio::about(ui, &adapter) {
            true => Answer::Cancel,
            false => Answer::Keep(Question::About(adapter)),
        },
    })
}

/// Buttons in a row; the number of the one that was pressed.
fn choice(ui: &mut Ui, words: &[&str]) -> Option<usize> {
    ui.add_space(8.0);
    let mut pressed = None;
    ui.horizontal(|ui| {
        for (index, word) in words.iter().enumerate() {
            if ui.button(*word).clicked() {
                pressed = Some(index);
            }
        }
    });
    pressed
}

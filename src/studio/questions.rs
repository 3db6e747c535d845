//! Questions that are to be answered before anything else, over the window.

use super::app::{Next, Order, Studio};
use super::document::Document;
use super::recovery::Left;
use eframe::egui::{self, Key, Ui};
use std::path::Path;

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
    Open(String),
    SaveAs(String, Option<Next>),
    Export(String),
}

impl Studio {
    /// The question that is to be answered, if there is one.
    pub(super) fn asking(&mut self, ui: &Ui) {
        let Some(question) = self.question.take() else {
            return;
        };
        let mut answer = None;
        let modal = egui::Modal::new(egui::Id::unique("studio question")).show(ui.ctx(), |ui| {
            ui.set_max_width(460.0);
            answer = asked(ui, question);
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
            Answer::SaveTo(path, next) => self.save(ui, Some(Path::new(&path)), next),
            Answer::Open(path) => self.obey(ui, Order::Ask(Next::Open(path.into()))),
            Answer::Export(out) => self.export(ui, out.into()),
            Answer::Recover(left, rest) => {
                let note = left.note.clone();
                self.replace(Document::recovered(note));
                // The text is in this window's journal now.
                if self.journal.is_some() {
                    let _ = left.discard();
                }
                self.question = (!rest.is_empty()).then_some(Question::Recover(rest));
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

/// What was answered.
enum Answer {
    /// Nothing yet.
    Keep(Question),
    Cancel,
    Go(Next),
    SaveAnd(Next),
    Settle(String, bool),
    SaveTo(String, Option<Next>),
    Open(String),
    Export(String),
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
        Question::Open(mut path) => match place(ui, "Open a script", &mut path, "Open") {
            Some(true) => Answer::Open(path),
            Some(false) => Answer::Cancel,
            None => Answer::Keep(Question::Open(path)),
        },
        Question::SaveAs(mut path, next) => match place(ui, "Save as", &mut path, "Save") {
            Some(true) => Answer::SaveTo(path, next),
            Some(false) => Answer::Cancel,
            None => Answer::Keep(Question::SaveAs(path, next)),
        },
        Question::Export(mut out) => {
            match place(ui, "Export a pack into the folder", &mut out, "Export") {
                Some(true) => Answer::Export(out),
                Some(false) => Answer::Cancel,
                None => Answer::Keep(Question::Export(out)),
            }
        }
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

/// A path to type; true to go on with it.
fn place(ui: &mut Ui, heading: &str, path: &mut String, verb: &str) -> Option<bool> {
    let label = ui.heading(heading);
    let edit = egui::TextEdit::singleline(path).desired_width(430.0);
    let response = ui.add(edit).labelled_by(label.id);
    if response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter)) && !path.is_empty() {
        return Some(true);
    }
    if !response.has_focus() && ui.memory(|m| m.focused().is_none()) {
        response.request_focus();
    }
    match choice(ui, &[verb, "Cancel"]) {
        Some(0) if !path.is_empty() => Some(true),
        Some(1) => Some(false),
        _ => None,
    }
}

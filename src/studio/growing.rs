//! The tree: sketched at once after each change, grown with all its LODs when the hand rests, both in threads of
//! their own.

use super::app::Studio;
use super::document::Outside;
use super::questions::Question;
use crate::pipeline::{self, Sketcher};
use crate::render::{Model, Textures};
use crate::species::{self, Beside};
use crate::viewer::Subject;
use eframe::egui::Ui;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long nothing must change before a tree is grown with all its LODs.
const REST: Duration = Duration::from_millis(250);

/// A tree and the text that it grew from.
#[derive(Debug)]
pub(super) struct Grown {
    pub(super) subject: Subject,
    pub(super) text: String,
    /// On the device, until the view takes it.
    model: Mutex<Option<Model>>,
}

/// What one sketch leaves to the next.
#[derive(Debug, Default)]
pub(super) struct Sketches {
    sketcher: Sketcher,
    /// The newest textures on the device, by number.
    textures: Option<(u64, Textures)>,
}

impl Studio {
    /// Keeps what is unsaved, sketches the tree at once, and grows it with all its LODs when the hand rests.
    pub(super) fn renew(&mut self) {
        self.keep();
        // Also while it is at fault and nothing grows.
        if let Some(path) = self.document.path() {
            self.watched.note(path);
        }
        self.grower.stop();
        self.seeds.stop();
        self.judging.stop();
        if self.document.reading().species.is_ok() {
            self.sketch();
            self.due = Some(Instant::now() + REST);
        } else {
            self.due = None;
        }
    }

    /// A script to be grown in another thread: its name, its text, and where its files are.
    fn script(&self) -> (String, String, PathBuf) {
        let path = self.document.path();
        let name = path.map_or_else(|| "script".to_owned(), |p| p.display().to_string());
        (
            name,
            self.document.text().to_owned(),
            self.document.folder(),
        )
    }

    fn sketch(&mut self) {
        let (name, text, folder) = self.script();
        let (maker, sketches) = (self.view.maker(), Arc::clone(&self.sketches));
        self.sketcher.ask(Box::new(move |progress| {
            let files = Beside(folder);
            let species = species::parse(&name, &text, &files).map_err(|f| f.render(false))?;
            let mut sketches = sketches.lock().unwrap_or_else(PoisonError::into_inner);
            let settings = pipeline::Settings::default();
            let sketch = sketches.sketcher.sketch(&species, &settings, &files);
            let Some(sketch) = sketch.map_err(|e| e.to_string())? else {
                return Ok(None);
            };
            if progress.cancelled() {
                return Ok(None);
            }
            let number = sketch.textures;
            let same = sketches.textures.take().filter(|(kept, _)| *kept == number);
            let model = maker.make(&sketch.asset.drawable(), same.map(|(_, textures)| textures));
            let model = model.map_err(|e| e.to_string())?;
            sketches.textures = Some((number, model.textures()));
            Ok(Some(Arc::new(Grown {
                subject: sketch.asset.into(),
                text,
                model: Mutex::new(Some(model)),
            })))
        }));
    }

    fn grow(&mut self) {
        self.due = None;
        let (name, text, folder) = self.script();
        let path = self.document.path().map(Path::to_owned);
        let (maker, watched) = (self.view.maker(), self.watched.clone());
        self.grower.ask(Box::new(move |progress| {
            watched.clear();
            if let Some(path) = &path {
                watched.note(path);
            }
            let settings = pipeline::Settings::default();
            let script = (name.as_str(), text.as_str());
            let subject = Subject::grown(script, &folder, &settings, &watched, progress)?;
            let model = maker.make(&subject.drawable(), None);
            let model = model.map_err(|e| e.to_string())?;
            Ok(Grown {
                subject,
                text,
                model: Mutex::new(Some(model)),
            })
        }));
    }

    /// Takes in what the threads have done.
    pub(super) fn listen(&mut self, ui: &Ui) {
        // A question that stands is answered first.
        if self.question.is_none() && self.watch.take() && !self.look(ui) {
            // One of the files that the script names.
            self.document.reread();
            self.renew();
        }
        if self.sketcher.poll().good
            && let Some(sketch) = self.sketcher.good().and_then(|s| (**s).clone())
            && self
                .shown
                .as_ref()
                .is_none_or(|shown| shown.text != sketch.text)
        {
            self.show(sketch);
        }
        if self.grower.poll().good
            && let Some(grown) = self.grower.good().cloned()
        {
            self.grown = Some(Arc::clone(&grown));
            self.number += 1;
            self.show(grown);
            // Its file may have changed before growing began to watch it.
            if self.question.is_none() {
                self.look(ui);
            }
        }
        let written = self.writer.poll();
        self.exported(ui, written);
        let copied = self.copier.poll();
        self.copied(ui, copied);
    }

    /// Takes in what somebody else has written to the file; false if nobody has.
    pub(super) fn look(&mut self, ui: &Ui) -> bool {
        match self.document.look() {
            Ok(Outside::Same) => return false,
            Ok(Outside::Taken) => {
                self.say(ui, "the file was changed outside and is read again");
                self.renew();
            }
            Ok(Outside::Merged) => {
                self.say(ui, "the file was changed outside; both changes are kept");
                self.renew();
            }
            Ok(Outside::Conflict(theirs)) => self.question = Some(Question::Conflict(theirs)),
            Err(error) => self.say(ui, format!("the file cannot be read any more: {error}")),
        }
        true
    }

    fn show(&mut self, tree: Arc<Grown>) {
        let model = tree
            .model
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(model) = model {
            self.view.put(model);
            self.shown = Some(tree);
            self.shows += 1;
            self.fault = None;
        }
    }

    /// Grows the tree with all its LODs once no hand has changed it for a while.
    pub(super) fn rest(&mut self, ui: &Ui) {
        let Some(due) = self.due else {
            return;
        };
        let left = due.saturating_duration_since(Instant::now());
        if !left.is_zero() {
            ui.ctx().request_repaint_after(left);
        } else if ui.input(|i| i.pointer.any_down()) {
            self.due = Some(Instant::now() + REST);
            ui.ctx().request_repaint_after(REST);
        } else {
            self.grow();
        }
    }
}

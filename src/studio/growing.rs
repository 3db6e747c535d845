//! The tree: sketched at once after each change; when the hand rests, sketched as fine as it is, then captured and
//! shaded, and last grown with all its LODs.
//!
//! Sketches and what belongs to them have one thread, whole trees another. Only one of the two works at a time: where a
//! software driver draws, picture and trees share the processor.

use super::app::Studio;
use super::baking::{Baking, SketchBaker};
use super::document::Outside;
use super::questions::Question;
use crate::asset::TreeAsset;
use crate::capture::{self, BakeError};
use crate::pipeline::{self, GenerateError, Haste, Sketch, Sketcher};
use crate::render::{Maker, Model, Textures};
use crate::report::Progress;
use crate::shadow;
use crate::species::{self, Beside};
use crate::viewer::Subject;
use eframe::egui::Ui;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long nothing must change before a tree is grown with all its LODs.
const REST: Duration = Duration::from_millis(250);

/// How long nothing must change before a sketch is made finer than it is while a hand moves, and captured.
const SETTLED: Duration = Duration::from_millis(120);

/// A tree and the text that it grew from.
#[derive(Debug)]
pub(super) struct Grown {
    pub(super) subject: Subject,
    pub(super) text: String,
    /// On the device, until the view takes it.
    model: Mutex<Option<Model>>,
    kind: Kind,
}

/// How much of a tree there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// Few triangles that stand in for it.
    Rough,
    /// Full detail.
    Fine,
    /// With captures and shadows.
    Furnished,
    /// With LODs.
    Whole,
}

/// What is to be done for a tree once nothing has changed for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Due {
    /// It is to be sketched at full detail.
    Fine(Instant),
    /// Its captures and shadows are to be made.
    Furnished(Instant),
    /// It is to be grown with all its LODs.
    Whole(Instant),
}

impl Due {
    fn at(self) -> Instant {
        match self {
            Self::Fine(at) | Self::Furnished(at) | Self::Whole(at) => at,
        }
    }
}

/// What one sketch leaves to the next.
#[derive(Debug, Default)]
pub(super) struct Sketches {
    sketcher: Sketcher,
    baking: Baking,
    /// The newest textures on the device, by number.
    textures: Option<(u64, Textures)>,
    /// The newest sketch at full detail on the device, and the text that it is of.
    model: Option<(String, Model)>,
}

impl Sketches {
    pub(super) fn new(baker: SketchBaker) -> Self {
        Self {
            baking: Baking::new(baker),
            ..Self::default()
        }
    }

    /// Puts a sketch on the device, with the textures of the one before if they are the same.
    fn put(&mut self, maker: &Maker, sketch: &Sketch, text: &str) -> Result<Model, String> {
        let number = sketch.textures;
        let same = self.textures.take().filter(|(kept, _)| *kept == number);
        let textures = same.map(|(_, textures)| textures);
        let meshes = (&sketch.stand_ins[..], sketch.is_rough);
        let model = maker.sketch(&sketch.asset.drawable(), meshes, textures);
        let model = model.map_err(|e| e.to_string())?;
        self.textures = Some((number, model.textures()));
        if !sketch.is_rough {
            self.model = Some((text.to_owned(), model.clone()));
        }
        Ok(model)
    }
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
            // A graphics card draws all of it in time.
            let is_slow = self.view.is_software();
            self.sketch(if is_slow { Haste::Great } else { Haste::None });
            self.due = Some(Due::Fine(Instant::now() + SETTLED));
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

    fn sketch(&mut self, haste: Haste) {
        let (name, text, folder) = self.script();
        let (maker, sketches) = (self.view.maker(), Arc::clone(&self.sketches));
        self.asked_of_sketcher(haste == Haste::Some, move |progress| {
            let files = Beside(folder);
            let species = species::parse(&name, &text, &files).map_err(|f| f.render(false))?;
            let mut sketches = sketches.lock().unwrap_or_else(PoisonError::into_inner);
            let settings = pipeline::Settings::default();
            let sketch = sketches
                .sketcher
                .sketch_in(haste, &species, &settings, &files);
            let Some(sketch) = sketch.map_err(|e| e.to_string())? else {
                return Ok(None);
            };
            if progress.cancelled() {
                return Ok(None);
            }
            let model = sketches.put(&maker, &sketch, &text)?;
            let kind = if sketch.is_rough {
                Kind::Rough
            } else {
                Kind::Fine
            };
            Ok(Some(Arc::new(Grown::new(
                (sketch.asset, text),
                model,
                kind,
            ))))
        });
    }

    /// Makes captures and shadows for the sketch that is shown, if it is at full detail and what the text says.
    fn furnish(&mut self) {
        let sketch = self
            .shown
            .clone()
            .filter(|shown| shown.kind == Kind::Fine && shown.text == self.document.text());
        let Some(sketch) = sketch else {
            return;
        };
        let (name, text, folder) = self.script();
        let (maker, sketches) = (self.view.maker(), Arc::clone(&self.sketches));
        let is_software = self.view.is_software();
        self.asked_of_sketcher(true, move |progress| {
            let files = Beside(folder);
            let species = species::parse(&name, &text, &files).map_err(|f| f.render(false))?;
            let mut sketches = sketches.lock().unwrap_or_else(PoisonError::into_inner);
            let of_text = sketches.model.as_ref().filter(|(of, _)| *of == text);
            let model = of_text.map(|(_, model)| model.clone());
            let (Some(asset), Some(model)) = (sketch.subject.asset(), model) else {
                return Ok(None);
            };
            let Sketches {
                sketcher, baking, ..
            } = &mut *sketches;
            let mut furnish = |settings: &pipeline::Settings| {
                baking.bake(is_software, |bakers| {
                    sketcher.furnish(bakers, (asset, &species), settings, &files, progress)
                })
            };
            let furnished = furnish(&first_pass()).or_else(|error| match error {
                GenerateError::Bake(BakeError::AtlasTooSmall { .. }) => {
                    furnish(&pipeline::Settings::default())
                }
                error => Err(error),
            });
            let furnished = furnished.map_err(|e| e.to_string())?;
            let model = maker.shaded(&model, &furnished.shadows);
            let model = model.map_err(|e| e.to_string())?;
            sketches.model = None;
            let grown = Grown::new((furnished, text), model, Kind::Furnished);
            Ok(Some(Arc::new(grown)))
        });
    }

    /// Gives the thread of sketches something to do. A hasty sketch that it is at is finished and shown: while a hand
    /// moves on, there is always a newer one.
    fn asked_of_sketcher(
        &mut self,
        is_slow: bool,
        work: impl FnOnce(&dyn Progress) -> Result<Option<Arc<Grown>>, String> + Send + 'static,
    ) {
        let job = Box::new(work);
        if std::mem::replace(&mut self.sketches_slowly, is_slow) {
            self.sketcher.ask(job);
        } else {
            self.sketcher.follow(job);
        }
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
                kind: Kind::Whole,
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
                .is_none_or(|shown| shown.text != sketch.text || shown.kind < sketch.kind)
        {
            if sketch.kind == Kind::Furnished {
                self.furnished = Some(Arc::clone(&sketch));
                self.furnishings += 1;
            }
            self.show(sketch);
        }
        if self.grower.poll().good
            && let Some(grown) = self.grower.good().cloned()
        {
            self.grown = Some(Arc::clone(&grown));
            self.furnished = None;
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
            let shown = self.shown.as_ref();
            let is_finer = shown.is_some_and(|shown| shown.text == tree.text);
            self.view.put(model, is_finer);
            self.shown = Some(tree);
            self.shows += 1;
            self.fault = None;
        }
    }

    /// True if the sketcher is at a tree, or at captures and shadows, that the view has not: what is shown is then not
    /// worth a picture in full, which takes a software driver longer and would hold the sketcher up.
    pub(super) fn is_awaited(&self) -> bool {
        self.sketcher.stage().is_some()
    }

    /// Makes the tree finer, and at last whole, once no hand has changed it for a while.
    pub(super) fn rest(&mut self, ui: &Ui) {
        let Some(due) = self.due else {
            return;
        };
        if self.sketcher.stage().is_some() {
            // It wakes the window when it is done.
            return;
        }
        let left = due.at().saturating_duration_since(Instant::now());
        if !left.is_zero() {
            return ui.ctx().request_repaint_after(left);
        }
        let rough = |shown: &Arc<Grown>| shown.kind == Kind::Rough;
        match due {
            Due::Fine(at) => {
                if self.shown.as_ref().is_some_and(rough) && self.is_up_to_date() {
                    self.sketch(Haste::Some);
                }
                self.due = Some(Due::Furnished(at));
            }
            Due::Furnished(at) => {
                self.furnish();
                self.due = Some(Due::Whole(at + REST - SETTLED));
            }
            Due::Whole(_) if ui.input(|i| i.pointer.any_down()) => {
                self.due = Some(Due::Whole(Instant::now() + REST));
            }
            Due::Whole(_) => return self.grow(),
        }
        ui.ctx().request_repaint();
    }
}

/// How captures and shadows are made that are wanted soon: with a quarter of the texels, and half of the samples.
fn first_pass() -> pipeline::Settings {
    let whole = pipeline::Settings::default();
    pipeline::Settings {
        captures: capture::Settings {
            atlas_size: whole.captures.atlas_size / 2,
            ..whole.captures
        },
        shadows: shadow::Settings {
            samples: whole.shadows.samples / 2,
            ..whole.shadows
        },
        ..whole
    }
}

impl Grown {
    fn new((asset, text): (TreeAsset, String), sketch: Model, kind: Kind) -> Self {
        let mut subject = Subject::from(asset);
        subject.stand_ins = sketch.stand_ins.iter().map(|lod| lod.triangles).collect();
        Self {
            subject,
            text,
            model: Mutex::new(Some(sketch)),
            kind,
        }
    }
}

//! Packs: what is asked before they are written, and how they are, in a thread of its own.

use super::app::Studio;
use super::browser::{Browser, Done};
use super::folder::Wants;
use super::growing::Grown;
use super::kept::{ATLASES, Export};
use crate::batch::{self, Item, Observer, Outcome, Plan, RunOptions};
use crate::pack::{self, Replace};
use crate::pipeline;
use crate::report::Progress;
use crate::species::edit;
use crate::species::schema::{Species, Variation};
use crate::species::{self, Beside};
use crate::viewer::loader::Polled;
use eframe::egui::{self, Ui};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The question where and how packs are to be written.
#[derive(Debug)]
pub(super) struct Form {
    browser: Browser,
    asked: Asked,
}

/// What is to be written, and how.
#[derive(Clone, Debug)]
pub(super) struct Asked {
    options: Export,
    /// True to replace packs of other versions.
    force: bool,
    which: Which,
    /// The script's named variations, true for those that are wanted.
    variations: Vec<(String, bool)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Which {
    Tree,
    Variations,
}

/// What came of an export.
#[derive(Debug)]
pub(super) struct Written {
    /// The pack, or the folder of several.
    pub(super) folder: PathBuf,
    packs: usize,
    failed: Vec<String>,
}

/// What is told of exports under the panes.
#[derive(Debug, Default)]
pub(super) struct Exports {
    /// What the thread is about.
    doing: Arc<Mutex<String>>,
    /// What was written last, until it is put away.
    done: Option<Arc<Written>>,
    /// Why a folder could not be shown; written by the thread that tried.
    unseen: Arc<Mutex<Option<String>>>,
}

impl Form {
    pub(super) fn new(out: &Path, options: Export, species: Option<&Species>) -> Self {
        let variations = species.map_or(&[][..], |s| &s.variations);
        let variations = variations.iter().map(|v| (v.name.clone(), true)).collect();
        Self {
            browser: Browser::new(Wants::Folder, out, ""),
            asked: Asked {
                options,
                force: false,
                which: Which::Tree,
                variations,
            },
        }
    }

    /// The question; where to write, once it is answered.
    pub(super) fn ui(&mut self, ui: &mut Ui) -> Option<Done> {
        let words = ("Export a pack into the folder", "Export");
        let Self { browser, asked } = self;
        browser.ui(ui, words, |ui| {
            ui.add_space(6.0);
            asked.trees(ui);
            ui.add_space(6.0);
            asked.options(ui);
        })
    }

    pub(super) fn asked(self) -> Asked {
        self.asked
    }
}

impl Asked {
    fn trees(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.radio_value(&mut self.which, Which::Tree, "This tree");
            let some = !self.variations.is_empty();
            ui.add_enabled_ui(some, |ui| {
                ui.radio_value(&mut self.which, Which::Variations, "Its variations")
                    .on_disabled_hover_text("The script names none yet");
            });
        });
        if self.which == Which::Variations {
            ui.horizontal_wrapped(|ui| {
                for (name, wanted) in &mut self.variations {
                    ui.checkbox(wanted, &**name);
                }
            });
        }
    }

    fn options(&mut self, ui: &mut Ui) {
        let options = &mut self.options;
        ui.horizontal(|ui| {
            let name = ui.label("Foliage atlas").id;
            let size = |edge: u32| format!("{edge} x {edge} texels");
            egui::ComboBox::from_id_salt("atlas size")
                .selected_text(size(options.atlas_size))
                .show_ui(ui, |ui| {
                    for edge in ATLASES {
                        ui.selectable_value(&mut options.atlas_size, edge, size(edge));
                    }
                })
                .response
                .labelled_by(name);
        });
        ui.checkbox(
            &mut options.mips,
            "Mips of the atlas that keep its coverage",
        );
        ui.checkbox(&mut options.embed, "Textures inside each GLB as well");
        ui.checkbox(&mut options.full, "Full detail as the first LOD");
        let mut wind = !options.no_wind;
        ui.checkbox(&mut wind, "How vertices sway in the wind");
        options.no_wind = !wind;
        ui.checkbox(&mut self.force, "Replace packs that another version wrote");
    }

    fn replace(&self) -> Replace {
        if self.force {
            Replace::AnyPack
        } else {
            Replace::OwnPacks
        }
    }
}

/// A script's text and where it stands.
struct Script {
    /// Its file, or where it would be.
    path: PathBuf,
    text: String,
}

impl Studio {
    /// Asks where and how packs are to be written.
    pub(super) fn ask_export(&self) -> Form {
        let options = self.kept.now.export.clone();
        let species = self.document.reading().species.as_deref().ok();
        Form::new(&self.out, options, species)
    }

    /// Begins to write what was asked for, into packs in `out`.
    pub(super) fn export(&mut self, ui: &Ui, out: PathBuf, asked: Asked) {
        let Ok(species) = &self.document.reading().species else {
            return self.say(ui, "the script is at fault; there is nothing to export");
        };
        let wanted = asked.variations.iter().filter(|(_, wanted)| *wanted);
        let names: Vec<String> = wanted.map(|(name, _)| name.clone()).collect();
        let variations = asked.which == Which::Variations;
        if variations && names.is_empty() {
            return self.say(ui, "no variation is chosen; nothing is exported");
        }
        let species = species.clone();
        let path = self.document.path().map(Path::to_owned);
        let script = Script {
            path: path.unwrap_or_else(|| PathBuf::from("script")),
            text: self.document.text().to_owned(),
        };
        self.out.clone_from(&out);
        self.kept.now.export = Export {
            folder: std::path::absolute(&out).ok(),
            ..asked.options.clone()
        };
        self.exports.done = None;
        let doing = Arc::clone(&self.exports.doing);
        say(&doing, "writing ...".to_owned());
        // A tree that stands there already as it is asked for is not grown again.
        let as_grown = asked.options.settings() == pipeline::Settings::default();
        let grown = self
            .grown
            .clone()
            .filter(|g| as_grown && g.text == script.text);
        self.writer.ask(Box::new(move |progress| {
            if variations {
                several(
                    &script,
                    (&species, &names),
                    &out,
                    (&asked, &doing),
                    progress,
                )
            } else {
                single(&script, grown.as_deref(), &out, (&asked, &doing), progress)
            }
        }));
    }

    /// Takes in what the thread has written.
    pub(super) fn exported(&mut self, ui: &Ui, polled: Polled) {
        if polled.good {
            self.exports.done = self.writer.good().cloned();
        } else if polled.changed
            && let Some(fault) = self.writer.fault().map(str::to_owned)
        {
            self.say(ui, format!("nothing is exported: {fault}"));
        }
        let unseen = self.exports.unseen.lock();
        let unseen = unseen.unwrap_or_else(PoisonError::into_inner).take();
        if let Some(fault) = unseen {
            self.say(ui, fault);
        }
    }

    /// What is being written, or was written last.
    pub(super) fn export_bar(&mut self, ui: &mut Ui) {
        if let Some(stage) = self.writer.stage() {
            let doing = self.exports.doing.lock();
            let mut words = doing.unwrap_or_else(PoisonError::into_inner).clone();
            if !["", "writing"].contains(&stage.name) {
                words += &format!(": {}", stage.name);
            }
            let mut cancelled = false;
            egui::Panel::bottom("export").show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label(words);
                    cancelled = ui.button("Cancel the export").clicked();
                });
            });
            if cancelled {
                self.writer.stop();
                self.say(ui, "the export is cancelled; nothing half-written is left");
            }
            return;
        }
        let Some(done) = self.exports.done.clone() else {
            return;
        };
        egui::Panel::bottom("export").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let folder = done.folder.display().to_string();
                ui.label(match done.packs {
                    1 => format!("{folder} is written"),
                    count => format!("{count} packs are written into {folder}"),
                });
                if ui.button("Show folder").clicked() {
                    show_folder(&done.folder, &self.exports.unseen, ui.ctx());
                }
                if ui.button("Copy path").clicked() {
                    ui.ctx().copy_text(folder);
                }
                if ui.button("Close").clicked() {
                    self.exports.done = None;
                }
            });
            for fault in &done.failed {
                ui.colored_label(ui.visuals().error_fg_color, fault);
            }
        });
    }
}

fn say(doing: &Mutex<String>, words: String) {
    *doing.lock().unwrap_or_else(PoisonError::into_inner) = words;
}

/// Writes the script's own tree.
fn single(
    script: &Script,
    grown: Option<&Grown>,
    out: &Path,
    (asked, doing): (&Asked, &Mutex<String>),
    progress: &dyn Progress,
) -> Result<Written, String> {
    let new;
    let asset = match grown.and_then(|g| g.subject.asset()) {
        Some(asset) => asset,
        None => {
            say(doing, "growing the tree".to_owned());
            let files = Beside(script.path.parent().unwrap_or(Path::new("")).to_owned());
            let name = script.path.display().to_string();
            let species = species::parse(&name, &script.text, &files);
            let species = species.map_err(|faults| faults.to_string())?;
            let settings = asked.options.settings();
            new = pipeline::generate(&species, &settings, &files, progress)
                .map_err(|error| error.to_string())?;
            &new
        }
    };
    let name = pack::folder_name(&asset.slug, asset.seed);
    say(doing, format!("writing {name}"));
    progress.begin("writing", 0);
    pack::sweep(out, |other| other == name);
    let files = pack::build(asset, script.text.as_bytes(), asked.options.options());
    let files = files.map_err(|error| error.to_string())?;
    if progress.cancelled() {
        return Err("cancelled".to_owned());
    }
    let folder = pack::write(out, &name, &files, asked.replace());
    Ok(Written {
        folder: folder.map_err(|error| error.to_string())?,
        packs: 1,
        failed: Vec::new(),
    })
}

/// Writes some of the script's variations, as `pleach batch` would.
fn several(
    script: &Script,
    (species, names): (&Species, &[String]),
    out: &Path,
    (asked, doing): (&Asked, &Mutex<String>),
    progress: &dyn Progress,
) -> Result<Written, String> {
    let is_wanted = |v: &&Variation| names.contains(&v.name);
    let variations = species.variations.iter().filter(is_wanted);
    let items = variations.enumerate().map(|(index, variation)| {
        let text = edit::vary(&script.text, species, variation).map_err(|e| e.to_string())?;
        Ok(item(index, &script.path, text))
    });
    let plan = Plan {
        items: items.collect::<Result<_, String>>()?,
    };
    let following = Following {
        progress,
        doing,
        count: plan.items.len(),
        under_way: Mutex::default(),
    };
    progress.begin("writing", plan.items.len() as u64);
    let options = RunOptions {
        out: out.to_owned(),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        resume: false,
        replace: asked.replace(),
        pack: asked.options.options(),
        settings: asked.options.settings(),
    };
    let outcomes = batch::run(&plan, &options, &following).map_err(|error| error.to_string())?;
    let failed = plan.items.iter().zip(&outcomes);
    let failed: Vec<String> = failed
        .filter_map(|(item, outcome)| match outcome {
            Outcome::Failed { reason, .. } => Some(format!("{}: {reason}", item.folder)),
            _ => None,
        })
        .collect();
    let is_made = |outcome: &&Outcome| matches!(outcome, Outcome::Made { .. });
    match outcomes.iter().filter(is_made).count() {
        0 => Err(failed.join("\n")),
        packs => Ok(Written {
            folder: out.to_owned(),
            packs,
            failed,
        }),
    }
}

fn item(index: usize, path: &Path, script: String) -> Item {
    let files = Beside(path.parent().unwrap_or(Path::new("")).to_owned());
    let species = species::parse(&path.display().to_string(), &script, &files);
    let folder = match &species {
        Ok(species) => pack::folder_name(&species.slug, species.seed),
        Err(_) => format!("variation {index}"),
    };
    Item {
        index,
        folder,
        path: path.to_owned(),
        script,
        seed: species.as_ref().map_or(1, |s| s.seed),
        budgets: None,
        texture_size: None,
        species: species.map(Box::new).map_err(|faults| faults.to_string()),
    }
}

/// Tells the window how far a batch is.
struct Following<'a> {
    progress: &'a dyn Progress,
    doing: &'a Mutex<String>,
    count: usize,
    /// How many packs are done, and the names of those that are not.
    under_way: Mutex<(usize, Vec<String>)>,
}

impl Following<'_> {
    fn tell(&self, change: impl FnOnce(&mut usize, &mut Vec<String>)) {
        let under_way = self.under_way.lock();
        let (done, names) = &mut *under_way.unwrap_or_else(PoisonError::into_inner);
        change(done, names);
        say(self.doing, wording(*done, self.count, names));
    }
}

/// How far a batch is, in words.
fn wording(done: usize, count: usize, names: &[String]) -> String {
    let number = (done + 1).min(count);
    let more = match names.len() {
        0 | 1 => String::new(),
        several => format!(" and {} more", several - 1),
    };
    let name = names.first().map_or("", String::as_str);
    format!("writing {number} of {count}: {name}{more}")
}

impl Observer for Following<'_> {
    fn item<'a>(&'a self, _worker: usize, item: &Item) -> Box<dyn Progress + 'a> {
        self.tell(|_, names| names.push(item.folder.clone()));
        Box::new(Within(self.progress))
    }

    fn done(&self, _worker: usize, item: &Item, _outcome: &Outcome) {
        self.tell(|done, names| {
            *done += 1;
            names.retain(|name| *name != item.folder);
        });
        self.progress.step();
    }

    fn cancelled(&self) -> bool {
        self.progress.cancelled()
    }
}

/// One tree of several: its stages are not told, and it is given up with them.
struct Within<'a>(&'a dyn Progress);

impl Progress for Within<'_> {
    fn begin(&self, _stage: &'static str, _steps: u64) {}

    fn step(&self) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Opens a folder with the system's program for that. It may run as long as its window, so a thread waits for it.
fn show_folder(folder: &Path, unseen: &Arc<Mutex<Option<String>>>, ctx: &egui::Context) {
    let program = if cfg!(windows) {
        "explorer"
    } else if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let mut command = std::process::Command::new(program);
    command.arg(folder);
    let (theirs, ctx) = (Arc::clone(unseen), ctx.clone());
    let wait = move || {
        let fault = match command.status() {
            // Explorer says that it failed whatever it did.
            Ok(status) if status.success() || cfg!(windows) => return,
            Ok(status) => format!("the folder cannot be shown: {program} ended with {status}"),
            Err(error) => format!("the folder cannot be shown: {program}: {error}"),
        };
        *theirs.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
        ctx.request_repaint();
    };
    let thread = std::thread::Builder::new().name("show folder".to_owned());
    if let Err(error) = thread.spawn(wait) {
        let fault = format!("the folder cannot be shown: {error}");
        *unseen.lock().unwrap_or_else(PoisonError::into_inner) = Some(fault);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn how_far_a_batch_is_counts_what_is_done() {
        let names = ["a-1", "b-2", "c-3"].map(str::to_owned);
        assert_eq!(wording(0, 4, &names), "writing 1 of 4: a-1 and 2 more");
        assert_eq!(wording(3, 4, &names[..1]), "writing 4 of 4: a-1");
        assert_eq!(wording(4, 4, &[]), "writing 4 of 4: ");
    }
}

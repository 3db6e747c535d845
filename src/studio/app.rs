//! The window's state: the document, the panes around it, and the threads that grow and write its tree.

use super::asking;
use super::baking::SketchBaker;
use super::browser::Browser;
use super::closeups::Closeups;
use super::dock::{Layout, Pane};
use super::document::{Document, Edit};
use super::drawings::Drawings;
use super::dropping::Copied;
use super::export::{Exports, Written};
use super::folder::Wants;
use super::form::Change;
use super::growing::{Due, Grown, Sketches};
use super::hand::Hand;
use super::judging::Judging;
use super::kept::{Keeper, Theme};
use super::palette::Palette;
use super::panes::Panes;
use super::pictures::Pictures;
use super::presence::Presence;
use super::questions::Question;
use super::recovery::{Left, Note};
use super::scribe::Scribe;
use super::seeds::Seeds;
use super::{menu, outline};
use crate::gpu::GpuError;
use crate::render::forest::ForestError;
use crate::species::edit::EditError;
use crate::species::fault::Fault;
use crate::viewer::keys::Action;
use crate::viewer::loader::Loader;
use crate::viewer::settings::Settings;
use crate::viewer::watch::{Watch, Watched};
use crate::viewer::{StartError, Subject, Viewport};
use eframe::egui::{self, RichText, Ui};
use eframe::egui_wgpu::RenderState;
use egui_tiles::Tree;
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How long a file that is to be opened may keep the window waiting.
const OPENING: Duration = Duration::from_secs(3);

/// Seconds that a message is shown.
const MESSAGE: f64 = 6.0;

/// What a window begins with.
#[derive(Debug)]
pub struct Begin {
    /// What is worked on.
    pub document: Document,
    /// Folder of notes of what is unsaved; none to keep none.
    pub notes: Option<PathBuf>,
    /// What killed windows have left.
    pub left: Vec<Left>,
    /// Folder that packs are written into.
    pub out: PathBuf,
    /// Who makes the captures and the shadows of sketches.
    pub baker: SketchBaker,
    /// Settings that outlive the window.
    pub kept: Keeper,
    /// True once the program is to end.
    pub stop: fn() -> bool,
}

impl Begin {
    /// A window on a document that keeps no notes.
    #[must_use]
    pub fn new(document: Document) -> Self {
        Self {
            document,
            notes: None,
            left: Vec::new(),
            out: PathBuf::from("packs"),
            baker: SketchBaker::default(),
            kept: Keeper::default(),
            stop: || false,
        }
    }
}

/// What is done once nothing is unsaved.
#[derive(Clone, Debug)]
pub(super) enum Next {
    Close,
    Open(PathBuf),
    New(String),
}

/// What the user wants done.
#[derive(Clone, Debug)]
pub(super) enum Order {
    Ask(Next),
    Save,
    SaveAs,
    Open,
    Export,
    Undo,
    Redo,
    Select(String),
    Change(Change),
    Palette,
    Hints,
    About,
    Scale(menu::Scale),
    Theme(Theme),
    ForgetRecent,
    ResetLayout,
    Act(Action),
}

/// The studio's state.
pub struct Studio {
    pub(super) document: Document,
    scribe: Option<Scribe>,
    pub(super) out: PathBuf,
    stop: fn() -> bool,
    pub(super) view: Viewport,
    pub(super) settings: Settings,
    /// The tree that is shown: often a sketch.
    pub(super) shown: Option<Arc<Grown>>,
    /// The last tree with all its LODs.
    pub(super) grown: Option<Arc<Grown>>,
    /// A newer tree that has captures and shadows, and no LODs yet.
    pub(super) furnished: Option<Arc<Grown>>,
    /// How many of those there were.
    pub(super) furnishings: u64,
    /// How many trees with all their LODs there were.
    pub(super) number: u64,
    pub(super) sketcher: Loader<Option<Arc<Grown>>>,
    pub(super) sketches: Arc<Mutex<Sketches>>,
    /// True if what the sketcher was asked for last takes its time, so that another edit is not to wait for it.
    pub(super) sketches_slowly: bool,
    pub(super) grower: Loader<Grown>,
    /// What is to be done for the tree next, and when.
    pub(super) due: Option<Due>,
    pub(super) writer: Loader<Written>,
    pub(super) exports: Exports,
    pub(super) copier: Loader<Copied>,
    pub(super) watch: Watch,
    pub(super) watched: Watched,
    selected: String,
    pub(super) dock: Tree<Pane>,
    message: Option<(String, f64)>,
    pub(super) fault: Option<String>,
    pub(super) question: Option<Question>,
    closing: bool,
    title: String,
    pictures: Pictures,
    closeups: Closeups,
    drawings: RefCell<Drawings>,
    pub(super) seeds: Seeds,
    /// What is done in the next frame, once what was typed in this one is taken.
    postponed: Vec<Order>,
    /// How many trees were shown.
    pub(super) shows: u64,
    hand: Hand,
    pub(super) judging: Judging,
    pub(super) kept: Keeper,
    /// True once the window looks as was kept.
    pub(super) is_settled: bool,
    /// The script that was remembered last.
    pub(super) remembered: Option<PathBuf>,
    pub(super) presence: Presence,
    pub(super) shows_hints: bool,
}

impl std::fmt::Debug for Studio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Studio")
            .field("path", &self.document.path())
            .field("selected", &self.selected)
            .finish_non_exhaustive()
    }
}

impl Studio {
    /// The window's state; its tree begins to grow. `wake` is called from other threads when there is something
    /// to be shown.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn new(
        state: &RenderState,
        begin: Begin,
        wake: impl Fn() + Clone + Send + Sync + 'static,
    ) -> Result<Self, StartError> {
        let watched = Watched::default();
        let watch = Watch::start(watched.clone(), begin.stop, wake.clone())?;
        let settings = Settings {
            panel: false,
            person: true,
            ..Settings::default()
        };
        let mut studio = Self {
            document: begin.document,
            scribe: begin
                .notes
                .map(|folder| Scribe::start(folder, wake.clone()))
                .transpose()?,
            out: begin.out,
            stop: begin.stop,
            view: Viewport::new(state)?,
            settings,
            shown: None,
            grown: None,
            furnished: None,
            furnishings: 0,
            number: 0,
            sketcher: Loader::start("sketch", wake.clone())?,
            sketches: Arc::new(Mutex::new(Sketches::new(begin.baker))),
            sketches_slowly: true,
            grower: Loader::start("grow", wake.clone())?,
            due: None,
            writer: Loader::start("write", wake.clone())?,
            hand: Hand::start(wake.clone())?,
            judging: Judging::start(wake.clone())?,
            exports: Exports::default(),
            copier: Loader::start("copy", wake.clone())?,
            watch,
            watched,
            selected: String::new(),
            dock: Layout::read(&begin.kept.now.dock)
                .unwrap_or_else(Layout::usual)
                .dock(),
            message: None,
            fault: None,
            question: (!begin.left.is_empty()).then_some(Question::Recover(begin.left)),
            closing: false,
            title: String::new(),
            pictures: Pictures::default(),
            closeups: Closeups::default(),
            drawings: RefCell::new(Drawings::start(wake.clone())?),
            seeds: Seeds::start(wake)?,
            postponed: Vec::new(),
            shows: 0,
            // Who keeps nothing would see them each time.
            shows_hints: begin.kept.keeps() && begin.kept.now.hints,
            kept: begin.kept,
            is_settled: false,
            remembered: None,
            presence: Presence::default(),
        };
        studio.renew();
        Ok(studio)
    }

    /// The document.
    #[must_use]
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The tree, if it is the one that the text says: growing is over and nothing is at fault.
    #[must_use]
    pub fn subject(&self) -> Option<&Subject> {
        let grown = self.grown.as_deref()?;
        (grown.text == self.document.text()).then_some(&grown.subject)
    }

    /// True if what is shown is the tree that the text says, be it a sketch.
    #[must_use]
    pub fn is_up_to_date(&self) -> bool {
        let shown = self.shown.as_ref();
        shown.is_some_and(|shown| shown.text == self.document.text())
    }

    /// True if there are captures and shadows of the tree that the text says, be it without LODs yet.
    #[must_use]
    pub fn is_furnished(&self) -> bool {
        let there = self.furnished.as_ref().or(self.grown.as_ref());
        there.is_some_and(|tree| tree.text == self.document.text())
    }

    /// Who made the captures and the shadows that are shown, unless it was the processor.
    #[must_use]
    pub fn baker(&self) -> Option<&str> {
        let there = self.furnished.as_ref().or(self.grown.as_ref());
        there.and_then(|tree| tree.subject.asset()?.baker.as_deref())
    }

    /// True if the grid of seeds has all its pictures.
    #[must_use]
    pub fn has_all_seeds(&self) -> bool {
        self.seeds.is_whole()
    }

    /// Path of the part whose page is shown.
    pub(super) fn selected(&self) -> &str {
        &self.selected
    }

    /// What is being said.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().map(|(text, _)| text.as_str())
    }

    /// What is unsaved, if there is anything to lose.
    fn note(&self) -> Option<Note> {
        // A new document to which nothing was done is nothing to lose.
        self.document.note().filter(|_| self.has_work())
    }

    /// Keeps what is unsaved over a kill.
    pub(super) fn keep(&mut self) {
        let note = self.note();
        if let Some(scribe) = &mut self.scribe {
            scribe.keep(note);
        }
    }

    /// Takes over the text that a killed window has left; its note goes once this window has one.
    pub(super) fn take_over(&mut self, left: Left) {
        self.replace(Document::recovered(left.note.clone()));
        let note = self.note();
        if let Some(scribe) = &mut self.scribe {
            scribe.take_over(note, left);
        }
    }

    pub(super) fn say(&mut self, ui: &Ui, text: impl Into<String>) {
        self.message = Some((text.into(), ui.input(|i| i.time) + MESSAGE));
    }

    fn fail(&mut self, error: &ForestError) {
        if matches!(error, ForestError::Gpu(GpuError::Lost(_))) {
            // The text is safe in the journal, and the next window offers it.
            self.closing = true;
        }
        self.fault = Some(error.to_string());
    }

    /// Puts another document in the place of this one.
    pub(super) fn replace(&mut self, document: Document) {
        self.document = document;
        self.copier.stop();
        // What is under way is of the other script.
        self.sketcher.stop();
        self.selected = String::new();
        // The tree of another script is no last sound one of this.
        (self.shown, self.furnished, self.grown) = (None, None, None);
        self.view.reframe();
        self.renew();
    }

    pub(super) fn go_on(&mut self, ui: &Ui, next: Next) {
        match next {
            Next::Close => {
                self.closing = true;
                if let Some(scribe) = &mut self.scribe {
                    scribe.keep(None);
                }
                ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Next::New(text) => self.replace(Document::new(text)),
            Next::Open(path) => {
                let there = path.clone();
                match asking::within(OPENING, move || Document::open(&there)) {
                    Some(Ok(document)) => self.replace(document),
                    Some(Err(error)) => {
                        self.say(ui, format!("cannot read {}: {error}", path.display()));
                    }
                    None => self.say(ui, format!("{} does not answer", path.display())),
                }
            }
        }
    }

    pub(super) fn obey(&mut self, ui: &Ui, order: Order) {
        match order {
            Order::Ask(Next::Close) if self.writer.stage().is_some() => self.say(ui, EXPORTING),
            Order::Ask(next) if self.document.is_unsaved() && self.has_work() => {
                self.question = Some(Question::Unsaved(next));
            }
            Order::Ask(next) => self.go_on(ui, next),
            Order::Save => self.save(ui, None, None),
            Order::SaveAs => self.ask_where(None),
            Order::Open => {
                let browser = Browser::new(Wants::Script, &self.document.folder(), "");
                self.question = Some(Question::Open(browser));
            }
            Order::Export if self.writer.stage().is_some() => {
                self.say(ui, "an export is under way; cancel it first, or wait");
            }
            Order::Export => {
                self.question = Some(Question::Export(Box::new(self.ask_export())));
            }
            Order::Undo => {
                if self.document.undo() {
                    self.renew();
                }
            }
            Order::Redo => {
                if self.document.redo() {
                    self.renew();
                }
            }
            Order::Select(path) => self.selected = path,
            Order::Change(Change::Rest) => {
                self.document.rest();
                if let Some(scribe) = &self.scribe {
                    scribe.hurry();
                }
            }
            Order::Change(Change::Edit(name, gesture, edit)) => {
                if let Err(error) = self.apply(&name, gesture.as_deref(), edit) {
                    self.say(ui, error.to_string());
                }
            }
            Order::Palette => self.question = Some(Question::Palette(Palette::default())),
            Order::Hints => self.shows_hints = true,
            Order::About => self.question = Some(Question::About(self.view.describe())),
            Order::Scale(scale) => self.scale(ui, scale),
            Order::Theme(theme) => ui.ctx().set_theme(theme),
            Order::ForgetRecent => self.kept.now.recent.clear(),
            Order::ResetLayout => self.dock = Layout::usual().dock(),
            Order::Act(action) => self.act(action),
        }
    }

    /// Does something to the document, as [`Document::apply`] does, and begins to grow what it says.
    ///
    /// # Errors
    /// If it cannot be done; all stays as it is.
    pub fn apply(
        &mut self,
        name: &str,
        gesture: Option<&str>,
        edit: Edit,
    ) -> Result<(), EditError> {
        self.document.apply(name, gesture, edit)?;
        self.renew();
        Ok(())
    }

    /// False for a new document to which nothing was done.
    fn has_work(&self) -> bool {
        self.document.path().is_some() || self.document.history().undoable().is_some()
    }
}

/// Told when a window is to be closed that is still writing.
const EXPORTING: &str = "packs are still being written: wait for them, or cancel the export";

/// True for what is done with the whole text, to which words that are being typed belong.
fn takes_text(order: &Order) -> bool {
    matches!(
        order,
        Order::Save | Order::SaveAs | Order::Export | Order::Ask(_)
    )
}

impl Studio {
    /// One frame of the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.settle(ui);
        self.listen(ui);
        self.rest(ui);
        let is_awaited = self.is_awaited();
        self.view.await_tree(is_awaited);
        let postponed = std::mem::take(&mut self.postponed);
        let mut orders = Vec::new();
        if self.question.is_none() {
            menu::pressed(ui, &mut orders);
            self.view_keys(ui);
        }
        egui::Panel::top("menu").show(ui, |ui| {
            egui::MenuBar::new().ui(ui, |ui| self.menu(ui, &mut orders));
        });
        if let Some((text, until)) = self.message.clone() {
            let left = until - ui.input(|i| i.time);
            if left > 0.0 {
                egui::Panel::bottom("message").show(ui, |ui| ui.label(text));
                if until < f64::MAX {
                    ui.ctx()
                        .request_repaint_after(Duration::from_secs_f64(left.max(0.01)));
                }
            } else {
                self.message = None;
            }
        }
        if let Some(fault) = self.scribe.as_mut().and_then(Scribe::take_fault) {
            self.message = Some((fault, f64::MAX));
        }
        self.export_bar(ui);
        self.panes(ui, &mut orders);
        self.hints(ui);
        let (later, now): (Vec<_>, Vec<_>) = orders.into_iter().partition(takes_text);
        for order in now.into_iter().chain(postponed) {
            self.obey(ui, order);
        }
        if !later.is_empty() && self.lets_go(ui) {
            self.postponed.extend(later);
        } else {
            for order in later {
                self.obey(ui, order);
            }
        }
        self.drops(ui);
        self.asking(ui);
        self.close(ui);
        let title = self.titled();
        if title != self.title {
            ui.ctx()
                .send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
        if let Err(error) = self.view.check() {
            self.fail(&error.into());
        }
    }

    fn titled(&self) -> String {
        let name = match self.document.path() {
            Some(path) => path.file_name().map(|n| n.to_string_lossy().into_owned()),
            None => Some("new species".to_owned()),
        };
        let star = if self.document.is_unsaved() { "*" } else { "" };
        format!("{}{star} - Pleach studio", name.unwrap_or_default())
    }

    fn panes(&mut self, ui: &mut Ui, orders: &mut Vec<Order>) {
        let reading = self.document.reading();
        let pages = reading
            .root
            .as_ref()
            .map(outline::pages)
            .unwrap_or_default();
        let faults: Vec<Fault> = match &reading.species {
            Ok(_) => Vec::new(),
            Err(faults) => faults.list().to_vec(),
        };
        let (shown, grown) = (self.shown.clone(), self.grown.clone());
        let fault = self.fault.as_deref().or(self.grower.fault());
        if let Some(fault) = fault.or(self.sketcher.fault()) {
            let fault = fault.to_owned();
            egui::Panel::bottom("fault").show(ui, |ui| {
                let colour = ui.visuals().error_fg_color;
                ui.label(RichText::new(fault).color(colour));
            });
        }
        let mut panes = Panes {
            document: &self.document,
            pages: &pages,
            stale: !faults.is_empty(),
            faults: &faults,
            selected: &self.selected,
            settings: &mut self.settings,
            view: &mut self.view,
            shown: shown.as_ref(),
            subject: shown.as_deref().map(|g| &g.subject),
            hand: &mut self.hand,
            closeups: &mut self.closeups,
            drawings: &self.drawings,
            seeds: &mut self.seeds,
            shows: self.shows,
            growing: self.due.is_some() || self.grower.stage().is_some(),
            grown: grown.as_ref(),
            furnished: self.furnished.as_ref(),
            furnishings: self.furnishings,
            number: self.number,
            pictures: &mut self.pictures,
            judging: &mut self.judging,
            busy: self.grower.stage(),
            fault: None,
            frame: false,
            orders: Vec::new(),
        };
        let dock = &mut self.dock;
        egui::CentralPanel::default()
            .frame(egui::Frame::NONE)
            .show(ui, |ui| dock.ui(&mut panes, ui));
        let Panes {
            orders: asked,
            fault,
            frame,
            ..
        } = panes;
        orders.extend(asked);
        let document = &self.document;
        let drawings = self.drawings.get_mut();
        drawings.draw(document.text(), || document.folder());
        if let Some(error) = fault {
            self.fail(&error);
        }
        if frame && let Some(shown) = &shown {
            self.view.frame(&shown.subject, &self.settings);
        }
    }

    /// Asks before the window closes on something unsaved.
    fn close(&mut self, ui: &Ui) {
        if (self.stop)() {
            self.closing = true;
            return ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        }
        let wanted = ui.input(|i| i.viewport().close_requested());
        if !wanted || self.closing {
            return;
        }
        let stay = || {
            ui.ctx()
                .send_viewport_cmd(egui::ViewportCommand::CancelClose);
        };
        if matches!(self.question, Some(Question::Conflict(_))) {
            stay();
        } else if self.lets_go(ui) {
            // What is being typed is taken first.
            stay();
            self.postponed.push(Order::Ask(Next::Close));
        } else if self.writer.stage().is_some() {
            stay();
            self.say(ui, EXPORTING);
        } else if self.document.is_unsaved() && self.has_work() {
            stay();
            self.question = Some(Question::Unsaved(Next::Close));
        }
    }

    /// Takes the focus from whatever is typed in, so that it gives its words; false if nothing is.
    fn lets_go(&self, ui: &Ui) -> bool {
        let focused = ui.memory(egui::Memory::focused);
        if let Some(id) = focused {
            ui.memory_mut(|memory| memory.surrender_focus(id));
            ui.ctx().request_repaint();
        }
        focused.is_some()
    }
}

impl eframe::App for Studio {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.view.background(visuals)
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        Self::ui(self, ui);
    }
}

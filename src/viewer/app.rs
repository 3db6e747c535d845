//! The window: a view, the panel beside it, the thread that grows trees, and the files that are watched.

use super::keys::{self, Action};
use super::level::Choice;
use super::loader::{Loader, Stage};
use super::panel::{self, Asked};
use super::rig::Rig;
use super::settings::{Arrangement, Settings};
use super::shot;
use super::subject::{Source, Subject};
use super::viewport::{Viewport, write};
use super::watch::{Watch, Watched};
use crate::gpu::GpuError;
use crate::render::Model;
use crate::render::forest::ForestError;
use eframe::egui::{self, Align2, Panel, Ui, vec2};
use eframe::egui_wgpu::RenderState;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Seconds that a message is shown.
const MESSAGE: f64 = 6.0;

/// How often the bar of growing moves.
const BUSY: Duration = Duration::from_millis(200);

/// What outlives a window whose graphics adapter is lost, so that the next one goes on where it ended.
#[derive(Clone, Debug)]
pub struct Kept {
    /// The camera.
    pub rig: Rig,
    /// All that was set.
    pub settings: Settings,
    /// What happened.
    pub reason: String,
}

/// Where a window leaves what outlives it.
pub type Legacy = Arc<Mutex<Option<Kept>>>;

/// What a window begins with.
#[derive(Clone, Debug)]
pub struct Start {
    /// The tree.
    pub source: Source,
    /// Folder into which screenshots are written.
    pub folder: PathBuf,
    /// True once the program is to end: the window closes.
    pub stop: fn() -> bool,
    /// What a window that was lost has left.
    pub kept: Option<Kept>,
    /// Where this one leaves it.
    pub legacy: Legacy,
}

impl Start {
    /// A first window.
    #[must_use]
    pub fn new(source: Source, folder: PathBuf) -> Self {
        Self {
            source,
            folder,
            stop: || false,
            kept: None,
            legacy: Legacy::default(),
        }
    }
}

/// Why a window cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The graphics adapter is of no use.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The system gives no thread.
    #[error("no thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// A tree, put on the device by the thread that made it: a window that does so itself stands still meanwhile.
#[derive(Debug)]
struct Loaded {
    subject: Arc<Subject>,
    model: Model,
}

/// The window's state.
#[derive(Debug)]
pub struct App {
    /// All that is set.
    pub settings: Settings,
    /// The view.
    pub view: Viewport,
    /// The tree that is shown.
    pub subject: Option<Arc<Subject>>,
    loader: Loader<Loaded>,
    watch: Watch,
    watched: Watched,
    source: Source,
    folder: PathBuf,
    stop: fn() -> bool,
    legacy: Legacy,
    /// What is said for a while, and until when.
    message: Option<(String, f64)>,
    /// What the adapter said of the newest frame.
    fault: Option<String>,
    lost: bool,
    arrangement: Arrangement,
}

impl App {
    /// A window's state; its tree begins to grow. `wake` is called from other threads when there is something
    /// to be shown.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn new(
        state: &RenderState,
        start: Start,
        wake: impl Fn() + Clone + Send + Sync + 'static,
    ) -> Result<Self, StartError> {
        let mut view = Viewport::new(state)?;
        let watched = Watched::default();
        let loader = Loader::start("grow", wake.clone())?;
        let watch = Watch::start(watched.clone(), start.stop, wake)?;
        let mut settings = Settings::default();
        let mut message = None;
        if let Some(kept) = start.kept {
            settings = kept.settings;
            view.keep(kept.rig);
            message = Some((kept.reason, f64::MAX));
        }
        let mut app = Self {
            arrangement: settings.arrangement,
            settings,
            view,
            subject: None,
            loader,
            watch,
            watched,
            source: start.source,
            folder: start.folder,
            stop: start.stop,
            legacy: start.legacy,
            message,
            fault: None,
            lost: false,
        };
        app.load();
        Ok(app)
    }

    /// What is wrong with the script, as it is shown.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.loader.fault().or(self.fault.as_deref())
    }

    /// What is being said.
    #[must_use]
    pub fn message(&self) -> Option<&str> {
        self.message.as_ref().map(|(text, _)| text.as_str())
    }

    /// True if the graphics adapter was lost: the window closes, and leaves its state behind.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.lost
    }

    /// The scene that is shown at rest.
    pub fn scene(&mut self) -> Option<crate::render::Scene> {
        let subject = self.subject.clone()?;
        Some(self.view.scene(&subject, &self.settings))
    }

    /// Grows or reads the tree, in the thread for that.
    fn load(&mut self) {
        let (source, watched) = (self.source.clone(), self.watched.clone());
        let maker = self.view.maker();
        self.loader.ask(Box::new(move |progress| {
            let subject = Arc::new(source.load(&watched, progress)?);
            let model = maker.make(&subject.drawable(), None);
            let model = model.map_err(|error| error.to_string())?;
            Ok(Loaded { subject, model })
        }));
    }

    /// Takes in what the threads have done.
    fn listen(&mut self) {
        if self.watch.take() {
            self.load();
        }
        if self.loader.poll().good
            && let Some(loaded) = self.loader.good()
        {
            self.view.put(loaded.model.clone(), false);
            self.subject = Some(Arc::clone(&loaded.subject));
            self.fault = None;
        }
    }

    /// A fault of the adapter: told, or the end of this window.
    fn fail(&mut self, error: &ForestError) {
        if matches!(error, ForestError::Gpu(GpuError::Lost(_))) {
            self.lost = true;
            let mut legacy = self.legacy.lock().unwrap_or_else(PoisonError::into_inner);
            *legacy = Some(Kept {
                rig: self.view.rig,
                settings: self.settings,
                reason: format!("{error}. The view was started again"),
            });
            return;
        }
        self.fault = Some(error.to_string());
    }

    fn say(&mut self, ui: &Ui, text: String) {
        self.message = Some((text, ui.input(|i| i.time) + MESSAGE));
    }

    fn act(&mut self, ui: &Ui, action: Action) {
        let settings = &mut self.settings;
        match action {
            Action::Frame => self.frame(),
            Action::Lod(lod) => settings.choice = Choice::Fixed(lod),
            Action::ByDistance => settings.choice = Choice::ByDistance,
            Action::NextView => settings.next_view(),
            Action::Forest => settings.toggle(Arrangement::Forest),
            Action::Strip => settings.toggle(Arrangement::Strip),
            Action::Turntable => settings.turntable = !settings.turntable,
            Action::Wind => settings.breeze.on = !settings.breeze.on,
            Action::Slower => self.view.rig.hasten(0.5),
            Action::Faster => self.view.rig.hasten(2.0),
            Action::Screenshot => self.shoot(ui),
            Action::Panel => settings.panel = !settings.panel,
            Action::Help => settings.help = !settings.help,
            Action::Quit if settings.help => settings.help = false,
            Action::Quit => ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close),
        }
    }

    fn frame(&mut self) {
        if let Some(subject) = self.subject.clone() {
            self.view.frame(&subject, &self.settings);
        }
    }

    /// Takes the camera to another arrangement, if there is one.
    fn arrange(&mut self) {
        let Some(subject) = self.subject.clone() else {
            return;
        };
        if self.arrangement != self.settings.arrangement {
            self.view
                .arrange(self.arrangement, &subject, &self.settings);
            self.arrangement = self.settings.arrangement;
        }
    }

    fn shoot(&mut self, ui: &Ui) {
        let Some(subject) = self.subject.clone() else {
            return self.say(ui, "there is no tree to take a picture of yet".to_owned());
        };
        match self.view.still(&subject, &self.settings) {
            Ok(picture) => {
                let saved = shot::save(&self.folder, &subject.slug, &picture);
                let text = saved.map_or_else(
                    |fault| fault,
                    |path| {
                        let (width, height) = (picture.width(), picture.height());
                        format!("{} ({width} x {height}) is written", path.display())
                    },
                );
                self.say(ui, text);
            }
            Err(error) => self.fail(&error),
        }
    }

    /// What is said over the view: growing, and messages.
    fn overlay(&mut self, ui: &Ui, rect: egui::Rect) {
        let now = ui.input(|i| i.time);
        if let Some(stage) = self.loader.stage() {
            let at = rect.center_top() + vec2(0.0, 12.0);
            write(
                ui,
                at,
                Align2::CENTER_TOP,
                &growing(&stage, self.subject.is_some()),
            );
            ui.ctx().request_repaint_after(BUSY);
        }
        if let Some((text, until)) = self.message.clone() {
            if now > until {
                self.message = None;
            } else {
                let at = rect.center_bottom() - vec2(0.0, 12.0);
                write(ui, at, Align2::CENTER_BOTTOM, &text);
                // A message without end goes with the next one.
                if until < f64::MAX {
                    let left = Duration::from_secs_f64((until - now).max(0.01));
                    ui.ctx().request_repaint_after(left);
                }
            }
        }
    }
}

/// What the thread is doing, in words.
fn growing(stage: &Stage, again: bool) -> String {
    let verb = if again { "Growing again" } else { "Growing" };
    match (stage.name, stage.steps) {
        ("", _) => format!("{verb} ..."),
        (name, 0) => format!("{verb}: {name} ..."),
        (name, steps) => format!("{verb}: {name}, {} of {steps}", stage.done.min(steps)),
    }
}

impl App {
    /// One frame of the window.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.listen();
        for action in keys::pressed(ui.ctx()) {
            self.act(ui, action);
        }
        let mut asked = Asked::default();
        let subject = self.subject.clone();
        if self.settings.panel {
            Panel::right("settings")
                .resizable(false)
                .exact_size(256.0)
                .show(ui, |ui| {
                    asked = panel::ui(ui, &mut self.settings, &mut self.view, subject.as_deref());
                });
        }
        if let Some(fault) = self.fault().map(str::to_owned) {
            let faults = Panel::bottom("faults").resizable(true).default_size(170.0);
            faults.show(ui, |ui| panel::faults(ui, &fault, subject.is_some()));
        }
        if asked.frame {
            self.frame();
        }
        self.arrange();
        if asked.shot {
            self.shoot(ui);
        }
        let frame = egui::Frame::NONE;
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            let settings = &mut self.settings;
            match self.view.ui(ui, settings, subject.as_deref()) {
                Ok(response) => self.overlay(ui, response.rect),
                Err(error) => self.fail(&error),
            }
        });
        panel::help(ui.ctx(), &mut self.settings.help);
        if let Err(error) = self.view.check() {
            self.fail(&error.into());
        }
        if self.lost || (self.stop)() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }
}

impl eframe::App for App {
    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.view.background(visuals)
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        Self::ui(self, ui);
    }
}

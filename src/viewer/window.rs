//! Opens the window, and says in words why it cannot be opened.

use super::app::{App, Kept, Legacy, Start};
use super::subject::Source;
use eframe::egui::ViewportBuilder;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuError, WgpuSetup, WgpuSetupCreateNew};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Libraries that a window on X11 is opened with.
const X11: &str = "On Debian and Ubuntu `apt install libx11-6 libx11-xcb1 libxcb1 libxcursor1 libxi6 libxkbcommon0 \
                   libxkbcommon-x11-0` brings them";

/// A device that is lost again within this time is not worth another window.
const TWICE: Duration = Duration::from_secs(20);

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No screen to put it on.
    #[error(
        "there is no screen to open a window on: {0}; set DISPLAY or WAYLAND_DISPLAY, or draw without a window: \
         `pleach render`"
    )]
    NoDisplay(String),
    /// A library is missing.
    #[error("a library that opens windows is missing: {0}. {X11}")]
    NoLibrary(String),
    /// No graphics adapter.
    #[error(
        "no graphics adapter: {0}; install a driver: on Debian and Ubuntu `apt install mesa-vulkan-drivers`"
    )]
    NoAdapter(String),
    /// The adapter was lost, and lost again.
    #[error("{0}. It was lost again at once")]
    Lost(String),
    /// Anything else.
    #[error("the window could not be opened: {0}")]
    Other(String),
}

impl WindowError {
    /// True if the machine is at fault and another try may help.
    #[must_use]
    pub fn is_worth_another_try(&self) -> bool {
        matches!(self, Self::Lost(_))
    }
}

/// What kind of window.
#[derive(Clone, Debug)]
pub struct Options {
    /// Size in points.
    pub size: [f32; 2],
    /// Folder into which screenshots are written.
    pub folder: PathBuf,
    /// True once the program is to end.
    pub stop: fn() -> bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            size: [1280.0, 800.0],
            folder: PathBuf::from("."),
            stop: || false,
        }
    }
}

/// Shows a tree until the window is closed. A window whose graphics adapter is lost is opened again as it was.
///
/// # Errors
/// [`WindowError`].
pub fn run(source: &Source, options: &Options) -> Result<(), WindowError> {
    let mut kept: Option<Kept> = None;
    loop {
        let begun = Instant::now();
        let legacy = Legacy::default();
        let start = Start {
            kept: kept.take(),
            stop: options.stop,
            legacy: Arc::clone(&legacy),
            ..Start::new(source.clone(), options.folder.clone())
        };
        let shown = show(options, start);
        let left = legacy.lock().unwrap_or_else(PoisonError::into_inner).take();
        match left {
            // Whatever else went wrong, went wrong because of this.
            Some(left) if begun.elapsed() < TWICE => return Err(WindowError::Lost(left.reason)),
            Some(left) => kept = Some(left),
            None => return shown,
        }
    }
}

/// One window on a tree, from its opening to its end.
fn show(options: &Options, start: Start) -> Result<(), WindowError> {
    let name = start.source.path().display().to_string();
    open(&format!("{name} - Pleach"), options.size, |state, ctx| {
        let ctx = ctx.clone();
        let wake = move || ctx.request_repaint();
        Ok(Box::new(App::new(state, start, wake)?))
    })
}

/// Why a window's content cannot be made.
type Unmade = Box<dyn std::error::Error + Send + Sync>;

/// Opens a window with a title and a size in points, and shows what `make` puts into it until it is closed.
///
/// # Errors
/// [`WindowError`].
pub fn open(
    title: &str,
    size: [f32; 2],
    make: impl FnOnce(
        &eframe::egui_wgpu::RenderState,
        &eframe::egui::Context,
    ) -> Result<Box<dyn eframe::App>, Unmade>,
) -> Result<(), WindowError> {
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title(title)
            .with_app_id("pleach")
            .with_inner_size(size)
            .with_min_inner_size([320.0, 240.0]),
        wgpu_options: WgpuConfiguration {
            wgpu_setup: setup(),
            ..WgpuConfiguration::default()
        },
        // It costs a software driver a twentieth of a second a frame.
        dithering: false,
        ..eframe::NativeOptions::default()
    };
    let run = move || {
        eframe::run_native(
            "pleach",
            native,
            Box::new(|cc| {
                let state = cc.wgpu_render_state.as_ref();
                let state = state.ok_or("the window has no graphics device")?;
                super::panel::style(&cc.egui_ctx);
                make(state, &cc.egui_ctx)
            }),
        )
    };
    let (result, panicked) = quietly(run);
    match result {
        Some(result) => result.map_err(|error| sentence(&error)),
        None => Err(panic_sentence(&panicked)),
    }
}

/// A device with all that the adapter can: the default for OpenGL has no storage buffers.
#[must_use]
pub fn setup() -> WgpuSetup {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.power_preference = wgpu::PowerPreference::HighPerformance;
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("window"),
        required_features: crate::gpu::WELCOME & adapter.features(),
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    });
    setup.into()
}

/// Runs something whose panics are to be told by us: their words, if it panicked.
fn quietly<T>(run: impl FnOnce() -> T) -> (Option<T>, String) {
    let words = Arc::new(Mutex::new(String::new()));
    let heard = Arc::clone(&words);
    let here = std::thread::current().id();
    let before = Arc::new(std::panic::take_hook());
    let others = Arc::clone(&before);
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().id() == here {
            *heard.lock().unwrap_or_else(PoisonError::into_inner) = info.to_string();
        } else {
            others(info);
        }
    }));
    let result = catch_unwind(AssertUnwindSafe(run)).ok();
    std::panic::set_hook(Box::new(move |info| before(info)));
    let words = words.lock().unwrap_or_else(PoisonError::into_inner).clone();
    (result, words)
}

/// What the window's libraries say, told with what to do.
fn sentence(error: &eframe::Error) -> WindowError {
    let text = error.to_string();
    match error {
        eframe::Error::WinitEventLoop(_) if text.contains(".so") || text.contains("shared lib") => {
            WindowError::NoLibrary(without_place(&text))
        }
        eframe::Error::WinitEventLoop(_) | eframe::Error::Winit(_) => {
            WindowError::NoDisplay(without_place(&text))
        }
        eframe::Error::Wgpu(WgpuError::RequestAdapterError(_)) => WindowError::NoAdapter(text),
        eframe::Error::Wgpu(WgpuError::CreateSurfaceError(_)) => {
            WindowError::NoAdapter("none that draws into windows was found".to_owned())
        }
        _ => WindowError::Other(text),
    }
}

/// What is said after the place in the source of whoever says it.
fn without_place(text: &str) -> String {
    let after = text.rsplit_once(".rs:").map_or(text, |(_, after)| after);
    let said = match after.split_once(": ") {
        Some((line, said)) if line.chars().all(|c| c.is_ascii_digit()) => said,
        _ => after,
    };
    said.trim_end_matches('.').to_owned()
}

/// A library that is missing shows as a panic of the one that would load it.
fn panic_sentence(text: &str) -> WindowError {
    let line = text.lines().last().unwrap_or(text).to_owned();
    if text.contains("could not be loaded") || text.contains("Could not load") {
        WindowError::NoLibrary(line.trim_end_matches('.').to_owned())
    } else {
        WindowError::Other(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_that_cannot_be_loaded_is_named_with_what_to_install() {
        let words = "Library libxkbcommon-x11.so could not be loaded.";
        let (result, told) = quietly(|| -> u32 { panic!("{words}") });
        assert!(result.is_none() && told.contains(words), "{told}");
        let sentence = panic_sentence(&told).to_string();
        assert!(
            sentence.contains("libxkbcommon-x11.so") && sentence.contains("apt install"),
            "{sentence}"
        );
    }

    #[test]
    fn the_place_in_the_source_of_a_library_is_left_out() {
        let text = "winit EventLoopError: os error at a/b/src/linux/mod.rs:765: neither is set.";
        assert_eq!(without_place(text), "neither is set");
        assert_eq!(without_place("no screen: none."), "no screen: none");
    }

    #[test]
    fn other_panics_are_told_as_they_are() {
        let (_, told) = quietly(|| panic!("planted by a test"));
        let sentence = panic_sentence(&told).to_string();
        assert!(
            sentence.contains("planted by a test") && !sentence.contains("apt"),
            "{sentence}"
        );
        assert_eq!(quietly(|| 3), (Some(3), String::new()));
    }
}

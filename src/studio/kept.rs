//! What the studio keeps from one window to the next: looks, recent files, how packs are exported; in a small file
//! in the user's folder for settings.

use crate::disk;
use crate::pack::Options;
use crate::pipeline::Settings;
use eframe::egui::ThemePreference;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Most recent files that are kept.
pub const RECENT: usize = 12;

/// Smallest and largest scale of the window's words and widgets.
pub const SCALES: [f32; 2] = [0.8, 2.0];

/// Edges of a foliage atlas that are offered, texels.
pub const ATLASES: [u32; 6] = [256, 512, 1024, 2048, 4096, 8192];

/// Height of a screen on which words have their usual size, points.
const USUAL_SCREEN: f32 = 1440.0;

/// How often the file is written at most.
const EVERY: Duration = Duration::from_secs(1);

/// Settings that outlive a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Kept {
    /// Light or dark.
    pub theme: Theme,
    /// Scale of words and widgets, within [`SCALES`].
    pub scale: f32,
    /// Scripts that were open, the newest first, [`RECENT`] at most.
    pub recent: Vec<PathBuf>,
    /// How packs are exported.
    pub export: Export,
    /// True until the first hints were dismissed.
    pub hints: bool,
    /// How the panes stand, in the words of the dock; empty while they stand as usual. What cannot be read is the
    /// usual, too.
    pub dock: String,
}

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// Light on dark.
    #[default]
    Dark,
    /// Dark on light.
    Light,
    /// As the system has it.
    System,
}

/// How packs are exported.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Export {
    /// Folder in which packs are made; none before the first export.
    pub folder: Option<PathBuf>,
    /// As in [`Options`].
    pub embed: bool,
    /// As in [`Options`].
    pub mips: bool,
    /// As in [`Options`].
    pub no_wind: bool,
    /// As in [`Settings`].
    pub full: bool,
    /// Edge of the foliage atlas, texels; one of [`ATLASES`].
    pub atlas_size: u32,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            scale: 1.0,
            recent: Vec::new(),
            export: Export::default(),
            hints: true,
            dock: String::new(),
        }
    }
}

impl Default for Export {
    fn default() -> Self {
        let Options {
            embed,
            mips,
            no_wind,
        } = Options::default();
        let settings = Settings::default();
        Self {
            folder: None,
            embed,
            mips,
            no_wind,
            full: settings.full,
            atlas_size: settings.captures.atlas_size,
        }
    }
}

impl Export {
    /// How packs are laid out.
    #[must_use]
    pub fn options(&self) -> Options {
        Options {
            embed: self.embed,
            mips: self.mips,
            no_wind: self.no_wind,
        }
    }

    /// How trees are made.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let mut settings = Settings {
            full: self.full,
            ..Settings::default()
        };
        settings.captures.atlas_size = self.atlas_size;
        settings
    }
}

impl From<Theme> for ThemePreference {
    fn from(theme: Theme) -> Self {
        match theme {
            Theme::Dark => Self::Dark,
            Theme::Light => Self::Light,
            Theme::System => Self::System,
        }
    }
}

impl Kept {
    /// Puts a script before all other recent ones. A path that is no text cannot be kept.
    pub fn remember(&mut self, path: &Path) {
        let Some(whole) = std::path::absolute(path).ok().filter(|p| is_text(p)) else {
            return;
        };
        self.recent.retain(|known| *known != whole);
        self.recent.insert(0, whole);
        self.recent.truncate(RECENT);
    }

    /// Mends what a hand may have written.
    fn mended(mut self) -> Self {
        let usual = Self::default();
        let [least, most] = SCALES;
        if !self.scale.is_finite() {
            self.scale = usual.scale;
        }
        self.scale = self.scale.clamp(least, most);
        self.recent.truncate(RECENT);
        if !ATLASES.contains(&self.export.atlas_size) {
            self.export.atlas_size = usual.export.atlas_size;
        }
        self
    }
}

fn is_text(path: &Path) -> bool {
    path.to_str().is_some()
}

/// Where settings are kept: in the user's folder for the settings of programs (XDG base directories, or what
/// Windows and macOS have for it). None if the user has no home.
#[must_use]
pub fn file() -> Option<PathBuf> {
    let named = |name: &str| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    let base = if cfg!(windows) {
        named("APPDATA")?
    } else if cfg!(target_os = "macos") {
        named("HOME")?.join("Library/Application Support")
    } else {
        named("XDG_CONFIG_HOME").or_else(|| Some(named("HOME")?.join(".config")))?
    };
    Some(base.join("pleach").join("studio.ron"))
}

/// Settings and their file, which is written when something has changed.
#[derive(Debug, Default)]
pub struct Keeper {
    /// What is kept from now on.
    pub now: Kept,
    file: Option<PathBuf>,
    /// What the file says.
    written: Kept,
    last: Option<Instant>,
    /// True while a file is there that says nothing.
    is_bad: bool,
    /// True if nothing was kept before.
    is_first: bool,
    fault: Option<String>,
}

impl Keeper {
    /// Reads a file of settings. One that is not there yet holds the usual ones, and without a `file` nothing is
    /// kept.
    #[must_use]
    pub fn open(file: Option<PathBuf>) -> Self {
        let mut keeper = Self::default();
        if let Some(file) = &file {
            match read(file) {
                Ok(kept) => {
                    keeper.is_first = kept.is_none();
                    keeper.now = kept.unwrap_or_default();
                }
                Err(fault) => {
                    keeper.is_bad = true;
                    let text = "the studio's settings cannot be read, and the usual ones are taken";
                    keeper.fault = Some(format!("{text}: {}: {fault}", file.display()));
                }
            }
        }
        keeper.written = keeper.now.clone();
        keeper.file = file;
        keeper
    }

    /// True if there is a file to keep them in.
    #[must_use]
    pub fn keeps(&self) -> bool {
        self.file.is_some()
    }

    /// Takes the scale that fits a screen of some height, points, if nobody has chosen one yet: without it, words are
    /// small on a screen of which the system does not tell how fine it is.
    pub fn suit(&mut self, height: f32) {
        if std::mem::take(&mut self.is_first) {
            let [least, most] = SCALES;
            let scale = (height / USUAL_SCREEN * 10.0).round() / 10.0;
            self.now.scale = scale.clamp(least.max(1.0), most);
        }
    }

    /// What went wrong, once.
    pub fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    /// Writes down what has changed, unless that was done a moment ago: then the time until it may be done again.
    pub fn keep(&mut self, now: Instant) -> Option<Duration> {
        if self.now == self.written || self.file.is_none() {
            return None;
        }
        let since = self.last.map(|last| now.saturating_duration_since(last));
        match since.and_then(|since| EVERY.checked_sub(since)) {
            Some(left) if !left.is_zero() => Some(left),
            _ => {
                self.last = Some(now);
                self.write();
                None
            }
        }
    }

    fn write(&mut self) {
        let Some(file) = self.file.clone() else {
            return;
        };
        // If it fails, it is told once and tried again when something changes.
        self.written = self.now.clone();
        if let Err(error) = self.put(&file) {
            let text = "the studio's settings cannot be kept";
            self.fault = Some(format!("{text}: {}: {error}", file.display()));
        }
    }

    fn put(&mut self, file: &Path) -> io::Result<()> {
        let pretty = ron::ser::PrettyConfig::default();
        let text = ron::ser::to_string_pretty(&self.now, pretty).map_err(io::Error::other)?;
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)?;
        }
        if self.is_bad {
            fs::rename(file, file.with_extension("ron.bad"))?;
            self.is_bad = false;
        }
        disk::write_whole(file, format!("{text}\n").as_bytes())
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        if self.now != self.written {
            self.write();
        }
    }
}

/// What a file says; none if there is no file.
fn read(file: &Path) -> Result<Option<Kept>, String> {
    let text = match fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error.to_string()),
    };
    let kept: Kept = ron::from_str(&text).map_err(|error| error.to_string())?;
    Ok(Some(kept.mended()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed() -> Kept {
        Kept {
            theme: Theme::Light,
            scale: 1.3,
            recent: vec![PathBuf::from("/trees/\"oak\".ron")],
            export: Export {
                folder: Some(PathBuf::from("/packs")),
                mips: true,
                atlas_size: 512,
                ..Export::default()
            },
            hints: false,
            dock: "Pane(Tree)".to_owned(),
        }
    }

    #[test]
    fn what_is_kept_is_read_again_and_written_only_when_it_changes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("config/pleach/studio.ron");
        let mut keeper = Keeper::open(Some(file.clone()));
        let begun = Instant::now();
        assert_eq!((keeper.keep(begun), file.exists()), (None, false));
        keeper.now = changed();
        assert_eq!((keeper.keep(begun), file.exists()), (None, true));
        assert_eq!(Keeper::open(Some(file.clone())).now, changed());
        keeper.now.scale = 1.5;
        let soon = begun + Duration::from_millis(400);
        assert_eq!(keeper.keep(soon), Some(Duration::from_millis(600)));
        assert_eq!(Keeper::open(Some(file.clone())).now, changed());
        assert_eq!(keeper.keep(begun + EVERY), None);
        let read = |file: &PathBuf| Keeper::open(Some(file.clone())).now.scale;
        assert!((read(&file) - 1.5).abs() < 1e-6);
        // What was not written yet is written when the window goes.
        keeper.now.scale = 0.9;
        drop(keeper);
        assert!((read(&file) - 0.9).abs() < 1e-6);
    }

    #[test]
    fn a_first_window_has_words_that_fit_its_screen_and_later_ones_what_was_chosen() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("studio.ron");
        for (height, scale) in [(720.0, 1.0), (1440.0, 1.0), (2160.0, 1.5), (4320.0, 2.0)] {
            let mut keeper = Keeper::open(Some(file.clone()));
            keeper.suit(height);
            assert_eq!(keeper.now.scale, scale, "{height}");
            keeper.suit(720.0);
            assert_eq!(keeper.now.scale, scale, "once");
            keeper.now.scale = 1.0;
            keeper.written = Kept::default();
        }
        let mut keeper = Keeper::open(Some(file.clone()));
        keeper.now.scale = 1.2;
        drop(keeper);
        let mut keeper = Keeper::open(Some(file));
        keeper.suit(2160.0);
        assert!((keeper.now.scale - 1.2).abs() < 1e-6);
    }

    #[test]
    fn a_file_that_is_no_settings_is_told_once_and_put_aside_when_something_changes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("studio.ron");
        fs::write(&file, "(theme: Pink").unwrap();
        let mut keeper = Keeper::open(Some(file.clone()));
        assert_eq!(keeper.now, Kept::default());
        assert!(keeper.take_fault().unwrap().contains("studio.ron"));
        assert_eq!(keeper.take_fault(), None);
        keeper.keep(Instant::now());
        assert_eq!(fs::read_to_string(&file).unwrap(), "(theme: Pink");
        keeper.now = changed();
        keeper.keep(Instant::now());
        let bad = dir.path().join("studio.ron.bad");
        assert_eq!(fs::read_to_string(bad).unwrap(), "(theme: Pink");
        assert_eq!(Keeper::open(Some(file)).now, changed());
    }

    #[test]
    fn what_another_version_or_a_hand_wrote_is_taken_as_far_as_it_goes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("studio.ron");
        let text = "(scale: 70, later: [1, 2], export: (atlas_size: 1000, embed: true))";
        fs::write(&file, text).unwrap();
        let mut keeper = Keeper::open(Some(file));
        assert_eq!(keeper.take_fault(), None);
        let export = Export {
            embed: true,
            ..Export::default()
        };
        let expected = Kept {
            scale: 2.0,
            export,
            ..Kept::default()
        };
        assert_eq!(keeper.now, expected);
    }

    #[test]
    fn recent_files_are_newest_first_each_once_and_few() {
        let mut kept = Kept::default();
        for number in 0..20 {
            kept.remember(Path::new(&format!("/trees/{number}.ron")));
        }
        kept.remember(Path::new("/trees/15.ron"));
        let names: Vec<String> = kept
            .recent
            .iter()
            .map(|p| p.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        let expected = [15, 19, 18, 17, 16, 14, 13, 12, 11, 10, 9, 8].map(|n| n.to_string());
        assert_eq!(names, expected);
        kept.remember(Path::new("oak.ron"));
        assert!(kept.recent[0].is_absolute());
    }
}

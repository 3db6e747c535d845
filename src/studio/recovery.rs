//! What outlives a window that is killed: the unsaved text of each open document, in a folder of the user's.
//!
//! A document that differs from its file has a note beside it in the folder, replaced as a whole at each change,
//! and a lock that the system lets go of when the process ends, however it ends. A note whose lock is free was
//! left by a window that was killed: its text is offered again.

use serde::{Deserialize, Serialize};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Ending of a note's name; its lock has `.lock` instead.
const NOTE: &str = "json";

/// A text that was not saved.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// The file that the text is of; none for a new document.
    pub path: Option<PathBuf>,
    /// What that file held when it was read or written last.
    pub saved: Option<String>,
    /// The text.
    pub text: String,
}

/// The place of one document's notes, held as long as it is open.
#[derive(Debug)]
pub struct Journal {
    note: PathBuf,
    lock: PathBuf,
    /// Kept open for its lock.
    _held: File,
    written: Option<Note>,
}

impl Journal {
    /// A place in `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// If the folder cannot be written to.
    pub fn open(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        for number in 0.. {
            let lock = folder.join(format!("document-{number}.lock"));
            let held = File::options()
                .create(true)
                .truncate(false)
                .write(true)
                .open(&lock)?;
            let note = lock.with_extension(NOTE);
            match held.try_lock() {
                // A note that is there is somebody's text.
                Ok(()) if !note.exists() => {
                    return Ok(Self {
                        note,
                        lock,
                        _held: held,
                        written: None,
                    });
                }
                Ok(()) | Err(TryLockError::WouldBlock) => {}
                Err(TryLockError::Error(error)) => return Err(error),
            }
        }
        unreachable!("numbers do not end")
    }

    /// Writes a note down, or takes it away if there is nothing to lose.
    ///
    /// # Errors
    /// If the disk does not take it; the note before stays.
    pub fn keep(&mut self, note: Option<&Note>) -> io::Result<()> {
        if self.written.as_ref() == note {
            return Ok(());
        }
        match note {
            Some(note) => {
                let folder = self.note.parent().unwrap_or(Path::new("."));
                let mut file = tempfile::NamedTempFile::new_in(folder)?;
                serde_json::to_writer(&mut file, note)?;
                file.flush()?;
                file.persist(&self.note)?;
            }
            None => fs::remove_file(&self.note)?,
        }
        self.written = note.cloned();
        Ok(())
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        // An unsaved text stays for the next window; an empty place does not.
        if self.written.is_none() {
            let _ = fs::remove_file(&self.lock);
        }
    }
}

/// A note that a window has left, held so that no other window offers it too.
#[derive(Debug)]
pub struct Left {
    /// What was not saved.
    pub note: Note,
    place: PathBuf,
    lock: PathBuf,
    _held: File,
}

impl Left {
    /// Takes the note away: its text is in safe hands, or not wanted.
    ///
    /// # Errors
    /// If the disk does not let go of it.
    pub fn discard(self) -> io::Result<()> {
        fs::remove_file(&self.place)?;
        fs::remove_file(&self.lock)
    }
}

/// Where notes are kept: in the user's folder for the state of programs (XDG base directories, or what Windows and
/// macOS have for it). None if the user has no home.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    let named = |name: &str| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    let base = if cfg!(windows) {
        named("LOCALAPPDATA")?
    } else if cfg!(target_os = "macos") {
        named("HOME")?.join("Library/Application Support")
    } else {
        named("XDG_STATE_HOME").or_else(|| Some(named("HOME")?.join(".local/state")))?
    };
    Some(base.join("pleach").join("unsaved"))
}

/// The notes in `folder` that killed windows have left. Notes that cannot be read are left alone.
#[must_use]
pub fn left(folder: &Path) -> Vec<Left> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut places: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    places.retain(|place| place.extension().is_some_and(|ending| ending == NOTE));
    places.sort();
    places.into_iter().filter_map(orphan).collect()
}

fn orphan(place: PathBuf) -> Option<Left> {
    let lock = place.with_extension("lock");
    let held = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&lock)
        .ok()?;
    held.try_lock().ok()?;
    let note = serde_json::from_slice(&fs::read(&place).ok()?).ok()?;
    Some(Left {
        note,
        place,
        lock,
        _held: held,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(text: &str) -> Note {
        Note {
            path: Some(PathBuf::from("oak.ron")),
            saved: Some("before".to_owned()),
            text: text.to_owned(),
        }
    }

    #[test]
    fn what_a_killed_window_leaves_is_found_once() {
        let dir = tempfile::tempdir().unwrap();
        let mut journal = Journal::open(dir.path()).unwrap();
        journal.keep(Some(&note("one"))).unwrap();
        journal.keep(Some(&note("two"))).unwrap();
        assert!(left(dir.path()).is_empty(), "its window is open");
        drop(journal);
        let found = left(dir.path());
        assert_eq!(found[0].note, note("two"));
        assert!(left(dir.path()).is_empty(), "another window has it");
        // Another document does not take its place.
        let mut other = Journal::open(dir.path()).unwrap();
        other.keep(Some(&note("three"))).unwrap();
        found.into_iter().for_each(|l| l.discard().unwrap());
        drop(other);
        assert_eq!(left(dir.path())[0].note, note("three"));
    }

    #[test]
    fn what_was_saved_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut journal = Journal::open(dir.path()).unwrap();
        journal.keep(Some(&note("one"))).unwrap();
        journal.keep(None).unwrap();
        drop(journal);
        assert!(left(dir.path()).is_empty());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_note_that_is_no_note_is_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("document-0.json"), "{").unwrap();
        assert!(left(dir.path()).is_empty());
        let mut journal = Journal::open(dir.path()).unwrap();
        journal.keep(Some(&note("one"))).unwrap();
        assert_eq!(fs::read(dir.path().join("document-0.json")).unwrap(), b"{");
    }
}

//! Writes what is unsaved in a thread of its own, so that no disk holds up the window.
//!
//! While a hand drags, the text changes with every frame; it is written every [`EVERY`] then, and at once when the
//! hand lets go. So what a kill takes with it is what was done in the last quarter of a second, and what the disk had
//! not taken yet.

use super::recovery::{Journal, Left, Note};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How often a text that goes on changing is written.
const EVERY: Duration = Duration::from_millis(250);

/// How long a window that goes waits for the disk.
const PATIENCE: Duration = Duration::from_secs(3);

/// What is to be written.
#[derive(Debug)]
struct Wanted {
    note: Option<Note>,
    /// Notes of killed windows whose text this one holds, to be taken away once it is written.
    left: Vec<Left>,
}

#[derive(Debug, Default)]
struct State {
    wanted: Option<Wanted>,
    /// True if it is not to wait.
    hurries: bool,
    ends: bool,
    /// True once the thread has ended.
    ended: bool,
    fault: Option<String>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Keeps the newest text of one document over a kill.
#[derive(Debug)]
pub(super) struct Scribe {
    shared: Arc<Shared>,
    /// What was asked for last; none if that was not written.
    last: Option<Option<Note>>,
}

impl Scribe {
    /// Writes into a folder, which is made with the first note; `wake` is called if that fails.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub(super) fn start(folder: PathBuf, wake: impl Fn() + Send + 'static) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        thread::Builder::new()
            .name("journal".to_owned())
            .spawn(move || {
                write(&folder, &theirs, &wake);
                theirs.lock().ended = true;
                theirs.changed.notify_all();
            })?;
        let last = Some(None);
        Ok(Self { shared, last })
    }

    /// Has a note written soon, or taken away at once if there is nothing to lose.
    pub(super) fn keep(&mut self, note: Option<Note>) {
        if self.last.as_ref() != Some(&note) {
            self.last = Some(note.clone());
            self.want(note, Vec::new());
        }
    }

    /// Has a note written at once, and then what a killed window has left of it taken away.
    pub(super) fn take_over(&mut self, note: Option<Note>, left: Left) {
        self.last = Some(note.clone());
        self.want(note, vec![left]);
        self.hurry();
    }

    fn want(&self, note: Option<Note>, mut left: Vec<Left>) {
        let mut state = self.shared.lock();
        state.hurries |= note.is_none();
        left.extend(state.wanted.take().into_iter().flat_map(|w| w.left));
        state.wanted = Some(Wanted { note, left });
        self.shared.changed.notify_all();
    }

    /// Writes what is to be written without waiting for more.
    pub(super) fn hurry(&self) {
        let mut state = self.shared.lock();
        if state.wanted.is_some() {
            state.hurries = true;
            self.shared.changed.notify_all();
        }
    }

    /// What went wrong, once.
    pub(super) fn take_fault(&mut self) -> Option<String> {
        let fault = self.shared.lock().fault.take();
        if fault.is_some() {
            // The next change is tried, and so is this one again.
            self.last = None;
        }
        fault
    }
}

impl Drop for Scribe {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.ends = true;
        self.shared.changed.notify_all();
        // A disk that does not answer keeps no window open.
        let ended = |state: &mut State| !state.ended;
        drop(
            self.shared
                .changed
                .wait_timeout_while(state, PATIENCE, ended),
        );
    }
}

/// Writes until there is no window any more.
fn write(folder: &Path, shared: &Shared, wake: &impl Fn()) {
    let mut journal = None;
    let mut last: Option<Instant> = None;
    // Notes of killed windows that go once their text is written.
    let mut left: Vec<Left> = Vec::new();
    loop {
        let mut state = shared.lock();
        while state.wanted.is_none() && !state.ends {
            state = wait(shared, state, None);
        }
        let rest = last.and_then(|last| EVERY.checked_sub(last.elapsed()));
        if let Some(rest) = rest.filter(|_| !state.hurries && !state.ends) {
            drop(wait(shared, state, Some(rest)));
            continue;
        }
        state.hurries = false;
        let Some(wanted) = state.wanted.take() else {
            return;
        };
        drop(state);
        last = Some(Instant::now());
        left.extend(wanted.left);
        match kept(folder, &mut journal, wanted.note.as_ref()) {
            Ok(()) => {
                for left in left.drain(..) {
                    let _ = left.discard();
                }
            }
            Err(error) => {
                let text = format!("what is unsaved cannot be kept over a crash: {error}");
                shared.lock().fault = Some(text);
                wake();
            }
        }
    }
}

fn wait<'s>(
    shared: &'s Shared,
    state: MutexGuard<'s, State>,
    most: Option<Duration>,
) -> MutexGuard<'s, State> {
    match most {
        Some(most) => {
            let waited = shared.changed.wait_timeout(state, most);
            waited.unwrap_or_else(PoisonError::into_inner).0
        }
        None => {
            let waited = shared.changed.wait(state);
            waited.unwrap_or_else(PoisonError::into_inner)
        }
    }
}

fn kept(folder: &Path, journal: &mut Option<Journal>, note: Option<&Note>) -> io::Result<()> {
    if journal.is_none() && note.is_some() {
        *journal = Some(Journal::open(folder)?);
    }
    journal
        .as_mut()
        .map_or(Ok(()), |journal| journal.keep(note))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::recovery::left;
    use std::fs;

    fn note(text: &str) -> Option<Note> {
        Some(Note {
            text: text.to_owned(),
            ..Note::default()
        })
    }

    /// What a kill would leave now.
    fn written(folder: &Path) -> Option<String> {
        let text = fs::read_to_string(folder.join("document-0.json")).ok()?;
        let note: Note = serde_json::from_str(&text).ok()?;
        Some(note.text)
    }

    fn until(what: &str, so: impl Fn() -> bool) {
        let begun = Instant::now();
        while !so() {
            assert!(begun.elapsed() < Duration::from_secs(20), "{what}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_text_that_goes_on_changing_is_written_now_and_then_and_its_end_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let mut scribe = Scribe::start(dir.path().to_owned(), || ()).unwrap();
        let (begun, mut seen) = (Instant::now(), Vec::new());
        let mut number = 0;
        while begun.elapsed() < 4 * EVERY {
            number += 1;
            scribe.keep(note(&number.to_string()));
            thread::sleep(Duration::from_millis(4));
            let now: Option<u32> = written(dir.path()).and_then(|text| text.parse().ok());
            if now.is_some() && now != seen.last().map(|(_, text)| *text) {
                seen.extend(now.map(|now| (begun.elapsed(), now)));
            }
        }
        // A machine under load may miss some of the times, and never has more of them.
        assert!((2..=5).contains(&seen.len()), "{seen:?} of {number}");
        scribe.keep(note("end"));
        scribe.hurry();
        let asked = Instant::now();
        until("the end", || written(dir.path()).as_deref() == Some("end"));
        println!("the end was written after {:?}", asked.elapsed());
        scribe.keep(None);
        until("nothing", || written(dir.path()).is_none());
        drop(scribe);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn what_was_done_just_before_the_window_goes_is_written() {
        let dir = tempfile::tempdir().unwrap();
        let mut scribe = Scribe::start(dir.path().to_owned(), || ()).unwrap();
        scribe.keep(note("one"));
        scribe.keep(note("two"));
        drop(scribe);
        let mut found = left(dir.path());
        assert_eq!(found[0].note.text, "two");
        // It is taken over by the next window, and goes only once that has it.
        let mut next = Scribe::start(dir.path().to_owned(), || ()).unwrap();
        next.take_over(note("two"), found.remove(0));
        drop(next);
        let found = left(dir.path());
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].note.text, "two");
    }

    #[test]
    fn a_note_whose_successor_was_not_written_goes_when_nothing_is_unsaved() {
        let dir = tempfile::tempdir().unwrap();
        let (folder, away) = (dir.path().join("notes"), dir.path().join("away"));
        let mut scribe = Scribe::start(folder.clone(), || ()).unwrap();
        scribe.keep(note("one"));
        until("the note", || written(&folder).as_deref() == Some("one"));
        fs::rename(&folder, &away).unwrap();
        fs::write(&folder, "").unwrap();
        scribe.keep(note("two"));
        until("the fault", || scribe.shared.lock().fault.is_some());
        assert!(scribe.take_fault().is_some());
        fs::remove_file(&folder).unwrap();
        fs::rename(&away, &folder).unwrap();
        scribe.keep(None);
        until("nothing", || written(&folder).is_none());
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_told_once() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        fs::write(&file, "").unwrap();
        let mut scribe = Scribe::start(file.join("notes"), || ()).unwrap();
        scribe.keep(note("one"));
        until("the fault", || scribe.shared.lock().fault.is_some());
        assert!(scribe.take_fault().unwrap().contains("cannot be kept"));
        assert_eq!(scribe.take_fault(), None);
    }
}

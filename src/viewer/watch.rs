//! Files that a tree is made of, and a thread that sees them change.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// How often files are looked at.
const EVERY: Duration = Duration::from_millis(500);

/// When a file was last written and how long it is; `None` if it is not there.
type Stamp = Option<(Option<SystemTime>, u64)>;

fn stamp(path: &Path) -> Stamp {
    let data = std::fs::metadata(path).ok()?;
    Some((data.modified().ok(), data.len()))
}

/// The files to look at, shared with whoever reads them.
#[derive(Clone, Debug, Default)]
pub struct Watched {
    stamps: Arc<Mutex<BTreeMap<PathBuf, Stamp>>>,
}

impl Watched {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Stamp>> {
        self.stamps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all files: they are about to be named again.
    pub fn clear(&self) {
        self.lock().clear();
    }

    /// Looks at a file from now on; to be called before it is read, so that no change between is missed.
    /// A file that is not there is looked for.
    pub fn note(&self, path: &Path) {
        let now = stamp(path);
        self.lock().entry(path.to_owned()).or_insert(now);
    }

    /// The files that are looked at.
    #[must_use]
    pub fn paths(&self) -> Vec<PathBuf> {
        self.lock().keys().cloned().collect()
    }

    /// True once for every change of any file.
    #[must_use]
    pub fn changed(&self) -> bool {
        let mut changed = false;
        for (path, known) in self.lock().iter_mut() {
            let now = stamp(path);
            changed |= now != *known;
            *known = now;
        }
        changed
    }
}

/// A thread that looks at files twice a second.
#[derive(Debug)]
pub struct Watch {
    told: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Starts the thread; `wake` is called from it when a file changed, and whenever `stop` says that the
    /// program is to end.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(
        watched: Watched,
        stop: fn() -> bool,
        wake: impl Fn() + Send + 'static,
    ) -> std::io::Result<Self> {
        let (told, over) = (
            Arc::new(AtomicBool::new(false)),
            Arc::new(AtomicBool::new(false)),
        );
        let (tell, end) = (Arc::clone(&told), Arc::clone(&over));
        let thread = std::thread::Builder::new()
            .name("watch".to_owned())
            .spawn(move || {
                while !end.load(Ordering::Relaxed) {
                    if watched.changed() {
                        tell.store(true, Ordering::Relaxed);
                        wake();
                    } else if stop() {
                        wake();
                    }
                    std::thread::park_timeout(EVERY);
                }
            })?;
        Ok(Self {
            told,
            over,
            thread: Some(thread),
        })
    }

    /// True once after a change.
    #[must_use]
    pub fn take(&self) -> bool {
        self.told.swap(false, Ordering::Relaxed)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // It only looks at files: a panic there is nothing to anyone.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::sync::mpsc::channel;

    #[test]
    fn a_changed_a_new_and_a_lost_file_are_each_seen_once() {
        let dir = tempfile::tempdir().unwrap();
        let [a, b] = ["a.ron", "b.txt"].map(|n| dir.path().join(n));
        fs::write(&a, "one").unwrap();
        let watched = Watched::default();
        watched.note(&a);
        watched.note(&b);
        assert!(!watched.changed());
        fs::write(&a, "three").unwrap();
        assert!(watched.changed() && !watched.changed());
        fs::write(&b, "").unwrap();
        assert!(watched.changed() && !watched.changed());
        fs::remove_file(&a).unwrap();
        assert!(watched.changed() && !watched.changed());
    }

    #[test]
    fn a_change_between_noting_and_looking_again_is_not_missed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.ron");
        fs::write(&path, "one").unwrap();
        let watched = Watched::default();
        watched.note(&path);
        fs::write(&path, "three").unwrap();
        // A second reader names it once more before anybody looked.
        watched.note(&path);
        assert!(watched.changed());
    }

    #[test]
    fn the_thread_wakes_whoever_is_to_end() {
        let (woken, wakes) = channel();
        let watch = Watch::start(
            Watched::default(),
            || true,
            move || {
                let _ = woken.send(());
            },
        )
        .unwrap();
        wakes.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(!watch.take(), "no file changed");
    }

    #[test]
    fn the_thread_wakes_whoever_waits() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.ron");
        fs::write(&path, "one").unwrap();
        let watched = Watched::default();
        watched.note(&path);
        let (woken, wakes) = channel();
        let watch = Watch::start(
            watched,
            || false,
            move || {
                let _ = woken.send(());
            },
        )
        .unwrap();
        assert!(!watch.take());
        fs::write(&path, "three").unwrap();
        wakes.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(watch.take() && !watch.take());
    }
}

//! Which of the recent files are there still, asked in threads: one on a network that is gone does not hold up the menu.

use super::asking::Answer;
use eframe::egui::Context;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long an answer is good for.
const GOOD: Duration = Duration::from_secs(5);

/// How often it is looked for answers.
const AGAIN: Duration = Duration::from_millis(100);

/// What is known of files.
#[derive(Debug, Default)]
pub(super) struct Presence {
    known: RefCell<BTreeMap<PathBuf, Known>>,
}

#[derive(Debug)]
struct Known {
    asked: Instant,
    answer: Answer<bool>,
    /// What was true last.
    is_there: bool,
}

impl Presence {
    /// True for a file that is there, or of which nothing else is known yet.
    pub(super) fn is_there(&self, path: &Path, ctx: &Context) -> bool {
        let mut known = self.known.borrow_mut();
        let known = known.entry(path.to_owned()).or_insert_with(|| Known {
            asked: Instant::now(),
            answer: ask(path),
            is_there: true,
        });
        known.answer.poll();
        // One that has not answered is not asked again.
        if !known.answer.is_awaited() && known.asked.elapsed() > GOOD {
            (known.asked, known.answer) = (Instant::now(), ask(path));
        }
        if let Some(is_there) = known.answer.get() {
            known.is_there = *is_there;
        }
        if known.answer.is_awaited() {
            ctx.request_repaint_after(AGAIN);
        }
        known.is_there
    }
}

fn ask(path: &Path) -> Answer<bool> {
    let path = path.to_owned();
    Answer::later(move || path.exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_until_it_is_known_not_to_be() {
        let dir = tempfile::tempdir().unwrap();
        let (there, gone) = (dir.path().join("a.ron"), dir.path().join("b.ron"));
        std::fs::write(&there, "()").unwrap();
        let (presence, ctx) = (Presence::default(), Context::default());
        assert!(presence.is_there(&gone, &ctx) || !gone.exists());
        let begun = Instant::now();
        while presence.is_there(&gone, &ctx) {
            assert!(begun.elapsed() < Duration::from_secs(20));
        }
        while presence
            .known
            .borrow()
            .values()
            .any(|k| k.answer.is_awaited())
        {
            presence.is_there(&there, &ctx);
            presence.is_there(&gone, &ctx);
        }
        assert!(presence.is_there(&there, &ctx));
    }
}

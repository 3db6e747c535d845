//! Measuring forms and choosing LODs tell how far they are, and end when they are told to.

mod common;

use std::sync::Mutex;

use pleach::pipeline::{self, GenerateError, Settings};
use pleach::report::Progress;
use pleach::species::Beside;

const MEASURING: &str = "measuring forms";
const CHOOSING: &str = "choosing LODs";

/// Notes what it is told, and cancels once it was asked more than so many times in one stage.
struct Watcher {
    stage: &'static str,
    patience: u32,
    seen: Mutex<Seen>,
}

#[derive(Default)]
struct Seen {
    /// Stages begun, with the steps announced and done.
    stages: Vec<(&'static str, u64, u64)>,
    /// Times asked in the stage.
    asked: u32,
    cancelled: bool,
    /// Steps and stages after the cancel.
    late: u32,
}

impl Seen {
    /// Steps announced and done.
    fn steps(&self, stage: &str) -> (u64, u64) {
        let found = self.stages.iter().find(|s| s.0 == stage);
        found.map(|s| (s.1, s.2)).expect("the stage was begun")
    }
}

impl Progress for Watcher {
    fn begin(&self, stage: &'static str, steps: u64) {
        let mut seen = self.seen.lock().expect("not poisoned");
        seen.late += u32::from(seen.cancelled);
        seen.stages.push((stage, steps, 0));
    }

    fn step(&self) {
        let mut seen = self.seen.lock().expect("not poisoned");
        seen.late += u32::from(seen.cancelled);
        seen.stages.last_mut().expect("a stage has begun").2 += 1;
    }

    fn cancelled(&self) -> bool {
        let mut seen = self.seen.lock().expect("not poisoned");
        if seen.stages.last().is_some_and(|s| s.0 == self.stage) {
            seen.asked += 1;
            seen.cancelled |= seen.asked > self.patience;
        }
        seen.cancelled
    }
}

/// Makes a palm on one thread, so that nothing else is under way when it is cancelled.
fn generate(stage: &'static str, patience: u32) -> (Result<(), GenerateError>, Seen) {
    let scripts = common::scripts();
    let palm = scripts.iter().find(|s| s.slug == "palm");
    let palm = palm.expect("a script of the repository");
    let mut settings = Settings {
        budgets: Some(vec![2000, 300]),
        bark_size: 32,
        ..Settings::default()
    };
    settings.captures.atlas_size = 256;
    settings.shadows.size = 32;
    let watcher = Watcher {
        stage,
        patience,
        seen: Mutex::default(),
    };
    let files = Beside(palm.folder.clone());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let made = pool
        .expect("one thread")
        .install(|| pipeline::generate(&palm.species, &settings, &files, &watcher).map(drop));
    (made, watcher.seen.into_inner().expect("not poisoned"))
}

#[test]
fn every_step_of_measuring_and_choosing_is_told_and_measuring_asks_within_its_steps() {
    let (made, seen) = generate(MEASURING, u32::MAX);
    made.expect("a sound script");
    for stage in [MEASURING, CHOOSING] {
        let (steps, done) = seen.steps(stage);
        assert!(steps > 0, "{stage}");
        assert_eq!(done, steps, "{stage}");
    }
    // Each sub-tree is looked at from six or twelve sides.
    let steps = seen.steps(MEASURING).0;
    assert!(u64::from(seen.asked) > 6 * steps, "{} {steps}", seen.asked);
}

#[test]
fn a_cancel_ends_measuring_and_choosing_without_another_step() {
    for (stage, patience) in [
        (MEASURING, 0),
        (MEASURING, 9),
        (MEASURING, 60),
        (CHOOSING, 0),
        (CHOOSING, 14),
    ] {
        let (made, seen) = generate(stage, patience);
        let told = format!("{stage}, asked {} times", seen.asked);
        assert!(
            matches!(made, Err(GenerateError::Cancelled(_))),
            "{told}: {made:?}"
        );
        assert_eq!(seen.stages.last().map(|s| s.0), Some(stage), "{told}");
        assert_eq!(seen.late, 0, "{told}");
    }
}

//! Questions to disks that may not answer: a folder on a network that is gone holds up its own thread, not the window.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, TryRecvError};
use std::thread;
use std::time::Duration;

/// How long the window waits for an answer without which it cannot go on.
pub(super) const PATIENCE: Duration = Duration::from_secs(1);

/// How long it waits for one that may come later: most disks answer within a frame, and nothing flickers then.
const GRACE: Duration = Duration::from_millis(if cfg!(test) { 20_000 } else { 60 });

/// An answer that has come, or is to come.
#[derive(Debug)]
pub(super) enum Answer<T> {
    Here(T),
    Awaited(Receiver<T>),
    /// There will be none.
    Never,
}

/// Puts a question in a thread of its own.
fn put<T: Send + 'static>(question: impl FnOnce() -> T + Send + 'static) -> Option<Receiver<T>> {
    let (answer, answers) = mpsc::channel();
    let ask = move || {
        // Nobody may wait for it any more.
        let _ = answer.send(question());
    };
    let thread = thread::Builder::new().name("ask".to_owned()).spawn(ask);
    thread.ok().map(|_| answers)
}

/// The answer, if it comes in time.
pub(super) fn within<T: Send + 'static>(
    patience: Duration,
    question: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    put(question)?.recv_timeout(patience).ok()
}

impl<T: Send + 'static> Answer<T> {
    /// Asks, and waits for a moment.
    pub(super) fn to(question: impl FnOnce() -> T + Send + 'static) -> Self {
        let Some(answers) = put(question) else {
            return Self::Never;
        };
        match answers.recv_timeout(GRACE) {
            Ok(answer) => Self::Here(answer),
            Err(RecvTimeoutError::Timeout) => Self::Awaited(answers),
            Err(RecvTimeoutError::Disconnected) => Self::Never,
        }
    }

    /// Asks, and waits for nothing.
    pub(super) fn later(question: impl FnOnce() -> T + Send + 'static) -> Self {
        put(question).map_or(Self::Never, Self::Awaited)
    }

    /// Takes in what has come; true if that is something new.
    pub(super) fn poll(&mut self) -> bool {
        let Self::Awaited(answers) = self else {
            return false;
        };
        *self = match answers.try_recv() {
            Ok(answer) => Self::Here(answer),
            Err(TryRecvError::Empty) => return false,
            Err(TryRecvError::Disconnected) => Self::Never,
        };
        true
    }

    /// The answer, if it is there.
    pub(super) fn get(&self) -> Option<&T> {
        match self {
            Self::Here(answer) => Some(answer),
            Self::Awaited(_) | Self::Never => None,
        }
    }

    pub(super) fn is_awaited(&self) -> bool {
        matches!(self, Self::Awaited(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    #[test]
    fn a_disk_that_does_not_answer_holds_up_nobody() {
        let (hold, held) = mpsc::channel::<()>();
        let begun = Instant::now();
        let dead = move || held.recv().is_err();
        assert_eq!(within(Duration::from_millis(50), dead), None);
        assert!(begun.elapsed() < Duration::from_secs(10));
        drop(hold);
        assert_eq!(within(Duration::from_secs(20), || 7), Some(7));
    }

    #[test]
    fn an_answer_that_comes_later_is_taken_in_once() {
        let (release, released) = mpsc::channel::<()>();
        let mut answer = Answer::later(move || released.recv().is_ok());
        assert!(!answer.poll() && answer.is_awaited() && answer.get().is_none());
        release.send(()).unwrap();
        let begun = Instant::now();
        while !answer.poll() {
            assert!(begun.elapsed() < Duration::from_secs(20));
        }
        assert_eq!(answer.get(), Some(&true));
        assert!(!answer.poll());
        assert_eq!(Answer::to(|| 3).get(), Some(&3));
    }
}

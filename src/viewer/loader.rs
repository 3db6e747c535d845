//! Work on a thread of its own, so that a window stays quick: the newest piece wins, what it overtakes is
//! cancelled, and the last good result stays.

use crate::report::Progress;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A piece of work: gives a result, or says in words why there is none. It should give up early if its
/// progress says that it is cancelled; whatever it then returns is dropped.
pub type Job<T> = Box<dyn FnOnce(&dyn Progress) -> Result<T, String> + Send>;

/// How far the newest piece of work is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stage {
    /// What is being done.
    pub name: &'static str,
    /// Steps done.
    pub done: u64,
    /// Steps in all; 0 if not known.
    pub steps: u64,
}

/// A thread that does one piece of work at a time, and what came of it.
pub struct Loader<T> {
    shared: Arc<Shared<T>>,
    news: Receiver<News<T>>,
    /// Number of the newest piece asked for.
    asked: u64,
    /// Number of the oldest piece whose result still counts.
    counts: u64,
    busy: bool,
    fault: Option<String>,
    good: Option<Arc<T>>,
}

/// What a call of [`Loader::poll`] found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Polled {
    /// There is a new good result.
    pub good: bool,
    /// Any of fault, result and business changed.
    pub changed: bool,
}

struct Shared<T> {
    next: Mutex<Next<T>>,
    some: Condvar,
    stage: Mutex<Stage>,
    wake: Box<dyn Fn() + Send + Sync>,
}

struct Next<T> {
    job: Option<(u64, Job<T>, Arc<AtomicBool>)>,
    /// Cancels the piece that is being done.
    running: Option<Arc<AtomicBool>>,
    over: bool,
}

struct News<T> {
    number: u64,
    result: Result<T, String>,
}

/// A poisoned lock still holds a whole value: writers only ever replace it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + 'static> Loader<T> {
    /// Starts the thread; `wake` is called from it when there is something to [`Loader::poll`], and when work
    /// comes to another stage.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(name: &str, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            next: Mutex::new(Next {
                job: None,
                running: None,
                over: false,
            }),
            some: Condvar::new(),
            stage: Mutex::new(Stage::default()),
            wake: Box::new(wake),
        });
        let (sender, news) = channel();
        let theirs = Arc::clone(&shared);
        std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || work(&theirs, &sender))?;
        Ok(Self {
            shared,
            news,
            asked: 0,
            counts: 0,
            busy: false,
            fault: None,
            good: None,
        })
    }

    /// Asks for a piece of work; all that were asked for before are overtaken.
    pub fn ask(&mut self, job: Job<T>) {
        self.counts = self.asked + 1;
        self.cancel();
        self.follow(job);
    }

    /// Asks for a piece of work, which takes the place of those that wait. The one that is being done is finished,
    /// and its result counts until this one's is there: where pieces are asked for faster than they are done, some
    /// of them are seen.
    pub fn follow(&mut self, job: Job<T>) {
        self.asked += 1;
        self.busy = true;
        lock(&self.shared.next).job = Some((self.asked, job, Arc::new(AtomicBool::new(false))));
        self.shared.some.notify_one();
    }

    /// Lets go of what is being done and of what was asked for; the last good result stays.
    pub fn stop(&mut self) {
        self.asked += 1;
        self.counts = self.asked;
        self.busy = false;
        lock(&self.shared.next).job = None;
        self.cancel();
    }

    /// Tells the piece that is being done to give up.
    fn cancel(&self) {
        if let Some(running) = &lock(&self.shared.next).running {
            running.store(true, Ordering::Relaxed);
        }
    }

    /// Takes in what has been done since the last call.
    pub fn poll(&mut self) -> Polled {
        let mut polled = Polled::default();
        while let Ok(News { number, result }) = self.news.try_recv() {
            if number < self.counts {
                continue;
            }
            self.counts = number;
            self.busy &= number != self.asked;
            polled.changed = true;
            match result {
                Ok(good) => {
                    self.good = Some(Arc::new(good));
                    self.fault = None;
                    polled.good = true;
                }
                Err(fault) => self.fault = Some(fault),
            }
        }
        polled
    }

    /// The last good result.
    #[must_use]
    pub fn good(&self) -> Option<&Arc<T>> {
        self.good.as_ref()
    }

    /// Why the newest piece of work that ended gave none.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// How far the newest piece of work is, while it is done.
    #[must_use]
    pub fn stage(&self) -> Option<Stage> {
        self.busy.then(|| lock(&self.shared.stage).clone())
    }
}

impl<T> std::fmt::Debug for Loader<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Loader")
            .field("asked", &self.asked)
            .field("busy", &self.busy)
            .field("fault", &self.fault)
            .finish_non_exhaustive()
    }
}

impl<T> Drop for Loader<T> {
    fn drop(&mut self) {
        let mut next = lock(&self.shared.next);
        next.over = true;
        next.job = None;
        if let Some(running) = &next.running {
            running.store(true, Ordering::Relaxed);
        }
        drop(next);
        self.shared.some.notify_one();
    }
}

/// The thread's life.
fn work<T>(shared: &Shared<T>, sender: &Sender<News<T>>) {
    while let Some((number, job, cancelled)) = next(shared) {
        *lock(&shared.stage) = Stage::default();
        let progress = Told {
            stage: &shared.stage,
            wake: &*shared.wake,
            cancelled: &cancelled,
        };
        // A fault of ours must not end the thread: the author of a script would wait for ever.
        let result = catch_unwind(AssertUnwindSafe(|| job(&progress))).unwrap_or_else(|_| {
            Err("the work stopped on a fault of this program; please report it".to_owned())
        });
        if cancelled.load(Ordering::Relaxed) {
            continue;
        }
        if sender.send(News { number, result }).is_err() {
            return;
        }
        (shared.wake)();
    }
}

/// Waits for the next piece of work; `None` when the loader is gone.
fn next<T>(shared: &Shared<T>) -> Option<(u64, Job<T>, Arc<AtomicBool>)> {
    let mut next = lock(&shared.next);
    next.running = None;
    loop {
        if next.over {
            return None;
        }
        if let Some((number, job, cancelled)) = next.job.take() {
            next.running = Some(Arc::clone(&cancelled));
            return Some((number, job, cancelled));
        }
        next = shared
            .some
            .wait(next)
            .unwrap_or_else(PoisonError::into_inner);
    }
}

struct Told<'a> {
    stage: &'a Mutex<Stage>,
    wake: &'a (dyn Fn() + Send + Sync),
    cancelled: &'a AtomicBool,
}

impl Progress for Told<'_> {
    fn begin(&self, name: &'static str, steps: u64) {
        *lock(self.stage) = Stage {
            name,
            done: 0,
            steps,
        };
        (self.wake)();
    }

    fn step(&self) {
        lock(self.stage).done += 1;
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, Instant};

    fn loader() -> Loader<u32> {
        Loader::start("test", || ()).unwrap()
    }

    /// Polls until something is good or faulty; fails after a long time.
    fn settled(loader: &mut Loader<u32>) {
        let begun = Instant::now();
        while !loader.poll().changed {
            assert!(begun.elapsed() < Duration::from_secs(20), "nothing came");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Works until it is cancelled.
    fn endless(began: Sender<()>, ended: Sender<()>) -> Job<u32> {
        Box::new(move |progress| {
            progress.begin("waiting", 0);
            let _ = began.send(());
            while !progress.cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            let _ = ended.send(());
            Ok(0)
        })
    }

    #[test]
    fn the_newest_piece_wins_and_cancels_the_one_before() {
        let mut loader = loader();
        let (began, has_begun) = channel();
        let (ended, has_ended) = channel();
        loader.ask(endless(began, ended));
        has_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        assert_eq!(loader.stage().unwrap().name, "waiting");
        // The second is overtaken before it begins.
        loader.ask(Box::new(|_| Ok(1)));
        loader.ask(Box::new(|_| Ok(2)));
        has_ended.recv_timeout(Duration::from_secs(20)).unwrap();
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(2));
        assert_eq!(loader.stage(), None);
    }

    #[test]
    fn a_fault_keeps_the_last_good_result_and_goes_when_all_is_well() {
        let mut loader = loader();
        loader.ask(Box::new(|_| Ok(7)));
        settled(&mut loader);
        loader.ask(Box::new(|_| Err("line 3: no such field".to_owned())));
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(7));
        assert_eq!(loader.fault(), Some("line 3: no such field"));
        loader.ask(Box::new(|_| Ok(8)));
        settled(&mut loader);
        assert_eq!(
            (loader.good().map(|g| **g), loader.fault()),
            (Some(8), None)
        );
    }

    #[test]
    fn a_panic_is_a_fault_and_work_goes_on() {
        let mut loader = loader();
        loader.ask(Box::new(|_| panic!("planted by a test")));
        settled(&mut loader);
        assert!(loader.fault().unwrap().contains("fault of this program"));
        loader.ask(Box::new(|_| Ok(1)));
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(1));
    }

    #[test]
    fn what_is_stopped_gives_nothing_and_what_comes_after_does() {
        let mut loader = loader();
        let (began, has_begun) = channel();
        let (ended, has_ended) = channel();
        loader.ask(endless(began, ended));
        has_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        loader.stop();
        has_ended.recv_timeout(Duration::from_secs(20)).unwrap();
        assert_eq!((loader.stage(), loader.poll()), (None, Polled::default()));
        loader.ask(Box::new(|_| Ok(3)));
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(3));
    }

    #[test]
    fn what_is_followed_is_finished_and_what_waited_in_between_is_not_begun() {
        let mut loader = loader();
        let (began, has_begun) = channel();
        let (go, may_go) = channel();
        loader.ask(Box::new(move |progress| {
            let _ = began.send(());
            let _ = may_go.recv_timeout(Duration::from_secs(20));
            Ok(u32::from(progress.cancelled()) + 10)
        }));
        has_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        loader.follow(Box::new(|_| Ok(1)));
        let (go_on, may_go_on) = channel();
        loader.follow(Box::new(move |_| {
            let _ = may_go_on.recv_timeout(Duration::from_secs(20));
            Ok(2)
        }));
        go.send(()).unwrap();
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(10));
        assert!(loader.stage().is_some(), "the next one is still to come");
        go_on.send(()).unwrap();
        settled(&mut loader);
        assert_eq!(loader.good().map(|g| **g), Some(2));
        assert_eq!(loader.stage(), None);
    }

    #[test]
    fn letting_go_of_the_loader_cancels_its_work() {
        let mut loader = loader();
        let (began, has_begun) = channel();
        let (ended, has_ended) = channel();
        loader.ask(endless(began, ended));
        has_begun.recv_timeout(Duration::from_secs(20)).unwrap();
        drop(loader);
        has_ended.recv_timeout(Duration::from_secs(20)).unwrap();
    }

    #[test]
    fn the_window_is_woken_for_stages_and_results() {
        let (woken, wakes) = channel();
        let mut loader: Loader<u32> = Loader::start("test", move || {
            let _ = woken.send(());
        })
        .unwrap();
        loader.ask(Box::new(|progress| {
            progress.begin("one", 1);
            Ok(1)
        }));
        for _ in 0..2 {
            wakes.recv_timeout(Duration::from_secs(20)).unwrap();
        }
        settled(&mut loader);
    }
}

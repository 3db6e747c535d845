//! Progress bars; hidden where stderr is no terminal.

use crate::report::Progress;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::time::Duration;

/// A bar that follows the stages of one tree.
#[derive(Debug)]
pub(crate) struct Bar {
    bar: ProgressBar,
    name: String,
}

impl Bar {
    pub(crate) fn alone(name: &str) -> Self {
        Self::of(ProgressBar::new(0), name)
    }

    pub(crate) fn among(bars: &MultiProgress, name: &str) -> Self {
        Self::of(bars.add(ProgressBar::new(0)), name)
    }

    fn of(bar: ProgressBar, name: &str) -> Self {
        bar.set_style(style("{spinner} {msg:32!} {bar:30} {pos}/{len}"));
        bar.set_message(name.to_owned());
        bar.enable_steady_tick(Duration::from_millis(120));
        Self {
            bar,
            name: name.to_owned(),
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn begin(&self, stage: &'static str, steps: u64) {
        self.bar.set_message(format!("{} {stage}", self.name));
        self.bar.set_length(steps);
        self.bar.set_position(0);
    }

    fn step(&self) {
        self.bar.inc(1);
    }

    fn cancelled(&self) -> bool {
        super::interrupted()
    }
}

/// A style, or indicatif's own if the template were wrong.
pub(crate) fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

//! A progress bar on stderr; none unless that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt;
use crate::watch::{Progress, Watch};

/// A bar that knows its end, or learns it from the work; it goes when it is dropped.
pub(super) fn bar(length: u64, what: &str) -> Bar {
    Bar::new(ProgressBar::new(length), what, "{msg} {wide_bar} {percent} % {eta} left")
}

/// A bar of so many steps, each of which is told by its name.
pub(super) fn steps(length: u64, what: &str) -> Bar {
    Bar { counts_names: true, ..bar(length, what) }
}

/// A bar that is told how much time is left.
pub(super) fn timed(what: &str) -> ProgressBar {
    let bar = ProgressBar::new(0).with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}") {
        bar.set_style(style);
    }
    bar
}

/// A counter for fits, whose length is not known.
pub(super) fn counter(prefix: &str) -> Bar {
    let style = "{spinner} {msg}: {pos} evaluations, {elapsed}";
    Bar { prefix: prefix.to_owned(), ..Bar::new(ProgressBar::no_length(), prefix, style) }
}

/// A progress bar that work tells how far it is.
pub(super) struct Bar {
    shown: ProgressBar,
    /// Goes before what is done now.
    prefix: String,
    /// Each name is a step; else it begins a new count.
    counts_names: bool,
}

impl Bar {
    fn new(bar: ProgressBar, what: &str, style: &str) -> Self {
        let bar = bar.with_message(what.to_owned());
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style);
        }
        Self { shown: bar, prefix: String::new(), counts_names: false }
    }

    /// Does work that this bar and the user's signals watch.
    pub(super) fn watch<T>(self, work: impl FnOnce(Watch<'_>) -> T) -> T {
        let tell = |progress: Progress<'_>| match progress {
            Progress::Now(what) => {
                self.shown.set_message(format!("{}{what}", self.prefix));
                if self.counts_names {
                    self.shown.inc(1);
                } else {
                    self.shown.set_position(0);
                    self.shown.reset_elapsed();
                }
            }
            Progress::Done { done, all } => {
                if all > 0 {
                    self.shown.set_length(all as u64);
                }
                self.shown.set_position(done as u64);
            }
            Progress::More(steps) => self.shown.inc(steps),
        };
        let done = work(Watch::new(interrupt::flag(), &tell));
        self.shown.finish_and_clear();
        done
    }
}

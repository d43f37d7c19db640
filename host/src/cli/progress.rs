//! How far work is, on stderr: a bar on a terminal, else a line now and then.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::{interrupt, say};
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

/// A progress bar that work tells how far it is; plain lines, seldom, where stderr is no terminal.
pub(super) struct Bar {
    shown: ProgressBar,
    /// Goes before what is done now.
    prefix: String,
    /// Each name is a step; else it begins a new count.
    counts_names: bool,
    /// When the last line was written, and whether lines are.
    last_line: Option<Mutex<Instant>>,
}

/// Time between two lines.
const SELDOM: Duration = Duration::from_secs(10);

impl Bar {
    fn new(shown: ProgressBar, what: &str, style: &str) -> Self {
        let shown = shown.with_message(what.to_owned());
        if let Ok(style) = ProgressStyle::with_template(style) {
            shown.set_style(style);
        }
        let is_terminal = std::io::stderr().is_terminal();
        if say::is_quiet() {
            shown.set_draw_target(ProgressDrawTarget::hidden());
        }
        let last_line = (!is_terminal && !say::is_quiet()).then(|| Mutex::new(Instant::now()));
        Self { shown, prefix: String::new(), counts_names: false, last_line }
    }

    /// Does work that this bar and the user's signals watch.
    pub(super) fn watch<T>(self, work: impl FnOnce(Watch<'_>) -> T) -> T {
        let done = work(Watch::new(interrupt::flag(), &|progress| self.tell(progress)));
        let (what, seconds) = (self.shown.message(), self.shown.elapsed().as_secs_f64());
        self.shown.finish_and_clear();
        say::detail(format_args!("{what}: {seconds:.2} s"));
        done
    }

    fn tell(&self, progress: Progress<'_>) {
        match progress {
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
        }
        self.line();
    }

    /// Writes a line, if it is time for one.
    fn line(&self) {
        let Some(last) = &self.last_line else { return };
        // whoever finds it taken leaves the line to the other thread
        let Ok(mut last) = last.try_lock() else { return };
        if last.elapsed() < SELDOM {
            return;
        }
        *last = Instant::now();
        let (what, done) = (self.shown.message(), self.shown.position());
        match self.shown.length().filter(|all| *all > 0) {
            Some(all) => say::note(format_args!(
                "{what}: {:.0} %, {} s left",
                100.0 * done as f64 / all as f64,
                self.shown.eta().as_secs()
            )),
            None => say::note(format_args!("{what}: {done} evaluations")),
        }
    }
}

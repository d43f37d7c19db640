//! How far work is, on stderr: a bar on a terminal, else a line now and then.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
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

/// Several fits at once, with the time that is left for all of them.
pub(super) struct Board {
    shown: ProgressBar,
    state: Mutex<BoardState>,
    all: usize,
    begun: Instant,
}

#[derive(Default)]
struct BoardState {
    running: Vec<String>,
    done: usize,
    last_line: Option<Instant>,
}

impl Board {
    pub(super) fn new(all: usize) -> Self {
        let shown = ProgressBar::new(all as u64);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len}  {msg}") {
            shown.set_style(style);
        }
        if say::is_quiet() || all == 0 {
            shown.set_draw_target(ProgressDrawTarget::hidden());
        }
        Self { shown, state: Mutex::default(), all, begun: Instant::now() }
    }

    /// Does one of the fits, which the user's signals watch.
    pub(super) fn watch<T>(&self, name: &str, work: impl FnOnce(Watch<'_>) -> T) -> T {
        self.change(|state| state.running.push(name.to_owned()));
        let done = work(Watch::new(interrupt::flag(), &|_| self.tell()));
        self.change(|state| {
            state.running.retain(|n| n != name);
            state.done += 1;
        });
        self.shown.inc(1);
        done
    }

    /// A line that does not tear the bar.
    pub(super) fn say(&self, line: std::fmt::Arguments<'_>) {
        self.shown.suspend(|| say::note(line));
    }

    fn change(&self, change: impl FnOnce(&mut BoardState)) {
        change(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner));
        self.tell();
    }

    /// What runs and how long all will take, on the bar or as a line now and then.
    fn tell(&self) {
        // whoever finds it taken leaves it to the other thread
        let Ok(mut state) = self.state.try_lock() else { return };
        let left = self.left(&state).map_or(String::new(), |s| format!(", {s:.0} s left"));
        let running = state.running.join(", ");
        if std::io::stderr().is_terminal() {
            self.shown.set_message(format!("{running}{left}"));
            return;
        }
        let last = state.last_line.unwrap_or(self.begun);
        if !say::is_quiet() && last.elapsed() >= SELDOM && !running.is_empty() {
            state.last_line = Some(Instant::now());
            say::note(format_args!("{} of {} fits{left}: {running}", state.done, self.all));
        }
    }

    /// Seconds left: every fit takes as long as those before, so many of them at once.
    fn left(&self, state: &BoardState) -> Option<f64> {
        let each =
            self.begun.elapsed().as_secs_f64() / (state.done > 0).then_some(state.done)? as f64;
        Some(each * (self.all - state.done.min(self.all)) as f64)
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.shown.finish_and_clear();
    }
}

//! A progress bar on stderr; none unless that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that knows its end.
pub(super) fn bar(length: u64, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(length).with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} % {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// A bar that is told how much time is left.
pub(super) fn timed(what: &str) -> ProgressBar {
    let bar = ProgressBar::new(0).with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}") {
        bar.set_style(style);
    }
    bar
}

/// A counter for work of unknown length.
pub(super) fn counter(what: &str) -> ProgressBar {
    let bar = ProgressBar::no_length().with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}: {pos} evaluations, {elapsed}")
    {
        bar.set_style(style);
    }
    bar
}

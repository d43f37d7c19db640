//! What is said on stderr: notes unless the user wants quiet, details if they ask for them, errors always.
//!
//! If nobody can read it, that is no failure.

use std::fmt::Arguments;
use std::io::Write;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::message::brief;

const QUIET: u8 = 0;
const USUAL: u8 = 1;
const VERBOSE: u8 = 2;

static LEVEL: AtomicU8 = AtomicU8::new(USUAL);

/// How much is said from now on.
pub(super) fn set(quiet: bool, verbose: bool) {
    let level = match (quiet, verbose) {
        (true, _) => QUIET,
        (false, true) => VERBOSE,
        (false, false) => USUAL,
    };
    LEVEL.store(level, Ordering::Relaxed);
}

/// Whether anything but errors is said.
pub(super) fn is_quiet() -> bool {
    LEVEL.load(Ordering::Relaxed) == QUIET
}

/// Says why the verb ends as it does.
pub(super) fn error(what: Arguments<'_>) {
    let text = what.to_string();
    drop(writeln!(std::io::stderr().lock(), "{}", brief(&text)));
}

/// Says a note, a warning or what was done.
pub(super) fn note(what: Arguments<'_>) {
    if !is_quiet() {
        error(what);
    }
}

/// Says a detail, for those who ask for them.
pub(super) fn detail(what: Arguments<'_>) {
    if LEVEL.load(Ordering::Relaxed) == VERBOSE {
        error(what);
    }
}

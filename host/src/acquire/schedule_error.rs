//! A schedule that cannot be read, or cannot be meant.

use std::io;
use std::path::PathBuf;

use asperity_core::protocol::MAX_POINTS;
use thiserror::Error;

/// A schedule that cannot be read, or cannot be meant.
#[derive(Debug, Error)]
pub enum ScheduleError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; check the path", path.display())]
    Read {
        /// The schedule file.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
    /// The file is too large.
    #[error("{}: is larger than 1 MiB, no schedule is; check the path", path.display())]
    TooLarge {
        /// The schedule file.
        path: PathBuf,
    },
    /// The file is not a schedule.
    #[error("{}:{line}: {what}; see the example in `asperity acquire --help`", path.display())]
    Syntax {
        /// The schedule file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// An impossible value.
    #[error("{key} {value} is not usable; {allowed}")]
    Value {
        /// The key of the schedule file; a flag is called alike.
        key: &'static str,
        /// The given value.
        value: String,
        /// The allowed values.
        allowed: &'static str,
    },
    /// A longer grid than an instrument holds.
    #[error(
        "{count} angles of observation are more than the {MAX_POINTS} of a segment; take a larger \
         --step, or scan in two files (--theta-range)"
    )]
    TooLong {
        /// Angles requested.
        count: i64,
    },
}

//! Faults of a file of scatter, and of what a format can hold.

use std::path::PathBuf;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// The fault and the remedy.
    pub fault: Fault,
}

/// The fault; the text ends with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// It cannot be opened.
    #[error("cannot be read ({0}); check the path and the permissions")]
    Io(#[from] std::io::Error),
    /// There is nothing in it.
    #[error("the file is empty; export it again")]
    Empty,
    /// No reader knows it.
    #[error("no known format of scatter; give one of {known}")]
    Unknown {
        /// Names of the formats.
        known: String,
    },
    /// It breaks the rules of its format.
    #[error("{format}: line {line}: {what}; correct the line, or export the file again")]
    Line {
        /// The format.
        format: &'static str,
        /// Line, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// The same where there are no lines.
    #[error("{format}: {what}; the file is damaged or not of this format, export it again")]
    Damaged {
        /// The format.
        format: &'static str,
        /// The fault and its place.
        what: String,
    },
    /// It uses a part of its format that is not supported.
    #[error("{format}: {what} is not supported; {remedy}")]
    Unsupported {
        /// The format.
        format: &'static str,
        /// What.
        what: String,
        /// The remedy.
        remedy: &'static str,
    },
}

/// What a format cannot hold; the text ends with the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{format} cannot hold {what}; {remedy}")]
pub struct CannotHold {
    /// The format.
    pub format: &'static str,
    /// What it has no place for.
    pub what: String,
    /// The remedy.
    pub remedy: String,
}

impl CannotHold {
    /// Of a format, what it has no place for, and the remedy.
    pub fn new(format: &'static str, what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { format, what: what.into(), remedy: remedy.into() }
    }
}

//! A scene that cannot be read, or cannot be meant.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// A scene that cannot be read, or cannot be meant.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}; check the path", path.display())]
    Read {
        /// The scene file.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
    /// The file is too large.
    #[error("{}: is larger than 1 MiB, no scene is; check the path", path.display())]
    TooLarge {
        /// The scene file.
        path: PathBuf,
    },
    /// A line at fault.
    #[error("{}:{line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The fault and its remedy.
        what: String,
    },
}

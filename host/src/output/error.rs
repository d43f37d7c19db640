//! Why an output cannot be written.

use std::io::{self, ErrorKind};
use std::path::PathBuf;

use thiserror::Error;

/// Why an output file could not be opened or completed. Each names the path and the remedy.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The path is a folder, or ends in `/` or `..`.
    #[error("{}: is a folder, not a file; add a file name", path.display())]
    Folder {
        /// The requested path.
        path: PathBuf,
    },
    /// The folder that should hold the file is missing.
    #[error("{}: there is no folder {}; create it or choose another place", path.display(), folder.display())]
    NoFolder {
        /// The requested path.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// The file exists and is write-protected.
    #[error("{}: exists and is write-protected; choose another name or lift the protection", path.display())]
    WriteProtected {
        /// The requested path.
        path: PathBuf,
    },
    /// The operating system refuses to create the file.
    #[error("{}: cannot be created: {source}; check the permissions of the folder", path.display())]
    Create {
        /// The requested path.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
    /// The content could not be written, or the finished file not renamed.
    #[error("{}: cannot be written: {source}; check the free space and the permissions", path.display())]
    Write {
        /// The requested path.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
    /// The file is an input of this run.
    #[error("{}: is an input ({}) and would be overwritten; choose another file or choose another folder", path.display(), input.display())]
    Input {
        /// The requested path.
        path: PathBuf,
        /// The input, as it was named.
        input: PathBuf,
    },
    /// The file is another output of this run.
    #[error("{}: is written by this run already ({}); choose another name for one of the two", path.display(), other.display())]
    Twice {
        /// The requested path.
        path: PathBuf,
        /// The other output, as it was named.
        other: PathBuf,
    },
    /// A folder for results cannot be made.
    #[error("{}: cannot be made ({source}); choose another folder", path.display())]
    NotMade {
        /// The folder.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
}

impl OutputError {
    /// Whether the system failed, for example for lack of space, although the request was valid.
    pub fn is_trouble(&self) -> bool {
        match self {
            Self::Write { .. } => true,
            Self::Create { source, .. } | Self::NotMade { source, .. } => matches!(
                source.kind(),
                ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::Interrupted
            ),
            _ => false,
        }
    }
}

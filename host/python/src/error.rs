//! Errors of the library as exceptions, with the library's own words.

use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::path::Path;

use pyo3::PyErr;
use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyValueError,
};

/// A value that cannot be used: `ValueError`.
pub(crate) fn bad(what: impl Display) -> PyErr {
    PyValueError::new_err(what.to_string())
}

/// What a reader said about a file: `OSError` if the file cannot be opened, `ValueError` if its content is at fault.
///
/// The library's readers do not tell the two apart by type, so the file is opened once more to see.
pub(crate) fn of_file(path: &Path, what: impl Display) -> PyErr {
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => PyIsADirectoryError::new_err(what.to_string()),
        Ok(_) => match std::fs::File::open(path) {
            Ok(_) => bad(what),
            Err(e) => of_io(&e, what),
        },
        Err(e) => of_io(&e, what),
    }
}

/// A failure of the operating system.
pub(crate) fn of_io(error: &io::Error, what: impl Display) -> PyErr {
    let what = what.to_string();
    match error.kind() {
        ErrorKind::NotFound => PyFileNotFoundError::new_err(what),
        ErrorKind::PermissionDenied => PyPermissionError::new_err(what),
        _ => PyOSError::new_err(what),
    }
}

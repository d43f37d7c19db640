//! Errors of the library as exceptions, with the library's own words.

use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::path::Path;

use asperity::message::brief;
use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyMemoryError, PyOSError, PyPermissionError,
    PyValueError,
};
use pyo3::{PyErr, PyResult};

/// A value that cannot be used: `ValueError`.
pub(crate) fn bad(what: impl Display) -> PyErr {
    PyValueError::new_err(said(what))
}

/// A message, short whatever it holds.
fn said(what: impl Display) -> String {
    brief(&what.to_string()).into_owned()
}

/// Room for so many values, all alike.
///
/// # Errors
/// `MemoryError`, which numpy's own functions raise there.
pub(crate) fn room<T: Clone>(count: usize, value: T) -> PyResult<Vec<T>> {
    let mut values = reserved(count)?;
    values.resize(count, value);
    Ok(values)
}

/// Room for so many values, still empty.
///
/// # Errors
/// As [`room`].
pub(crate) fn reserved<T>(count: usize) -> PyResult<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| {
        PyMemoryError::new_err(format!("no memory for {count} values; give fewer rows at a time"))
    })?;
    Ok(values)
}

/// What a reader said about a file: `OSError` if the file cannot be opened, `ValueError` if its content is at fault.
///
/// The library's readers do not tell the two apart by type, so the file is opened once more to see.
pub(crate) fn of_file(path: &Path, what: impl Display) -> PyErr {
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => PyIsADirectoryError::new_err(said(what)),
        Ok(_) => match std::fs::File::open(path) {
            Ok(_) => bad(what),
            Err(e) => of_io(&e, what),
        },
        Err(e) => of_io(&e, what),
    }
}

/// A failure of the operating system.
pub(crate) fn of_io(error: &io::Error, what: impl Display) -> PyErr {
    let what = said(what);
    match error.kind() {
        ErrorKind::NotFound => PyFileNotFoundError::new_err(what),
        ErrorKind::PermissionDenied => PyPermissionError::new_err(what),
        _ => PyOSError::new_err(what),
    }
}

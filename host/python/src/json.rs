//! Results of the library as Python's own dictionaries, and words of Python as the library's choices.

use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::error::bad;

/// A structure of the library as dictionaries and lists.
pub(crate) fn object<'py>(py: Python<'py>, of: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    parsed(py, &serde_json::to_string(of).map_err(bad)?)
}

/// A text of JSON as dictionaries and lists.
pub(crate) fn parsed<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// The choice that a word means.
///
/// # Errors
/// `ValueError` with the argument and the words there are.
pub(crate) fn word<T: DeserializeOwned>(argument: &str, word: Option<&str>) -> PyResult<Option<T>> {
    let read = |word: &str| serde_json::from_value(Value::from(word));
    word.map(read).transpose().map_err(|e| bad(format!("{argument}: {e}")))
}

//! Pickles: an object as a function of this module and its arguments, which give the same bits again.

use pyo3::prelude::*;

/// What `__reduce__` returns: the function `asperity._native.NAME`, and its arguments.
pub(crate) type Reduced<'py, A> = (Bound<'py, PyAny>, A);

/// See [`Reduced`].
pub(crate) fn by<'py, A>(py: Python<'py>, name: &str, arguments: A) -> PyResult<Reduced<'py, A>> {
    Ok((py.import("asperity._native")?.getattr(name)?, arguments))
}

//! Tables made by `asperity tabulate`.

use std::path::{Path, PathBuf};

use asperity::boundary::Boundary;
use asperity::embedded::{EmbeddedTable, Record, of_bytes, read, to_bytes};
use asperity::law_file::Kind;
use asperity::reconstruct::Subject;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{bad, of_file};
use crate::pairs::{Each, What, values};
use crate::pickled::{self, Reduced};
use crate::precision::Rounded;
use crate::rays::{Samples, samples};
use crate::subject::subject;

/// The BSDF of any method in arrays, as a device evaluates it.
///
/// `load` reads one; it never changes. Values are NaN in a lobe that the table was made without.
#[pyclass(frozen, module = "asperity")]
#[derive(Debug)]
pub(crate) struct Table {
    table: EmbeddedTable,
    record: Record,
}

impl Table {
    fn values<'py>(
        &self,
        what: What,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let rounded = Rounded(&self.table);
        values(wi, wo, &Each(&rounded, what), &Each(&self.table, what))
    }

    /// What light is sent on.
    pub(crate) fn subject(&self) -> Subject {
        let kind = Kind::Table(Box::new(self.record.clone()));
        let boundary = Boundary::Table(Box::new(self.table.clone()));
        let ior = kind.ior(&boundary);
        Subject { table: kind.table(), ..subject(boundary, &kind.method(), ior) }
    }
}

#[pymethods]
impl Table {
    /// Reads a table.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A `.bsdft` file of `asperity tabulate`.
    ///
    /// Returns
    /// -------
    /// Table
    ///
    /// Raises
    /// ------
    /// OSError
    ///     If the file cannot be opened.
    /// ValueError
    ///     If the content is no table, or is damaged.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let (table, record) = py.detach(|| read(&path)).map_err(|e| of_file(&path, e))?;
        Ok(Self { table, record })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py, (Bound<'py, PyBytes>,)>> {
        let bytes = to_bytes(&self.table, &self.record);
        pickled::by(py, "restore_table", (PyBytes::new(py, &bytes),))
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// str: Name of the method of its model.
    #[getter]
    fn method(&self) -> &str {
        &self.record.method
    }

    /// float: Index of the dielectric over that of the air.
    #[getter]
    fn ior(&self) -> Option<f32> {
        if self.opaque() { None } else { self.record.eta }
    }

    /// bool: Whether the body is opaque.
    #[getter]
    fn opaque(&self) -> bool {
        self.table.header().opaque
    }

    /// bool: Whether the file carries a checksum; those of format 1 do not.
    #[getter]
    fn has_checksum(&self) -> bool {
        self.record.crc32c.is_some()
    }

    /// str: Type of the stored values: "u8", "u16" or "f32".
    #[getter]
    fn storage(&self) -> &str {
        self.table.storage()
    }

    /// int: Size of the arrays on a device, bytes.
    #[getter]
    fn nbytes(&self) -> usize {
        self.table.bytes()
    }

    /// float or None: Distance from its model, eq. (18), %; None where it was not measured.
    #[getter]
    fn distance_percent(&self) -> Option<f64> {
        self.record.distance_percent
    }

    /// The BSDF f(wi, wo), without cosine.
    #[doc = include_str!("docs/values.txt")]
    fn eval<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Eval, wi, wo)
    }

    /// The angle-resolved scatter f(wi, wo) |cos theta_o|: scattered flux per solid angle, for unit flux in.
    #[doc = include_str!("docs/values.txt")]
    fn ars<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Ars, wi, wo)
    }

    /// The density of `sample` at `wo`, per solid angle of `wo`.
    #[doc = include_str!("docs/values.txt")]
    fn pdf<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Pdf, wi, wo)
    }

    /// Draws one scattered ray per row, coherent ones included.
    #[doc = include_str!("docs/sample.txt")]
    fn sample<'py>(&self, wi: &Bound<'py, PyAny>, u: &Bound<'py, PyAny>) -> PyResult<Samples<'py>> {
        samples(wi, u, &Rounded(&self.table), &self.table)
    }

    fn __repr__(&self) -> String {
        let (method, storage) = (self.method(), self.storage());
        let sum = if self.has_checksum() { "" } else { ", no checksum" };
        format!("<asperity.Table of {method}, {} bytes, {storage}{sum}>", self.nbytes())
    }
}

/// A table from the content of its file.
#[pyfunction]
pub(crate) fn restore_table(bytes: &[u8]) -> PyResult<Table> {
    let (table, record) = of_bytes(Path::new("pickled table"), bytes).map_err(bad)?;
    Ok(Table { table, record })
}

//! Tables made by `asperity tabulate`.

use std::path::{Path, PathBuf};

use asperity::embedded::{EmbeddedTable, Record, of_bytes, read, to_bytes};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::{bad, of_file};
use crate::pairs::{Each, What, values};
use crate::pickled::{self, Reduced};
use crate::precision::Rounded;
use crate::rays::{Samples, samples};

/// The BSDF of any method in arrays.
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
}

#[pymethods]
impl Table {
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

    #[getter]
    fn method(&self) -> &str {
        &self.record.method
    }

    #[getter]
    fn ior(&self) -> Option<f32> {
        if self.opaque() { None } else { self.record.eta }
    }

    #[getter]
    fn opaque(&self) -> bool {
        self.table.header().opaque
    }

    #[getter]
    fn has_checksum(&self) -> bool {
        self.record.crc32c.is_some()
    }

    #[getter]
    fn storage(&self) -> &str {
        self.table.storage()
    }

    #[getter]
    fn nbytes(&self) -> usize {
        self.table.bytes()
    }

    #[getter]
    fn distance_percent(&self) -> Option<f64> {
        self.record.distance_percent
    }

    fn eval<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Eval, wi, wo)
    }

    fn ars<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Ars, wi, wo)
    }

    fn pdf<'py>(
        &self,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.values(What::Pdf, wi, wo)
    }

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

//! Height maps from files.

use std::path::PathBuf;

use asperity::surface::{Preparation, Prepared, Purpose, Roughness};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::error::of_file;
use crate::json::{self, word};

/// A measured height map, made ready for light.
///
/// Read one with `read_map`. Rows are y, columns x; heights are um.
#[pyclass(frozen, module = "asperity")]
#[derive(Debug)]
pub(crate) struct HeightMap {
    pub(crate) prepared: Prepared,
    pub(crate) path: PathBuf,
}

#[pymethods]
impl HeightMap {
    /// ndarray: Heights, um, (ny, nx) of float64; rows are y, columns x.
    #[getter]
    fn heights_um<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let map = &self.prepared.map;
        let complete = map.complete().unwrap_or_default(); // a map for light is complete
        complete.to_vec().into_pyarray(py).reshape([map.ny(), map.nx()])
    }

    /// tuple of float: Distances of neighbouring points along x and y, um.
    #[getter]
    fn pitch_um(&self) -> (f64, f64) {
        (self.prepared.map.dx_um(), self.prepared.map.dy_um())
    }

    /// str: How the map goes on beyond its borders, "periodic" or "mirrored".
    #[getter]
    fn edges(&self) -> &'static str {
        self.prepared.edges.name()
    }

    /// str: The format of its file.
    #[getter]
    fn format(&self) -> &'static str {
        self.prepared.format
    }

    /// list of str: What has to be said about the file, in plain words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.prepared.warnings.clone()
    }

    /// Roughness figures after form removal, as `asperity stats --json` names them.
    ///
    /// Returns
    /// -------
    /// dict
    ///     Lengths in um; None where a figure needs what the map does not have.
    fn roughness<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::object(py, &Roughness::of(&self.prepared.map))
    }

    fn __repr__(&self) -> String {
        let map = &self.prepared.map;
        format!("<asperity.HeightMap of {} x {} points, {}>", map.nx(), map.ny(), self.edges())
    }
}

/// Reads a height map and makes it ready for light: crop, fill, form, edges, in this order.
///
/// Parameters
/// ----------
/// path : str or path
///     The file, of any format that `asperity stats` reads.
/// pixel_um, z_um : float, optional
///     Pixel size, and height of a step of one, um, for files that give none.
/// xy_unit, z_unit : str, optional
///     Units of lateral numbers and of heights, for files that do not say them: "um", "nm", ...
/// crop : str, optional
///     "X0:X1,Y0:Y1", the rectangle of points that is used, ends not included.
/// fill : {"plane", "nearest", "harmonic"}, optional
///     With what missing points are filled.
/// form : {"none", "mean", "plane", "quadratic"}, optional
///     What is subtracted; without it the mean plane, of a periodic map the mean.
/// edges : {"periodic", "mirrored"}, optional
///     How the map goes on; without it found out from the map.
/// channel : int, optional
///     Number from 0 of the map, of a file that holds several.
/// ignore_checksum, allow_steep : bool, default False
///     Take an x3p file with a wrong checksum; a map with an rms slope above 30.
///
/// Returns
/// -------
/// HeightMap
///     Complete, its form removed.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be opened.
/// ValueError
///     If it is no map, or not complete.
#[pyfunction]
#[pyo3(signature = (
    path, *, pixel_um=None, z_um=None, xy_unit=None, z_unit=None, crop=None, fill=None, form=None, edges=None,
    channel=None, ignore_checksum=false, allow_steep=false
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn read_map(
    py: Python<'_>,
    path: PathBuf,
    pixel_um: Option<f64>,
    z_um: Option<f64>,
    xy_unit: Option<&str>,
    z_unit: Option<&str>,
    crop: Option<&str>,
    fill: Option<&str>,
    form: Option<&str>,
    edges: Option<&str>,
    channel: Option<usize>,
    ignore_checksum: bool,
    allow_steep: bool,
) -> PyResult<HeightMap> {
    let preparation = Preparation {
        pixel_um,
        z_um,
        xy_unit: word("xy_unit", xy_unit)?,
        z_unit: word("z_unit", z_unit)?,
        channel,
        ignore_checksum,
        allow_steep,
        crop: word("crop", crop)?,
        fill: word("fill", fill)?,
        form: word("form", form)?,
        edges: word("edges", edges)?,
    };
    let prepared = py.detach(|| preparation.load(&path, Purpose::Light));
    let prepared = prepared.map_err(|what| of_file(&path, what))?;
    Ok(HeightMap { prepared, path })
}

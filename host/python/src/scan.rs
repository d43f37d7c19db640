//! Scans: readings over angles, and what is known about how they were made.

use std::path::PathBuf;

use asperity::measurement::{Measurement, Metadata, Reading, ScanError, ScanFault, csv};
use asperity::provenance::InputFile;
use numpy::{IntoPyArray, PyArray1};
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyIsADirectoryError, PyOSError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{bad, of_io};
use crate::pickled::{self, Reduced};

/// A scan of one sample, sorted by incidence and then by observation angle.
///
/// Parameters
/// ----------
/// sigma_deg, theta_deg : array_like of float, (N,)
///     Angles of incidence, 0 to below 90, and of observation, -90 to 90; degrees.
/// reading : array_like of float, (N,)
///     Flux over that of the beam without a sample; with `quantity` "bsdf" the BSDF in 1/sr.
/// meta : dict, optional
///     Header of a scan file: geometry, ior, rough_side, aperture_deg, quantity, ...
///
/// Raises
/// ------
/// ValueError
///     If the lengths differ, a number is outside its domain, or a value of `meta` cannot be read.
#[pyclass(frozen, module = "asperity")]
#[derive(Debug)]
pub(crate) struct Scan {
    pub(crate) measurement: Measurement,
    /// The file it was read from.
    pub(crate) input: Option<InputFile>,
}

impl Scan {
    fn array<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Reading) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.measurement.readings().iter().map(of).collect::<Vec<_>>().into_pyarray(py)
    }
}

#[pymethods]
impl Scan {
    #[new]
    #[pyo3(signature = (sigma_deg, theta_deg, reading, meta=None))]
    #[expect(
        clippy::needless_pass_by_value,
        reason = "arguments from Python are extracted by value"
    )]
    fn new(
        sigma_deg: Vec<f64>,
        theta_deg: Vec<f64>,
        reading: Vec<f64>,
        meta: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let (s, t, r) = (sigma_deg.len(), theta_deg.len(), reading.len());
        if s != t || s != r {
            let what = format!("sigma_deg, theta_deg and reading have the lengths {s}, {t}, {r}");
            return Err(bad(what + "; give as many of each"));
        }
        let mut known = Metadata::default();
        for (key, value) in meta.into_iter().flatten().filter(|(_, value)| !value.is_none()) {
            known.set(&key.str()?.to_cow()?, &value.str()?.to_cow()?).map_err(bad)?;
        }
        let readings = sigma_deg
            .iter()
            .zip(&theta_deg)
            .zip(&reading)
            .map(|((sigma, theta), value)| Reading::in_plane(*sigma, *theta, *value));
        let measurement = Measurement::new(known, readings.collect()).map_err(bad)?;
        Ok(Self { measurement, input: None })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py, OfScan>> {
        let all = |of: fn(&Reading) -> f64| self.measurement.readings().iter().map(of).collect();
        let readings = [all(|r| r.sigma_deg), all(|r| r.theta_deg), all(|r| r.value)];
        let input = self.input.clone().map(|input| (input.path, input.sha256));
        pickled::by(py, "restore_scan", (readings, self.measurement.meta.entries(), input))
    }

    /// It never changes, so it is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    /// numpy.ndarray of float64, (N,): Angles of incidence, degrees.
    #[getter]
    fn sigma_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |r| r.sigma_deg)
    }

    /// numpy.ndarray of float64, (N,): Angles of observation in the plane of incidence, degrees.
    #[getter]
    fn theta_deg<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |r| r.theta_deg)
    }

    /// numpy.ndarray of float64, (N,): Flux over that of the beam without a sample; or the BSDF, 1/sr, see `quantity`.
    #[getter]
    fn reading<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.array(py, |r| r.value)
    }

    /// str: What the readings are: "flux" or "bsdf".
    #[getter]
    fn quantity(&self) -> String {
        self.measurement.quantity().to_string()
    }

    /// dict: Header of the scan file: geometry, ior, rough_side, aperture_deg, wavelength_nm, ...
    #[getter]
    fn meta<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        const NUMBERS: [&str; 4] = ["ior", "aperture_deg", "wavelength_nm", "noise_floor_percent"];
        let dict = PyDict::new(py);
        for (key, value) in self.measurement.meta.entries() {
            match key.as_str() {
                "seed" => dict.set_item(key, self.measurement.meta.seed)?,
                k if NUMBERS.contains(&k) => dict.set_item(key, value.parse::<f64>()?)?,
                _ => dict.set_item(key, value)?,
            }
        }
        Ok(dict)
    }

    fn __len__(&self) -> usize {
        self.measurement.readings().len()
    }

    fn __repr__(&self) -> String {
        let incidences = self.measurement.incidences();
        format!("<asperity.Scan of {} readings at sigma {incidences:?} deg>", self.__len__())
    }
}

/// What a scan is made of: angles and readings, header, and the file it was read from with its digest.
type OfScan = ([Vec<f64>; 3], Vec<(String, String)>, Option<(String, String)>);

/// A scan from a pickle.
#[pyfunction]
#[pyo3(signature = (readings, header, input))]
pub(crate) fn restore_scan(
    readings: [Vec<f64>; 3],
    header: Vec<(String, String)>,
    input: Option<(String, String)>,
) -> PyResult<Scan> {
    let mut meta = Metadata::default();
    for (key, value) in &header {
        meta.set(key, value).map_err(bad)?;
    }
    let [sigma, theta, value] = readings;
    let rows = sigma.into_iter().zip(theta).zip(value);
    let reading = |((sigma_deg, theta_deg), value)| Reading::in_plane(sigma_deg, theta_deg, value);
    let measurement = Measurement::new(meta, rows.map(reading).collect()).map_err(bad)?;
    let input = input.map(|(path, sha256)| InputFile { path, sha256 });
    Ok(Scan { measurement, input })
}

/// Reads a scan file.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     CSV with `# key: value` lines, then `sigma_deg,theta_deg,reading`.
///
/// Returns
/// -------
/// Scan
///
/// Raises
/// ------
/// OSError
///     If the file cannot be opened.
/// ValueError
///     If the content is no scan; the message names the line.
#[pyfunction]
pub(crate) fn read_scan(py: Python<'_>, path: PathBuf) -> PyResult<Scan> {
    py.detach(|| {
        let bytes = csv::load(&path)?;
        let input = Some(InputFile::of_bytes(&path, &bytes));
        Ok(Scan { measurement: csv::parse(&bytes, &path)?, input })
    })
    .map_err(|e| exception(&e))
}

fn exception(error: &ScanError) -> PyErr {
    let what = error.to_string();
    match &*error.fault {
        ScanFault::NoFile => PyFileNotFoundError::new_err(what),
        ScanFault::Folder => PyIsADirectoryError::new_err(what),
        ScanFault::TooLarge => PyOSError::new_err(what),
        ScanFault::Io(e) => of_io(e, what),
        _ => bad(what),
    }
}

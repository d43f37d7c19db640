//! Scans and balances of models, tables and maps.

use std::path::PathBuf;

use asperity::boundary::Boundary;
use asperity::forward::Rays;
use asperity::kirchhoff::Speckle;
use asperity::measurement::AngleRange;
use asperity::reconstruct::{
    CheckRequest, Engine, Light, NoBalance, NoScan, NoSubject, ScanRequest, Subject,
};
use asperity_core::direction::Side;
use asperity_core::gonio::gp200;
use pyo3::prelude::*;

use crate::error::bad;
use crate::json;
use crate::light::{Lines, light, unlit};
use crate::map::HeightMap;
use crate::model::Model;
use crate::scan::Scan;
use crate::setup::unclear;
use crate::table::Table;
use crate::work::interruptible;

/// What light is sent on.
#[derive(FromPyObject)]
pub(crate) enum Of<'py> {
    #[pyo3(transparent, annotation = "Model")]
    Model(PyRef<'py, Model>),
    #[pyo3(transparent, annotation = "Table")]
    Table(PyRef<'py, Table>),
    #[pyo3(transparent, annotation = "HeightMap")]
    Map(PyRef<'py, HeightMap>),
}

/// How light is sent on a map.
struct OnMap {
    ior: Option<f64>,
    engine: Option<Engine>,
    light: Light,
}

impl OnMap {
    fn new(ior: Option<f64>, engine: Option<&str>, light: Light) -> PyResult<Self> {
        let engine = match engine {
            None => None,
            Some("ray") => Some(Engine::Ray),
            Some("wave") => Some(Engine::Wave),
            Some("hybrid") => Some(Engine::Hybrid),
            Some(other) => {
                return Err(bad(format!("engine {other:?}; give \"ray\", \"wave\" or \"hybrid\"")));
            }
        };
        Ok(Self { ior, engine, light })
    }

    fn subject(&self, py: Python<'_>, of: &Of<'_>, usual: &[Speckle]) -> PyResult<Subject> {
        let is_said = self.ior.is_some() || self.engine.is_some() || self.light.is_known();
        match of {
            Of::Map(map) => {
                let ior = self.ior.ok_or_else(|| bad("a map needs ior, the index under it"))?;
                let engine = self.engine.unwrap_or(Engine::Ray);
                if !engine.is_wave() && self.light.is_known() {
                    let what = "rays have no wavelength; leave it out, or give engine=\"wave\" or \"hybrid\"";
                    return Err(bad(what));
                }
                let (path, prepared, light) = (&map.path, &map.prepared, &self.light);
                let made =
                    py.detach(|| Subject::of_map(path, prepared, ior, (engine, light), usual));
                made.map_err(|e| match e {
                    NoSubject::Unlit(what) => unlit(&what),
                    e => bad(e),
                })
            }
            _ if is_said => {
                Err(bad("ior, engine and light are for a map; models and tables have their own"))
            }
            Of::Model(model) => Ok(model.subject()),
            Of::Table(table) => Ok(table.subject()),
        }
    }
}

/// Simulates a goniophotometer scan of a model, of a table, or of a height map, as `asperity scan` does.
///
/// Parameters
/// ----------
/// of : Model, Table or HeightMap
///     What is measured.
/// sigma_deg : sequence of float
///     Angles of incidence, degrees, 0 to below 90.
/// theta_deg : (float, float)
///     First and last angle of observation, degrees.
/// step_deg : float, default 0.1
///     Step of the angle of observation, degrees.
/// aperture_deg : float, default 0.6
///     Full angle of the detector's cone, degrees.
/// geometry : {"transmission", "reflection"}, optional
///     Side of the detector; without it transmission, of an opaque body reflection.
/// rough_side : {"source", "detector"}
///     Which way the rough face looks.
/// quantity : {"flux", "bsdf"}
///     What the readings are.
/// rays : int, optional
///     Monte Carlo with so many rays per incidence; without it quadrature, of a traced map 1.5e7 rays.
/// seed : int, default 1
///     Seed of the rays.
/// ior : float, optional
///     Index of the material under a map over that of the air; a map needs it.
/// engine : {"ray", "wave", "hybrid"}, optional
///     How light is sent on a map.
/// wavelength_nm : float, sequence of float, or sequence of (float, float), optional
///     Vacuum wavelengths of the light, alone or with weights, for waves.
/// speckle : {"averaged", "kept", "patch"}, optional
///     What becomes of the speckle of waves.
/// shadowing : {"auto", "on", "off"}, optional
///     Smith's shadowing and masking for waves.
///
/// Returns
/// -------
/// Scan
///     Its `meta` says the noise floor of rays, and what the instrument is.
///
/// Raises
/// ------
/// ValueError
///     With the argument that mends it.
#[pyfunction]
#[pyo3(signature = (
    of, *, sigma_deg=gp200::SIGMAS_DEG.to_vec(), theta_deg=(-90.0, 90.0), step_deg=gp200::STEP_DEG,
    aperture_deg=gp200::APERTURE_DEG,
    geometry=None, rough_side="source", quantity="flux", rays=None, seed=1, ior=None, engine=None,
    wavelength_nm=None, speckle=None, shadowing=None
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn scan(
    py: Python<'_>,
    of: Of<'_>,
    sigma_deg: Vec<f64>,
    theta_deg: (f64, f64),
    step_deg: f64,
    aperture_deg: f64,
    geometry: Option<&str>,
    rough_side: &str,
    quantity: &str,
    rays: Option<u64>,
    seed: u64,
    ior: Option<f64>,
    engine: Option<&str>,
    wavelength_nm: Option<Lines>,
    speckle: Option<&str>,
    shadowing: Option<&str>,
) -> PyResult<Scan> {
    // words are checked where those of a header are
    let mut said = asperity::measurement::Metadata::default();
    let words =
        [("geometry", geometry), ("rough_side", Some(rough_side)), ("quantity", Some(quantity))];
    for (key, value) in words {
        said.set(key, value.unwrap_or_default()).map_err(bad)?;
    }
    let usual = ScanRequest::default();
    let request = ScanRequest {
        sigma_deg,
        theta: AngleRange::new(theta_deg.0, theta_deg.1).map_err(bad)?,
        step_deg,
        aperture_deg,
        geometry: said.geometry,
        rough_side: said.rough_side.unwrap_or(usual.rough_side),
        quantity: said.quantity.unwrap_or(usual.quantity),
        rays,
        seed,
        ..usual
    };
    if rays == Some(0) {
        return Err(bad("rays is 0; give the number of rays per incidence, from 1"));
    }
    let light = light(wavelength_nm, speckle, shadowing, None)?;
    let on_map = OnMap::new(ior, engine, light)?;
    let subject = on_map.subject(py, &of, &[Speckle::Patch, Speckle::Kept])?;
    let done = interruptible(py, |watch| request.run(&subject, watch))?;
    let done = done.map_err(|e| match e {
        NoScan::Unclear(what) => unclear(&what),
        NoScan::OpaqueTransmits => bad(format!("{e}; use geometry=\"reflection\"")),
        NoScan::RaysNeedAperture | NoScan::CoherentNeedsAperture => {
            bad(format!("{e}; give aperture_deg above 0"))
        }
        NoScan::WavesAreNotTraced => bad(format!("{e}; leave rays out")),
        e => bad(e),
    })?;
    Ok(Scan { measurement: done.measurement, input: None })
}

/// Says where the flux goes: reflected, transmitted and lost fractions, and whether the law is reciprocal.
///
/// Parameters
/// ----------
/// of : Model, Table or HeightMap
///     What is balanced.
/// incidences_deg : sequence of float
///     Angles of incidence in the medium the light comes from, degrees, 0 to below 90.
/// side : {"air", "dielectric"}, optional
///     Only this side; both without it.
/// rays : int, default 1000000
///     Rays per incidence, for what is traced.
/// seed : int, default 1
///     Seed of the rays.
/// ior : float, optional
///     Index of the material under a map over that of the air; a map needs it.
/// engine : {"ray", "wave", "hybrid"}, optional
///     How light is sent on a map.
/// wavelength_nm : float, sequence of float, or sequence of (float, float), optional
///     Vacuum wavelengths of the light, alone or with weights, for waves.
/// speckle : {"averaged", "kept", "patch"}, optional
///     What becomes of the speckle of waves.
/// shadowing : {"auto", "on", "off"}, optional
///     Smith's shadowing and masking for waves.
///
/// Returns
/// -------
/// dict
///     The object that `asperity check --json` prints.
///
/// Raises
/// ------
/// ValueError
///     With the argument that mends it.
#[pyfunction]
#[pyo3(signature = (
    of, *, incidences_deg=vec![0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0], side=None, rays=1_000_000, seed=1, ior=None,
    engine=None, wavelength_nm=None, speckle=None, shadowing=None
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn check<'py>(
    py: Python<'py>,
    of: Of<'py>,
    incidences_deg: Vec<f64>,
    side: Option<&str>,
    rays: u64,
    seed: u64,
    ior: Option<f64>,
    engine: Option<&str>,
    wavelength_nm: Option<Lines>,
    speckle: Option<&str>,
    shadowing: Option<&str>,
) -> PyResult<Bound<'py, PyAny>> {
    let side = match side {
        None => None,
        Some("air") => Some(Side::Air),
        Some("dielectric") => Some(Side::Dielectric),
        Some(other) => return Err(bad(format!("side {other:?}; give \"air\" or \"dielectric\""))),
    };
    if rays == 0 {
        return Err(bad("rays is 0; give the number of rays per incidence, from 1"));
    }
    let request = CheckRequest { incidences_deg, side, rays: Rays { count: rays, seed } };
    let light = light(wavelength_nm, speckle, shadowing, None)?;
    let on_map = OnMap::new(ior, engine, light)?;
    let subject = on_map.subject(py, &of, &[Speckle::Averaged])?;
    let done = interruptible(py, |watch| request.run(&subject.boundary, watch))?;
    let done = done.map_err(|e| match e {
        NoBalance::NoInside => bad(format!("{e}; use side=\"air\"")),
        e => bad(e),
    })?;
    json::parsed(py, &done.json(&subject).map_err(bad)?)
}

/// A boundary of Python's own objects as a subject.
pub(crate) fn subject(boundary: Boundary, method: &str, ior: Option<f64>) -> Subject {
    Subject {
        boundary,
        method: method.to_owned(),
        ior,
        path: PathBuf::from(method),
        preparation: None,
        table: None,
        notice: None,
    }
}

//! Fitting a model to a scan.

use asperity::fit::MISFIT_PERCENT;
use asperity::method::Kind;
use asperity::reconstruct::{Found, Trials, usually_asked};
use pyo3::prelude::*;

use crate::error::bad;
use crate::light::Lines;
use crate::map::HeightMap;
use crate::model::Model;
use crate::scan::Scan;
use crate::setup::{Given, unusable, warn_of_failed};
use crate::work::interruptible;

/// Fits a model to a scan, with every law and every way to treat speckle that the method has; the best is kept.
///
/// An argument goes before the header of the scan. Other threads run meanwhile; Ctrl-C ends the fit.
///
/// Parameters
/// ----------
/// scan : the readings.
/// method : "ggx", "normals", "heights", and with `map` "measured-ray", "measured-wave" or "measured-hybrid".
/// ior, opaque : refractive index over that of air, or an opaque body.
/// law : "gauss" or "cauchy" alone; both are tried without it.
/// free : optional parameters to fit as well: ior, gain, theta0 (normals), n, h_max, z0 (heights).
/// cutoff : whether the filter of a map (cutoff_um) is fitted too.
/// geometry, rough_side, aperture_deg : the instrument, as in the header of a scan file.
/// map : the height map of the surface.
/// wavelength_nm : vacuum wavelength of the light, several, or pairs with weights, for waves.
/// speckle, shadowing : "averaged", "kept" or "patch"; "auto", "on" or "off".
/// objective : "rmsd" (eq. 18), "relative" or "log".
/// max_misfit_percent : largest error of a single incidence that counts as described.
/// rays, fit_rays, seed : rays per incidence for the final figures and while a traced method is fitted.
///
/// Raises
/// ------
/// ValueError with the argument that mends it. A law that fails beside a better one is a warning.
#[pyfunction]
#[pyo3(signature = (
    scan, method="ggx", *, ior=None, opaque=false, law=None, free=None, cutoff=true, geometry=None, rough_side=None,
    aperture_deg=None, map=None, wavelength_nm=None, speckle=None, shadowing=None, objective="rmsd",
    max_evaluations=4000, max_misfit_percent=MISFIT_PERCENT, rays=None, fit_rays=None, seed=1
))]
#[expect(clippy::too_many_arguments, clippy::fn_params_excessive_bools, reason = "named arguments of Python")]
pub(crate) fn fit(
    py: Python<'_>,
    scan: &Scan,
    method: &str,
    ior: Option<f64>,
    opaque: bool,
    law: Option<&str>,
    free: Option<Vec<String>>,
    cutoff: bool,
    geometry: Option<&str>,
    rough_side: Option<&str>,
    aperture_deg: Option<f64>,
    map: Option<&HeightMap>,
    wavelength_nm: Option<Lines>,
    speckle: Option<&str>,
    shadowing: Option<&str>,
    objective: &str,
    max_evaluations: u64,
    max_misfit_percent: f64,
    rays: Option<u64>,
    fit_rays: Option<u64>,
    seed: u64,
) -> PyResult<Model> {
    let given = Given {
        ior,
        opaque,
        geometry,
        rough_side,
        aperture_deg,
        speckle,
        shadowing,
        objective,
        max_evaluations,
        max_misfit_percent,
        rays,
        fit_rays,
        seed,
    };
    let kind = Kind::named(method).map_err(bad)?;
    if law.is_some() && !kind.has_profile {
        return Err(bad(format!("method {method} has no law; leave it out")));
    }
    if map.is_some() && !kind.needs_map {
        return Err(bad(format!("method {method} has no map; leave it out")));
    }
    if !kind.is_wave() && (speckle.is_some() || shadowing.is_some()) {
        let what = format!("method {method} sends no waves; leave speckle and shadowing out");
        return Err(bad(what));
    }
    let free = free.unwrap_or_default();
    let mut task = given.task(scan, map, wavelength_nm)?;
    task.options.fit_ior = free.iter().any(|f| f == "ior");
    task.options.fit_gain = free.iter().any(|f| f == "gain");
    if opaque && (task.options.fit_ior || task.options.fit_gain) {
        return Err(bad("an opaque body has a gain anyway and no index; leave them out of free"));
    }
    let asked = |parameter: &str| match parameter {
        "cutoff_um" => cutoff,
        other => usually_asked(other) || free.iter().any(|f| f == other),
    };
    let trials = task.trials(method, law, &asked).map_err(|why| unusable(&why))?;
    check_free(method, &free, &trials)?;
    let found = interruptible(py, |watch| task.fit(&trials, watch))?;
    let Found { entry, model, failed } = found.map_err(bad)?;
    warn_of_failed(py, &failed)?;
    let folder = map.and_then(|map| std::path::absolute(&map.path).ok());
    let folder = folder.and_then(|path| path.parent().map(std::path::PathBuf::from));
    Model::of(model, entry.fit.boundary, folder)
}

/// Refuses names that are no parameters of the method.
fn check_free(method: &str, free: &[String], trials: &Trials) -> PyResult<()> {
    for parameter in free {
        let mut known = trials.iter().flat_map(|m| m.parameters()).map(|p| p.name);
        if !["ior", "gain"].contains(&parameter.as_str()) && !known.any(|name| name == parameter) {
            return Err(bad(format!("method {method} has no parameter `{parameter}` to set free")));
        }
    }
    Ok(())
}

//! Fitting a model to a scan.

use asperity::fit::MISFIT_PERCENT;
use asperity::method::{Bounces, Kind};
use asperity::reconstruct::{Found, Trials, usually_asked};
use pyo3::prelude::*;

use crate::error::bad;
use crate::light::Lines;
use crate::map::HeightMap;
use crate::model::Model;
use crate::scan::Scan;
use crate::setup::{Given, unusable, warn_of_failed};
use crate::work::interruptible;

/// Fits a model to a scan, with every profile and every way to treat speckle that the method has; the best is kept.
///
/// An argument goes before the header of the scan; what neither says is an error. Other threads run meanwhile; Ctrl-C ends the fit.
///
/// Parameters
/// ----------
/// scan : Scan
///     The readings.
/// method : {"ggx", "normals", "heights", "measured-ray", "measured-wave", "measured-hybrid", "beckmann", "student",
///     "smith-normals", "slopes", "abg", "harvey", "k-correlation", "super-gauss", "mix"}
///     The method; the measured ones need `map`, and mix needs `of`.
/// ior : float, optional
///     Index of the plate over that of the air.
/// opaque : bool, default False
///     The body is opaque: `gain` and `lambert` take the place of the index.
/// profile : {"gauss", "cauchy"}, optional
///     Profile of the density; without it both are tried and the better one is kept.
/// free : sequence of str, optional
///     Optional parameters to fit too: ior, gain, theta0 (normals), n, h_max, z0 (heights), orientation (ggx, beckmann, student: two
///     widths with it).
/// of : sequence of str, optional
///     The one law or two that `mix` is made of.
/// bounces : {"one", "all", "walk"}, optional
///     Facets that light may meet, for microfacets.
/// body : {"sheet", "plate"}, optional
///     What abg, harvey, k-correlation and super-gauss describe; the sheet as measured without it.
/// cutoff : bool, default True
///     Whether the filter of a map (`cutoff_um`) is fitted too.
/// geometry : {"transmission", "reflection"}, optional
///     Where the detector was.
/// rough_side : {"source", "detector"}, optional
///     Where the rough face looked.
/// aperture_deg : float, optional
///     Full angle of the detector's cone, degrees.
/// map : HeightMap, optional
///     The height map of the surface.
/// wavelength_nm : float, sequence of float, or sequence of (float, float), optional
///     Vacuum wavelengths of the light, alone or with weights, for waves.
/// speckle : {"averaged", "kept", "patch"}, optional
///     What becomes of the speckle of waves.
/// shadowing : {"auto", "on", "off"}, optional
///     Smith's shadowing and masking for waves.
/// objective : {"rmsd", "relative", "log"}
///     What is made small.
/// max_evaluations : int, default 4000
///     Simulations at most.
/// max_misfit_percent : float, default 15
///     Largest error of a single incidence that counts as described, % of its largest reading.
/// rays, fit_rays : int, optional
///     Rays per incidence of the final figures, and of each simulation; methods that trace rays only.
/// seed : int, default 1
///     Seed of the rays.
///
/// Returns
/// -------
/// Model
///     With standard errors, `rmsd_percent`, `termination`, `verdict` and `warnings`.
///
/// Raises
/// ------
/// ValueError
///     With the argument that mends it. A profile that fails beside a better one is a warning.
#[pyfunction]
#[pyo3(signature = (
    scan, method="ggx", *, ior=None, opaque=false, profile=None, free=None, of=None, bounces=None, body=None,
    cutoff=true, geometry=None, rough_side=None, aperture_deg=None, map=None, wavelength_nm=None, speckle=None, shadowing=None, objective="rmsd",
    max_evaluations=4000, max_misfit_percent=MISFIT_PERCENT, rays=None, fit_rays=None, seed=1
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn fit(
    py: Python<'_>,
    scan: &Scan,
    method: &str,
    ior: Option<f64>,
    opaque: bool,
    profile: Option<&str>,
    free: Option<Vec<String>>,
    of: Option<Vec<String>>,
    bounces: Option<&str>,
    body: Option<&str>,
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
    if profile.is_some() && !kind.has_profile {
        return Err(bad(format!("method {method} has no profile; leave it out")));
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
    let of = of.unwrap_or_default();
    task.of = &of;
    task.bounces = bounces.map(Bounces::named).transpose().map_err(bad)?;
    task.in_plate = match body {
        None | Some("sheet") => false,
        Some("plate") => true,
        Some(other) => return Err(bad(format!("body `{other}` is unknown; write sheet or plate"))),
    };
    if body.is_some() && !kind.describes_sheet && !kind.of_parts {
        return Err(bad(format!("method {method} describes a rough face; leave body out")));
    }
    task.options.fit_ior = free.iter().any(|f| f == "ior");
    task.options.fit_gain = free.iter().any(|f| f == "gain");
    if opaque && (task.options.fit_ior || task.options.fit_gain) {
        return Err(bad("an opaque body has a gain anyway and no index; leave them out of free"));
    }
    let asked = |parameter: &str| match parameter {
        "cutoff_um" => cutoff,
        other => usually_asked(other) || free.iter().any(|f| f == other),
    };
    let trials = task.trials(method, profile, &asked).map_err(|why| unusable(&why))?;
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

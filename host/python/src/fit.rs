//! Fitting a model to a scan.

use asperity::fit::{
    self as library, Fit, FitError, FitOptions, FitRays, Fitted, MISFIT_PERCENT, Objective,
};
use asperity::method::{Choice, Kind, Method, Surface};
use asperity::model::{self, IncidenceRecord, Timing};
use asperity::provenance::Provenance;
use asperity::reconstruct::{Said, Situation, Unclear};
use pyo3::prelude::*;

use crate::error::bad;
use crate::model::Model;
use crate::scan::Scan;
use crate::work::interruptible;

/// Fits a method that needs no height map.
///
/// An argument goes before the header of the scan; what neither says is an error. Other threads run meanwhile; Ctrl-C ends the fit.
///
/// Parameters
/// ----------
/// scan : Scan
///     The readings.
/// method : {"ggx", "normals", "heights"}
///     The method.
/// ior : float, optional
///     Index of the plate over that of the air.
/// opaque : bool, default False
///     The body is opaque: `gain` and `lambert` take the place of the index.
/// law : {"gauss", "cauchy"}, optional
///     Profile of the density; without it both are tried and the better one is kept.
/// free : sequence of str, optional
///     Optional parameters to fit too: ior, gain, theta0 (normals), n, h_max, z0 (heights).
/// geometry : {"transmission", "reflection"}, optional
///     Where the detector was.
/// rough_side : {"source", "detector"}, optional
///     Where the rough face looked.
/// aperture_deg : float, optional
///     Full angle of the detector's cone, degrees.
/// objective : {"rmsd", "relative", "log"}
///     What is made small.
/// max_evaluations : int, default 4000
///     Simulations at most.
/// rays, fit_rays : int, optional
///     Rays of the final figures, and of each simulation; methods that trace rays only.
/// seed : int, default 1
///     Seed of the rays.
///
/// Returns
/// -------
/// Model
///     With standard errors, `rmsd_percent`, `termination` and `warnings`.
///
/// Raises
/// ------
/// ValueError
///     If something is not said or outside its domain, a method or a parameter is unknown, or no start of the fit is possible.
#[pyfunction]
#[pyo3(signature = (
    scan, method="ggx", *, ior=None, opaque=false, law=None, free=None, geometry=None, rough_side=None,
    aperture_deg=None, objective="rmsd", max_evaluations=4000, rays=None, fit_rays=None, seed=1
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn fit(
    py: Python<'_>,
    scan: &Scan,
    method: &str,
    ior: Option<f64>,
    opaque: bool,
    law: Option<&str>,
    free: Option<Vec<String>>,
    geometry: Option<&str>,
    rough_side: Option<&str>,
    aperture_deg: Option<f64>,
    objective: &str,
    max_evaluations: u64,
    rays: Option<u64>,
    fit_rays: Option<u64>,
    seed: u64,
) -> PyResult<Model> {
    let (measurement, free) = (&scan.measurement, free.unwrap_or_default());
    // the words of the header, checked where those of a file are
    let mut said = measurement.meta.clone();
    let number = aperture_deg.filter(|a| *a > 0.0).map(|a| a.to_string());
    let given = [("geometry", geometry), ("rough_side", rough_side)];
    for (key, value) in given.into_iter().chain([("aperture_deg", number.as_deref())]) {
        if let Some(value) = value {
            said.set(key, value).map_err(bad)?;
        }
    }
    let said = Said {
        geometry: said.geometry,
        ior,
        opaque,
        rough_side: said.rough_side,
        aperture_deg: aperture_deg.or(said.aperture_deg),
    };
    let Situation { surface, setup } = said.about(measurement).map_err(|e| unclear(&e))?;
    if rays == Some(0) || fit_rays == Some(0) || max_evaluations == 0 {
        return Err(bad("rays, fit_rays and max_evaluations must be positive"));
    }
    let options = FitOptions {
        surface,
        fit_ior: free.iter().any(|f| f == "ior"),
        fit_gain: free.iter().any(|f| f == "gain"),
        objective: objective.parse().map_err(|e: <Objective as std::str::FromStr>::Err| bad(e))?,
        max_evaluations,
        rays: FitRays { fit: fit_rays, last: rays, seed, ..FitRays::default() },
    };
    if opaque && (options.fit_ior || options.fit_gain) {
        return Err(bad("an opaque body has a gain anyway and no index; leave them out of free"));
    }
    let methods = methods(method, law, &free, surface, seed)?;
    if setup.aperture_deg <= 0.0 && methods.iter().any(|m| m.is_traced()) {
        return Err(bad("rays need a detector to fall into; give aperture_deg above 0"));
    }
    let (chosen, fit) = interruptible(py, |stop| {
        let mut best: Option<(&dyn Method, Fit)> = None;
        let (mut evaluations, mut seconds) = (0, 0.0);
        for method in &methods {
            let done = match library::fit(&**method, measurement, &setup, &options, stop, &|_| ()) {
                Err(_) if best.is_some() => continue,
                done => done?,
            };
            evaluations += done.evaluations;
            seconds += done.seconds;
            if best.as_ref().is_none_or(|(_, b)| done.objective.1 < b.objective.1) {
                best = Some((&**method, done));
            }
        }
        let (method, fit) = best.ok_or(FitError::NoStart)?;
        Ok::<_, FitError>((method, Fit { evaluations, seconds, ..fit }))
    })?
    .map_err(bad)?;
    let boundary = fit.boundary.clone();
    Model::of(record(chosen, &fit, scan, &options), boundary)
}

/// The methods to try: one with every law.
fn methods(
    name: &str,
    law: Option<&str>,
    free: &[String],
    surface: Surface,
    seed: u64,
) -> PyResult<Vec<Box<dyn Method>>> {
    let kind = Kind::named(name).map_err(bad)?;
    if kind.needs_map {
        let what =
            format!("method {name} needs a height map; fit it with `asperity fit --map FILE`");
        return Err(bad(what));
    }
    if law.is_some() && !kind.has_law {
        return Err(bad(format!("method {name} has no law; leave it out")));
    }
    let laws: &[Option<&str>] = match law {
        None if kind.has_law => &[Some("gauss"), Some("cauchy")],
        law => &[law],
    };
    let asked = |parameter: &str| free.iter().any(|f| f == parameter);
    let of_law = |law: Option<&str>| {
        Choice { law, asked: &asked, seed, ..Choice::new(name, surface) }.method()
    };
    let methods = laws.iter().copied().map(of_law).collect::<Result<Vec<_>, _>>().map_err(bad)?;
    for parameter in free {
        let mut known = methods.iter().flat_map(|m| m.parameters()).map(|p| p.name);
        if !["ior", "gain"].contains(&parameter.as_str()) && !known.any(|name| name == parameter) {
            return Err(bad(format!("method {name} has no parameter `{parameter}` to set free")));
        }
    }
    Ok(methods)
}

/// What is unclear about a scan, and the argument that says it.
fn unclear(what: &Unclear) -> PyErr {
    let argument = match what {
        Unclear::Geometry => "give geometry=\"transmission\" or \"reflection\"",
        Unclear::Index { .. } => "give ior, or opaque=True",
        Unclear::RoughSide => "give rough_side=\"source\" or \"detector\"",
        Unclear::Aperture => "give aperture_deg (full angle)",
        Unclear::OpaqueIndex => "leave ior or opaque out",
        Unclear::OpaqueTransmits => "give ior instead of opaque",
        Unclear::NoPlate => "give another ior",
        Unclear::UnusableAperture(_) => {
            "give the full angle of the detector's cone as aperture_deg, above 0 to 30 (0 only for BSDF values)"
        }
        Unclear::Domain(_) => return bad(what),
    };
    bad(format!("{what}; {argument}"))
}

/// The fit as a model.
fn record(method: &dyn Method, fit: &Fit, scan: &Scan, options: &FitOptions) -> model::Model {
    let surface = fit.ior.map_or(options.surface, |ior| Surface::Dielectric { ior });
    let values = fit.parameters.iter().map(|p| (p.name.to_owned(), p.record()));
    let mut made = model::Model::new(method, surface, values);
    let measurement = &scan.measurement;
    made.rmsd_percent = Some(fit.rmsd_percent);
    made.noise_floor_percent = fit.noise_floor_percent;
    made.simulation_noise_percent = fit.simulation_noise_percent;
    made.objective = Some(fit.objective.0.to_string());
    made.objective_value = Some(fit.objective.1);
    let incidences = fit.incidences.iter();
    made.incidences = incidences
        .map(|i| IncidenceRecord { sigma_deg: i.sigma_deg, rmsd_percent: i.rmsd_percent })
        .collect();
    made.evaluations = Some(fit.evaluations);
    made.timing = Some(Timing { seconds: fit.seconds });
    made.termination = Some(fit.termination.word().into());
    made.neglected_flux = Some(fit.neglected.flux);
    made.neglected_percent = Some(100.0 * fit.neglected.reading / measurement.largest_reading());
    made.validity = fit.refusal(MISFIT_PERCENT).into_iter().collect();
    made.validity.extend(fit.parameters.iter().filter_map(Fitted::warning));
    let seed = method.is_traced().then_some(options.rays.seed);
    let mut provenance = Provenance::of_this_program(seed);
    provenance.inputs = scan.input.iter().cloned().collect();
    provenance.references = method.references().iter().map(|&r| r.to_owned()).collect();
    made.provenance = Some(provenance);
    made
}

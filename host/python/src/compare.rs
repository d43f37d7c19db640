//! Every method on every sample.

use asperity::fit::MISFIT_PERCENT;
use asperity::measurement::noise;
use asperity::method::Kind;
use asperity::reconstruct::{
    Comparison, Grounds, SampleResult, SurfaceFigures, Task, Trials, usually_asked,
};
use pyo3::prelude::*;

use crate::error::bad;
use crate::json;
use crate::light::Lines;
use crate::map::HeightMap;
use crate::scan::Scan;
use crate::setup::{Given, unusable, warn_of_failed};
use crate::work::interruptible;

/// Fits every method to every scan, and sets the results side by side, as `asperity compare` does.
///
/// Parameters
/// ----------
/// scans : sequence of Scan
///     The readings, one scan per sample.
/// maps : sequence of HeightMap, optional
///     Height maps of the samples, in the order of the scans.
/// names : sequence of str, optional
///     Names of the samples; `sample1`, `sample2`, ... without them.
/// methods : sequence of str, optional
///     Methods; the five of the paper without them.
/// ior : float, optional
///     Index of the plates over that of the air.
/// opaque : bool, default False
///     The bodies are opaque.
/// geometry : {"transmission", "reflection"}, optional
///     Where the detector was.
/// rough_side : {"source", "detector"}, optional
///     Where the rough face looked.
/// aperture_deg : float, optional
///     Full angle of the detector's cone, degrees.
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
/// dict
///     The object that `asperity compare --json --no-timing` prints. A method that cannot be used is in it with the reason.
///
/// Raises
/// ------
/// ValueError
///     With the argument that mends it.
#[pyfunction]
#[pyo3(signature = (
    scans, *, maps=None, names=None, methods=None, ior=None, opaque=false, geometry=None, rough_side=None,
    aperture_deg=None, wavelength_nm=None, speckle=None, shadowing=None, objective="rmsd", max_evaluations=4000,
    max_misfit_percent=MISFIT_PERCENT, rays=None, fit_rays=None, seed=1
))]
#[expect(clippy::too_many_arguments, reason = "named arguments of Python")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scans: Vec<PyRef<'py, Scan>>,
    maps: Option<Vec<PyRef<'py, HeightMap>>>,
    names: Option<Vec<String>>,
    methods: Option<Vec<String>>,
    ior: Option<f64>,
    opaque: bool,
    geometry: Option<&str>,
    rough_side: Option<&str>,
    aperture_deg: Option<f64>,
    wavelength_nm: Option<Lines>,
    speckle: Option<&str>,
    shadowing: Option<&str>,
    objective: &str,
    max_evaluations: u64,
    max_misfit_percent: f64,
    rays: Option<u64>,
    fit_rays: Option<u64>,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
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
    let methods =
        methods.unwrap_or_else(|| Kind::of_paper().into_iter().map(String::from).collect());
    for name in &methods {
        Kind::named(name).map_err(bad)?;
    }
    let maps = maps.unwrap_or_default();
    for (what, count) in [("maps", maps.len()), ("names", names.as_ref().map_or(0, Vec::len))] {
        if count != 0 && count != scans.len() {
            return Err(bad(format!(
                "{} scans, {count} {what}; give one per scan, or none",
                scans.len()
            )));
        }
    }
    let names = names.unwrap_or_else(|| (1..=scans.len()).map(|k| format!("sample{k}")).collect());
    let mut samples = Vec::new();
    for (k, scan) in scans.iter().enumerate() {
        let task = given.task(scan, maps.get(k).map(|map| &**map), wavelength_nm.clone())?;
        samples.push(sample(py, &names[k], &task, &methods)?);
    }
    let comparison = Comparison {
        title: "Comparison of the methods".into(),
        what: String::new(),
        methods,
        samples,
        timing: false,
    };
    json::object(py, &comparison.json())
}

/// All methods on one sample.
fn sample(
    py: Python<'_>,
    name: &str,
    task: &Task<'_>,
    methods: &[String],
) -> PyResult<SampleResult> {
    let with = |method: &String| -> Result<Trials, String> {
        let trials = task.trials(method, None, &usually_asked);
        trials.map_err(|why| unusable(&why).value(py).to_string())
    };
    let plan: Vec<_> = methods.iter().map(|method| (method, with(method))).collect();
    let done = interruptible(py, |watch| {
        plan.iter().map(|(method, trials)| task.attempt(method, trials, watch)).collect::<Vec<_>>()
    })?;
    let mut attempts = Vec::new();
    for (attempt, failed) in done {
        warn_of_failed(py, &failed)?;
        attempts.push(attempt);
    }
    Ok(SampleResult {
        name: name.to_owned(),
        title: name.to_owned(),
        noise_floor_percent: SampleResult::floor_of(&attempts)
            .or_else(|| noise::before_fit(task.measurement)),
        attempts,
        surface: task.map.map(|map| SurfaceFigures::of(&map.map)),
        ranking: Vec::new(),
        grounds: Grounds::default(),
        rigorous: None,
        lit: Vec::new(),
    })
}

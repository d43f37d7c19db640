//! Fitting a method's parameters to a measurement.
//!
//! A fit has two stages. The first searches from several starts, with first hits only and thinned readings. The second starts from the best
//! of them, with all internal passes and every reading. Light of later hits is then linear in the parameters about the best values so
//! far, until these no longer change.
//!
//! The example of the crate fits a scan. A fit of a scan that a model made returns the parameters of that model:
//! ```
//! use asperity::fit::{FitOptions, fit};
//! use asperity::forward::{Angles, Effort, Rays, Sample, Setup, simulate};
//! use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
//! use asperity::method::{Body, Choice};
//! use asperity::watch::Watch;
//! use asperity_core::{gonio::Geometry, plate::RoughSide};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let body = Body::Dielectric { ior: 1.49 };
//! let method = Choice::new("ggx", body).method()?;
//! let setup = Setup {
//!     sample: Sample::Plate { eta: body.eta()?, rough_side: RoughSide::Source },
//!     geometry: Geometry::Transmission,
//!     aperture_deg: 0.6,
//!     slit_height_deg: None,
//!     quantity: Quantity::Flux,
//! };
//! let thetas: Vec<f64> = (-40..=40).map(f64::from).collect();
//! let (angles, no_rays) = (Angles::product(&[0.0], &thetas), Rays { count: 0, seed: 1 });
//! let boundary = method.boundary(&[0.2], body)?;
//! let made = simulate(&boundary, &setup, &angles, Effort::Full, no_rays, Watch::nobody());
//! let made = made.ok_or("stopped")?;
//! let reading = |(&theta_deg, &value)| Reading::in_plane(0.0, theta_deg, value);
//! let readings = thetas.iter().zip(&made.values).map(reading).collect();
//! let scan = Measurement::new(Metadata::default(), readings)?;
//! let found = fit(&*method, &scan, &setup, &FitOptions::new(body), Watch::nobody())?;
//! assert!((found.parameters[0].value - 0.2).abs() < 1e-3, "{:?}", found.parameters);
//! # Ok(())
//! # }
//! ```

mod objective;
mod nuisance;
mod problem;
mod variants;
mod cost;
mod starts;
mod search;
mod descent;
mod told;
mod secant;
mod simplex;
mod uncertainty;
mod profile;
mod simplest;
mod fitted;
mod later;
mod quick;
mod signature;
mod budget;
mod explained;
mod bootstrap;
mod errors;
mod verdict;
mod tail;
mod rays;
mod outcome;

pub use budget::Doubts;
pub use errors::Errors;
pub use fitted::{Fitted, Shown};
pub use nuisance::{MOST_GAINS, Nuisance, is_of_instrument};
pub use objective::Objective;
pub use outcome::{Fit, FitError, IncidenceError, Termination};
pub use profile::{Profile, Side};
pub use quick::{Quick, Rival, quick};
pub use rays::FitRays;
pub use signature::{NoSignature, Signature};
pub use tail::tail_score;
pub use verdict::MISFIT_PERCENT;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use std::time::Instant;

use asperity_core::metric::rmsd_percent;

use crate::forward::{Angles, Effort, Rays, Readings, Setup};
use crate::measurement::{Measurement, noise};
use crate::method::{Body, BuildError, Method};
use crate::watch::Watch;

use problem::Problem;
use search::{Search, Stopped};
use simplest::Found;

/// The options of a fit.
#[derive(Clone, Copy, Debug)]
pub struct FitOptions {
    /// The body; its index is the start if `fit_ior` is set.
    pub body: Body,
    /// Whether the refractive index is a parameter too.
    pub fit_ior: bool,
    /// Whether a calibration factor on all readings is a parameter too (an opaque body has one anyway).
    pub fit_gain: bool,
    /// The objective.
    pub objective: Objective,
    /// Largest number of evaluations of the forward model, over both stages.
    pub max_evaluations: u64,
    /// Rays of a method that traces them.
    pub rays: FitRays,
    /// What the instrument may be wrong about, fitted too.
    pub nuisance: Nuisance,
    /// What the instrument shows without a sample, in place of an ideal cone; not for methods that trace rays.
    pub signature: Option<Signature>,
    /// Doubts that are not fitted: they add to the errors.
    pub doubts: Doubts,
    /// Replicas of a bootstrap, 0 for none.
    pub replicas: u32,
}

impl FitOptions {
    /// The defaults: only the method's own parameters are free, and the fit minimises the error of eq. (18).
    pub fn new(body: Body) -> Self {
        Self {
            body,
            fit_ior: false,
            fit_gain: false,
            objective: Objective::default(),
            max_evaluations: 4000,
            rays: FitRays::default(),
            nuisance: Nuisance::default(),
            signature: None,
            doubts: Doubts::default(),
            replicas: 0,
        }
    }
}

/// Starts of all that are searched from.
const MOST_STARTS: usize = 2;

/// The cost of a traced draft after which no other start is searched from: 1 % in terms of eq. (18).
const NEAR_ENOUGH: f64 = 1.0;

/// Fits `method` to a measurement.
///
/// `watch` is told the number of evaluations so far. A fit that is stopped ends with the best values it has.
///
/// # Errors
/// [`FitError`]; a fit that does not converge is a result, not an error.
pub fn fit(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    watch: Watch<'_>,
) -> Result<Fit, FitError> {
    fit_beside(method, measurement, setup, options, None, watch)
}

/// How much a traced law's draft may be worse than that of another before it is given up.
const BEHIND: f64 = 1.2;

/// The same beside another law's fit, whose draft is given: a law that traces rays and is far behind is not fitted in full.
///
/// # Errors
/// As [`fit`]; [`FitError::Behind`].
pub fn fit_beside(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    other: Option<f64>,
    watch: Watch<'_>,
) -> Result<Fit, FitError> {
    let begun = Instant::now();
    let whole = Problem::new(method, measurement, setup, options, watch);
    let mut problem = whole.spread();
    if problem.parameters().len() > measurement.readings().len() {
        return Err(FitError::TooFewReadings {
            readings: measurement.readings().len(),
            parameters: problem.parameters().len(),
        });
    }
    problem.check_fixed()?;
    let all = problem.parameters().to_vec();
    let mut search = Search::new(watch, options.max_evaluations);

    // under noise the root of the mean square, else a share of the cost
    let (draft_tolerance, tolerance) = if problem.is_traced() {
        (1e-4, 1e-4)
    } else if method.wave().is_some() {
        // seconds an evaluation, and maps are not known better
        (2e-2, 1e-3)
    } else {
        (1e-3, 5e-6)
    };
    let draft = problem.thinned();
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for (cost, start) in search.best_starts(&draft, MOST_STARTS) {
        let Ok(end) = search.minimise(&draft, &start, Effort::Draft, draft_tolerance) else {
            // the best of the first evaluations is a result too
            found.push(search.best_pair().unwrap_or((cost, start)));
            break;
        };
        found.push(if end.cost < cost { (end.cost, end.values) } else { (cost, start) });
        if problem.is_traced() && end.cost < NEAR_ENOUGH {
            break;
        }
    }
    found.retain(|(cost, _)| *cost < search::IMPOSSIBLE);
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((drafted, mut start)) = found.into_iter().next() else {
        return Err(if search.interrupted() { FitError::Interrupted } else { FitError::NoStart });
    };
    if let Some(other) = other.filter(|other| problem.is_traced() && *other > 0.0)
        && drafted > BEHIND * other
    {
        return Err(FitError::Behind(drafted / other));
    }
    // A floor lost in the draft lies far down a flat logarithm: its least-squares value is where to look.
    problem.solve_linear(&mut start);
    if problem.is_traced() {
        choose_rays(&mut problem, &start, measurement, options)?;
    }
    let found = match later::minimise(&mut search, &problem, &start, tolerance) {
        Ok(end) if end.converged => (end.values, Termination::Converged),
        Ok(end) => (end.values, Termination::MaxEvaluations),
        Err(Stopped) => (search.best_or(start), Termination::Interrupted),
    };
    let found = Found { problem, values: found.0, termination: found.1 };
    let Found { problem, values, termination } =
        found.simplest(&mut search, options, (draft_tolerance, tolerance))?;

    let whole = whole.holding_as(&problem);
    let Some(readings) = last_readings(&whole, &values, measurement, options)? else {
        return Err(FitError::Interrupted);
    };
    let is_spread = problem.measured().len() < whole.measured().len();
    let at_fitted = if is_spread { problem.simulate(&values, Effort::Full)? } else { None };
    let at_fitted = at_fitted.as_ref().unwrap_or(&readings);
    let measured: Vec<f64> = measurement.readings().iter().map(|r| r.value).collect();
    let told = search.told(&problem, &problem.to_free(&values), 1e-9);
    let here = (&values[..], &at_fitted.values[..]);
    let (parameters, errors) = errors::found(&problem, &all, here, told.as_ref(), options);
    let (boundary, body) = problem.boundary(&values)?;
    let simulation_noise_percent = noise_percent(&readings, measurement);
    let of_rays = simulation_noise_percent.filter(|_| problem.is_traced());
    Ok(Fit {
        parameters,
        errors,
        boundary,
        ior: match body {
            Body::Dielectric { ior } => Some(ior),
            Body::Opaque | Body::Sheet { .. } => None,
        },
        rmsd_percent: rmsd_percent(&measured, &readings.values).unwrap_or(f64::NAN),
        objective: (options.objective, whole.cost_of(&readings.values)),
        incidences: verdict::by_incidence(&Angles::of(measurement), &measured, &readings.values),
        neglected: readings.neglected,
        simulation_noise_percent,
        noise_floor_percent: noise::of_fit(measurement, &readings.values, of_rays),
        readings: readings.values,
        evaluations: search.evaluations(),
        seconds: begun.elapsed().as_secs_f64(),
        termination,
        draft: drafted,
    })
}

/// The objective of a method with given values, without a fit; `None` if they make no boundary, or if stopped.
pub fn cost_at(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    values: &[f64],
    watch: Watch<'_>,
) -> Option<f64> {
    let problem = Problem::new(method, measurement, setup, options, watch);
    let readings = problem.simulate(values, Effort::Full).ok()??;
    Some(problem.cost_of(&readings.values))
}

/// Noise of simulated readings in terms of eq. (18), %.
fn noise_percent(readings: &Readings, measurement: &Measurement) -> Option<f64> {
    let errors = readings.std_errors.as_ref()?;
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64;
    Some(100.0 * mean_square.sqrt() / measurement.largest_reading())
}

/// The readings that judge the result; for a traced boundary from rays that the fit has not used.
///
/// `None` if stopped before there were any.
fn last_readings(
    problem: &Problem<'_>,
    values: &[f64],
    measurement: &Measurement,
    options: &FitOptions,
) -> Result<Option<Readings>, BuildError> {
    let watch = problem.watch();
    let seed = options.rays.seed.wrapping_add(1);
    let with = |count, watch: Watch<'_>| problem.simulate_last(values, Rays { count, seed }, watch);
    if !watch.is_stopped() && !problem.is_traced() {
        let readings = problem.simulate(values, Effort::Full)?;
        if readings.is_some() || !watch.is_stopped() {
            return Ok(readings);
        }
    }
    if watch.is_stopped() {
        // The best values so far deserve figures, however noisy.
        return soon(|late| with(options.rays.draft, Watch::silent(late)));
    }
    if let Some(count) = options.rays.last {
        return with(count, watch);
    }
    let count = problem.full_rays();
    let Some(first) = with(count, watch)? else {
        return soon(|late| with(options.rays.draft, Watch::silent(late)));
    };
    let noise = noise_percent(&first, measurement).unwrap_or(0.0);
    if noise <= FitRays::NOISE_PERCENT {
        return Ok(Some(first));
    }
    let count = FitRays::for_noise(count, noise, FitRays::NOISE_PERCENT).min(FitRays::MOST);
    Ok(with(count as u64, watch)?.or(Some(first)))
}

/// Wait for the figures of the best values after the user stopped the fit.
const PATIENCE: Duration = Duration::from_secs(1);

/// What `work` gives, if it is done before the flag that it looks at is set, soon.
fn soon<T>(work: impl FnOnce(&AtomicBool) -> T) -> T {
    let late = AtomicBool::new(false);
    let (done, ended) = std::sync::mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let late = &late;
        scope.spawn(move || {
            // an error means that the time is over: a sender that is gone is an error too, and harmless
            if ended.recv_timeout(PATIENCE).is_err() {
                late.store(true, Ordering::Relaxed);
            }
        });
        let found = work(late);
        done.send(()).ok();
        found
    })
}

/// Rays of the fit: as given, or as many as the noise of the draft at its best values calls for.
fn choose_rays(
    problem: &mut Problem<'_>,
    start: &[f64],
    measurement: &Measurement,
    options: &FitOptions,
) -> Result<(), BuildError> {
    let Some(given) = options.rays.fit else {
        let draft = options.rays.draft;
        let rays = Rays { count: draft, seed: options.rays.seed };
        let ready = problem.ready(start, Effort::Part)?;
        let Some(readings) = ready.readings(Effort::Part, rays, problem.watch()) else {
            return Ok(());
        };
        let readings = problem.levelled(readings);
        let noise = noise_percent(&readings, measurement).unwrap_or(0.0);
        let (least, most) = FitRays::IN_FIT;
        let count = FitRays::for_noise(draft, noise, FitRays::FIT_NOISE_PERCENT);
        problem.set_full_rays(count.clamp(least, most) as u64);
        return Ok(());
    };
    problem.set_full_rays(given);
    Ok(())
}

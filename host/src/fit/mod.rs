//! Fitting a method's parameters to a measurement.
//!
//! Two stages: from several starts with first hits only and thinned readings, then from the best of
//! them with all internal passes and every reading.

mod objective;
mod problem;
mod simplex;
mod uncertainty;
mod verdict;

pub use objective::Objective;
pub use verdict::{IncidenceError, MISFIT_PERCENT};

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use asperity_core::metric::rmsd_percent;

use crate::boundary::Boundary;
use crate::forward::{Effort, Neglected, Plan, Setup};
use crate::measurement::Measurement;
use crate::method::{BuildError, Method, Surface};

use problem::Problem;
use simplex::{Search, Stopped};

/// What to fit and how.
#[derive(Clone, Copy, Debug)]
pub struct FitOptions {
    /// The body; its index is the start if `fit_ior` is set.
    pub surface: Surface,
    /// Whether the refractive index is a parameter too.
    pub fit_ior: bool,
    /// Whether a calibration factor on all readings is a parameter too (an opaque body has one anyway).
    pub fit_gain: bool,
    /// What is minimised.
    pub objective: Objective,
    /// Evaluations of the forward model at most, over both stages.
    pub max_evaluations: u64,
}

/// Why a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Termination {
    /// The simplex shrank to its tolerance.
    Converged,
    /// The evaluations ran out.
    MaxEvaluations,
    /// The user stopped it; the best values so far are kept.
    Interrupted,
}

impl Termination {
    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::MaxEvaluations => "max_evaluations",
            Self::Interrupted => "interrupted",
        }
    }
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Standard error from the curvature at the optimum; `None` if the data do not determine it.
    pub std_error: Option<f64>,
    /// Whether it stopped at a bound of its range.
    pub at_bound: bool,
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The fitted parameters, in order.
    pub parameters: Vec<Fitted>,
    /// The boundary they make.
    pub boundary: Boundary,
    /// Refractive index; `None` for an opaque body.
    pub ior: Option<f64>,
    /// Simulated readings, in the order of the measurement's.
    pub readings: Vec<f64>,
    /// Error of eq. (18), %.
    pub rmsd_percent: f64,
    /// What was minimised, and its value.
    pub objective: (Objective, f64),
    /// Error of eq. (18) for each incidence alone.
    pub incidences: Vec<IncidenceError>,
    /// Light left out of the internal passes.
    pub neglected: Neglected,
    /// Evaluations of the forward model.
    pub evaluations: u64,
    /// Wall time.
    pub seconds: f64,
    /// Why it ended.
    pub termination: Termination,
}

/// Why there is no fit.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The fixed values make no boundary.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Fewer readings than parameters.
    #[error("{readings} readings cannot determine {parameters} parameters; measure more angles")]
    TooFewReadings {
        /// Readings given.
        readings: usize,
        /// Parameters asked for.
        parameters: usize,
    },
    /// No start gave a finite error.
    #[error(
        "no start gave a finite error: the readings do not look like scatter of such a \
             sample; check their unit and the column"
    )]
    NoStart,
    /// Stopped before the first result.
    #[error("interrupted before the first result")]
    Interrupted,
}

/// Starts of all that are searched from.
const MOST_STARTS: usize = 2;

/// Fits `method` to a measurement.
///
/// `progress(done)` is called with the number of evaluations so far. When `stop` is set the fit ends
/// with the best values it has.
///
/// # Errors
/// [`FitError`]; a fit that does not converge is a result, not an error.
pub fn fit(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    stop: &AtomicBool,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Fit, FitError> {
    let begun = Instant::now();
    let problem = Problem::new(method, measurement, setup, options);
    if problem.parameters().len() > measurement.readings().len() {
        return Err(FitError::TooFewReadings {
            readings: measurement.readings().len(),
            parameters: problem.parameters().len(),
        });
    }
    problem.check_fixed()?;
    let mut search = Search::new(stop, progress, options.max_evaluations);

    let draft = problem.thinned();
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for (cost, start) in search.best_starts(&draft, MOST_STARTS) {
        match search.minimise(&draft, &start, Effort::Draft, 1e-3) {
            Ok(end) if end.cost < cost => found.push((end.cost, end.values)),
            Ok(_) => found.push((cost, start)),
            Err(Stopped) => break,
        }
    }
    found.retain(|(cost, _)| *cost < simplex::IMPOSSIBLE);
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, mut start)) = found.into_iter().next() else {
        return Err(if search.interrupted() { FitError::Interrupted } else { FitError::NoStart });
    };
    // A floor lost in the draft lies far down a flat logarithm: its least-squares value is where to look.
    problem.solve_linear(&mut start);
    let (values, termination) = match search.minimise(&problem, &start, Effort::Full, 5e-6) {
        Ok(end) if end.converged => (end.values, Termination::Converged),
        Ok(end) => (end.values, Termination::MaxEvaluations),
        Err(Stopped) => (search.best_or(start), Termination::Interrupted),
    };

    let readings = problem.simulate(&values, Effort::Full)?;
    let measured: Vec<f64> = measurement.readings().iter().map(|r| r.value).collect();
    let std_errors = uncertainty::std_errors(&problem, &values, &readings.values);
    let parameters = problem
        .parameters()
        .iter()
        .zip(&values)
        .zip(std_errors)
        .map(|((p, &value), std_error)| Fitted {
            name: p.name,
            unit: p.unit,
            value,
            std_error,
            at_bound: p.is_at_bound(value),
        })
        .collect();
    let (boundary, surface) = problem.boundary(&values)?;
    Ok(Fit {
        parameters,
        boundary,
        ior: match surface {
            Surface::Dielectric { ior } => Some(ior),
            Surface::Opaque => None,
        },
        rmsd_percent: rmsd_percent(&measured, &readings.values).unwrap_or(f64::NAN),
        objective: (options.objective, problem.cost_of(&readings.values)),
        incidences: verdict::by_incidence(&Plan::of(measurement), &measured, &readings.values),
        neglected: readings.neglected,
        readings: readings.values,
        evaluations: search.evaluations(),
        seconds: begun.elapsed().as_secs_f64(),
        termination,
    })
}

//! A fit for orientation: thinned readings, one search. What would an assumption change?

use asperity_core::metric::rmsd_percent;

use super::FitOptions;
use super::later;
use super::problem::Problem;
use super::search::Search;
use crate::forward::{Effort, Setup};
use crate::measurement::Measurement;
use crate::method::Method;
use crate::watch::Watch;

/// The end of a quick fit.
#[derive(Clone, Debug)]
pub struct Quick {
    /// Error of eq. (18) over the readings it used, %.
    pub rmsd_percent: f64,
    /// The least cost, in the units of the objective.
    pub cost: f64,
    /// Names and values of the fitted parameters.
    pub values: Vec<(&'static str, f64)>,
    /// Evaluations of the forward model.
    pub evaluations: u64,
}

impl Quick {
    /// The value of a parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(n, _)| *n == name).map(|(_, value)| *value)
    }
}

/// Evaluations at most.
const MOST: u64 = 800;
/// The tolerance of its end, as a share of the error.
const TOLERANCE: f64 = 5e-3;

/// A quick fit; `None` if there is none, if stopped, or if it would hardly come below a cost of `most`.
pub fn quick(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    most: f64,
    watch: Watch<'_>,
) -> Option<Quick> {
    let problem = Problem::new(method, measurement, setup, options, watch.quiet()).thinned();
    problem.check_fixed().ok()?;
    let mut search = Search::new(watch.quiet(), MOST);
    let (_, start) = search.best_starts(&problem, 1).into_iter().next()?;
    let end = search.minimise(&problem, &start, Effort::Draft, TOLERANCE).ok()?;
    let end = if problem.has_later_hits() {
        later::estimate(&mut search, &problem, &end.values, TOLERANCE, most).ok()??
    } else {
        end
    };
    let readings = problem.simulate(&end.values, Effort::Full).ok()??;
    let names = problem.parameters().iter().map(|p| p.name);
    Some(Quick {
        rmsd_percent: rmsd_percent(problem.measured(), &readings.values)?,
        cost: end.cost,
        values: names.zip(end.values.iter().copied()).collect(),
        evaluations: search.evaluations(),
    })
}

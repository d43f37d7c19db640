//! A fit for orientation: thinned readings, one search. What would an assumption change?

use asperity_core::metric::rmsd_percent;

use super::FitOptions;
use super::later::{self, Beside};
use super::problem::Problem;
use super::search::{Search, Stopped};
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

    /// The values of the parameters of a problem; those it does not have are as in `others`.
    fn values_of(&self, problem: &Problem<'_>, others: &[f64]) -> Vec<f64> {
        let parameters = problem.parameters().iter().zip(others);
        parameters.map(|(p, other)| self.value(p.name).unwrap_or(*other)).collect()
    }
}

/// A fit that another one is held against.
#[derive(Clone, Copy, Debug)]
pub struct Rival<'a> {
    /// The fit.
    pub fit: &'a Quick,
    /// The share of its cost that the other one has to come down to soon.
    pub soon: f64,
    /// The share of its cost below which the other one is of use.
    pub useful: f64,
}

impl Rival<'_> {
    fn limit(&self) -> Beside {
        Beside { cost: self.soon * self.fit.cost, useful: self.useful * self.fit.cost }
    }
}

/// Evaluations at most.
const MOST: u64 = 800;
/// The tolerance of its end, as a share of the error.
const TOLERANCE: f64 = 5e-3;
/// How many times the cost of the fit beside that of first hits alone may be.
const HOPELESS: f64 = 10.0;
/// Costs alike up to this factor are those of one law.
const SAME: f64 = 1.01;

/// A quick fit; `None` if there is none, or if stopped.
///
/// One of another instrument or other readings than those of a fit `beside` it ends early, with nothing, where it would hardly
/// be of use.
pub fn quick(
    method: &dyn Method,
    measurement: &Measurement,
    setup: &Setup,
    options: &FitOptions,
    beside: Option<Rival<'_>>,
    watch: Watch<'_>,
) -> Option<Quick> {
    let problem = Problem::new(method, measurement, setup, options, watch.quiet()).thinned();
    problem.check_fixed().ok()?;
    let mut search = Search::new(watch.quiet(), MOST);
    let (_, start) = search.best_starts(&problem, 1).into_iter().next()?;
    let end = search.minimise(&problem, &start, Effort::Draft, TOLERANCE).ok()?;
    if beside.is_some_and(|rival| end.cost > HOPELESS * rival.fit.cost) {
        return None;
    }
    let values = if problem.has_later_hits() {
        in_full(&mut search, &problem, (&start, &end.values), beside).ok()??
    } else {
        end.values
    };
    let readings = problem.simulate(&values, Effort::Full).ok()??;
    let names = problem.parameters().iter().map(|p| p.name);
    Some(Quick {
        rmsd_percent: rmsd_percent(problem.measured(), &readings.values)?,
        cost: problem.cost_at(&values, &readings.values),
        values: names.zip(values).collect(),
        evaluations: search.evaluations(),
    })
}

/// With all light, from where a search of first hits has ended. That may be far from the minimum: if it leads nowhere, from the
/// fit beside, where further numbers leave that as it is.
fn in_full(
    search: &mut Search<'_>,
    problem: &Problem<'_>,
    (start, end): (&[f64], &[f64]),
    beside: Option<Rival<'_>>,
) -> Result<Option<Vec<f64>>, Stopped> {
    let limit = beside.as_ref().map(Rival::limit);
    let found = later::estimate(search, problem, end, TOLERANCE, limit)?;
    let Some(Rival { fit, .. }) = beside.filter(|_| found.is_none()) else { return Ok(found) };
    let values = fit.values_of(problem, start);
    let cost = problem.cost(&values, Effort::Full).ok().flatten();
    if cost.is_none_or(|cost| cost > SAME * fit.cost) {
        return Ok(None);
    }
    later::estimate(search, problem, &values, TOLERANCE, limit)
}

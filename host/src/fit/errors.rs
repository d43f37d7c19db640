//! The errors of fitted values: of noise, of doubts about the instrument, by a bootstrap, and how they hang together.

use super::FitOptions;
use super::bootstrap;
use super::budget::{Effect, contributions, moves};
use super::explained::unexplained;
use super::fitted::Fitted;
use super::problem::Problem;
use super::told::Told;
use super::uncertainty::{Curvature, curvature};
use super::{later, profile};
use crate::method::Parameter;
use crate::model::{Contribution, Correlation};

/// The errors of the free parameters together.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    /// Names of the free parameters, in order.
    pub names: Vec<&'static str>,
    /// Covariance of their errors, in their units; empty if the data do not determine it.
    pub covariance: Vec<Vec<f64>>,
    /// How the readings tie the values to each other whatever their noise, correlations as of noise that is alike in all.
    pub ties: Vec<Vec<f64>>,
    /// The budget of uncertainty: noise, then each doubt; empty without doubts.
    pub budget: Vec<Contribution>,
    /// Draws by the bootstrap, one row a replica.
    pub samples: Vec<Vec<f64>>,
}

impl Errors {
    /// Correlations of the errors, each pair once.
    pub fn correlations(&self) -> Vec<Correlation> {
        let own = |k: usize| self.covariance[k][k].sqrt();
        let of = |(i, row): (usize, &Vec<f64>)| {
            row.iter().enumerate().map(|(j, c)| (c / (own(i) * own(j))).clamp(-1.0, 1.0)).collect()
        };
        let matrix: Vec<Vec<f64>> = self.covariance.iter().enumerate().map(of).collect();
        Correlation::all(&self.names, &matrix)
    }

    /// The ties of the values, each pair once.
    pub fn tied(&self) -> Vec<Correlation> {
        Correlation::all(&self.names, &self.ties)
    }

    /// The standard error of a smooth function of the free parameters with these derivatives.
    pub fn propagated(&self, derivatives: &[f64]) -> Option<f64> {
        if self.covariance.len() != derivatives.len() || derivatives.is_empty() {
            return None;
        }
        let row = |row: &Vec<f64>| row.iter().zip(derivatives).map(|(c, d)| c * d).sum::<f64>();
        let variance: f64 = self.covariance.iter().zip(derivatives).map(|(r, d)| d * row(r)).sum();
        Some(variance.max(0.0).sqrt())
    }
}

/// The parameters with their errors, `all` of them in their order, those that are held too.
pub(super) fn found(
    problem: &Problem<'_>,
    all: &[Parameter],
    (values, simulated): (&[f64], &[f64]),
    told: Option<&Told>,
    options: &FitOptions,
) -> (Vec<Fitted>, Errors) {
    // the errors ask for small changes about the fitted values
    let later = later::about(problem, values, || ()).ok().flatten();
    let near = later.map(|later| problem.with_later(later));
    let near = near.as_ref().unwrap_or(problem);
    let effects = options.doubts.effects(near, values, simulated);
    let curvature = curvature(near, values, simulated, told).map(|found| {
        if effects.is_empty() {
            return found;
        }
        let left = unexplained(near, &found, simulated, &effects);
        found.with_noise(near, left)
    });
    let profiles = curvature.as_ref().map(|c| profile::profiles(near, values, c, told));
    let of_noise: Vec<Option<f64>> = (0..values.len())
        .map(|k| {
            let profile = profiles.as_ref().and_then(|p| p[k]);
            profile.map(|p| p.stated()).or_else(|| curvature.as_ref()?.std_errors[k])
        })
        .collect();
    let errors = curvature
        .as_ref()
        .map(|c| together(near, (values, simulated), (c, &effects), &of_noise, options));
    let errors = errors.unwrap_or_default();
    let combined = |k: usize| match errors.covariance.get(k) {
        Some(row) => of_noise[k].map(|_| row[k].sqrt()),
        None => of_noise[k],
    };
    let mut free = 0..values.len();
    let one = |(p, held): (&Parameter, &Option<f64>)| {
        let k = if held.is_none() { free.next() } else { None };
        let value = held.or(k.map(|k| values[k])).unwrap_or(f64::NAN);
        Fitted {
            name: p.name,
            unit: p.unit,
            value,
            std_error: k.and_then(combined),
            profile: k.and_then(|k| profiles.as_ref()?[k]),
            at_bound: held.is_none() && p.is_at_bound(value),
            is_none: held.is_some(),
        }
    };
    (all.iter().zip(problem.held()).map(one).collect(), errors)
}

/// The covariance of all errors, the budget and the draws.
fn together(
    problem: &Problem<'_>,
    (values, simulated): (&[f64], &[f64]),
    (curvature, effects): (&Curvature, &[Effect]),
    of_noise: &[Option<f64>],
    options: &FitOptions,
) -> Errors {
    let names: Vec<&'static str> = problem.parameters().iter().map(|p| p.name).collect();
    let correlations = curvature.correlations(problem);
    let noise = |k: usize| of_noise[k].unwrap_or(0.0);
    let mut covariance: Vec<Vec<f64>> = (0..names.len())
        .map(|i| (0..names.len()).map(|j| correlations[i][j] * noise(i) * noise(j)).collect())
        .collect();
    let of_part = |part: &Vec<f64>| moves(problem, curvature, simulated, part);
    let moved: Vec<Vec<Vec<f64>>> =
        effects.iter().map(|effect| effect.parts.iter().map(of_part).collect()).collect();
    for part in moved.iter().flatten() {
        for (row, a) in covariance.iter_mut().zip(part) {
            row.iter_mut().zip(part).for_each(|(c, b)| *c += a * b);
        }
    }
    let mut budget = Vec::new();
    if !effects.is_empty() {
        let of_noise = names.iter().enumerate().map(|(k, name)| ((*name).to_owned(), noise(k)));
        budget.push(Contribution {
            source: "noise".into(),
            std_dev: 0.0,
            unit: String::new(),
            effects: of_noise.collect(),
        });
        budget.extend(contributions(problem, effects, &moved));
    }
    let mut samples = Vec::new();
    if options.replicas > 0 && !problem.is_traced() {
        let draws = (options.replicas, options.rays.seed);
        samples = bootstrap::replicas(problem, values, simulated, effects, draws, problem.watch());
    }
    Errors { names, covariance, ties: curvature.ties(), budget, samples }
}

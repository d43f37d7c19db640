//! Gauss and Newton's steps, damped \[Levenberg 1944; Marquardt 1963\], for methods of many parameters.
//!
//! A simplex loses its way beyond some six dimensions. Readings without noise have derivatives by differences, and each step asks for one
//! more simulation than there are parameters. Directions that the readings do not determine are damped: there the
//! parameters stay near their start.

use super::problem::Problem;
use super::search::{End, IMPOSSIBLE, Search, Stopped};
use crate::forward::Effort;
use crate::linear::inverse;

/// Parameters from which on it takes the place of the simplex.
pub(super) const MANY: usize = 5;
/// Steps at most.
const STEPS: usize = 60;
/// Dampings tried for a step.
const TRIES: usize = 9;
/// First damping, its growth after a failure, and its share after a success.
const DAMPING: f64 = 1e-3;
const GROWTH: f64 = 5.0;
const RELIEF: f64 = 0.2;
/// Damping of directions without any slope, as a share of the mean.
const FLOOR: f64 = 1e-6;
/// The step of a derivative, and the longest step of a parameter, in the parameter's own.
const DIFFERENCE: f64 = 0.01;
const LONGEST: f64 = 4.0;

/// A place in free coordinates, its residuals and their mean square.
struct Place {
    free: Vec<f64>,
    residuals: Vec<f64>,
    square: f64,
}

/// Minimises from a start until a step lessens the cost by less than `tolerance` of it.
pub(super) fn minimise(
    search: &Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    effort: Effort,
    tolerance: f64,
) -> Result<End, Stopped> {
    let descent = Descent { search, problem, effort };
    let Some(mut here) = descent.place(problem.to_free(start))? else {
        return Ok(End { values: start.to_vec(), cost: IMPOSSIBLE, converged: false });
    };
    let (mut damping, mut converged) = (DAMPING, false);
    for _ in 0..STEPS {
        let Some(columns) = descent.columns(&here)? else { break };
        let mut better = None;
        for _ in 0..TRIES {
            let Some(there) = descent.step(&here, &columns, damping)? else { break };
            if there.square < here.square {
                damping *= RELIEF;
                better = Some(there);
                break;
            }
            damping *= GROWTH;
        }
        if search.is_spent() {
            break;
        }
        let Some(there) = better else {
            converged = true;
            break;
        };
        // costs are roots of squares
        converged = there.square > here.square * (1.0 - 2.0 * tolerance);
        here = there;
        if converged {
            break;
        }
    }
    let cost = problem.objective().of_mean_square(here.square);
    Ok(End { values: problem.to_bounded(&here.free), cost, converged })
}

struct Descent<'a, 'b> {
    search: &'a Search<'b>,
    problem: &'a Problem<'b>,
    effort: Effort,
}

impl Descent<'_, '_> {
    /// `None` if there is no simulation of it.
    fn place(&self, free: Vec<f64>) -> Result<Option<Place>, Stopped> {
        if self.search.interrupted() {
            return Err(Stopped);
        }
        self.search.count();
        let values = self.problem.to_bounded(&free);
        let Ok(Some(readings)) = self.problem.simulate(&values, self.effort) else {
            return if self.search.interrupted() { Err(Stopped) } else { Ok(None) };
        };
        let residuals = self.problem.residuals(&values, &readings.values);
        let count = self.problem.measured().len();
        let square = residuals.iter().map(|r| r * r).sum::<f64>() / count as f64;
        if !square.is_finite() {
            return Ok(None);
        }
        self.search.note(self.problem.objective().of_mean_square(square), &values);
        Ok(Some(Place { free, residuals, square }))
    }

    /// The derivatives of the residuals, by parameter; `None` if the evaluations ran out.
    fn columns(&self, here: &Place) -> Result<Option<Vec<Vec<f64>>>, Stopped> {
        let values = self.problem.to_bounded(&here.free);
        let mut columns = Vec::with_capacity(values.len());
        for (k, (parameter, value)) in self.problem.parameters().iter().zip(values).enumerate() {
            if self.search.is_spent() {
                return Ok(None);
            }
            let step = DIFFERENCE * parameter.step(value);
            let mut free = here.free.clone();
            free[k] += step;
            let slope = |there: Place| {
                let pairs = there.residuals.iter().zip(&here.residuals);
                pairs.map(|(there, here)| (there - here) / step).collect()
            };
            columns.push(self.place(free)?.map_or_else(|| vec![0.0; here.residuals.len()], slope));
        }
        Ok(Some(columns))
    }

    /// Where a damped step leads; `None` if nowhere.
    fn step(
        &self,
        here: &Place,
        columns: &[Vec<f64>],
        damping: f64,
    ) -> Result<Option<Place>, Stopped> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut curvature: Vec<Vec<f64>> =
            columns.iter().map(|a| columns.iter().map(|b| dot(a, b)).collect()).collect();
        let mean = (0..columns.len()).map(|k| curvature[k][k]).sum::<f64>() / columns.len() as f64;
        for (k, row) in curvature.iter_mut().enumerate() {
            row[k] += damping * (row[k] + FLOOR * mean);
        }
        let Some(inverse) = inverse(&curvature) else { return Ok(None) };
        let fall: Vec<f64> = columns.iter().map(|column| -dot(column, &here.residuals)).collect();
        let values = self.problem.to_bounded(&here.free);
        let parameters = self.problem.parameters().iter().zip(values);
        let moved =
            here.free.iter().zip(&inverse).zip(parameters).map(|((at, row), (p, value))| {
                let most = LONGEST * p.step(value).abs();
                at + dot(row, &fall).clamp(-most, most)
            });
        self.place(moved.collect())
    }
}

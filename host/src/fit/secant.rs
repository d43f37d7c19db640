//! Steps of Gauss and Newton for readings that rays make, with derivatives from the steps themselves \[Broyden 1965\].
//!
//! A simulation takes a tenth of a second to minutes, and its readings have noise, though nearly the same one at neighbouring values.
//! So derivatives are differences over wide steps, taken once in a draft; each further simulation corrects them along its own
//! step, and the fit in full begins with those of the draft. A search of one or two parameters ends after five to ten simulations,
//! where a simplex takes forty.

use super::problem::Problem;
use super::search::{End, IMPOSSIBLE, Search, Stopped};
use super::told::{Slopes, Told};
use crate::forward::Effort;
use crate::linear::inverse;

/// Steps at most, and how many in a row may fail.
const STEPS: usize = 24;
const FAILURES: usize = 3;
/// First damping, its growth after a failure, and its share after a success.
const DAMPING: f64 = 1e-3;
const GROWTH: f64 = 10.0;
const RELIEF: f64 = 0.1;
/// Damping of directions without any slope, as a share of the mean.
const FLOOR: f64 = 1e-6;
/// The step of a first derivative, and the longest step, in the parameter's own.
const DIFFERENCE: f64 = 0.25;
const LONGEST: f64 = 3.0;
/// A step that is short, in the parameter's own: in a draft, and in full; and a move after which derivatives are not taken anew.
const SHORT: (f64, f64) = (0.1, 0.001);
const RENEWED: f64 = 0.1;
/// How often they are taken anew.
const RENEWALS: usize = 3;
/// The step that noise is as large as, in the parameter's own.
const BLUR: f64 = 0.1;
/// The mean square of residuals that noise leaves where a model is right.
const LEAST: f64 = 1e-6;
/// The share of the mean square that is little in a draft.
const DRAFT_TOLERANCE: f64 = 1e-2;

/// A place in free coordinates, its residuals by either half of the rays, and their mean product.
struct Place {
    free: Vec<f64>,
    halves: [Vec<f64>; 2],
    square: f64,
    /// Variance of the sum of the products by the noise of rays.
    variance: f64,
}

/// Minimises from a start until a step is short, or promises to lessen the root of the mean square by less than `tolerance`.
///
/// A draft ends there. A search in full then takes the derivatives anew, from both sides, and goes on until the step that they
/// show is short too: where a model misses the readings derivatives from afar are zero elsewhere than the cost's.
pub(super) fn minimise(
    search: &Search<'_>,
    problem: &Problem<'_>,
    start: &[f64],
    effort: Effort,
    tolerance: f64,
) -> Result<End, Stopped> {
    let walk = Walk { search, problem, effort, tolerance };
    let impossible = || End { values: start.to_vec(), cost: IMPOSSIBLE, converged: false };
    let Some(mut here) = walk.place(problem.to_free(start))? else { return Ok(impossible()) };
    let mut slopes = match search.slopes(problem, &here.free) {
        Some(slopes) => slopes,
        None => walk.differences(&mut here)?,
    };
    let mut converged = walk.steps(&mut here, &mut slopes)?;
    if effort != Effort::Draft {
        for _ in 0..RENEWALS {
            let before = here.free.clone();
            slopes = walk.central_differences(&here)?;
            converged = walk.steps(&mut here, &mut slopes.clone())?;
            if walk.is_short(&before, &here.free, RENEWED) || search.is_spent() {
                break;
            }
        }
    }
    let values = problem.to_bounded(&here.free);
    let cost = 1e4 * here.square;
    let Place { free, halves, variance, .. } = here;
    search.tell(problem, Told { free, halves, slopes, variance });
    Ok(End { values, cost, converged })
}

/// Derivatives corrected so that they tell what a step did; of a short step noise tells as much. `units` are the parameters' own
/// steps.
fn correct(slopes: &mut Slopes, here: &Place, there: &Place, units: &[f64]) {
    let by: Vec<f64> = there.free.iter().zip(&here.free).map(|(to, from)| to - from).collect();
    let square: f64 = by.iter().zip(units).map(|(b, unit)| b * b + (BLUR * unit).powi(2)).sum();
    for ((columns, to), from) in slopes.iter_mut().zip(&there.halves).zip(&here.halves) {
        for (i, (to, from)) in to.iter().zip(from).enumerate() {
            let told: f64 = columns.iter().zip(&by).map(|(column, b)| column[i] * b).sum();
            let missed = (to - from - told) / square;
            columns.iter_mut().zip(&by).for_each(|(column, b)| column[i] += missed * b);
        }
    }
}

/// A step, and by how much it should lessen the mean square.
struct Step {
    by: Vec<f64>,
    promised: f64,
}

struct Walk<'a, 'b> {
    search: &'a Search<'b>,
    problem: &'a Problem<'b>,
    effort: Effort,
    tolerance: f64,
}

impl Walk<'_, '_> {
    /// Steps until one is short, promises little, or fails too often; whether it ends so, and not because evaluations ran out.
    fn steps(&self, here: &mut Place, slopes: &mut Slopes) -> Result<bool, Stopped> {
        let (mut damping, mut failures) = (DAMPING, 0);
        let short = if self.effort == Effort::Draft { SHORT.0 } else { SHORT.1 };
        for _ in 0..STEPS {
            if self.search.is_spent() {
                return Ok(false);
            }
            let Some(step) = self.step(here, slopes, damping) else { return Ok(true) };
            let moved: Vec<f64> = here.free.iter().zip(&step.by).map(|(at, by)| at + by).collect();
            let is_short = self.is_short(&here.free, &moved, short);
            let little = if self.effort == Effort::Draft {
                DRAFT_TOLERANCE * here.square
            } else {
                // what lessens the root of the mean square by the tolerance
                2.0 * self.tolerance * here.square.max(LEAST).sqrt()
            };
            if is_short || step.promised < little {
                return Ok(true);
            }
            let there = self.place(moved)?;
            if let Some(there) = &there {
                correct(slopes, here, there, &self.units(&here.free));
            }
            if let Some(there) = there.filter(|there| there.square < here.square) {
                (*here, damping, failures) = (there, damping * RELIEF, 0);
            } else {
                (damping, failures) = (damping * GROWTH, failures + 1);
            }
            if failures == FAILURES {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The parameters' own steps.
    fn units(&self, free: &[f64]) -> Vec<f64> {
        let values = self.problem.to_bounded(free);
        let parameters = self.problem.parameters().iter().zip(values);
        parameters.map(|(p, value)| p.step(value).abs()).collect()
    }

    /// Whether two places are nearer than a share of each parameter's own step.
    fn is_short(&self, from: &[f64], to: &[f64], share: f64) -> bool {
        let units = self.units(from);
        from.iter().zip(to).zip(units).all(|((from, to), unit)| (to - from).abs() < share * unit)
    }

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
        let halves = self.problem.residual_halves(&values, &readings);
        let square = self.problem.mean_product(&halves);
        let variance = self.problem.product_variance(&values, &halves, &readings);
        if !square.is_finite() {
            return Ok(None);
        }
        self.search.note(1e4 * square, &values);
        Ok(Some(Place { free, halves, square, variance }))
    }

    /// Derivatives of the residuals by differences, by parameter; goes on to the best place it sees.
    fn differences(&self, here: &mut Place) -> Result<Slopes, Stopped> {
        let values = self.problem.to_bounded(&here.free);
        let mut slopes = [Vec::new(), Vec::new()];
        for (k, (parameter, value)) in self.problem.parameters().iter().zip(values).enumerate() {
            let step = DIFFERENCE * parameter.step(value);
            let mut free = here.free.clone();
            free[k] += step;
            let there = self.place(free)?;
            for (half, columns) in slopes.iter_mut().enumerate() {
                let from = &here.halves[half];
                columns.push(there.as_ref().map_or_else(
                    || vec![0.0; from.len()],
                    |there| {
                        let pairs = there.halves[half].iter().zip(from);
                        pairs.map(|(there, here)| (there - here) / step).collect()
                    },
                ));
            }
            if let Some(there) = there.filter(|there| there.square < here.square) {
                *here = there;
            }
        }
        Ok(slopes)
    }

    /// The same from both sides of a place.
    fn central_differences(&self, here: &Place) -> Result<Slopes, Stopped> {
        let mut slopes = [Vec::new(), Vec::new()];
        for (k, unit) in self.units(&here.free).into_iter().enumerate() {
            let side = |sign: f64| {
                let mut free = here.free.clone();
                free[k] += sign * DIFFERENCE * unit;
                self.place(free)
            };
            let (above, below) = (side(1.0)?, side(-1.0)?);
            let (above, below) = (above.as_ref().unwrap_or(here), below.as_ref().unwrap_or(here));
            let width = above.free[k] - below.free[k];
            for (half, columns) in slopes.iter_mut().enumerate() {
                let pairs = above.halves[half].iter().zip(&below.halves[half]);
                columns.push(match width {
                    w if w > 0.0 => pairs.map(|(a, b)| (a - b) / w).collect(),
                    _ => vec![0.0; here.halves[half].len()],
                });
            }
        }
        Ok(slopes)
    }

    /// A damped step; `None` if there is none. Products are of one half of the rays with the other: noise adds nothing to them.
    fn step(&self, here: &Place, [a, b]: &Slopes, damping: f64) -> Option<Step> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let both = |i: usize, j: usize| 0.5 * (dot(&a[i], &b[j]) + dot(&b[i], &a[j]));
        let count = a.len();
        let curvature: Vec<Vec<f64>> =
            (0..count).map(|i| (0..count).map(|j| both(i, j)).collect()).collect();
        let mean = (0..count).map(|k| curvature[k][k].abs()).sum::<f64>() / count as f64;
        let mut damped = curvature.clone();
        for (k, row) in damped.iter_mut().enumerate() {
            row[k] += damping * (row[k].abs() + FLOOR * mean);
        }
        let inverse = inverse(&damped)?;
        let [ra, rb] = &here.halves;
        let fall: Vec<f64> = (0..count).map(|k| -0.5 * (dot(&a[k], rb) + dot(&b[k], ra))).collect();
        let most = self.units(&here.free).into_iter().map(|unit| LONGEST * unit);
        let by: Vec<f64> = inverse
            .iter()
            .zip(most)
            .map(|(row, most)| dot(row, &fall).clamp(-most, most))
            .collect();
        let bent: f64 = curvature.iter().zip(&by).map(|(row, b)| b * dot(row, &by)).sum();
        let promised = (2.0 * dot(&fall, &by) - bent) / self.problem.measured().len() as f64;
        by.iter().all(|b| b.is_finite()).then_some(Step { by, promised })
    }
}

//! Parameters that may stand for nothing: no filter, no floor, no offset.
//!
//! A fit with one more parameter always ends no higher, for it describes some of the noise too. So each parameter that has a
//! value for `nothing` is held there, the others are fitted again, and that fit is kept unless its sum of squares is higher
//! by more than noise makes it: nine times the variance that one parameter takes up (three standard errors), and three
//! standard errors of the rays, which both sums are computed with anew.

use super::Termination;
use super::later;
use super::problem::Problem;
use super::search::{Search, Stopped};
use super::uncertainty::correlated_sum;
use crate::forward::{Effort, Rays};
use crate::method::BuildError;

/// Rise of chi squared beyond which a parameter is kept: three standard errors.
const MOST_RISE: f64 = 9.0;
/// Standard errors of the rays that count as noise.
const RAY_ERRORS: f64 = 3.0;
/// Factor by which rays are added, and how often.
const MORE_RAYS: u64 = 4;
const MORE_TIMES: u32 = 2;

/// A fit so far.
pub(super) struct Found<'a> {
    pub(super) problem: Problem<'a>,
    pub(super) values: Vec<f64>,
    pub(super) termination: Termination,
}

impl Found<'_> {
    /// The same, or a fit with fewer parameters that describes the measurement as well. `tolerances` are those of the
    /// draft and of the fit.
    ///
    /// # Errors
    /// If the values make no boundary.
    pub(super) fn simplest(
        mut self,
        search: &mut Search<'_>,
        options: &super::FitOptions,
        tolerances: (f64, f64),
    ) -> Result<Self, BuildError> {
        let mut k = 0;
        while let Some(p) = self.problem.parameters().get(k) {
            let Some(none) = p.none.filter(|_| self.termination == Termination::Converged) else {
                k += 1;
                continue;
            };
            let held = self.problem.holding(k, none);
            match fitted(&held, &self.values, k, search, tolerances) {
                Ok(Some(values)) => {
                    match needed(&held, &values, &self.problem, &self.values, options)? {
                        Some(true) => k += 1,
                        Some(false) => {
                            self.problem = held;
                            self.values = values;
                        }
                        None => self.termination = Termination::Interrupted,
                    }
                }
                Ok(None) => {
                    self.termination = Termination::MaxEvaluations;
                }
                Err(Stopped) => {
                    self.termination = Termination::Interrupted;
                }
            }
        }
        Ok(self)
    }
}

/// The values of the others where one parameter is held; `None` if they did not converge.
fn fitted(
    held: &Problem<'_>,
    values: &[f64],
    k: usize,
    search: &mut Search<'_>,
    (draft_tolerance, tolerance): (f64, f64),
) -> Result<Option<Vec<f64>>, Stopped> {
    let mut others = values.to_vec();
    others.remove(k);
    let draft = held.thinned();
    // where rays are traced the value that a single other parameter had is start enough
    let is_enough = draft.is_traced() && others.len() == 1;
    let starts = if is_enough { Vec::new() } else { draft.starts() };
    let starts = starts.into_iter().chain([others]).collect();
    let Some((_, start)) = search.best_of(&draft, starts, 1).into_iter().next() else {
        return if search.interrupted() { Err(Stopped) } else { Ok(None) };
    };
    let end = search.minimise(&draft, &start, Effort::Draft, draft_tolerance)?;
    let mut start = end.values;
    held.solve_linear(&mut start);
    let end = later::minimise(search, held, &start, tolerance)?;
    Ok(end.converged.then_some(end.values))
}

/// Whether the parameter that is held is needed: whether the sum of squares without it, at `a`, is significantly higher than
/// with it, at `b`. Where only the noise of the rays leaves this open, more rays are sent. `None` if the user stopped it.
fn needed(
    held: &Problem<'_>,
    a: &[f64],
    full: &Problem<'_>,
    b: &[f64],
    options: &super::FitOptions,
) -> Result<Option<bool>, BuildError> {
    let mut count = full.full_rays();
    let most = count.saturating_mul(MORE_RAYS.pow(MORE_TIMES));
    loop {
        let rays = Rays { count, seed: options.rays.seed.wrapping_add(1) };
        let (Some(without), Some(with)) = (Sum::of(held, a, rays)?, Sum::of(full, b, rays)?) else {
            return Ok(None);
        };
        let rise = without.squares - with.squares;
        let enough = MOST_RISE * with.unit;
        let ray_error = (without.ray_variance + with.ray_variance).sqrt();
        let open = rise > enough.max(ray_error) && rise < enough + RAY_ERRORS * ray_error;
        if !open || count >= most {
            return Ok(Some(rise > enough + RAY_ERRORS * ray_error));
        }
        count *= MORE_RAYS;
    }
}

/// A sum of squares and its noise.
struct Sum {
    /// Sum of the squares of the residuals, without what the noise of rays adds.
    squares: f64,
    /// What a parameter without meaning takes away of it: the variance of a residual, times the number of neighbours
    /// that share it.
    unit: f64,
    /// Variance of the sum by the noise of its rays.
    ray_variance: f64,
}

impl Sum {
    fn of(problem: &Problem<'_>, values: &[f64], rays: Rays) -> Result<Option<Self>, BuildError> {
        let unit =
            |residuals: &[f64]| correlated_sum(problem, residuals) / residuals.len().max(1) as f64;
        if !problem.is_traced() {
            let found = problem.simulate(values, Effort::Full)?;
            return Ok(found.map(|readings| {
                let residuals = problem.residuals(values, &readings.values);
                let squares = residuals.iter().map(|r| r * r).sum();
                Self { squares, unit: unit(&residuals), ray_variance: 0.0 }
            }));
        }
        // rays that the fit has not seen: it chose its values to suit the noise of its own
        let Some(readings) = problem.simulate_last(values, rays, problem.watch())? else {
            return Ok(None);
        };
        let halves = problem.residual_halves(values, &readings);
        let ray_variance = problem.product_variance(values, &halves, &readings);
        let [a, b] = halves;
        let squares = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        let mean: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect();
        Ok(Some(Self { squares, unit: unit(&mean), ray_variance }))
    }
}

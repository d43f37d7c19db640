//! Nelder-Mead through argmin, guarded: no infinite or undefined cost ever reaches it.

use argmin::core::{CostFunction, Error, Executor, State, TerminationReason, TerminationStatus};
use argmin::solver::neldermead::NelderMead;

use super::descent;
use super::problem::Problem;
use super::search::{End, IMPOSSIBLE, Search, Stopped};
use super::secant;
use crate::forward::Effort;

impl Search<'_> {
    /// The starts with the lowest costs, at most `most`, the best first.
    pub(super) fn best_starts(&self, problem: &Problem<'_>, most: usize) -> Vec<(f64, Vec<f64>)> {
        self.best_of(problem, problem.starts(), most)
    }

    /// Of given starts those with the lowest costs.
    pub(super) fn best_of(
        &self,
        problem: &Problem<'_>,
        starts: Vec<Vec<f64>>,
        most: usize,
    ) -> Vec<(f64, Vec<f64>)> {
        let target = Target { search: self, problem, effort: Effort::Draft };
        let mut rated: Vec<(f64, Vec<f64>)> = starts
            .into_iter()
            .map_while(|start| {
                let cost = target.cost(&problem.to_free(&start)).ok()?;
                (!self.interrupted()).then_some((cost, start))
            })
            .collect();
        rated.sort_by(|a, b| a.0.total_cmp(&b.0));
        rated.into_iter().take(most).collect()
    }

    /// Minimises from a start until the costs of the simplex differ by less than `tolerance` times the
    /// best of them.
    pub(super) fn minimise(
        &mut self,
        problem: &Problem<'_>,
        start: &[f64],
        effort: Effort,
        tolerance: f64,
    ) -> Result<End, Stopped> {
        if problem.is_traced() {
            self.begin();
            return secant::minimise(self, problem, start, effort, tolerance);
        }
        if problem.parameters().len() < descent::MANY {
            return self.simplex(problem, start, effort, tolerance);
        }
        if !problem.is_limited() {
            self.begin();
            return descent::minimise(self, problem, start, effort, tolerance);
        }
        // steps end where there is no more light: simplices, until a fresh one leads no further
        let mut end = self.simplex(problem, start, effort, tolerance)?;
        for _ in 0..AGAIN {
            let next = self.simplex(problem, &end.values, effort, tolerance)?;
            let is_done = next.cost > end.cost * (1.0 - FURTHER);
            end = if next.cost < end.cost { next } else { end };
            if is_done || !end.converged {
                break;
            }
        }
        Ok(end)
    }

    /// One simplex.
    fn simplex(
        &mut self,
        problem: &Problem<'_>,
        start: &[f64],
        effort: Effort,
        tolerance: f64,
    ) -> Result<End, Stopped> {
        self.begin();
        let parameters = problem.parameters();
        let first = problem.to_free(start);
        let mut simplex = vec![first.clone()];
        for (k, p) in parameters.iter().enumerate() {
            let mut corner = first.clone();
            // A start found by a draft is good: a smaller simplex keeps it.
            let size = if effort == Effort::Full { 0.06 } else { 1.0 };
            corner[k] += size * p.step(start[k]);
            simplex.push(corner);
        }
        let target = Target { search: self, problem, effort };
        let spent = || End { values: start.to_vec(), cost: IMPOSSIBLE, converged: false };
        let at_start = target.cost(&first).map_err(|_| Stopped)?;
        let iterations = self.budget.saturating_sub(self.evaluations());
        let Ok(solver) =
            NelderMead::new(simplex).with_sd_tolerance(tolerance * at_start.max(LEAST))
        else {
            return Ok(End { values: start.to_vec(), cost: at_start, converged: false });
        };
        let run =
            Executor::new(target, solver).configure(|state| state.max_iters(iterations)).run();
        let Ok(run) = run else { return Err(Stopped) };
        if self.interrupted() {
            return Err(Stopped);
        }
        if self.is_spent() {
            // The evaluations ran out: the best of them is the answer.
            let best = self.best.lock().ok().and_then(|best| best.clone());
            return Ok(best.map_or_else(spent, |(cost, values)| End {
                values,
                cost,
                converged: false,
            }));
        }
        let converged = matches!(
            run.state().get_termination_status(),
            TerminationStatus::Terminated(
                TerminationReason::SolverConverged | TerminationReason::TargetCostReached
            )
        );
        let (cost, free) = match run.state().get_best_param() {
            Some(free) => (run.state().get_best_cost(), free.clone()),
            None => (at_start, first),
        };
        Ok(End { values: problem.to_bounded(&free), cost, converged })
    }
}

/// A cost that counts as more than nothing.
const LEAST: f64 = 1e-6;
/// Fresh simplices at most, and the share by which one must lessen the cost to be followed by another.
const AGAIN: usize = 6;
const FURTHER: f64 = 1e-3;

/// The cost as argmin wants it.
struct Target<'a, 'b> {
    search: &'a Search<'b>,
    problem: &'a Problem<'a>,
    effort: Effort,
}

impl CostFunction for Target<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, free: &Vec<f64>) -> Result<f64, Error> {
        // Never an error: argmin unwraps the costs of a shrinking simplex.
        if self.search.interrupted() || self.search.is_spent() {
            return Ok(IMPOSSIBLE);
        }
        self.search.count();
        let values = self.problem.to_bounded(free);
        let cost = self.problem.cost(&values, self.effort).ok().flatten().unwrap_or(IMPOSSIBLE);
        // NaN compares false: it becomes impossible too.
        let cost = if cost < IMPOSSIBLE { cost } else { IMPOSSIBLE };
        self.search.note(cost, &values);
        Ok(cost)
    }
}

//! The cost of a fit: residuals of the readings and of what is known beforehand.

use super::problem::Problem;
use crate::forward::{Effort, Rays};
use crate::method::{BuildError, Parameter};

impl Problem<'_> {
    /// The cost of a fit; `None` if the user stopped it.
    ///
    /// Traced readings have noise, which adds to the mean square of the residuals, and adds less where a
    /// surface is smoother: a fit would prefer that. The mean product of the residuals of two
    /// independent simulations has no such part; it may be negative where the model is as good as the
    /// noise allows to see. So the cost is the objective for quadrature, and this mean, times 10^4, for rays.
    pub(super) fn cost(&self, values: &[f64], effort: Effort) -> Result<Option<f64>, BuildError> {
        if !self.is_traced() {
            return Ok(self.simulate(values, effort)?.map(|r| self.cost_at(values, &r.values)));
        }
        let ready = self.ready(values)?;
        let rays = self.rays(effort);
        let half = |seed| {
            let rays = Rays { count: rays.count.div_ceil(2), seed };
            ready.readings(effort, rays, self.watch).map(|r| r.values)
        };
        let (Some(a), Some(b)) = (half(rays.seed), half(rays.seed ^ (1 << 63))) else {
            return Ok(None);
        };
        let objective = self.objective();
        let product: f64 = self
            .measured
            .iter()
            .zip(a.iter().zip(&b))
            .map(|(&m, (&a, &b))| {
                objective.residual(m, a, self.largest) * objective.residual(m, b, self.largest)
            })
            .sum();
        let prior: f64 = self.of_priors(values).map(|r| r * r).sum();
        // A root would make a cliff of the place where the mean is nothing.
        Ok(Some(1e4 * (product + prior) / self.measured.len() as f64))
    }

    /// The residuals whose mean square the fit minimises: those of the readings, then [`Self::prior_count`] of what is known
    /// beforehand.
    pub(super) fn residuals(&self, values: &[f64], simulated: &[f64]) -> Vec<f64> {
        let pairs = self.measured.iter().zip(simulated);
        let of_readings = pairs.map(|(&m, &s)| self.objective().residual(m, s, self.largest));
        of_readings.chain(self.of_priors(values)).collect()
    }

    fn of_priors(&self, values: &[f64]) -> impl Iterator<Item = f64> {
        let known = |(p, value): (&Parameter, &f64)| {
            let (nominal, width) = self.priors.get(p.name)?;
            Some(self.noise * (value - nominal) / width)
        };
        self.parameters.iter().zip(values).filter_map(known)
    }

    /// How many of the free parameters have a prior.
    pub(super) fn prior_count(&self) -> usize {
        self.parameters.iter().filter(|p| self.priors.contains_key(p.name)).count()
    }

    /// Standard deviation of a residual by noise, in which priors are weighed.
    pub(super) fn noise(&self) -> f64 {
        self.noise
    }

    pub(super) fn largest(&self) -> f64 {
        self.largest
    }

    /// The objective for values and their simulated readings, with what is known beforehand.
    fn cost_at(&self, values: &[f64], simulated: &[f64]) -> f64 {
        let sum: f64 = self.residuals(values, simulated).iter().map(|r| r * r).sum();
        self.objective().of_mean_square(sum / self.measured.len() as f64)
    }

    /// By how much the residuals of a law change where the instrument makes readings `after` of `before`.
    pub(super) fn residual_change(&self, before: &[f64], after: &[f64]) -> Vec<f64> {
        let of = |readings: &[f64]| -> Vec<f64> {
            let pairs = before.iter().zip(readings);
            pairs.map(|(&s, &m)| self.objective().residual(m, s, self.largest)).collect()
        };
        let pairs = of(before).into_iter().zip(of(after));
        pairs.map(|(before, after)| before - after).collect()
    }

    /// The objective for simulated readings; not finite if any of them is not.
    pub(super) fn cost_of(&self, simulated: &[f64]) -> f64 {
        let objective = self.objective();
        let sum: f64 = self
            .measured
            .iter()
            .zip(simulated)
            .map(|(&m, &s)| objective.residual(m, s, self.largest).powi(2))
            .sum();
        objective.of_mean_square(sum / self.measured.len() as f64)
    }
}

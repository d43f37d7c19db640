//! The cost of a fit: residuals of the readings and of what is known beforehand.

use super::problem::Problem;
use crate::forward::{Effort, Readings};
use crate::method::{BuildError, Parameter};

impl Problem<'_> {
    /// The cost of a fit; `None` if the user stopped it.
    ///
    /// Traced readings have noise, which adds to the mean square of the residuals, and adds less where a
    /// surface is smoother: a fit would prefer that. The mean product of the residuals of two
    /// independent halves of the rays has no such part; it may be negative where the model is as good as the
    /// noise allows to see. So the cost is the objective for quadrature, and this mean, times 10^4, for rays.
    pub(super) fn cost(&self, values: &[f64], effort: Effort) -> Result<Option<f64>, BuildError> {
        let Some(readings) = self.simulate(values, effort)? else { return Ok(None) };
        if !self.is_traced() {
            return Ok(Some(self.cost_at(values, &readings.values)));
        }
        // A root would make a cliff of the place where the mean is nothing.
        Ok(Some(1e4 * self.mean_product(&self.residual_halves(values, &readings))))
    }

    /// The residuals of either half of the rays.
    pub(super) fn residual_halves(&self, values: &[f64], readings: &Readings) -> [Vec<f64>; 2] {
        match &readings.halves {
            Some([a, b]) => [self.residuals(values, a), self.residuals(values, b)],
            None => [(); 2].map(|()| self.residuals(values, &readings.values)),
        }
    }

    /// The mean of the products of the residuals of two halves.
    pub(super) fn mean_product(&self, [a, b]: &[Vec<f64>; 2]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / self.measured.len() as f64
    }

    /// Variance of the sum of those products by the noise of the rays.
    pub(super) fn product_variance(
        &self,
        values: &[f64],
        [a, b]: &[Vec<f64>; 2],
        readings: &Readings,
    ) -> f64 {
        let both = self.residuals(values, &readings.values);
        let variances = self.ray_variances(&both, readings);
        let (mut sum, mut from) = (0.0, 0);
        for incidence in &self.angles().incidences {
            let to = from + incidence.theta_deg.len();
            // neighbours whose cones overlap count the same rays; half the rays have twice the variance
            let alike = 2.0 * self.overlap(&incidence.theta_deg) as f64 + 1.0;
            let of = |i: usize| 2.0 * variances[i] * (a[i] * a[i] + b[i] * b[i]);
            sum += alike * (from..to.min(variances.len())).map(of).sum::<f64>();
            from = to;
        }
        sum
    }

    /// Variances of the residuals of readings by the noise of their rays; empty if they have none.
    pub(super) fn ray_variances(&self, residuals: &[f64], readings: &Readings) -> Vec<f64> {
        let errors = readings.std_errors.iter().flatten();
        let lifted = self.measured.iter().zip(readings.values.iter().zip(errors));
        let moved = lifted.map(|(&m, (s, e))| self.objective().residual(m, s + e, self.largest));
        moved.zip(residuals).map(|(moved, r)| (moved - r) * (moved - r)).collect()
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
    pub(super) fn cost_at(&self, values: &[f64], simulated: &[f64]) -> f64 {
        let sum: f64 = self.residuals(values, simulated).iter().map(|r| r * r).sum();
        self.objective().of_mean_square(sum / self.measured.len() as f64)
    }

    /// The same of readings at the level of the law.
    pub(super) fn cost_of_simulated(&self, values: &[f64], readings: Readings) -> f64 {
        self.cost_at(values, &self.levelled(readings).values)
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

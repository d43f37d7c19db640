//! What a search of readings with noise tells the next one: where it ended, and the derivatives there.

use super::problem::Problem;
use crate::method::Parameter;

/// Derivatives of the residuals, by parameter, from either half of the rays.
pub(super) type Slopes = [Vec<Vec<f64>>; 2];

/// Where a search ended.
#[derive(Clone)]
pub(super) struct Told {
    pub(super) free: Vec<f64>,
    /// Residuals there by either half of the rays, and their derivatives near it.
    pub(super) halves: [Vec<f64>; 2],
    pub(super) slopes: Slopes,
    /// Variance of the sum of the products of the halves by the noise of rays.
    pub(super) variance: f64,
}

impl Told {
    /// The residuals by all rays.
    pub(super) fn residuals(&self) -> Vec<f64> {
        mean(&self.halves)
    }

    /// Their derivatives by the values of the parameters themselves.
    pub(super) fn columns(&self, problem: &Problem<'_>) -> Vec<Vec<f64>> {
        let rate = |(p, free): (&Parameter, &f64)| {
            let step = 1e-3 * p.step(p.to_bounded(*free));
            2.0 * step / (p.to_bounded(free + step) - p.to_bounded(free - step))
        };
        let rates = problem.parameters().iter().zip(&self.free).map(rate);
        let [a, b] = &self.slopes;
        let both = a.iter().zip(b).zip(rates);
        both.map(|((a, b), rate)| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b) * rate).collect())
            .collect()
    }
}

fn mean([a, b]: &[Vec<f64>; 2]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
}

//! Standard errors from the curvature at the optimum.

use super::problem::Problem;
use crate::forward::Effort;
use crate::linear::inverse;

/// The derivatives at the optimum.
pub(super) struct Curvature {
    /// Residuals at the optimum.
    pub(super) residuals: Vec<f64>,
    /// Their derivatives, by parameter.
    pub(super) columns: Vec<Vec<f64>>,
    /// Inverse of the curvature of half the sum of their squares.
    pub(super) inverse: Vec<Vec<f64>>,
    /// Standard errors of the values; `None` where the data do not determine one.
    pub(super) std_errors: Vec<Option<f64>>,
}

impl Curvature {
    /// Correlations of the errors of the values, by parameter and parameter, -1 to 1.
    pub(super) fn correlations(&self) -> Vec<Vec<f64>> {
        let own = |k: usize| self.inverse[k][k].sqrt();
        let of = |(i, row): (usize, &Vec<f64>)| {
            row.iter().enumerate().map(|(j, c)| (c / (own(i) * own(j))).clamp(-1.0, 1.0)).collect()
        };
        self.inverse.iter().enumerate().map(of).collect()
    }
}

/// The curvature at fitted values; `None` if the data do not determine them.
///
/// With `J` the derivatives of the residuals `r`, the curvature of the sum of squares is `H = J^T J` (Gauss and
/// Newton), and the covariance of the values is `H^-1 M H^-1`, where `M` sums the products of the scores
/// `J_i r_i` over neighbouring readings of an incidence with falling weights \[Newey & West 1987\]. So
/// readings need not be alike in noise, nor independent: neighbours share most of their aperture, and
/// the misfit of a model has a shape.
pub(super) fn curvature(
    problem: &Problem<'_>,
    values: &[f64],
    simulated: &[f64],
) -> Option<Curvature> {
    let residual = |values: &[f64], readings: &[f64]| problem.residuals(values, readings);
    // The fit chose its values under the noise of its own rays, which is part of their error.
    let fitted = problem.is_traced().then(|| problem.simulate(values, Effort::Full));
    let at_optimum = match &fitted {
        Some(Ok(Some(readings))) => residual(values, &readings.values),
        _ => residual(values, simulated),
    };
    let (n, p) = (problem.measured().len(), values.len());
    if n + problem.prior_count() <= p {
        return None;
    }
    let mut columns = Vec::with_capacity(p);
    for (k, parameter) in problem.parameters().iter().enumerate() {
        // the noise of a traced derivative falls with the width of its step
        let share = if problem.is_traced() { 0.2 } else { 1e-2 };
        let step = share * parameter.step(values[k]).abs().clamp(0.05, 5.0);
        let free = parameter.to_free(values[k]);
        let side = |sign: f64| {
            let mut probe = values.to_vec();
            probe[k] = parameter.to_bounded(free + sign * step);
            let readings = problem.simulate(&probe, Effort::Full).ok()??;
            Some((probe[k], residual(&probe, &readings.values)))
        };
        let here = || (values[k], at_optimum.clone());
        // where there is no more light, from one side
        let ((high, above), (low, below)) = match (side(1.0), side(-1.0)) {
            (Some(above), Some(below)) => (above, below),
            (Some(above), None) => (above, here()),
            (None, Some(below)) => (here(), below),
            (None, None) => return None,
        };
        let width = high - low;
        columns.push(above.iter().zip(&below).map(|(a, b)| (a - b) / width).collect::<Vec<_>>());
    }
    let product = |i: usize, j: usize| -> f64 {
        columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum()
    };
    let curvature: Vec<Vec<f64>> =
        (0..p).map(|i| (0..p).map(|j| product(i, j)).collect()).collect();
    let inverse = inverse(&curvature)?;
    let found = Curvature { residuals: at_optimum, columns, inverse, std_errors: Vec::new() };
    let std_errors = found.std_errors(problem, &found.residuals);
    Some(Curvature { std_errors, ..found })
}

impl Curvature {
    /// Standard errors of the values if noise left these residuals, as [`curvature`] says.
    pub(super) fn std_errors(&self, problem: &Problem<'_>, residuals: &[f64]) -> Vec<Option<f64>> {
        let (n, p) = (problem.measured().len(), self.columns.len());
        // what is known beforehand is as good as it says, whatever its residual
        let beforehand = residuals.len().saturating_sub(n);
        let correction = n as f64 / n.saturating_sub(p).max(1) as f64;
        let of = |row: &Vec<f64>| {
            let moved = |i: usize| -> f64 {
                row.iter().zip(&self.columns).map(|(h, column)| h * column[i]).sum::<f64>()
            };
            // H^-1 J_i r_i, one series of length n a parameter: the variance is their correlated sum
            let series: Vec<f64> = (0..n).map(|i| moved(i) * residuals[i]).collect();
            let of_priors: f64 =
                (n..n + beforehand).map(|i| (moved(i) * problem.noise()).powi(2)).sum();
            let variance = correction * correlated_sum(problem, &series) + of_priors;
            Some(variance.sqrt()).filter(|e| e.is_finite() && *e > 0.0)
        };
        self.inverse.iter().map(of).collect()
    }
}

/// Variance of a sum of correlated terms: the largest of three estimates from products of neighbours
/// within an incidence: none; those whose cones overlap; all up to one and a half times the root of
/// the number of readings, with falling weights.
///
/// The third sees the shape of a misfit, but the scores sum to zero at the optimum, so a reach as wide as
/// the lobe finds too little; the second sees the noise that overlapping cones share.
pub(super) fn correlated_sum(problem: &Problem<'_>, series: &[f64]) -> f64 {
    let mut from = 0;
    let mut estimates = [0.0; 3];
    for incidence in &problem.angles().incidences {
        let part = &series[from..from + incidence.theta_deg.len()];
        from += part.len();
        let overlap = problem.overlap(&incidence.theta_deg);
        let reach = (1.5 * (part.len() as f64).sqrt()).ceil().min(MOST_REACH) as usize;
        for lag in 0..=reach.max(overlap).min(part.len().saturating_sub(1)) {
            let sum: f64 = part.iter().zip(&part[lag..]).map(|(a, b)| a * b).sum();
            let both = if lag == 0 { sum } else { 2.0 * sum };
            estimates[0] += if lag == 0 { both } else { 0.0 };
            estimates[1] += if lag <= overlap { both } else { 0.0 };
            estimates[2] += both * (1.0 - lag as f64 / (reach + 1) as f64).max(0.0);
        }
    }
    estimates.into_iter().fold(0.0, f64::max)
}

/// Longest lag that is looked at, readings.
const MOST_REACH: f64 = 256.0;

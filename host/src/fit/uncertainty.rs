//! Standard errors from the curvature at the optimum.

use super::problem::Problem;
use crate::forward::Effort;
use crate::linear::inverse;

/// Standard errors of the fitted values, `None` where the data do not determine one.
///
/// With `J` the derivatives of the residuals `r`, the curvature of the sum of squares is `H = J^T J` (Gauss and
/// Newton), and the covariance of the values is `H^-1 M H^-1`, where `M` sums the products of the scores
/// `J_i r_i` over neighbouring readings of an incidence with falling weights \[Newey & West 1987\]. So
/// readings need not be alike in noise, nor independent: neighbours share most of their aperture, and
/// the misfit of a model has a shape.
pub(super) fn std_errors(
    problem: &Problem<'_>,
    values: &[f64],
    simulated: &[f64],
) -> Vec<Option<f64>> {
    let unknown = vec![None; values.len()];
    let objective = problem.objective();
    let residual = |readings: &[f64]| -> Vec<f64> {
        problem
            .measured()
            .iter()
            .zip(readings)
            .map(|(&m, &s)| objective.residual(m, s, problem.largest()))
            .collect()
    };
    let at_optimum = residual(simulated);
    let (n, p) = (at_optimum.len(), values.len());
    if n <= p {
        return unknown;
    }
    let mut columns = Vec::with_capacity(p);
    for (k, parameter) in problem.parameters().iter().enumerate() {
        let step = 1e-3 * parameter.step(values[k]).abs().clamp(0.05, 5.0);
        let free = parameter.to_free(values[k]);
        let side = |sign: f64| {
            let mut probe = values.to_vec();
            probe[k] = parameter.to_bounded(free + sign * step);
            let readings = problem.simulate(&probe, Effort::Full).ok()?;
            Some((probe[k], residual(&readings.values)))
        };
        let (Some((high, above)), Some((low, below))) = (side(1.0), side(-1.0)) else {
            return unknown;
        };
        let width = high - low;
        columns.push(above.iter().zip(&below).map(|(a, b)| (a - b) / width).collect::<Vec<_>>());
    }
    let product = |i: usize, j: usize| -> f64 {
        columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum()
    };
    let curvature: Vec<Vec<f64>> =
        (0..p).map(|i| (0..p).map(|j| product(i, j)).collect()).collect();
    let Some(inverse) = inverse(&curvature) else {
        return unknown;
    };
    // H^-1 J_i r_i, one series of length n a parameter: the variance is their correlated sum.
    let correction = n as f64 / (n - p) as f64;
    inverse
        .iter()
        .map(|row| {
            let moved = |i: usize| -> f64 {
                row.iter().zip(&columns).map(|(h, column)| h * column[i]).sum::<f64>()
                    * at_optimum[i]
            };
            let series: Vec<f64> = (0..n).map(moved).collect();
            let variance = correction * correlated_sum(problem, &series);
            Some(variance.sqrt()).filter(|e| e.is_finite() && *e > 0.0)
        })
        .collect()
}

/// Variance of a sum of correlated terms: products of neighbours within an incidence, Bartlett weights up
/// to twice the lag at which two detector cones no longer overlap.
///
/// No further: the scores sum to zero at the optimum, so a reach as wide as the lobe would find no
/// variance at all.
fn correlated_sum(problem: &Problem<'_>, series: &[f64]) -> f64 {
    let mut from = 0;
    let mut variance = 0.0;
    for incidence in &problem.plan().incidences {
        let part = &series[from..from + incidence.theta_deg.len()];
        from += part.len();
        let reach = 1 + 2 * problem.overlap(&incidence.theta_deg);
        for lag in 0..reach.min(part.len()) {
            let sum: f64 = part.iter().zip(&part[lag..]).map(|(a, b)| a * b).sum();
            let weight = 1.0 - lag as f64 / reach as f64;
            variance += if lag == 0 { sum } else { 2.0 * weight * sum };
        }
    }
    variance.max(0.0)
}

//! Standard errors from the curvature at the optimum.

use super::problem::Problem;
use crate::forward::Effort;

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

/// Variance of a sum of correlated terms: products of neighbours within an incidence, Bartlett weights
/// up to a lag of one and a half times the root of the number of readings.
fn correlated_sum(problem: &Problem<'_>, series: &[f64]) -> f64 {
    let mut from = 0;
    let mut variance = 0.0;
    for incidence in &problem.plan().incidences {
        let part = &series[from..from + incidence.theta_deg.len()];
        from += part.len();
        let reach = (1.5 * (part.len() as f64).sqrt()).ceil() as usize;
        for lag in 0..reach.min(part.len()) {
            let sum: f64 = part.iter().zip(&part[lag..]).map(|(a, b)| a * b).sum();
            let weight = 1.0 - lag as f64 / reach as f64;
            variance += if lag == 0 { sum } else { 2.0 * weight * sum };
        }
    }
    variance.max(0.0)
}

/// Inverse of a small symmetric positive matrix by Cholesky, scaled to unit diagonal first; `None` if it
/// is singular.
fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let p = matrix.len();
    let scale: Vec<f64> = (0..p).map(|i| matrix[i][i].sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    let mut l = vec![vec![0.0; p]; p];
    for i in 0..p {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = matrix[i][j] / (scale[i] * scale[j]) - known;
            if i == j {
                if rest < 1e-12 {
                    return None;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    // Columns of L^-1, then A^-1 = L^-T L^-1.
    let lower: Vec<Vec<f64>> = (0..p)
        .map(|k| {
            let mut y = vec![0.0; p];
            for i in k..p {
                let known: f64 = (k..i).map(|j| l[i][j] * y[j]).sum();
                y[i] = (if i == k { 1.0 } else { 0.0 } - known) / l[i][i];
            }
            y
        })
        .collect();
    let entry = |i: usize, j: usize| {
        let sum: f64 = lower[i].iter().zip(&lower[j]).map(|(a, b)| a * b).sum();
        sum / (scale[i] * scale[j])
    };
    Some((0..p).map(|i| (0..p).map(|j| entry(i, j)).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::inverse;

    #[test]
    fn the_inverse_of_a_known_matrix_and_the_refusal_of_a_singular_one() {
        // [[4, 2], [2, 3]] has the inverse [[3, -2], [-2, 4]] / 8
        let found = inverse(&[vec![4.0, 2.0], vec![2.0, 3.0]]).unwrap();
        for (row, exact) in found.iter().zip([[0.375, -0.25], [-0.25, 0.5]]) {
            assert!(row.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        }
        assert!(inverse(&[vec![1.0, 1.0], vec![1.0, 1.0]]).is_none());
        assert!(inverse(&[vec![0.0]]).is_none());
    }
}

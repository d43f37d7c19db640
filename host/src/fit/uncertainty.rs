//! Standard errors from the curvature at the optimum.

use super::problem::Problem;
use crate::forward::Effort;

/// Standard errors of the fitted values, `None` where the data do not determine one.
///
/// The curvature of the sum of squares is that of Gauss and Newton, `J^T J`; the covariance is its inverse
/// times the variance of the residuals, times their correlation length in readings: neighbouring
/// readings share most of their aperture, and a misfit of the model has a shape, so they are not
/// independent.
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
    let mut curvature = vec![vec![0.0; p]; p];
    for (i, row) in curvature.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum();
        }
    }
    let variance = at_optimum.iter().map(|r| r * r).sum::<f64>() / (n - p) as f64;
    let correlated = correlation_length(problem, &at_optimum);
    inverse_diagonal(curvature)
        .into_iter()
        .map(|d| d.map(|d| (d * variance * correlated).sqrt()).filter(|e| e.is_finite()))
        .collect()
}

/// Sum of the autocorrelation of the residuals over both signs of the lag, in readings, at least 1.
fn correlation_length(problem: &Problem<'_>, residuals: &[f64]) -> f64 {
    let total: f64 = residuals.iter().map(|r| r * r).sum();
    if total <= 0.0 {
        return 1.0;
    }
    let longest = problem.plan().incidences.iter().map(|i| i.theta_deg.len()).max().unwrap_or(0);
    let mut length = 1.0;
    for lag in 1..longest {
        let mut from = 0;
        let mut sum = 0.0;
        for incidence in &problem.plan().incidences {
            let part = &residuals[from..from + incidence.theta_deg.len()];
            from += part.len();
            sum += part.iter().zip(part.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>();
        }
        // up to the first lag without correlation: beyond, the sum is noise
        if sum <= 0.0 {
            break;
        }
        length += 2.0 * sum / total;
    }
    length
}

/// Diagonal of the inverse of a small symmetric matrix by Cholesky, scaled to unit diagonal first;
/// `None` throughout if it is singular.
fn inverse_diagonal(matrix: Vec<Vec<f64>>) -> Vec<Option<f64>> {
    let p = matrix.len();
    let scale: Vec<f64> = (0..p).map(|i| matrix[i][i].sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return vec![None; p];
    }
    let mut l = vec![vec![0.0; p]; p];
    for i in 0..p {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = matrix[i][j] / (scale[i] * scale[j]) - known;
            if i == j {
                if rest < 1e-12 {
                    return vec![None; p];
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    (0..p)
        .map(|k| {
            // solve L y = e_k: the diagonal element is |y|^2
            let mut y = vec![0.0; p];
            for i in k..p {
                let known: f64 = (k..i).map(|j| l[i][j] * y[j]).sum();
                y[i] = (if i == k { 1.0 } else { 0.0 } - known) / l[i][i];
            }
            Some(y.iter().map(|v| v * v).sum::<f64>() / (scale[k] * scale[k]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::inverse_diagonal;

    #[test]
    fn the_inverse_of_a_known_matrix_and_the_refusal_of_a_singular_one() {
        // [[4, 2], [2, 3]] has the inverse [[3, -2], [-2, 4]] / 8
        let d = inverse_diagonal(vec![vec![4.0, 2.0], vec![2.0, 3.0]]);
        assert!((d[0].unwrap() - 0.375).abs() < 1e-14 && (d[1].unwrap() - 0.5).abs() < 1e-14);
        assert_eq!(inverse_diagonal(vec![vec![1.0, 1.0], vec![1.0, 1.0]]), vec![None, None]);
        assert_eq!(inverse_diagonal(vec![vec![0.0]]), vec![None]);
    }
}

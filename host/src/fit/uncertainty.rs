//! Standard errors from the curvature at the optimum.

use super::problem::Problem;
use super::told::Told;
use crate::forward::Effort;
use crate::linear::inverse;

/// The derivatives at the optimum.
pub(super) struct Curvature {
    /// Residuals at the optimum.
    pub(super) residuals: Vec<f64>,
    /// What of them is noise: all, unless doubts explain a part.
    pub(super) noise: Vec<f64>,
    /// Their derivatives, by parameter.
    pub(super) columns: Vec<Vec<f64>>,
    /// Inverse of the curvature of half the sum of their squares.
    pub(super) inverse: Vec<Vec<f64>>,
    /// Standard errors of the values; `None` where the data do not determine one.
    pub(super) std_errors: Vec<Option<f64>>,
}

/// The curvature at fitted values; `None` if the data do not determine them.
///
/// With `J` the derivatives of the residuals `r`, the curvature of the sum of squares is `H = J^T J` (Gauss and
/// Newton), and the covariance of the values is `H^-1 M H^-1`, where `M` sums the products of the scores
/// `J_i r_i` over neighbouring readings of an incidence with falling weights \[Newey & West 1987\]. So
/// readings need not be alike in noise, nor independent: neighbours share most of their aperture, and
/// the misfit of a model has a shape.
///
/// A search under noise has `told` both already.
pub(super) fn curvature(
    problem: &Problem<'_>,
    values: &[f64],
    simulated: &[f64],
    told: Option<&Told>,
) -> Option<Curvature> {
    let (n, p) = (problem.measured().len(), values.len());
    if n + problem.prior_count() <= p {
        return None;
    }
    if let Some(told) = told {
        return of_columns(problem, told.residuals(), told.columns(problem));
    }
    let residual = |values: &[f64], readings: &[f64]| problem.residuals(values, readings);
    // The fit chose its values under the noise of its own rays, which is part of their error.
    let fitted = problem.is_traced().then(|| problem.simulate(values, Effort::Full));
    let at_optimum = match &fitted {
        Some(Ok(Some(readings))) => residual(values, &readings.values),
        _ => residual(values, simulated),
    };
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
    of_columns(problem, at_optimum, columns)
}

/// The curvature of residuals and their derivatives at the optimum.
fn of_columns(
    problem: &Problem<'_>,
    at_optimum: Vec<f64>,
    columns: Vec<Vec<f64>>,
) -> Option<Curvature> {
    let p = columns.len();
    let product = |i: usize, j: usize| -> f64 {
        columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum()
    };
    let curvature: Vec<Vec<f64>> =
        (0..p).map(|i| (0..p).map(|j| product(i, j)).collect()).collect();
    let inverse = inverse(&curvature)?;
    let noise = at_optimum.clone();
    let found = Curvature {
        residuals: at_optimum,
        noise: Vec::new(),
        columns,
        inverse,
        std_errors: Vec::new(),
    };
    Some(found.with_noise(problem, noise))
}

impl Curvature {
    /// The same if these residuals are the noise.
    pub(super) fn with_noise(self, problem: &Problem<'_>, noise: Vec<f64>) -> Self {
        let std_errors = self.std_errors(problem, &noise);
        Self { noise, std_errors, ..self }
    }

    /// How the readings tie the values to each other whatever their noise, by parameter and parameter, -1 to 1.
    pub(super) fn ties(&self) -> Vec<Vec<f64>> {
        correlations(&self.inverse)
    }

    /// Standard errors of the values if noise left these residuals, as [`curvature`] says.
    fn std_errors(&self, problem: &Problem<'_>, residuals: &[f64]) -> Vec<Option<f64>> {
        let count = problem.measured().len();
        let correction = count as f64 / count.saturating_sub(self.columns.len()).max(1) as f64;
        let of = |row: &Vec<f64>| {
            let series = self.series(row, &residuals[..count]);
            let variance = correction * correlated_sum(problem, &series)
                + self.of_priors(problem, (row, row), residuals.len());
            Some(variance.sqrt()).filter(|e| e.is_finite() && *e > 0.0)
        };
        self.inverse.iter().map(of).collect()
    }

    /// Correlations of the errors of the values, by parameter and parameter, -1 to 1: those of the estimate that is the largest
    /// of all parameters together.
    pub(super) fn correlations(&self, problem: &Problem<'_>) -> Vec<Vec<f64>> {
        let readings = &self.noise[..problem.measured().len()];
        let series: Vec<Vec<f64>> =
            self.inverse.iter().map(|row| self.series(row, readings)).collect();
        let (count, p) = (self.noise.len(), series.len());
        let pair = |i: usize, j: usize| {
            let rows = (&self.inverse[i][..], &self.inverse[j][..]);
            let of_priors = self.of_priors(problem, rows, count);
            estimates(problem, &series[i], &series[j]).map(|sum| sum + of_priors)
        };
        let all: Vec<Vec<[f64; 3]>> =
            (0..p).map(|i| (0..p).map(|j| pair(i, j)).collect()).collect();
        let size = |m: usize| -> f64 { (0..p).map(|k| all[k][k][m].max(0.0).ln()).sum() };
        let largest = (0..3).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
        // readings without any noise tell no more than the ties
        if !size(largest).is_finite() {
            return self.ties();
        }
        let matrix: Vec<Vec<f64>> =
            all.iter().map(|row| row.iter().map(|sums| sums[largest]).collect()).collect();
        correlations(&matrix)
    }

    /// What each reading moves a value by: `H^-1 J_i r_i`.
    fn series(&self, row: &[f64], residuals: &[f64]) -> Vec<f64> {
        let moved = |i: usize| -> f64 {
            row.iter().zip(&self.columns).map(|(h, column)| h * column[i]).sum::<f64>()
        };
        residuals.iter().enumerate().map(|(i, r)| moved(i) * r).collect()
    }

    /// The share of a covariance that what is known beforehand has: as good as it says, whatever its residual.
    fn of_priors(&self, problem: &Problem<'_>, (a, b): (&[f64], &[f64]), count: usize) -> f64 {
        let moved = |row: &[f64], i: usize| -> f64 {
            row.iter().zip(&self.columns).map(|(h, column)| h * column[i]).sum::<f64>()
        };
        let one = |i: usize| moved(a, i) * moved(b, i) * problem.noise().powi(2);
        (problem.measured().len()..count).map(one).sum()
    }
}

/// Correlations of a covariance, -1 to 1.
fn correlations(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let own = |k: usize| covariance[k][k].sqrt();
    let of = |(i, row): (usize, &Vec<f64>)| {
        row.iter().enumerate().map(|(j, c)| (c / (own(i) * own(j))).clamp(-1.0, 1.0)).collect()
    };
    covariance.iter().enumerate().map(of).collect()
}

/// Variance of a sum of correlated terms: the largest of three estimates from products of neighbours
/// within an incidence: none; those whose cones overlap; all up to one and a half times the root of
/// the number of readings, with falling weights.
///
/// The third sees the shape of a misfit, but the scores sum to zero at the optimum, so a reach as wide as
/// the lobe finds too little; the second sees the noise that overlapping cones share.
pub(super) fn correlated_sum(problem: &Problem<'_>, series: &[f64]) -> f64 {
    estimates(problem, series, series).into_iter().fold(0.0, f64::max)
}

/// The three estimates of the covariance of two such sums.
fn estimates(problem: &Problem<'_>, first: &[f64], second: &[f64]) -> [f64; 3] {
    let mut from = 0;
    let mut estimates = [0.0; 3];
    for incidence in &problem.angles().incidences {
        let range = from..from + incidence.theta_deg.len();
        from = range.end;
        let (a, b) = (&first[range.clone()], &second[range]);
        let overlap = problem.overlap(&incidence.theta_deg);
        let reach = (1.5 * (a.len() as f64).sqrt()).ceil().min(MOST_REACH) as usize;
        let products = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for lag in 0..=reach.max(overlap).min(a.len().saturating_sub(1)) {
            let both = if lag == 0 {
                products(a, b)
            } else {
                products(a, &b[lag..]) + products(b, &a[lag..])
            };
            estimates[0] += if lag == 0 { both } else { 0.0 };
            estimates[1] += if lag <= overlap { both } else { 0.0 };
            estimates[2] += both * (1.0 - lag as f64 / (reach + 1) as f64).max(0.0);
        }
    }
    estimates
}

/// Longest lag that is looked at, readings.
const MOST_REACH: f64 = 256.0;

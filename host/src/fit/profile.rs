//! Standard errors checked by a profile of the cost.
//!
//! A standard error comes from the curvature at the optimum: it says that the sum of squares, in units of the variance that
//! belongs to the parameter, rises by 4 where the value is moved by two of it and the others are fitted again. Here the value is
//! moved and the others follow (along the valley that the curvature shows, and by a step of Gauss and Newton where
//! readings have no noise). Where the rise is less the error was too small: it is enlarged, on its side, until the rise is 4.

use super::problem::Problem;
use super::told::Told;
use super::uncertainty::Curvature;
use crate::forward::Effort;
use crate::linear::inverse;

/// The verdict of a profile on one side of a standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// The standard error that makes the cost rise as it should.
    Error(f64),
    /// The value cannot be moved so far: a bound of its range is nearer.
    Bound,
    /// The cost hardly rises, however far the value is moved: no error can be stated.
    Flat,
}

/// The two sides of a standard error, downwards and upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Of the curvature at the optimum.
    pub std_error: f64,
    /// Rise of chi squared at two standard errors below and above the value, 4 if the error is right; `None` beyond a bound.
    pub rises: [Option<f64>; 2],
    /// The standard error on either side.
    pub sides: [Side; 2],
    /// Factor by which a side may exceed the error of the curvature and still confirm it.
    tolerance: f64,
}

/// Factors by which a side may exceed the error of the curvature: without noise, and under that of rays.
const TOLERANCES: (f64, f64) = (1.2, 1.5);
/// Farthest that the error of a side is looked for, in standard errors of the curvature.
const FARTHEST: f64 = 8.0;
/// Moves of a value on one side at most: without noise, and under that of rays.
const MOVES: (u32, u32) = (5, 1);
/// Standard errors of the rays that count as noise.
const RAY_ERRORS: f64 = 3.0;
/// Rise of chi squared at two standard errors.
const RISE: f64 = 4.0;

impl Profile {
    /// Whether neither side is larger than the curvature says.
    pub fn is_confirmed(&self) -> bool {
        let most = self.tolerance * self.std_error;
        self.sides.iter().all(|side| match side {
            Side::Error(e) => *e <= most,
            Side::Bound => true,
            Side::Flat => false,
        })
    }

    /// The error to state: that of the curvature where it is confirmed, else the larger one of the sides.
    pub fn stated(&self) -> f64 {
        if self.is_confirmed() {
            return self.std_error;
        }
        self.sides.iter().fold(self.std_error, |most, side| match side {
            Side::Error(e) => most.max(*e),
            Side::Bound | Side::Flat => most,
        })
    }

    /// The warning; `None` if the error is confirmed.
    pub fn text(&self, name: &str, unit: &str) -> Option<String> {
        if self.is_confirmed() {
            return None;
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let [down, up] = self.sides.map(|side| match side {
            Side::Error(e) => format!("{e:.2e}"),
            Side::Bound => "to its bound".into(),
            Side::Flat => "without end".into(),
        });
        let flat = self.sides.contains(&Side::Flat);
        let says = if flat { "is unreliable" } else { "is larger than the curvature says" };
        Some(format!(
            "the standard error of {name} {says} ({:.2e}{unit}): by the profile of the cost it is {down} downwards, \
             {up} upwards",
            self.std_error
        ))
    }
}

/// Profiles of all parameters; `None` where there is no standard error to check, or the user stopped.
pub(super) fn profiles(
    problem: &Problem<'_>,
    values: &[f64],
    curvature: &Curvature,
    told: Option<&Told>,
) -> Vec<Option<Profile>> {
    let traced = problem.is_traced();
    let optimum = if traced {
        let known = told.map(|told| squares_of_halves(&told.halves));
        known.or_else(|| sum_of(problem, values)).map(|least| (values.to_vec(), least))
    } else {
        bottom(problem, values, curvature)
    };
    let Some((bottom, least)) = optimum else { return vec![None; values.len()] };
    let values = &bottom[..];
    let one = |(k, std_error): (usize, &Option<f64>)| {
        let std_error = (*std_error)?;
        let parameter = &problem.parameters()[k];
        if parameter.is_at_bound(values[k]) {
            return None;
        }
        let own = curvature.inverse[k][k];
        let valley = Valley { problem, values, curvature, k, least, unit: std_error.powi(2) / own };
        // a rise that the noise of rays hides says nothing
        let noise = told.map_or(0.0, |told| (2.0 * told.variance).sqrt() / valley.unit);
        if RAY_ERRORS * noise > RISE {
            return None;
        }
        let down = valley.side(-std_error)?;
        let up = valley.side(std_error)?;
        let tolerance = if traced { TOLERANCES.1 } else { TOLERANCES.0 };
        let (rises, sides) = ([down.0, up.0], [down.1, up.1]);
        Some(Profile { std_error, rises, sides, tolerance })
    };
    curvature.std_errors.iter().enumerate().map(one).collect()
}

/// The cost along one parameter.
struct Valley<'a> {
    problem: &'a Problem<'a>,
    values: &'a [f64],
    curvature: &'a Curvature,
    k: usize,
    /// Sum of squares at the optimum.
    least: f64,
    /// Sum of squares that counts as 1 in chi squared.
    unit: f64,
}

impl Valley<'_> {
    /// The rise at two standard errors to a side, and the error of that side; `None` if stopped.
    fn side(&self, std_error: f64) -> Option<(Option<f64>, Side)> {
        let moves = if self.problem.is_traced() { MOVES.1 } else { MOVES.0 };
        let (mut errors, mut first) = (2.0, None);
        for k in 0..moves {
            let value = self.values[self.k] + errors * std_error;
            let (least, most) = self.problem.parameters()[self.k].bounds;
            if !(least..=most).contains(&value) {
                return Some((first, Side::Bound));
            }
            let rise = self.rise(errors * std_error)?;
            first = if k == 0 { Some(rise) } else { first };
            // as if the cost were a parabola from here to the optimum
            let next = errors * (RISE / rise.max(1e-12)).sqrt();
            let near = (rise / RISE - 1.0).abs() < 0.1;
            if next > FARTHEST && errors >= 0.5 * FARTHEST {
                return Some((first, Side::Flat));
            }
            if near || k + 1 == moves {
                let side = if next > FARTHEST {
                    Side::Flat
                } else {
                    Side::Error(0.5 * next * std_error.abs())
                };
                return Some((first, side));
            }
            errors = next.min(2.0 * errors).min(FARTHEST);
        }
        None
    }

    /// Rise of chi squared where the value is moved by `by` and the others follow.
    fn rise(&self, by: f64) -> Option<f64> {
        let inverse_k = &self.curvature.inverse[self.k];
        let parameters = self.problem.parameters();
        let inside = |j: usize, value: f64| {
            let (least, most) = parameters[j].bounds;
            value.clamp(least, most)
        };
        let mut probe: Vec<f64> = (0..self.values.len())
            .map(|j| self.values[j] + inverse_k[j] / inverse_k[self.k] * by)
            .enumerate()
            .map(|(j, value)| inside(j, value))
            .collect();
        if self.problem.is_traced() {
            return Some((sum_of(self.problem, &probe)? - self.least) / self.unit);
        }
        let residuals = |probe: &[f64]| {
            let readings = self.problem.simulate(probe, Effort::Full).ok()??;
            Some(self.problem.residuals(probe, &readings.values))
        };
        let at_probe = residuals(&probe)?;
        let mut least = squares(&at_probe);
        if let Some(step) = self.step_of_others(&at_probe) {
            for (j, by) in step {
                probe[j] = inside(j, probe[j] + by);
            }
            least = least.min(squares(&residuals(&probe)?));
        }
        Some((least - self.least) / self.unit)
    }

    /// The step of Gauss and Newton of the other parameters; nothing if there are none.
    fn step_of_others(&self, residuals: &[f64]) -> Option<Vec<(usize, f64)>> {
        let others: Vec<usize> = (0..self.values.len()).filter(|j| *j != self.k).collect();
        let columns = &self.curvature.columns;
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let row = |i: &usize| others.iter().map(|j| dot(&columns[*i], &columns[*j])).collect();
        let curvature: Vec<Vec<f64>> = others.iter().map(row).collect();
        let gradient: Vec<f64> = others.iter().map(|j| dot(&columns[*j], residuals)).collect();
        let inverse = inverse(&curvature).filter(|_| !others.is_empty())?;
        let steps = inverse.iter().map(|row| -dot(row, &gradient));
        Some(others.iter().copied().zip(steps).collect())
    }
}

/// The bottom of the valley and its sum of squares: a fit ends near it, a part of a standard error away, which would look
/// like a lopsided valley.
fn bottom(problem: &Problem<'_>, values: &[f64], curvature: &Curvature) -> Option<(Vec<f64>, f64)> {
    let here = squares(&curvature.residuals);
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let gradient: Vec<f64> =
        curvature.columns.iter().map(|column| dot(column, &curvature.residuals)).collect();
    let moved: Vec<f64> = problem
        .parameters()
        .iter()
        .zip(values)
        .zip(&curvature.inverse)
        .map(|((p, value), row)| (value - dot(row, &gradient)).clamp(p.bounds.0, p.bounds.1))
        .collect();
    let readings = problem.simulate(&moved, Effort::Full).ok()??;
    let there = squares(&problem.residuals(&moved, &readings.values));
    Some(if there < here { (moved, there) } else { (values.to_vec(), here) })
}

fn squares(residuals: &[f64]) -> f64 {
    residuals.iter().map(|r| r * r).sum()
}

/// The same without what the noise of rays adds.
fn squares_of_halves([a, b]: &[Vec<f64>; 2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The sum of squares under the rays of the fit, without what their noise adds.
fn sum_of(problem: &Problem<'_>, values: &[f64]) -> Option<f64> {
    let cost = problem.cost(values, Effort::Full).ok()??;
    Some(1e-4 * cost * problem.measured().len() as f64)
}

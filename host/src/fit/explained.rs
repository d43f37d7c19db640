//! What doubts about the instrument explain of the residuals of a fit.
//!
//! An instrument that is a little off leaves residuals with a shape. They are not noise: the budget counts the doubt already, and
//! noise that were estimated from them would count it again. With `D` the changes of the residuals by one standard deviation of
//! each doubt, less what the values of the fit take up, the most likely deviations are
//! `z = (D^T D / s^2 + 1)^-1 D^T r / s^2` for noise `s` \[Tarantola 2005, eq. 3.38\]; `r - D z` is left. Values and deviations
//! follow the noise of the readings that determine them, so what is left there is divided by `sqrt(1 - h)`, `h` their leverage
//! \[Mackinnon and White 1985, HC2\].

use super::budget::{Effect, change_by, moves};
use super::problem::Problem;
use super::uncertainty::Curvature;
use crate::linear::inverse;

/// Doubts that are looked at together at most; more have no share of the shape each.
const MOST: usize = 64;

/// The residuals without what the doubts explain.
pub(super) fn unexplained(
    problem: &Problem<'_>,
    curvature: &Curvature,
    simulated: &[f64],
    effects: &[Effect],
) -> Vec<f64> {
    let residuals = &curvature.residuals;
    let parts: Vec<&Vec<f64>> = effects.iter().flat_map(|effect| &effect.parts).collect();
    let variance = problem.noise().powi(2);
    if parts.is_empty() || parts.len() > MOST || !(variance > 0.0 && variance.is_finite()) {
        return residuals.clone();
    }
    let changes: Vec<Vec<f64>> =
        parts.iter().map(|part| beside_values(problem, curvature, simulated, part)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let row = |(i, a): (usize, &Vec<f64>)| {
        let entry = |(j, b): (usize, &Vec<f64>)| dot(a, b) / variance + f64::from(u8::from(i == j));
        changes.iter().enumerate().map(entry).collect::<Vec<f64>>()
    };
    let matrix: Vec<Vec<f64>> = changes.iter().enumerate().map(row).collect();
    let Some(solution) = inverse(&matrix) else { return residuals.clone() };
    let right: Vec<f64> = changes.iter().map(|change| dot(change, residuals) / variance).collect();
    let mut left = residuals.clone();
    for (row, change) in solution.iter().zip(&changes) {
        let deviation = dot(row, &right);
        left.iter_mut().zip(change).for_each(|(r, d)| *r -= deviation * d);
    }
    let of_values = leverage(&curvature.columns, &curvature.inverse);
    let of_doubts = leverage(&changes, &solution);
    for (r, (a, b)) in left.iter_mut().zip(of_values.iter().zip(&of_doubts)) {
        *r /= (1.0 - a - b / variance).max(0.1).sqrt();
    }
    left
}

/// The diagonal of `J M J^T`.
fn leverage(columns: &[Vec<f64>], matrix: &[Vec<f64>]) -> Vec<f64> {
    let count = columns.first().map_or(0, Vec::len);
    let at = |i: usize| {
        let row = |row: &Vec<f64>| row.iter().zip(columns).map(|(m, c)| m * c[i]).sum::<f64>();
        matrix.iter().zip(columns).map(|(r, c)| row(r) * c[i]).sum()
    };
    (0..count).map(at).collect()
}

/// The change of the residuals by a part of a doubt, after the values have followed it.
fn beside_values(
    problem: &Problem<'_>,
    curvature: &Curvature,
    simulated: &[f64],
    part: &[f64],
) -> Vec<f64> {
    let mut change = change_by(problem, simulated, part);
    for c in &mut change {
        *c = -*c;
    }
    change.resize(curvature.residuals.len(), 0.0);
    for (by, column) in moves(problem, curvature, simulated, part).iter().zip(&curvature.columns) {
        change.iter_mut().zip(column).for_each(|(c, j)| *c += by * j);
    }
    change
}

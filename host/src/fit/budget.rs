//! The budget of uncertainty of fitted values [JCGM 100:2008]: what each doubt about the instrument adds to the noise.
//!
//! A doubt of one standard deviation changes the readings by `d`; the values that a fit would then find move by
//! `-H^-1 J^T d` with the derivatives `J` of the residuals and the curvature `H` at the optimum. Doubts are independent: their
//! squares add.

use super::nuisance::{APERTURE, GAIN, GAIN_AT, SIGMA_ZERO, STRAY, THETA_ZERO};
use super::problem::Problem;
use super::uncertainty::Curvature;
use crate::forward::Effort;
use crate::method::Body;
use crate::model::Contribution;

/// Doubts about the instrument and the sample, standard deviations; `None` is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Doubts {
    /// Zero of theta and, independently, of sigma, degrees.
    pub offset_deg: Option<f64>,
    /// Factor of all readings, relative.
    pub gain: Option<f64>,
    /// Change of that factor along a line, from the first to the last reading of an incidence and, independently, of
    /// the scan, relative.
    pub drift: Option<f64>,
    /// Factor of each incidence, independently, relative.
    pub gains: Option<f64>,
    /// Light in every reading, as a share of the largest.
    pub stray: Option<f64>,
    /// Factor of the aperture, relative.
    pub aperture: Option<f64>,
    /// Refractive index.
    pub ior: Option<f64>,
}

/// How one doubt changes the readings, one standard deviation of each independent part.
#[derive(Clone, Debug)]
pub(super) struct Effect {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) std_dev: f64,
    /// Changes of the readings.
    pub(super) parts: Vec<Vec<f64>>,
}

impl Doubts {
    /// What the doubts do to readings at fitted values; those that the fit has as parameters are in its noise already.
    pub(super) fn effects(
        &self,
        problem: &Problem<'_>,
        values: &[f64],
        simulated: &[f64],
    ) -> Vec<Effect> {
        let fitted = |name: &str| problem.parameters().iter().any(|p| p.name == name);
        let moved = |change: &dyn Fn(Problem<'_>) -> Problem<'_>| {
            let readings = change(problem.clone()).simulate(values, Effort::Full).ok()??;
            Some(readings.values.iter().zip(simulated).map(|(a, b)| a - b).collect::<Vec<f64>>())
        };
        let lines = Lines::of(problem, simulated);
        let largest = problem.largest();
        let mut found = Vec::new();
        let mut add = |name, unit, std_dev, parts: Vec<Vec<f64>>| {
            if !parts.is_empty() {
                found.push(Effect { name, unit, std_dev, parts });
            }
        };
        if let Some(by) = self.offset_deg {
            if !fitted(THETA_ZERO) {
                let part = moved(&|p| p.turned(by, 0.0));
                add("zero of theta", "deg", by, part.into_iter().collect());
            }
            if !fitted(SIGMA_ZERO) {
                let part = moved(&|p| p.turned(0.0, by));
                add("zero of sigma", "deg", by, part.into_iter().collect());
            }
        }
        let is_free = problem.has_free_levels();
        if let Some(by) = self.gain.filter(|_| !is_free && (!fitted(GAIN) || is_opaque(problem))) {
            add("gain", "", by, vec![simulated.iter().map(|s| by * s).collect()]);
        }
        if let Some(by) = self.gains.filter(|_| !is_free && !has_gains(problem)) {
            add("gain of an incidence", "", by, lines.levels(by));
        }
        if let Some(by) = self.drift {
            add("drift", "", by, lines.drifts(by));
        }
        if let Some(by) = self.stray.filter(|_| !fitted(STRAY)) {
            add("stray light", "", by, vec![vec![by * largest; simulated.len()]]);
        }
        if let Some(by) = self.aperture.filter(|_| !fitted(APERTURE)) {
            let part = moved(&|p| p.opened(1.0 + by));
            add("aperture", "", by, part.into_iter().collect());
        }
        if let Some(by) = self.ior.filter(|_| !fitted("ior")) {
            let part = match problem.body() {
                Body::Dielectric { ior } => moved(&|p| p.with_ior(ior + by)),
                Body::Opaque | Body::Sheet { .. } => None,
            };
            add("index", "", by, part.into_iter().collect());
        }
        found
    }
}

fn has_gains(problem: &Problem<'_>) -> bool {
    problem.parameters().iter().any(|p| p.name.starts_with(GAIN_AT))
}

/// The gain of an opaque body is that of its law, and a doubt about the instrument's is not in its noise.
fn is_opaque(problem: &Problem<'_>) -> bool {
    matches!(problem.body(), Body::Opaque)
}

/// The readings of each incidence, in their order.
struct Lines<'a> {
    simulated: &'a [f64],
    ranges: Vec<std::ops::Range<usize>>,
}

impl<'a> Lines<'a> {
    fn of(problem: &Problem<'_>, simulated: &'a [f64]) -> Self {
        let mut from = 0;
        let range = |planes: &[crate::forward::Incidence]| {
            let count: usize = planes.iter().map(|plane| plane.theta_deg.len()).sum();
            from += count;
            from - count..from
        };
        Self { simulated, ranges: problem.angles().by_incidence().into_iter().map(range).collect() }
    }

    fn part(&self, factor: impl Fn(usize) -> f64) -> Vec<f64> {
        self.simulated.iter().enumerate().map(|(k, s)| s * factor(k)).collect()
    }

    /// A factor of each incidence alone.
    fn levels(&self, by: f64) -> Vec<Vec<f64>> {
        let of = |range: &std::ops::Range<usize>| {
            self.part(|k| if range.contains(&k) { by } else { 0.0 })
        };
        self.ranges.iter().map(of).collect()
    }

    /// A line along each incidence alone, and one along all.
    fn drifts(&self, by: f64) -> Vec<Vec<f64>> {
        let along = |range: &std::ops::Range<usize>| {
            let steps = range.len().saturating_sub(1).max(1) as f64;
            self.part(|k| {
                let place = (k as f64 - range.start as f64) / steps - 0.5;
                if range.contains(&k) { by * place } else { 0.0 }
            })
        };
        let whole = 0..self.simulated.len();
        let single = if self.ranges.len() > 1 { &self.ranges[..] } else { &[] };
        single.iter().chain(std::iter::once(&whole)).map(along).collect()
    }
}

/// The standard uncertainties that the doubts add to each value, one row a doubt; `moved` are the moves of the values by each
/// part of each effect.
pub(super) fn contributions(
    problem: &Problem<'_>,
    effects: &[Effect],
    moved: &[Vec<Vec<f64>>],
) -> Vec<Contribution> {
    let row = |(effect, parts): (&Effect, &Vec<Vec<f64>>)| {
        let added = |k: usize| parts.iter().map(|part| part[k] * part[k]).sum::<f64>().sqrt();
        let parameters = problem.parameters().iter().enumerate();
        Contribution {
            source: effect.name.into(),
            std_dev: effect.std_dev,
            unit: effect.unit.into(),
            effects: parameters.map(|(k, p)| (p.name.to_owned(), added(k))).collect(),
        }
    };
    effects.iter().zip(moved).map(row).collect()
}

/// The negative of what the residuals change by where the law is held and the readings move by a part.
pub(super) fn change_by(problem: &Problem<'_>, simulated: &[f64], part: &[f64]) -> Vec<f64> {
    let after: Vec<f64> = simulated.iter().zip(part).map(|(s, d)| s + d).collect();
    problem.residual_change(simulated, &after)
}

/// How far the fitted values move where the instrument has changed the readings by a part.
pub(super) fn moves(
    problem: &Problem<'_>,
    curvature: &Curvature,
    simulated: &[f64],
    part: &[f64],
) -> Vec<f64> {
    let change = change_by(problem, simulated, part);
    let dot = |column: &[f64]| -> f64 { column.iter().zip(&change).map(|(a, b)| a * b).sum() };
    let scores: Vec<f64> = curvature.columns.iter().map(|column| dot(column)).collect();
    let of = |row: &Vec<f64>| row.iter().zip(&scores).map(|(h, s)| h * s).sum();
    curvature.inverse.iter().map(of).collect()
}

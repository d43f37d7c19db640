//! What was written, read back and compared with the law.

use std::f64::consts::FRAC_PI_2;

use rayon::prelude::*;
use serde::Serialize;

use crate::law::Law;
use crate::sampled::{Incidence, Nodes, SampledBsdf};

/// One incidence of a file beside the law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Rotation of the sample, degrees.
    pub rotation_deg: f64,
    /// Number of directions.
    pub nodes: usize,
    /// Largest distance of a value at a node from the law, percent of the peak.
    pub node_error_percent: f64,
    /// Flux of the law.
    pub flux_law: f64,
    /// Flux of the file as its reader interpolates it.
    pub flux_file: f64,
    /// Flux that the file states, if it does.
    pub flux_stated: Option<f64>,
    /// Largest value of the law, 1/sr.
    pub peak_law: f64,
    /// Largest value of the file, 1/sr.
    pub peak_file: f64,
}

impl Row {
    /// Relative error of the flux, percent.
    pub fn flux_percent(&self) -> f64 {
        percent(self.flux_file, self.flux_law)
    }

    /// Relative error of the peak, percent.
    pub fn peak_percent(&self) -> f64 {
        percent(self.peak_file, self.peak_law)
    }
}

fn percent(is: f64, ought: f64) -> f64 {
    if is.to_bits() == ought.to_bits() { 0.0 } else { 100.0 * (is / ought - 1.0) }
}

/// Compares every incidence of a file with the law.
pub fn compare(file: &SampledBsdf, law: &dyn Law) -> Vec<Row> {
    let all = file.incidences.par_iter().enumerate();
    all.map(|(k, incidence)| row(file, k, incidence, law)).collect()
}

fn row(file: &SampledBsdf, k: usize, incidence: &Incidence, law: &dyn Law) -> Row {
    let from = [incidence.theta, incidence.phi];
    let directions = incidence.nodes.directions();
    let (mut peak_law, mut peak_file, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (at, value) in directions.iter().zip(file.band(k, 0)) {
        if at[0] > FRAC_PI_2 - 1e-8 {
            continue; // at and below the horizon a file may hold what it likes
        }
        let is = law.value(from, *at);
        peak_law = peak_law.max(is);
        peak_file = peak_file.max(*value);
        worst = worst.max((is - value).abs());
    }
    let flux_law = match (&incidence.nodes, law.flux(from)) {
        (_, Some(flux)) => flux,
        (Nodes::Grid(grid), None) => {
            for cell in grid.cells() {
                let middle = [
                    f64::midpoint(cell.radii[0], cell.radii[1]),
                    f64::midpoint(cell.azimuths[0], cell.azimuths[1]),
                ];
                let out = grid.frame.absolute(middle);
                if out[0] < FRAC_PI_2 {
                    peak_law = peak_law.max(law.value(from, out));
                    peak_file = peak_file.max(incidence.value(0, out, file.interpolation));
                }
            }
            grid.integral(&|_, out| law.value(from, out).max(0.0))
        }
        (_, None) => f64::NAN,
    };
    Row {
        incidence_deg: incidence.theta.to_degrees(),
        rotation_deg: incidence.phi.to_degrees(),
        nodes: directions.len(),
        node_error_percent: if peak_law > 0.0 { 100.0 * worst / peak_law } else { 0.0 },
        flux_law,
        flux_file: file.flux(k, 0),
        flux_stated: incidence.stated.first().copied(),
        peak_law,
        peak_file,
    }
}

//! What was written, read back and compared with the law.

use std::f64::consts::FRAC_PI_2;

use rayon::prelude::*;
use serde::Serialize;

use crate::hemisphere;
use crate::law::{Capped, Law};
use crate::sampled::{Incidence, Nodes, SampledBsdf, Symmetry};

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

/// Compares every incidence of a file with the grid it was made of, value by value, and with the law, flux and peak.
pub fn compare(file: &SampledBsdf, made: &SampledBsdf, law: &dyn Law) -> Vec<Row> {
    let all = file.incidences.par_iter().enumerate();
    all.map(|(k, incidence)| row(file, (k, incidence), made, law)).collect()
}

fn row(
    file: &SampledBsdf,
    (k, incidence): (usize, &Incidence),
    made: &SampledBsdf,
    law: &dyn Law,
) -> Row {
    let (raw, law) = (law, &Capped(law));
    let from = [incidence.theta, incidence.phi];
    let directions = incidence.nodes.directions();
    let over = |at: &[f64; 2]| at[0] < FRAC_PI_2 - 1e-8; // at and below the horizon a file may hold what it likes
    let mut peaks = Peaks::default();
    let before = made.incidences.get(k).filter(|i| i.nodes.len() == directions.len());
    let mut worst = if before.is_some() { 0.0_f64 } else { f64::NAN };
    for (j, (at, value)) in directions.iter().zip(file.band(k, 0)).enumerate() {
        if !over(at) {
            continue;
        }
        let is = if law.has_grain() || before.is_none() { *value } else { law.value(from, *at) };
        peaks.add(is, *value);
        // the order of nodes is the file's; a grid of the same directions has them in the same order
        let ought =
            made.incidences.get(k).and_then(|i| i.values.get(j)).copied().unwrap_or(f64::NAN);
        worst = worst.max((ought - value).abs());
    }
    if let (Nodes::Grid(grid), false) = (&incidence.nodes, law.has_grain()) {
        for cell in grid.cells() {
            let out = grid.frame.absolute(cell.middle());
            if over(&out) {
                peaks.add(law.value(from, out), incidence.value(0, out, file.interpolation));
            }
        }
    }
    Row {
        incidence_deg: degrees(incidence.theta),
        rotation_deg: degrees(incidence.phi),
        nodes: directions.len(),
        node_error_percent: if peaks.law > 0.0 { 100.0 * worst / peaks.law } else { 0.0 },
        flux_law: law_flux(raw, file, from),
        flux_file: file.flux(k, 0),
        flux_stated: incidence.stated.first().copied(),
        peak_law: peaks.law,
        peak_file: peaks.file,
    }
}

/// Largest values over the same directions.
#[derive(Clone, Copy, Debug, Default)]
struct Peaks {
    law: f64,
    file: f64,
}

impl Peaks {
    fn add(&mut self, law: f64, file: f64) {
        self.law = self.law.max(law);
        self.file = self.file.max(file);
    }
}

/// Degrees without the digits that only their conversion made.
fn degrees(radians: f64) -> f64 {
    (radians.to_degrees() * 1e9).round() / 1e9
}

/// Flux of a law: what it knows, else by cubature.
fn law_flux(law: &dyn Law, file: &SampledBsdf, from: [f64; 2]) -> f64 {
    let mirrored = file.symmetry == Symmetry::Isotropic;
    law.flux(from).unwrap_or_else(|| hemisphere::flux(law, from, file.specular(from[0]), mirrored))
}

//! Readings by quadrature: no noise, and smooth in the parameters.

use std::f64::consts::FRAC_PI_2;

use asperity_core::bsdf::Bsdf;
use asperity_core::gonio::{Geometry, observation};
use rayon::prelude::*;

use super::aperture::{Integral, Warp, lines};
use super::internal::passes;
use super::optics::{Entry, View, enter, look};
use super::{Incidence, Plan, Sample, Setup, solid_angle};
use crate::measurement::Quantity;

/// Readings of a scan, in the order of its plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The readings.
    pub values: Vec<f64>,
    /// Flux left inside the plate where the internal passes were cut off, as a fraction of the beam's:
    /// the largest over the incidences. No reading can be short of more.
    pub neglected: f64,
}

/// Simulates a scan of `boundary` in a `setup`.
///
/// First hit of the rough face: integrated over each detector's cone in closed form along one
/// coordinate. Internal passes: a fixed low-discrepancy rule, until less than 1e-5 of the beam is left.
pub fn quadrature<B: Bsdf<f64> + Sync>(boundary: &B, setup: &Setup, plan: &Plan) -> Readings {
    let parts: Vec<(Vec<f64>, f64)> = plan
        .incidences
        .par_iter()
        .map(|incidence| one_incidence(boundary, setup, incidence))
        .collect();
    Readings {
        neglected: parts.iter().map(|p| p.1).fold(0.0, f64::max),
        values: parts.into_iter().flat_map(|p| p.0).collect(),
    }
}

fn one_incidence<B: Bsdf<f64>>(
    boundary: &B,
    setup: &Setup,
    incidence: &Incidence,
) -> (Vec<f64>, f64) {
    let sigma = incidence.sigma_deg.to_radians();
    let entry = enter(setup, sigma);
    let scale = lobe_width(boundary.slope(), setup);
    let half_angle = 0.5 * setup.aperture_deg.to_radians();
    if setup.quantity == Quantity::Bsdf && half_angle <= 0.0 {
        return point_values(boundary, setup, &entry, incidence, scale);
    }

    let warp = Warp::new(sigma, scale);
    let lines = lines(half_angle, scale);
    // A lobe wider than the cone looks the same on all lines for what was scattered twice.
    let wide = lines.len() == 2;
    let mut values = vec![0.0; incidence.theta_deg.len()];
    let mut neglected = 0.0_f64;
    let mut inner = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        if k == 0 || !wide {
            (inner, neglected) = internal_density(boundary, setup, &entry, &warp, line.psi);
        }
        let density: Vec<f64> = (0..=2 * warp.cells())
            .zip(&inner)
            .map(|(half, inner)| {
                let (theta, slope) = warp.node(half);
                (first_hit(boundary, setup, &entry, theta, line.psi) + inner) * slope
            })
            .collect();
        let integral = Integral::new(&warp, &density);
        for (value, theta) in values.iter_mut().zip(&incidence.theta_deg) {
            *value += integral.reading(&warp, line, theta.to_radians());
        }
    }
    for (value, theta) in values.iter_mut().zip(&incidence.theta_deg) {
        // The beam mirrored by a smooth front face is narrower than any cone.
        if entry.mirrored > 0.0 && (theta.to_radians() - sigma).abs() <= half_angle {
            *value += entry.mirrored;
        }
        if setup.quantity == Quantity::Bsdf {
            let cosine = theta.to_radians().cos();
            *value = if cosine > 1e-9 {
                *value / (solid_angle(setup.aperture_deg) * cosine)
            } else {
                0.0
            };
        }
    }
    (values, neglected)
}

/// Angular half width of the lobe outside the plate, rad: a scale for the warp, not a result.
fn lobe_width(slope: f64, setup: &Setup) -> f64 {
    let gain = match (setup.geometry, setup.sample) {
        (Geometry::Transmission, Sample::Plate { eta, .. }) => (eta.get() - 1.0).abs(),
        _ => 2.0,
    };
    (slope * gain).clamp(1e-8, 0.5)
}

fn view(setup: &Setup, theta: f64, psi: f64) -> Option<View> {
    look(setup, observation(setup.geometry, theta, psi))
}

/// Flux per solid angle after one hit of the rough face.
fn first_hit<B: Bsdf<f64>>(
    boundary: &B,
    setup: &Setup,
    entry: &Entry,
    theta: f64,
    psi: f64,
) -> f64 {
    // The horizon itself receives nothing, and is where rounding decides the side.
    if FRAC_PI_2 - theta.abs() < 1e-9 {
        return 0.0;
    }
    view(setup, theta, psi)
        .map_or(0.0, |v| entry.flux * v.factor * boundary.ars(entry.w, v.towards))
}

/// Internal passes on a line: computed at every fourth cell, a cubic between.
fn internal_density<B: Bsdf<f64>>(
    boundary: &B,
    setup: &Setup,
    entry: &Entry,
    warp: &Warp,
    psi: f64,
) -> (Vec<f64>, f64) {
    let fine = 2 * warp.cells() + 1;
    let Sample::Plate { eta, .. } = setup.sample else {
        return (vec![0.0; fine], 0.0);
    };
    const STRIDE: usize = 8; // half cells
    let views: Vec<Option<View>> = (0..fine)
        .step_by(STRIDE)
        .map(|half| {
            let theta = warp.node(half).0;
            if FRAC_PI_2 - theta.abs() < 1e-9 { None } else { view(setup, theta, psi) }
        })
        .collect();
    let found = passes(boundary, eta.get(), entry, &views);
    let at = |k: isize| {
        let last = found.density.len() as isize - 1;
        found.density[k.clamp(0, last) as usize]
    };
    let values = (0..fine)
        .map(|half| {
            let (k, t) = ((half / STRIDE) as isize, (half % STRIDE) as f64 / STRIDE as f64);
            let [a, b, c, d] = [at(k - 1), at(k), at(k + 1), at(k + 2)];
            // Catmull-Rom, kept from undershooting zero
            let cubic = b
                + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
            cubic.max(0.0)
        })
        .collect();
    (values, found.neglected)
}

/// The BSDF at single directions: `ars / cos` without a detector.
fn point_values<B: Bsdf<f64>>(
    boundary: &B,
    setup: &Setup,
    entry: &Entry,
    incidence: &Incidence,
    scale: f64,
) -> (Vec<f64>, f64) {
    let warp = Warp::new(incidence.sigma_deg.to_radians(), scale);
    let opaque = setup.sample == Sample::Opaque;
    let (inner, neglected) = if opaque {
        (Vec::new(), 0.0)
    } else {
        internal_density(boundary, setup, entry, &warp, 0.0)
    };
    let values = incidence
        .theta_deg
        .iter()
        .map(|theta| {
            let theta = theta.to_radians();
            let cosine = theta.cos();
            if cosine < 1e-9 {
                return 0.0;
            }
            let first = first_hit(boundary, setup, entry, theta, 0.0);
            (first + if opaque { 0.0 } else { warp.interpolate(&inner, theta) }) / cosine
        })
        .collect();
    (values, neglected)
}

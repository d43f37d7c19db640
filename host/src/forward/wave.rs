//! Readings of a height map that scatters waves: diffuse light, coherent light, internal passes.
//!
//! Averaged readings integrate the mean law over the detector's cones, as any law, and add the coherent beams. Kept
//! ones count the orders of this very map whose directions fall into the cones. Between its faces the plate is
//! thick: intensities add, and what meets the rough face again follows the mean law.

use std::sync::atomic::{AtomicBool, Ordering};

use asperity_core::bsdf::{Lobe, Smooth};
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::gonio::{Geometry, Goniophotometer, incidence};
use asperity_core::plate::RoughSide;
use rayon::prelude::*;

use super::optics::{Entry, enter, look};
use super::{Effort, Incidence, Plan, Readings, Sample, Setup, quadrature, solid_angle};
use crate::kirchhoff::{Beam, BeamOrders, Speckle, Tiling, WaveBoundary, orders};
use crate::measurement::Quantity;

/// Simulates a scan; `None` if `stop` was set before the end. `progress(done, all)` counts transforms.
pub fn wave(
    boundary: &WaveBoundary,
    setup: &Setup,
    plan: &Plan,
    effort: Effort,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Option<Readings> {
    match boundary.speckle() {
        Speckle::Averaged => Some(averaged(boundary, setup, plan, effort)),
        Speckle::Kept | Speckle::Patch => kept(boundary, setup, plan, effort, stop, progress),
    }
}

fn averaged(boundary: &WaveBoundary, setup: &Setup, plan: &Plan, effort: Effort) -> Readings {
    let mut readings = quadrature(boundary, setup, plan, effort);
    let mut std_errors = Vec::with_capacity(readings.values.len());
    let mut from = 0;
    for angles in &plan.incidences {
        let values = &mut readings.values[from..from + angles.theta_deg.len()];
        from += angles.theta_deg.len();
        let one = Beams::new(boundary, setup, angles);
        let error = |(value, theta): (&f64, &f64)| value * one.speckle(*theta);
        std_errors.extend(values.iter().zip(&angles.theta_deg).map(error));
        one.add_coherent(values, Hits::All);
    }
    readings.std_errors = Some(std_errors);
    readings
}

fn kept(
    boundary: &WaveBoundary,
    setup: &Setup,
    plan: &Plan,
    effort: Effort,
    stop: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Option<Readings> {
    let mut readings = match effort {
        Effort::Draft => Readings {
            values: vec![0.0; plan.len()],
            neglected: super::Neglected::default(),
            std_errors: None,
        },
        Effort::Full | Effort::Passes => quadrature(boundary, setup, plan, Effort::Passes),
    };
    let all: Vec<Beams<'_>> =
        plan.incidences.iter().map(|angles| Beams::new(boundary, setup, angles)).collect();
    let beams: Vec<Beam> = all.iter().flat_map(Beams::first).collect();
    let found = orders(boundary.map(), boundary.tiling(), boundary.eta(), &beams, stop, progress);
    // the map of a boundary is complete
    let found = found.ok().flatten()?;
    let wavelengths: Vec<f64> = boundary.wavelengths().iter().map(|w| w.1).collect();
    let parts: Vec<(Vec<f64>, Vec<f64>)> = all
        .par_iter()
        .zip(found.par_chunks(wavelengths.len()))
        .map(|(one, orders)| one.received(orders, &wavelengths))
        .collect();
    if stop.load(Ordering::Relaxed) {
        return None;
    }
    let (mut from, mut std_errors) = (0, Vec::with_capacity(readings.values.len()));
    for (one, (values, errors)) in all.iter().zip(parts) {
        let mine = &mut readings.values[from..from + values.len()];
        from += values.len();
        for (sum, value) in mine.iter_mut().zip(values) {
            *sum += value;
        }
        std_errors.extend(errors);
        if effort != Effort::Draft {
            one.add_coherent(mine, Hits::Later);
        }
    }
    readings.std_errors = Some(std_errors);
    Some(readings)
}

/// Which coherent beams are meant: all that leave, or those that met the rough face more than once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hits {
    All,
    Later,
}

/// The light of one incidence.
struct Beams<'a> {
    boundary: &'a WaveBoundary,
    setup: &'a Setup,
    angles: &'a Incidence,
    entry: Entry,
    sigma: f64,
}

impl<'a> Beams<'a> {
    fn new(boundary: &'a WaveBoundary, setup: &'a Setup, angles: &'a Incidence) -> Self {
        let sigma = angles.sigma_deg.to_radians();
        Self { boundary, setup, angles, entry: enter(setup, sigma), sigma }
    }

    /// What the rough face sends towards the detector's side at once, one beam a wavelength.
    fn first(&self) -> Vec<Beam> {
        let lobe = match self.setup.geometry {
            Geometry::Transmission => Lobe::Transmission,
            Geometry::Reflection => Lobe::Reflection,
        };
        let wi = self.entry.w;
        let beam = |(wavelength_um, _)| Beam { wi, lobe, wavelength_um };
        self.boundary.wavelengths().iter().map(beam).collect()
    }

    /// Relative standard error of a reading of diffuse light.
    fn speckle(&self, theta_deg: f64) -> f64 {
        let (s, c) = theta_deg.to_radians().sin_cos();
        let z = if self.setup.geometry == Geometry::Transmission { -c } else { c };
        let towards = look(self.setup, Direction::from_unit(s, 0.0, z)).map(|v| v.towards);
        let n = self.boundary.eta().get();
        let outside = self.setup.aperture_deg.to_radians() * c;
        towards.map_or(0.0, |wo| {
            let sines = if wo.z() > 0.0 { outside } else { outside / n };
            self.boundary.speckle_error(self.entry.w, wo, sines)
        })
    }

    /// Adds the coherent beams, which leave in the direction of the undeviated or the mirrored beam.
    fn add_coherent(&self, values: &mut [f64], hits: Hits) {
        let half = 0.5 * self.setup.aperture_deg.to_radians();
        if half <= 0.0 {
            return;
        }
        let flux = self.coherent(hits);
        for (value, theta_deg) in values.iter_mut().zip(&self.angles.theta_deg) {
            let theta = theta_deg.to_radians();
            if (theta - self.sigma).abs() <= half * (1.0 + 1e-9) {
                *value += flux * self.unit(theta);
            }
        }
    }

    /// Flux of all coherent beams: the series of reflections between both faces.
    fn coherent(&self, hits: Hits) -> f64 {
        let Sample::Plate { eta, rough_side } = self.setup.sample else { return 0.0 };
        let smooth = Smooth { eta };
        let outside = incidence(self.sigma);
        let Some(inside) = smooth.refract(outside) else { return 0.0 };
        let [x, y, z] = inside.xyz();
        let inside = Direction::from_unit(-x, -y, z);
        let f = smooth.fresnel(outside);
        let (r_s, t_s) = (f.reflected, f.transmitted);
        let mut sum = 0.0;
        for (wavelength_um, weight) in self.boundary.wavelengths().iter() {
            let above = self.boundary.coherent_at(outside, wavelength_um);
            let below = self.boundary.coherent_at(inside, wavelength_um);
            let series = 1.0 / (1.0 - r_s * below.reflected).max(1e-12);
            let (once, all) = match (self.setup.geometry, rough_side) {
                (Geometry::Transmission, RoughSide::Source) => {
                    (above.transmitted * t_s, above.transmitted * t_s * series)
                }
                (Geometry::Transmission, RoughSide::Detector) => {
                    (below.transmitted * t_s, below.transmitted * t_s * series)
                }
                (Geometry::Reflection, RoughSide::Source) => {
                    let back = above.transmitted * r_s * below.transmitted * series;
                    (above.reflected, above.reflected + back)
                }
                (Geometry::Reflection, RoughSide::Detector) => {
                    let once = t_s * below.reflected * t_s;
                    (once, once * series)
                }
            };
            sum += weight * if hits == Hits::All { all } else { all - once };
        }
        sum
    }

    /// From relative flux in the aperture to what the setup reads; 0 where the cosine vanishes.
    fn unit(&self, theta: f64) -> f64 {
        match self.setup.quantity {
            Quantity::Flux => 1.0,
            Quantity::Bsdf => {
                let cosine = theta.cos();
                let solid_angle = solid_angle(self.setup.aperture_deg);
                if cosine > 1e-9 { 1.0 / (solid_angle * cosine) } else { 0.0 }
            }
        }
    }

    /// Where an order leaves the plate, and the share of it that does.
    fn out(&self, wo: Direction<f64>) -> Option<(Direction<f64>, f64)> {
        let Sample::Plate { eta, rough_side } = self.setup.sample else { return Some((wo, 1.0)) };
        let wo = if rough_side == RoughSide::Source { wo } else { wo.turned_over() };
        let straight =
            (self.setup.geometry == Geometry::Reflection) == (rough_side == RoughSide::Source);
        if straight {
            return Some((wo, 1.0));
        }
        let ([x, y, z], n) = (wo.xyz(), eta.get());
        let (x, y) = (n * x, n * y);
        let cos2 = 1.0 - x * x - y * y;
        let cos = (cos2 > 0.0).then(|| cos2.sqrt())?;
        let share = fresnel::dielectric(cos, n).transmitted;
        Some((Direction::from_unit(x, y, cos.copysign(z)), share))
    }

    /// Readings of the orders that leave at once, and the standard errors of their speckle.
    fn received(&self, orders: &[BeamOrders], weights: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let theta = &self.angles.theta_deg[..];
        let Setup { aperture_deg, geometry, .. } = *self.setup;
        let cone = Goniophotometer { aperture_deg, geometry }.cone();
        // four orders of a patch are as good as one, and its coherent light is in several
        let (alike, spread) =
            if self.boundary.tiling() == Tiling::Patch { (4.0, 2) } else { (1.0, 0) };
        // where a sum begins to hold an order, and where it ceases to
        let mut changes = vec![[0.0; 2]; theta.len() + 1];
        for (beam, weight) in orders.iter().zip(weights) {
            for order in beam.iter() {
                let Some((wo, share)) = self.out(order.wo) else { continue };
                let Some((from, to)) = cone.angles(wo) else { continue };
                let first = theta.partition_point(|t| *t < from);
                let end = theta.partition_point(|t| *t <= to);
                if first < end {
                    let shadow = self.boundary.unshadowed(self.entry.w, order.wo);
                    let flux = self.entry.flux * weight * order.power * share * shadow;
                    let coherent = order.number.iter().all(|n| n.abs() <= spread);
                    let square = if coherent { 0.0 } else { alike * flux * flux };
                    for (k, sign) in [(first, 1.0), (end, -1.0)] {
                        changes[k][0] += sign * flux;
                        changes[k][1] += sign * square;
                    }
                }
            }
        }
        let mut sum = [0.0; 2];
        let mut readings = (Vec::with_capacity(theta.len()), Vec::with_capacity(theta.len()));
        for ([flux, square], theta_deg) in changes.iter().zip(theta) {
            sum[0] += flux;
            sum[1] += square;
            let unit = self.unit(theta_deg.to_radians());
            // differences of sums may undershoot zero
            readings.0.push(sum[0].max(0.0) * unit);
            readings.1.push(sum[1].max(0.0).sqrt() * unit);
        }
        readings
    }
}

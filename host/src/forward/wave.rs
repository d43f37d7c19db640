//! Readings of a height map that scatters waves: diffuse light, coherent light, internal passes.
//!
//! Averaged readings integrate the mean law over the detector's cones, as any law, and add the coherent beams. Kept
//! ones count the orders of this very map whose directions fall into the cones. Between its faces the plate is
//! thick: intensities add, and what meets the rough face again follows the mean law.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::gonio::{Geometry, Goniophotometer};
use asperity_core::plate::RoughSide;
use rayon::prelude::*;

use super::coherent::{self, Hits};
use super::optics::{Entry, enter, look};
use super::{Angles, Effort, Incidence, Readings, Sample, Setup, quadrature};
use crate::kirchhoff::{Beam, BeamOrders, Speckle, Tiling, WaveBoundary, orders};
use crate::watch::Watch;

/// Simulates a scan; `None` if it was stopped before the end. `watch` is told the transforms done.
pub fn wave(
    boundary: &WaveBoundary,
    setup: &Setup,
    plan: &Angles,
    effort: Effort,
    watch: Watch<'_>,
) -> Option<Readings> {
    match boundary.speckle() {
        Speckle::Averaged => Some(averaged(boundary, setup, plan, effort)),
        Speckle::Kept | Speckle::Patch => kept(boundary, setup, plan, effort, watch),
    }
}

fn averaged(boundary: &WaveBoundary, setup: &Setup, plan: &Angles, effort: Effort) -> Readings {
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
    plan: &Angles,
    effort: Effort,
    watch: Watch<'_>,
) -> Option<Readings> {
    let mut readings = if effort.has_passes() {
        quadrature(boundary, setup, plan, Effort::Passes)
    } else {
        Readings {
            values: vec![0.0; plan.len()],
            neglected: super::Neglected::default(),
            std_errors: None,
            halves: None,
        }
    };
    let all: Vec<Beams<'_>> =
        plan.incidences.iter().map(|angles| Beams::new(boundary, setup, angles)).collect();
    let beams: Vec<Beam> = all.iter().flat_map(Beams::first).collect();
    let found = orders(boundary.map(), boundary.tiling(), boundary.eta(), &beams, watch);
    // the map of a boundary is complete
    let found = found.ok().flatten()?;
    let wavelengths: Vec<f64> = boundary.wavelengths().iter().map(|w| w.1).collect();
    let parts: Vec<(Vec<f64>, Vec<f64>)> = all
        .par_iter()
        .zip(found.par_chunks(wavelengths.len()))
        .map(|(one, orders)| one.received(orders, &wavelengths))
        .collect();
    if watch.is_stopped() {
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
        if effort.has_passes() {
            one.add_coherent(mine, Hits::Later);
        }
    }
    readings.std_errors = Some(std_errors);
    Some(readings)
}

/// The light of one incidence.
struct Beams<'a> {
    boundary: &'a WaveBoundary,
    setup: &'a Setup,
    angles: &'a Incidence,
    entry: Entry,
}

impl<'a> Beams<'a> {
    fn new(boundary: &'a WaveBoundary, setup: &'a Setup, angles: &'a Incidence) -> Self {
        Self { boundary, setup, angles, entry: enter(setup, angles.sigma_deg.to_radians()) }
    }

    /// The light that the rough face sends directly to the detector's side, one beam per wavelength.
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
        let wo = self.angles.turned(Direction::from_unit(s, 0.0, z));
        let towards = look(self.setup, wo).map(|v| v.towards);
        let n = self.boundary.eta().get();
        let outside = self.setup.aperture_deg.to_radians() * c;
        towards.map_or(0.0, |wo| {
            let sines = if wo.z() > 0.0 { outside } else { outside / n };
            self.boundary.speckle_error(self.entry.w, wo, sines)
        })
    }

    /// Adds the coherent beams.
    fn add_coherent(&self, values: &mut [f64], hits: Hits) {
        let one = |(wavelength_um, weight)| {
            let at = |wi| self.boundary.coherent_at(wi, wavelength_um);
            weight * coherent::flux(self.setup, self.angles.sigma_deg.to_radians(), hits, at)
        };
        let flux = self.boundary.wavelengths().iter().map(one).sum();
        coherent::add(self.setup, self.angles, values, flux);
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
                let wo = self.angles.turned_back(wo);
                let Some((from, to)) = cone.angles(wo) else { continue };
                let first = theta.partition_point(|t| *t < from);
                let end = theta.partition_point(|t| *t <= to);
                if first < end {
                    let power = self.boundary.shadowed(beam.beam(), &order);
                    let flux = self.entry.flux * weight * power * share;
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
            let unit = coherent::unit(self.setup, theta_deg.to_radians());
            // differences of sums may undershoot zero
            readings.0.push(sum[0].max(0.0) * unit);
            readings.1.push(sum[1].max(0.0).sqrt() * unit);
        }
        readings
    }
}

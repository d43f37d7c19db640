//! Coherent light in readings: what keeps its direction at the rough face leaves the plate as a beam.
//!
//! Beams are of light that keeps its direction at every hit; what is scattered at one of them is in [`super::returns`].

use asperity_core::bsdf::Smooth;
use asperity_core::direction::Direction;
use asperity_core::gonio::{Geometry, incidence};
use asperity_core::plate::RoughSide;

use super::{Angles, Incidence, Sample, Setup, solid_angle};
use crate::kirchhoff::CoherentFlux;
use crate::measurement::Quantity;

/// Which coherent beams are meant: all that leave, or those that met the rough face more than once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hits {
    All,
    Later,
}

/// Flux of all coherent beams of an incidence in radians: the series of reflections between both faces. `coherent` is what
/// the rough face keeps of the light from a direction.
pub(super) fn flux(
    setup: &Setup,
    sigma: f64,
    hits: Hits,
    coherent: impl Fn(Direction<f64>) -> CoherentFlux,
) -> f64 {
    let Sample::Plate { eta, rough_side } = setup.sample else { return 0.0 };
    let smooth = Smooth { eta };
    let outside = incidence(sigma);
    let Some(inside) = smooth.refract(outside) else { return 0.0 };
    let [x, y, z] = inside.xyz();
    let inside = Direction::from_unit(-x, -y, z);
    let f = smooth.fresnel(outside);
    let (r_s, t_s) = (f.reflected, f.transmitted);
    let (above, below) = (coherent(outside), coherent(inside));
    let series = 1.0 / (1.0 - r_s * below.reflected).max(1e-12);
    let (once, all) = match (setup.geometry, rough_side) {
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
    if hits == Hits::All { all } else { all - once }
}

/// Adds beams of that flux, which leave in the direction of the undeviated or the mirrored beam, to the readings of an incidence.
pub(super) fn add(setup: &Setup, angles: &Incidence, values: &mut [f64], flux: f64) {
    let half = 0.5 * setup.aperture_deg.to_radians();
    if half <= 0.0 {
        return;
    }
    for (value, theta_deg) in values.iter_mut().zip(&angles.theta_deg) {
        let theta = theta_deg.to_radians();
        if angles.angle_to_beam(theta) <= half * (1.0 + 1e-9) {
            *value += flux * unit(setup, theta);
        }
    }
}

/// Adds all coherent beams of a law to the readings of its diffuse light.
pub(super) fn add_all(
    setup: &Setup,
    plan: &Angles,
    values: &mut [f64],
    coherent: impl Fn(Direction<f64>) -> CoherentFlux,
) {
    let mut rest = values;
    for angles in &plan.incidences {
        let (mine, after) = rest.split_at_mut(angles.theta_deg.len().min(rest.len()));
        let flux = flux(setup, angles.sigma_deg.to_radians(), Hits::All, &coherent);
        add(setup, angles, mine, flux);
        rest = after;
    }
}

/// From relative flux in the aperture to what the setup reads; 0 where the cosine vanishes.
pub(super) fn unit(setup: &Setup, theta: f64) -> f64 {
    match setup.quantity {
        Quantity::Flux => 1.0,
        Quantity::Bsdf => {
            let cosine = theta.cos();
            let solid_angle = solid_angle(setup.aperture_deg);
            if cosine > 1e-9 { 1.0 / (solid_angle * cosine) } else { 0.0 }
        }
    }
}

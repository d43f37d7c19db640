//! The forward model: a rough boundary, in a plate, in a goniophotometer, gives readings.
//!
//! [`quadrature`] is deterministic and smooth in the parameters, as fits need it. [`monte_carlo`] checks it
//! independently and serves boundaries that cannot be evaluated. [`wave`] adds
//! coherent beams and speckle. [`simulate`] chooses among them; the example of [`mod@crate::fit`] uses it.

mod optics;
mod aperture;
mod azimuth;
mod between;
mod profile;
mod returns;
mod polar;
mod triangles;
mod field;
mod inside;
mod internal;
mod quadrature;
mod rays;
mod heeding;
mod monte_carlo;
mod coherent;
mod wave;
mod simulate;

pub(crate) use heeding::Heeding;
pub(crate) use monte_carlo::count_flux_until;
pub use monte_carlo::{MonteCarlo, count_flux, monte_carlo};
pub use quadrature::{Effort, Neglected, Readings, quadrature};
pub use rays::Rays;
pub(crate) use rays::{Tiles, mix};
pub use simulate::simulate;
pub use wave::wave;

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

use crate::measurement::{Measurement, Quantity};

/// The sample in the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// A plate of relative index `eta` with one rough face.
    Plate {
        /// Index of the plate over that of air.
        eta: RelativeIor<f64>,
        /// Which way the rough face looks.
        rough_side: RoughSide,
    },
    /// An opaque body: one reflection, no inside.
    Opaque,
}

/// A sample in the instrument, and the quantity of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// The sample in the beam.
    pub sample: Sample,
    /// Side of the detector.
    pub geometry: Geometry,
    /// FULL angle of the detector's cone, degrees. 0 for readings of a BSDF taken as point values.
    pub aperture_deg: f64,
    /// Relative flux, or BSDF in 1/sr.
    pub quantity: Quantity,
}

impl Setup {
    /// Whether the detector looks at the rough face itself, not through a smooth one.
    pub(crate) fn sees_rough_face(&self) -> bool {
        match self.sample {
            Sample::Plate { rough_side, .. } => {
                (self.geometry == Geometry::Reflection) == (rough_side == RoughSide::Source)
            }
            Sample::Opaque => true,
        }
    }
}

/// The angles of one incidence, degrees; observation angles ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Angle of incidence.
    pub sigma_deg: f64,
    /// Angles of observation.
    pub theta_deg: Vec<f64>,
}

/// The angles of a scan.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Angles {
    /// One entry per incidence.
    pub incidences: Vec<Incidence>,
}

impl Angles {
    /// The angles of a measurement, in the order of its readings.
    pub fn of(measurement: &Measurement) -> Self {
        let mut angles = Self::default();
        for r in measurement.readings() {
            match angles.incidences.last_mut() {
                Some(last) if last.sigma_deg.to_bits() == r.sigma_deg.to_bits() => {
                    last.theta_deg.push(r.theta_deg);
                }
                _ => angles
                    .incidences
                    .push(Incidence { sigma_deg: r.sigma_deg, theta_deg: vec![r.theta_deg] }),
            }
        }
        angles
    }

    /// The same observation angles for every incidence.
    pub fn product(sigmas_deg: &[f64], theta_deg: &[f64]) -> Self {
        let incidence = |&sigma_deg| Incidence { sigma_deg, theta_deg: theta_deg.to_vec() };
        Self { incidences: sigmas_deg.iter().map(incidence).collect() }
    }

    /// Number of readings.
    pub fn len(&self) -> usize {
        self.incidences.iter().map(|i| i.theta_deg.len()).sum()
    }

    /// True without readings.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Solid angle of the detector's cone in sr; `aperture_deg` is its FULL angle.
pub fn solid_angle(aperture_deg: f64) -> f64 {
    let s = (0.25 * aperture_deg.to_radians()).sin();
    4.0 * std::f64::consts::PI * s * s
}

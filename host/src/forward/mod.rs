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
mod tally;
mod monte_carlo;
mod facets;
mod coherent;
mod wave;
mod simulate;

pub(crate) use heeding::Heeding;
pub(crate) use monte_carlo::count_flux_until;
pub use monte_carlo::{MonteCarlo, count_flux, monte_carlo};
pub use quadrature::{Effort, Neglected, Readings, quadrature};
pub use rays::Rays;
pub(crate) use rays::{Tiles, mix};
pub use simulate::{by_rays, simulate};
pub use wave::wave;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

use crate::measurement::{Measurement, Plane, Quantity};

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
    /// FULL height of a slit out of the plane of observation, degrees; the aperture is then its width in that plane. `None`: a
    /// round cone. For laws in closed form.
    pub slit_height_deg: Option<f64>,
    /// Relative flux, or BSDF in 1/sr.
    pub quantity: Quantity,
}

impl Setup {
    /// Solid angle of the detector, sr.
    pub fn solid_angle(&self) -> f64 {
        match self.slit_height_deg {
            None => solid_angle(self.aperture_deg),
            // int cos psi dpsi over the height, times the width
            Some(height) => {
                self.aperture_deg.to_radians() * 2.0 * (0.5 * height.to_radians()).sin()
            }
        }
    }

    /// The lobe that the detector is in.
    pub(crate) fn lobe(&self) -> Lobe {
        match self.geometry {
            Geometry::Reflection => Lobe::Reflection,
            Geometry::Transmission => Lobe::Transmission,
        }
    }

    /// By how much the frame of the rough face is turned where the sample is: a face that looks away turns the other way.
    pub(crate) fn turn_deg(&self, rotation_deg: f64) -> f64 {
        match self.sample {
            Sample::Plate { rough_side: RoughSide::Detector, .. } => -rotation_deg,
            _ => rotation_deg,
        }
    }

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

/// The angles of one incidence in one plane of observation, degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Angle of incidence.
    pub sigma_deg: f64,
    /// Rotation of the sample about its normal, anticlockwise seen from the source.
    pub rotation_deg: f64,
    /// Azimuth of the plane of observation from the plane of incidence; 0 in that plane.
    pub phi_deg: f64,
    /// Angles of observation in that plane, ascending.
    pub theta_deg: Vec<f64>,
}

impl Incidence {
    /// Observed in the plane of incidence.
    pub fn in_plane(sigma_deg: f64, theta_deg: Vec<f64>) -> Self {
        Self { sigma_deg, rotation_deg: 0.0, phi_deg: 0.0, theta_deg }
    }

    /// Whether the plane of observation is another than that of incidence.
    pub(crate) fn is_turned(&self) -> bool {
        self.phi_deg.abs() > 0.0
    }

    /// A direction as it is in a frame that is turned with the plane of observation.
    pub(crate) fn turned_back(&self, w: Direction<f64>) -> Direction<f64> {
        if self.is_turned() { turned(w, -self.phi_deg.to_radians()) } else { w }
    }

    /// A direction of that frame as it is in the frame of the plane of incidence.
    pub(crate) fn turned(&self, w: Direction<f64>) -> Direction<f64> {
        if self.is_turned() { turned(w, self.phi_deg.to_radians()) } else { w }
    }

    /// The point of the plane that is nearest to the undeviated or mirrored beam: its angle, and how far it is from it, rad.
    pub(crate) fn nearest_to_beam(&self) -> (f64, f64) {
        let sigma = self.sigma_deg.to_radians();
        if !self.is_turned() {
            return (sigma, 0.0);
        }
        let (sin, cos) = self.phi_deg.to_radians().sin_cos();
        ((sigma.tan() * cos).atan(), (sigma.sin() * sin).abs().asin())
    }

    /// Angle between the direction at `theta`, rad, and the undeviated or mirrored beam.
    pub(crate) fn angle_to_beam(&self, theta: f64) -> f64 {
        let (nearest, off) = self.nearest_to_beam();
        let along = (theta - nearest).abs();
        if self.is_turned() { (along.cos() * off.cos()).clamp(-1.0, 1.0).acos() } else { along }
    }
}

/// A direction turned about the normal, by an angle in radians.
fn turned(w: Direction<f64>, phi: f64) -> Direction<f64> {
    let ([x, y, z], (sin, cos)) = (w.xyz(), phi.sin_cos());
    Direction::from_unit(cos * x - sin * y, sin * x + cos * y, z)
}

/// The angles of a scan.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Angles {
    /// One entry per incidence and plane of observation, those of one incidence in a row.
    pub incidences: Vec<Incidence>,
}

impl Angles {
    /// The angles of a measurement, in the order of its readings.
    pub fn of(measurement: &Measurement) -> Self {
        let plane = |plane: Plane<'_>| Incidence {
            sigma_deg: plane.sigma_deg,
            rotation_deg: plane.rotation_deg,
            phi_deg: plane.phi_deg,
            theta_deg: plane.readings.iter().map(|r| r.theta_deg).collect(),
        };
        Self { incidences: measurement.by_plane().map(plane).collect() }
    }

    /// The same observation angles, in the plane of incidence, for every incidence.
    pub fn product(sigmas_deg: &[f64], theta_deg: &[f64]) -> Self {
        let incidence = |&sigma_deg| Incidence::in_plane(sigma_deg, theta_deg.to_vec());
        Self { incidences: sigmas_deg.iter().map(incidence).collect() }
    }

    /// The planes of observation of each incidence.
    pub(crate) fn by_incidence(&self) -> Vec<&[Incidence]> {
        let same = |a: &Incidence, b: &Incidence| a.sigma_deg.total_cmp(&b.sigma_deg).is_eq();
        self.incidences.chunk_by(same).collect()
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

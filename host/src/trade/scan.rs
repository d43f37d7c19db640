//! The scans that judge an evaluator: the measured one, and one of its own model.

use asperity_core::bsdf::Bsdf;
use asperity_core::gonio::{Geometry, gp200};
use asperity_core::metric::rmsd_percent;
use asperity_core::plate::RoughSide;
use asperity_core::quantity::RelativeIor;

use crate::boundary::AnyLaw;
use crate::forward::{Angles, Effort, Sample, Setup, quadrature};
use crate::measurement::{Measurement, Quantity};

/// Step of the scan that tells the distance from the model, degrees.
pub(super) const STEP: f64 = 0.25;

/// The measured scan.
#[derive(Clone, Debug)]
pub struct Scan {
    setup: Setup,
    angles: Angles,
    readings: Vec<f64>,
}

impl Scan {
    /// A measurement and how it was made.
    pub fn of(measurement: &Measurement, setup: Setup) -> Self {
        let readings = measurement.readings().iter().map(|r| r.value).collect();
        Self { setup, angles: Angles::of(measurement), readings }
    }

    /// The scan that any model can be compared on: the GP-200's, in transmission if there is any.
    pub(super) fn usual<B: Bsdf<f64> + Sync>(model: &B, eta: Option<f64>) -> Option<Self> {
        let (sample, geometry) = match eta {
            Some(eta) => {
                let (eta, rough_side) = (RelativeIor::new(eta).ok()?, RoughSide::Source);
                (Sample::Plate { eta, rough_side }, Geometry::Transmission)
            }
            None => (Sample::Opaque, Geometry::Reflection),
        };
        let setup = Setup {
            sample,
            geometry,
            aperture_deg: gp200::APERTURE_DEG,
            slit_height_deg: None,
            quantity: Quantity::Flux,
        };
        let thetas: Vec<f64> = (0..=720).map(|k| -90.0 + STEP * f64::from(k)).collect();
        let angles = Angles::product(&gp200::SIGMAS_DEG, &thetas);
        let readings = quadrature(&AnyLaw::of(model), &setup, &angles, Effort::Full).values;
        Some(Self { setup, angles, readings })
    }

    /// Its incidences, degrees.
    pub(super) fn sigmas_deg(&self) -> impl Iterator<Item = f64> + '_ {
        self.angles.incidences.iter().map(|i| i.sigma_deg)
    }

    /// Eq. (18) of a law's diffuse light.
    pub(super) fn error<B: Bsdf<f64> + Sync>(&self, law: &B) -> Option<f64> {
        let values = quadrature(&AnyLaw::of(law), &self.setup, &self.angles, Effort::Full).values;
        rmsd_percent(&self.readings, &values).filter(|e| e.is_finite())
    }
}

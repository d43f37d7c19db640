//! Why there is no scan.

use crate::measurement::meta::HeaderFault;
use crate::measurement::{AngleRange, InvalidReading};

use super::super::Lacking;
use super::super::situation::Unclear;

/// Why there is no scan.
#[derive(Debug, thiserror::Error)]
pub enum NoScan {
    /// An angle of incidence outside 0 to below 90 degrees.
    #[error("an incidence of {0} degrees is not usable; give 0 to below 90 degrees")]
    Incidence(f64),
    /// The same incidence twice.
    #[error("the incidence of {0} degrees is given twice; leave one out")]
    IncidenceTwice(f64),
    /// A rotation outside 0 to below 360 degrees.
    #[error("a rotation of {0} degrees is not usable; give 0 to below 360 degrees")]
    Rotation(f64),
    /// The same rotation twice, or none.
    #[error("give every rotation of the sample once, and one at least")]
    Rotations,
    /// A map is not turned.
    #[error("a map is scanned as it lies, and light comes from x; only laws are rotated")]
    MapIsNotTurned,
    /// Angles of observation that no instrument has.
    #[error("{0} is outside -90:90; give degrees from the plate normal")]
    Outside(AngleRange),
    /// A step that gives no angles, or too many.
    #[error(
        "a step of {step_deg} over {from_deg} to {to_deg} degrees is not usable; give a positive step of at most a million angles"
    )]
    Step {
        /// The step.
        step_deg: f64,
        /// First angle.
        from_deg: f64,
        /// Last angle.
        to_deg: f64,
    },
    /// Transmitted light of an opaque body.
    #[error("an opaque body transmits nothing")]
    OpaqueTransmits,
    /// Rays without an aperture.
    #[error("rays need a detector to fall into")]
    RaysNeedAperture,
    /// Coherent light without an aperture.
    #[error("coherent light needs a detector to fall into")]
    CoherentNeedsAperture,
    /// Rays of waves.
    #[error("waves are summed, not traced")]
    WavesAreNotTraced,
    /// Parts of waves.
    #[error("all incidences of waves are summed at once; only rays and quadrature have parts")]
    WavesAreWhole,
    /// Plate or aperture cannot be.
    #[error(transparent)]
    Unclear(#[from] Unclear),
    /// A table lacks lobes.
    #[error(transparent)]
    Lacking(#[from] Lacking),
    /// A text that no header holds.
    #[error(transparent)]
    Header(#[from] HeaderFault),
    /// The index is none.
    #[error("{0}")]
    Index(String),
    /// Readings that no measurement has.
    #[error("the model gives no usable scan: {0}")]
    Unusable(#[from] InvalidReading),
    /// Stopped, with nothing to keep.
    #[error("interrupted")]
    Interrupted,
    /// Stopped, with nothing to keep.
    #[error("interrupted before the first incidence was done")]
    InterruptedEarly,
}

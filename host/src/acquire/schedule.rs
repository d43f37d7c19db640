//! What is to be measured. A [`Schedule`] exists only if it can be carried out, save for the limits of the
//! instrument, which [`Schedule::check`] compares.

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::protocol::{Axis, Ident, Microdegrees, Range};
use thiserror::Error;

/// When the dark current and the beam without the sample are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CalibrationRule {
    /// Once, before the first incidence.
    #[default]
    Once,
    /// Before each incidence.
    PerSigma,
}

/// A scan: the same even grid of observation angles at every incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Angles of incidence, in the order in which they are measured; no two are equal.
    pub(super) sigmas: Vec<Microdegrees>,
    /// First angle of observation.
    pub(super) start: Microdegrees,
    /// Distance of neighbours, > 0.
    pub(super) step: Microdegrees,
    /// Angles of observation, 1 to 1801.
    pub(super) count: u16,
    /// Full angle of the detector's cone, above 0 to 10 degrees.
    pub(super) aperture: Microdegrees,
    /// Integration time of a reading, 100 to 10^7 microseconds.
    pub(super) integration_us: u32,
    /// Range of the detector.
    pub(super) range: Range,
    /// How far below its first point the detector moves before a segment begins, >= 0: the gears then always bear on
    /// the same side.
    pub(super) run_up: Microdegrees,
    /// When it is calibrated.
    pub(super) calibration: CalibrationRule,
    /// Side of the detector.
    pub(super) geometry: Geometry,
    /// Name of the sample, in one line.
    pub(super) sample: Option<String>,
    /// Index of refraction of the plate relative to air.
    pub(super) ior: Option<f64>,
    /// Which way the rough face looks.
    pub(super) rough_side: Option<RoughSide>,
    /// Wavelength of the light, nm.
    pub(super) wavelength_nm: Option<f64>,
}

/// A schedule that this instrument cannot carry out.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LimitError {
    /// An angle beyond the end of an axis.
    #[error(
        "{axis} {angle} deg is beyond the limits of {instrument}, {least} to {most} deg; change {flag}"
    )]
    Angle {
        /// The axis.
        axis: Axis,
        /// The angle, degrees.
        angle: f64,
        /// Model and serial number.
        instrument: String,
        /// Least position, degrees.
        least: f64,
        /// Largest position, degrees.
        most: f64,
        /// Where the angle comes from.
        flag: &'static str,
    },
    /// Too many points for its memory.
    #[error(
        "{count} angles of observation are more than the {most} that {instrument} holds; take a larger --step"
    )]
    Points {
        /// Angles of the schedule.
        count: u16,
        /// Angles that it holds.
        most: u16,
        /// Model and serial number.
        instrument: String,
    },
}

impl Schedule {
    /// Angles of incidence in the order in which they are measured.
    pub fn sigmas(&self) -> &[Microdegrees] {
        &self.sigmas
    }

    /// Angles of observation of a segment.
    pub fn count(&self) -> u16 {
        self.count
    }

    /// Points of all segments.
    pub fn points(&self) -> u64 {
        self.sigmas.len() as u64 * u64::from(self.count)
    }

    /// The angle of observation of point `index` < [`count`](Self::count).
    pub fn theta(&self, index: u16) -> Microdegrees {
        Microdegrees(self.start.0.saturating_add(self.step.0.saturating_mul(i32::from(index))))
    }

    /// Distance of neighbouring angles of observation.
    pub fn step(&self) -> Microdegrees {
        self.step
    }

    /// Full angle of the detector's cone.
    pub fn aperture(&self) -> Microdegrees {
        self.aperture
    }

    /// Integration time of a reading, microseconds.
    pub fn integration_us(&self) -> u32 {
        self.integration_us
    }

    /// The detector's range.
    pub fn range(&self) -> Range {
        self.range
    }

    /// When it is calibrated.
    pub fn calibration(&self) -> CalibrationRule {
        self.calibration
    }

    /// The position to which the detector moves before it measures point `index`: a little below it, within the
    /// limits of the axis.
    pub fn run_up(&self, index: u16, ident: &Ident) -> Microdegrees {
        let below = self.theta(index).0.saturating_sub(self.run_up.0);
        Microdegrees(below.max(ident.theta.least.0))
    }

    /// Whether that instrument can carry it out.
    ///
    /// # Errors
    /// [`LimitError`] for the first thing it cannot do.
    pub fn check(&self, ident: &Ident) -> Result<(), LimitError> {
        let instrument = || super::client::describe(ident);
        let thetas = [self.theta(0), self.theta(self.count.saturating_sub(1))];
        let sigmas = self.sigmas.iter().map(|sigma| (Axis::Sigma, ident.sigma, *sigma, "--sigma"));
        let thetas = thetas.iter().map(|t| (Axis::Theta, ident.theta, *t, "--theta-range"));
        for (axis, limits, angle, flag) in sigmas.chain(thetas) {
            if angle < limits.least || angle > limits.most {
                return Err(LimitError::Angle {
                    axis,
                    angle: angle.degrees(),
                    instrument: instrument(),
                    least: limits.least.degrees(),
                    most: limits.most.degrees(),
                    flag,
                });
            }
        }
        if self.count > ident.max_points {
            let (count, most) = (self.count, ident.max_points);
            return Err(LimitError::Points { count, most, instrument: instrument() });
        }
        Ok(())
    }
}

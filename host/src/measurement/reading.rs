//! One reading of a goniophotometer, and what is none.

use std::cmp::Ordering;

use thiserror::Error;

/// Readings below zero are noise around zero as long as they are no lower than this fraction of the
/// largest reading; below that the dark signal was subtracted wrongly.
pub(super) const NEGATIVE_LIMIT: f64 = 0.05;

/// One position of the goniophotometer.
///
/// The direction of observation lies in a plane through the normal; `phi_deg` is the azimuth of that plane from the plane of
/// incidence, and `theta_deg` the signed angle in it. At `phi_deg == 0` positive angles are those of the undeviated or
/// mirrored beam, which is at `theta_deg == sigma_deg`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Angle of incidence in degrees, in [0, 90).
    pub sigma_deg: f64,
    /// Rotation of the sample about its normal in degrees, in [0, 360).
    pub rotation_deg: f64,
    /// Azimuth of the plane of observation in degrees, in (-90, 90].
    pub phi_deg: f64,
    /// Angle of observation in that plane in degrees, in [-90, 90].
    pub theta_deg: f64,
    /// The reading in the unit of [`Measurement::quantity`](super::Measurement::quantity).
    pub value: f64,
}

impl Reading {
    /// A reading in the plane of incidence.
    pub const fn in_plane(sigma_deg: f64, theta_deg: f64, value: f64) -> Self {
        Self { sigma_deg, rotation_deg: 0.0, phi_deg: 0.0, theta_deg, value }
    }

    /// A reading at a polar angle in [0, 90] and any azimuth, degrees; azimuth 0 is that of the undeviated or mirrored beam.
    pub fn at(sigma_deg: f64, [polar_deg, azimuth_deg]: [f64; 2], value: f64) -> Self {
        let azimuth = azimuth_deg.rem_euclid(360.0);
        // the half planes at an azimuth and opposite to it are one plane, and all planes meet at the normal
        let (phi_deg, theta_deg) = match azimuth {
            _ if polar_deg <= 0.0 => (0.0, 0.0),
            ..=90.0 => (azimuth, polar_deg),
            ..=270.0 => (azimuth - 180.0, -polar_deg),
            _ => (azimuth - 360.0, polar_deg),
        };
        let mut reading = Self { phi_deg, ..Self::in_plane(sigma_deg, theta_deg, value) };
        reading.normalise();
        reading
    }

    /// Makes one of two numbers for the same place.
    pub(super) fn normalise(&mut self) {
        if self.phi_deg <= -90.0 {
            self.phi_deg = 90.0;
            self.theta_deg = -self.theta_deg;
        }
        // -0 and 0 are one angle
        for angle in
            [&mut self.sigma_deg, &mut self.rotation_deg, &mut self.phi_deg, &mut self.theta_deg]
        {
            *angle += 0.0;
        }
    }

    /// Polar angle and azimuth of the direction of observation, degrees.
    pub fn direction(&self) -> [f64; 2] {
        let azimuth = if self.theta_deg < 0.0 { self.phi_deg + 180.0 } else { self.phi_deg };
        [self.theta_deg.abs(), azimuth.rem_euclid(360.0)]
    }

    /// The place in words.
    pub(super) fn place(&self) -> String {
        let Self { sigma_deg, rotation_deg, phi_deg, theta_deg, .. } = self;
        let other = |name: &str, angle: &f64| match angle.abs() {
            0.0 => String::new(),
            _ => format!(", {name} {angle} deg"),
        };
        let (phi, rotation) = (other("phi", phi_deg), other("rotation", rotation_deg));
        format!("sigma {sigma_deg} deg, theta {theta_deg} deg{phi}{rotation}")
    }

    /// The order of places in a scan.
    pub(super) fn compare_place(&self, other: &Self) -> Ordering {
        let key = |r: &Self| [r.sigma_deg, r.rotation_deg, r.phi_deg, r.theta_deg];
        let pairs = key(self).into_iter().zip(key(other));
        pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b)))
    }

    /// Whether another is of the same incidence, rotation and plane of observation.
    pub(super) fn is_in_plane_of(&self, other: &Self) -> bool {
        let theta_deg = self.theta_deg;
        self.compare_place(&Self { theta_deg, ..*other }).is_eq()
    }

    pub(super) fn check(&self) -> Result<(), ReadingFault> {
        if !(0.0..90.0).contains(&self.sigma_deg) {
            return Err(ReadingFault::Sigma(self.sigma_deg));
        }
        if !(-90.0..=90.0).contains(&self.theta_deg) {
            return Err(ReadingFault::Theta(self.theta_deg));
        }
        if !(-90.0..=90.0).contains(&self.phi_deg) {
            return Err(ReadingFault::Phi(self.phi_deg));
        }
        if !(0.0..360.0).contains(&self.rotation_deg) {
            return Err(ReadingFault::Rotation(self.rotation_deg));
        }
        if !self.value.is_finite() {
            return Err(ReadingFault::NotFinite(self.value));
        }
        Ok(())
    }
}

/// A set of readings that is not a measurement, and the reading at fault.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("{}{fault}", row.map(|row| format!("reading {}: ", row + 1)).unwrap_or_default())]
pub struct InvalidReading {
    /// Index of the reading in the order given; `None` where all are at fault together.
    pub row: Option<usize>,
    /// The fault.
    pub fault: ReadingFault,
}

/// Faults of the readings themselves, from any source.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ReadingFault {
    /// There are none.
    #[error("there are no readings; a scan needs at least one")]
    NoReadings,
    /// Angle of incidence outside [0, 90) degrees, or not finite.
    #[error(
        "the angle of incidence {0} deg is outside [0, 90); give degrees from the plate normal, \
         or leave the row out (--sigma-range)"
    )]
    Sigma(f64),
    /// Angle of observation outside [-90, 90] degrees, or not finite.
    #[error(
        "the angle of observation {0} deg is outside [-90, 90]; give degrees from the plate normal \
         on the detector's side, or leave the row out (--theta-range)"
    )]
    Theta(f64),
    /// Azimuth of the plane of observation outside [-90, 90] degrees, or not finite.
    #[error(
        "the azimuth {0} deg of the plane of observation is outside [-90, 90]; theta has the sign: \
         write azimuth 170, theta 10 as -10, -10"
    )]
    Phi(f64),
    /// Rotation of the sample outside [0, 360) degrees, or not finite.
    #[error("the rotation {0} deg of the sample is outside [0, 360); add or take away whole turns")]
    Rotation(f64),
    /// NaN or infinite.
    #[error("the reading {0} is not finite; delete the row where nothing was measured")]
    NotFinite(f64),
    /// Too far below zero to be noise.
    #[error(
        "the reading {value} is below zero by more than 5 % of the largest reading {largest}; \
         check the dark signal that was subtracted"
    )]
    Negative {
        /// The reading.
        value: f64,
        /// The largest one.
        largest: f64,
    },
    /// The same point twice.
    #[error(
        "{} was measured before (reading {}); average the two or keep one", reading.place(), first_row + 1
    )]
    Repeated {
        /// The second of the two.
        reading: Reading,
        /// Index of the first.
        first_row: usize,
    },
    /// No reading above zero.
    #[error("no reading is above zero; the detector saw no light: check the lamp and the column")]
    AllDark,
}

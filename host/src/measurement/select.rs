//! Ranges of angles: the part of a measurement in use.

use std::fmt::{self, Display};
use std::str::FromStr;

use thiserror::Error;

use super::{Measurement, Reading};

/// Angles as written in decimals differ from their doubles in the last digits, in degrees.
const ROUNDING_DEG: f64 = 1e-9;

/// A range of angles in degrees, ends included; written `5:75`, `-60:60`, `:60` or `5:`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleRange {
    min_deg: f64,
    max_deg: f64,
}

/// A text that is not a range of angles.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}` is not a range of angles; write FROM:TO in degrees with FROM <= TO, such as -60:60")]
pub struct RangeError(String);

impl AngleRange {
    /// Every angle.
    pub const ALL: Self = Self { min_deg: f64::NEG_INFINITY, max_deg: f64::INFINITY };

    /// The angles from `min_deg` to `max_deg` degrees, both included.
    ///
    /// # Errors
    /// [`RangeError`] unless `min_deg <= max_deg`.
    pub fn new(min_deg: f64, max_deg: f64) -> Result<Self, RangeError> {
        if min_deg <= max_deg {
            Ok(Self { min_deg, max_deg })
        } else {
            Err(RangeError(format!("{min_deg}:{max_deg}")))
        }
    }

    /// The lower end, degrees; may be infinite.
    pub fn min_deg(&self) -> f64 {
        self.min_deg
    }

    /// The upper end, degrees; may be infinite.
    pub fn max_deg(&self) -> f64 {
        self.max_deg
    }

    /// Whether an angle in degrees is inside; ends count as inside whatever their last digits.
    pub fn contains(&self, angle_deg: f64) -> bool {
        angle_deg >= self.min_deg - ROUNDING_DEG && angle_deg <= self.max_deg + ROUNDING_DEG
    }
}

impl Default for AngleRange {
    fn default() -> Self {
        Self::ALL
    }
}

impl FromStr for AngleRange {
    type Err = RangeError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let fault = || RangeError(text.to_owned());
        let end = |part: &str, open: f64| match part.trim() {
            "" => Some(open),
            number => number.parse().ok().filter(|angle: &f64| angle.is_finite()),
        };
        let (from, to) = text.split_once(':').ok_or_else(fault)?;
        let min_deg = end(from, f64::NEG_INFINITY).ok_or_else(fault)?;
        let max_deg = end(to, f64::INFINITY).ok_or_else(fault)?;
        Self::new(min_deg, max_deg).map_err(|_| fault())
    }
}

impl Display for AngleRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::ALL {
            return f.write_str("any");
        }
        let end = |angle: f64| {
            if angle.is_finite() { angle.to_string() } else { String::new() }
        };
        write!(f, "{}:{}", end(self.min_deg), end(self.max_deg))
    }
}

/// The part of a measurement that is used; everything by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Selection {
    /// Angles of incidence.
    pub sigma: AngleRange,
    /// Angles of observation.
    pub theta: AngleRange,
    /// Azimuths of planes of observation.
    pub phi: AngleRange,
}

/// A selection that leaves nothing to use.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SelectionFault {
    /// No reading inside.
    #[error(
        "no reading has {asked}; the scan covers sigma {} and theta {}: widen --sigma-range, \
         --theta-range or --phi-range", covered.sigma, covered.theta
    )]
    Nothing {
        /// The selection.
        asked: Selection,
        /// The ranges that the readings cover.
        covered: Selection,
    },
    /// Readings inside, but all dark.
    #[error("no reading above zero has {asked}: widen --sigma-range, --theta-range or --phi-range")]
    Dark {
        /// The selection.
        asked: Selection,
    },
}

impl Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sigma in {} and theta in {} deg", self.sigma, self.theta)?;
        if self.phi == AngleRange::ALL { Ok(()) } else { write!(f, ", phi in {} deg", self.phi) }
    }
}

impl Selection {
    /// Whether the point is inside; angles in degrees.
    pub fn contains(&self, sigma_deg: f64, theta_deg: f64) -> bool {
        self.sigma.contains(sigma_deg) && self.theta.contains(theta_deg)
    }

    /// The readings inside, with the header of the whole.
    ///
    /// # Errors
    /// [`SelectionFault`] where no reading, or none above zero, is inside.
    pub fn apply(&self, scan: &Measurement) -> Result<Measurement, SelectionFault> {
        let inside =
            |r: &&Reading| self.contains(r.sigma_deg, r.theta_deg) && self.phi.contains(r.phi_deg);
        let kept: Vec<Reading> = scan.readings().iter().filter(inside).copied().collect();
        if kept.is_empty() {
            let points =
                scan.readings().iter().map(|reading| (reading.sigma_deg, reading.theta_deg));
            return Err(SelectionFault::Nothing { asked: *self, covered: Self::covering(points) });
        }
        // Sorted and free of repetitions as part of the whole; negative noise was judged there too.
        let mut part = Measurement { meta: scan.meta.clone(), readings: kept };
        if part.readings.len() < scan.readings().len() {
            // It was relative to the whole.
            part.meta.noise_floor_percent = None;
        }
        if part.largest_reading() <= 0.0 {
            return Err(SelectionFault::Dark { asked: *self });
        }
        Ok(part)
    }

    /// The smallest selection that contains the points (sigma, theta) in degrees.
    pub(super) fn covering(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let empty = AngleRange { min_deg: f64::INFINITY, max_deg: f64::NEG_INFINITY };
        let grown = |range: AngleRange, angle: f64| AngleRange {
            min_deg: range.min_deg.min(angle),
            max_deg: range.max_deg.max(angle),
        };
        points.fold(
            Self { sigma: empty, theta: empty, phi: AngleRange::ALL },
            |covered, (sigma, theta)| Self {
                sigma: grown(covered.sigma, sigma),
                theta: grown(covered.theta, theta),
                ..covered
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::Metadata;
    use super::*;

    #[test]
    fn ranges_include_their_ends_and_may_be_open() {
        let range: AngleRange = " -60 : 0.3".parse().unwrap();
        assert!(range.contains(-60.0) && range.contains(0.1 + 0.2) && !range.contains(0.31));
        let open: AngleRange = ":60".parse().unwrap();
        assert!(open.contains(-90.0) && !open.contains(61.0));
        assert_eq!((range.to_string().as_str(), open.to_string().as_str()), ("-60:0.3", ":60"));
        for bad in ["", "5", "75:5", "a:b", "nan:5", "0:inf", "1:2:3"] {
            assert!(bad.parse::<AngleRange>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_selection_keeps_what_is_inside_and_says_what_there_was() {
        let points = [(0.0, -10.0), (0.0, 10.0), (30.0, 10.0), (30.0, 40.0)];
        let reading =
            |&(sigma_deg, theta_deg): &(f64, f64)| Reading::in_plane(sigma_deg, theta_deg, 1.0);
        let scan =
            Measurement::new(Metadata::default(), points.iter().map(reading).collect()).unwrap();
        let mut selection = Selection { theta: "0:20".parse().unwrap(), ..Selection::default() };
        assert_eq!(selection.apply(&scan).unwrap().readings().len(), 2);
        selection.sigma = "5:25".parse().unwrap();
        let message = selection.apply(&scan).unwrap_err().to_string();
        assert!(message.contains("covers sigma 0:30 and theta -10:40"), "{message}");
    }
}

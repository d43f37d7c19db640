//! Measurements: the readings of a goniophotometer, with what is known about sample and instrument.
//!
//! ```
//! use asperity::measurement::{Quantity, csv};
//!
//! let text = "# geometry: transmission\n# ior: 1.49\nsigma_deg,theta_deg,reading\n0,0,0.002\n0,1,0.001\n";
//! let scan = csv::parse(text, "scan.csv")?; // from a file: csv::read
//! assert_eq!((scan.readings().len(), scan.quantity()), (2, Quantity::Flux));
//! assert_eq!(scan.meta.ior, Some(1.49));
//! // an error names file, line and remedy
//! let error = csv::parse("sigma_deg,theta_deg,reading\n0,0,x\n", "bad.csv").unwrap_err();
//! assert!(error.to_string().starts_with("bad.csv:2,"), "{error}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | concept |
//! |---|---|
//! | [`meta`] | the header of a scan |
//! | [`select`] | ranges of angles |
//! | [`error`] | faults of a scan file, and their places |
//! | [`csv`] | reading the standard file |
//! | [`columns`] | the columns of a foreign CSV file |
//! | [`import`] | reading such a file |
//! | [`exchanged`] | reading the files of other programs |
//! | [`write`](mod@write) | writing the standard file |
//! | [`noise`] | the noise floor, from the readings alone |

use std::ops::Range;

use thiserror::Error;

pub mod meta;
pub mod select;
pub mod error;
pub mod csv;
pub mod columns;
mod table;
pub mod import;
pub mod exchanged;
pub mod write;
pub mod noise;
#[cfg(test)]
mod malformed;

pub use self::columns::ColumnMap;
pub use self::error::{ScanError, ScanFault};
pub use self::import::{Import, RowCounts};
pub use self::meta::{Metadata, Quantity};
pub use self::noise::NoiseEstimate;
pub use self::select::{AngleRange, Selection};

/// Readings below zero are noise around zero as long as they are no lower than this fraction of the
/// largest reading; below that the dark signal was subtracted wrongly.
const NEGATIVE_LIMIT: f64 = 0.05;

/// One position of the goniophotometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Angle of incidence in degrees, in [0, 90).
    pub sigma_deg: f64,
    /// Angle of observation in the plane of incidence in degrees, in [-90, 90]; the undeviated beam
    /// and the mirror direction are at `theta_deg == sigma_deg`.
    pub theta_deg: f64,
    /// The reading in the unit of [`Measurement::quantity`].
    pub value: f64,
}

/// A scan of one sample: readings over angles of incidence and of observation.
///
/// Readings are sorted by incidence, then by observation angle; all are finite and in their ranges,
/// no point occurs twice, and at least one reading is above zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The known facts about the sample and the instrument.
    pub meta: Metadata,
    readings: Vec<Reading>,
}

/// The readings at one angle of incidence, by increasing observation angle; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence<'a> {
    /// Angle of incidence in degrees.
    pub sigma_deg: f64,
    /// Where these readings are in [`Measurement::readings`].
    pub range: Range<usize>,
    /// The readings themselves.
    pub readings: &'a [Reading],
}

impl Measurement {
    /// Sorts and checks readings given in any order.
    ///
    /// # Errors
    /// [`InvalidReading`] with the index of the first offending reading.
    pub fn new(meta: Metadata, mut readings: Vec<Reading>) -> Result<Self, InvalidReading> {
        let at = |row| move |fault| InvalidReading { row: Some(row), fault };
        let whole = |fault| InvalidReading { row: None, fault };
        if readings.is_empty() {
            return Err(whole(ReadingFault::NoReadings));
        }
        for (row, reading) in readings.iter_mut().enumerate() {
            reading.check().map_err(at(row))?;
            // -0 and 0 are one angle
            reading.sigma_deg += 0.0;
            reading.theta_deg += 0.0;
        }
        let largest = largest(&readings);
        if largest <= 0.0 {
            return Err(whole(ReadingFault::AllDark));
        }
        for (row, reading) in readings.iter().enumerate() {
            if reading.value < -NEGATIVE_LIMIT * largest {
                return Err(at(row)(ReadingFault::Negative { value: reading.value, largest }));
            }
        }
        let mut order: Vec<usize> = (0..readings.len()).collect();
        let point = |row: usize| (readings[row].sigma_deg, readings[row].theta_deg);
        order.sort_by(|&a, &b| {
            let ((sigma_a, theta_a), (sigma_b, theta_b)) = (point(a), point(b));
            sigma_a.total_cmp(&sigma_b).then(theta_a.total_cmp(&theta_b))
        });
        // the earliest repetition in the given order, which is the one a reader looks for
        let repeated = order.windows(2).filter(|pair| point(pair[0]) == point(pair[1]));
        if let Some(pair) = repeated.min_by_key(|pair| pair[1]) {
            let (sigma_deg, theta_deg) = point(pair[1]);
            let first_row = pair[0];
            return Err(at(pair[1])(ReadingFault::Repeated { sigma_deg, theta_deg, first_row }));
        }
        let readings = order.into_iter().map(|row| readings[row]).collect();
        Ok(Self { meta, readings })
    }

    /// All readings, by incidence, then by observation angle; never empty.
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The quantity of the readings, from the header; [`Quantity::Flux`] without one.
    pub fn quantity(&self) -> Quantity {
        self.meta.quantity.unwrap_or_default()
    }

    /// The distinct angles of incidence in degrees, increasing.
    pub fn incidences(&self) -> Vec<f64> {
        self.by_incidence().map(|incidence| incidence.sigma_deg).collect()
    }

    /// The readings grouped by angle of incidence, increasing.
    pub fn by_incidence(&self) -> impl Iterator<Item = Incidence<'_>> {
        let mut start = 0;
        let same = |a: &Reading, b: &Reading| a.sigma_deg.total_cmp(&b.sigma_deg).is_eq();
        self.readings.chunk_by(same).map(move |readings| {
            let range = start..start + readings.len();
            start = range.end;
            Incidence { sigma_deg: readings[0].sigma_deg, range, readings }
        })
    }

    /// The largest reading, above zero, in the unit of [`quantity`](Self::quantity): the divisor of
    /// the error figure \[Sokolov2022, eq. 18\].
    pub fn largest_reading(&self) -> f64 {
        largest(&self.readings)
    }
}

fn largest(readings: &[Reading]) -> f64 {
    readings.iter().map(|reading| reading.value).fold(f64::NEG_INFINITY, f64::max)
}

impl Reading {
    fn check(&self) -> Result<(), ReadingFault> {
        if !(0.0..90.0).contains(&self.sigma_deg) {
            return Err(ReadingFault::Sigma(self.sigma_deg));
        }
        if !(-90.0..=90.0).contains(&self.theta_deg) {
            return Err(ReadingFault::Theta(self.theta_deg));
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
        "sigma {sigma_deg} deg, theta {theta_deg} deg was measured before (reading {}); \
         average the two or keep one", first_row + 1
    )]
    Repeated {
        /// Angle of incidence in degrees.
        sigma_deg: f64,
        /// Angle of observation in degrees.
        theta_deg: f64,
        /// Index of the first of the two.
        first_row: usize,
    },
    /// No reading above zero.
    #[error("no reading is above zero; the detector saw no light: check the lamp and the column")]
    AllDark,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(sigma_deg: f64, theta_deg: f64, value: f64) -> Reading {
        Reading { sigma_deg, theta_deg, value }
    }

    #[test]
    fn readings_are_sorted_and_grouped_whatever_their_order() {
        let mixed = [(30.0, 5.0, 2.0), (0.0, 1.0, 3.0), (30.0, -5.0, 1.0), (-0.0, -1.0, 0.5)];
        let readings = mixed.iter().map(|&(s, t, v)| reading(s, t, v)).collect();
        let scan = Measurement::new(Metadata::default(), readings).unwrap();
        assert_eq!(scan.incidences(), [0.0, 30.0]);
        let groups: Vec<_> = scan.by_incidence().map(|group| group.range).collect();
        assert_eq!(groups, [0..2, 2..4]);
        let values: Vec<f64> = scan.readings().iter().map(|reading| reading.value).collect();
        assert_eq!(values, [0.5, 3.0, 1.0, 2.0]);
        assert_eq!((scan.largest_reading(), scan.quantity()), (3.0, Quantity::Flux));
    }

    #[test]
    fn noise_around_zero_is_kept_and_a_wrong_dark_signal_refused() {
        let with = |dark| vec![reading(0.0, 0.0, 1.0), reading(0.0, 1.0, dark)];
        assert!(Measurement::new(Metadata::default(), with(-0.049)).is_ok());
        let error = Measurement::new(Metadata::default(), with(-0.051)).unwrap_err();
        assert_eq!(error.row, Some(1));
        assert!(error.to_string().starts_with("reading 2: "), "{error}");
    }

    #[test]
    fn the_second_of_two_equal_points_is_named_with_the_first() {
        let points = [(0.0, 2.0), (0.0, 1.0), (15.0, 1.0), (0.0, 2.0), (0.0, 1.0)];
        let readings = points.iter().map(|&(s, t)| reading(s, t, 1.0)).collect();
        let error = Measurement::new(Metadata::default(), readings).unwrap_err();
        assert_eq!(error.row, Some(3));
        assert!(matches!(error.fault, ReadingFault::Repeated { first_row: 0, .. }));
    }
}

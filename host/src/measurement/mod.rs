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
//! | [`layout`] | encodings, separators, decimal marks |
//! | [`csv`] | reading the standard file |
//! | [`columns`] | the columns of a foreign CSV file |
//! | [`import`] | reading such a file |
//! | [`exchanged`] | reading the files of other programs |
//! | [`write`](mod@write) | writing the standard file |
//! | [`noise`] | the noise floor, from the readings alone |
//! | [`isotropy`] | what no isotropic law can follow |
//! | [`clean`] | what is left out before a scan is used |
//! | [`signs`] | what readings say of how they were made: drop-outs, saturation, their unit |

use std::ops::Range;

pub mod meta;
mod reading;
pub mod select;
pub mod error;
pub mod layout;
mod text;
pub mod csv;
pub mod columns;
mod table;
pub mod import;
pub mod exchanged;
pub mod write;
pub mod noise;
pub mod isotropy;
pub mod signs;
pub mod clean;
#[cfg(test)]
mod malformed;

pub use self::columns::{AngleUnit, ColumnMap};
pub use self::error::{ScanError, ScanFault};
pub use self::import::{Import, RowCounts};
pub use self::isotropy::Isotropy;
pub use self::layout::Layout;
pub use self::meta::{Metadata, Quantity, Stated};
pub use self::noise::NoiseEstimate;
pub use self::reading::{InvalidReading, Reading, ReadingFault};
pub use self::select::{AngleRange, Selection};

/// A scan of one sample: readings over angles of incidence and of observation.
///
/// Readings are sorted by incidence, rotation of the sample, plane and angle of observation; all are finite and in
/// their ranges, no point occurs twice, and at least one reading is above zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The known facts about the sample and the instrument.
    pub meta: Metadata,
    readings: Vec<Reading>,
}

/// The readings at one angle of incidence, plane by plane; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence<'a> {
    /// Angle of incidence in degrees.
    pub sigma_deg: f64,
    /// Where these readings are in [`Measurement::readings`].
    pub range: Range<usize>,
    /// The readings themselves.
    pub readings: &'a [Reading],
}

/// The readings in one plane of observation, by increasing angle of observation; never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane<'a> {
    /// Angle of incidence in degrees.
    pub sigma_deg: f64,
    /// Rotation of the sample about its normal in degrees.
    pub rotation_deg: f64,
    /// Azimuth of the plane from the plane of incidence in degrees; 0 in that plane.
    pub phi_deg: f64,
    /// Where these readings are in [`Measurement::readings`].
    pub range: Range<usize>,
    /// The readings themselves.
    pub readings: &'a [Reading],
}

impl Measurement {
    /// Sorts and checks readings given in any order, and converts them if the header states more than their quantity:
    ///
    /// | [`stated`](Metadata::stated) | reading |
    /// |---|---|
    /// | `ars` | f = ars / cos theta; readings at the horizon are left out |
    /// | `factor` | f = factor / pi |
    /// | `counts` | flux = counts [`COUNTS_PEAK`](Stated::COUNTS_PEAK) / the largest |
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
            reading.normalise();
        }
        let largest = largest(&readings);
        if largest <= 0.0 {
            return Err(whole(ReadingFault::AllDark));
        }
        for (row, reading) in readings.iter().enumerate() {
            if reading.value < -reading::NEGATIVE_LIMIT * largest {
                return Err(at(row)(ReadingFault::Negative { value: reading.value, largest }));
            }
        }
        let mut order: Vec<usize> = (0..readings.len()).collect();
        order.sort_by(|&a, &b| readings[a].compare_place(&readings[b]));
        // the earliest repetition in the given order, which is the one a reader looks for
        let same = |pair: &&[usize]| readings[pair[0]].compare_place(&readings[pair[1]]).is_eq();
        let repeated = order.windows(2).filter(same);
        if let Some(pair) = repeated.min_by_key(|pair| pair[1]) {
            let reading = readings[pair[1]];
            return Err(at(pair[1])(ReadingFault::Repeated { reading, first_row: pair[0] }));
        }
        let readings = order.into_iter().map(|row| readings[row]).collect();
        Self { meta, readings }.converted().map_err(whole)
    }

    /// The same with its readings in their quantity.
    fn converted(mut self) -> Result<Self, ReadingFault> {
        let Some(stated) = self.meta.stated else { return Ok(self) };
        if stated == Stated::Ars {
            self.readings.retain(|reading| reading.theta_deg.abs() < 90.0);
        }
        if self.readings.is_empty() || self.largest_reading() <= 0.0 {
            return Err(ReadingFault::AllDark);
        }
        let peak = self.largest_reading();
        for Reading { theta_deg, value, .. } in &mut self.readings {
            *value /= match stated {
                Stated::Flux | Stated::Bsdf => 1.0,
                Stated::Ars => theta_deg.to_radians().cos(),
                Stated::Factor => std::f64::consts::PI,
                Stated::Counts => peak / Stated::COUNTS_PEAK,
            };
        }
        self.meta.state(stated);
        self.meta.stated = self.meta.stated.filter(|s| *s == Stated::Counts);
        Ok(self)
    }

    /// All readings, by incidence, then by observation angle; never empty.
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The quantity of the readings, from the header; [`Quantity::Flux`] without one.
    pub fn quantity(&self) -> Quantity {
        self.meta.quantity.unwrap_or_default()
    }

    /// Whether the readings are proportional to flux by an unknown factor, which a fit has to find.
    pub fn is_relative(&self) -> bool {
        self.meta.stated == Some(Stated::Counts)
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

    /// The readings grouped by plane of observation, in their order.
    pub fn by_plane(&self) -> impl Iterator<Item = Plane<'_>> {
        let mut start = 0;
        self.readings.chunk_by(Reading::is_in_plane_of).map(move |readings| {
            let range = start..start + readings.len();
            start = range.end;
            let Reading { sigma_deg, rotation_deg, phi_deg, .. } = readings[0];
            Plane { sigma_deg, rotation_deg, phi_deg, range, readings }
        })
    }

    /// Whether all readings are in the plane of incidence, of one rotation of the sample.
    pub fn is_in_plane(&self) -> bool {
        let first = self.readings[0].rotation_deg;
        let in_plane =
            |r: &Reading| r.phi_deg.abs() <= 0.0 && r.rotation_deg.total_cmp(&first).is_eq();
        self.readings.iter().all(in_plane)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(sigma_deg: f64, theta_deg: f64, value: f64) -> Reading {
        Reading::in_plane(sigma_deg, theta_deg, value)
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
    fn what_is_stated_becomes_a_quantity() {
        let scan = |stated: &str| {
            let mut meta = Metadata::default();
            meta.set("quantity", stated).unwrap();
            let readings =
                vec![reading(10.0, 60.0, 3.0), reading(10.0, 90.0, 0.0), reading(10.0, 0.0, 1.0)];
            Measurement::new(meta, readings).unwrap()
        };
        let values =
            |scan: &Measurement| scan.readings().iter().map(|r| r.value).collect::<Vec<_>>();
        let near = |scan: &Measurement, expected: &[f64]| {
            let values = values(scan);
            assert_eq!(values.len(), expected.len());
            for (a, b) in values.iter().zip(expected) {
                assert!((a - b).abs() <= 1e-15 * b.abs(), "{values:?} is not {expected:?}");
            }
        };
        let bsdf = Some(Quantity::Bsdf);
        // ars = f cos 60 deg = f / 2; at 90 deg it says nothing
        let ars = scan("ars");
        assert_eq!((ars.meta.quantity, ars.meta.stated), (bsdf, None));
        near(&ars, &[1.0, 6.0]);
        let factor = scan("factor");
        assert_eq!((factor.meta.quantity, factor.meta.stated), (bsdf, None));
        near(&factor, &[1.0, 3.0, 0.0].map(|r| r / std::f64::consts::PI));
        let counts = scan("counts");
        assert!(counts.is_relative() && counts.quantity() == Quantity::Flux);
        near(&counts, &[1e-3 / 3.0, 1e-3, 0.0]);
        // what is converted once stays as it is
        for made in [ars, factor, counts] {
            assert_eq!(Measurement::new(made.meta.clone(), made.readings.clone()).unwrap(), made);
        }
        assert_eq!(values(&scan("bsdf")), values(&scan("flux")));
        let mut meta = Metadata::default();
        meta.state(Stated::Ars);
        let dark = Measurement::new(meta, vec![reading(0.0, 90.0, 1.0)]).unwrap_err();
        assert_eq!(dark.fault, ReadingFault::AllDark);
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

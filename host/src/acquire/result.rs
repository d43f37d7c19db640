//! From a complete journal to a scan file.
//!
//! The file follows from schedule, instrument, calibrations and points alone: how often the line was lost
//! or the program ended leaves no trace in it.

use thiserror::Error;

use super::conditions;
use super::error::plain;
use super::journal::{Journal, Stored};
use super::signal;
use crate::measurement::{InvalidReading, Measurement, Metadata, Quantity, Reading, write};

/// Readings above the beam without the sample: the lamp has drifted, or the reference was too low.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AboveBeam {
    /// The number.
    pub count: u64,
    /// The largest: angle of incidence and of observation, degrees, and value.
    pub largest: Reading,
}

impl AboveBeam {
    /// Those of a scan; `None` if there are none.
    fn of(readings: &[Reading]) -> Option<Self> {
        let above = readings.iter().filter(|reading| signal::is_above_beam(reading.value));
        let count = above.clone().count() as u64;
        let largest = above.max_by(|a, b| a.value.total_cmp(&b.value))?;
        Some(Self { count, largest: *largest })
    }
}

/// A scan file, and what the user should know about it.
pub(super) struct Finished {
    pub(super) bytes: Vec<u8>,
    pub(super) above_beam: Option<AboveBeam>,
}

/// The scan file.
///
/// # Errors
/// [`NoScan`] if the readings do not make a scan, for example if all are dark, or are impossible, as in a journal of
/// an earlier version.
pub(super) fn scan_file(journal: &Journal) -> Result<Finished, NoScan> {
    let schedule = journal.schedule();
    let mut readings = Vec::new();
    for (k, sigma) in schedule.sigmas().iter().enumerate() {
        for (index, point) in (0..schedule.count()).zip(journal.points(k)) {
            let theta = schedule.theta(index).degrees();
            let reading = Reading::in_plane(sigma.degrees(), theta, relative(journal, point));
            if reading.value.is_finite() && !signal::is_possible(reading.value) {
                return Err(NoScan::Impossible(reading));
            }
            readings.push(reading);
        }
    }
    let above_beam = AboveBeam::of(&readings);
    let mut bytes = Vec::new();
    let scan = Measurement::new(header(journal), readings)?;
    // writing to memory cannot fail
    let _ = write::write(&scan, &mut bytes);
    Ok(Finished { bytes, above_beam })
}

/// Why complete points are no scan.
#[derive(Debug, Error)]
pub enum NoScan {
    /// No readings of a goniophotometer.
    #[error(transparent)]
    Invalid(#[from] InvalidReading),
    /// More light than the beam has.
    #[error(
        "at sigma {} deg, theta {} deg the reading is {} times the beam without the sample; the reference is \
         wrong: delete the journal and measure again",
        .0.sigma_deg, .0.theta_deg, plain(.0.value)
    )]
    Impossible(Reading),
}

/// A reading relative to the beam without the sample; NaN, which is refused, without its calibration.
fn relative(journal: &Journal, point: &Stored) -> f64 {
    let calibration = journal.calibrations().get(point.calibration);
    calibration.map_or(f64::NAN, |stored| signal::relative(&stored.values, &point.reading))
}

/// The header. Aperture, integration time and range are what the instrument reported: no point is in the
/// journal unless its status was the schedule's.
fn header(journal: &Journal) -> Metadata {
    let schedule = journal.schedule();
    let (model, serial) = journal.instrument();
    let ids = journal.calibrations().iter().map(|stored| format!("{:08x}", stored.values.id));
    let mut ids: Vec<String> = ids.collect();
    // calibrations with one identity are the same
    ids.dedup();
    let integration = f64::from(schedule.integration_us()) / 1e3;
    Metadata {
        sample: schedule.sample.clone(),
        instrument: Some(format!("{model}, serial number {serial}")),
        geometry: Some(schedule.geometry),
        ior: schedule.ior,
        rough_side: schedule.rough_side,
        aperture_deg: Some(schedule.aperture().degrees()),
        wavelength_nm: schedule.wavelength_nm,
        calibration: Some(format!("relative to the beam without sample; {}", ids.join(", "))),
        quantity: Some(Quantity::Flux),
        other: vec![
            ("integration_ms".to_owned(), integration.to_string()),
            ("range".to_owned(), conditions::range(schedule.range())),
        ],
        ..Metadata::default()
    }
}

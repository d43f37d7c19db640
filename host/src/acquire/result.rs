//! From a complete journal to a scan file.
//!
//! The file follows from plan, instrument, calibrations and points alone: how often the line was lost
//! or the program ended leaves no trace in it.

use asperity_core::protocol::Range;

use super::journal::{Journal, Stored};
use crate::measurement::{InvalidReading, Measurement, Metadata, Quantity, Reading, write};

/// The scan file.
///
/// # Errors
/// [`InvalidReading`] where the readings are no scan, as when all are dark.
pub(super) fn scan_file(journal: &Journal) -> Result<Vec<u8>, InvalidReading> {
    let plan = journal.plan();
    let mut readings = Vec::new();
    for (k, sigma) in plan.sigmas().iter().enumerate() {
        for (index, point) in (0..plan.count()).zip(journal.points(k)) {
            readings.push(Reading {
                sigma_deg: sigma.degrees(),
                theta_deg: plan.theta(index).degrees(),
                value: relative(journal, point),
            });
        }
    }
    let mut bytes = Vec::new();
    let scan = Measurement::new(header(journal), readings)?;
    // writing to memory cannot fail
    let _ = write::write(&scan, &mut bytes);
    Ok(bytes)
}

/// A reading relative to the beam without the sample; NaN, which is refused, without its calibration.
fn relative(journal: &Journal, point: &Stored) -> f64 {
    let calibration = journal.calibrations().get(point.calibration).map(|stored| &stored.values);
    let Some(calibration) = calibration else { return f64::NAN };
    let dark = calibration.dark.get(usize::from(calibration.range)).copied().unwrap_or(f32::NAN);
    let beam = f64::from(calibration.reference) - f64::from(dark);
    (f64::from(point.reading.signal) - f64::from(point.reading.dark)) / beam
}

fn header(journal: &Journal) -> Metadata {
    let plan = journal.plan();
    let (model, serial) = journal.instrument();
    let ids = journal.calibrations().iter().map(|stored| format!("{:08x}", stored.values.id));
    let mut ids: Vec<String> = ids.collect();
    // calibrations with one identity are the same
    ids.dedup();
    let range = match plan.range() {
        Range::Auto => "auto".to_owned(),
        Range::Fixed(number) => number.to_string(),
    };
    let integration = f64::from(plan.integration_us()) / 1e3;
    Metadata {
        sample: plan.sample.clone(),
        instrument: Some(format!("{model}, serial number {serial}")),
        geometry: Some(plan.geometry),
        ior: plan.ior,
        rough_side: plan.rough_side,
        aperture_deg: Some(plan.aperture().degrees()),
        wavelength_nm: plan.wavelength_nm,
        calibration: Some(format!("relative to the beam without sample; {}", ids.join(", "))),
        quantity: Some(Quantity::Flux),
        other: vec![
            ("integration_ms".to_owned(), integration.to_string()),
            ("range".to_owned(), range),
        ],
        ..Metadata::default()
    }
}

//! What a fit is made to: a scan file, or a model that the virtual goniophotometer measures.
//!
//! The latter says one law by another, such as the ABg parameters of a fitted plate for an optical design program; the error of the
//! fit is that of the conversion.

use std::path::Path;

use asperity_core::gonio::{Geometry, gp200};
use asperity_core::plate::RoughSide;

use super::error::{Failure, without_effect};
use super::flags::scan::{ReadFlags, SetupFlags};
use super::{progress, say};
use crate::boundary::Boundary;
use crate::law_file;
use crate::measurement::{Measurement, Quantity, csv};
use crate::provenance::InputFile;
use crate::reconstruct::{ScanRequest, Subject};

/// Step of the angle of observation, degrees.
const STEP_DEG: f64 = 0.25;

/// What a fit is made to.
pub(super) struct Given {
    pub(super) scan: Measurement,
    pub(super) input: InputFile,
    /// Whether it is a model that was measured: nothing is wrong with such readings.
    pub(super) is_model: bool,
}

/// Reads a scan, or measures the model in a file.
pub(super) fn read(path: &Path, read: &ReadFlags, setup: &SetupFlags) -> Result<Given, Failure> {
    let bytes = csv::load(path)?;
    if !law_file::is_law(path, &bytes) {
        let (scan, input) = read.read(path, setup)?;
        return Ok(Given { scan, input, is_model: false });
    }
    without_effect(&read.given(), "a model is measured, not read")?;
    let subject = Subject::read(path)?;
    // where there are values, they need no detector
    let has_values =
        !subject.boundary.is_traced() && !matches!(subject.boundary, Boundary::Wave(_));
    let usual = if has_values { 0.0 } else { gp200::APERTURE_DEG };
    let aperture_deg = setup.aperture.unwrap_or(usual);
    let request = ScanRequest {
        step_deg: STEP_DEG,
        aperture_deg,
        geometry: setup.geometry.map(Geometry::from),
        rough_side: setup.rough_side.map_or(RoughSide::Source, RoughSide::from),
        quantity: if aperture_deg > 0.0 { Quantity::Flux } else { Quantity::Bsdf },
        ..ScanRequest::default()
    };
    let scan = progress::bar(0, "measuring").watch(|watch| request.run(&subject, watch))?;
    if scan.interrupted {
        return Err(Failure::No(
            "interrupted while the model was measured; no fit was made".into(),
        ));
    }
    let what = if aperture_deg > 0.0 { "readings of flux" } else { "values of its BSDF" };
    say::note(format_args!(
        "{}: a model; the fit is to {what} in the plane of incidence at 0, 15, 30, 45 and 60 deg, as a plate shows them",
        path.display()
    ));
    let input = InputFile::of_bytes(path, &bytes);
    Ok(Given { scan: scan.measurement, input, is_model: true })
}

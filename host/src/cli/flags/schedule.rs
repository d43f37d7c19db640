//! The flags of a schedule.

use std::path::{Path, PathBuf};

use super::scan::number;
use crate::acquire::Draft;
use crate::acquire::draft::RangeWord;
use crate::cli::error::Failure;
use crate::measurement::AngleRange;
use crate::plan::Plan;

/// What is measured; without a schedule file and flags, as on the GP-200.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "The schedule")]
pub(in crate::cli) struct ScheduleFlags {
    /// Schedule file (TOML), or a plan made by `asperity plan`, whose schedule it is; flags go before it
    #[arg(long, alias = "plan", value_name = "FILE")]
    schedule: Option<PathBuf>,
    /// Angles of incidence in degrees [default: 0,15,30,45,60]
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', allow_hyphen_values = true)]
    sigma: Option<Vec<f64>>,
    /// Angles of observation, FROM:TO in degrees [default: -90:90]
    #[arg(long, value_name = "FROM:TO", allow_hyphen_values = true)]
    theta_range: Option<String>,
    /// Step of the angle of observation in degrees [default: 0.1]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = number)]
    step: Option<f64>,
    /// FULL angle of the detector's cone in degrees [default: 0.6]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = number)]
    aperture: Option<f64>,
    /// Integration time of a reading in ms [default: 100]
    #[arg(long, value_name = "MS", allow_hyphen_values = true, value_parser = number)]
    integration_ms: Option<f64>,
    /// Range of the detector, 0 (coarsest) to 5, or auto [default: auto]
    #[arg(long, value_name = "N")]
    range: Option<String>,
    /// How far below its first angle a segment is approached, degrees [default: 0.5]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = number)]
    run_up: Option<f64>,
    /// Calibrate once, or before each incidence: per-sigma [default: once]
    #[arg(long, value_name = "WHEN")]
    calibrate: Option<String>,
    /// Side of the detector: transmission or reflection [default: transmission]
    #[arg(long, value_name = "SIDE")]
    geometry: Option<String>,
    /// Name of the sample, for the header
    #[arg(long, value_name = "NAME")]
    sample: Option<String>,
    /// Index of refraction of the plate, for the header
    #[arg(long, value_name = "N", value_parser = number)]
    ior: Option<f64>,
    /// Which way the rough face looks, source or detector, for the header
    #[arg(long, value_name = "SIDE")]
    rough_side: Option<String>,
    /// Wavelength of the light in nm, for the header
    #[arg(long, value_name = "NM", value_parser = number)]
    wavelength_nm: Option<f64>,
}

impl ScheduleFlags {
    /// What flags and schedule file say together.
    pub(in crate::cli) fn draft(&self) -> Result<Draft, Failure> {
        let file = self.schedule.as_deref().map(of_file).transpose()?.unwrap_or_default();
        let range = self.theta_range.as_deref().map(str::parse::<AngleRange>).transpose();
        let range = range.map_err(|e| Failure::bad(format!("--theta-range: {e}")))?;
        // an open end is the end of the instrument's usual range
        let end = |degrees: f64, usual| if degrees.is_finite() { degrees } else { usual };
        let flags = Draft {
            sigma_deg: self.sigma.clone(),
            theta_from_deg: range.as_ref().map(|range| end(range.min_deg(), -90.0)),
            theta_to_deg: range.as_ref().map(|range| end(range.max_deg(), 90.0)),
            theta_step_deg: self.step,
            aperture_deg: self.aperture,
            integration_ms: self.integration_ms,
            range: self.range.clone().map(RangeWord::Word),
            run_up_deg: self.run_up,
            calibrate: self.calibrate.clone(),
            geometry: self.geometry.clone(),
            sample: self.sample.clone(),
            ior: self.ior,
            rough_side: self.rough_side.clone(),
            wavelength_nm: self.wavelength_nm,
        };
        Ok(flags.or(file))
    }
}

/// The schedule in a file: its content tells whether it is a schedule or a plan.
fn of_file(path: &Path) -> Result<Draft, Failure> {
    if !Plan::is_plan_file(path) {
        return Ok(Draft::read(path)?);
    }
    let plan = Plan::read(path).map_err(Failure::bad)?;
    plan.measure.map(|measure| measure.schedule).ok_or_else(|| {
        Failure::bad(format!(
            "{}: the plan has no schedule, for its surface is a model already; give a schedule file",
            path.display()
        ))
    })
}

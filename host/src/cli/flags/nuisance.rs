//! What the instrument may be wrong about: the flags of `fit`.

use super::scan::number;
use crate::cli::error::Failure;
use crate::fit::{MOST_GAINS, Nuisance};
use crate::measurement::Measurement;
use crate::reconstruct::Task;

/// Numbers of the instrument that are fitted too, each with the standard deviation of its prior.
#[derive(Debug, clap::Args)]
#[command(
    next_help_heading = "Instrument (fitted too, within what is known of it)"
)]
pub(in crate::cli) struct NuisanceFlags {
    /// Fit the zeros of theta and sigma too, known to DEG [default: 0.3]
    #[arg(long, hide_short_help = true, value_name = "DEG", num_args = 0..=1, require_equals = true, default_missing_value = "0.3", value_parser = number)]
    fit_offset: Option<f64>,
    /// Fit stray light in all readings too, known to PERCENT of the largest [default: 0.1]
    #[arg(long, hide_short_help = true, value_name = "PERCENT", num_args = 0..=1, require_equals = true, default_missing_value = "0.1", value_parser = number)]
    fit_stray: Option<f64>,
    /// Fit the detector's aperture too, known to PERCENT [default: 10]
    #[arg(long, hide_short_help = true, value_name = "PERCENT", num_args = 0..=1, require_equals = true, default_missing_value = "10", value_parser = number)]
    fit_aperture: Option<f64>,
    /// Fit a factor of each incidence too, known to PERCENT [default: 5]
    #[arg(long, hide_short_help = true, value_name = "PERCENT", num_args = 0..=1, require_equals = true, default_missing_value = "5", value_parser = number)]
    fit_gains: Option<f64>,
    /// The factor of --fit-gain is 1 to PERCENT; without it nothing is known of it
    #[arg(long, hide_short_help = true, value_name = "PERCENT", requires = "fit_gain", value_parser = number)]
    gain_prior: Option<f64>,
}

impl NuisanceFlags {
    /// The flags with whether they are given.
    pub(in crate::cli) fn given(&self) -> [(&'static str, bool); 4] {
        [
            ("--fit-offset", self.fit_offset.is_some()),
            ("--fit-stray", self.fit_stray.is_some()),
            ("--fit-aperture", self.fit_aperture.is_some()),
            ("--fit-gains", self.fit_gains.is_some()),
        ]
    }

    /// The numbers, checked.
    pub(in crate::cli) fn nuisance(&self, scan: &Measurement) -> Result<Nuisance, Failure> {
        let widths =
            [self.fit_offset, self.fit_stray, self.fit_aperture, self.fit_gains, self.gain_prior];
        if widths.into_iter().flatten().any(|w| !(w > 0.0 && w.is_finite())) {
            return Err(Failure::bad("what is known of the instrument must be above 0"));
        }
        let tilts = scan.incidences();
        if self.fit_gains.is_some() && tilts.len() > MOST_GAINS {
            return Err(Failure::bad(format!(
                "--fit-gains is for at most {MOST_GAINS} incidences, and there are {}; choose some with --sigma-range",
                tilts.len()
            )));
        }
        let share = |percent: Option<f64>| percent.map(|p| 0.01 * p);
        // normal incidence tells nothing of a zero of sigma but by its sign
        let tilted = tilts.iter().any(|t| *t > 0.0);
        Ok(Nuisance {
            theta_zero_deg: self.fit_offset,
            sigma_zero_deg: self.fit_offset.filter(|_| tilted),
            stray: share(self.fit_stray),
            aperture: share(self.fit_aperture),
            gain: share(self.gain_prior),
            gains: share(self.fit_gains),
        })
    }

    /// Refuses an aperture of readings that have none.
    pub(in crate::cli) fn check(&self, task: &Task<'_>) -> Result<(), Failure> {
        if self.fit_aperture.is_some() && task.setup.aperture_deg <= 0.0 {
            return Err(Failure::bad(
                "--fit-aperture is for readings in an aperture; values of a BSDF have none",
            ));
        }
        Ok(())
    }
}

//! What the instrument may be wrong about: the flags of `fit`.

use std::path::PathBuf;

use super::scan::number;
use crate::cli::error::Failure;
use crate::fit::{Doubts, MOST_GAINS, Nuisance, Signature};
use crate::forward::Setup;
use crate::measurement::{Measurement, csv};
use crate::reconstruct::Task;

/// Numbers of the instrument that are fitted too, each with the standard deviation of its prior.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Instrument (fitted too, within what is known of it)")]
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
    /// A scan without a sample: the response of beam and detector, in place of an ideal cone
    #[arg(long, hide_short_help = true, value_name = "FILE", conflicts_with = "beam_width")]
    signature: Option<PathBuf>,
    /// FULL angle of a round beam, whose overlap with the detector is the response
    #[arg(long, hide_short_help = true, value_name = "DEG", value_parser = number)]
    beam_width: Option<f64>,
    /// FULL height of a slit across the plane of observation; the aperture is then its width
    #[arg(long, hide_short_help = true, value_name = "DEG", conflicts_with_all = ["signature", "beam_width"], value_parser = number)]
    slit_height: Option<f64>,
    /// Doubts about the instrument that are not fitted, one standard deviation each: offset=0.05,gain=1,drift=0.3 and also
    /// gains, stray, aperture (percent), ior; they enter the errors, and a budget is printed
    #[arg(long, hide_short_help = true, value_name = "KEY=VALUE,...", value_parser = doubts)]
    uncertainty: Option<Doubts>,
    /// Fit N scans that the fitted law would have given, with its noise and the doubts of --uncertainty
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000))]
    bootstrap: Option<u32>,
}

/// Doubts as text: angles in degrees, the index as it is, all others in percent.
fn doubts(text: &str) -> Result<Doubts, String> {
    let mut found = Doubts::default();
    for part in text.split(',') {
        let (key, value) =
            part.split_once('=').ok_or_else(|| format!("`{part}` is no KEY=VALUE"))?;
        let value: f64 = value.trim().parse().map_err(|_| format!("`{value}` is no number"))?;
        if !(value > 0.0 && value.is_finite()) {
            return Err(format!("{key} = {value} must be above 0"));
        }
        let share = Some(0.01 * value);
        match key.trim() {
            "offset" => found.offset_deg = Some(value),
            "ior" => found.ior = Some(value),
            "gain" => found.gain = share,
            "gains" => found.gains = share,
            "drift" => found.drift = share,
            "stray" => found.stray = share,
            "aperture" => found.aperture = share,
            other => {
                return Err(format!(
                    "`{other}` is no doubt; the doubts are offset (deg), ior, and in percent gain, gains, drift, stray, aperture"
                ));
            }
        }
    }
    Ok(found)
}

impl NuisanceFlags {
    /// The flags with whether they are given.
    pub(in crate::cli) fn given(&self) -> [(&'static str, bool); 8] {
        [
            ("--slit-height", self.slit_height.is_some()),
            ("--signature", self.signature.is_some()),
            ("--beam-width", self.beam_width.is_some()),
            ("--bootstrap", self.bootstrap.is_some()),
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

    /// The response of the instrument, where it is no ideal cone.
    pub(in crate::cli) fn signature(
        &self,
        aperture_deg: f64,
    ) -> Result<Option<Signature>, Failure> {
        if let Some(path) = &self.signature {
            let scan = csv::parse(&csv::load(path)?, path)?;
            let found = Signature::of_scan(&scan);
            return found.map(Some).map_err(|e| Failure::bad(format!("{}: {e}", path.display())));
        }
        let beam = self.beam_width.map(|beam| Signature::of_beam(beam, aperture_deg));
        beam.transpose().map_err(Failure::bad)
    }

    /// The detector with its slit, if it has one.
    pub(in crate::cli) fn opening(&self, setup: Setup) -> Result<Setup, Failure> {
        let Some(height) = self.slit_height else { return Ok(setup) };
        if !(height > 0.0 && height <= 60.0) {
            return Err(Failure::bad(
                "--slit-height is the full height in degrees, above 0 and at most 60",
            ));
        }
        if setup.aperture_deg <= 0.0 {
            return Err(Failure::bad(
                "--slit-height needs the width of the slit; add --aperture DEG",
            ));
        }
        Ok(Setup { slit_height_deg: Some(height), ..setup })
    }

    /// Whether the response is other than a cone.
    pub(in crate::cli) fn has_response(&self) -> bool {
        self.slit_height.is_some() || self.signature.is_some() || self.beam_width.is_some()
    }

    /// The doubts that are not fitted.
    pub(in crate::cli) fn doubts(&self) -> Doubts {
        self.uncertainty.unwrap_or_default()
    }

    /// Replicas of the bootstrap.
    pub(in crate::cli) fn replicas(&self) -> u32 {
        self.bootstrap.unwrap_or(0)
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

#[cfg(test)]
mod tests {
    use super::doubts;

    #[test]
    fn doubts_have_units() {
        let found = doubts("offset=0.05,gain=1,drift=0.3,ior=0.002").unwrap();
        assert_eq!(
            (found.offset_deg, found.gain, found.ior),
            (Some(0.05), Some(0.01), Some(0.002))
        );
        assert!((found.drift.unwrap() - 0.003).abs() < 1e-15 && found.stray.is_none());
        for bad in ["gain", "gain=x", "gain=-1", "weather=1", ""] {
            assert!(doubts(bad).is_err(), "{bad}");
        }
    }
}

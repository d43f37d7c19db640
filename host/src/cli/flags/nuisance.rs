//! What the instrument may be wrong about, and the index of the body: the flags of `fit`, `compare` and `trade`.

use std::path::PathBuf;

use super::scan::number;
use crate::cli::error::{Failure, without_effect};
use crate::fit::{Doubts, FitOptions, MOST_GAINS, Nuisance, Signature};
use crate::forward::Setup;
use crate::measurement::{Measurement, csv};
use crate::method::Body;

/// Why nothing of the instrument is fitted where laws are ranked.
pub(in crate::cli) const RANKED_FOR: &str = "laws are ranked for an instrument that is known";

/// Numbers beside the law that are fitted too; those of the instrument have the standard deviation of their prior.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Index and instrument (fitted too, within what is known of them)")]
pub(in crate::cli) struct NuisanceFlags {
    /// Fit the refractive index too; --ior or the header gives the start
    #[arg(long)]
    fit_ior: bool,
    /// Fit a calibration factor on all readings too (an opaque body always has one)
    #[arg(long)]
    fit_gain: bool,
    /// Fit the zeros of theta and sigma too, known to DEG [default: 0.3]
    #[arg(long, hide_short_help = true, value_name = "DEG", num_args = 0..=1, require_equals = true, default_missing_value = "0.3", value_parser = number)]
    fit_offset: Option<f64>,
    /// Fit stray light in all readings too, known to PERCENT of the largest [default: 0.1]
    #[arg(long, hide_short_help = true, value_name = "PERCENT", num_args = 0..=1, require_equals = true, default_missing_value = "0.1", value_parser = number)]
    fit_stray: Option<f64>,
    /// Fit the detector's aperture too, known to PERCENT [default: 10]
    #[arg(long, hide_short_help = true, value_name = "PERCENT", num_args = 0..=1, require_equals = true, default_missing_value = "10", value_parser = number)]
    fit_aperture: Option<f64>,
    /// Fit a factor of each incidence too, known to PERCENT [default: 5]; free: the levels of the incidences mean nothing, as where
    /// each is normalised to its own peak
    #[arg(long, hide_short_help = true, value_name = "PERCENT|free", num_args = 0..=1, require_equals = true, default_missing_value = "5", value_parser = Gains::parse)]
    fit_gains: Option<Gains>,
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
}

/// What is known of the factor of each incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Gains {
    /// Nothing.
    Free,
    /// That it is 1 to so many percent.
    Known(f64),
}

impl Gains {
    fn parse(text: &str) -> Result<Self, String> {
        if text == "free" { Ok(Self::Free) } else { number(text).map(Self::Known) }
    }

    fn percent(self) -> Option<f64> {
        match self {
            Self::Free => None,
            Self::Known(percent) => Some(percent),
        }
    }
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
    /// The flags of the instrument with whether they are given.
    fn of_instrument(&self) -> [(&'static str, bool); 7] {
        [
            ("--slit-height", self.slit_height.is_some()),
            ("--signature", self.signature.is_some()),
            ("--beam-width", self.beam_width.is_some()),
            ("--fit-offset", self.fit_offset.is_some()),
            ("--fit-stray", self.fit_stray.is_some()),
            ("--fit-aperture", self.fit_aperture.is_some()),
            ("--fit-gains", self.fit_gains.is_some()),
        ]
    }

    /// Refuses the flags of the instrument where laws are ranked.
    pub(in crate::cli) fn need_none(&self) -> Result<(), Failure> {
        without_effect(&self.of_instrument(), RANKED_FOR)
    }

    /// All flags with whether they are given.
    pub(in crate::cli) fn given(&self) -> Vec<(&'static str, bool)> {
        let others = [
            ("--fit-ior", self.fit_ior),
            ("--fit-gain", self.fit_gain),
            ("--uncertainty", self.uncertainty.is_some()),
        ];
        self.of_instrument().into_iter().chain(others).collect()
    }

    /// Options of a fit with what is fitted too, checked against the scan and the instrument that is known.
    pub(in crate::cli) fn apply(
        &self,
        usual: &FitOptions,
        scan: &Measurement,
        setup: &Setup,
    ) -> Result<FitOptions, Failure> {
        if !matches!(usual.body, Body::Dielectric { .. }) && (self.fit_ior || self.fit_gain) {
            return Err(Failure::bad(
                "--fit-ior and --fit-gain are for a plate; laws of an opaque body or a sheet have a level anyway and no index",
            ));
        }
        let is_free = self.fit_gains == Some(Gains::Free);
        if is_free && !matches!(usual.body, Body::Dielectric { .. }) {
            return Err(Failure::bad(
                "--fit-gains=free is for a plate: of other bodies the level of the law is free already; say what is known of the \
                 incidences beside each other, --fit-gains=PERCENT",
            ));
        }
        if is_free && self.gain_prior.is_some() {
            return Err(Failure::bad(
                "--gain-prior says nothing where --fit-gains=free; leave one of them out",
            ));
        }
        if self.fit_aperture.is_some() && setup.aperture_deg <= 0.0 {
            return Err(Failure::bad(
                "--fit-aperture is for readings in an aperture; values of a BSDF have none",
            ));
        }
        Ok(FitOptions {
            fit_ior: self.fit_ior,
            fit_gain: self.fit_gain || scan.is_relative(),
            nuisance: self.nuisance(scan)?,
            signature: self.signature(setup.aperture_deg)?,
            doubts: self.uncertainty.unwrap_or_default(),
            ..*usual
        })
    }

    /// The widths of the priors, checked.
    fn nuisance(&self, scan: &Measurement) -> Result<Nuisance, Failure> {
        let gains = self.fit_gains.and_then(Gains::percent);
        let widths = [self.fit_offset, self.fit_stray, self.fit_aperture, gains, self.gain_prior];
        if widths.into_iter().flatten().any(|w| !(w > 0.0 && w.is_finite())) {
            return Err(Failure::bad("what is known of the instrument must be above 0"));
        }
        let tilts = scan.incidences();
        if gains.is_some() && tilts.len() > MOST_GAINS {
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
            gains: share(gains),
            free_levels: self.fit_gains == Some(Gains::Free),
        })
    }

    /// The response of the instrument, where it is no ideal cone.
    fn signature(&self, aperture_deg: f64) -> Result<Option<Signature>, Failure> {
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

//! A plan written out, and its checksum: the way back from [`Plan`] to [`Draft`].

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::protocol::{Range, checksum};

use super::draft::{Draft, RangeWord};
use super::plan::{CalibrationRule, Plan};

impl Plan {
    /// The plan with nothing left unsaid.
    pub fn draft(&self) -> Draft {
        let word = |text: &str| Some(text.to_owned());
        Draft {
            sigma_deg: Some(self.sigmas.iter().map(|sigma| sigma.degrees()).collect()),
            theta_from_deg: Some(self.start.degrees()),
            theta_to_deg: Some(self.theta(self.count.saturating_sub(1)).degrees()),
            theta_step_deg: Some(self.step.degrees()),
            aperture_deg: Some(self.aperture.degrees()),
            integration_ms: Some(f64::from(self.integration_us) / 1e3),
            range: Some(match self.range {
                Range::Auto => RangeWord::Word("auto".to_owned()),
                Range::Fixed(number) => RangeWord::Number(i64::from(number)),
            }),
            run_up_deg: Some(self.run_up.degrees()),
            calibrate: word(match self.calibration {
                CalibrationRule::Once => "once",
                CalibrationRule::PerSigma => "per-sigma",
            }),
            geometry: word(match self.geometry {
                Geometry::Transmission => "transmission",
                Geometry::Reflection => "reflection",
            }),
            sample: self.sample.clone(),
            ior: self.ior,
            rough_side: self.rough_side.and_then(|side| {
                word(match side {
                    RoughSide::Source => "source",
                    RoughSide::Detector => "detector",
                })
            }),
            wavelength_nm: self.wavelength_nm,
        }
    }

    /// The plan as a plan file: the same text for the same plan, and the same plan from that text.
    pub fn text(&self) -> String {
        // such a structure has no value that TOML does not know
        toml::to_string(&self.draft()).unwrap_or_default()
    }

    /// CRC-32C of [`text`](Self::text).
    pub fn hash(&self) -> u32 {
        checksum(self.text().as_bytes())
    }
}

//! A schedule as a file or as flags say it: anything may be missing.
//!
//! ```toml
//! sigma_deg = [0, 15, 30, 45, 60]
//! theta_from_deg = -90
//! theta_to_deg = 90
//! theta_step_deg = 0.1
//! aperture_deg = 0.6
//! integration_ms = 100
//! range = "auto"            # or 0 (coarsest) to 5
//! calibrate = "once"        # or "per-sigma"
//! geometry = "transmission"
//! sample = "No 5"
//! ior = 1.49
//! rough_side = "source"
//! wavelength_nm = 550
//! ```

use asperity_core::gonio::{Geometry, gp200};
use asperity_core::protocol::{MAX_POINTS, Microdegrees, RANGES, Range};
use serde::{Deserialize, Serialize};

use super::error::plain;
use super::schedule::{CalibrationRule, Schedule};
use super::schedule_error::ScheduleError;
use crate::measurement::Metadata;
use crate::message::excerpt;

/// Longest number that a message repeats as it is.
const MOST_DIGITS: usize = 12;
/// Most angles of incidence.
const MAX_SIGMAS: usize = 1000;

/// What is said of a schedule; `None` is not said. Its text is TOML, in the same order each time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Draft {
    /// Angles of incidence, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_deg: Option<Vec<f64>>,
    /// First angle of observation, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta_from_deg: Option<f64>,
    /// Last angle of observation, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta_to_deg: Option<f64>,
    /// Distance of neighbours, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theta_step_deg: Option<f64>,
    /// Full angle of the detector's cone, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture_deg: Option<f64>,
    /// Integration time of a reading, ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integration_ms: Option<f64>,
    /// The detector's range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<RangeWord>,
    /// Distance below its first point from which a segment is approached, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run_up_deg: Option<f64>,
    /// `once` or `per-sigma`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibrate: Option<String>,
    /// `transmission` or `reflection`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry: Option<String>,
    /// Name of the sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<String>,
    /// Index of refraction relative to air.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ior: Option<f64>,
    /// `source` or `detector`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rough_side: Option<String>,
    /// Wavelength of the light, nm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelength_nm: Option<f64>,
}

/// A range by number, or `auto`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RangeWord {
    /// Always this one.
    Number(i64),
    /// `auto`, or a number as text.
    Word(String),
}

impl Draft {
    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// This draft, completed by the other one.
    pub fn or(self, other: Self) -> Self {
        Self {
            sigma_deg: self.sigma_deg.or(other.sigma_deg),
            theta_from_deg: self.theta_from_deg.or(other.theta_from_deg),
            theta_to_deg: self.theta_to_deg.or(other.theta_to_deg),
            theta_step_deg: self.theta_step_deg.or(other.theta_step_deg),
            aperture_deg: self.aperture_deg.or(other.aperture_deg),
            integration_ms: self.integration_ms.or(other.integration_ms),
            range: self.range.or(other.range),
            run_up_deg: self.run_up_deg.or(other.run_up_deg),
            calibrate: self.calibrate.or(other.calibrate),
            geometry: self.geometry.or(other.geometry),
            sample: self.sample.or(other.sample),
            ior: self.ior.or(other.ior),
            rough_side: self.rough_side.or(other.rough_side),
            wavelength_nm: self.wavelength_nm.or(other.wavelength_nm),
        }
    }

    /// The schedule; what is not said is as on the GP-200: incidences 0, 15, 30, 45, 60, observation -90
    /// to 90 in steps of 0.1, aperture 0.6, run-up 0.5 degrees; 100 ms, range `auto`, calibrated once,
    /// transmission.
    ///
    /// # Errors
    /// [`ScheduleError::Value`], [`ScheduleError::TooLong`].
    pub fn schedule(&self) -> Result<Schedule, ScheduleError> {
        let sigmas = self.sigmas()?;
        let (start, step, count) = self.grid()?;
        let header = self.header()?;
        Ok(Schedule {
            sigmas,
            start,
            step,
            count,
            aperture: angle(
                "aperture",
                self.aperture_deg.unwrap_or(gp200::APERTURE_DEG),
                APERTURE,
                |a| (1..=10 * Microdegrees::DEGREE).contains(&a),
            )?,
            integration_us: self.integration()?,
            range: self.range()?,
            run_up: angle("run_up", self.run_up_deg.unwrap_or(0.5), RUN_UP, |a| {
                (0..=10 * Microdegrees::DEGREE).contains(&a)
            })?,
            calibration: match self.calibrate.as_deref() {
                None | Some("once") => CalibrationRule::Once,
                Some("per-sigma") => CalibrationRule::PerSigma,
                Some(other) => return Err(wrong("calibrate", other, "write once or per-sigma")),
            },
            geometry: header.geometry.unwrap_or(Geometry::Transmission),
            sample: header.sample,
            ior: header.ior,
            rough_side: header.rough_side,
            wavelength_nm: header.wavelength_nm,
        })
    }

    fn sigmas(&self) -> Result<Vec<Microdegrees>, ScheduleError> {
        let given = self.sigma_deg.clone().unwrap_or_else(|| gp200::SIGMAS_DEG.to_vec());
        if given.is_empty() || given.len() > MAX_SIGMAS {
            let count = format!("of {} angles", given.len());
            return Err(wrong("sigma", &count, "give 1 to 1000 angles of incidence"));
        }
        let mut sigmas = Vec::with_capacity(given.len());
        for degrees in given {
            let inside = |a| (0..90 * Microdegrees::DEGREE).contains(&a);
            let sigma = angle("sigma", degrees, SIGMA, inside)?;
            if sigmas.contains(&sigma) {
                return Err(wrong("sigma", &number(degrees), "it is given twice; leave one out"));
            }
            sigmas.push(sigma);
        }
        Ok(sigmas)
    }

    fn grid(&self) -> Result<(Microdegrees, Microdegrees, u16), ScheduleError> {
        let quarter = 90 * Microdegrees::DEGREE;
        let inside = |a| (-quarter..=quarter).contains(&a);
        let from = angle(
            "theta_from",
            self.theta_from_deg.unwrap_or(gp200::THETAS_DEG[0]),
            THETA,
            inside,
        )?;
        let to =
            angle("theta_to", self.theta_to_deg.unwrap_or(gp200::THETAS_DEG[1]), THETA, inside)?;
        let step = angle("step", self.theta_step_deg.unwrap_or(gp200::STEP_DEG), STEP, |a| a > 0)?;
        if from > to {
            let range = format!("{}:{}", from.degrees(), to.degrees());
            return Err(wrong("theta_range", &range, "give the smaller angle first"));
        }
        let count = (i64::from(to.0) - i64::from(from.0)) / i64::from(step.0) + 1;
        match u16::try_from(count).ok().filter(|count| *count <= MAX_POINTS) {
            Some(count) => Ok((from, step, count)),
            None => Err(ScheduleError::TooLong { count }),
        }
    }

    fn integration(&self) -> Result<u32, ScheduleError> {
        let ms = self.integration_ms.unwrap_or(100.0);
        let us = (ms * 1e3).round();
        // written so that NaN is refused too
        if (100.0..=1e7).contains(&us) && (ms * 1e3 - us).abs() < 1e-3 {
            return Ok(us as u32);
        }
        let allowed = "give 0.1 to 10000 ms in whole microseconds";
        Err(wrong("integration_ms", &number(ms), allowed))
    }

    fn range(&self) -> Result<Range, ScheduleError> {
        let (text, number) = match &self.range {
            None => return Ok(Range::Auto),
            Some(RangeWord::Number(number)) => (number.to_string(), Some(*number)),
            Some(RangeWord::Word(word)) if word == "auto" => return Ok(Range::Auto),
            Some(RangeWord::Word(word)) => (word.clone(), word.parse().ok()),
        };
        let number = number.and_then(|n| u8::try_from(n).ok()).filter(|n| *n < RANGES);
        let allowed = "give auto, or a number from 0 (coarsest) to 5 (finest)";
        number.map(Range::Fixed).ok_or_else(|| wrong("range", &text, allowed))
    }

    /// The header of the scan, checked like that of a scan file.
    fn header(&self) -> Result<Metadata, ScheduleError> {
        let mut meta = Metadata::default();
        if let Some(sample) = &self.sample {
            if sample.chars().any(char::is_control) || sample.len() > 500 {
                let allowed = "give a name of one line, at most 500 bytes long";
                return Err(wrong("sample", sample, allowed));
            }
            meta.sample = Some(sample.trim().to_owned()).filter(|sample| !sample.is_empty());
        }
        let shown = |value: Option<f64>| value.map(|value| value.to_string());
        let values = [
            ("geometry", self.geometry.clone()),
            ("ior", shown(self.ior)),
            ("rough_side", self.rough_side.clone()),
            ("wavelength_nm", shown(self.wavelength_nm)),
        ];
        for (key, value) in values {
            let Some(value) = value else { continue };
            let known = match key {
                "geometry" => "write transmission or reflection",
                "ior" => "give the index relative to air, 0.1 to 10",
                "rough_side" => "write source or detector",
                _ => "give one wavelength in nm, 10 to 1e6",
            };
            if value.trim().is_empty() || meta.set(key, &value).is_err() {
                let said = value.parse().map_or(value, number);
                return Err(wrong(key, &said, known));
            }
        }
        Ok(meta)
    }
}

const SIGMA: &str = "give degrees from 0 to below 90, at most 6 decimals";
const THETA: &str = "give degrees from -90 to 90, at most 6 decimals";
const STEP: &str = "give degrees above 0, at most 6 decimals";
const APERTURE: &str = "give the full angle in degrees, above 0 to 10, at most 6 decimals";
const RUN_UP: &str = "give degrees from 0 to 10, at most 6 decimals";

fn wrong(key: &'static str, value: &str, allowed: &'static str) -> ScheduleError {
    ScheduleError::Value { key, value: excerpt(value), allowed }
}

/// A number that was given, with all its digits where they are few.
fn number(value: f64) -> String {
    let text = value.to_string();
    if text.len() <= MOST_DIGITS { text } else { plain(value) }
}

/// An angle of whole microdegrees.
fn angle(
    key: &'static str,
    degrees: f64,
    allowed: &'static str,
    inside: impl Fn(i32) -> bool,
) -> Result<Microdegrees, ScheduleError> {
    let exact = |angle: &Microdegrees| (degrees * 1e6 - f64::from(angle.0)).abs() < 1e-3;
    Microdegrees::from_degrees(degrees)
        .filter(|angle| exact(angle) && inside(angle.0))
        .ok_or_else(|| wrong(key, &number(degrees), allowed))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn read(text: &str) -> Result<Schedule, String> {
        let draft = Draft::parse(text, Path::new("p.toml")).map_err(|e| e.to_string())?;
        draft.schedule().map_err(|e| e.to_string())
    }

    #[test]
    fn the_usual_plan_is_that_of_the_gp_200() {
        let schedule = read("").unwrap();
        assert_eq!(
            (schedule.count, schedule.theta(900), schedule.points()),
            (1801, Microdegrees(0), 9005)
        );
        assert_eq!(schedule.sigmas.last(), Some(&Microdegrees(60_000_000)));
        assert_eq!(read(&schedule.text()).unwrap(), schedule);
    }

    #[test]
    fn a_plan_survives_its_text() {
        let text = "sigma_deg = [7.123456, 0]\ntheta_from_deg = -1\ntheta_to_deg = 1.05\n\
                    theta_step_deg = 0.3\naperture_deg = 1\nintegration_ms = 0.1\nrange = 3\n\
                    run_up_deg = 0\ncalibrate = \"per-sigma\"\ngeometry = \"reflection\"\n\
                    sample = 'a \"b\" # c'\nior = 1.4917\nrough_side = \"detector\"\n\
                    wavelength_nm = 632.8\n";
        let schedule = read(text).unwrap();
        assert_eq!((schedule.count, schedule.theta(6)), (7, Microdegrees(800_000)));
        assert_eq!(read(&schedule.text()).unwrap(), schedule);
        assert_ne!(schedule.hash(), read("").unwrap().hash());
        assert!(!schedule.text().lines().any(|line| line.trim().is_empty()), "{}", schedule.text());
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_the_remedy() {
        for (text, words) in [
            ("\nsigma_deg = [0,,1]", "p.toml:2: "),
            ("theta_deg = 1", "unknown field `theta_deg`"),
            ("ior = 1.5\nior = 1.6", "p.toml:2: "),
            ("sigma_deg = [90]", "sigma 90 is not usable; give degrees from 0 to below 90"),
            ("sigma_deg = [0, 0.0]", "given twice"),
            ("sigma_deg = []", "1 to 1000"),
            ("sigma_deg = [nan]", "sigma NaN"),
            ("theta_step_deg = 0.05", "3601 angles of observation are more than the 1801"),
            ("theta_step_deg = 0.0000001", "at most 6 decimals"),
            ("sigma_deg = [1e300]", "sigma 1.00000e300 is not usable"),
            ("integration_ms = -1e308", "integration_ms -1.00000e308 is not usable"),
            ("ior = 1e300", "ior 1.00000e300 is not usable"),
            ("theta_step_deg = 0", "above 0"),
            ("theta_from_deg = 1\ntheta_to_deg = 0", "smaller angle first"),
            ("aperture_deg = 11", "above 0 to 10"),
            ("integration_ms = 0.05", "0.1 to 10000"),
            ("integration_ms = inf", "0.1 to 10000"),
            ("range = 6", "range 6 is not usable; give auto"),
            ("range = \"fine\"", "range fine"),
            ("calibrate = \"never\"", "once or per-sigma"),
            ("geometry = \"up\"", "transmission or reflection"),
            ("ior = 0.09", "0.1 to 10"),
            ("sample = \"a\\nb\"", "one line"),
            ("wavelength_nm = 0.55", "in nm"),
        ] {
            let message = read(text).expect_err(text);
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}

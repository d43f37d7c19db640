//! A schedule as text: read from a file, and written out, with its checksum: the way back from [`Schedule`] to [`Draft`].

use std::io::ErrorKind;
use std::path::Path;

use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;
use asperity_core::protocol::{Range, checksum};

use super::draft::{Draft, RangeWord};
use super::schedule::{CalibrationRule, Schedule};
use super::schedule_error::ScheduleError;
use crate::input::read_file;

/// Largest schedule file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Longest message of the parser that is repeated, characters.
const MOST_WORDS: usize = 160;

impl Draft {
    /// Reads a schedule file.
    ///
    /// # Errors
    /// [`ScheduleError::Read`], [`ScheduleError::TooLarge`], [`ScheduleError::Syntax`] with file and line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ScheduleError> {
        let path = path.as_ref();
        let bytes = read_file(path, MAX_BYTES).map_err(|source| match source.kind() {
            ErrorKind::FileTooLarge | ErrorKind::InvalidInput => {
                ScheduleError::TooLarge { path: path.to_owned() }
            }
            _ => ScheduleError::Read { path: path.to_owned(), source },
        })?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let good = e.utf8_error().valid_up_to();
            let before = e.as_bytes().get(..good).unwrap_or(&[]);
            ScheduleError::Syntax {
                path: path.to_owned(),
                line: String::from_utf8_lossy(before).matches('\n').count() + 1,
                what: "is not UTF-8 text".to_owned(),
            }
        })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a schedule file; `path` is for messages.
    ///
    /// # Errors
    /// [`ScheduleError::Syntax`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, ScheduleError> {
        toml::from_str(text).map_err(|e| {
            let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or("");
            ScheduleError::Syntax {
                path: path.to_owned(),
                line: before.matches('\n').count() + 1,
                what: brief(e.message()),
            }
        })
    }
}

/// The message of a parser, in one line; it may repeat text of the file, however long.
fn brief(message: &str) -> String {
    let line = message.lines().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(MOST_WORDS) {
        Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
        None => line,
    }
}

impl Schedule {
    /// The schedule with nothing left unsaid.
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

    /// The schedule as a schedule file: the same text for the same schedule, and the same schedule from that text.
    pub fn text(&self) -> String {
        // such a structure has no value that TOML does not know
        toml::to_string(&self.draft()).unwrap_or_default()
    }

    /// CRC-32C of [`text`](Self::text).
    pub fn hash(&self) -> u32 {
        checksum(self.text().as_bytes())
    }
}

//! The settings that an instrument must have while it measures, and the check of its status.
//!
//! An accepted setting may still not be obeyed. The aperture, the integration time and the range in the scan file are
//! those that the instrument reported before and after every point.

use asperity_core::protocol::{Microdegrees, Range, Status};

use super::error::Trouble;
use super::schedule::Schedule;

/// Tolerance of an axis position, by its encoder, microdegrees.
pub(super) const OFF_TARGET: u32 = 20_000;

/// Settings as the schedule wants them, and where the sample stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions<'a> {
    schedule: &'a Schedule,
    /// The angle of the sample; `None` before it was set.
    sigma: Option<Microdegrees>,
}

impl<'a> Conditions<'a> {
    /// Those of a schedule, the sample standing anywhere.
    pub(super) fn of(schedule: &'a Schedule) -> Self {
        Self { schedule, sigma: None }
    }

    /// The same at an incidence.
    pub(super) fn at(self, sigma: Microdegrees) -> Self {
        Self { sigma: Some(sigma), ..self }
    }

    /// Compares.
    ///
    /// # Errors
    /// [`Trouble::Disobeyed`] with the first setting that is not as it was set.
    pub(super) fn check(&self, status: &Status) -> Result<(), Trouble> {
        let schedule = self.schedule;
        let degrees = |angle: Microdegrees| format!("{} deg", angle.degrees());
        let ms = |us: u32| format!("{} ms", f64::from(us) / 1e3);
        let disobeyed = |what, wanted: String, reported: String| {
            Err(Trouble::Disobeyed { what, wanted, reported })
        };
        if !status.lamp {
            return disobeyed("the lamp", "on".to_owned(), "off".to_owned());
        }
        if status.aperture != schedule.aperture() {
            return disobeyed(
                "the aperture",
                degrees(schedule.aperture()),
                degrees(status.aperture),
            );
        }
        if status.integration_us != schedule.integration_us() {
            let (wanted, reported) = (ms(schedule.integration_us()), ms(status.integration_us));
            return disobeyed("the integration time", wanted, reported);
        }
        if status.range != schedule.range() {
            return disobeyed("the range", range(schedule.range()), range(status.range));
        }
        match self.sigma {
            Some(sigma) if status.sigma.0.abs_diff(sigma.0) > OFF_TARGET => {
                disobeyed("the angle of incidence", degrees(sigma), degrees(status.sigma))
            }
            _ => Ok(()),
        }
    }
}

/// A range in words.
pub(super) fn range(range: Range) -> String {
    match range {
        Range::Auto => "auto".to_owned(),
        Range::Fixed(number) => number.to_string(),
    }
}

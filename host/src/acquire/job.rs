//! What an acquisition is asked for, and how far it is.

use std::path::Path;

use super::patience::Patience;
use super::schedule::Schedule;

/// A request to measure.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// What to measure; on resuming `None` takes the journal's schedule.
    pub schedule: Option<Schedule>,
    /// The scan file; the journal stands beside it.
    pub output: &'a Path,
    /// Points that may be in flight, 1 to 1801: at most so many are measured again after a power failure.
    pub credit: u16,
    /// Continue the journal.
    pub resume: bool,
    /// On resuming, calibrate again where the instrument has lost its calibration.
    pub recalibrate: bool,
    /// The limits of all waits.
    pub patience: Patience,
}

/// Progress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Points stored.
    pub done: u64,
    /// Points of the schedule.
    pub total: u64,
    /// Remaining time at the pace so far, seconds.
    pub seconds_left: f64,
}

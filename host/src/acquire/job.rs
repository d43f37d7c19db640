//! What an acquisition is asked for, and how far it is.

use std::path::Path;

use super::patience::Patience;
use super::schedule::Schedule;

/// What is to be done.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// What to measure; on resuming `None` takes the journal's schedule.
    pub schedule: Option<Schedule>,
    /// The scan file; the journal stands beside it.
    pub output: &'a Path,
    /// Points that may be under way, 1 to 1801: what is measured again at most after the end of power.
    pub credit: u16,
    /// Go on with the journal.
    pub resume: bool,
    /// On resuming, calibrate again where the instrument has lost its calibration.
    pub recalibrate: bool,
    /// How long is waited for what.
    pub patience: Patience,
}

/// How far it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Points stored.
    pub done: u64,
    /// Points of the schedule.
    pub total: u64,
    /// What is left at the pace so far, seconds.
    pub seconds_left: f64,
}

//! Why an acquisition made no scan file.

use std::path::PathBuf;

use thiserror::Error;

use super::error::LinkError;
use super::journal::JournalError;
use super::result::NoScan;
use super::schedule::LimitError;
use crate::output::OutputError;

/// Why there is no scan file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AcquireError {
    /// Trouble with the instrument or the way to it.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Trouble with the journal.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Trouble with the scan file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The instrument cannot carry out the schedule.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// There is a scan already.
    #[error("{}: exists already; choose another name or delete it", path.display())]
    Exists {
        /// The scan file.
        path: PathBuf,
    },
    /// The journal is of another schedule.
    #[error(
        "{}: was begun with another schedule; give the same schedule, or none to take the journal's, or \
         delete the journal to begin anew", path.display()
    )]
    OtherPlan {
        /// The journal.
        path: PathBuf,
    },
    /// The instrument has another calibration than the last one of the journal, or none.
    #[error(
        "{instrument}: its calibration is gone or another one than that of {}; go on with \
         --recalibrate, or delete the journal to begin anew", path.display()
    )]
    OtherCalibration {
        /// Model and serial number.
        instrument: String,
        /// The journal.
        path: PathBuf,
    },
    /// The calibration has the name of the journal's, and other currents.
    #[error(
        "{instrument}: its calibration {id:08x} has other currents than {} holds under that name, so the \
         readings of one of them are wrong; delete the journal and measure again", path.display()
    )]
    FalseCalibration {
        /// Model and serial number.
        instrument: String,
        /// The name.
        id: u32,
        /// The journal.
        path: PathBuf,
    },
    /// More light than the range holds.
    #[error(
        "sigma {sigma_deg} deg, theta {theta_deg} deg: more light than range {range} holds; begin anew \
         with --range auto, or with a smaller number"
    )]
    OverRange {
        /// Angle of incidence, degrees.
        sigma_deg: f64,
        /// Angle of observation, degrees.
        theta_deg: f64,
        /// The range.
        range: u8,
    },
    /// All points are there, but they do not make a scan.
    #[error("{}: keeps all points, but they are no scan: {source}", path.display())]
    NoScan {
        /// The journal.
        path: PathBuf,
        /// The fault.
        source: NoScan,
    },
    /// Ended by the user.
    #[error(
        "interrupted with {done} of {total} points, kept in {}; go on with --resume", path.display()
    )]
    Interrupted {
        /// Points kept.
        done: u64,
        /// Points of the schedule.
        total: u64,
        /// The journal.
        path: PathBuf,
    },
    /// Ended by the user before anything was measured.
    #[error("interrupted before the first point; nothing was written")]
    NotBegun,
}

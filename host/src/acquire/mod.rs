//! Acquisition: driving a goniophotometer over a line, and keeping every point that was measured.
//!
//! | module | concept |
//! |---|---|
//! | [`transport`] | bytes to and from a port: serial, TCP, or a simulator in this process |
//! | [`error`] | what can be wrong with an instrument |
//! | [`patience`] | the limits of all waits |
//! | `wording` | requests and answers: which belong together, their names |
//! | `signal` | the possible currents of the detector |
//! | `link` | frames over bytes: one request, its answer, events in between |
//! | [`client`] | a client that owns an instrument, and owns it again after the line was lost |
//! | `recovery` | finding it again |
//! | `motion` | longer work: homing, moving, calibrating |
//! | [`schedule`] | the schedule of a scan |
//! | `conditions` | the settings that the instrument must have meanwhile |
//! | [`draft`] | a schedule as a file or as flags say it |
//! | `schedule_text` | a schedule read from a file and written out |
//! | [`schedule_error`] | a schedule that cannot be read, or cannot be meant |
//! | [`estimate`] | how long it takes |
//! | [`journal`] | the points measured so far, on disk |
//! | `run_error` | why there is no scan file |
//! | `result` | from a complete journal to a scan file |
//! | `segment` | one incidence |
//! | `session` | incidence after incidence |
//! | [`run`](mod@run) | all of it |
//!
//! PROTOCOL.md specifies the messages.

pub mod transport;
pub mod error;
pub mod patience;
mod wording;
mod signal;
mod link;
pub mod client;
mod recovery;
pub mod schedule;
mod conditions;
mod motion;
pub mod draft;
mod schedule_text;
pub mod schedule_error;
pub mod estimate;
pub mod journal;
mod result;
mod run_error;
pub mod job;
mod segment;
mod session;
pub mod run;

#[cfg(test)]
mod mock;
#[cfg(test)]
mod tests_line;
#[cfg(test)]
mod tests_run;

pub use self::client::Client;
pub use self::draft::Draft;
pub use self::error::{LinkError, Trouble};
pub use self::job::{Job, Progress};
pub use self::journal::{Journal, JournalError};
pub use self::patience::Patience;
pub use self::result::{AboveBeam, NoScan};
pub use self::run::{Summary, run};
pub use self::run_error::AcquireError;
pub use self::schedule::{CalibrationRule, Schedule};
pub use self::schedule_error::ScheduleError;
pub use self::transport::{InProcess, Peer, Transport};

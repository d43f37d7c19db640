//! A whole acquisition: from an idle instrument, or from a journal, to a scan file.

use std::sync::atomic::AtomicBool;

use asperity_core::protocol::{Axis, Ident, Microdegrees};

use super::client::{Client, describe};
use super::error::{LinkError, Trouble};
use super::job::{Job, Progress};
use super::journal::{Journal, JournalError};
use super::result::{AboveBeam, Finished, scan_file};
use super::run_error::AcquireError;
use super::session::Session;
use super::transport::Transport;
use crate::output::AtomicFile;

/// The result of an acquisition.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Model and serial number.
    pub instrument: (String, u32),
    /// Points of the scan.
    pub points: u64,
    /// Those of them that the journal had already.
    pub resumed: u64,
    /// Identities of the calibrations.
    pub calibrations: Vec<u32>,
    /// Number of losses of the line.
    pub recoveries: u32,
    /// Readings above the beam without the sample: how many, and the largest.
    pub above_beam: Option<AboveBeam>,
}

/// Measures and writes the scan file.
///
/// Files are checked before `connect` is called; it is not called at all if the journal is complete. The instrument
/// is stopped and released in all cases. When `stop` is set, the first request is to stop, within a tenth of a second
/// if the line works; the stage stays where it is.
///
/// # Errors
/// [`AcquireError`]; the journal keeps all points measured so far.
pub fn run<T: Transport>(
    job: &Job<'_>,
    connect: impl FnOnce() -> Result<T, LinkError>,
    stop: &AtomicBool,
    progress: &mut dyn FnMut(Progress),
) -> Result<Summary, AcquireError> {
    // fails here, before the long run
    drop(AtomicFile::create(job.output)?);
    let mut journal = open(job)?;
    let resumed = journal.as_ref().map_or(0, Journal::len);
    let mut recoveries = 0;
    if !journal.as_ref().is_some_and(Journal::is_complete) {
        let interrupted = |journal: Option<&Journal>, e: AcquireError| match e {
            AcquireError::Link(e) if matches!(*e.trouble, Trouble::Interrupted) => {
                interruption(journal)
            }
            e => e,
        };
        let client = Client::connect_heeding(connect()?, job.patience, Some(stop));
        let mut client = client.map_err(|e| interrupted(journal.as_ref(), e.into()))?;
        let measured = acquire(&mut client, job, &mut journal, progress);
        client.let_go();
        recoveries = client.recoveries();
        let complete = journal.as_ref().is_some_and(Journal::is_complete);
        match measured.map_err(|e| interrupted(journal.as_ref(), e)) {
            // all that is left is to write it
            Err(AcquireError::Interrupted { .. }) if complete => {}
            measured => measured?,
        }
    }
    let journal = journal.ok_or(AcquireError::NotBegun)?;
    let Finished { bytes, above_beam } = scan_file(&journal)
        .map_err(|source| AcquireError::NoScan { path: journal.path().to_owned(), source })?;
    AtomicFile::create(job.output)?.finish(&bytes)?;
    let summary = Summary { above_beam, ..summary(&journal, resumed, recoveries) };
    journal.delete()?;
    Ok(summary)
}

/// The journal to go on with; `None` to begin a new one.
fn open(job: &Job<'_>) -> Result<Option<Journal>, AcquireError> {
    let path = Journal::path_of(job.output);
    let is_there = job.output.is_file();
    let exists = || AcquireError::Exists { path: job.output.to_owned() };
    if !job.resume {
        if path.exists() {
            return Err(JournalError::Exists { path }.into());
        }
        return if is_there { Err(exists()) } else { Ok(None) };
    }
    let journal = Journal::open(path)?;
    if job.schedule.as_ref().is_some_and(|schedule| schedule != journal.schedule()) {
        return Err(AcquireError::OtherPlan { path: journal.path().to_owned() });
    }
    // a complete journal beside its scan was only not deleted any more
    if is_there && !journal.is_complete() {
        return Err(exists());
    }
    Ok(Some(journal))
}

fn summary(journal: &Journal, resumed: u64, recoveries: u32) -> Summary {
    let (model, serial) = journal.instrument();
    Summary {
        instrument: (model.to_owned(), serial),
        points: journal.len(),
        resumed,
        calibrations: journal.calibrations().iter().map(|stored| stored.values.id).collect(),
        recoveries,
        above_beam: None,
    }
}

/// From the first request to the last point and the way home.
fn acquire<T: Transport>(
    client: &mut Client<'_, T>,
    job: &Job<'_>,
    journal: &mut Option<Journal>,
    progress: &mut dyn FnMut(Progress),
) -> Result<(), AcquireError> {
    if let Some(journal) = journal.as_ref() {
        same_instrument(client, journal)?;
    }
    let schedule = match (journal.as_ref(), &job.schedule) {
        (Some(journal), _) => journal.schedule().clone(),
        (None, Some(schedule)) => schedule.clone(),
        (None, None) => return Err(AcquireError::NotBegun),
    };
    schedule.check(client.ident())?;
    client.claim()?;
    let status = client.wait_idle("what another client has begun", client.patience().grace)?;
    let journal = if let Some(journal) = journal {
        journal
    } else {
        let path = Journal::path_of(job.output);
        journal.insert(Journal::create(path, &schedule, client.ident())?)
    };
    let mut session =
        Session { client, job, schedule: &schedule, segments: 0, recalibrate: job.recalibrate };
    if !session.will_calibrate(journal) {
        session.check_calibration(&status, journal)?;
    }
    session.all(journal, progress)?;
    Ok(park(session.client)?)
}

fn same_instrument<T: Transport>(
    client: &Client<'_, T>,
    journal: &Journal,
) -> Result<(), AcquireError> {
    let Ident { model, serial, .. } = client.ident();
    let (expected_model, expected_serial) = journal.instrument();
    if (model.as_str(), *serial) == (expected_model, expected_serial) {
        return Ok(());
    }
    Err(client
        .fail(Trouble::OtherInstrument {
            found: describe(client.ident()),
            expected: format!("{expected_model} {expected_serial}"),
        })
        .into())
}

/// Both axes to zero.
fn park<T: Transport>(client: &mut Client<'_, T>) -> Result<(), LinkError> {
    client.move_to(Axis::Sigma, Microdegrees(0))?;
    client.move_to(Axis::Theta, Microdegrees(0))
}

/// The state after an interruption.
fn interruption(journal: Option<&Journal>) -> AcquireError {
    let Some(journal) = journal else { return AcquireError::NotBegun };
    let (done, total) = (journal.len(), journal.schedule().points());
    AcquireError::Interrupted { done, total, path: journal.path().to_owned() }
}

//! A whole acquisition: from an idle instrument, or from a journal, to a scan file.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use asperity_core::protocol::{Axis, Ident, MachineState, Microdegrees, Request, Status};
use thiserror::Error;

use super::client::{Client, describe};
use super::conditions::Conditions;
use super::error::{LinkError, Trouble};
use super::journal::{Journal, JournalError};
use super::patience::Patience;
use super::plan::{CalibrationRule, LimitError, Plan};
use super::result::{AboveBeam, Finished, NoScan, scan_file};
use super::segment::{Course, End, is_forgotten, progress_of, scan};
use super::transport::Transport;
use crate::output::{AtomicFile, OutputError};

/// How often a segment is begun anew without a new point.
const RESTARTS: u32 = 5;

/// What is to be done.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// What to measure; on resuming `None` takes the journal's plan.
    pub plan: Option<Plan>,
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
    /// Points of the plan.
    pub total: u64,
    /// What is left at the pace so far, seconds.
    pub seconds_left: f64,
}

/// What was done.
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
    /// How often the line was lost and found.
    pub recoveries: u32,
    /// Readings above the beam without the sample: how many, and the largest.
    pub above_beam: Option<AboveBeam>,
}

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
    /// The instrument cannot carry out the plan.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// There is a scan already.
    #[error("{}: exists already; choose another name or delete it", path.display())]
    Exists {
        /// The scan file.
        path: PathBuf,
    },
    /// The journal is of another plan.
    #[error(
        "{}: was begun with another plan; give the same plan, or none to take the journal's, or \
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
    /// All points are there, and they are no scan.
    #[error("{}: keeps all points, but they are no scan: {source}", path.display())]
    NoScan {
        /// The journal.
        path: PathBuf,
        /// What is wrong.
        source: NoScan,
    },
    /// Ended by the user.
    #[error(
        "interrupted with {done} of {total} points, kept in {}; go on with --resume", path.display()
    )]
    Interrupted {
        /// Points kept.
        done: u64,
        /// Points of the plan.
        total: u64,
        /// The journal.
        path: PathBuf,
    },
    /// Ended by the user before anything was measured.
    #[error("interrupted before the first point; nothing was written")]
    NotBegun,
}

/// Measures, and writes the scan file.
///
/// Files are looked at before `connect` is called; it is not called at all if the journal is complete.
/// Whatever happens, the instrument is stopped and released. When `stop` is set the first thing it is told
/// is to stop, within a tenth of a second where the line works; it stays where it is.
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
    if job.plan.as_ref().is_some_and(|plan| plan != journal.plan()) {
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
    let plan = match (journal.as_ref(), &job.plan) {
        (Some(journal), _) => journal.plan().clone(),
        (None, Some(plan)) => plan.clone(),
        (None, None) => return Err(AcquireError::NotBegun),
    };
    plan.check(client.ident())?;
    client.claim()?;
    let status = client.wait_idle("what another client has begun", client.patience().grace)?;
    let journal = if let Some(journal) = journal {
        journal
    } else {
        let path = Journal::path_of(job.output);
        journal.insert(Journal::create(path, &plan, client.ident())?)
    };
    let mut session =
        Session { client, job, plan: &plan, segments: 0, recalibrate: job.recalibrate };
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

/// What an interruption has left.
fn interruption(journal: Option<&Journal>) -> AcquireError {
    let Some(journal) = journal else { return AcquireError::NotBegun };
    let (done, total) = (journal.len(), journal.plan().points());
    AcquireError::Interrupted { done, total, path: journal.path().to_owned() }
}

/// An acquisition under way.
struct Session<'a, 's, T> {
    client: &'a mut Client<'s, T>,
    job: &'a Job<'a>,
    plan: &'a Plan,
    /// Names of segments given so far.
    segments: u32,
    /// Calibrate where the calibration is gone; once.
    recalibrate: bool,
}

impl<T: Transport> Session<'_, '_, T> {
    /// Whether the next incidence with a missing point is calibrated first.
    fn will_calibrate(&self, journal: &Journal) -> bool {
        let Some((sigma, _)) = journal.next() else { return false };
        journal.calibrations().last().is_none_or(|last| {
            self.plan.calibration() == CalibrationRule::PerSigma && last.sigma != sigma
        })
    }

    /// The calibration of the journal must be in force: all else is not comparable.
    fn check_calibration(
        &mut self,
        status: &Status,
        journal: &Journal,
    ) -> Result<(), AcquireError> {
        let last = journal.calibrations().last().map(|last| last.values.id);
        if status.calibration == last {
            // as long as it is in force it need not be made again
            self.recalibrate = false;
            return self.same_calibration(journal);
        }
        if self.recalibrate {
            return Ok(());
        }
        let (instrument, path) = (describe(self.client.ident()), journal.path().to_owned());
        Err(AcquireError::OtherCalibration { instrument, path })
    }

    /// Calibrations of one name are the same.
    fn same_calibration(&mut self, journal: &Journal) -> Result<(), AcquireError> {
        let Some(last) = journal.calibrations().last().map(|last| last.values) else {
            return Ok(());
        };
        let values = self.client.last_calibration()?;
        if values == last {
            return Ok(());
        }
        let (instrument, path) = (describe(self.client.ident()), journal.path().to_owned());
        Err(AcquireError::FalseCalibration { instrument, id: last.id, path })
    }

    /// All incidences.
    fn all(
        &mut self,
        journal: &mut Journal,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), AcquireError> {
        let mut begun = (journal.len(), self.client.now());
        // in a row, and how many of them because the line was lost
        let (mut failures, mut lost) = (0, 0);
        while let Some(missing) = journal.next() {
            let before = self.client.recoveries();
            match self.one(missing.0, journal, &mut begun, progress) {
                Ok(End::Complete | End::Disturbed) => {}
                Err(AcquireError::Link(e))
                    if is_forgotten(&e.trouble) && self.client.recoveries() != before => {}
                Err(e) => return Err(e),
            }
            failures = if journal.next() == Some(missing) { failures + 1 } else { 0 };
            lost += u32::from(self.client.recoveries() != before);
            if failures == 0 {
                lost = 0;
            }
            if failures >= RESTARTS {
                let (what, times) = ("the scan of a segment", RESTARTS);
                return Err(self
                    .client
                    .fail(match lost {
                        0 => Trouble::Stops { what, times },
                        _ => Trouble::Unstable { what, times },
                    })
                    .into());
            }
        }
        Ok(())
    }

    /// One incidence, as far as it goes without a disturbance.
    fn one(
        &mut self,
        sigma: usize,
        journal: &mut Journal,
        begun: &mut (u64, std::time::Duration),
        progress: &mut dyn FnMut(Progress),
    ) -> Result<End, AcquireError> {
        let before = self.client.recoveries();
        let status = self.settle()?;
        if self.client.recoveries() != before {
            return Ok(End::Disturbed);
        }
        self.check_settings(&status)?;
        let mut calibrates = self.will_calibrate(journal);
        if !calibrates {
            self.check_calibration(&status, journal)?;
            calibrates = self.recalibrate;
        }
        if calibrates && !self.calibrate(sigma, journal)? {
            return Ok(End::Disturbed);
        }
        if begun.0 == journal.len() {
            begun.1 = self.client.now();
        }
        self.segments += 1;
        let calibration = journal.calibrations().len().saturating_sub(1);
        let Some(values) = journal.calibrations().last().map(|last| last.values) else {
            return Ok(End::Disturbed);
        };
        let (plan, name, credit) = (self.plan, self.segments, self.job.credit.max(1));
        let course = Course { plan, sigma, name, credit, calibration, values };
        let start = *begun;
        scan(self.client, &course, journal, &mut |journal, now| {
            progress(progress_of(journal, start, now));
        })
    }

    /// Calibrates; `false` if the line was lost, and what was found may be gone.
    fn calibrate(&mut self, sigma: usize, journal: &mut Journal) -> Result<bool, AcquireError> {
        let calibration = self.client.calibrate()?;
        let before = self.client.recoveries();
        let status = self.client.status()?;
        if self.client.recoveries() != before {
            return Ok(false);
        }
        self.check_settings(&status)?;
        if status.calibration != Some(calibration.id) {
            let named = status.calibration.map_or_else(|| "none".into(), |id| format!("{id:08x}"));
            let said = format!(
                "it has made calibration {:08x}, and its status says {named}",
                calibration.id
            );
            return Err(self.client.fail(Trouble::Nonsense(said)).into());
        }
        self.recalibrate = false;
        journal.add_calibration(sigma, calibration)?;
        Ok(true)
    }

    fn check_settings(&self, status: &Status) -> Result<(), LinkError> {
        Conditions::of(self.plan).check(status).map_err(|trouble| self.client.fail(trouble))
    }

    /// Homes and sets what is not as the plan wants it; what is so is left alone, for setting the
    /// aperture or the lamp drops the calibration.
    fn settle(&mut self) -> Result<Status, AcquireError> {
        // a request made again after the line was lost may have begun something
        if !matches!(self.client.status()?.state, MachineState::Idle | MachineState::Fault) {
            self.client.ask(Request::Stop)?;
        }
        let limit = self.client.patience().grace;
        let (plan, status) = (self.plan, self.client.wait_idle("stopping", limit)?);
        let settings = [
            (status.aperture == plan.aperture(), Request::Aperture(plan.aperture())),
            (status.range == plan.range(), Request::Range(plan.range())),
            (
                status.integration_us == plan.integration_us(),
                Request::Integration(plan.integration_us()),
            ),
            (status.lamp, Request::Lamp(true)),
        ];
        for (set, request) in settings {
            if !set {
                self.client.ask(request)?;
            }
        }
        if !status.homed {
            self.client.home()?;
        }
        Ok(self.client.status()?)
    }
}

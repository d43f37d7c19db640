//! An acquisition in progress: incidence after incidence, restarted after a disturbance.

use asperity_core::protocol::{MachineState, Request, Status};

use super::client::{Client, describe};
use super::conditions::Conditions;
use super::error::{LinkError, Trouble};
use super::job::{Job, Progress};
use super::journal::Journal;
use super::run_error::AcquireError;
use super::schedule::{CalibrationRule, Schedule};
use super::segment::{Course, End, is_forgotten, progress_of, scan};
use super::transport::Transport;

/// Number of restarts of a segment without a new point.
const RESTARTS: u32 = 5;

/// An acquisition under way.
pub(super) struct Session<'a, 's, T> {
    pub(super) client: &'a mut Client<'s, T>,
    pub(super) job: &'a Job<'a>,
    pub(super) schedule: &'a Schedule,
    /// Names of segments given so far.
    pub(super) segments: u32,
    /// Calibrate where the calibration is gone; once.
    pub(super) recalibrate: bool,
}

impl<T: Transport> Session<'_, '_, T> {
    /// Whether the next incidence with a missing point is calibrated first.
    pub(super) fn will_calibrate(&self, journal: &Journal) -> bool {
        let Some((sigma, _)) = journal.next() else { return false };
        journal.calibrations().last().is_none_or(|last| {
            self.schedule.calibration() == CalibrationRule::PerSigma && last.sigma != sigma
        })
    }

    /// The calibration of the journal must be in force: all else is not comparable.
    pub(super) fn check_calibration(
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
    pub(super) fn all(
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
        let (schedule, name, credit) = (self.schedule, self.segments, self.job.credit.max(1));
        let course = Course { schedule, sigma, name, credit, calibration, values };
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
        // a fault that puts the lamp out is the fault
        self.client.refuse_fault(status)?;
        Conditions::of(self.schedule).check(status).map_err(|trouble| self.client.fail(trouble))
    }

    /// Homes and sets what is not as the schedule wants it; what is so is left alone, for setting the
    /// aperture or the lamp drops the calibration.
    fn settle(&mut self) -> Result<Status, AcquireError> {
        // a request made again after the line was lost may have begun something
        if !matches!(self.client.status()?.state, MachineState::Idle | MachineState::Fault) {
            self.client.ask(Request::Stop)?;
        }
        let limit = self.client.patience().grace;
        let (schedule, status) = (self.schedule, self.client.wait_idle("stopping", limit)?);
        let settings = [
            (status.aperture == schedule.aperture(), Request::Aperture(schedule.aperture())),
            (status.range == schedule.range(), Request::Range(schedule.range())),
            (
                status.integration_us == schedule.integration_us(),
                Request::Integration(schedule.integration_us()),
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

//! Longer work: homing, moving, calibrating.

use std::time::Duration;

use asperity_core::protocol::{
    Axis, Calibration, CalibrationKind, Event, MachineState, Microdegrees, Request, Status,
};

use super::client::Client;
use super::conditions::OFF_TARGET;
use super::error::{LinkError, Trouble};
use super::estimate;
use super::transport::Transport;

/// How often work begins again because the line was lost meanwhile.
const TRIES: u32 = 5;

impl<T: Transport> Client<'_, T> {
    /// Waits until the instrument is idle, at most for `limit`.
    ///
    /// # Errors
    /// [`Trouble::Fault`] if it has stopped by one, [`Trouble::Overdue`], [`Trouble::Interrupted`], and
    /// as [`ask`](Self::ask).
    pub fn wait_idle(&mut self, what: &'static str, limit: Duration) -> Result<Status, LinkError> {
        let deadline = self.now() + limit;
        loop {
            let status = self.status()?;
            self.refuse_fault(&status)?;
            if status.state == MachineState::Idle {
                return Ok(status);
            }
            self.heed_stop()?;
            if self.now() >= deadline {
                let seconds = limit.as_secs_f64();
                return Err(self.fail(Trouble::Overdue { what, seconds }));
            }
            let next = (self.now() + self.patience().poll).min(deadline);
            self.wait_change(next)?;
        }
    }

    /// If a fault has stopped it, that is an error.
    pub(super) fn refuse_fault(&self, status: &Status) -> Result<(), LinkError> {
        match (status.state, status.fault) {
            (MachineState::Fault, Some(fault)) => Err(self.fail(Trouble::Fault(fault))),
            (MachineState::Fault, None) => {
                let said = "it is in a fault, and in none".to_owned();
                Err(self.fail(Trouble::Nonsense(said)))
            }
            _ => Ok(()),
        }
    }

    /// Waits until `until`, or until an event says that the state has changed.
    fn wait_change(&mut self, until: Duration) -> Result<(), LinkError> {
        let changed = |event: &Event| matches!(event, Event::State(_) | Event::Fault(_));
        while self.now() < until {
            self.heed_stop()?;
            if self.events(until)?.iter().any(changed) {
                break;
            }
        }
        Ok(())
    }

    /// Begins longer work and waits for its end; begins again if the line was lost in between.
    fn perform(
        &mut self,
        what: &'static str,
        request: Request,
        limit: Duration,
    ) -> Result<Status, LinkError> {
        for _ in 0..TRIES {
            let before = self.recoveries();
            self.ask(request)?;
            let status = self.wait_idle(what, limit)?;
            if self.recoveries() == before {
                return Ok(status);
            }
        }
        Err(self.fail(Trouble::Unstable { what, times: TRIES }))
    }

    /// Finds the zeros of both axes.
    ///
    /// # Errors
    /// As [`wait_idle`](Self::wait_idle); [`Trouble::Nonsense`] if it is not homed afterwards.
    pub fn home(&mut self) -> Result<Status, LinkError> {
        let limit = self.patience().motion(estimate::homing(self.ident()));
        let status = self.perform("homing", Request::Home, limit)?;
        if status.homed {
            return Ok(status);
        }
        Err(self.fail(Trouble::Nonsense("it has homed, and is not homed".to_owned())))
    }

    /// Sends an axis to a position.
    ///
    /// # Errors
    /// As [`wait_idle`](Self::wait_idle); [`Trouble::Nonsense`] if it is not there afterwards.
    pub fn move_to(&mut self, axis: Axis, target: Microdegrees) -> Result<(), LinkError> {
        let whole = match axis {
            Axis::Sigma => self.ident().sigma,
            Axis::Theta => self.ident().theta,
        };
        let limit = self.patience().motion(estimate::whole(&whole));
        let status = self.perform("a movement", Request::Move(axis, target), limit)?;
        let reached = match axis {
            Axis::Sigma => status.sigma,
            Axis::Theta => status.theta,
        };
        if reached.0.abs_diff(target.0) <= OFF_TARGET {
            return Ok(());
        }
        Err(self.fail(Trouble::Nonsense(format!(
            "the {axis} axis was sent to {} degrees and stands at {}",
            target.degrees(),
            reached.degrees()
        ))))
    }

    /// Both calibration runs with the present settings.
    ///
    /// # Errors
    /// As [`wait_idle`](Self::wait_idle) and [`last_calibration`](Self::last_calibration).
    pub fn calibrate(&mut self) -> Result<Calibration, LinkError> {
        for _ in 0..TRIES {
            let before = self.recoveries();
            let status = self.status()?;
            let time = estimate::calibration(self.ident(), status.integration_us);
            let limit = self.patience().motion(time);
            for kind in [CalibrationKind::Dark, CalibrationKind::Reference] {
                self.perform("a calibration", Request::Calibrate(kind), limit)?;
            }
            let calibration = self.last_calibration()?;
            if self.recoveries() == before {
                return Ok(calibration);
            }
        }
        Err(self.fail(Trouble::Unstable { what: "a calibration", times: TRIES }))
    }
}

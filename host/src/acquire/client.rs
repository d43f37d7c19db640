//! An instrument that is owned, and owned again after the line was lost.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use asperity_core::protocol::{
    Calibration, DeviceError, Diagnostics, Event, Ident, MachineState, Request, Response, Status,
};

use super::error::{LinkError, Trouble};
use super::link::{Failed, Link};
use super::patience::Patience;
use super::transport::Transport;

/// How often one request survives the loss of the line.
const LOSSES: u32 = 3;

/// A client of one instrument.
///
/// Where the line breaks, or the instrument has forgotten its owner, the line is opened again, the
/// instrument is recognised, claimed and stopped; then the request is made again. Whoever has begun a
/// motion finds by [`recoveries`](Self::recoveries) that it has to be begun anew.
#[derive(Debug)]
pub struct Client<'s, T> {
    link: Link<T>,
    ident: Ident,
    owner: bool,
    recoveries: u32,
    stop: Option<&'s AtomicBool>,
}

impl<'s, T: Transport> Client<'s, T> {
    /// Finds out who is there.
    ///
    /// # Errors
    /// [`Trouble::Silent`], [`Trouble::NotAnInstrument`], [`Trouble::Version`], [`Trouble::Lost`],
    /// [`Trouble::Nonsense`].
    pub fn connect(line: T, patience: Patience) -> Result<Self, LinkError> {
        let mut link = Link::new(line, patience);
        match link.identify(patience.identify) {
            Ok(ident) => Ok(Self { link, ident, owner: false, recoveries: 0, stop: None }),
            Err(trouble) => Err(LinkError::new(link.line.name(), trouble)),
        }
    }

    /// From now on waits end with [`Trouble::Interrupted`] soon after the flag is set; `None`: no more.
    pub fn heed(&mut self, stop: Option<&'s AtomicBool>) {
        self.stop = stop;
    }

    /// Who it is.
    pub fn ident(&self) -> &Ident {
        &self.ident
    }

    /// How often the line was lost and found again, or the ownership.
    pub fn recoveries(&self) -> u32 {
        self.recoveries
    }

    /// This client's session number.
    pub fn session(&self) -> u16 {
        self.link.session()
    }

    /// The line.
    pub fn line(&self) -> &T {
        &self.link.line
    }

    /// The line, to be meddled with.
    pub fn line_mut(&mut self) -> &mut T {
        &mut self.link.line
    }

    pub(super) fn patience(&self) -> Patience {
        self.link.patience
    }

    pub(super) fn now(&self) -> Duration {
        self.link.line.now()
    }

    /// Trouble with this instrument.
    pub(super) fn fail(&self, trouble: Trouble) -> LinkError {
        LinkError::new(self.link.line.name(), trouble)
    }

    pub(super) fn heed_stop(&self) -> Result<(), LinkError> {
        match self.stop {
            Some(stop) if stop.load(Ordering::SeqCst) => Err(self.fail(Trouble::Interrupted)),
            _ => Ok(()),
        }
    }

    /// Makes a request that is answered at once, or begins what takes time.
    ///
    /// # Errors
    /// [`Trouble::Refused`], [`Trouble::InUse`], [`Trouble::Fault`] where the instrument says no;
    /// [`Trouble::Lost`], [`Trouble::OtherInstrument`], [`Trouble::Unstable`] where it cannot be asked.
    pub fn ask(&mut self, request: Request) -> Result<Response, LinkError> {
        for _ in 0..LOSSES {
            match self.link.exchange(request) {
                Ok(Ok(response)) => return Ok(response),
                Ok(Err(DeviceError::NotOwner)) if self.owner => self.recover(None)?,
                Ok(Err(why)) => return Err(self.fail(refusal(request, why))),
                Err(failed) => self.recover(Some(failed))?,
            }
        }
        Err(self.fail(Trouble::Unstable { what: name(request), times: LOSSES }))
    }

    /// What the instrument is doing. An owner that the instrument has forgotten claims it again.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn status(&mut self) -> Result<Status, LinkError> {
        for _ in 0..LOSSES {
            let Response::Status(status) = self.ask(Request::Status)? else {
                return Err(self.fail(other_answer()));
            };
            if !self.owner || status.owner == Some(self.session()) {
                return Ok(status);
            }
            self.recover(None)?;
        }
        Err(self.fail(Trouble::Unstable { what: "keeping the instrument", times: LOSSES }))
    }

    /// Counters of the line and the firmware.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn diagnostics(&mut self) -> Result<Diagnostics, LinkError> {
        match self.ask(Request::Diagnostics)? {
            Response::Diagnostics(diagnostics) => Ok(diagnostics),
            _ => Err(self.fail(other_answer())),
        }
    }

    /// The result of both calibration runs; its numbers are finite.
    ///
    /// # Errors
    /// As [`ask`](Self::ask), and [`Trouble::Nonsense`].
    pub fn last_calibration(&mut self) -> Result<Calibration, LinkError> {
        let Response::Calibration(calibration) = self.ask(Request::LastCalibration)? else {
            return Err(self.fail(other_answer()));
        };
        let values = calibration.dark.iter().chain([&calibration.reference]);
        let dark = calibration.dark.get(usize::from(calibration.range));
        if dark.is_none() || !values.clone().all(|value| value.is_finite()) {
            let said = format!("the calibration {calibration:?}");
            return Err(self.fail(Trouble::Nonsense(said)));
        }
        if dark.is_some_and(|dark| calibration.reference <= *dark) {
            return Err(self.fail(Trouble::Nonsense(format!(
                "without the sample the detector reads {} nA, not more than in the dark; look after \
                 the lamp and the beam",
                calibration.reference
            ))));
        }
        Ok(calibration)
    }

    /// Makes this client the owner, as soon as another one is gone.
    ///
    /// # Errors
    /// [`Trouble::InUse`] if it is not gone in [`Patience::in_use`], and as [`ask`](Self::ask).
    pub fn claim(&mut self) -> Result<(), LinkError> {
        let deadline = self.now() + self.patience().in_use;
        loop {
            match self.claim_now() {
                Err(e) if matches!(*e.trouble, Trouble::InUse) && self.now() < deadline => {
                    self.heed_stop()?;
                    self.link.line.pause(self.patience().poll);
                }
                done => return done,
            }
        }
    }

    /// Makes this client the owner, if the instrument is free.
    ///
    /// # Errors
    /// [`Trouble::InUse`], and as [`ask`](Self::ask).
    pub fn claim_now(&mut self) -> Result<(), LinkError> {
        self.ask(Request::Claim)?;
        self.owner = true;
        Ok(())
    }

    /// From now on waits for lost lines and answers are short: the end is near.
    pub(super) fn hurry(&mut self) {
        self.link.patience = self.link.patience.brief();
    }

    /// Gives the instrument up; it stops.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn release(&mut self) -> Result<(), LinkError> {
        self.ask(Request::Release)?;
        self.owner = false;
        Ok(())
    }

    /// Stops and gives up the instrument as far as it can be reached, in about a second: for the end
    /// of a run that has failed already.
    pub fn let_go(&mut self) {
        if !self.owner {
            return;
        }
        self.hurry();
        for request in [Request::Stop, Request::Release] {
            let _ = self.link.exchange(request);
        }
        self.owner = false;
    }

    /// The events that have come; waits until `until` for the first one.
    pub(super) fn events(&mut self, until: Duration) -> Result<Vec<Event>, LinkError> {
        match self.link.event(until) {
            Ok(first) => Ok(first.into_iter().chain(self.link.events()).collect()),
            Err(e) => {
                self.recover(Some(Failed::Io(e)))?;
                Ok(Vec::new())
            }
        }
    }

    /// Finds the instrument again, the same one, and makes it ours and idle.
    ///
    /// `lost` is how the line failed; without it the line is good and only the ownership is gone.
    fn recover(&mut self, lost: Option<Failed>) -> Result<(), LinkError> {
        self.recoveries = self.recoveries.wrapping_add(1);
        let limit = self.patience().lost;
        let deadline = self.now() + limit;
        let mut reconnect = lost.is_some();
        let mut cause = lost.and_then(|failed| match failed {
            Failed::Io(e) => Some(e),
            Failed::Silent => None,
        });
        let mut taken = false;
        for k in 0.. {
            self.heed_stop()?;
            if self.now() >= deadline {
                break;
            }
            if reconnect && let Err(e) = self.link.reconnect() {
                cause = Some(e);
                self.link.line.pause(self.patience().back_off(k));
                continue;
            }
            match self.try_recover(deadline) {
                Ok(true) => return Ok(()),
                Ok(false) => taken = true,
                Err(Recovery::Wait(e)) => (cause, reconnect) = (e.or(cause), true),
                Err(Recovery::End(trouble)) => return Err(self.fail(trouble)),
            }
            self.link.line.pause(self.patience().back_off(k));
        }
        let lost = Trouble::Lost { seconds: limit.as_secs_f64(), cause };
        Err(self.fail(if taken { Trouble::InUse } else { lost }))
    }

    /// One try on an open line; `false` if another client owns the instrument.
    fn try_recover(&mut self, deadline: Duration) -> Result<bool, Recovery> {
        let left = deadline.saturating_sub(self.now()).min(self.patience().identify);
        let found = self.link.identify(left).map_err(|trouble| match trouble {
            Trouble::Lost { cause, .. } => Recovery::Wait(cause),
            Trouble::Silent { .. } | Trouble::NotAnInstrument { .. } => Recovery::Wait(None),
            other => Recovery::End(other),
        })?;
        if (found.model, found.serial) != (self.ident.model, self.ident.serial) {
            return Err(Recovery::End(Trouble::OtherInstrument {
                found: describe(&found),
                expected: describe(&self.ident),
            }));
        }
        self.ident = found;
        if !self.owner {
            return Ok(true);
        }
        match self.link.exchange(Request::Claim)? {
            Ok(_) => {}
            Err(DeviceError::InUse) => return Ok(false),
            Err(why) => return Err(Recovery::End(refusal(Request::Claim, why))),
        }
        while self.now() < deadline {
            match self.link.exchange(Request::Status)? {
                Ok(Response::Status(status))
                    if matches!(status.state, MachineState::Idle | MachineState::Fault) =>
                {
                    // events of what was under way are of no use any more
                    drop(self.link.events());
                    return Ok(true);
                }
                _ => drop(self.link.exchange(Request::Stop)?),
            }
            self.link.line.pause(self.patience().poll);
        }
        Err(Recovery::Wait(None))
    }
}

/// Why a try to recover did not succeed.
enum Recovery {
    Wait(Option<std::io::Error>),
    End(Trouble),
}

impl From<Failed> for Recovery {
    fn from(failed: Failed) -> Self {
        match failed {
            Failed::Silent => Self::Wait(None),
            Failed::Io(e) => Self::Wait(Some(e)),
        }
    }
}

/// Model and serial number.
pub fn describe(ident: &Ident) -> String {
    format!("{} {}", ident.model, ident.serial)
}

fn refusal(request: Request, why: DeviceError) -> Trouble {
    match why {
        DeviceError::InUse => Trouble::InUse,
        DeviceError::Faulted(fault) => Trouble::Fault(fault),
        why => Trouble::Refused { what: name(request), why },
    }
}

/// Cannot be: the kind of an answer is looked at where it is taken from the line.
fn other_answer() -> Trouble {
    Trouble::Nonsense("an answer to another question".to_owned())
}

/// A request in plain words.
fn name(request: Request) -> &'static str {
    match request {
        Request::Identify => "to say who it is",
        Request::Claim => "to be taken",
        Request::Release => "to be released",
        Request::Status => "its status",
        Request::Diagnostics => "its counters",
        Request::Home => "homing",
        Request::Move(..) => "to move",
        Request::Aperture(_) => "the aperture",
        Request::Range(_) => "the range",
        Request::Integration(_) => "the integration time",
        Request::Lamp(_) => "to switch the lamp",
        Request::Read | Request::LastReading => "a reading",
        Request::Calibrate(_) | Request::LastCalibration => "a calibration",
        Request::Scan(_) => "to scan",
        Request::Continue { .. } => "to go on with the scan",
        Request::Stop | Request::EmergencyStop => "to stop",
        Request::ClearFault => "to clear the fault",
    }
}

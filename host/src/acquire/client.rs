//! A client that owns an instrument, and owns it again after the line was lost.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asperity_core::protocol::{
    Calibration, DeviceError, Diagnostics, Event, Ident, Request, Response, Status,
};

use super::error::{LinkError, Trouble};
use super::link::{Failed, Link};
use super::patience::Patience;
use super::signal;
use super::transport::Transport;
use super::wording::{name, unfit};

/// Number of losses of the line that one request survives.
const LOSSES: u32 = 3;

/// A client of one instrument.
///
/// If the line breaks, or the instrument has forgotten its owner, the client opens the line again, recognises, claims
/// and stops the instrument, and repeats the request. After a motion, a change of [`recoveries`](Self::recoveries)
/// shows that the motion must begin again.
#[derive(Debug)]
pub struct Client<'s, T> {
    pub(super) link: Link<'s, T>,
    pub(super) ident: Ident,
    pub(super) owner: bool,
    /// The answer to a claim has not come: the client may be the owner.
    claiming: bool,
    pub(super) recoveries: u32,
}

impl<'s, T: Transport> Client<'s, T> {
    /// Identifies the instrument.
    ///
    /// # Errors
    /// [`Trouble::Silent`], [`Trouble::NotAnInstrument`], [`Trouble::Version`], [`Trouble::Lost`],
    /// [`Trouble::Nonsense`].
    pub fn connect(line: T, patience: Patience) -> Result<Self, LinkError> {
        Self::connect_heeding(line, patience, None)
    }

    /// The same, with a stop flag from the first byte on: see [`heed`](Self::heed).
    ///
    /// # Errors
    /// As [`connect`](Self::connect), and [`Trouble::Interrupted`].
    pub fn connect_heeding(
        line: T,
        patience: Patience,
        stop: Option<&'s AtomicBool>,
    ) -> Result<Self, LinkError> {
        let mut link = Link::new(line, patience);
        link.stop = stop;
        match link.identify(patience.identify) {
            Ok(ident) => Ok(Self { link, ident, owner: false, claiming: false, recoveries: 0 }),
            Err(trouble) => Err(LinkError::new(link.line.name(), trouble)),
        }
    }

    /// From now on waits end with [`Trouble::Interrupted`] soon after the flag is set; `None` removes the flag.
    pub fn heed(&mut self, stop: Option<&'s AtomicBool>) {
        self.link.stop = stop;
    }

    /// The identity of the instrument.
    pub fn ident(&self) -> &Ident {
        &self.ident
    }

    /// How often the line or the ownership was lost and recovered.
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

    /// The line, mutable.
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

    /// Time since the last answer of the instrument.
    pub(super) fn unheard(&self) -> Duration {
        self.now().saturating_sub(self.link.answered())
    }

    pub(super) fn heed_stop(&self) -> Result<(), LinkError> {
        if self.link.is_stopped() { Err(self.fail(Trouble::Interrupted)) } else { Ok(()) }
    }

    /// Sends a request that the instrument answers at once, or that begins longer work.
    ///
    /// # Errors
    /// [`Trouble::Refused`], [`Trouble::InUse`], [`Trouble::Fault`] if the instrument refuses;
    /// [`Trouble::Lost`], [`Trouble::OtherInstrument`], [`Trouble::Unstable`], [`Trouble::Mute`],
    /// [`Trouble::Astray`] if it cannot be reached; [`Trouble::Nonsense`], [`Trouble::Interrupted`].
    pub fn ask(&mut self, request: Request) -> Result<Response, LinkError> {
        let mut astray = 0;
        for _ in 0..LOSSES {
            match self.link.exchange(request) {
                Ok(Ok(response)) => return Ok(response),
                Ok(Err(DeviceError::NotOwner)) if self.owner => self.recover(None)?,
                Ok(Err(why)) => return Err(self.fail(refusal(request, why))),
                Err(Failed::Interrupted) => return Err(self.fail(Trouble::Interrupted)),
                Err(Failed::Unfit(answer)) => return Err(self.fail(unfit(request, answer))),
                Err(failed) => {
                    astray = if let Failed::Astray(answers) = failed { answers } else { 0 };
                    self.recover(Some(failed))?;
                }
            }
        }
        Err(self.fail(match astray {
            0 => Trouble::Unstable { what: name(request), times: LOSSES },
            answers => Trouble::Astray { answers },
        }))
    }

    /// The status of the instrument. If the instrument has forgotten its owner, the client claims it again.
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

    /// The result of both calibration runs; readings can be taken relative to it.
    ///
    /// # Errors
    /// As [`ask`](Self::ask), and [`Trouble::WeakBeam`].
    pub fn last_calibration(&mut self) -> Result<Calibration, LinkError> {
        let Response::Calibration(calibration) = self.ask(Request::LastCalibration)? else {
            return Err(self.fail(other_answer()));
        };
        signal::check_calibration(&calibration).map_err(|trouble| self.fail(trouble))?;
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
                    self.link.pause(self.patience().poll);
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
        self.claiming = true;
        let claimed = self.ask(Request::Claim);
        self.owner = claimed.is_ok();
        // without an answer it may be the owner all the same
        self.claiming = claimed.as_ref().is_err_and(|e| !matches!(*e.trouble, Trouble::InUse));
        claimed.map(drop)
    }

    /// From now on waits for lost lines and answers are short, for the end of a run.
    pub(super) fn hurry(&mut self) {
        self.link.patience = self.link.patience.brief();
    }

    /// Releases the instrument; it stops.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn release(&mut self) -> Result<(), LinkError> {
        self.ask(Request::Release)?;
        self.owner = false;
        Ok(())
    }

    /// Stops it at once if it can be reached; from now on waits are short and ignore the flag.
    pub(super) fn stop_now(&mut self) {
        self.heed(None);
        self.hurry();
        if self.owner || self.claiming {
            let _ = self.link.exchange(Request::Stop);
        }
    }

    /// Its status, if it answers at once and this client still owns it.
    pub(super) fn glance(&mut self) -> Option<Status> {
        match self.link.exchange(Request::Status) {
            Ok(Ok(Response::Status(status))) => {
                (status.owner == Some(self.session())).then_some(status)
            }
            _ => None,
        }
    }

    /// Stops and releases the instrument if it can be reached, within about a second; for the end of a failed run.
    pub fn let_go(&mut self) {
        if !self.owner && !self.claiming {
            return;
        }
        self.stop_now();
        let _ = self.link.exchange(Request::Release);
        (self.owner, self.claiming) = (false, false);
    }

    /// The received events that are not yet taken.
    pub(super) fn waiting(&self) -> impl Iterator<Item = &Event> {
        self.link.waiting()
    }

    /// The received events; waits until `until` for the first one.
    pub(super) fn events(&mut self, until: Duration) -> Result<Vec<Event>, LinkError> {
        match self.link.event(until) {
            Ok(first) => Ok(first.into_iter().chain(self.link.events()).collect()),
            Err(e) => {
                self.recover(Some(Failed::Io(e)))?;
                Ok(Vec::new())
            }
        }
    }
}

/// Model and serial number.
pub fn describe(ident: &Ident) -> String {
    format!("{} {}", ident.model, ident.serial)
}

pub(super) fn refusal(request: Request, why: DeviceError) -> Trouble {
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

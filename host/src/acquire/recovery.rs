//! Finding an instrument again after the line was lost, or the ownership of it.

use std::time::Duration;

use asperity_core::protocol::{DeviceError, MachineState, Request, Response};

use super::client::{Client, describe, refusal};
use super::error::{LinkError, Trouble};
use super::link::Failed;
use super::transport::Transport;
use super::wording::{name, unfit};

impl<T: Transport> Client<'_, T> {
    /// Finds the same instrument again, claims it and makes it idle.
    ///
    /// `lost` says how the line failed; without it the line is good and only the ownership is lost.
    pub(super) fn recover(&mut self, lost: Option<Failed>) -> Result<(), LinkError> {
        self.recoveries = self.recoveries.wrapping_add(1);
        let limit = self.patience().lost;
        let deadline = self.now() + limit;
        let mut reconnect = lost.is_some();
        let mut why = match lost {
            Some(Failed::Io(e)) => Why::Lost(Some(e)),
            _ => Why::Lost(None),
        };
        for k in 0.. {
            self.heed_stop()?;
            if self.now() >= deadline {
                break;
            }
            if reconnect && let Err(e) = self.link.reconnect() {
                why = Why::Lost(Some(e));
                self.link.pause(self.patience().back_off(k));
                continue;
            }
            match self.try_recover(deadline) {
                Ok(()) => return Ok(()),
                Err(Recovery::Wait(Why::Lost(None))) if matches!(why, Why::Lost(_)) => {}
                Err(Recovery::Wait(found)) => why = found,
                Err(Recovery::End(trouble)) => return Err(self.fail(trouble)),
            }
            // who owns it is found out on the open line
            reconnect = !matches!(why, Why::InUse);
            self.link.pause(self.patience().back_off(k));
        }
        Err(self.fail(why.trouble(limit.as_secs_f64())))
    }

    /// One try on an open line.
    fn try_recover(&mut self, deadline: Duration) -> Result<(), Recovery> {
        let left = deadline.saturating_sub(self.now()).min(self.patience().identify);
        let found = self.link.identify(left).map_err(|trouble| match trouble {
            Trouble::Lost { cause, .. } => Recovery::Wait(Why::Lost(cause)),
            Trouble::Astray { answers } => Recovery::Wait(Why::Astray(answers)),
            Trouble::Silent { .. } | Trouble::NotAnInstrument { .. } => {
                Recovery::Wait(Why::Lost(None))
            }
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
            return Ok(());
        }
        self.retake(Request::Claim)?;
        while self.now() < deadline {
            if let Response::Status(status) = self.retake(Request::Status)?
                && matches!(status.state, MachineState::Idle | MachineState::Fault)
            {
                // events of what was under way are of no use any more
                drop(self.link.events());
                return Ok(());
            }
            self.retake(Request::Stop)?;
            self.link.pause(self.patience().poll);
        }
        Err(Recovery::Wait(Why::Restless))
    }

    /// One request of a recovery.
    fn retake(&mut self, request: Request) -> Result<Response, Recovery> {
        match self.link.exchange(request) {
            Ok(Ok(response)) => Ok(response),
            Ok(Err(DeviceError::InUse)) => Err(Recovery::Wait(Why::InUse)),
            // restarted in between
            Ok(Err(DeviceError::NotOwner)) => Err(Recovery::Wait(Why::Lost(None))),
            Ok(Err(why)) => Err(Recovery::End(refusal(request, why))),
            Err(Failed::Silent) => Err(Recovery::Wait(Why::Mute(request))),
            Err(Failed::Astray(answers)) => Err(Recovery::Wait(Why::Astray(answers))),
            Err(Failed::Unfit(answer)) => Err(Recovery::End(unfit(request, answer))),
            Err(Failed::Interrupted) => Err(Recovery::End(Trouble::Interrupted)),
            Err(Failed::Io(e)) => Err(Recovery::Wait(Why::Lost(Some(e)))),
        }
    }
}

/// Why a try to recover did not succeed.
enum Recovery {
    /// It may succeed later.
    Wait(Why),
    End(Trouble),
}

/// The obstacle of a recovery.
enum Why {
    /// The line does not carry.
    Lost(Option<std::io::Error>),
    /// No answer to this one.
    Mute(Request),
    Astray(u64),
    InUse,
    /// It does not come to rest.
    Restless,
}

impl Why {
    /// The trouble it is if it lasts.
    fn trouble(self, seconds: f64) -> Trouble {
        match self {
            Self::Lost(cause) => Trouble::Lost { seconds, cause },
            Self::Mute(request) => Trouble::Mute { what: name(request), seconds },
            Self::Astray(answers) => Trouble::Astray { answers },
            Self::InUse => Trouble::InUse,
            Self::Restless => Trouble::Overdue { what: "stopping", seconds },
        }
    }
}

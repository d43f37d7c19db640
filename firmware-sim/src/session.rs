//! Whose the instrument is, and what was answered last: PROTOCOL.md, section 2.

use asperity_core::protocol::{DeviceError, Encoded, Event, Frame, Message, Request, encode};

use crate::clock::Instant;

/// What is to be done with a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// Carry it out, and answer.
    Execute,
    /// Refuse it.
    Refuse(DeviceError),
    /// Send the last answer again.
    Again,
    /// Old: say nothing.
    Ignore,
}

/// The last request of an owner, and its answer.
#[derive(Clone, Debug)]
struct Last {
    session: u16,
    sequence: u16,
    answer: Encoded,
}

/// The owner and the exchange with it.
#[derive(Clone, Debug)]
pub(crate) struct Session {
    owner: Option<u16>,
    heard: Instant,
    /// Outlives the owner: a `Release` may have to be answered again.
    last: Option<Last>,
    /// The number of the `Claim` that made the owner one.
    claim: u16,
    /// Number of the next event.
    event: u16,
}

impl Session {
    pub(crate) const fn new() -> Self {
        Self { owner: None, heard: Instant(0), last: None, claim: 0, event: 0 }
    }

    pub(crate) fn owner(&self) -> Option<u16> {
        self.owner
    }

    /// When the owner has been silent for too long.
    pub(crate) fn deadline(&self, limit_us: u32) -> Option<Instant> {
        self.owner.map(|_| self.heard.after(u64::from(limit_us)))
    }

    /// Judges a request; `limit_us` is the silence limit.
    pub(crate) fn judge(
        &mut self,
        frame: &Frame,
        request: &Request,
        now: Instant,
        limit_us: u32,
    ) -> Verdict {
        let Frame { session, sequence, .. } = *frame;
        // also without an owner
        let silent = self.deadline(limit_us).is_none_or(|deadline| deadline <= now);
        let owns = self.owner == Some(session);
        if let Some(last) = self.last.as_ref().filter(|last| last.session == session) {
            if last.sequence == sequence {
                if owns {
                    self.heard = now;
                }
                return Verdict::Again;
            }
            let newer = sequence.wrapping_sub(last.sequence) < 0x8000;
            // a `Claim` starts the count anew, but not if it is the old one come late
            let anew = *request == Request::Claim && (sequence != self.claim || silent);
            if owns && !newer && !anew {
                return Verdict::Ignore;
            }
        }
        if owns {
            self.heard = now;
        }
        match request {
            Request::Identify | Request::Status | Request::Diagnostics | Request::EmergencyStop => {
                Verdict::Execute
            }
            Request::Claim if session == 0 => Verdict::Refuse(DeviceError::BadValue),
            Request::Claim if silent || owns => Verdict::Execute,
            Request::Claim => Verdict::Refuse(DeviceError::InUse),
            _ if owns => Verdict::Execute,
            _ => Verdict::Refuse(DeviceError::NotOwner),
        }
    }

    /// A new owner.
    pub(crate) fn claim(&mut self, frame: &Frame, now: Instant) {
        (self.owner, self.heard, self.claim) = (Some(frame.session), now, frame.sequence);
    }

    /// Nobody's.
    pub(crate) fn release(&mut self) {
        self.owner = None;
    }

    /// Nobody's, and nothing remembered: the connection is gone.
    pub(crate) fn forget(&mut self) {
        (self.owner, self.last) = (None, None);
    }

    /// The bytes of an answer; those to the owner are remembered (`owned` before it was carried out).
    pub(crate) fn answer(&mut self, to: &Frame, message: Message, owned: bool) -> Encoded {
        let Frame { session, sequence, .. } = *to;
        let answer = encode(&Frame { session, sequence, message });
        if owned || self.owner == Some(session) {
            self.last = Some(Last { session, sequence, answer: answer.clone() });
        }
        answer
    }

    /// The last answer.
    pub(crate) fn again(&self) -> &[u8] {
        self.last.as_ref().map_or(&[], |last| last.answer.as_bytes())
    }

    /// The bytes of an event for the owner, if there is one.
    pub(crate) fn event(&mut self, event: Event) -> Option<Encoded> {
        let session = self.owner?;
        let frame = Frame { session, sequence: self.event, message: Message::Event(event) };
        self.event = self.event.wrapping_add(1);
        Some(encode(&frame))
    }
}

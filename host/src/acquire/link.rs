//! Frames over bytes: one request, its answer, and the events between them.

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use asperity_core::protocol::{
    Decoder, DeviceError, Encoded, Event, Frame, FrameError, Ident, Message, Request, Response,
    VERSION, encode,
};

use super::error::Trouble;
use super::patience::Patience;
use super::transport::Transport;
use super::wording::{fits, kind, unfit};

/// Events kept; more than any credit. Further ones are lost, as the line may lose them.
const MOST_EVENTS: usize = 4096;
/// Bytes of a stranger that are shown.
const EXCERPT: usize = 32;
/// The longest wait without a check of the stop flag.
const SLICE: Duration = Duration::from_millis(50);

/// The answer of an instrument.
pub(super) type Answer = Result<Response, DeviceError>;

/// Why there is no answer.
#[derive(Debug)]
pub(super) enum Failed {
    /// None came, although the request was repeated.
    Silent,
    /// Only answers to what was not asked came, so many.
    Astray(u64),
    /// The request was answered by what is no answer to it.
    Unfit(&'static str),
    /// The user stopped it.
    Interrupted,
    /// The line is broken.
    Io(io::Error),
}

impl From<io::Error> for Failed {
    fn from(e: io::Error) -> Self {
        Self::Io(e)
    }
}

/// One end of a line on which frames are exchanged.
#[derive(Debug)]
pub(super) struct Link<'s, T> {
    pub(super) line: T,
    pub(super) patience: Patience,
    /// Once it is set, no wait continues.
    pub(super) stop: Option<&'s AtomicBool>,
    session: u16,
    sequence: u16,
    decoder: Decoder,
    events: VecDeque<Event>,
    /// The answer to the request under way.
    answer: Option<Answer>,
    asked: Request,
    /// The kind of an answer that is none to the request under way.
    unfit: Option<&'static str>,
    /// When the last answer came.
    answered: Duration,
    /// The version of an instrument that speaks another one.
    version: Option<u16>,
    heard: Heard,
}

/// The bytes received since the identification began.
#[derive(Debug, Default)]
struct Heard {
    bytes: u64,
    first: Vec<u8>,
    /// Frames that only an instrument sends.
    frames: u64,
    /// Answers among them that are to another request.
    astray: u64,
}

impl<T: Transport> Link<'_, T> {
    pub(super) fn new(line: T, patience: Patience) -> Self {
        Self {
            line,
            patience,
            stop: None,
            session: random(),
            sequence: 0,
            decoder: Decoder::new(),
            events: VecDeque::new(),
            answer: None,
            asked: Request::Identify,
            unfit: None,
            answered: Duration::ZERO,
            version: None,
            heard: Heard::default(),
        }
    }

    pub(super) fn session(&self) -> u16 {
        self.session
    }

    /// Whether the user wants it to end.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(|stop| stop.load(Ordering::SeqCst))
    }

    /// When the last answer came, by the line's clock.
    pub(super) fn answered(&self) -> Duration {
        self.answered
    }

    /// Sends a request, and repeats the same bytes until an answer comes.
    pub(super) fn exchange(&mut self, request: Request) -> Result<Answer, Failed> {
        let frame = self.number(request);
        let astray = self.heard.astray;
        for k in 0..self.patience.tries {
            if let Some(answer) = self.attempt(&frame, k, Duration::MAX)? {
                return Ok(answer);
            }
        }
        // one or two may be late answers to a client that has gone
        match self.heard.astray.saturating_sub(astray) {
            answers if answers >= u64::from(self.patience.tries) => Err(Failed::Astray(answers)),
            _ => Err(Failed::Silent),
        }
    }

    /// Identifies the instrument, for at most `limit`; opens a broken line again.
    pub(super) fn identify(&mut self, limit: Duration) -> Result<Ident, Trouble> {
        let deadline = self.line.now() + limit;
        let (bad, mut cause, mut k) = (self.decoder.bad(), None, 0);
        self.heard = Heard::default();
        let frame = self.number(Request::Identify);
        while self.line.now() < deadline {
            match self.attempt(&frame, k, deadline) {
                Ok(Some(Ok(Response::Ident(ident)))) => return plausible(ident),
                Ok(Some(_)) => self.pause(self.patience.back_off(k)),
                Ok(None) | Err(Failed::Silent | Failed::Astray(_)) => {}
                Err(Failed::Interrupted) => return Err(Trouble::Interrupted),
                Err(Failed::Unfit(answer)) => return Err(unfit(Request::Identify, answer)),
                Err(Failed::Io(e)) => {
                    self.pause(self.patience.back_off(k));
                    cause = Some(self.reconnect().err().unwrap_or(e));
                }
            }
            if let Some(theirs) = self.version.take() {
                return Err(Trouble::Version { theirs, ours: VERSION });
            }
            k += 1;
        }
        let seconds = limit.as_secs_f64();
        if self.heard.astray >= u64::from(self.patience.tries.min(k)) && k > 0 {
            return Err(Trouble::Astray { answers: self.heard.astray });
        }
        if self.heard.bytes > 0 && self.heard.frames == 0 {
            let dot = |&byte: &u8| if matches!(byte, b' '..=b'~') { char::from(byte) } else { '.' };
            let first: String = self.heard.first.iter().map(dot).collect();
            // what servers of serial ports say to a second client before they close the line
            if first.to_ascii_lowercase().contains("in use") {
                return Err(Trouble::InUse);
            }
            let bad = self.decoder.bad().wrapping_sub(bad);
            return Err(Trouble::NotAnInstrument { bytes: self.heard.bytes, bad, first });
        }
        Err(match cause {
            Some(_) => Trouble::Lost { seconds, cause },
            None => Trouble::Silent { seconds },
        })
    }

    /// Opens the line again and discards what came before.
    pub(super) fn reconnect(&mut self) -> io::Result<()> {
        self.decoder.reset();
        self.events.clear();
        self.line.reconnect()
    }

    /// The next event; waits for it until `until`, or until it is stopped.
    pub(super) fn event(&mut self, until: Duration) -> io::Result<Option<Event>> {
        while self.events.is_empty() && self.line.now() < until && !self.is_stopped() {
            self.receive(until)?;
        }
        Ok(self.events.pop_front())
    }

    /// Waits, at most until it is stopped.
    pub(super) fn pause(&mut self, time: Duration) {
        let deadline = self.line.now() + time;
        while self.line.now() < deadline && !self.is_stopped() {
            self.line.pause(deadline.saturating_sub(self.line.now()).min(SLICE));
        }
    }

    /// The received events that are not yet taken.
    pub(super) fn waiting(&self) -> impl Iterator<Item = &Event> {
        self.events.iter()
    }

    /// The events that have come, without waiting.
    pub(super) fn events(&mut self) -> impl Iterator<Item = Event> + '_ {
        self.events.drain(..)
    }

    fn number(&mut self, request: Request) -> Encoded {
        self.sequence = self.sequence.wrapping_add(1);
        (self.asked, self.answer) = (request, None);
        (self.unfit, self.version) = (None, None);
        encode(&Frame {
            session: self.session,
            sequence: self.sequence,
            message: Message::Request(request),
        })
    }

    /// Sends, and waits once.
    fn attempt(
        &mut self,
        frame: &Encoded,
        k: u32,
        end: Duration,
    ) -> Result<Option<Answer>, Failed> {
        if self.is_stopped() {
            return Err(Failed::Interrupted);
        }
        self.line.send(frame.as_bytes())?;
        let back_off = if k == 0 { Duration::ZERO } else { self.patience.back_off(k - 1) };
        let until = (self.line.now() + self.patience.answer + back_off).min(end);
        while self.answer.is_none() && self.version.is_none() && self.line.now() < until {
            self.receive(until)?;
            if let (None, Some(answer)) = (self.answer, self.unfit) {
                return Err(Failed::Unfit(answer));
            }
            // what is under way was heard, or will not be: last words come next
            if self.answer.is_none() && self.is_stopped() {
                return Err(Failed::Interrupted);
            }
        }
        Ok(self.answer.take())
    }

    /// Reads everything that comes first until `until`; returns early if there is a flag to check.
    fn receive(&mut self, until: Duration) -> io::Result<()> {
        let mut buffer = [0; 4096];
        let most = if self.stop.is_some() { SLICE } else { Duration::MAX };
        let wait = until.saturating_sub(self.line.now()).min(most);
        let count = self.line.receive(&mut buffer, wait)?;
        let mut bytes = buffer.get(..count).unwrap_or(&[]);
        self.heard.bytes += bytes.len() as u64;
        let room = EXCERPT.saturating_sub(self.heard.first.len());
        self.heard.first.extend(bytes.iter().take(room));
        while let Some(result) = self.decoder.next(&mut bytes) {
            match result {
                Ok(frame) => self.take(frame),
                Err(FrameError::Version(version)) => self.version = Some(version),
                Err(_) => {}
            }
        }
        Ok(())
    }

    fn take(&mut self, frame: Frame) {
        let (mine, current) = (frame.session == self.session, frame.sequence == self.sequence);
        self.heard.frames += u64::from(!matches!(frame.message, Message::Request(_)));
        match frame.message {
            Message::Response(response) if mine && current => {
                if fits(self.asked, &response) {
                    (self.answer, self.answered) = (Some(Ok(response)), self.line.now());
                } else {
                    self.unfit = Some(kind(&response));
                }
            }
            Message::Error(error) if mine && current => {
                (self.answer, self.answered) = (Some(Err(error)), self.line.now());
            }
            Message::Response(_) | Message::Error(_) => {
                // of another session, or with a number that was not yet given; older ones come late
                let ahead = frame.sequence.wrapping_sub(self.sequence) < 0x8000;
                self.heard.astray += u64::from(!mine || (ahead && !current));
            }
            Message::Event(event) if mine && self.events.len() < MOST_EVENTS => {
                self.events.push_back(event);
            }
            // somebody else's
            _ => {}
        }
    }
}

/// The requirements of this program.
fn plausible(ident: Ident) -> Result<Ident, Trouble> {
    if ident.protocol != VERSION {
        return Err(Trouble::Version { theirs: ident.protocol, ours: VERSION });
    }
    for (name, axis) in [("sigma", ident.sigma), ("theta", ident.theta)] {
        if axis.speed == 0 || axis.least > axis.most {
            return Err(Trouble::Nonsense(format!(
                "its {name} axis goes from {} to {} degrees at {} microdegrees a second",
                axis.least.degrees(),
                axis.most.degrees(),
                axis.speed
            )));
        }
    }
    if ident.max_points == 0 {
        return Err(Trouble::Nonsense("its segments have no points".to_owned()));
    }
    Ok(ident)
}

/// A session number, not 0, from the keys that the operating system draws for hash tables.
fn random() -> u16 {
    let drawn = RandomState::new().hash_one(std::process::id());
    (drawn % u64::from(u16::MAX)) as u16 + 1
}

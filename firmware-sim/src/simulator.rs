//! The instrument: bytes and time in, bytes out.

use asperity_core::protocol::{
    Decoder, DeviceError, Diagnostics, Event, Frame, Ident, MAX_POINTS, MachineState, Message,
    Request, Response, Status, Text16, VERSION, scpi::Command,
};

use crate::clock::{Instant, Sink, earlier};
use crate::config::{Config, SIGMA, THETA};
use crate::fault::MachineFault;
use crate::machine::{Happening, Machine, Progress};
use crate::session::{Session, Verdict};
use crate::text::{self, Text, TextError};

/// Most things told in one call; more have to wait for the next.
const MOST_AT_ONCE: usize = 16;

/// Version of the firmware.
const FIRMWARE: [u8; 3] = [0, 1, 0];

/// What the port listens to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Text,
    Frames,
}

/// A goniophotometer with nothing behind it but arithmetic.
///
/// It waits for nothing: [`handle`](Self::handle) takes what has come and returns after at most a few
/// milliseconds; [`poll_at`](Self::poll_at) says when to call it again although nothing came.
///
/// ```
/// use asperity_core::protocol::{Decoder, Frame, Message, Request, Response, encode};
/// use asperity_firmware_sim::{Config, Instant, Simulator};
/// let mut instrument = Simulator::new(Config::demo());
/// let request = Frame { session: 7, sequence: 1, message: Message::Request(Request::Identify) };
/// let mut line = Vec::new();
/// let mut out = |bytes: &[u8]| line.extend_from_slice(bytes);
/// instrument.handle(encode(&request).as_bytes(), Instant(0), &mut out);
/// let answer = Decoder::new().next(&mut &line[..]).unwrap().unwrap();
/// assert!(matches!(answer.message, Message::Response(Response::Ident(_))));
/// ```
#[derive(Clone, Debug)]
pub struct Simulator {
    machine: Machine,
    session: Session,
    decoder: Decoder,
    text: Text,
    mode: Mode,
    /// A text command waits for its reading.
    reading_wanted: bool,
    /// When bytes came last, and when anything happened last.
    received: Instant,
    now: Instant,
    stack_bytes: u32,
}

impl Simulator {
    /// An instrument just switched on, at `Instant(0)`: not homed, lamp on, nobody's.
    pub const fn new(config: Config) -> Self {
        Self {
            machine: Machine::new(config),
            session: Session::new(),
            decoder: Decoder::new(),
            text: Text::new(),
            mode: Mode::Text,
            reading_wanted: false,
            received: Instant(0),
            now: Instant(0),
            stack_bytes: 0,
        }
    }

    /// What it was made with.
    pub fn config(&self) -> &Config {
        self.machine.config()
    }

    /// What it is doing.
    pub fn state(&self) -> MachineState {
        self.machine.state()
    }

    /// A snapshot, as of the last call of [`handle`](Self::handle).
    pub fn status(&self) -> Status {
        self.machine.status(self.now, self.session.owner())
    }

    /// Counters, as of the last call of [`handle`](Self::handle).
    pub fn diagnostics(&self) -> Diagnostics {
        Diagnostics {
            frames: self.decoder.good(),
            bad_frames: self.decoder.bad(),
            stack_bytes: self.stack_bytes,
            uptime_ms: (self.now.0 / 1000) as u32,
        }
    }

    /// Tells [`Diagnostics`] how much stack the firmware has used at most, bytes.
    pub fn set_stack_bytes(&mut self, bytes: u32) {
        self.stack_bytes = bytes;
    }

    /// A fault of the machine at its next occasion.
    pub fn inject(&mut self, fault: MachineFault) {
        self.machine.injected().add(fault);
    }

    /// Takes bytes, does what is due by `now`, and answers.
    pub fn handle(&mut self, bytes: &[u8], now: Instant, out: &mut impl Sink) {
        // what was due before these bytes came is done before they are looked at
        self.now = self.now.max(now);
        self.advance(out);
        if !bytes.is_empty() {
            self.receive(bytes, out);
            self.tell_news(out);
        }
    }

    /// When to call [`handle`](Self::handle) again, with or without bytes; the past means at once.
    pub fn poll_at(&self) -> Option<Instant> {
        earlier(self.machine.due(), self.silence()).map(|at| at.max(self.now))
    }

    /// The connection is gone: the instrument stops and is nobody's, as after `Release`.
    pub fn disconnected(&mut self, now: Instant) {
        self.now = self.now.max(now);
        self.release();
        self.session.forget();
        self.decoder.reset();
        self.text.drop_line();
    }

    /// When it stops because its owner is silent.
    fn silence(&self) -> Option<Instant> {
        let deadline = self.session.deadline(self.config().silence_us)?;
        self.machine.is_active().then_some(deadline)
    }

    fn release(&mut self) {
        self.machine.stop(self.now);
        self.session.release();
        self.mode = Mode::Text;
        self.reading_wanted = false;
    }

    /// Does what is due, in the order of time.
    fn advance(&mut self, out: &mut dyn Sink) {
        let silence = self.silence();
        let until = silence.map_or(self.now, |silence| silence.min(self.now));
        for _ in 0..MOST_AT_ONCE {
            match self.machine.step(until) {
                Progress::Nothing | Progress::Traced => break,
                Progress::Some => {}
                Progress::Happened(happening) => self.tell(happening, out),
            }
        }
        if silence.is_some_and(|silence| silence <= self.now) && self.machine.is_active() {
            self.machine.stop(until);
            self.tell_news(out);
        }
    }

    /// Changes of state that requests have made.
    fn tell_news(&mut self, out: &mut dyn Sink) {
        while let Some(news) = self.machine.news() {
            self.tell(news, out);
        }
    }

    fn tell(&mut self, happening: Happening, out: &mut dyn Sink) {
        let event = match happening {
            Happening::State(state) => Event::State(state),
            Happening::Fault(fault) => Event::Fault(fault),
            Happening::Point(point) => Event::Point(point),
            Happening::Reading => return self.say_reading(out),
        };
        if matches!(event, Event::Fault(_)) && core::mem::take(&mut self.reading_wanted) {
            self.text.error(TextError::Hardware);
        }
        if let Some(frame) = self.session.event(event) {
            out.write(frame.as_bytes());
        }
    }

    /// Shares the bytes out between text and frames.
    fn receive(&mut self, mut bytes: &[u8], out: &mut dyn Sink) {
        let pause = self.now.since(self.received);
        let silent = pause >= u64::from(self.config().silence_us);
        if silent && self.decoder.is_between_frames() {
            self.mode = Mode::Text;
        }
        self.received = self.now;
        while let [first, rest @ ..] = bytes {
            match self.mode {
                Mode::Frames => {
                    if let Some(Ok(frame)) = self.decoder.next(&mut bytes) {
                        self.frame(&frame, out);
                        self.tell_news(out);
                    }
                }
                Mode::Text if *first == 0 => {
                    self.text.drop_line();
                    self.mode = Mode::Frames;
                }
                Mode::Text => {
                    bytes = rest;
                    if let Some(command) = self.text.take(*first) {
                        self.command(command, out);
                        self.tell_news(out);
                    }
                }
            }
        }
    }

    fn frame(&mut self, frame: &Frame, out: &mut dyn Sink) {
        let Message::Request(request) = frame.message else { return };
        let limit = self.config().silence_us;
        let owned = self.session.owner() == Some(frame.session);
        let message = match self.session.judge(frame, &request, self.now, limit) {
            Verdict::Ignore => return,
            Verdict::Again => return out.write(self.session.again()),
            Verdict::Refuse(error) => Message::Error(error),
            Verdict::Execute => match self.execute(frame, &request) {
                Ok(response) => Message::Response(response),
                Err(error) => Message::Error(error),
            },
        };
        let answer = self.session.answer(frame, message, owned);
        out.write(answer.as_bytes());
    }

    fn execute(&mut self, frame: &Frame, request: &Request) -> Result<Response, DeviceError> {
        match request {
            Request::Identify => return Ok(Response::Ident(self.ident())),
            Request::Status => return Ok(Response::Status(self.status())),
            Request::Diagnostics => return Ok(Response::Diagnostics(self.diagnostics())),
            Request::Claim => self.session.claim(frame, self.now),
            Request::Release => self.release(),
            _ => return self.machine.apply(request, self.now),
        }
        Ok(Response::Accepted)
    }

    fn ident(&self) -> Ident {
        let config = self.config();
        Ident {
            protocol: VERSION,
            model: Text16::new("GP-200 simulator"),
            serial: config.serial,
            firmware: FIRMWARE,
            sigma: config.limits(SIGMA),
            theta: config.limits(THETA),
            max_points: MAX_POINTS,
        }
    }

    fn command(&mut self, command: Command, out: &mut dyn Sink) {
        let deadline = self.session.deadline(self.config().silence_us);
        match command {
            Command::Identify => return self.say_identity(out),
            Command::NextError => return self.text.say_error(out),
            Command::ClearErrors => return self.text.clear_errors(),
            Command::Angles => return self.say_angles(out),
            // an owner not heard of for long gives way to it as to another client
            Command::Reset if deadline.is_some_and(|deadline| deadline <= self.now) => {
                self.session.release();
            }
            _ if self.session.owner().is_some() => return self.text.error(TextError::Protected),
            _ => {}
        }
        if let Err(error) = self.obey(command, out) {
            self.text.error(error);
        }
    }

    fn obey(&mut self, command: Command, out: &mut dyn Sink) -> Result<(), TextError> {
        let now = self.now;
        match command {
            Command::Reset => {
                self.reading_wanted = false;
                let requests =
                    [Request::Stop, Request::ClearFault, Request::Lamp(true), Request::Home];
                for request in &requests {
                    self.machine.apply(request, now)?;
                }
            }
            Command::SetAngles(sigma, theta) => self.machine.travel_both(sigma, theta, now)?,
            Command::Measure => {
                self.machine.apply(&Request::Read, now)?;
                self.reading_wanted = true;
            }
            Command::ScanData => self.say_points(out)?,
            Command::Identify | Command::NextError | Command::ClearErrors | Command::Angles => {}
        }
        Ok(())
    }

    fn say_identity(&self, out: &mut dyn Sink) {
        out.write(b"Asperity,GP-200 simulator,");
        text::unsigned(self.config().serial, out);
        let [major, minor, patch] = FIRMWARE;
        for (sign, number) in [(b",", major), (b".", minor), (b".", patch)] {
            out.write(sign);
            text::unsigned(u32::from(number), out);
        }
        out.write(b"\n");
    }

    fn say_angles(&self, out: &mut dyn Sink) {
        let Status { sigma, theta, .. } = self.status();
        text::angle(sigma, out);
        out.write(b",");
        text::angle(theta, out);
        out.write(b"\n");
    }

    fn say_reading(&mut self, out: &mut dyn Sink) {
        if !core::mem::take(&mut self.reading_wanted) {
            return;
        }
        if let Some(reading) = self.machine.last_reading() {
            text::exponential(self.machine.relative(&reading), out);
            out.write(b"\n");
        }
    }

    fn say_points(&self, out: &mut dyn Sink) -> Result<(), TextError> {
        let (first, end) = self.machine.points().ok_or(TextError::NoData)?;
        if end <= first {
            return Err(TextError::NoData);
        }
        text::block(u32::from(end - first) * 4, out);
        for index in first..end {
            let point = self.machine.point(index);
            let value = point.map_or(0.0, |point| self.machine.relative(&point.reading));
            out.write(&value.to_le_bytes());
        }
        out.write(b"\n");
        Ok(())
    }
}

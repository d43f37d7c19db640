//! An instrument, a client, and a clock.

use asperity_core::protocol::{
    Axis, CalibrationKind, Decoder, DeviceError, Event, Frame, MachineState, Message, Microdegrees,
    Point, Reading, Request, Response, Segment, Status, encode,
};
use std::boxed::Box;
use std::vec::Vec;

use crate::{Config, Instant, Simulator};

pub(super) const SESSION: u16 = 7;

/// A small sample, quick to trace.
pub(super) fn quick() -> Config {
    Config { rays: 2000, ..Config::demo() }
}

/// Owns the instrument from the start.
pub(super) struct Bench {
    pub(super) simulator: Box<Simulator>,
    pub(super) now: Instant,
    pub(super) sequence: u16,
    /// Everything said since the last request.
    pub(super) events: Vec<Event>,
}

#[expect(clippy::large_types_passed_by_value, reason = "written where it is used")]
impl Bench {
    pub(super) fn new(config: Config) -> Self {
        let simulator = Box::new(Simulator::new(config));
        let mut bench =
            Self { simulator, now: Instant(1_000_000), sequence: 0, events: Vec::new() };
        assert_eq!(bench.ask(Request::Claim), Ok(Response::Accepted));
        bench
    }

    /// Homed, and the lamp is on.
    pub(super) fn homed(config: Config) -> Self {
        let mut bench = Self::new(config);
        bench.accept(Request::Home);
        bench.finish();
        assert!(bench.simulator.status().homed);
        bench
    }

    /// Bytes in, bytes out, now.
    pub(super) fn raw(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        self.simulator.handle(bytes, self.now, &mut |b: &[u8]| out.extend_from_slice(b));
        out
    }

    pub(super) fn frame(session: u16, sequence: u16, request: Request) -> Vec<u8> {
        let frame = Frame { session, sequence, message: Message::Request(request) };
        encode(&frame).as_bytes().to_vec()
    }

    /// The answer of the instrument to any session; events are put aside.
    pub(super) fn answer_to(
        &mut self,
        session: u16,
        sequence: u16,
        request: Request,
    ) -> Option<Result<Response, DeviceError>> {
        let out = self.raw(&Self::frame(session, sequence, request));
        self.sort(&out, session, sequence)
    }

    fn sort(
        &mut self,
        out: &[u8],
        session: u16,
        sequence: u16,
    ) -> Option<Result<Response, DeviceError>> {
        let (mut decoder, mut bytes, mut answer) = (Decoder::new(), out, None);
        while let Some(frame) = decoder.next(&mut bytes) {
            let frame = frame.expect("a good frame");
            match frame.message {
                Message::Event(event) => self.events.push(event),
                Message::Response(response) => {
                    assert_eq!((frame.session, frame.sequence), (session, sequence));
                    assert!(answer.replace(Ok(response)).is_none(), "two answers");
                }
                Message::Error(error) => {
                    assert_eq!((frame.session, frame.sequence), (session, sequence));
                    assert!(answer.replace(Err(error)).is_none(), "two answers");
                }
                Message::Request(_) => panic!("an instrument does not ask"),
            }
        }
        answer
    }

    /// The owner asks; exactly one answer.
    pub(super) fn ask(&mut self, request: Request) -> Result<Response, DeviceError> {
        self.sequence = self.sequence.wrapping_add(1);
        self.events.clear();
        self.answer_to(SESSION, self.sequence, request).expect("an answer")
    }

    pub(super) fn accept(&mut self, request: Request) {
        assert_eq!(self.ask(request), Ok(Response::Accepted), "{request:?}");
    }

    pub(super) fn refused(&mut self, request: Request) -> DeviceError {
        self.ask(request).expect_err("it should not have been accepted")
    }

    pub(super) fn status(&mut self) -> Status {
        match self.ask(Request::Status) {
            Ok(Response::Status(status)) => status,
            other => panic!("{other:?}"),
        }
    }

    /// Lets a call come at the next time the instrument wants one; false if it wants none.
    pub(super) fn turn(&mut self) -> bool {
        let Some(at) = self.simulator.poll_at() else { return false };
        self.now = self.now.max(at);
        let out = self.raw(&[]);
        assert_eq!(self.sort(&out, SESSION, self.sequence), None);
        true
    }

    /// Time passes, as far as the client keeps quiet.
    pub(super) fn wait(&mut self, us: u64) {
        let end = self.now.after(us);
        while self.simulator.poll_at().is_some_and(|at| at <= end) {
            self.turn();
        }
        self.now = end;
        let out = self.raw(&[]);
        assert_eq!(self.sort(&out, SESSION, self.sequence), None);
    }

    /// Until the instrument is idle or stopped, saying something every second; the events of all that.
    pub(super) fn finish(&mut self) {
        let mut all = core::mem::take(&mut self.events);
        for _ in 0..1000 {
            let end = self.now.after(1_000_000);
            while self.simulator.poll_at().is_some_and(|at| at <= end) {
                self.turn();
            }
            all.append(&mut self.events);
            if matches!(self.simulator.state(), MachineState::Idle | MachineState::Fault) {
                self.events = all;
                return;
            }
            self.now = end;
            self.status();
            all.append(&mut self.events);
        }
        panic!("it does not end: {:?}", self.simulator.status());
    }

    pub(super) fn travel(&mut self, axis: Axis, to: i32) {
        self.accept(Request::Move(axis, Microdegrees(to)));
        self.finish();
    }

    pub(super) fn read(&mut self) -> Reading {
        self.accept(Request::Read);
        self.finish();
        match self.ask(Request::LastReading) {
            Ok(Response::Reading(reading)) => reading,
            other => panic!("{other:?}"),
        }
    }

    pub(super) fn calibrate(&mut self) {
        for kind in [CalibrationKind::Dark, CalibrationKind::Reference] {
            self.accept(Request::Calibrate(kind));
            self.finish();
        }
    }

    /// The points told since the last request.
    pub(super) fn points(&self) -> Vec<Point> {
        self.events
            .iter()
            .filter_map(|event| match event {
                Event::Point(point) => Some(*point),
                _ => None,
            })
            .collect()
    }

    pub(super) fn scan(&mut self, segment: Segment) -> Vec<Point> {
        self.accept(Request::Scan(segment));
        self.finish();
        self.points()
    }
}

/// Points every `step` microdegrees, all credit at once.
pub(super) fn segment(start: i32, step: i32, count: u16) -> Segment {
    let (start, step) = (Microdegrees(start), Microdegrees(step));
    Segment { segment: 42, start, step, count, first: 0, credit: count }
}

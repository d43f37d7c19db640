//! A small instrument for tests: it answers, moves at once, and what it says can be tampered with.

use std::time::Duration;

use asperity_core::protocol::{
    Axis, Calibration, Decoder, DeviceError, Encoded, Event, Frame, Ident, MachineState, Message,
    Microdegrees, Point, Range, Reading, Request, Response, Segment, Status, encode,
};

use super::estimate;
use super::transport::Peer;

/// The fate of a frame of the instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fate {
    Pass,
    Drop,
    Corrupt,
    Twice,
    /// The line breaks before it.
    Cut,
    /// The power fails before it.
    Restart,
}

/// Decides on each frame: its number from 0, and the frame, which may be changed.
pub(super) type Tamper = Box<dyn FnMut(u64, &mut Frame) -> Fate>;

pub(super) struct Device {
    pub(super) ident: Ident,
    pub(super) status: Status,
    pub(super) tamper: Tamper,
    /// Every request heard, as its frame.
    pub(super) heard: Vec<Frame>,
    /// Until when the line stays broken.
    pub(super) down: Option<Duration>,
    /// How long it stays broken.
    pub(super) outage: Duration,
    decoder: Decoder,
    answered: Option<(Frame, Encoded)>,
    segment: Option<Segment>,
    calibrations: u32,
    sent: u64,
}

impl Device {
    pub(super) fn new() -> Self {
        let mut ident = estimate::typical();
        ident.serial = 42;
        Self {
            ident,
            status: off(),
            tamper: Box::new(|_, _| Fate::Pass),
            heard: Vec::new(),
            down: None,
            outage: Duration::from_secs(2),
            decoder: Decoder::new(),
            answered: None,
            segment: None,
            calibrations: 0,
            sent: 0,
        }
    }

    pub(super) fn tampered(tamper: impl FnMut(u64, &mut Frame) -> Fate + 'static) -> Self {
        Self { tamper: Box::new(tamper), ..Self::new() }
    }

    fn say(&mut self, mut frame: Frame, now: Duration, out: &mut Vec<u8>) {
        let fate = (self.tamper)(self.sent, &mut frame);
        self.sent += 1;
        let bytes = encode(&frame);
        match fate {
            Fate::Pass => out.extend_from_slice(bytes.as_bytes()),
            Fate::Drop => {}
            Fate::Corrupt => {
                let middle = bytes.as_bytes().len() / 2;
                let flip = |(k, byte): (usize, &u8)| if k == middle { byte ^ 0x55 } else { *byte };
                out.extend(bytes.as_bytes().iter().enumerate().map(flip));
            }
            Fate::Twice => out.extend_from_slice(&bytes.as_bytes().repeat(2)),
            Fate::Cut => {
                self.down = Some(now + self.outage);
                self.status.owner = None;
                self.status.state = MachineState::Idle;
            }
            Fate::Restart => (self.status, self.segment, self.answered) = (off(), None, None),
        }
    }

    fn request(&mut self, frame: Frame, request: Request, now: Duration, out: &mut Vec<u8>) {
        self.heard.push(frame);
        if let Some((last, answer)) = &self.answered
            && *last == frame
        {
            let Ok(again) = Self::decode(answer) else { return };
            return self.say(again, now, out);
        }
        let free = matches!(request, Request::Identify | Request::Status | Request::Claim);
        let message = if !free && self.status.owner != Some(frame.session) {
            Message::Error(DeviceError::NotOwner)
        } else {
            self.apply(request, frame.session).map_or_else(Message::Error, Message::Response)
        };
        let answer = Frame { message, ..frame };
        self.answered = Some((frame, encode(&answer)));
        self.say(answer, now, out);
        if let (
            Request::Scan(Segment { segment, first: next, credit, .. })
            | Request::Continue { segment, next, credit },
            Message::Response(_),
        ) = (request, message)
        {
            self.points(frame.session, segment, next, credit, now, out);
        }
    }

    fn decode(encoded: &Encoded) -> Result<Frame, ()> {
        Decoder::new().next(&mut encoded.as_bytes()).ok_or(())?.map_err(|_| ())
    }

    fn apply(&mut self, request: Request, session: u16) -> Result<Response, DeviceError> {
        let status = &mut self.status;
        match request {
            Request::Identify => return Ok(Response::Ident(self.ident)),
            Request::Status => return Ok(Response::Status(*status)),
            Request::LastCalibration => return Ok(Response::Calibration(self.calibration())),
            Request::Claim => {
                if status.owner.is_some_and(|owner| owner != session) {
                    return Err(DeviceError::InUse);
                }
                status.owner = Some(session);
            }
            Request::Release => status.owner = None,
            Request::Home => status.homed = true,
            Request::Move(..) | Request::Scan(_) if !status.homed => {
                return Err(DeviceError::NotHomed);
            }
            Request::Move(Axis::Sigma, to) => status.sigma = to,
            Request::Move(Axis::Theta, to) => status.theta = to,
            Request::Aperture(aperture) => status.aperture = aperture,
            Request::Range(range) => status.range = range,
            Request::Integration(us) => status.integration_us = us,
            Request::Lamp(on) => status.lamp = on,
            Request::Calibrate(_) => {
                self.calibrations += 1;
                status.calibration = Some(self.calibrations);
            }
            Request::Scan(segment) => {
                (self.segment, status.state) = (Some(segment), MachineState::Measuring);
                status.segment = Some((segment.segment, segment.first));
            }
            Request::Continue { segment, .. }
                if self.segment.is_none_or(|held| held.segment != segment) =>
            {
                return Err(DeviceError::NoSegment);
            }
            Request::Stop => status.state = MachineState::Idle,
            _ => {}
        }
        Ok(Response::Accepted)
    }

    fn calibration(&self) -> Calibration {
        let (id, reference) = (self.status.calibration.unwrap_or(0), 900.0);
        Calibration { id, dark: [0.5; 6], reference, range: 0 }
    }

    /// All that credit allows, at once.
    fn points(
        &mut self,
        session: u16,
        segment: u32,
        next: u16,
        credit: u16,
        now: Duration,
        out: &mut Vec<u8>,
    ) {
        let Some(held) = self.segment else { return };
        let end = next.saturating_add(credit).min(held.count);
        for index in next..end {
            let theta = Microdegrees(held.start.0 + held.step.0 * i32::from(index));
            let light = 1.0 + f64::from(self.status.sigma.0) + (f64::from(theta.0) / 1e6).cos();
            let signal = (0.5 + 1e-3 * light.abs().sqrt()) as f32;
            let reading = Reading { signal, dark: 0.5, range: 2, over: false, under: false };
            let message = Message::Event(Event::Point(Point { segment, index, theta, reading }));
            self.status.segment = Some((segment, index + 1));
            self.say(Frame { session, sequence: index, message }, now, out);
        }
        if end == held.count {
            self.status.state = MachineState::Idle;
        }
    }
}

/// As after power-on.
fn off() -> Status {
    Status {
        state: MachineState::Idle,
        fault: None,
        homed: false,
        lamp: false,
        sigma: Microdegrees(0),
        theta: Microdegrees(0),
        aperture: Microdegrees(1),
        range: Range::Auto,
        integration_us: 1000,
        segment: None,
        calibration: None,
        owner: None,
    }
}

impl Peer for Device {
    fn exchange(&mut self, mut bytes: &[u8], now: Duration, out: &mut Vec<u8>) {
        while let Some(result) = self.decoder.next(&mut bytes) {
            if let Ok(frame) = result
                && let Message::Request(request) = frame.message
            {
                self.request(frame, request, now, out);
            }
        }
    }

    fn poll_at(&self) -> Option<Duration> {
        None
    }

    fn connected(&self) -> bool {
        self.down.is_none()
    }

    fn reconnect(&mut self, now: Duration) -> bool {
        self.down = self.down.filter(|until| *until > now);
        self.down.is_none()
    }
}

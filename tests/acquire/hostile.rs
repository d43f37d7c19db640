//! An instrument that does not do what it says, at the other end of a line on a simulated clock: the simulator
//! with somebody between it and the client.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use asperity::acquire::Peer;
use asperity_core::protocol::{
    CalibrationKind, Decoder, Event, Frame, Message, Request, Response, Segment, encode,
};
use asperity_firmware_sim::{Config, Instant, Simulator};

/// What becomes of a request on its way to the instrument.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Heard {
    Pass,
    /// It never arrives.
    Lost,
    /// Another one is carried out in its place; its answer goes to the client.
    Instead(Request),
    /// The instrument is not told, and the client gets this.
    Fake(Message),
    /// The line closes, for so long.
    Cut(Duration),
}

/// What becomes of a frame on its way to the client.
#[derive(Clone, Debug)]
pub(crate) enum Said {
    Pass,
    Lost,
    Twice,
    /// These in its place.
    Instead(Vec<Frame>),
    /// These bytes in its place.
    Bytes(Vec<u8>),
}

/// Of a request, by kind, and how many of that kind have come with this one.
pub(crate) type Hear = Box<dyn FnMut(&Frame, u32) -> Heard + Send>;
/// Of a frame of the instrument, and how many points have come with this one.
pub(crate) type Say = Box<dyn FnMut(&Frame, u32) -> Said + Send>;
/// Bytes that nobody asked for, of a session.
pub(crate) type Chatter = Box<dyn FnMut(u16) -> Vec<u8> + Send>;

/// Who stands between.
pub(crate) struct Behaviour {
    pub(crate) hear: Hear,
    pub(crate) say: Say,
    /// Time between two pieces of chatter, and what is said.
    pub(crate) chatter: Option<(Duration, Chatter)>,
    /// Time from byte to byte towards the client; 0 for as they come.
    pub(crate) slow: Duration,
}

impl Behaviour {
    /// Nobody.
    pub(crate) fn good() -> Self {
        Self {
            hear: Box::new(|_, _| Heard::Pass),
            say: Box::new(|_, _| Said::Pass),
            chatter: None,
            slow: Duration::ZERO,
        }
    }

    pub(crate) fn hears(hear: impl FnMut(&Frame, u32) -> Heard + Send + 'static) -> Self {
        Self { hear: Box::new(hear), ..Self::good() }
    }

    pub(crate) fn says(say: impl FnMut(&Frame, u32) -> Said + Send + 'static) -> Self {
        Self { say: Box::new(say), ..Self::good() }
    }

    pub(crate) fn chatters(
        self,
        every: Duration,
        chatter: impl FnMut(u16) -> Vec<u8> + Send + 'static,
    ) -> Self {
        Self { chatter: Some((every, Box::new(chatter))), ..self }
    }
}

/// A peer for the in-process transport.
pub(crate) struct Hostile {
    pub(crate) simulator: Simulator,
    behaviour: Behaviour,
    from_client: Decoder,
    from_instrument: Decoder,
    /// Requests of each kind, calibrations counted apart.
    pub(crate) heard: BTreeMap<String, u32>,
    points: u32,
    /// When a request came last, and the longest time without one since.
    asked: Option<Duration>,
    pub(crate) longest_silence: Duration,
    session: u16,
    next_chatter: Duration,
    /// On their way to the client, with the time when they are there.
    late: VecDeque<(Duration, u8)>,
    down: Option<Duration>,
}

impl Hostile {
    pub(crate) fn new(config: &Config, behaviour: Behaviour) -> Self {
        Self {
            simulator: Simulator::new(*config),
            behaviour,
            from_client: Decoder::new(),
            from_instrument: Decoder::new(),
            heard: BTreeMap::new(),
            points: 0,
            asked: None,
            longest_silence: Duration::ZERO,
            session: 0,
            next_chatter: Duration::ZERO,
            late: VecDeque::new(),
            down: None,
        }
    }

    /// From now on somebody stands between.
    pub(crate) fn behave(&mut self, behaviour: Behaviour) {
        self.behaviour = behaviour;
        (self.points, self.heard) = (0, BTreeMap::new());
        (self.asked, self.longest_silence) = (None, Duration::ZERO);
    }

    /// From now on it does what it says.
    pub(crate) fn mend(&mut self) {
        self.behave(Behaviour::good());
        self.late.clear();
        self.down = None;
    }

    fn take(&mut self, frame: Frame, request: &Request, now: Duration, out: &mut Vec<u8>) {
        self.session = frame.session;
        let silence = now.saturating_sub(self.asked.replace(now).unwrap_or(now));
        self.longest_silence = self.longest_silence.max(silence);
        let count = self.heard.entry(kind(request)).or_default();
        *count += 1;
        let told = match (self.behaviour.hear)(&frame, *count) {
            Heard::Pass => frame,
            Heard::Instead(request) => Frame { message: Message::Request(request), ..frame },
            Heard::Lost => return,
            Heard::Fake(message) => {
                return out.extend_from_slice(encode(&Frame { message, ..frame }).as_bytes());
            }
            Heard::Cut(time) => {
                self.down = Some(now + time);
                self.late.clear();
                return self.simulator.disconnected(instant(now));
            }
        };
        self.run(encode(&told).as_bytes(), now, out);
    }

    /// Lets the instrument work, and hands on what it says.
    fn run(&mut self, bytes: &[u8], now: Duration, out: &mut Vec<u8>) {
        let mut said = Vec::new();
        self.simulator.handle(bytes, instant(now), &mut |b: &[u8]| said.extend_from_slice(b));
        let mut said = &said[..];
        while let Some(result) = self.from_instrument.next(&mut said) {
            let Ok(frame) = result else { continue };
            self.points += u32::from(matches!(frame.message, Message::Event(Event::Point(_))));
            match (self.behaviour.say)(&frame, self.points) {
                Said::Pass => put(out, &frame),
                Said::Lost => {}
                Said::Twice => [frame; 2].iter().for_each(|frame| put(out, frame)),
                Said::Instead(frames) => frames.iter().for_each(|frame| put(out, frame)),
                Said::Bytes(bytes) => out.extend_from_slice(&bytes),
            }
        }
    }
}

impl Peer for Hostile {
    fn exchange(&mut self, mut bytes: &[u8], now: Duration, out: &mut Vec<u8>) {
        let mut said = Vec::new();
        self.run(&[], now, &mut said);
        while let Some(result) = self.from_client.next(&mut bytes) {
            if let Ok(frame) = result
                && let Message::Request(request) = frame.message
                && self.connected()
            {
                self.take(frame, &request, now, &mut said);
            }
        }
        if let Some((every, chatter)) = &mut self.behaviour.chatter
            && now >= self.next_chatter
        {
            said.extend(chatter(self.session));
            self.next_chatter = now + *every;
        }
        if self.behaviour.slow.is_zero() {
            return out.extend(said);
        }
        for byte in said {
            let last = self.late.back().map_or(now, |late| late.0).max(now);
            self.late.push_back((last + self.behaviour.slow, byte));
        }
        while let Some((_, byte)) = self.late.pop_front_if(|late| late.0 <= now) {
            out.push(byte);
        }
    }

    fn poll_at(&self) -> Option<Duration> {
        let simulator = self.simulator.poll_at().map(|at| Duration::from_micros(at.0));
        let chatter = self.behaviour.chatter.as_ref().map(|_| self.next_chatter);
        let late = self.late.front().map(|late| late.0);
        [simulator, chatter, late].into_iter().flatten().min()
    }

    fn connected(&self) -> bool {
        self.down.is_none()
    }

    fn reconnect(&mut self, now: Duration) -> bool {
        self.down = self.down.filter(|until| now < *until);
        self.connected()
    }
}

fn instant(now: Duration) -> Instant {
    Instant(now.as_micros() as u64)
}

fn put(out: &mut Vec<u8>, frame: &Frame) {
    out.extend_from_slice(encode(frame).as_bytes());
}

/// The kind of a request; calibration runs are told apart.
pub(crate) fn kind(request: &Request) -> String {
    match request {
        Request::Calibrate(CalibrationKind::Dark) => "Dark".to_owned(),
        Request::Calibrate(CalibrationKind::Reference) => "Reference".to_owned(),
        Request::Scan(Segment { .. }) => "Scan".to_owned(),
        other => {
            let debug = format!("{other:?}");
            debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
        }
    }
}

/// The same frame with another message.
pub(crate) fn with(frame: &Frame, message: Message) -> Said {
    Said::Instead(vec![Frame { message, ..*frame }])
}

/// The request of a frame.
pub(crate) fn request(frame: &Frame) -> Option<Request> {
    match frame.message {
        Message::Request(request) => Some(request),
        _ => None,
    }
}

/// `accepted`.
pub(crate) const ACCEPTED: Message = Message::Response(Response::Accepted);

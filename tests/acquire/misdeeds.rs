//! How an instrument can misbehave, one after another, and what has to come of it.

use std::time::Duration;

use asperity_core::protocol::{
    Axis, Calibration, DeviceError, Event, Fault, Frame, MachineState, Message, Microdegrees,
    Point, Range, Request, Response, Status,
};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

use crate::hostile::{ACCEPTED, Behaviour, Heard, Said, request, with};

/// What has to come of it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Expected {
    /// An error with these words.
    Ends(&'static [&'static str]),
    /// The scan of a good instrument, to the byte.
    Completes,
}

use Expected::{Completes, Ends};

/// A misbehaviour.
pub(crate) struct Misdeed {
    pub(crate) name: String,
    pub(crate) expected: Expected,
    pub(crate) behaviour: Behaviour,
    /// Light of its lamp: how much of it is lost in an hour.
    pub(crate) drift: f32,
    /// Whether the instrument can be told to stop: else it does so by itself, after 5 s of silence.
    pub(crate) reachable: bool,
    /// Whether the journal holds what was not so, and has to be refused afterwards.
    pub(crate) spoils: bool,
}

fn misdeed(name: &str, expected: Expected, behaviour: Behaviour) -> Misdeed {
    let name = name.to_owned();
    Misdeed { name, expected, behaviour, drift: 0.0, reachable: true, spoils: false }
}

/// From this point on something is wrong, where it is not wrong from the beginning.
const FROM: u32 = 20;

/// Changes what the status says, from some point on.
fn status(from: u32, change: impl Fn(&mut Status) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, points| match frame.message {
        Message::Response(Response::Status(mut status)) if points >= from => {
            change(&mut status);
            with(frame, Message::Response(Response::Status(status)))
        }
        _ => Said::Pass,
    })
}

/// Changes points, from [`FROM`] on.
fn point(change: impl Fn(&mut Point) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, points| match frame.message {
        Message::Event(Event::Point(mut point)) if points >= FROM => {
            change(&mut point);
            with(frame, Message::Event(Event::Point(point)))
        }
        _ => Said::Pass,
    })
}

fn calibration(change: impl Fn(&mut Calibration) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, _| match frame.message {
        Message::Response(Response::Calibration(mut values)) => {
            change(&mut values);
            with(frame, Message::Response(Response::Calibration(values)))
        }
        _ => Said::Pass,
    })
}

/// Another request is carried out in place of some.
fn instead(other: impl Fn(Request) -> Option<Request> + Send + 'static) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        request(frame).and_then(&other).map_or(Heard::Pass, Heard::Instead)
    })
}

/// Accepted, and not done.
fn feigned(which: fn(&Request) -> bool) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        if request(frame).is_some_and(|r| which(&r)) { Heard::Fake(ACCEPTED) } else { Heard::Pass }
    })
}

/// Refused with that error.
fn refused(which: fn(&Request) -> bool, error: DeviceError) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        let refuse = request(frame).is_some_and(|r| which(&r));
        if refuse { Heard::Fake(Message::Error(error)) } else { Heard::Pass }
    })
}

/// Answers with another frame, where it answers; `from` answers pass.
fn answers(from: u32, mut other: impl FnMut(&Frame) -> Frame + Send + 'static) -> Behaviour {
    let mut count = 0;
    Behaviour::says(move |frame, _| {
        if matches!(frame.message, Message::Event(_)) {
            return Said::Pass;
        }
        count += 1;
        if count > from { Said::Instead(vec![other(frame)]) } else { Said::Pass }
    })
}

/// All of them but the silences and the closed lines.
pub(crate) fn all() -> Vec<Misdeed> {
    let mut all = settings();
    all.extend(motions());
    all.extend(points());
    all.extend(calibrations());
    all.extend(talk());
    all.extend(states());
    all
}

fn settings() -> Vec<Misdeed> {
    vec![
        misdeed(
            "aperture accepted, not obeyed",
            Ends(&["the aperture was set to 2 deg, and the instrument reports 0.6 deg"]),
            feigned(|r| matches!(r, Request::Aperture(_))),
        ),
        misdeed(
            "another aperture",
            Ends(&["the aperture was set to 2 deg, and the instrument reports 1.5 deg"]),
            instead(|r| match r {
                Request::Aperture(_) => Some(Request::Aperture(Microdegrees(1_500_000))),
                _ => None,
            }),
        ),
        misdeed(
            "integration accepted, not obeyed",
            Ends(&["the integration time was set to 5 ms, and the instrument reports 10 ms"]),
            feigned(|r| matches!(r, Request::Integration(_))),
        ),
        misdeed(
            "lamp accepted, not obeyed",
            Ends(&["the lamp was set to on, and the instrument reports off"]),
            instead(|r| match r {
                Request::Lamp(true) => Some(Request::Lamp(false)),
                _ => None,
            }),
        ),
        misdeed(
            "range accepted, not obeyed",
            Ends(&["the range was set to 0, and the instrument reports auto"]),
            feigned(|r| matches!(r, Request::Range(_))),
        ),
        misdeed(
            "aperture changes by itself",
            Ends(&["the aperture was set to 2 deg, and the instrument reports 0.1 deg"]),
            status(FROM, |status| status.aperture = Microdegrees(100_000)),
        ),
        misdeed(
            "integration changes by itself",
            Ends(&["the integration time was set to 5 ms, and the instrument reports 5.001 ms"]),
            status(FROM, |status| status.integration_us += 1),
        ),
        misdeed(
            "lamp goes off without a fault",
            Ends(&["the lamp was set to on"]),
            status(FROM, |status| status.lamp = false),
        ),
        misdeed(
            "range changes by itself",
            Ends(&["the range was set to 0, and the instrument reports 3"]),
            status(FROM, |status| status.range = Range::Fixed(3)),
        ),
        misdeed(
            "sample turns by itself",
            Ends(&["the angle of incidence was set to 0 deg, and the instrument reports 1 deg"]),
            status(FROM, |status| status.sigma.0 += 1_000_000),
        ),
        misdeed(
            "calibration is another one",
            Ends(&["its calibration is gone or another one", "--recalibrate"]),
            status(FROM, |status| status.calibration = status.calibration.map(|id| id ^ 1)),
        ),
        misdeed(
            "calibration is gone",
            Ends(&["its calibration is gone or another one"]),
            status(FROM, |status| status.calibration = None),
        ),
    ]
}

fn motions() -> Vec<Misdeed> {
    vec![
        misdeed(
            "homing feigned",
            Ends(&["it has homed, and is not homed"]),
            feigned(|r| *r == Request::Home),
        ),
        misdeed(
            "sample is not turned",
            Ends(&["the sigma axis was sent to 30 degrees and stands at 0"]),
            feigned(|r| matches!(r, Request::Move(Axis::Sigma, _))),
        ),
        misdeed(
            "detector goes elsewhere",
            Ends(&["the theta axis was sent to -20.5 degrees and stands at 7"]),
            instead(|r| match r {
                Request::Move(Axis::Theta, _) => {
                    Some(Request::Move(Axis::Theta, Microdegrees(7_000_000)))
                }
                _ => None,
            }),
        ),
        misdeed(
            "scan feigned",
            Ends(&["stopped 5 times before the scan of a segment was over"]),
            feigned(|r| matches!(r, Request::Scan(_))),
        ),
        misdeed(
            "asked for more, feigned",
            Ends(&["the next point of the scan is not over"]),
            feigned(|r| matches!(r, Request::Continue { .. })),
        ),
        misdeed("stop feigned", Completes, feigned(|r| *r == Request::Stop)),
        misdeed(
            "another segment is scanned",
            Ends(&["it was read at"]),
            instead(|r| match r {
                Request::Scan(mut segment) => {
                    segment.start.0 += 1_000_000;
                    Some(Request::Scan(segment))
                }
                _ => None,
            }),
        ),
    ]
}

fn points() -> Vec<Misdeed> {
    let (mut kept, mut held) = (None, None);
    let stale = Behaviour::says(move |frame, points| {
        let Message::Event(Event::Point(_)) = frame.message else { return Said::Pass };
        if points <= FROM {
            kept = Some(*frame);
            return Said::Pass;
        }
        Said::Instead(kept.into_iter().collect())
    });
    let swapped = Behaviour::says(move |frame, _| {
        let Message::Event(Event::Point(_)) = frame.message else { return Said::Pass };
        match held.take() {
            None => {
                held = Some(*frame);
                Said::Lost
            }
            Some(earlier) => Said::Instead(vec![*frame, earlier]),
        }
    });
    let lost = |every: u32| {
        Behaviour::says(move |frame, points| match frame.message {
            Message::Event(Event::Point(_)) if points.is_multiple_of(every) => Said::Lost,
            _ => Said::Pass,
        })
    };
    let twice = Behaviour::says(|frame, _| match frame.message {
        Message::Event(_) => Said::Twice,
        _ => Said::Pass,
    });
    let overdue = Ends(&["the next point of the scan is not over after 1"]);
    vec![
        misdeed("stale points for ever", overdue, stale),
        misdeed(
            "a trickle of stale points",
            overdue,
            lost(1).chatters(Duration::from_millis(150), frame_of_old_point),
        ),
        misdeed("points doubled", Completes, twice),
        misdeed("every third point lost", Completes, lost(3)),
        misdeed("all points lost", overdue, lost(1)),
        misdeed("points in pairs, the later first", Completes, swapped),
        misdeed("points counted backwards", overdue, point(|p| p.index = 40 - p.index)),
        misdeed("points of another segment", overdue, point(|p| p.segment ^= 1)),
        misdeed(
            "points of another session",
            overdue,
            Behaviour::says(|frame, points| match frame.message {
                Message::Event(Event::Point(_)) if points >= FROM => {
                    Said::Instead(vec![Frame { session: frame.session ^ 1, ..*frame }])
                }
                _ => Said::Pass,
            }),
        ),
        misdeed(
            "theta off by a step",
            Ends(&["it was read at"]),
            point(|p| p.theta.0 += 2_000_000),
        ),
        misdeed("theta off by 0.03 deg", Ends(&["it was read at"]), point(|p| p.theta.0 -= 30_000)),
        misdeed("signal NaN", Ends(&["signal NaN"]), point(|p| p.reading.signal = f32::NAN)),
        misdeed("signal inf", Ends(&["signal inf"]), point(|p| p.reading.signal = f32::INFINITY)),
        misdeed("dark NaN", Ends(&["dark NaN"]), point(|p| p.reading.dark = f32::NAN)),
        misdeed(
            "signal 3e38",
            Ends(&["3.40282e38 nA in range 0, which holds 1000 nA"]),
            point(|p| p.reading.signal = f32::MAX),
        ),
        misdeed("range 6", Ends(&["it was read in range 6"]), point(|p| p.reading.range = 6)),
        misdeed("another range", Ends(&["it was read in range 2"]), point(|p| p.reading.range = 2)),
        misdeed("over range", Ends(&["more light than range 0"]), point(|p| p.reading.over = true)),
        misdeed(
            "dark current of another calibration",
            Ends(&["a dark current of 0.5 nA in range 0, and its calibration says"]),
            point(|p| p.reading.dark = 0.5),
        ),
    ]
}

/// The first point of the first segment, as it has come before.
fn frame_of_old_point(session: u16) -> Vec<u8> {
    let reading = asperity_core::protocol::Reading {
        signal: 0.1,
        dark: 0.0,
        range: 0,
        over: false,
        under: false,
    };
    let theta = Microdegrees(-20_000_000);
    let old = Point { segment: 0, index: 0, theta, reading };
    let message = Message::Event(Event::Point(old));
    asperity_core::protocol::encode(&Frame { session, sequence: 0, message }).as_bytes().to_vec()
}

fn calibrations() -> Vec<Misdeed> {
    let weak = Ends(&["above the dark current", "are needed", "lamp"]);
    vec![
        misdeed(
            "reference hardly above dark",
            weak,
            calibration(|c| c.reference = c.dark[0] + 2e-4),
        ),
        misdeed("reference below dark", weak, calibration(|c| c.reference = c.dark[0] - 1.0)),
        misdeed("reference of a tenth percent", weak, calibration(|c| c.reference = 0.8)),
        misdeed("dark as bright as the beam", weak, calibration(|c| c.dark = [790.0; 6])),
        Misdeed { drift: -1e9, ..misdeed("lamp on, and burnt out", weak, Behaviour::good()) },
        Misdeed {
            drift: 1e6,
            ..misdeed("beam beyond the coarsest range", Ends(&["it is cut off"]), Behaviour::good())
        },
        misdeed("reference NaN", Ends(&["NaN nA"]), calibration(|c| c.reference = f32::NAN)),
        misdeed("dark inf", Ends(&["inf"]), calibration(|c| c.dark[5] = f32::INFINITY)),
        misdeed("calibration in range 9", Ends(&["range 9"]), calibration(|c| c.range = 9)),
        misdeed(
            "calibration of another name",
            Ends(&["it has made calibration", "its status says"]),
            calibration(|c| c.id ^= 1),
        ),
        misdeed(
            "calibration feigned",
            Ends(&["the calibration's values", "no such reading"]),
            feigned(|r| matches!(r, Request::Calibrate(_))),
        ),
        Misdeed {
            spoils: true,
            ..misdeed(
                "reference too low, readings above the beam",
                Ends(&["times the beam without the sample"]),
                Behaviour::says(|frame, points| match frame.message {
                    Message::Response(Response::Calibration(mut values)) => {
                        values.reference = 20.0;
                        with(frame, Message::Response(Response::Calibration(values)))
                    }
                    Message::Event(Event::Point(mut point)) if points >= FROM => {
                        point.reading.signal = 60.0;
                        with(frame, Message::Event(Event::Point(point)))
                    }
                    _ => Said::Pass,
                }),
            )
        },
    ]
}

fn talk() -> Vec<Misdeed> {
    let mut noise = Pcg64Mcg::new(34);
    let flood = move |_| (0..2000).map(|_| noise.next_u32() as u8).collect::<Vec<u8>>();
    let dead = |from: u32| {
        Behaviour::says(move |_, points| if points >= from { Said::Lost } else { Said::Pass })
    };
    let busy = |frame: &Frame, kind| Frame { message: Message::Error(kind), ..*frame };
    let wrong = |which: fn(&Response) -> bool, other: Message| {
        Behaviour::says(move |frame, _| match &frame.message {
            Message::Response(response) if which(response) => with(frame, other),
            _ => Said::Pass,
        })
    };
    vec![
        misdeed(
            "another version",
            Ends(&["protocol version 7, this program version 1"]),
            Behaviour::says(|frame, _| match frame.message {
                Message::Response(Response::Ident(mut ident)) => {
                    ident.protocol = 7;
                    with(frame, Message::Response(Response::Ident(ident)))
                }
                _ => Said::Pass,
            }),
        ),
        misdeed(
            "axis without speed",
            Ends(&["its theta axis goes from"]),
            Behaviour::says(|frame, _| match frame.message {
                Message::Response(Response::Ident(mut ident)) => {
                    ident.theta.speed = 0;
                    with(frame, Message::Response(Response::Ident(ident)))
                }
                _ => Said::Pass,
            }),
        ),
        misdeed(
            "wrong kind of answer to Identify",
            Ends(&["asked for its name, it answers with `accepted`"]),
            wrong(|r| matches!(r, Response::Ident(_)), ACCEPTED),
        ),
        misdeed(
            "wrong kind of answer to Status",
            Ends(&["asked for its status, it answers with `accepted`"]),
            wrong(|r| matches!(r, Response::Status(_)), ACCEPTED),
        ),
        misdeed(
            "wrong kind of answer to LastCalibration",
            Ends(&["asked for the calibration's values, it answers with its counters"]),
            wrong(
                |r| matches!(r, Response::Calibration(_)),
                Message::Response(Response::Diagnostics(
                    asperity_core::protocol::Diagnostics::default(),
                )),
            ),
        ),
        misdeed(
            "answers numbered wrongly",
            Ends(&["not to what it is asked"]),
            answers(0, |frame| Frame { sequence: frame.sequence.wrapping_add(1), ..*frame }),
        ),
        Misdeed {
            reachable: false,
            ..misdeed(
                "answers numbered wrongly later on",
                Ends(&["not to what it is asked"]),
                answers(12, |frame| Frame { sequence: frame.sequence.wrapping_add(9), ..*frame }),
            )
        },
        misdeed(
            "answers to another session",
            Ends(&["not to what it is asked"]),
            answers(0, |frame| Frame { session: frame.session ^ 2, ..*frame }),
        ),
        misdeed(
            "garbage at full speed in place of answers",
            Ends(&["no instrument of this kind"]),
            dead(0).chatters(Duration::ZERO, flood),
        ),
        misdeed("falls silent in the middle", Ends(&["not back within 30 s"]), dead(FROM)),
        misdeed(
            "an endless frame",
            Ends(&["no instrument of this kind"]),
            dead(0).chatters(Duration::from_millis(1), |_| vec![0xab; 10]),
        ),
        misdeed(
            "an endless frame between good ones",
            Completes,
            Behaviour::good().chatters(Duration::from_millis(20), |_| vec![0xab; 10]),
        ),
        misdeed(
            "frames of 300 bytes between good ones",
            Completes,
            Behaviour::says(|frame, _| {
                let good = asperity_core::protocol::encode(frame);
                Said::Bytes([&[0][..], &[9; 300], good.as_bytes()].concat())
            }),
        ),
        misdeed(
            "a byte every 3 ms",
            Completes,
            Behaviour { slow: Duration::from_millis(3), ..Behaviour::good() },
        ),
        misdeed(
            "a byte every 400 ms",
            Ends(&["no instrument of this kind answers: 12 bytes came", "--baud"]),
            Behaviour { slow: Duration::from_millis(400), ..Behaviour::good() },
        ),
        misdeed(
            "chatter of states, without points",
            Ends(&["the next point of the scan is not over"]),
            Behaviour::says(|frame, _| match frame.message {
                Message::Event(Event::Point(_)) => {
                    with(frame, Message::Event(Event::State(MachineState::Measuring)))
                }
                _ => Said::Pass,
            })
            .chatters(Duration::from_millis(30), |session| {
                let message = Message::Event(Event::State(MachineState::Measuring));
                let frame = Frame { session, sequence: 0, message };
                asperity_core::protocol::encode(&frame).as_bytes().to_vec()
            }),
        ),
        misdeed(
            "cries fault, and has none",
            Completes,
            Behaviour::good().chatters(Duration::from_millis(40), |session| {
                let message = Message::Event(Event::Fault(Fault::OverRange));
                let frame = Frame { session, sequence: 0, message };
                asperity_core::protocol::encode(&frame).as_bytes().to_vec()
            }),
        ),
        misdeed("all it says twice", Completes, Behaviour::says(|_, _| Said::Twice)),
        misdeed(
            "busy with everything",
            Ends(&["refuses its status: it is busy (moving)"]),
            answers(2, move |frame| busy(frame, DeviceError::Busy(MachineState::Moving))),
        ),
        misdeed(
            "never ours",
            Ends(&["another client is using the instrument"]),
            refused(|r| *r == Request::Claim, DeviceError::InUse),
        ),
        misdeed(
            "settings are not for us",
            Ends(&["the integration time failed 3 times"]),
            refused(|r| matches!(r, Request::Integration(_)), DeviceError::NotOwner),
        ),
        misdeed(
            "forgets its segment again and again",
            Ends(&["stopped 5 times before the scan of a segment was over"]),
            Behaviour::hears(|frame, count| match request(frame) {
                Some(Request::Continue { .. }) if count > 1 => {
                    Heard::Fake(Message::Error(DeviceError::NoSegment))
                }
                Some(Request::Scan(_)) if count > 1 => Heard::Fake(ACCEPTED),
                _ => Heard::Pass,
            }),
        ),
        misdeed(
            "refuses to go on",
            Ends(&["refuses more points of a segment"]),
            refused(|r| matches!(r, Request::Continue { .. }), DeviceError::BadValue),
        ),
    ]
}

fn states() -> Vec<Misdeed> {
    vec![
        misdeed(
            "always moving",
            Ends(&["is not over after 15 s"]),
            status(0, |status| status.state = MachineState::Moving),
        ),
        misdeed(
            "measures for ever",
            Ends(&["the scan of a segment is not over", "the next point of the scan is not over"]),
            status(41, |status| status.state = MachineState::Measuring),
        ),
        misdeed(
            "a fault that is none",
            Ends(&["in a fault, and in none"]),
            status(FROM, |status| status.state = MachineState::Fault),
        ),
        misdeed(
            "stopped by a fault",
            Ends(&["the lamp went out"]),
            status(FROM, |status| {
                (status.state, status.fault) = (MachineState::Fault, Some(Fault::LampFailed));
            }),
        ),
        misdeed(
            "stops without a word",
            Ends(&["refuses a movement: it is busy (measuring)"]),
            Behaviour::says(|frame, points| match frame.message {
                Message::Response(Response::Status(mut status)) if points >= FROM => {
                    (status.state, status.segment) = (MachineState::Idle, None);
                    with(frame, Message::Response(Response::Status(status)))
                }
                Message::Event(Event::Point(_)) if points >= FROM => Said::Lost,
                _ => Said::Pass,
            }),
        ),
        misdeed(
            "belongs to nobody",
            Ends(&["keeping the instrument failed 3 times"]),
            status(0, |status| status.owner = None),
        ),
        misdeed(
            "has measured what never comes",
            Ends(&["the next point of the scan is not over"]),
            Behaviour::says(|frame, points| match frame.message {
                Message::Response(Response::Status(mut status)) if points >= FROM => {
                    status.segment = status.segment.map(|(name, _)| (name, u16::MAX));
                    with(frame, Message::Response(Response::Status(status)))
                }
                Message::Event(Event::Point(_)) if points >= FROM => Said::Lost,
                _ => Said::Pass,
            }),
        ),
    ]
}

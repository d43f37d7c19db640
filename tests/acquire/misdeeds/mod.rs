//! How an instrument can misbehave, one after another, and what has to come of it.

mod points;
mod talk;

use asperity_core::protocol::{
    Axis, Calibration, DeviceError, Event, Fault, Frame, MachineState, Message, Microdegrees,
    Point, Range, Request, Response, Status,
};

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

pub(super) fn misdeed(name: &str, expected: Expected, behaviour: Behaviour) -> Misdeed {
    let name = name.to_owned();
    Misdeed { name, expected, behaviour, drift: 0.0, reachable: true, spoils: false }
}

/// From this point on something is wrong, where it is not wrong from the beginning.
pub(super) const FROM: u32 = 20;

/// Changes what the status says, from some point on.
pub(super) fn status(from: u32, change: impl Fn(&mut Status) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, points| match frame.message {
        Message::Response(Response::Status(mut status)) if points >= from => {
            change(&mut status);
            with(frame, Message::Response(Response::Status(status)))
        }
        _ => Said::Pass,
    })
}

/// Changes points, from [`FROM`] on.
pub(super) fn point(change: impl Fn(&mut Point) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, points| match frame.message {
        Message::Event(Event::Point(mut point)) if points >= FROM => {
            change(&mut point);
            with(frame, Message::Event(Event::Point(point)))
        }
        _ => Said::Pass,
    })
}

pub(super) fn calibration(change: impl Fn(&mut Calibration) + Send + 'static) -> Behaviour {
    Behaviour::says(move |frame, _| match frame.message {
        Message::Response(Response::Calibration(mut values)) => {
            change(&mut values);
            with(frame, Message::Response(Response::Calibration(values)))
        }
        _ => Said::Pass,
    })
}

/// Another request is carried out in place of some.
pub(super) fn instead(other: impl Fn(Request) -> Option<Request> + Send + 'static) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        request(frame).and_then(&other).map_or(Heard::Pass, Heard::Instead)
    })
}

/// Accepted, and not done.
pub(super) fn feigned(which: fn(&Request) -> bool) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        if request(frame).is_some_and(|r| which(&r)) { Heard::Fake(ACCEPTED) } else { Heard::Pass }
    })
}

/// Refused with that error.
pub(super) fn refused(which: fn(&Request) -> bool, error: DeviceError) -> Behaviour {
    Behaviour::hears(move |frame, _| {
        let refuse = request(frame).is_some_and(|r| which(&r));
        if refuse { Heard::Fake(Message::Error(error)) } else { Heard::Pass }
    })
}

/// Answers with another frame, where it answers; `from` answers pass.
pub(super) fn answers(
    from: u32,
    mut other: impl FnMut(&Frame) -> Frame + Send + 'static,
) -> Behaviour {
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
    all.extend(points::all());
    all.extend(talk::all());
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

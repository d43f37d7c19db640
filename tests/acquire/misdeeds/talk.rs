//! Answers of the wrong kind, under wrong numbers; noise, chatter, slowness; refusals.

use std::time::Duration;

use asperity_core::protocol::{
    DeviceError, Diagnostics, Event, Fault, Frame, MachineState, Message, Request, Response, encode,
};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

use super::Expected::{Completes, Ends};
use super::{FROM, Misdeed, answers, misdeed, refused};
use crate::hostile::{ACCEPTED, Behaviour, Heard, Said, request, with};

pub(super) fn all() -> Vec<Misdeed> {
    let mut all = strangers();
    all.extend(noise());
    all.extend(refusals());
    all
}

/// Answers that are none.
fn strangers() -> Vec<Misdeed> {
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
                Message::Response(Response::Diagnostics(Diagnostics::default())),
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
    ]
}

/// An event that nobody asked for.
fn unasked(session: u16, event: Event) -> Vec<u8> {
    encode(&Frame { session, sequence: 0, message: Message::Event(event) }).as_bytes().to_vec()
}

/// What is no frame, or no news, or late.
fn noise() -> Vec<Misdeed> {
    let mut noise = Pcg64Mcg::new(34);
    let flood = move |_| (0..2000).map(|_| noise.next_u32() as u8).collect::<Vec<u8>>();
    let dead = |from: u32| {
        Behaviour::says(move |_, points| if points >= from { Said::Lost } else { Said::Pass })
    };
    vec![
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
                let good = encode(frame);
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
                unasked(session, Event::State(MachineState::Measuring))
            }),
        ),
        misdeed(
            "cries fault, and has none",
            Completes,
            Behaviour::good().chatters(Duration::from_millis(40), |session| {
                unasked(session, Event::Fault(Fault::OverRange))
            }),
        ),
        misdeed("all it says twice", Completes, Behaviour::says(|_, _| Said::Twice)),
    ]
}

/// No, again and again.
fn refusals() -> Vec<Misdeed> {
    let busy = |frame: &Frame, kind| Frame { message: Message::Error(kind), ..*frame };
    vec![
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

//! Points and calibrations that are not what they should be.

use std::time::Duration;

use asperity_core::protocol::{
    Event, Frame, Message, Microdegrees, Point, Reading, Request, Response, encode,
};

use super::Expected::{Completes, Ends};
use super::{FROM, Misdeed, calibration, feigned, misdeed, point};
use crate::hostile::{Behaviour, Said, with};

pub(super) fn all() -> Vec<Misdeed> {
    let mut all = places();
    all.extend(currents());
    all.extend(calibrations());
    all
}

/// Which points come, and from where.
fn places() -> Vec<Misdeed> {
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
        misdeed(
            "points counted backwards",
            Ends(&["it was read at"]),
            point(|p| p.index = 40 - p.index),
        ),
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
    ]
}

/// What points say.
fn currents() -> Vec<Misdeed> {
    vec![
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
    let reading = Reading { signal: 0.1, dark: 0.0, range: 0, over: false, under: false };
    let theta = Microdegrees(-20_000_000);
    let old = Point { segment: 0, index: 0, theta, reading };
    let message = Message::Event(Event::Point(old));
    encode(&Frame { session, sequence: 0, message }).as_bytes().to_vec()
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

//! The wire format against PROTOCOL.md: its tables of numbers and its golden vectors.

use std::collections::BTreeMap;

use asperity_core::protocol::{
    Axis, AxisLimits, Calibration, CalibrationKind, Decoder, DeviceError, Diagnostics, Event,
    Fault, Frame, FrameError, Ident, MachineState, Message, Microdegrees, Point, Range, Reading,
    Request, Response, Segment, Status, Text16, checksum, encode,
};

const PAGE: &str = include_str!("../../PROTOCOL.md");

/// The rows of the table whose header begins with `columns`, as cells.
fn table(columns: &[&str]) -> Vec<Vec<&'static str>> {
    let cells = |line: &'static str| -> Vec<&'static str> {
        line.trim().trim_matches('|').split('|').map(|cell| cell.trim().trim_matches('`')).collect()
    };
    let mut lines = PAGE.lines().skip_while(|line| !cells(line).starts_with(columns));
    assert!(lines.next().is_some(), "no table {columns:?} in PROTOCOL.md");
    lines.skip(1).take_while(|line| line.starts_with('|')).map(cells).collect()
}

const SEGMENT: Segment = Segment {
    segment: 70_000,
    start: Microdegrees(-90_000_000),
    step: Microdegrees(100_000),
    count: 1801,
    first: 0,
    credit: 16,
};

const READING: Reading =
    Reading { signal: 0.12345, dark: 0.02, range: 3, over: false, under: true };

const CALIBRATION: Calibration = Calibration {
    id: 0xdead_beef,
    dark: [0.02, 0.021, 0.022, 0.023, 0.024, 0.025],
    reference: 800.25,
    range: 0,
};

const POINT: Point = Point {
    segment: 70_000,
    index: 1800,
    theta: Microdegrees(90_000_000),
    reading: Reading { signal: -0.5, dark: 0.0, range: 5, over: false, under: false },
};

fn ident() -> Ident {
    let limits = |least, most, speed| AxisLimits {
        least: Microdegrees(least),
        most: Microdegrees(most),
        speed,
    };
    Ident {
        protocol: 1,
        model: Text16::new("GP-200 simulator"),
        serial: 4711,
        firmware: [1, 2, 3],
        sigma: limits(0, 85_000_000, 10_000_000),
        theta: limits(-95_000_000, 95_000_000, 20_000_000),
        max_points: 1801,
    }
}

fn status() -> Status {
    Status {
        state: MachineState::Measuring,
        fault: None,
        homed: true,
        lamp: true,
        sigma: Microdegrees(15_000_000),
        theta: Microdegrees(-89_900_000),
        aperture: Microdegrees(600_000),
        range: Range::Auto,
        integration_us: 20_000,
        segment: Some((70_000, 1)),
        calibration: Some(0xdead_beef),
        owner: Some(0x1234),
    }
}

fn faulted() -> Status {
    Status {
        state: MachineState::Fault,
        fault: Some(Fault::AxisStalled(Axis::Theta)),
        homed: false,
        lamp: false,
        sigma: Microdegrees(0),
        theta: Microdegrees(0),
        range: Range::Fixed(2),
        segment: None,
        calibration: None,
        owner: None,
        ..status()
    }
}

fn diagnostics() -> Diagnostics {
    Diagnostics { frames: 1_000_000, bad_frames: 3, stack_bytes: 2048, uptime_ms: 123_456_789 }
}

/// What the names of the golden vectors stand for.
fn golden() -> BTreeMap<&'static str, Message> {
    use Message::{Error, Event as Say, Request as Ask, Response as Answer};
    BTreeMap::from([
        ("identify", Ask(Request::Identify)),
        ("claim", Ask(Request::Claim)),
        ("status", Ask(Request::Status)),
        ("move-theta", Ask(Request::Move(Axis::Theta, Microdegrees(-90_500_000)))),
        ("aperture", Ask(Request::Aperture(Microdegrees(600_000)))),
        ("range-auto", Ask(Request::Range(Range::Auto))),
        ("range-5", Ask(Request::Range(Range::Fixed(5)))),
        ("integration", Ask(Request::Integration(20_000))),
        ("lamp-on", Ask(Request::Lamp(true))),
        ("calibrate-reference", Ask(Request::Calibrate(CalibrationKind::Reference))),
        ("scan", Ask(Request::Scan(SEGMENT))),
        ("continue", Ask(Request::Continue { segment: 70_000, next: 16, credit: 16 })),
        ("emergency-stop", Ask(Request::EmergencyStop)),
        ("ident", Answer(Response::Ident(ident()))),
        ("accepted", Answer(Response::Accepted)),
        ("status-measuring", Answer(Response::Status(status()))),
        ("status-fault", Answer(Response::Status(faulted()))),
        ("diagnostics", Answer(Response::Diagnostics(diagnostics()))),
        ("reading", Answer(Response::Reading(READING))),
        ("calibration", Answer(Response::Calibration(CALIBRATION))),
        ("error-busy", Error(DeviceError::Busy(MachineState::Measuring))),
        ("error-faulted", Error(DeviceError::Faulted(Fault::AxisStalled(Axis::Theta)))),
        ("error-soft-limit", Error(DeviceError::SoftLimit(Axis::Theta))),
        ("error-needs-dark", Error(DeviceError::NeedsCalibration(CalibrationKind::Dark))),
        ("point", Say(Event::Point(POINT))),
        ("event-idle", Say(Event::State(MachineState::Idle))),
        ("event-fault", Say(Event::Fault(Fault::LampFailed))),
    ])
}

fn hex(text: &str) -> Vec<u8> {
    text.split(' ').map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

#[test]
fn golden_vectors_in_both_directions() {
    let mut messages = golden();
    for row in table(&["name", "session", "sequence", "bytes"]) {
        let [name, session, sequence, bytes] = row[..] else { panic!("{row:?}") };
        let bytes = hex(bytes);
        let (mut decoder, mut rest) = (Decoder::new(), &bytes[..]);
        let decoded = decoder.next(&mut rest);
        assert!(rest.is_empty(), "{name}");
        if name == "other-version" {
            assert_eq!(decoded, Some(Err(FrameError::Version(2))));
            continue;
        }
        let message = messages.remove(name).unwrap_or_else(|| panic!("no message named {name}"));
        let frame = Frame {
            session: session.parse().unwrap(),
            sequence: sequence.parse().unwrap(),
            message,
        };
        assert_eq!(decoded, Some(Ok(frame)), "{name}");
        assert_eq!(encode(&frame).as_bytes(), bytes, "{name}");
    }
    assert!(messages.is_empty(), "not in PROTOCOL.md: {:?}", messages.keys());
}

/// Unstuffs and cuts off the checksum, by the book and slowly.
fn payload(encoded: &[u8]) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), &encoded[1..encoded.len() - 1]);
    while let [code, block @ ..] = rest {
        let (block, more) = block.split_at(usize::from(*code) - 1);
        out.extend_from_slice(block);
        if !more.is_empty() {
            out.push(0);
        }
        rest = more;
    }
    let sum = out.split_off(out.len() - 4);
    assert_eq!(sum, checksum(&out).to_le_bytes());
    out
}

/// The table's numbers are those on the wire, in the table's order, with none left out.
fn numbers(what: &str, messages: &[Message]) {
    let rows = table(&["number", what]);
    assert_eq!(rows.len(), messages.len(), "{what}");
    for (row, &message) in rows.iter().zip(messages) {
        let wire = payload(encode(&Frame { session: 1, sequence: 1, message }).as_bytes());
        assert_eq!(wire[3].to_string(), row[0], "{what} {}", row[1]);
        let debug = format!("{message:?}");
        let inner = debug.split_once('(').unwrap().1;
        let name: String = inner.chars().take_while(char::is_ascii_alphanumeric).collect();
        assert_eq!(name, row[1], "{what}");
    }
}

#[test]
fn the_tables_number_every_message_as_the_wire_does() {
    let requests = [
        Request::Identify,
        Request::Claim,
        Request::Release,
        Request::Status,
        Request::Diagnostics,
        Request::Home,
        Request::Move(Axis::Sigma, Microdegrees(1)),
        Request::Aperture(Microdegrees(1)),
        Request::Range(Range::Auto),
        Request::Integration(1),
        Request::Lamp(true),
        Request::Read,
        Request::LastReading,
        Request::Calibrate(CalibrationKind::Dark),
        Request::LastCalibration,
        Request::Scan(SEGMENT),
        Request::Continue { segment: 1, next: 1, credit: 1 },
        Request::Stop,
        Request::EmergencyStop,
        Request::ClearFault,
    ];
    numbers("request", &requests.map(Message::Request));
    let responses = [
        Response::Ident(ident()),
        Response::Accepted,
        Response::Status(status()),
        Response::Diagnostics(diagnostics()),
        Response::Reading(READING),
        Response::Calibration(CALIBRATION),
    ];
    numbers("response", &responses.map(Message::Response));
    let errors = [
        DeviceError::Busy(MachineState::Idle),
        DeviceError::Faulted(Fault::OverRange),
        DeviceError::NotHomed,
        DeviceError::InUse,
        DeviceError::NotOwner,
        DeviceError::SoftLimit(Axis::Sigma),
        DeviceError::BadValue,
        DeviceError::LampOff,
        DeviceError::Nothing,
        DeviceError::NoSegment,
        DeviceError::NeedsCalibration(CalibrationKind::Dark),
    ];
    numbers("error", &errors.map(Message::Error));
    let events =
        [Event::Point(POINT), Event::State(MachineState::Idle), Event::Fault(Fault::OverRange)];
    numbers("event", &events.map(Message::Event));
}

#[test]
fn the_checksum_is_the_published_one() {
    // the check value of CRC-32/ISCSI
    assert_eq!(checksum(b"123456789"), 0xe306_9283);
}

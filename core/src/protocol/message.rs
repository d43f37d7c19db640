//! What is said on the line. The order of the variants is their number on the wire: append only.

use serde::{Deserialize, Serialize};

use super::reading::{Calibration, CalibrationKind, Point, Range, Reading, Segment};
use super::state::{Axis, DeviceError, Diagnostics, Fault, Ident, MachineState, Status};
use super::units::Microdegrees;

/// A message, whose it is, and its number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The client's session, drawn at random, not 0; answers and events carry that of the request.
    pub session: u16,
    /// A client counts its requests up, with wrap-around; an answer repeats the request's number. A
    /// request sent again keeps its number, is carried out once, and gets the same answer again.
    /// Events count on their own.
    pub sequence: u16,
    /// What is said.
    pub message: Message,
}

/// Everything that can be said, by either end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// Client to instrument.
    Request(Request),
    /// Instrument to client: carried out, or begun.
    Response(Response),
    /// Instrument to client: not carried out.
    Error(DeviceError),
    /// Instrument to client, unasked.
    Event(Event),
}

/// What a client wants. Everything but `Identify`, `Status`, `Diagnostics`, `Claim` and
/// `EmergencyStop` is for the owner alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? `Response::Ident`, in every version of the protocol.
    Identify,
    /// Makes this session the owner, unless another one owns the instrument and has been heard of lately.
    Claim,
    /// The instrument stops, belongs to nobody, and listens to text again.
    Release,
    /// `Response::Status`, in every state.
    Status,
    /// `Response::Diagnostics`, in every state.
    Diagnostics,
    /// Finds the zero of both axes. Accepted when begun; over when idle and homed.
    Home,
    /// Sends an axis to a position. Accepted when begun; over when idle.
    Move(Axis, Microdegrees),
    /// FULL angle of the detector's cone, > 0, at most 10 degrees. Drops the reference.
    Aperture(Microdegrees),
    /// The detector's range.
    Range(Range),
    /// Integration time, 100 microseconds to 10 s. Drops the calibration.
    Integration(u32),
    /// The lamp on or off. Off drops the reference.
    Lamp(bool),
    /// Reads the detector where it is. Accepted when begun; over when idle; see `LastReading`.
    Read,
    /// `Response::Reading` of the last `Read`.
    LastReading,
    /// One calibration run. Accepted when begun; over when idle.
    Calibrate(CalibrationKind),
    /// `Response::Calibration`, after both runs.
    LastCalibration,
    /// Scans a segment; the points come as events. Idle when all are measured.
    Scan(Segment),
    /// The client has points of the segment up to `next` (not included): sends on from there, `credit`
    /// points at most, measures them first where needed. Also how lost points are asked for again.
    Continue {
        /// Name of the segment.
        segment: u32,
        /// First point the client does not have.
        next: u16,
        /// How many points may be sent before the client asks for more, >= 1.
        credit: u16,
    },
    /// Stops whatever is going on, in good order; idle afterwards.
    Stop,
    /// Cuts the motors at once: fault `EmergencyStop`. From any session.
    EmergencyStop,
    /// Leaves the fault; idle afterwards.
    ClearFault,
}

/// What an instrument answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Response {
    /// To `Identify`.
    Ident(Ident),
    /// Carried out, or begun.
    Accepted,
    /// To `Status`.
    Status(Status),
    /// To `Diagnostics`.
    Diagnostics(Diagnostics),
    /// To `LastReading`.
    Reading(Reading),
    /// To `LastCalibration`.
    Calibration(Calibration),
}

/// What an instrument says unasked, to its owner. Any may be lost: `Status` and `Continue` find out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// A point of the segment being scanned.
    Point(Point),
    /// The state has changed.
    State(MachineState),
    /// The instrument has stopped.
    Fault(Fault),
}

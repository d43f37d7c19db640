//! The messages. The order of the variants is their number on the wire: append only.

use serde::{Deserialize, Serialize};

use super::reading::{Calibration, CalibrationKind, Point, Range, Reading, Segment};
use super::state::{Axis, DeviceError, Diagnostics, Fault, Ident, MachineState, Status};
use super::units::Microdegrees;

/// A message with its session and its number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The client's session, drawn at random, not 0; answers and events repeat the session of the request.
    pub session: u16,
    /// A client numbers its requests upwards, with wrap-around; an answer repeats the number of the request. A
    /// repeated request keeps its number, is carried out once, and gets the same answer again. Events have a count of
    /// their own.
    pub sequence: u16,
    /// The message.
    pub message: Message,
}

/// Every message, from either end.
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

/// A request of a client. Only the owner may send requests other than `Identify`, `Status`, `Diagnostics`, `Claim`
/// and `EmergencyStop`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// The identity of the instrument: `Response::Ident`, in every version of the protocol.
    Identify,
    /// Makes this session the owner, unless another session owns the instrument and was active lately.
    Claim,
    /// The instrument stops, has no owner, and accepts text again.
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
    /// Reads the detector at its present position. Accepted when begun; over when idle; see `LastReading`.
    Read,
    /// `Response::Reading` of the last `Read`.
    LastReading,
    /// One calibration run. Accepted when begun; over when idle.
    Calibrate(CalibrationKind),
    /// `Response::Calibration`, after both runs.
    LastCalibration,
    /// Scans a segment; the points come as events. Idle when all are measured.
    Scan(Segment),
    /// The client has the points of the segment before `next`. The instrument sends at most `credit` points from
    /// there on, and measures them first where needed. This also requests lost points again.
    Continue {
        /// Name of the segment.
        segment: u32,
        /// First point the client does not have.
        next: u16,
        /// Points that the instrument may send before the next request, >= 1.
        credit: u16,
    },
    /// Stops the present work in good order; idle afterwards.
    Stop,
    /// Cuts the motors at once: fault `EmergencyStop`. From any session.
    EmergencyStop,
    /// Clears the fault; idle afterwards.
    ClearFault,
}

/// The answer of an instrument.
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

/// An event, which the instrument sends to its owner without a request. Any event may be lost; `Status` and
/// `Continue` recover its content.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// A point of the segment being scanned.
    Point(Point),
    /// The state has changed.
    State(MachineState),
    /// The instrument has stopped.
    Fault(Fault),
}

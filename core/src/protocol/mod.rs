//! The protocol between an instrument and a computer: messages, frames, and a small text interface.
//!
//! PROTOCOL.md is the specification: byte tables, states, golden vectors. A [`Frame`] is one message
//! with the session it belongs to and its sequence number, serialised by postcard, closed by a CRC-32C,
//! and stuffed by COBS between two zero bytes. [`encode`] makes frames, [`Decoder`] finds them in a
//! stream of bytes that may be cut, corrupted or garbage. [`scpi`] reads the text commands.
//!
//! ```
//! use asperity_core::protocol::{Decoder, Frame, Message, Request, encode};
//!
//! let request = Frame { session: 7, sequence: 1, message: Message::Request(Request::Status) };
//! let encoded = encode(&request);
//! // what the other end receives, after garbage on the line
//! let line = [&[0x42, 0x17][..], encoded.as_bytes()].concat();
//! let (mut decoder, mut bytes) = (Decoder::default(), &line[..]);
//! let received = std::iter::from_fn(|| decoder.next(&mut bytes)).find_map(Result::ok);
//! assert_eq!(received, Some(request));
//! ```

mod codec;
mod frame;
mod message;
mod reading;
pub mod scpi;
mod state;
mod units;

pub use codec::{Encoded, FrameError, MAX_ENCODED, MAX_PAYLOAD, checksum, encode};
pub use frame::Decoder;
pub use message::{Event, Frame, Message, Request, Response};
pub use reading::{Calibration, CalibrationKind, Point, RANGES, Range, Reading, Segment};
pub use state::{Axis, AxisLimits, DeviceError, Diagnostics, Fault, Ident, MachineState, Status};
pub use units::{Microdegrees, Text16};

/// Version of the messages. A client refuses any other.
pub const VERSION: u16 = 1;

/// Most points of one segment.
pub const MAX_POINTS: u16 = 1801;

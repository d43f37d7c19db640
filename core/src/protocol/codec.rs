//! One frame to bytes and back: postcard, CRC-32C, COBS.

use core::fmt;

use crc::{CRC_32_ISCSI, Crc};
use heapless::Vec;
use postcard::ser_flavors::Flavor;

use super::message::Frame;

/// Largest number of bytes of a serialised message with its checksum, before stuffing.
pub const MAX_PAYLOAD: usize = 96;

/// Largest number of bytes of a frame on the line: the payload, one byte of stuffing, a zero at either end.
pub const MAX_ENCODED: usize = MAX_PAYLOAD + 3;

/// Bytes of the checksum, little-endian, at the end of the payload.
const CHECKSUM: usize = 4;

const CASTAGNOLI: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);

/// CRC-32C (Castagnoli, reflected, initial and final all ones) of `bytes`: the line's checksum.
pub fn checksum(bytes: &[u8]) -> u32 {
    CASTAGNOLI.checksum(bytes)
}

/// Why bytes between two zeros are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// A block of the stuffing is cut off.
    Truncated,
    /// Longer than [`MAX_PAYLOAD`].
    TooLong,
    /// The checksum is wrong.
    Checksum,
    /// The checksum is right, the message is not one of this version.
    Unknown,
    /// An instrument with another version of the protocol.
    Version(u16),
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated => f.write_str("a frame is cut off"),
            Self::TooLong => f.write_str("a frame is too long"),
            Self::Checksum => f.write_str("a frame's checksum is wrong"),
            Self::Unknown => f.write_str("a frame holds no message of this version"),
            Self::Version(version) => write!(f, "a frame of protocol version {version}"),
        }
    }
}

impl core::error::Error for FrameError {}

/// A frame ready for the line.
#[derive(Clone, Debug)]
pub struct Encoded(Vec<u8, MAX_ENCODED>);

impl Encoded {
    /// Its bytes; the first and the last are zero, no other is.
    pub fn as_bytes(&self) -> &[u8] {
        &self.0
    }
}

impl AsRef<[u8]> for Encoded {
    fn as_ref(&self) -> &[u8] {
        self.as_bytes()
    }
}

/// A message on its way into its payload; room for the checksum is kept.
struct Payload<'a>(&'a mut Vec<u8, MAX_PAYLOAD>);

impl Flavor for Payload<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        let fits = self.0.len() + bytes.len() <= MAX_PAYLOAD - CHECKSUM;
        let put = if fits { self.0.extend_from_slice(bytes).ok() } else { None };
        put.ok_or(postcard::Error::SerializeBufferFull)
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// Serialises a frame. No message of this version is too long; a longer one would come out empty.
pub fn encode(frame: &Frame) -> Encoded {
    let mut payload = Vec::new();
    let written = postcard::serialize_with_flavor(frame, Payload(&mut payload));
    let sum = checksum(&payload).to_le_bytes();
    let whole = written.is_ok() && payload.extend_from_slice(&sum).is_ok();
    let stuffed = if whole { stuff(&payload) } else { None };
    Encoded(stuffed.unwrap_or_default())
}

/// COBS of less than 254 bytes, with a zero before and behind; `None` if it does not fit.
fn stuff(payload: &[u8]) -> Option<Vec<u8, MAX_ENCODED>> {
    let mut stuffed = Vec::new();
    stuffed.push(0).ok()?;
    for block in payload.split(|&byte| byte == 0) {
        // `MAX_PAYLOAD` is below 254, so no block needs splitting
        stuffed.push(block.len() as u8 + 1).ok()?;
        stuffed.extend_from_slice(block).ok()?;
    }
    stuffed.push(0).ok()?;
    Some(stuffed)
}

/// The frame in an unstuffed payload.
pub(super) fn parse(payload: &[u8]) -> Result<Frame, FrameError> {
    let Some((message, sum)) = payload.split_last_chunk::<CHECKSUM>() else {
        return Err(FrameError::Truncated);
    };
    if checksum(message) != u32::from_le_bytes(*sum) {
        return Err(FrameError::Checksum);
    }
    match postcard::take_from_bytes::<Frame>(message) {
        Ok((frame, [])) => Ok(frame),
        _ => Err(other_version(message).map_or(FrameError::Unknown, FrameError::Version)),
    }
}

/// The version, if this is the answer to `Identify` in a layout that this version does not know.
fn other_version(message: &[u8]) -> Option<u16> {
    // session, sequence, `Message::Response`, `Response::Ident`, `Ident::protocol`: frozen for ever
    match postcard::take_from_bytes::<(u16, u16, u8, u8, u16)>(message) {
        Ok(((_, _, 1, 0, version), _)) if version != super::VERSION => Some(version),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{FrameError, MAX_ENCODED, MAX_PAYLOAD, encode, parse};
    use crate::protocol::{
        Axis, AxisLimits, Calibration, Event, Fault, Frame, Ident, MachineState, Message,
        Microdegrees, Point, Range, Reading, Request, Response, Segment, Status, Text16,
    };

    const FAR: Microdegrees = Microdegrees(i32::MIN);
    const READING: Reading =
        Reading { signal: 1.1, dark: 1.1, range: 255, over: true, under: true };

    /// The longest message of every kind.
    fn longest() -> [Message; 6] {
        let limits = AxisLimits { least: FAR, most: FAR, speed: u32::MAX };
        [
            Message::Request(Request::Scan(Segment {
                segment: u32::MAX,
                start: FAR,
                step: FAR,
                count: u16::MAX,
                first: u16::MAX,
                credit: u16::MAX,
            })),
            Message::Response(Response::Ident(Ident {
                protocol: u16::MAX,
                model: Text16::new("sixteen letters!"),
                serial: u32::MAX,
                firmware: [255; 3],
                sigma: limits,
                theta: limits,
                max_points: u16::MAX,
            })),
            Message::Response(Response::Status(Status {
                state: MachineState::Fault,
                fault: Some(Fault::AxisStalled(Axis::Theta)),
                homed: true,
                lamp: true,
                sigma: FAR,
                theta: FAR,
                aperture: FAR,
                range: Range::Fixed(255),
                integration_us: u32::MAX,
                segment: Some((u32::MAX, u16::MAX)),
                calibration: Some(u32::MAX),
                owner: Some(u16::MAX),
            })),
            Message::Response(Response::Calibration(Calibration {
                id: u32::MAX,
                dark: [1.1; 6],
                reference: 1.1,
                range: 255,
            })),
            Message::Response(Response::Reading(READING)),
            Message::Event(Event::Point(Point {
                segment: u32::MAX,
                index: u16::MAX,
                theta: FAR,
                reading: READING,
            })),
        ]
    }

    #[test]
    fn the_longest_messages_fit() {
        for message in longest() {
            let frame = Frame { session: u16::MAX, sequence: u16::MAX, message };
            let encoded = encode(&frame);
            let bytes = encoded.as_bytes();
            assert!(bytes.len() > 8 && bytes.len() <= MAX_ENCODED, "{message:?}");
            let (inside, ends) = (&bytes[1..bytes.len() - 1], (bytes[0], bytes[bytes.len() - 1]));
            assert!(ends == (0, 0) && !inside.contains(&0), "{message:?}");
        }
    }

    #[test]
    fn a_payload_too_short_for_its_checksum_is_cut_off() {
        assert_eq!(parse(&[]), Err(FrameError::Truncated));
        assert_eq!(parse(&[1, 2, 3]), Err(FrameError::Truncated));
        assert_eq!(parse(&[0; MAX_PAYLOAD]), Err(FrameError::Checksum));
    }

    #[test]
    fn bytes_left_over_are_refused() {
        // a good checksum over a good message and one byte more
        let mut message = std::vec![1, 1, 0, 3];
        let sum = |m: &[u8]| super::checksum(m).to_le_bytes();
        let whole = |m: &[u8]| [m, &sum(m)].concat();
        assert!(parse(&whole(&message)).is_ok());
        message.push(0);
        assert_eq!(parse(&whole(&message)), Err(FrameError::Unknown));
    }
}

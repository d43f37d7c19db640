//! Finds frames in a stream of bytes.

use heapless::Vec;

use super::codec::{FrameError, MAX_PAYLOAD, parse};
use super::message::Frame;

/// Accepts bytes in pieces of any size and returns frames; memory and time are bounded for any input.
///
/// Zeros separate frames, so damage ends at the next zero: at most two frames are discarded, the one in which a byte
/// was lost and the one joined to it.
///
/// ```
/// use asperity_core::protocol::{Decoder, Frame, Message, Request, encode};
/// let frame = Frame { session: 7, sequence: 1, message: Message::Request(Request::Status) };
/// let mut line = b"garbage".to_vec();
/// line.extend_from_slice(encode(&frame).as_bytes());
/// let (mut decoder, mut bytes) = (Decoder::new(), &line[..]);
/// assert!(decoder.next(&mut bytes).is_some_and(|result| result.is_err()));
/// assert_eq!(decoder.next(&mut bytes), Some(Ok(frame)));
/// assert_eq!(decoder.next(&mut bytes), None);
/// assert_eq!((decoder.good(), decoder.bad()), (1, 1));
/// ```
#[derive(Clone, Debug)]
pub struct Decoder {
    payload: Vec<u8, MAX_PAYLOAD>,
    /// Bytes left in the block of the stuffing.
    left: u8,
    /// A zero stands between this block and the next.
    zero: bool,
    /// Something came since the last zero.
    begun: bool,
    too_long: bool,
    good: u32,
    bad: u32,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that waits for a frame.
    pub const fn new() -> Self {
        Self {
            payload: Vec::new(),
            left: 0,
            zero: false,
            begun: false,
            too_long: false,
            good: 0,
            bad: 0,
        }
    }

    /// Frames received, with wrap-around.
    pub fn good(&self) -> u32 {
        self.good
    }

    /// Frames discarded, with wrap-around.
    pub fn bad(&self) -> u32 {
        self.bad
    }

    /// Whether the last byte ended a frame, or no byte has come yet.
    pub fn is_between_frames(&self) -> bool {
        !self.begun
    }

    /// Discards the frame begun, as after a lost connection. The counters stay.
    pub fn reset(&mut self) {
        self.payload.clear();
        self.left = 0;
        (self.zero, self.begun, self.too_long) = (false, false, false);
    }

    /// Takes bytes off the front of `bytes`, up to the end of the next frame, good or bad.
    ///
    /// `None` if the bytes end before a frame does; the rest may follow in the next call.
    pub fn next(&mut self, bytes: &mut &[u8]) -> Option<Result<Frame, FrameError>> {
        while let [first, rest @ ..] = *bytes {
            if *first == 0 {
                *bytes = rest;
                if let Some(result) = self.finish() {
                    return Some(result);
                }
            } else if self.left == 0 {
                *bytes = rest;
                self.block(*first);
            } else {
                self.data(bytes);
            }
        }
        None
    }

    /// The head of a block.
    fn block(&mut self, code: u8) {
        self.too_long |= self.zero && self.payload.push(0).is_err();
        self.begun = true;
        self.left = code - 1;
        self.zero = code != u8::MAX;
    }

    /// As much of a block as there is before its end or the next zero.
    fn data(&mut self, bytes: &mut &[u8]) {
        let most = bytes.len().min(usize::from(self.left));
        let (block, _) = bytes.split_at(most);
        let run = block.iter().position(|&byte| byte == 0).unwrap_or(most);
        let (run, rest) = bytes.split_at(run);
        self.append(run);
        self.left -= run.len() as u8;
        *bytes = rest;
    }

    fn append(&mut self, bytes: &[u8]) {
        self.too_long |= self.payload.extend_from_slice(bytes).is_err();
    }

    /// The end of a frame; `None` between two zeros without anything.
    fn finish(&mut self) -> Option<Result<Frame, FrameError>> {
        if !self.begun {
            return None;
        }
        let result = if self.too_long {
            Err(FrameError::TooLong)
        } else if self.left > 0 {
            Err(FrameError::Truncated)
        } else {
            parse(&self.payload)
        };
        self.reset();
        let counter = if result.is_ok() { &mut self.good } else { &mut self.bad };
        *counter = counter.wrapping_add(1);
        Some(result)
    }
}

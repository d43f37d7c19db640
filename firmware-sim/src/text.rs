//! The text facade: lines in, lines out, a queue of errors.

use asperity_core::protocol::scpi::{Command, LineError, MAX_LINE, parse};
use asperity_core::protocol::{DeviceError, Microdegrees};
use heapless::{Deque, Vec};

use crate::clock::Sink;

/// Errors kept; SCPI wants the last one to be -350 when there were more.
const QUEUE: usize = 4;

/// An error by the numbers of SCPI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextError {
    Line(LineError),
    /// A client owns the instrument.
    Protected,
    /// Not in this state.
    Conflict,
    OutOfRange,
    /// There are no points.
    NoData,
    /// A fault.
    Hardware,
    QueueOverflow,
}

impl TextError {
    fn code(self) -> (i16, &'static str) {
        match self {
            Self::Line(error) => error.code(),
            Self::Protected => (-203, "Command protected"),
            Self::Conflict => (-221, "Settings conflict"),
            Self::OutOfRange => LineError::OutOfRange.code(),
            Self::NoData => (-230, "Data corrupt or stale"),
            Self::Hardware => (-240, "Hardware error"),
            Self::QueueOverflow => (-350, "Queue overflow"),
        }
    }
}

impl From<DeviceError> for TextError {
    fn from(error: DeviceError) -> Self {
        match error {
            DeviceError::SoftLimit(_) | DeviceError::BadValue => Self::OutOfRange,
            DeviceError::Faulted(_) => Self::Hardware,
            _ => Self::Conflict,
        }
    }
}

/// The line that comes in, and the errors.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    /// One byte more than allowed, so that a line that is too long is refused; what comes on top is lost.
    line: Vec<u8, { MAX_LINE + 1 }>,
    errors: Deque<TextError, QUEUE>,
}

impl Text {
    pub(crate) const fn new() -> Self {
        Self { line: Vec::new(), errors: Deque::new() }
    }

    /// Takes a byte; at the end of a line the command, if it is one.
    pub(crate) fn take(&mut self, byte: u8) -> Option<Command> {
        if byte != b'\n' && byte != b'\r' {
            let _ = self.line.push(byte);
            return None;
        }
        let parsed = parse(&self.line);
        self.drop_line();
        parsed.unwrap_or_else(|error| {
            self.error(TextError::Line(error));
            None
        })
    }

    /// Forgets the line begun.
    pub(crate) fn drop_line(&mut self) {
        self.line.clear();
    }

    pub(crate) fn error(&mut self, error: TextError) {
        if self.errors.push_back(error).is_err()
            && let Some(last) = self.errors.back_mut()
        {
            *last = TextError::QueueOverflow;
        }
    }

    pub(crate) fn clear_errors(&mut self) {
        self.errors.clear();
    }

    /// Answers `SYST:ERR?`: the oldest error, which is forgotten.
    pub(crate) fn say_error(&mut self, out: &mut dyn Sink) {
        let oldest = self.errors.pop_front();
        let (number, text) = oldest.map_or((0, "No error"), TextError::code);
        integer(i32::from(number), out);
        out.write(b",\"");
        out.write(text.as_bytes());
        out.write(b"\"\n");
    }
}

/// Up to ten digits with leading zeros, at least `least` of them; more than ten are never asked for.
fn digits(mut number: u32, least: usize, out: &mut dyn Sink) {
    let mut text = Vec::<u8, 10>::new();
    while (number > 0 || text.len() < least) && text.push(b'0' + (number % 10) as u8).is_ok() {
        number /= 10;
    }
    text.reverse();
    out.write(&text);
}

/// A whole number.
pub(crate) fn integer(number: i32, out: &mut dyn Sink) {
    if number < 0 {
        out.write(b"-");
    }
    digits(number.unsigned_abs(), 1, out);
}

/// A number without a sign.
pub(crate) fn unsigned(number: u32, out: &mut dyn Sink) {
    digits(number, 1, out);
}

/// An angle in degrees, six decimals.
pub(crate) fn angle(angle: Microdegrees, out: &mut dyn Sink) {
    let size = angle.0.unsigned_abs();
    if angle.0 < 0 {
        out.write(b"-");
    }
    digits(size / Microdegrees::DEGREE.unsigned_abs(), 1, out);
    out.write(b".");
    digits(size % Microdegrees::DEGREE.unsigned_abs(), 6, out);
}

/// A number in exponential form, seven digits: `1.234568e-03`. SCPI writes 9.91E37 for no number.
pub(crate) fn exponential(number: f32, out: &mut dyn Sink) {
    let number = if number.is_finite() { f64::from(number) } else { 9.91e37 };
    if number < 0.0 {
        out.write(b"-");
    }
    let (mut size, mut exponent) = (number.abs(), 0_i32);
    // an f32 is above 1e-46 and below 1e39, or 0
    while size >= 10.0 && exponent < 40 {
        (size, exponent) = (size / 10.0, exponent + 1);
    }
    while size > 0.0 && size < 1.0 && exponent > -50 {
        (size, exponent) = (size * 10.0, exponent - 1);
    }
    let mut whole = (size * 1e6 + 0.5) as u32;
    if whole >= 10_000_000 {
        (whole, exponent) = (1_000_000, exponent + 1);
    }
    digits(whole / 1_000_000, 1, out);
    out.write(b".");
    digits(whole % 1_000_000, 6, out);
    out.write(if exponent < 0 { b"e-" } else { b"e+" });
    digits(exponent.unsigned_abs(), 2, out);
}

/// The head of a definite-length block of this many bytes.
pub(crate) fn block(bytes: u32, out: &mut dyn Sink) {
    let width = bytes.checked_ilog10().unwrap_or(0) + 1;
    out.write(b"#");
    digits(width, 1, out);
    digits(bytes, 1, out);
}

#[cfg(test)]
mod tests {
    use super::{QUEUE, Text, TextError, angle, block, exponential, integer};
    use crate::clock::Sink;
    use asperity_core::protocol::Microdegrees;
    use asperity_core::protocol::scpi::Command;
    use std::string::String;
    use std::vec::Vec;

    fn text(write: impl Fn(&mut dyn Sink)) -> String {
        let mut bytes = Vec::new();
        write(&mut |piece: &[u8]| bytes.extend_from_slice(piece));
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn numbers_read_as_they_should() {
        for (number, expected) in [
            (0.0, "0.000000e+00"),
            (1.0, "1.000000e+00"),
            (-1.5e-3, "-1.500000e-03"),
            (f32::MIN_POSITIVE, "1.175494e-38"),
            (f32::from_bits(1), "1.401298e-45"),
            (f32::MAX, "3.402823e+38"),
            (f32::NAN, "9.910000e+37"),
        ] {
            assert_eq!(text(|out| exponential(number, out)), expected);
        }
        // the standard library rounds exactly; half of the powers of ten are a little too small
        let same = |x: f32| {
            let said: f64 = text(|out| exponential(x, out)).parse().unwrap();
            let exact: f64 = std::format!("{x:.6e}").parse().unwrap();
            assert_eq!(said.to_bits(), exact.to_bits(), "{x:e}");
        };
        for k in -37..=38 {
            same(std::format!("1e{k}").parse().unwrap());
        }
        let mut x = 1.1e-30_f32;
        while x < 1e30 {
            same(x);
            x *= 1.37;
        }
        assert_eq!(text(|out| angle(Microdegrees(-30_250_001), out)), "-30.250001");
        assert_eq!(text(|out| angle(Microdegrees(-5), out)), "-0.000005");
        assert_eq!(text(|out| integer(i32::MIN, out)), "-2147483648");
        assert_eq!(text(|out| block(7204, out)), "#47204");
        assert_eq!(text(|out| block(0, out)), "#10");
    }

    #[test]
    fn lines_are_cut_at_their_ends_and_long_ones_refused() {
        let mut port = Text::new();
        let mut send = |line: &[u8]| line.iter().filter_map(|&b| port.take(b)).collect::<Vec<_>>();
        assert_eq!(send(b"*IDN?\r\n\nMEAS?\n"), [Command::Identify, Command::Measure]);
        assert_eq!(send(&[b'A'; 5000]), []);
        assert_eq!(send(b"\n*CLS\n"), [Command::ClearErrors]);
        let errors = text(|out| port.clone().say_error(out));
        assert_eq!(errors, "-363,\"Input buffer overrun\"\n");
    }

    #[test]
    fn the_queue_of_errors_is_first_in_first_out_and_says_when_it_is_full() {
        let mut port = Text::new();
        port.error(TextError::NoData);
        for _ in 0..QUEUE {
            port.error(TextError::Conflict);
        }
        let said: Vec<String> = (0..=QUEUE)
            .map(|_| {
                let mut bytes = Vec::new();
                port.say_error(&mut |piece: &[u8]| bytes.extend_from_slice(piece));
                String::from_utf8(bytes).unwrap()
            })
            .collect();
        assert_eq!(said[0], "-230,\"Data corrupt or stale\"\n");
        assert_eq!(said[1], "-221,\"Settings conflict\"\n");
        assert_eq!(said[QUEUE - 1], "-350,\"Queue overflow\"\n");
        assert_eq!(said[QUEUE], "0,\"No error\"\n");
    }
}

//! The text interface: a few SCPI commands for a terminal, `LabVIEW` or VISA.

use super::units::Microdegrees;

/// Longest line, without its end.
pub const MAX_LINE: usize = 64;

/// A text command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// `*IDN?`: maker, model, serial number, firmware.
    Identify,
    /// `*RST`: stops, clears faults, homes, lamp on.
    Reset,
    /// `*CLS`: clears the errors.
    ClearErrors,
    /// `SYSTem:ERRor?`: takes the oldest error.
    NextError,
    /// `GONiometer:ANGle <sigma>,<theta>`: moves, degrees.
    SetAngles(Microdegrees, Microdegrees),
    /// `GONiometer:ANGle?`: where the axes are, degrees.
    Angles,
    /// `MEASure?`: one reading, relative where calibrated.
    Measure,
    /// `SCAN:DATA?`: the points measured last, a definite-length block of little-endian `f32`.
    ScanData,
}

/// Why a line is no command, by the numbers of SCPI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LineError {
    /// Not printable ASCII.
    InvalidCharacter,
    /// -113: no such header.
    UndefinedHeader,
    /// -108: more parameters than the command has.
    ParameterNotAllowed,
    /// -109: fewer parameters than the command has.
    MissingParameter,
    /// -120: a parameter that is no number.
    NumericData,
    /// -222: a number out of range.
    OutOfRange,
    /// -363: the line is too long.
    Overrun,
}

impl LineError {
    /// The number and the text of SCPI-99, volume 2, chapter 21.
    pub fn code(self) -> (i16, &'static str) {
        match self {
            Self::InvalidCharacter => (-101, "Invalid character"),
            Self::ParameterNotAllowed => (-108, "Parameter not allowed"),
            Self::MissingParameter => (-109, "Missing parameter"),
            Self::UndefinedHeader => (-113, "Undefined header"),
            Self::NumericData => (-120, "Numeric data error"),
            Self::OutOfRange => (-222, "Data out of range"),
            Self::Overrun => (-363, "Input buffer overrun"),
        }
    }
}

/// Reads one line, without its end; `Ok(None)` if it is blank.
///
/// Letters of either case; long and short forms; a leading `:` is allowed.
///
/// # Errors
/// [`LineError`], for `SYST:ERR?`.
pub fn parse(line: &[u8]) -> Result<Option<Command>, LineError> {
    if line.len() > MAX_LINE {
        return Err(LineError::Overrun);
    }
    let line = line.trim_ascii();
    if !line.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\t')) {
        return Err(LineError::InvalidCharacter);
    }
    let mut words = line.splitn(2, u8::is_ascii_whitespace);
    let header = words.next().unwrap_or(&[]);
    let parameters = words.next().unwrap_or(&[]).trim_ascii();
    if header.is_empty() {
        return Ok(None);
    }
    let command = match header.strip_prefix(b":").unwrap_or(header) {
        h if h.eq_ignore_ascii_case(b"*IDN?") => Command::Identify,
        h if h.eq_ignore_ascii_case(b"*RST") => Command::Reset,
        h if h.eq_ignore_ascii_case(b"*CLS") => Command::ClearErrors,
        h if is(h, [(b"SYST", b"SYSTEM"), (b"ERR?", b"ERROR?")]) => Command::NextError,
        h if is(h, [(b"GON", b"GONIOMETER"), (b"ANG?", b"ANGLE?")]) => Command::Angles,
        h if is(h, [(b"GON", b"GONIOMETER"), (b"ANG", b"ANGLE")]) => {
            return angles(parameters).map(Some);
        }
        h if is(h, [(b"MEAS?", b"MEASURE?")]) => Command::Measure,
        h if is(h, [(b"SCAN", b"SCAN"), (b"DATA?", b"DATA?")]) => Command::ScanData,
        _ => return Err(LineError::UndefinedHeader),
    };
    if parameters.is_empty() { Ok(Some(command)) } else { Err(LineError::ParameterNotAllowed) }
}

/// Whether the header is these keywords, each in its short or its long form.
fn is<const N: usize>(header: &[u8], keywords: [(&[u8], &[u8]); N]) -> bool {
    let mut words = header.split(|&byte| byte == b':');
    keywords.iter().all(|(short, long)| {
        words.next().is_some_and(|w| w.eq_ignore_ascii_case(short) || w.eq_ignore_ascii_case(long))
    }) && words.next().is_none()
}

fn angles(parameters: &[u8]) -> Result<Command, LineError> {
    if parameters.is_empty() {
        return Err(LineError::MissingParameter);
    }
    let mut fields = parameters.split(|&byte| byte == b',');
    let mut angle = || decimal(fields.next().ok_or(LineError::MissingParameter)?.trim_ascii());
    let (sigma, theta) = (angle()?, angle()?);
    match fields.next() {
        None => Ok(Command::SetAngles(sigma, theta)),
        Some(_) => Err(LineError::ParameterNotAllowed),
    }
}

/// A decimal number of degrees, with a sign and a point if need be, no exponent; digits beyond the
/// sixth decimal are not looked at.
fn decimal(text: &[u8]) -> Result<Microdegrees, LineError> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let mut parts = digits.splitn(2, |&byte| byte == b'.');
    let (whole, decimals) = (parts.next().unwrap_or(&[]), parts.next().unwrap_or(&[]));
    if whole.is_empty() && decimals.is_empty()
        || !whole.iter().chain(decimals).all(u8::is_ascii_digit)
    {
        return Err(LineError::NumericData);
    }
    let six = decimals.iter().chain(core::iter::repeat(&b'0')).take(6);
    let value = whole.iter().chain(six).try_fold(0_i32, |value, digit| {
        value.checked_mul(10)?.checked_add(i32::from(digit - b'0'))
    });
    let value = value.ok_or(LineError::OutOfRange)?;
    Ok(Microdegrees(if negative { -value } else { value }))
}

#[cfg(test)]
mod tests {
    use super::{Command, LineError, MAX_LINE, parse};
    use crate::protocol::Microdegrees;

    #[test]
    fn commands_in_long_and_short_form_and_either_case() {
        let cases: [(&[u8], Command); 11] = [
            (b"*IDN?", Command::Identify),
            (b" *idn? \r", Command::Identify),
            (b"*RST", Command::Reset),
            (b"*CLS", Command::ClearErrors),
            (b"SYST:ERR?", Command::NextError),
            (b":system:error?", Command::NextError),
            (b"GON:ANG?", Command::Angles),
            (b"Goniometer:Angle?", Command::Angles),
            (b"MEAS?", Command::Measure),
            (b"SCAN:DATA?", Command::ScanData),
            (
                b"GON:ANG 15, -30.25",
                Command::SetAngles(Microdegrees(15_000_000), Microdegrees(-30_250_000)),
            ),
        ];
        for (line, command) in cases {
            assert_eq!(
                parse(line),
                Ok(Some(command)),
                "{}",
                std::string::String::from_utf8_lossy(line)
            );
        }
        assert_eq!(parse(b" \r"), Ok(None));
    }

    #[test]
    fn numbers_are_decimal_degrees() {
        let angles = |text: &str| parse(std::format!("GON:ANG {text}").as_bytes());
        let set = |s, t| Ok(Some(Command::SetAngles(Microdegrees(s), Microdegrees(t))));
        assert_eq!(angles("+.5,5."), set(500_000, 5_000_000));
        assert_eq!(angles("0.1234567,-0"), set(123_456, 0));
        assert_eq!(angles("1,2,3"), Err(LineError::ParameterNotAllowed));
        assert_eq!(angles("1"), Err(LineError::MissingParameter));
        assert_eq!(angles(""), Err(LineError::MissingParameter));
        for wrong in ["a,1", "1e2,1", ",1", ".,1", "--1,1", "1,", "1.2.3,1"] {
            assert_eq!(angles(wrong), Err(LineError::NumericData), "{wrong}");
        }
        assert_eq!(angles("2148,0"), Err(LineError::OutOfRange));
        assert_eq!(angles("99999999999999,0"), Err(LineError::OutOfRange));
    }

    #[test]
    fn what_is_no_command_has_the_number_of_scpi() {
        assert_eq!(parse(b"HELLO"), Err(LineError::UndefinedHeader));
        assert_eq!(parse(b"SYST:ERR?:X"), Err(LineError::UndefinedHeader));
        assert_eq!(parse(b"*IDN? 1"), Err(LineError::ParameterNotAllowed));
        assert_eq!(parse(b"*IDN\xff"), Err(LineError::InvalidCharacter));
        assert_eq!(parse(&[b'A'; MAX_LINE + 1]), Err(LineError::Overrun));
        assert_eq!(LineError::UndefinedHeader.code().0, -113);
    }
}

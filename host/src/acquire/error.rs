//! Trouble with an instrument: the port, the fault and the remedy.

use std::io;

use thiserror::Error;

use asperity_core::protocol::{DeviceError, Fault};

/// Trouble with an instrument, shown as `/dev/ttyUSB0: ...; remedy`.
#[derive(Debug, Error)]
#[error("{port}: {trouble}")]
pub struct LinkError {
    /// The port, as the user named it.
    pub port: String,
    /// The fault.
    pub trouble: Box<Trouble>,
}

impl LinkError {
    /// Trouble on a port.
    pub fn new(port: impl Into<String>, trouble: Trouble) -> Self {
        Self { port: port.into(), trouble: Box::new(trouble) }
    }
}

/// A fault of an instrument, or of the line to it.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Trouble {
    /// Not the name of a port.
    #[error(
        "is not a port; give a serial port (see `asperity acquire --list-ports`) or tcp:HOST:PORT"
    )]
    BadPort,
    /// Another program has the port open.
    #[error("is in use by another program; end that program, or wait for it")]
    Locked,
    /// The port cannot be opened.
    #[error(
        "cannot be opened: {0}; check the cable and the name (`asperity acquire --list-ports`)"
    )]
    Open(io::Error),
    /// A device answers, but not in this protocol.
    #[error(
        "no instrument of this kind answers: {bytes} bytes came, {bad} broken frames, beginning with \
         `{first}`; check the port and --baud"
    )]
    NotAnInstrument {
        /// Bytes received.
        bytes: u64,
        /// Frames thrown away.
        bad: u32,
        /// The first bytes; those that are no printable ASCII are dots.
        first: String,
    },
    /// Nothing answers.
    #[error(
        "no answer within {seconds:.1} s; check that the instrument is switched on, the cable, and --baud"
    )]
    Silent {
        /// The time waited.
        seconds: f64,
    },
    /// An instrument of another version of the protocol.
    #[error(
        "the instrument speaks protocol version {theirs}, this program version {ours}; update the \
         firmware or asperity"
    )]
    Version {
        /// The instrument's.
        theirs: u16,
        /// This program's.
        ours: u16,
    },
    /// Another client owns the instrument.
    #[error(
        "another client is using the instrument; wait until it is done (a lost one is forgotten in 5 s)"
    )]
    InUse,
    /// After the line was lost another instrument answers, or the journal belongs to another one.
    #[error("this is {found}, not {expected}; connect the instrument that was begun with")]
    OtherInstrument {
        /// Model and serial number of this one.
        found: String,
        /// Model and serial number of the one expected.
        expected: String,
    },
    /// The instrument refuses the request.
    #[error("the instrument refuses {what}: {why}; see `asperity instrument status`")]
    Refused {
        /// The request.
        what: &'static str,
        /// Its reason.
        why: DeviceError,
    },
    /// The instrument has stopped.
    #[error(
        "the instrument has stopped by a fault: {what}; mend it, then `asperity instrument clear`{again}",
        what = .0, again = home_again(*.0)
    )]
    Fault(Fault),
    /// Answers to what was not asked.
    #[error(
        "the instrument answers, but not to what it is asked ({answers} answers with numbers of other \
         requests); switch it off and on"
    )]
    Astray {
        /// The number.
        answers: u64,
    },
    /// It is present, but does not answer one kind of request.
    #[error(
        "the instrument answers, but not when it is asked for {what} ({seconds:.0} s); switch it off and on"
    )]
    Mute {
        /// The request.
        what: &'static str,
        /// The time waited.
        seconds: f64,
    },
    /// The instrument accepted a setting and does not have it.
    #[error(
        "{what} was set to {wanted}, and the instrument reports {reported}: nothing measured so is kept; \
         switch it off and on, see `asperity instrument status`"
    )]
    Disobeyed {
        /// The setting.
        what: &'static str,
        /// As it was set.
        wanted: String,
        /// As the status has it.
        reported: String,
    },
    /// The beam without the sample is too weak to measure against.
    #[error(
        "without the sample the detector reads {reference} nA, {above} nA above the dark current, and at \
         least {least} nA are needed (ten times the largest dark current, {dark} nA, and 1 % of the range); \
         look after lamp, beam and shutter",
        reference = plain(*.reference), above = plain(*.above), least = plain(*.least), dark = plain(*.dark)
    )]
    WeakBeam {
        /// The reading without the sample, nA.
        reference: f64,
        /// The same less the dark current of its range, nA.
        above: f64,
        /// The largest dark current of all ranges, nA.
        dark: f64,
        /// The least that is measured against, nA.
        least: f64,
    },
    /// It stops again and again and reports no fault.
    #[error(
        "the instrument has stopped {times} times before {what} was over, without a fault; see \
         `asperity instrument status`, switch it off and on"
    )]
    Stops {
        /// The work in progress.
        what: &'static str,
        /// The number of times.
        times: u32,
    },
    /// The line was lost and is not back.
    #[error("the connection was lost and not back within {seconds:.0} s{}; check cable and power", because(.cause.as_ref()))]
    Lost {
        /// The time waited.
        seconds: f64,
        /// The last error of the operating system.
        cause: Option<io::Error>,
    },
    /// The line or the instrument fails again and again.
    #[error(
        "{what} failed {times} times because the connection was lost or no answer came; check cable and power"
    )]
    Unstable {
        /// The attempt.
        what: &'static str,
        /// The number of times.
        times: u32,
    },
    /// The instrument reports something impossible.
    #[error("the instrument says what cannot be: {0}; switch it off and on, or have it serviced")]
    Nonsense(String),
    /// It does not finish.
    #[error("{what} is not over after {seconds:.0} s; see `asperity instrument status`")]
    Overdue {
        /// The work begun.
        what: &'static str,
        /// The time waited.
        seconds: f64,
    },
    /// The user stopped it.
    #[error("interrupted")]
    Interrupted,
}

/// A number in a message: six digits at most, whatever its size.
pub(super) fn plain(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) {
        let digits = (5.0 - value.abs().max(1e-4).log10().floor()).clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$}");
        let text = if text.contains('.') { text.trim_end_matches('0') } else { &text };
        text.trim_end_matches('.').to_owned()
    } else if value.is_finite() {
        format!("{value:.5e}")
    } else {
        value.to_string()
    }
}

fn because(cause: Option<&io::Error>) -> String {
    cause.map_or_else(String::new, |e| format!(" ({e})"))
}

/// The remedy if a fault loses the zeros.
fn home_again(fault: Fault) -> &'static str {
    match fault {
        Fault::AxisStalled(_) | Fault::LimitSwitch(_) | Fault::EmergencyStop => {
            " and `asperity instrument home`"
        }
        Fault::OverRange | Fault::LampFailed => "",
    }
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn numbers_in_messages_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (800.0, "800"),
            (-0.0042, "-0.0042"),
            (123_456.7, "123457"),
            (1e300, "1.00000e300"),
            (f64::MIN_POSITIVE, "2.22507e-308"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(plain(value), text);
        }
    }
}

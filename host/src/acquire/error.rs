//! What can be wrong with an instrument: on which port, what, and what to do.

use std::io;

use thiserror::Error;

use asperity_core::protocol::{DeviceError, Fault};

/// Trouble with an instrument, shown as `/dev/ttyUSB0: ...; remedy`.
#[derive(Debug, Error)]
#[error("{port}: {trouble}")]
pub struct LinkError {
    /// The port, as the user named it.
    pub port: String,
    /// What is wrong.
    pub trouble: Box<Trouble>,
}

impl LinkError {
    /// Trouble on a port.
    pub fn new(port: impl Into<String>, trouble: Trouble) -> Self {
        Self { port: port.into(), trouble: Box::new(trouble) }
    }
}

/// What is wrong with an instrument, or with the way to it.
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
    /// Something answers, but not in this protocol.
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
        /// How long was waited.
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
    /// After the line was lost another instrument answers, or the journal is of another one.
    #[error("this is {found}, not {expected}; connect the instrument that was begun with")]
    OtherInstrument {
        /// Model and serial number of this one.
        found: String,
        /// Model and serial number of the one expected.
        expected: String,
    },
    /// The instrument says no.
    #[error("the instrument refuses {what}: {why}; see `asperity instrument status`")]
    Refused {
        /// What was asked for.
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
    /// The line was lost and is not back.
    #[error("the connection was lost and not back within {seconds:.0} s{}; check cable and power", because(.cause.as_ref()))]
    Lost {
        /// How long was waited.
        seconds: f64,
        /// The operating system's last word.
        cause: Option<io::Error>,
    },
    /// The line or the instrument fails again and again.
    #[error(
        "{what} failed {times} times because the connection was lost each time; check cable and power"
    )]
    Unstable {
        /// What was tried.
        what: &'static str,
        /// How often.
        times: u32,
    },
    /// The instrument says what cannot be.
    #[error("the instrument says what cannot be: {0}; switch it off and on, or have it serviced")]
    Nonsense(String),
    /// It does not come to an end.
    #[error("{what} is not over after {seconds:.0} s; see `asperity instrument status`")]
    Overdue {
        /// What was begun.
        what: &'static str,
        /// How long was waited.
        seconds: f64,
    },
    /// The user wants it to end.
    #[error("interrupted")]
    Interrupted,
}

fn because(cause: Option<&io::Error>) -> String {
    cause.map_or_else(String::new, |e| format!(" ({e})"))
}

/// What has to follow where a fault loses the zeros.
fn home_again(fault: Fault) -> &'static str {
    match fault {
        Fault::AxisStalled(_) | Fault::LimitSwitch(_) | Fault::EmergencyStop => {
            " and `asperity instrument home`"
        }
        Fault::OverRange | Fault::LampFailed => "",
    }
}

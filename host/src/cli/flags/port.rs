//! The port of an instrument, as flags, and how trouble with it ends a verb.

use crate::acquire::transport::{self, Transport};
use crate::acquire::{
    AcquireError, Client, JournalError, LinkError, Patience, ScheduleError, Trouble,
};
use crate::cli::error::Failure;

/// Where the instrument is.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "The instrument")]
pub(in crate::cli) struct PortFlags {
    /// Serial port, such as /dev/ttyUSB0 or COM3, or tcp:HOST:PORT
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) port: Option<String>,
    /// Bits a second of a serial port
    #[arg(long, value_name = "N", default_value_t = 115_200)]
    baud: u32,
}

impl PortFlags {
    /// Opens it; `None` without `--port`.
    pub(in crate::cli) fn open(&self) -> Result<Box<dyn Transport>, LinkError> {
        transport::open(self.port.as_deref().unwrap_or_default(), self.baud)
    }

    /// Opens it and finds out who is there.
    pub(in crate::cli) fn connect(&self) -> Result<Client<'static, Box<dyn Transport>>, LinkError> {
        Client::connect(self.open()?, Patience::default())
    }

    /// `--port` must be there.
    pub(in crate::cli) fn need(&self) -> Result<(), Failure> {
        match &self.port {
            Some(_) => Ok(()),
            None => Err(Failure::bad(
                "no port is given; add --port PORT (`asperity acquire --list-ports` shows the serial ones)",
            )),
        }
    }
}

impl From<LinkError> for Failure {
    fn from(e: LinkError) -> Self {
        match *e.trouble {
            Trouble::BadPort => Self::bad(e),
            Trouble::Interrupted => Self::No(e.to_string()),
            _ => Self::Trouble(e.to_string()),
        }
    }
}

impl From<ScheduleError> for Failure {
    fn from(e: ScheduleError) -> Self {
        Self::bad(e)
    }
}

impl From<AcquireError> for Failure {
    fn from(e: AcquireError) -> Self {
        match e {
            AcquireError::Link(e) => e.into(),
            AcquireError::Output(e) => e.into(),
            AcquireError::Interrupted { .. } | AcquireError::NotBegun => Self::No(e.to_string()),
            AcquireError::OtherCalibration { .. }
            | AcquireError::FalseCalibration { .. }
            | AcquireError::OverRange { .. }
            | AcquireError::NoScan { .. }
            | AcquireError::Journal(JournalError::Io { .. }) => Self::Trouble(e.to_string()),
            e => Self::bad(e),
        }
    }
}

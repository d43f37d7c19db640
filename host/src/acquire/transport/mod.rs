//! Bytes to and from an instrument, and the clock of the waits.

#[cfg(feature = "serial")]
mod serial;
mod tcp;
mod in_process;

use std::io;
use std::time::Duration;

use super::error::{LinkError, Trouble};

pub use self::in_process::{InProcess, Peer};
#[cfg(feature = "serial")]
pub use self::serial::{PortName, Serial, list};
pub use self::tcp::Tcp;

/// A line to an instrument.
pub trait Transport {
    /// Sends all bytes.
    ///
    /// # Errors
    /// The line is broken; [`reconnect`](Self::reconnect) may restore it.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Takes what has come, at most the buffer full; waits for the first byte. 0: nothing within `wait`.
    ///
    /// # Errors
    /// The line is broken; [`reconnect`](Self::reconnect) may restore it.
    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Time since some fixed moment, never going back.
    fn now(&self) -> Duration;

    /// Waits.
    fn pause(&mut self, time: Duration);

    /// Closes the line and opens it again; tries once.
    ///
    /// # Errors
    /// It cannot be opened now.
    fn reconnect(&mut self) -> io::Result<()>;

    /// The name that the user gave it.
    fn name(&self) -> String;
}

macro_rules! pass_on {
    ($owner:ty) => {
        impl<T: Transport + ?Sized> Transport for $owner {
            fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
                (**self).send(bytes)
            }
            fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> io::Result<usize> {
                (**self).receive(buffer, wait)
            }
            fn now(&self) -> Duration {
                (**self).now()
            }
            fn pause(&mut self, time: Duration) {
                (**self).pause(time);
            }
            fn reconnect(&mut self) -> io::Result<()> {
                (**self).reconnect()
            }
            fn name(&self) -> String {
                (**self).name()
            }
        }
    };
}

pass_on!(Box<T>);
pass_on!(&mut T);

/// Opens `tcp:HOST:PORT`, or the serial port of that name with `baud` bits per second.
///
/// # Errors
/// [`Trouble::BadPort`], [`Trouble::Locked`], [`Trouble::Open`].
pub fn open(port: &str, baud: u32) -> Result<Box<dyn Transport>, LinkError> {
    let failed = |trouble| LinkError::new(port, trouble);
    if let Some(address) = port.strip_prefix("tcp:") {
        let tcp = Tcp::new(address).ok_or_else(|| failed(Trouble::BadPort))?;
        return Ok(Box::new(tcp.open().map_err(|e| failed(Trouble::Open(e)))?));
    }
    if port.trim().is_empty() || baud == 0 {
        return Err(failed(Trouble::BadPort));
    }
    serial_port(port, baud).map_err(|e| match e.kind() {
        io::ErrorKind::ResourceBusy => failed(Trouble::Locked),
        _ => failed(Trouble::Open(e)),
    })
}

#[cfg(feature = "serial")]
fn serial_port(port: &str, baud: u32) -> io::Result<Box<dyn Transport>> {
    Ok(Box::new(Serial::open(port, baud)?))
}

#[cfg(not(feature = "serial"))]
fn serial_port(_: &str, _: u32) -> io::Result<Box<dyn Transport>> {
    let text = "this program was built without the feature `serial`; use tcp:HOST:PORT";
    Err(io::Error::new(io::ErrorKind::Unsupported, text))
}

/// Whether an error only says that nothing came in time, or that a signal came in between.
fn is_only_late(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | WouldBlock | Interrupted)
}

/// The line is closed at the other end.
fn broken() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "the line is closed at the other end")
}

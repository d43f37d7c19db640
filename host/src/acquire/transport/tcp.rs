//! An instrument on the network.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::thread;
use std::time::{Duration, Instant};

use super::{Transport, broken, is_only_late};

/// Longest time for reaching one address.
const CONNECT: Duration = Duration::from_secs(3);
/// Longest time for sending a frame.
const SEND: Duration = Duration::from_secs(1);

/// A TCP connection, `HOST:PORT`; an IPv6 address stands in brackets.
#[derive(Debug)]
pub struct Tcp {
    address: String,
    stream: Option<TcpStream>,
    begun: Instant,
}

impl Tcp {
    /// A line to that address, not yet opened; `None` if it is not `HOST:PORT`.
    pub fn new(address: &str) -> Option<Self> {
        let (host, port) = address.rsplit_once(':')?;
        port.parse::<u16>().ok().filter(|&port| port > 0)?;
        (!host.is_empty()).then(|| Self {
            address: address.to_owned(),
            stream: None,
            begun: Instant::now(),
        })
    }

    /// Opens it.
    ///
    /// # Errors
    /// The operating system's.
    pub fn open(mut self) -> io::Result<Self> {
        self.reconnect()?;
        Ok(self)
    }
}

impl Transport for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.as_mut().ok_or_else(broken)?.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> io::Result<usize> {
        let stream = self.stream.as_mut().ok_or_else(broken)?;
        // zero would mean for ever
        stream.set_read_timeout(Some(wait.max(Duration::from_millis(1))))?;
        match stream.read(buffer) {
            Ok(0) => Err(broken()),
            Err(e) if is_only_late(&e) => Ok(0),
            result => result,
        }
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        thread::sleep(time);
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.stream = None;
        let mut failed = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
        for address in self.address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, CONNECT) {
                Ok(stream) => {
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(SEND))?;
                    self.stream = Some(stream);
                    return Ok(());
                }
                Err(e) => failed = e,
            }
        }
        Err(failed)
    }

    fn name(&self) -> String {
        format!("tcp:{}", self.address)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_a_host_and_a_port() {
        for good in ["localhost:5025", "[::1]:5025", "10.0.0.7:1"] {
            assert!(Tcp::new(good).is_some(), "{good}");
        }
        for bad in ["", "localhost", ":5025", "localhost:", "localhost:0", "localhost:70000"] {
            assert!(Tcp::new(bad).is_none(), "{bad}");
        }
    }
}

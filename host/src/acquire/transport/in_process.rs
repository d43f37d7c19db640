//! An instrument inside this process, with its own clock: it scans for hours in an instant.

use std::io;
use std::time::Duration;

use super::{Transport, broken};

/// Time of one byte on a line of 115200 baud, 8N1.
const BYTE: Duration = Duration::from_nanos(86_806);
/// The clock goes on by this much where the peer wants to be asked again at once and says nothing.
const LEAST_JUMP: Duration = Duration::from_micros(100);
/// Capacity of a line without a reader; more is lost.
const MOST_PENDING: usize = 1 << 20;

/// The other end of a line.
pub trait Peer {
    /// Takes the bytes that came, and appends what it says; `now` is the time on the line's clock.
    fn exchange(&mut self, bytes: &[u8], now: Duration, out: &mut Vec<u8>);

    /// When it next has something to say of its own accord; `None`: not before it is asked.
    fn poll_at(&self) -> Option<Duration>;

    /// Whether the line is up. If not, it fails until [`reconnect`](Self::reconnect) succeeds.
    fn connected(&self) -> bool {
        true
    }

    /// The client opens the line again; whether it succeeds.
    fn reconnect(&mut self, now: Duration) -> bool {
        let _ = now;
        true
    }
}

/// A line to a [`Peer`]. Its clock advances only for waits and for bytes, which take their time at 115200 baud. Even
/// a peer that never stops sending cannot stop the clock.
#[derive(Clone, Debug)]
pub struct InProcess<P> {
    peer: P,
    clock: Duration,
    pending: Vec<u8>,
}

impl<P: Peer> InProcess<P> {
    /// A line to that peer at time 0.
    pub fn new(peer: P) -> Self {
        Self { peer, clock: Duration::ZERO, pending: Vec::new() }
    }

    /// The other end.
    pub fn peer(&self) -> &P {
        &self.peer
    }

    /// The other end, mutable.
    pub fn peer_mut(&mut self) -> &mut P {
        &mut self.peer
    }

    fn exchange(&mut self, bytes: &[u8]) -> io::Result<()> {
        if !self.peer.connected() {
            self.pending.clear();
            return Err(broken());
        }
        self.peer.exchange(bytes, self.clock, &mut self.pending);
        self.pending.truncate(MOST_PENDING);
        Ok(())
    }

    /// On to the moment when the peer is next to be asked, at most to `deadline`.
    fn jump(&mut self, deadline: Duration) {
        let next = self.peer.poll_at().unwrap_or(deadline);
        let next = if next > self.clock { next } else { self.clock + LEAST_JUMP };
        self.clock = next.min(deadline);
    }
}

impl<P: Peer> Transport for InProcess<P> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.clock += BYTE * bytes.len() as u32;
        self.exchange(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> io::Result<usize> {
        let deadline = self.clock + wait;
        loop {
            self.exchange(&[])?;
            if !self.pending.is_empty() {
                let taken = self.pending.len().min(buffer.len());
                for (slot, byte) in buffer.iter_mut().zip(self.pending.drain(..taken)) {
                    *slot = byte;
                }
                self.clock += BYTE * taken as u32;
                return Ok(taken);
            }
            if self.clock >= deadline {
                return Ok(0);
            }
            self.jump(deadline);
        }
    }

    fn now(&self) -> Duration {
        self.clock
    }

    fn pause(&mut self, time: Duration) {
        let deadline = self.clock + time;
        while self.clock < deadline {
            // a broken line is found out when it is next used
            let _ = self.exchange(&[]);
            self.jump(deadline);
        }
    }

    fn reconnect(&mut self) -> io::Result<()> {
        self.pending.clear();
        if self.peer.reconnect(self.clock) {
            Ok(())
        } else {
            Err(io::Error::from(io::ErrorKind::ConnectionRefused))
        }
    }

    fn name(&self) -> String {
        "simulator".to_owned()
    }
}

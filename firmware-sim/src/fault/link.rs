//! A line that loses, breaks, repeats and holds up what is sent over it, by chance but by a seed.

use asperity_core::math::Real;
use heapless::Vec;
use rand_pcg::Pcg32;

use crate::clock::{Instant, Sink};

/// Most bytes kept together; longer pieces are cut.
const CHUNK: usize = 256;
/// Chunks on the way in one direction; what comes on top is lost.
const SLOTS: usize = 28;

/// How likely each fault is for each chunk of bytes (0 to 1), and how long faults last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkFaults {
    /// One byte is lost.
    pub drop: f32,
    /// One bit is turned over.
    pub flip: f32,
    /// The chunk comes twice, the second time up to four delays later.
    pub duplicate: f32,
    /// The chunk, and all after it, come up to a delay later.
    pub delay: f32,
    /// The end of the chunk is lost, or all of it.
    pub truncate: f32,
    /// Nothing passes in this direction for a while.
    pub stall: f32,
    /// The connection breaks: what is on the way is lost.
    pub disconnect: f32,
    /// Longest delay, microseconds.
    pub delay_us: u32,
    /// Length of a stall, microseconds.
    pub stall_us: u32,
    /// How long there is no connection, microseconds.
    pub reconnect_us: u32,
}

impl LinkFaults {
    /// A good line.
    pub const NONE: Self = Self {
        drop: 0.0,
        flip: 0.0,
        duplicate: 0.0,
        delay: 0.0,
        truncate: 0.0,
        stall: 0.0,
        disconnect: 0.0,
        delay_us: 50_000,
        stall_us: 300_000,
        reconnect_us: 200_000,
    };

    /// Every fault of single chunks as likely as this; stalls a tenth, broken connections a hundredth.
    pub fn rate(rate: f32) -> Self {
        Self {
            drop: rate,
            flip: rate,
            duplicate: rate,
            delay: rate,
            truncate: rate,
            stall: rate / 10.0,
            disconnect: rate / 100.0,
            ..Self::NONE
        }
    }
}

/// Where bytes go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From the client.
    ToInstrument,
    /// To the client.
    ToClient,
}

/// Bytes on their way.
#[derive(Clone, Debug)]
struct Chunk {
    due: Instant,
    /// Among those due together the first sent comes first.
    order: u32,
    bytes: Vec<u8, CHUNK>,
}

/// One direction.
#[derive(Clone, Debug)]
struct Lane {
    chunks: Vec<Chunk, SLOTS>,
    order: u32,
    /// Nothing overtakes the last chunk, duplicates apart.
    last: Instant,
}

impl Lane {
    const fn new() -> Self {
        Self { chunks: Vec::new(), order: 0, last: Instant(0) }
    }

    /// Takes a chunk; an empty one, or one too many, is lost.
    fn put(&mut self, bytes: Vec<u8, CHUNK>, due: Instant) {
        let chunk = Chunk { due, order: self.order, bytes };
        if !chunk.bytes.is_empty() && self.chunks.push(chunk).is_ok() {
            self.order = self.order.wrapping_add(1);
        }
    }

    /// Gives the next chunk that is due by `now`.
    fn take(&mut self, now: Instant) -> Option<Vec<u8, CHUNK>> {
        let due = self.chunks.iter().enumerate().filter(|(_, chunk)| chunk.due <= now);
        let (first, _) = due.min_by_key(|(_, chunk)| (chunk.due, chunk.order))?;
        Some(self.chunks.swap_remove(first).bytes)
    }

    fn due(&self) -> Option<Instant> {
        self.chunks.iter().map(|chunk| chunk.due).min()
    }

    fn clear(&mut self) {
        self.chunks.clear();
    }
}

/// A line of two directions with faults. The time is that of whoever calls.
///
/// ```
/// use asperity_firmware_sim::fault::{Direction, Link, LinkFaults};
/// use asperity_firmware_sim::Instant;
/// let mut line = Link::new(LinkFaults::NONE, 1);
/// line.send(Direction::ToClient, b"hello", Instant(0));
/// let mut got = Vec::new();
/// line.receive(Direction::ToClient, Instant(0), &mut |bytes: &[u8]| got.extend_from_slice(bytes));
/// assert_eq!(got, b"hello");
/// ```
#[derive(Clone, Debug)]
pub struct Link {
    faults: LinkFaults,
    chance: Pcg32,
    lanes: [Lane; 2],
    /// When the connection is back.
    broken: Option<Instant>,
    /// The break was not yet told.
    news: bool,
}

impl Link {
    /// A line; the same seed and the same calls give the same faults.
    pub fn new(faults: LinkFaults, seed: u64) -> Self {
        let chance = Pcg32::new(seed, 0x11e);
        Self { faults, chance, lanes: [Lane::new(), Lane::new()], broken: None, news: false }
    }

    /// Whether there is a connection.
    pub fn is_connected(&mut self, now: Instant) -> bool {
        self.broken = self.broken.filter(|&end| now < end);
        self.broken.is_none()
    }

    /// True once after the connection broke: both ends are to be told.
    pub fn take_break(&mut self) -> bool {
        core::mem::take(&mut self.news)
    }

    /// When there is something to receive, in either direction, or the connection is back.
    pub fn poll_at(&self) -> Option<Instant> {
        self.lanes.iter().filter_map(Lane::due).chain(self.broken).min()
    }

    /// Takes bytes at one end.
    pub fn send(&mut self, direction: Direction, bytes: &[u8], now: Instant) {
        for chunk in bytes.chunks(CHUNK) {
            if self.is_connected(now) {
                self.pass(direction, chunk, now);
            }
        }
    }

    /// Gives what has come at the other end.
    pub fn receive(&mut self, direction: Direction, now: Instant, out: &mut impl Sink) {
        self.is_connected(now);
        let lane = self.lane(direction);
        while let Some(bytes) = lane.take(now) {
            out.write(&bytes);
        }
    }

    fn lane(&mut self, direction: Direction) -> &mut Lane {
        let [to_instrument, to_client] = &mut self.lanes;
        match direction {
            Direction::ToInstrument => to_instrument,
            Direction::ToClient => to_client,
        }
    }

    fn happens(&mut self, probability: f32) -> bool {
        f32::uniform(&mut self.chance) < probability
    }

    /// Below `end`.
    fn below(&mut self, end: usize) -> usize {
        (f64::uniform(&mut self.chance) * end as f64).to_index()
    }

    fn pass(&mut self, direction: Direction, chunk: &[u8], now: Instant) {
        let faults = self.faults;
        if self.happens(faults.disconnect) {
            self.broken = Some(now.after(u64::from(faults.reconnect_us)));
            self.news = true;
            self.lanes.iter_mut().for_each(Lane::clear);
            return;
        }
        // never an error: chunks are cut to this capacity
        let mut bytes = Vec::<u8, CHUNK>::from_slice(chunk).unwrap_or_default();
        if self.happens(faults.flip) {
            let bit = self.below(bytes.len() * 8);
            if let Some(byte) = bytes.get_mut(bit / 8) {
                *byte ^= 1 << (bit % 8);
            }
        }
        if self.happens(faults.drop) {
            let at = self.below(bytes.len());
            bytes.remove(at);
        }
        if self.happens(faults.truncate) {
            let length = self.below(bytes.len() + 1);
            bytes.truncate(length);
        }
        let mut due = self.lane(direction).last.max(now);
        if self.happens(faults.delay) {
            let us = self.below(faults.delay_us as usize + 1);
            due = due.max(now.after(us as u64));
        }
        if self.happens(faults.stall) {
            due = due.after(u64::from(faults.stall_us));
        }
        let late = due.after(self.below(4 * faults.delay_us as usize + 1) as u64);
        let twice = self.happens(faults.duplicate);
        let lane = self.lane(direction);
        lane.last = due;
        lane.put(bytes.clone(), due);
        if twice {
            lane.put(bytes, late);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Direction, Link, LinkFaults};
    use crate::clock::Instant;
    use std::vec::Vec;

    const ALWAYS: u64 = u64::MAX / 2;

    fn all(line: &mut Link, now: Instant) -> Vec<u8> {
        let mut got = Vec::new();
        line.receive(Direction::ToClient, now, &mut |b: &[u8]| got.extend_from_slice(b));
        got
    }

    fn one(faults: LinkFaults, bytes: &[u8]) -> (Link, Vec<u8>) {
        let mut line = Link::new(faults, 3);
        line.send(Direction::ToClient, bytes, Instant(0));
        let got = all(&mut line, Instant(ALWAYS));
        (line, got)
    }

    #[test]
    fn a_good_line_changes_nothing_and_keeps_directions_apart() {
        let bytes: Vec<u8> = (0..1000).map(|k| k as u8).collect();
        let (mut line, got) = one(LinkFaults::NONE, &bytes);
        assert_eq!(got, bytes);
        line.send(Direction::ToInstrument, &bytes, Instant(5));
        assert!(all(&mut line, Instant(ALWAYS)).is_empty());
        assert_eq!(line.poll_at(), Some(Instant(5)));
    }

    #[test]
    fn each_fault_does_what_it_says() {
        let bytes = [0x55; 100];
        let none = LinkFaults::NONE;
        let (_, got) = one(LinkFaults { drop: 1.0, ..none }, &bytes);
        assert_eq!(got.len(), 99);
        let (_, got) = one(LinkFaults { flip: 1.0, ..none }, &bytes);
        let flipped: u32 = got.iter().zip(bytes).map(|(a, b)| (a ^ b).count_ones()).sum();
        assert_eq!((got.len(), flipped), (100, 1));
        let (_, got) = one(LinkFaults { duplicate: 1.0, ..none }, &bytes);
        assert_eq!(got.len(), 200);
        let (_, got) = one(LinkFaults { truncate: 1.0, ..none }, &bytes);
        assert!(got.len() < 100);
        let mut line = Link::new(LinkFaults { stall: 1.0, ..none }, 3);
        line.send(Direction::ToClient, &bytes, Instant(0));
        assert!(all(&mut line, Instant(299_999)).is_empty());
        assert_eq!(all(&mut line, Instant(300_000)).len(), 100);
    }

    #[test]
    fn delays_keep_the_order() {
        let mut line = Link::new(LinkFaults { delay: 0.5, ..LinkFaults::NONE }, 9);
        let mut got = Vec::new();
        for k in 0..200_u8 {
            line.send(Direction::ToClient, &[k], Instant(u64::from(k) * 3000));
            got.extend(all(&mut line, Instant(u64::from(k) * 3000)));
        }
        assert!(got.len() < 200, "nothing was late");
        got.extend(all(&mut line, Instant(ALWAYS)));
        assert!(got.iter().copied().eq(0..200_u8));
    }

    #[test]
    fn a_break_loses_what_is_on_the_way_and_is_told_once() {
        let mut line = Link::new(LinkFaults { disconnect: 1.0, ..LinkFaults::NONE }, 1);
        line.send(Direction::ToClient, b"x", Instant(10));
        assert!(line.take_break() && !line.take_break());
        assert!(!line.is_connected(Instant(200_009)) && line.is_connected(Instant(200_010)));
        assert!(all(&mut line, Instant(ALWAYS)).is_empty());
    }

    #[test]
    fn the_same_seed_gives_the_same_faults() {
        let run = |seed| {
            let mut line = Link::new(LinkFaults::rate(0.2), seed);
            let mut got = Vec::new();
            for k in 0..300_u64 {
                let now = Instant(k * 10_000);
                line.send(Direction::ToClient, &k.to_le_bytes(), now);
                got.extend(all(&mut line, now));
            }
            got
        };
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
    }

    #[test]
    fn a_full_line_loses_and_does_not_fail() {
        let mut line = Link::new(LinkFaults { stall: 1.0, ..LinkFaults::NONE }, 1);
        line.send(Direction::ToClient, &std::vec![1; 100_000], Instant(0));
        assert_eq!(all(&mut line, Instant(ALWAYS)).len(), super::SLOTS * super::CHUNK);
    }
}

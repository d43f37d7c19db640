//! An instrument at the end of a line that may be bad, as a peer in this process.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asperity::acquire::{
    AcquireError, Draft, InProcess, Job, Patience, Peer, Schedule, Summary, run,
};
use asperity_firmware_sim::fault::{Direction, Link, LinkFaults};
use asperity_firmware_sim::{Config, Instant, MachineFault, Simulator};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

/// What goes wrong.
#[derive(Clone, Debug)]
pub(crate) struct Trouble {
    /// On the line, chunk by chunk.
    pub(crate) link: LinkFaults,
    /// Share of all bytes that are replaced, in both directions.
    pub(crate) noise: f64,
    /// That only from this time on.
    pub(crate) noise_from: Duration,
    /// In the machine, at these times of the line's clock.
    pub(crate) machine: Vec<(Duration, MachineFault)>,
    pub(crate) seed: u64,
}

impl Trouble {
    pub(crate) const NONE: Self = Self {
        link: LinkFaults::NONE,
        noise: 0.0,
        noise_from: Duration::ZERO,
        machine: Vec::new(),
        seed: 0,
    };
}

/// A peer for the in-process transport.
#[derive(Debug)]
pub(crate) struct Bench {
    pub(crate) simulator: Simulator,
    link: Link,
    noise: f64,
    noise_from: Duration,
    machine: Vec<(Duration, MachineFault)>,
    generator: Pcg64Mcg,
    connected: bool,
    /// Bytes that were replaced.
    pub(crate) hit: u64,
}

impl Bench {
    pub(crate) fn new(config: &Config, trouble: &Trouble) -> Self {
        Self {
            simulator: Simulator::new(*config),
            link: Link::new(trouble.link, trouble.seed),
            noise: trouble.noise,
            noise_from: trouble.noise_from,
            machine: trouble.machine.clone(),
            generator: Pcg64Mcg::new(u128::from(trouble.seed) | 1 << 80),
            connected: true,
            hit: 0,
        }
    }

    /// From now on nothing goes wrong any more.
    pub(crate) fn mend(&mut self) {
        self.link = Link::new(LinkFaults::NONE, 0);
        self.noise = 0.0;
        self.machine.clear();
        self.connected = true;
    }

    /// Replaces some bytes.
    fn spoil(&mut self, bytes: &mut [u8], now: Duration) {
        if self.noise > 0.0 && now >= self.noise_from {
            let limit = (self.noise * f64::from(u32::MAX)) as u32;
            for byte in bytes {
                if self.generator.next_u32() < limit {
                    *byte = self.generator.next_u32() as u8;
                    self.hit += 1;
                }
            }
        }
    }

    fn happen(&mut self, now: Duration) {
        let simulator = &mut self.simulator;
        self.machine.retain(|&(at, fault)| {
            if at <= now {
                simulator.inject(fault);
            }
            at > now
        });
    }
}

impl Peer for Bench {
    fn exchange(&mut self, bytes: &[u8], now: Duration, out: &mut Vec<u8>) {
        self.happen(now);
        let time = now;
        let now = Instant(now.as_micros() as u64);
        if !bytes.is_empty() {
            let mut bytes = bytes.to_vec();
            self.spoil(&mut bytes, time);
            self.link.send(Direction::ToInstrument, &bytes, now);
        }
        let (mut received, mut said) = (Vec::new(), Vec::new());
        let mut take = |bytes: &[u8]| received.extend_from_slice(bytes);
        self.link.receive(Direction::ToInstrument, now, &mut take);
        self.simulator.handle(&received, now, &mut |b: &[u8]| said.extend_from_slice(b));
        self.spoil(&mut said, time);
        self.link.send(Direction::ToClient, &said, now);
        self.link.receive(Direction::ToClient, now, &mut |b: &[u8]| out.extend_from_slice(b));
        if self.link.take_break() {
            self.simulator.disconnected(now);
        }
        self.connected = self.link.is_connected(now);
    }

    fn poll_at(&self) -> Option<Duration> {
        let due = [self.simulator.poll_at(), self.link.poll_at()];
        due.into_iter().flatten().min().map(|at| Duration::from_micros(at.0))
    }

    fn connected(&self) -> bool {
        self.connected
    }

    fn reconnect(&mut self, now: Duration) -> bool {
        self.connected = self.link.is_connected(Instant(now.as_micros() as u64));
        self.connected
    }
}

/// A schedule from TOML.
pub(crate) fn schedule(text: &str) -> Schedule {
    Draft::parse(text, Path::new("plan.toml")).unwrap().schedule().unwrap()
}

/// An instrument that is fast to simulate.
pub(crate) fn config(seed: u64) -> Config {
    Config { rays: 200, acceleration: 50, seed, ..Config::demo() }
}

/// Acquires over a line that stays open for the next attempt.
pub(crate) fn acquire(line: &mut InProcess<Bench>, job: &Job<'_>) -> Result<Summary, AcquireError> {
    run(job, || Ok(line), &AtomicBool::new(false), &mut |_| {})
}

/// A new scan of that schedule.
pub(crate) fn begin<'a>(schedule: &Schedule, output: &'a Path) -> Job<'a> {
    Job {
        schedule: Some(schedule.clone()),
        output,
        credit: 16,
        resume: false,
        recalibrate: false,
        patience: Patience::default(),
    }
}

/// A folder in memory where there is one: the journals of a thousand scans are synced to it.
pub(crate) fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap()
}

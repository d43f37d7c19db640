//! The machine: axes, lamp, detector, and what they are doing.
//!
//! Requests change it at once or begin something; `run` carries on what was begun.

mod begin;
mod run;

use asperity_core::gonio::gp200;
use asperity_core::protocol::{
    Axis as Name, Calibration, DeviceError, Fault, MachineState, Microdegrees, Point, RANGES,
    Range, Reading, Segment, Status, checksum,
};

use crate::axis::Axis;
use crate::clock::Instant;
use crate::config::{Config, SIGMA, THETA};
use crate::fault::Injected;
use crate::memory::Memory;
use crate::optics::{Angles, Tracing};
use crate::transition::{self, Input};

/// Something a client may want to hear of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Happening {
    State(MachineState),
    Fault(Fault),
    Point(Point),
    /// A reading asked for by `Read` is there.
    Reading,
}

/// What one step came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Progress {
    /// Nothing to do at this time.
    Nothing,
    /// One thing done; there may be more.
    Some,
    /// A chunk of rays traced: enough for one call.
    Traced,
    Happened(Happening),
}

/// What is going on. `end` is when, by the clock of the line.
#[derive(Clone, Debug)]
enum Job {
    None,
    /// `Home`, `Move`.
    Motion {
        end: Instant,
    },
    /// The rays of a reading.
    Trace {
        tracing: Tracing,
        arm: i32,
        light: f32,
    },
    /// The reading itself.
    Read {
        end: Instant,
        arm: i32,
        light: f32,
    },
    Dark {
        end: Instant,
    },
    Reference {
        end: Instant,
    },
    /// The rays of a scan.
    TraceAll(Tracing),
    /// Between two points, since.
    Ready {
        since: Instant,
    },
    /// On the way to a point, and reading it.
    Point {
        end: Instant,
    },
}

/// The segment in the memory.
#[derive(Clone, Copy, Debug)]
struct Held {
    angles: Angles,
    /// Points before this one are measured, or not wanted.
    measured: u16,
    /// The next point to be sent.
    send: u16,
    /// Credit ends before this point.
    until: u16,
    /// Dark currents in force when the scan began.
    dark: Option<[f32; RANGES as usize]>,
}

impl Held {
    fn count(&self) -> u16 {
        self.angles.segment.count
    }

    fn has_to_send(&self) -> bool {
        self.send < self.until.min(self.measured)
    }

    fn may_measure(&self) -> bool {
        self.measured < self.until
    }
}

/// See the module.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    config: Config,
    state: MachineState,
    fault: Option<Fault>,
    homed: bool,
    lamp: bool,
    sigma: Axis,
    theta: Axis,
    aperture: Microdegrees,
    range: Range,
    integration_us: u32,
    /// Range in which the amplifier is.
    gain: u8,
    job: Job,
    held: Option<Held>,
    memory: Memory,
    reading: Option<Reading>,
    dark: Option<[f32; RANGES as usize]>,
    reference: Option<(f32, u8)>,
    injected: Injected,
    /// The state last spoken of.
    announced: MachineState,
    /// A fault not yet spoken of.
    news: Option<Fault>,
}

impl Machine {
    /// Integration time after power-on, microseconds.
    const INTEGRATION_US: u32 = 10_000;
    /// Aperture after power-on, to the nearest millionth of a degree.
    const APERTURE: Microdegrees =
        Microdegrees((gp200::APERTURE_DEG * Microdegrees::DEGREE as f64 + 0.5) as i32);

    /// As after power-on: not homed, lamp on.
    #[expect(clippy::large_types_passed_by_value, reason = "kept, and made in place")]
    pub(crate) const fn new(config: Config) -> Self {
        Self {
            state: MachineState::Idle,
            fault: None,
            homed: false,
            lamp: true,
            sigma: Axis::new(config.limits(SIGMA), 0),
            theta: Axis::new(config.limits(THETA), config.backlash.0),
            aperture: Self::APERTURE,
            range: Range::Auto,
            integration_us: Self::INTEGRATION_US,
            gain: 0,
            job: Job::None,
            held: None,
            memory: Memory::new(),
            reading: None,
            dark: None,
            reference: None,
            injected: Injected::NONE,
            announced: MachineState::Idle,
            news: None,
            config,
        }
    }

    pub(crate) fn config(&self) -> &Config {
        &self.config
    }

    pub(crate) fn state(&self) -> MachineState {
        self.state
    }

    /// Whether it moves or measures.
    pub(crate) fn is_active(&self) -> bool {
        !matches!(self.state, MachineState::Idle | MachineState::Fault)
    }

    pub(crate) fn injected(&mut self) -> &mut Injected {
        &mut self.injected
    }

    /// A snapshot.
    pub(crate) fn status(&self, now: Instant, owner: Option<u16>) -> Status {
        Status {
            state: self.state,
            fault: self.fault,
            homed: self.homed,
            lamp: self.lamp,
            sigma: self.sigma.encoder(now),
            theta: self.theta.encoder(now),
            aperture: self.aperture,
            range: self.range,
            integration_us: self.integration_us,
            segment: self.held.map(|held| (held.angles.segment.segment, held.measured)),
            calibration: self.calibration().map(|calibration| calibration.id),
            owner,
        }
    }

    pub(crate) fn last_reading(&self) -> Option<Reading> {
        self.reading
    }

    /// After both runs.
    pub(crate) fn calibration(&self) -> Option<Calibration> {
        let (dark, (reference, range)) = (self.dark?, self.reference?);
        let mut bytes = [0; 4 * (RANGES as usize + 4)];
        let words = dark.into_iter().chain([reference]).map(f32::to_bits).chain([
            u32::from(range),
            self.aperture.0.cast_unsigned(),
            self.integration_us,
        ]);
        for (slot, word) in bytes.chunks_exact_mut(4).zip(words) {
            slot.copy_from_slice(&word.to_le_bytes());
        }
        Some(Calibration { id: checksum(&bytes), dark, reference, range })
    }

    /// A reading relative to the reference; the photocurrent less the dark current before there is one.
    pub(crate) fn relative(&self, reading: &Reading) -> f32 {
        let light = reading.signal - reading.dark;
        match self.calibration() {
            Some(Calibration { dark, reference, range, .. }) => {
                let dark = dark.get(usize::from(range)).copied().unwrap_or(0.0);
                light / (reference - dark)
            }
            None => light,
        }
    }

    /// The segment in the memory: first point, number of the first one not measured.
    pub(crate) fn points(&self) -> Option<(u16, u16)> {
        self.held.map(|held| (held.angles.segment.first, held.measured))
    }

    /// A measured point of the segment in the memory.
    pub(crate) fn point(&self, index: u16) -> Option<Point> {
        let held = self.held.filter(|held| index < held.measured)?;
        let Segment { segment, first, .. } = held.angles.segment;
        let dark = held.dark.unwrap_or([0.0; RANGES as usize]);
        let (theta, reading) = (held.angles.encoder(index), self.memory.reading(index, &dark));
        (index >= first).then_some(Point { segment, index, theta, reading })
    }

    /// Asks the table of states; the state changes if it says so.
    fn enter(&mut self, input: Input) -> Result<(), DeviceError> {
        (self.state, self.fault) = transition::next(self.state, self.fault, input)?;
        Ok(())
    }

    /// Stands still in good order; `Fault` stays.
    pub(crate) fn stop(&mut self, now: Instant) {
        if self.state == MachineState::Homing {
            self.homed = false;
        }
        if self.enter(Input::Stop).is_ok() {
            self.halt(now);
        }
    }

    /// Stops by a fault.
    pub(crate) fn fail(&mut self, fault: Fault, now: Instant) {
        if self.state != MachineState::Fault {
            self.news = Some(fault);
        }
        match fault {
            Fault::AxisStalled(_) | Fault::LimitSwitch(_) | Fault::EmergencyStop => {
                self.homed = false;
            }
            Fault::LampFailed => self.lamp_off(),
            Fault::OverRange => {}
        }
        if self.state == MachineState::Homing {
            self.homed = false;
        }
        if self.enter(Input::Fault(fault)).is_ok() {
            self.halt(now);
        }
    }

    fn lamp_off(&mut self) {
        self.lamp = false;
        (self.reference, self.reading) = (None, None);
    }

    fn halt(&mut self, now: Instant) {
        self.sigma.halt(now);
        self.theta.halt(now);
        self.job = Job::None;
        if let Some(held) = &mut self.held {
            held.until = held.send;
        }
    }

    /// Motion of one axis, with the fault that was injected for it; returns when it ends.
    fn go(&mut self, name: Name, to: Microdegrees, start: Instant) -> Instant {
        let axis = match name {
            Name::Sigma => &mut self.sigma,
            Name::Theta => &mut self.theta,
        };
        let moves = axis.encoder(start) != to;
        let fault = if moves { self.injected.take_for(name) } else { None };
        axis.go(to.0, start, fault)
    }
}

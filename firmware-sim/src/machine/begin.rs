//! What requests ask of the machine: refused, done at once, or begun.

use asperity_core::protocol::{
    Axis as Name, CalibrationKind, DeviceError, Fault, Microdegrees, RANGES, Range, Request,
    Response, Segment,
};

use super::{Held, Job, Machine};
use crate::clock::Instant;
use crate::optics::{Angles, Tracing};
use crate::transition::{self, Input};

/// Durations of the machine, microseconds.
pub(super) const SETTLE_US: u64 = 2000;
const SHUTTER_US: u64 = 200_000;
const WITHDRAWAL_US: u64 = 2_000_000;

const INTEGRATION_US: core::ops::RangeInclusive<u32> = 100..=10_000_000;
const WIDEST: i32 = 10 * Microdegrees::DEGREE;

impl Machine {
    /// Carries out a request, or begins to.
    ///
    /// The state is asked first, then whether the axes are homed, then the values.
    pub(crate) fn apply(
        &mut self,
        request: &Request,
        now: Instant,
    ) -> Result<Response, DeviceError> {
        match *request {
            Request::Home => self.home(now)?,
            Request::Move(axis, to) => self.travel(axis, to, now)?,
            Request::Aperture(aperture) => self.set_aperture(aperture)?,
            Request::Range(range) => self.set_range(range)?,
            Request::Integration(us) => self.set_integration(us)?,
            Request::Lamp(on) => self.set_lamp(on)?,
            Request::Read => self.read(now)?,
            Request::LastReading => {
                return self.reading.map(Response::Reading).ok_or(DeviceError::Nothing);
            }
            Request::Calibrate(kind) => self.calibrate(kind, now)?,
            Request::LastCalibration => {
                return self.calibration().map(Response::Calibration).ok_or(DeviceError::Nothing);
            }
            Request::Scan(segment) => self.scan(&segment, now)?,
            Request::Continue { segment, next, credit } => self.go_on(segment, next, credit)?,
            Request::Stop => self.stop(now),
            Request::EmergencyStop => self.fail(Fault::EmergencyStop, now),
            Request::ClearFault => self.enter(Input::ClearFault)?,
            // of the session, not of the machine
            Request::Identify
            | Request::Claim
            | Request::Release
            | Request::Status
            | Request::Diagnostics => {}
        }
        Ok(Response::Accepted)
    }

    /// Whether something may begin, without beginning it.
    fn may(&self, input: Input) -> Result<(), DeviceError> {
        transition::next(self.state, self.fault, input)?;
        match input {
            Input::Move | Input::Measure if !self.homed => Err(DeviceError::NotHomed),
            _ => Ok(()),
        }
    }

    fn within(&self, name: Name, position: i64) -> Result<(), DeviceError> {
        let axis = match name {
            Name::Sigma => &self.sigma,
            Name::Theta => &self.theta,
        };
        if axis.allows(position) { Ok(()) } else { Err(DeviceError::SoftLimit(name)) }
    }

    fn home(&mut self, now: Instant) -> Result<(), DeviceError> {
        self.enter(Input::Home)?;
        self.homed = false;
        let sigma = self.sigma.home(now, self.injected.take_for(Name::Sigma));
        let theta = self.theta.home(now, self.injected.take_for(Name::Theta));
        self.job = Job::Motion { end: self.settled(sigma.max(theta)) };
        Ok(())
    }

    fn travel(&mut self, name: Name, to: Microdegrees, now: Instant) -> Result<(), DeviceError> {
        self.may(Input::Move)?;
        self.within(name, i64::from(to.0))?;
        self.enter(Input::Move)?;
        let end = self.go(name, to, now);
        self.job = Job::Motion { end: self.settled(end) };
        Ok(())
    }

    /// Both axes, the sample first.
    pub(crate) fn travel_both(
        &mut self,
        sigma: Microdegrees,
        theta: Microdegrees,
        now: Instant,
    ) -> Result<(), DeviceError> {
        self.may(Input::Move)?;
        self.within(Name::Sigma, i64::from(sigma.0))?;
        self.within(Name::Theta, i64::from(theta.0))?;
        self.enter(Input::Move)?;
        let there = self.go(Name::Sigma, sigma, now);
        let end = self.go(Name::Theta, theta, there);
        self.job = Job::Motion { end: self.settled(end) };
        Ok(())
    }

    fn settled(&self, end: Instant) -> Instant {
        end.after(self.config.scaled(SETTLE_US))
    }

    fn set_aperture(&mut self, aperture: Microdegrees) -> Result<(), DeviceError> {
        self.may(Input::Setting)?;
        if !(1..=WIDEST).contains(&aperture.0) {
            return Err(DeviceError::BadValue);
        }
        if aperture != self.aperture {
            self.aperture = aperture;
            (self.reference, self.reading) = (None, None);
        }
        Ok(())
    }

    fn set_range(&mut self, range: Range) -> Result<(), DeviceError> {
        self.may(Input::Setting)?;
        if matches!(range, Range::Fixed(RANGES..)) {
            return Err(DeviceError::BadValue);
        }
        if range != self.range {
            (self.range, self.reading) = (range, None);
        }
        Ok(())
    }

    fn set_integration(&mut self, us: u32) -> Result<(), DeviceError> {
        self.may(Input::Setting)?;
        if !INTEGRATION_US.contains(&us) {
            return Err(DeviceError::BadValue);
        }
        if us != self.integration_us {
            self.integration_us = us;
            (self.dark, self.reference, self.reading) = (None, None, None);
        }
        Ok(())
    }

    fn set_lamp(&mut self, on: bool) -> Result<(), DeviceError> {
        self.may(Input::Setting)?;
        match (self.lamp, on) {
            (true, false) => self.lamp_off(),
            (false, true) => (self.lamp, self.reading) = (true, None),
            _ => {}
        }
        Ok(())
    }

    fn lit(&self) -> Result<(), DeviceError> {
        if self.lamp { Ok(()) } else { Err(DeviceError::LampOff) }
    }

    fn read(&mut self, now: Instant) -> Result<(), DeviceError> {
        self.may(Input::Measure)?;
        self.lit()?;
        self.enter(Input::Measure)?;
        self.reading = None;
        let tracing = Tracing::new(&self.config, self.sigma.encoder(now), self.aperture);
        self.job = Job::Trace { tracing, arm: self.theta.arm(now), light: 0.0 };
        Ok(())
    }

    fn calibrate(&mut self, kind: CalibrationKind, now: Instant) -> Result<(), DeviceError> {
        self.may(Input::Measure)?;
        let integration = u64::from(self.integration_us);
        let us = match kind {
            CalibrationKind::Dark => SHUTTER_US + u64::from(RANGES) * integration,
            CalibrationKind::Reference => {
                self.lit()?;
                if self.dark.is_none() {
                    return Err(DeviceError::NeedsCalibration(CalibrationKind::Dark));
                }
                WITHDRAWAL_US + integration
            }
        };
        self.enter(Input::Measure)?;
        let end = now.after(self.config.scaled(us));
        self.job = match kind {
            CalibrationKind::Dark => Job::Dark { end },
            CalibrationKind::Reference => Job::Reference { end },
        };
        Ok(())
    }

    fn scan(&mut self, segment: &Segment, now: Instant) -> Result<(), DeviceError> {
        self.may(Input::Measure)?;
        let Segment { start, step, count, first, credit, .. } = *segment;
        let known = 1..=asperity_core::protocol::MAX_POINTS;
        if step.0 < 1 || !known.contains(&count) || first >= count || credit == 0 {
            return Err(DeviceError::BadValue);
        }
        let start = i64::from(start.0);
        self.within(Name::Theta, start)?;
        self.within(Name::Theta, start + i64::from(step.0) * i64::from(count - 1))?;
        self.lit()?;
        self.enter(Input::Measure)?;
        let mut angles = Angles { segment: *segment, first_arm: 0 };
        angles.first_arm = self.theta.arm_after(angles.encoder(first).0, now);
        let until = first.saturating_add(credit).min(count);
        self.held = Some(Held { angles, measured: first, send: first, until, dark: self.dark });
        self.memory.begin(count);
        let sigma = self.sigma.encoder(now);
        self.job = Job::TraceAll(Tracing::new(&self.config, sigma, self.aperture));
        Ok(())
    }

    fn go_on(&mut self, segment: u32, next: u16, credit: u16) -> Result<(), DeviceError> {
        self.may(Input::Continue)?;
        let held = self.held.as_mut().filter(|held| held.angles.segment.segment == segment);
        let Some(held) = held else { return Err(DeviceError::NoSegment) };
        let known = held.angles.segment.first..=held.measured;
        if !known.contains(&next) || credit == 0 {
            return Err(DeviceError::BadValue);
        }
        held.send = next;
        held.until = next.saturating_add(credit).min(held.count());
        Ok(())
    }
}

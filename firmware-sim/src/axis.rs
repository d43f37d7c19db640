//! An axis: finite speed, an encoder on the motor, play between motor and arm.

use asperity_core::protocol::{AxisLimits, Fault, Microdegrees};

use crate::clock::Instant;

/// How far beyond the soft limit the end switch is, microdegrees.
const BEYOND: i32 = 1_000_000;

/// Part of a motion: from one encoder position to another.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: i32,
    to: i32,
    start: Instant,
    end: Instant,
}

impl Leg {
    const fn at(position: i32) -> Self {
        Self { from: position, to: position, start: Instant(0), end: Instant(0) }
    }

    fn position(&self, now: Instant) -> i32 {
        let (done, all) = (now.since(self.start), self.end.since(self.start));
        if done >= all {
            return self.to;
        }
        let way = i64::from(self.to) - i64::from(self.from);
        // no overflow: 2^28 microdegrees, 2^25 microseconds
        let part = way.saturating_mul(done as i64) / (all.max(1) as i64);
        self.from.saturating_add(part as i32)
    }
}

/// One axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    limits: AxisLimits,
    /// Play, microdegrees.
    backlash: i32,
    leg: Leg,
    /// Where it goes after the leg: homing has two.
    then: Option<i32>,
    /// Where the arm was when the leg began.
    arm: i32,
    /// What ends the leg.
    fault: Option<Fault>,
}

impl Axis {
    /// At zero; the speed is by the clock of the line.
    pub(crate) const fn new(limits: AxisLimits, backlash: i32) -> Self {
        Self { limits, backlash, leg: Leg::at(0), then: None, arm: 0, fault: None }
    }

    /// Whether a position is within the soft limits.
    pub(crate) fn allows(&self, position: i64) -> bool {
        (i64::from(self.limits.least.0)..=i64::from(self.limits.most.0)).contains(&position)
    }

    /// What the encoder says, microdegrees.
    pub(crate) fn encoder(&self, now: Instant) -> Microdegrees {
        Microdegrees(self.leg.position(now))
    }

    /// Where the arm is, microdegrees: the encoder's position and up to the whole play above it. The
    /// motor pushes the arm upwards; on its way down it lets the play go by first.
    pub(crate) fn arm(&self, now: Instant) -> i32 {
        self.arm_at(self.leg.position(now))
    }

    fn arm_at(&self, encoder: i32) -> i32 {
        self.arm.min(encoder.saturating_add(self.backlash)).max(encoder)
    }

    /// Where the arm will be once the motor is at `encoder`, if it goes there straight.
    pub(crate) fn arm_after(&self, encoder: i32, now: Instant) -> i32 {
        let there = Self { arm: self.arm(now), ..*self };
        there.arm_at(encoder)
    }

    /// Begins a motion, at the earliest at `start`; returns when it ends. With a fault it ends half way.
    pub(crate) fn go(&mut self, to: i32, start: Instant, fault: Option<Fault>) -> Instant {
        let from = self.leg.position(start);
        self.arm = self.arm_at(from);
        let to = if fault.is_some() { from.midpoint(to) } else { to };
        let way = u64::from(from.abs_diff(to));
        let time = (way * 1_000_000).div_ceil(u64::from(self.limits.speed.max(1)));
        self.leg = Leg { from, to, start, end: start.after(time) };
        (self.then, self.fault) = (None, fault);
        self.leg.end
    }

    /// Begins to look for the zero: down to the end switch, then up to 0. Returns when it is there.
    pub(crate) fn home(&mut self, start: Instant, fault: Option<Fault>) -> Instant {
        let switch = self.limits.least.0.saturating_sub(BEYOND);
        let end = self.go(switch, start, fault);
        if fault.is_some() {
            return end;
        }
        self.then = Some(0);
        end.after(
            (u64::from(switch.unsigned_abs()) * 1_000_000)
                .div_ceil(u64::from(self.limits.speed.max(1))),
        )
    }

    /// Goes on with the next leg when the last is over; the fault that has ended it, if any.
    pub(crate) fn advance(&mut self, now: Instant) -> Option<Fault> {
        if now < self.leg.end {
            return None;
        }
        if let Some(to) = self.then.take() {
            self.go(to, self.leg.end, None);
        }
        self.fault.take()
    }

    /// When something happens next.
    pub(crate) fn due(&self) -> Option<Instant> {
        (self.then.is_some() || self.fault.is_some()).then_some(self.leg.end)
    }

    /// Stands still where it is.
    pub(crate) fn halt(&mut self, now: Instant) {
        let here = self.leg.position(now);
        self.arm = self.arm_at(here);
        (self.leg, self.then, self.fault) = (Leg::at(here), None, None);
    }
}

#[cfg(test)]
mod tests {
    use super::Axis;
    use crate::clock::Instant;
    use crate::config::THETA;
    use asperity_core::protocol::{Axis as Name, Fault};

    const SECOND: u64 = 1_000_000;

    fn theta() -> Axis {
        Axis::new(THETA, 50_000)
    }

    #[test]
    fn it_takes_its_time() {
        let mut axis = theta();
        let end = axis.go(40_000_000, Instant(SECOND), None);
        assert_eq!(end, Instant(3 * SECOND));
        assert_eq!(axis.encoder(Instant(0)).0, 0);
        assert_eq!(axis.encoder(Instant(2 * SECOND)).0, 20_000_000);
        assert_eq!(axis.encoder(Instant(9 * SECOND)).0, 40_000_000);
        axis.halt(Instant(2 * SECOND));
        assert_eq!(axis.encoder(Instant(9 * SECOND)).0, 20_000_000);
    }

    #[test]
    fn the_arm_follows_upwards_and_hangs_back_by_the_play_downwards() {
        let mut axis = theta();
        let mut go = |to: i32, at: u64| {
            axis.go(to, Instant(at * SECOND), None);
            axis.arm(Instant((at + 9) * SECOND))
        };
        assert_eq!(go(10_000_000, 0), 10_000_000);
        assert_eq!(go(9_980_000, 10), 10_000_000, "within the play the arm rests");
        assert_eq!(go(5_000_000, 20), 5_050_000);
        assert_eq!(go(5_020_000, 30), 5_050_000, "the play is not yet taken up");
        assert_eq!(go(5_050_000, 40), 5_050_000);
        assert_eq!(go(5_100_000, 50), 5_100_000);
    }

    #[test]
    fn homing_ends_at_zero_from_below() {
        let mut axis = theta();
        axis.go(30_000_000, Instant(0), None);
        axis.go(20_000_000, Instant(5 * SECOND), None);
        let end = axis.home(Instant(10 * SECOND), None);
        // 116 degrees down, 96 up
        assert_eq!(end, Instant(10 * SECOND + 10_600_000));
        let switch = axis.due().unwrap();
        assert_eq!(axis.encoder(switch).0, -96_000_000);
        assert_eq!(axis.advance(switch), None);
        assert_eq!((axis.encoder(end).0, axis.arm(end), axis.due()), (0, 0, None));
    }

    #[test]
    fn a_fault_ends_a_motion_half_way() {
        let mut axis = theta();
        let fault = Fault::AxisStalled(Name::Theta);
        let end = axis.go(40_000_000, Instant(0), Some(fault));
        assert_eq!((end, axis.due()), (Instant(SECOND), Some(Instant(SECOND))));
        assert_eq!(axis.advance(Instant(SECOND - 1)), None);
        assert_eq!(axis.advance(end), Some(fault));
        assert_eq!(axis.encoder(end).0, 20_000_000);
        assert_eq!(axis.advance(end), None);
    }
}

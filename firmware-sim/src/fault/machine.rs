//! Faults of the machine, injected.

use asperity_core::protocol::{Axis, Fault};

/// A fault to be had at the next occasion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineFault {
    /// The next motion of the axis stops half way.
    StalledAxis(Axis),
    /// The next motion of the axis ends half way, at an end switch.
    LimitSwitch(Axis),
    /// The next reading, point or calibration gives the detector too much light.
    OverRange,
    /// The lamp goes out at once.
    LampOff,
}

/// The faults that wait for their occasion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Injected {
    sigma: Option<Fault>,
    theta: Option<Fault>,
    pub(crate) over_range: bool,
    pub(crate) lamp_off: bool,
}

impl Injected {
    pub(crate) const NONE: Self =
        Self { sigma: None, theta: None, over_range: false, lamp_off: false };

    pub(crate) fn add(&mut self, fault: MachineFault) {
        match fault {
            MachineFault::StalledAxis(axis) => *self.of(axis) = Some(Fault::AxisStalled(axis)),
            MachineFault::LimitSwitch(axis) => *self.of(axis) = Some(Fault::LimitSwitch(axis)),
            MachineFault::OverRange => self.over_range = true,
            MachineFault::LampOff => self.lamp_off = true,
        }
    }

    /// What this motion of an axis meets; the one after it meets nothing.
    pub(crate) fn take_for(&mut self, axis: Axis) -> Option<Fault> {
        self.of(axis).take()
    }

    fn of(&mut self, axis: Axis) -> &mut Option<Fault> {
        match axis {
            Axis::Sigma => &mut self.sigma,
            Axis::Theta => &mut self.theta,
        }
    }
}

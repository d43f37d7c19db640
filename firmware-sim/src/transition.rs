//! The states of the instrument: the table of PROTOCOL.md, section 3, as one pure function.

use asperity_core::protocol::{DeviceError, Fault, MachineState};

/// What happens to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// `Home`.
    Home,
    /// `Move`.
    Move,
    /// `Read`, `Calibrate`, `Scan`.
    Measure,
    /// `Aperture`, `Range`, `Integration`, `Lamp`.
    Setting,
    /// `Continue`.
    Continue,
    /// What was begun is finished.
    Done,
    /// `Stop`, or the silence of the owner.
    Stop,
    /// A fault, or `EmergencyStop`.
    Fault(Fault),
    /// `ClearFault`.
    ClearFault,
}

/// The state after `input`. A fault goes with the state `Fault` and with no other.
///
/// # Errors
/// `Busy` or `Faulted`: nothing changes.
pub const fn next(
    state: MachineState,
    fault: Option<Fault>,
    input: Input,
) -> Result<(MachineState, Option<Fault>), DeviceError> {
    use MachineState::{Homing, Idle, Measuring, Moving};
    // the first fault stays
    if let (MachineState::Fault, Some(first)) = (state, fault) {
        return match input {
            Input::Done | Input::Stop | Input::Fault(_) => Ok((state, fault)),
            Input::ClearFault => Ok((Idle, None)),
            _ => Err(DeviceError::Faulted(first)),
        };
    }
    match (state, input) {
        (_, Input::Fault(first)) => Ok((MachineState::Fault, Some(first))),
        (_, Input::Done | Input::Stop)
        | (Idle, Input::Setting | Input::Continue | Input::ClearFault) => Ok((Idle, None)),
        (Idle, Input::Home) => Ok((Homing, None)),
        (Idle, Input::Move) => Ok((Moving, None)),
        (Idle, Input::Measure) | (Measuring, Input::Continue) => Ok((Measuring, None)),
        (busy, _) => Err(DeviceError::Busy(busy)),
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, next};
    use MachineState::{Homing, Idle, Measuring, Moving};
    use asperity_core::protocol::{Axis, DeviceError, Fault, MachineState};

    const FAULTS: [Fault; 7] = [
        Fault::AxisStalled(Axis::Sigma),
        Fault::AxisStalled(Axis::Theta),
        Fault::LimitSwitch(Axis::Sigma),
        Fault::LimitSwitch(Axis::Theta),
        Fault::OverRange,
        Fault::LampFailed,
        Fault::EmergencyStop,
    ];

    /// The table of PROTOCOL.md, written out: rows are states, columns the inputs below.
    #[test]
    fn every_cell_of_the_table() {
        let inputs = [
            Input::Home,
            Input::Move,
            Input::Measure,
            Input::Setting,
            Input::Continue,
            Input::Done,
            Input::Stop,
            Input::ClearFault,
        ];
        let to = |state| Ok((state, None));
        let busy = |state| Err(DeviceError::Busy(state));
        let idle = [
            to(Homing),
            to(Moving),
            to(Measuring),
            to(Idle),
            to(Idle),
            to(Idle),
            to(Idle),
            to(Idle),
        ];
        let working = |state| {
            let e = busy(state);
            let go_on = if state == Measuring { to(Measuring) } else { e };
            [e, e, e, e, go_on, to(Idle), to(Idle), e]
        };
        let rows = [
            (Idle, idle),
            (Homing, working(Homing)),
            (Moving, working(Moving)),
            (Measuring, working(Measuring)),
        ];
        for (state, row) in rows {
            for (input, expected) in inputs.into_iter().zip(row) {
                assert_eq!(next(state, None, input), expected, "{state:?} {input:?}");
            }
            for fault in FAULTS {
                let stopped = Ok((MachineState::Fault, Some(fault)));
                assert_eq!(next(state, None, Input::Fault(fault)), stopped, "{state:?}");
            }
        }
        for first in FAULTS {
            let stays = Ok((MachineState::Fault, Some(first)));
            let refused = Err(DeviceError::Faulted(first));
            let row = [refused, refused, refused, refused, refused, stays, stays, to(Idle)];
            for (input, expected) in inputs.into_iter().zip(row) {
                assert_eq!(next(MachineState::Fault, Some(first), input), expected, "{input:?}");
            }
            for second in FAULTS {
                assert_eq!(next(MachineState::Fault, Some(first), Input::Fault(second)), stays);
            }
        }
    }
}

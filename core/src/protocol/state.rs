//! The identity of an instrument, its state, and its faults.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::reading::{CalibrationKind, Range};
use super::units::{Microdegrees, Text16};

/// An axis of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// Angle of incidence: the sample turns.
    Sigma,
    /// Angle of observation: the detector's arm turns.
    Theta,
}

/// Limits and speed of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisLimits {
    /// Smallest position.
    pub least: Microdegrees,
    /// Largest position.
    pub most: Microdegrees,
    /// Microdegrees per second, > 0.
    pub speed: u32,
}

/// The identity of the instrument. `protocol` comes first in every version, so that a client of another version
/// recognises it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ident {
    /// Version of the messages, [`super::VERSION`].
    pub protocol: u16,
    /// Maker's name of the model.
    pub model: Text16,
    /// Serial number.
    pub serial: u32,
    /// Firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// The sample's axis.
    pub sigma: AxisLimits,
    /// The detector's axis.
    pub theta: AxisLimits,
    /// Most points of one segment.
    pub max_points: u16,
}

/// The state of the instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MachineState {
    /// Nothing; ready.
    Idle,
    /// Finding the zero of both axes.
    Homing,
    /// Going to a position.
    Moving,
    /// Reading, calibrating, or scanning a segment.
    Measuring,
    /// Stopped by a fault; only `ClearFault` leads out.
    Fault,
}

/// Why an instrument stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// An axis does not follow its motor. Clearing it does not bring the zero back: home again.
    AxisStalled(Axis),
    /// An axis ran into its end switch. Home again.
    LimitSwitch(Axis),
    /// The detector received more light than it tolerates.
    OverRange,
    /// The lamp went out.
    LampFailed,
    /// A client requested it. Home again.
    EmergencyStop,
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Sigma => "sigma",
            Self::Theta => "theta",
        })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AxisStalled(axis) => write!(f, "the {axis} axis is stalled"),
            Self::LimitSwitch(axis) => write!(f, "the {axis} axis ran into its end switch"),
            Self::OverRange => f.write_str("the detector was given too much light"),
            Self::LampFailed => f.write_str("the lamp went out"),
            Self::EmergencyStop => f.write_str("emergency stop"),
        }
    }
}

impl fmt::Display for MachineState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Homing => "homing",
            Self::Moving => "moving",
            Self::Measuring => "measuring",
            Self::Fault => "fault",
        })
    }
}

/// A snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The state.
    pub state: MachineState,
    /// Why it stopped; `Some` exactly if `state` is `Fault`.
    pub fault: Option<Fault>,
    /// Whether the zeros of both axes are known.
    pub homed: bool,
    /// Whether the lamp is on.
    pub lamp: bool,
    /// Position of the sample, by its encoder.
    pub sigma: Microdegrees,
    /// Position of the detector, by its encoder.
    pub theta: Microdegrees,
    /// FULL angle of the detector's cone.
    pub aperture: Microdegrees,
    /// The detector's range, as set.
    pub range: Range,
    /// Integration time of a reading, microseconds.
    pub integration_us: u32,
    /// The segment in the memory and the number of its points measured so far.
    pub segment: Option<(u32, u16)>,
    /// Identity of the calibration in force: see [`super::Calibration::id`].
    pub calibration: Option<u32>,
    /// The session that owns the instrument.
    pub owner: Option<u16>,
}

/// Counters for the maintenance of the line and the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diagnostics {
    /// Good frames received since power-on.
    pub frames: u32,
    /// Frames discarded since power-on: cut, corrupted, too long, unknown.
    pub bad_frames: u32,
    /// Bytes of stack used at most since power-on; 0 where that is not known.
    pub stack_bytes: u32,
    /// Milliseconds since power-on.
    pub uptime_ms: u32,
}

/// Why a request was refused. Nothing has moved or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum DeviceError {
    /// Not in this state; wait, or stop first.
    Busy(MachineState),
    /// Not before `ClearFault`.
    Faulted(Fault),
    /// The zeros of the axes are not known: `Home` first.
    NotHomed,
    /// Another session owns the instrument.
    InUse,
    /// This session does not own the instrument: `Claim` first.
    NotOwner,
    /// Beyond the limits of an axis.
    SoftLimit(Axis),
    /// A setting outside its domain.
    BadValue,
    /// The lamp is off.
    LampOff,
    /// Nothing has been read, or calibrated, since power-on or the last change of a setting.
    Nothing,
    /// The requested segment is not the one in the memory.
    NoSegment,
    /// That calibration needs another one first.
    NeedsCalibration(CalibrationKind),
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy(state) => write!(f, "it is busy ({state})"),
            Self::Faulted(fault) => write!(f, "it is stopped by a fault: {fault}"),
            Self::NotHomed => f.write_str("its axes are not homed"),
            Self::InUse => f.write_str("another client is using it"),
            Self::NotOwner => f.write_str("another client took it over, or it was restarted"),
            Self::SoftLimit(axis) => write!(f, "beyond the limits of the {axis} axis"),
            Self::BadValue => f.write_str("a setting is outside its domain"),
            Self::LampOff => f.write_str("its lamp is off"),
            Self::Nothing => f.write_str("it has no such reading"),
            Self::NoSegment => f.write_str("it no longer holds that segment"),
            Self::NeedsCalibration(CalibrationKind::Dark) => {
                f.write_str("it needs a dark calibration first")
            }
            Self::NeedsCalibration(CalibrationKind::Reference) => {
                f.write_str("it needs a reference without the sample first")
            }
        }
    }
}

impl core::error::Error for DeviceError {}

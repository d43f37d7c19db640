//! Readings of the detector.

use serde::{Deserialize, Serialize};

use super::units::Microdegrees;

/// Number of ranges; range `r` measures up to `1000 nA / 10^r`.
pub const RANGES: u8 = 6;

/// The detector's range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Range {
    /// The finest range that holds the signal, found anew for every reading.
    Auto,
    /// Always this one, 0 (coarsest) to [`RANGES`] - 1.
    Fixed(u8),
}

/// One value of the detector, not yet relative to the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Photocurrent, nA, dark current included.
    pub signal: f32,
    /// Dark current of this range by the last dark calibration, nA; 0 before it.
    pub dark: f32,
    /// Range it was read in.
    pub range: u8,
    /// The range was too fine: the signal is cut off and of no use.
    pub over: bool,
    /// A finer range would have held the signal: fewer digits than possible.
    pub under: bool,
}

/// A reading of a segment, with its place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Name of the segment, as its request gave it.
    pub segment: u32,
    /// Which point of the grid, from 0.
    pub index: u16,
    /// Position of the detector by its encoder while the point was read.
    pub theta: Microdegrees,
    /// The reading.
    pub reading: Reading,
}

/// Points `first` to `count - 1` of an even grid of observation angles, at the present incidence.
///
/// The message gives the whole grid even if only its end is wanted: a point is then the same reading whether its
/// segment was scanned in one go or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// A name the client has not used before in this session.
    pub segment: u32,
    /// Observation angle of point 0.
    pub start: Microdegrees,
    /// Distance of neighbours, > 0.
    pub step: Microdegrees,
    /// Number of points of the grid, 1 to [`super::MAX_POINTS`].
    pub count: u16,
    /// First point to be read, < `count`.
    pub first: u16,
    /// Points that the instrument may send before the next request, >= 1.
    pub credit: u16,
}

/// Which calibration run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CalibrationKind {
    /// Shutter closed: the dark current of every range.
    Dark,
    /// Sample withdrawn, detector in the beam: the reading that counts as 1. Needs the dark one first.
    Reference,
}

/// The result of both calibration runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// CRC-32C of the values and of the settings they were taken with: two calibrations with the same identity are equal.
    pub id: u32,
    /// Dark current of every range, nA.
    pub dark: [f32; RANGES as usize],
    /// Photocurrent of the beam without the sample, nA, dark current included.
    pub reference: f32,
    /// Range of the reference.
    pub range: u8,
}

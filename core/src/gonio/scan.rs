//! Readings of one incidence in fixed-size storage.

use super::{AngleGrid, Geometry};
use crate::math::Real;

/// Readings of one angle of incidence: `N` at most, on an even grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan<T, const N: usize> {
    /// Angle of incidence, degrees.
    pub sigma_deg: T,
    /// Side of the detector.
    pub geometry: Geometry,
    /// Angles of observation; `grid.count <= N`.
    pub grid: AngleGrid<T>,
    readings: [T; N],
}

impl<T: Real, const N: usize> Scan<T, N> {
    /// A scan with all readings zero; the grid is cut to `N` angles.
    pub fn new(sigma_deg: T, geometry: Geometry, grid: AngleGrid<T>) -> Self {
        let grid = AngleGrid { count: grid.count.min(N), ..grid };
        Self { sigma_deg, geometry, grid, readings: [T::ZERO; N] }
    }

    /// The readings, in the order of the grid.
    pub fn readings(&self) -> &[T] {
        self.readings.get(..self.grid.count).unwrap_or(&[])
    }

    /// The readings, mutable.
    pub fn readings_mut(&mut self) -> &mut [T] {
        let count = self.grid.count.min(N);
        self.readings.get_mut(..count).unwrap_or(&mut [])
    }
}

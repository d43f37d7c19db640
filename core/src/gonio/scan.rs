//! Readings of one incidence in storage of a fixed capacity.

use heapless::Vec;

use super::{AngleGrid, Geometry};
use crate::math::Real;

/// Readings of one angle of incidence: `N` at most, on an even grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan<T, const N: usize> {
    /// Angle of incidence, degrees.
    pub sigma_deg: T,
    /// Side of the detector.
    pub geometry: Geometry,
    grid: AngleGrid<T>,
    /// As many as the grid has angles.
    readings: Vec<T, N>,
}

impl<T: Real, const N: usize> Scan<T, N> {
    /// A scan with all readings zero; the grid is cut to `N` angles.
    pub fn new(sigma_deg: T, geometry: Geometry, grid: AngleGrid<T>) -> Self {
        let mut readings = Vec::new();
        // never an error: cut to the capacity
        let _ = readings.resize(grid.count.min(N), T::ZERO);
        let grid = AngleGrid { count: readings.len(), ..grid };
        Self { sigma_deg, geometry, grid, readings }
    }

    /// Angles of observation, as many as there are readings.
    pub fn grid(&self) -> &AngleGrid<T> {
        &self.grid
    }

    /// The readings, in the order of the grid.
    pub fn readings(&self) -> &[T] {
        &self.readings
    }

    /// The readings, mutable.
    pub fn readings_mut(&mut self) -> &mut [T] {
        &mut self.readings
    }
}

#[cfg(test)]
mod tests {
    use super::Scan;
    use crate::gonio::{AngleGrid, Geometry};

    #[test]
    fn a_grid_is_cut_to_the_capacity_and_has_a_reading_an_angle() {
        let grid = AngleGrid { start_deg: -1.0, step_deg: 0.5, count: 5 };
        let cut: Scan<f64, 3> = Scan::new(0.0, Geometry::Transmission, grid);
        assert_eq!((cut.grid().count, cut.readings()), (3, &[0.0; 3][..]));
        let mut whole: Scan<f64, 9> = Scan::new(0.0, Geometry::Transmission, grid);
        assert_eq!((whole.grid().count, whole.readings()), (5, &[0.0; 5][..]));
        whole.readings_mut()[4] = 0.25;
        assert_eq!(whole.readings(), [0.0, 0.0, 0.0, 0.0, 0.25]);
    }
}

//! The GP-200, the goniophotometer of the paper: how it measures unless it is told otherwise.
//!
//! Every default of a scan, on the host and in the firmware, is one of these constants.

use super::{AngleGrid, Geometry, Goniophotometer};
use crate::math::Real;

/// Angles of incidence, degrees.
pub const SIGMAS_DEG: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
/// First and last angle of observation, degrees.
pub const THETAS_DEG: [f64; 2] = [-90.0, 90.0];
/// Step of the angle of observation, degrees.
pub const STEP_DEG: f64 = 0.1;
/// Number of angles of observation.
pub const COUNT: usize = 1801;
/// FULL angle of the detector's cone, degrees.
pub const APERTURE_DEG: f64 = 0.6;

impl<T: Real> AngleGrid<T> {
    /// The GP-200's grid: -90 to +90 degrees in steps of 0.1 degree, 1801 angles.
    pub fn gp200() -> Self {
        let [start, _] = THETAS_DEG.map(T::from_f64);
        Self { start_deg: start, step_deg: T::from_f64(STEP_DEG), count: COUNT }
    }
}

impl<T: Real> Goniophotometer<T> {
    /// The GP-200: a cone of 0.6 degrees, full angle, behind the sample.
    pub fn gp200() -> Self {
        Self { aperture_deg: T::from_f64(APERTURE_DEG), geometry: Geometry::Transmission }
    }
}

#[cfg(test)]
mod tests {
    use super::{COUNT, STEP_DEG, THETAS_DEG};
    use crate::gonio::AngleGrid;

    #[test]
    fn the_grid_goes_from_the_first_angle_to_the_last() {
        let grid = AngleGrid::<f64>::gp200();
        let ends = [grid.degrees(0), grid.degrees(COUNT - 1)];
        assert!(ends.iter().zip(THETAS_DEG).all(|(got, end)| (got - end).abs() < 1e-12));
        assert!((grid.degrees(901) - STEP_DEG).abs() < 1e-13);
    }
}

//! Evenly spaced observation angles.

use crate::math::Real;

/// `count` angles in degrees, `step` apart, from `start` upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngleGrid<T> {
    /// First angle, degrees.
    pub start_deg: T,
    /// Distance of neighbours, degrees, > 0.
    pub step_deg: T,
    /// Number of angles.
    pub count: usize,
}

impl<T: Real> AngleGrid<T> {
    /// The `k`-th angle in degrees.
    pub fn degrees(&self, k: usize) -> T {
        // divided, not multiplied, where the step is a decimal fraction: 0.1 has no exact form
        let per_degree = T::ONE / self.step_deg;
        let whole = (per_degree + T::HALF).floor();
        let k = T::from_f64(k as f64);
        let exact = (per_degree - whole).abs() <= whole * T::EPSILON * T::from_f64(4.0);
        self.start_deg + if exact && whole > T::ZERO { k / whole } else { k * self.step_deg }
    }

    /// Indices of the angles within [`from_deg`, `to_deg`]; empty if none.
    pub fn within(&self, from_deg: T, to_deg: T) -> core::ops::Range<usize> {
        let position = |x: T| (x - self.start_deg) / self.step_deg;
        let first = -((-position(from_deg)).floor());
        let last = position(to_deg).floor();
        if !(last >= T::ZERO && last >= first) {
            return 0..0;
        }
        first.to_index().min(self.count)..last.to_index().saturating_add(1).min(self.count)
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::AngleGrid;

    #[test]
    fn the_grid_of_the_gp200_hits_its_decimals() {
        let grid = AngleGrid::<f64>::gp200();
        assert!(
            (grid.degrees(0) - -90.0).abs() < 1e-300 && (grid.degrees(1800) - 90.0).abs() < 1e-12
        );
        assert!((grid.degrees(901) - 0.1).abs() < 1e-13);
    }

    #[test]
    fn a_range_of_angles_is_cut_to_the_grid() {
        let grid = AngleGrid { start_deg: -1.0, step_deg: 0.5, count: 5 };
        assert_eq!(grid.within(-0.6, 0.6), 1..4);
        assert_eq!(grid.within(-9.0, 9.0), 0..5);
        assert_eq!(grid.within(2.0, 9.0), 5..5);
        assert_eq!(grid.within(-9.0, -2.0), 0..0);
        assert_eq!(grid.within(0.1, 0.4), 0..0);
        assert_eq!(grid.within(f64::NAN, 0.4), 0..0);
    }
}

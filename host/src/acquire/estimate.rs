//! Estimates of durations.

use std::time::Duration;

use asperity_core::protocol::{
    AxisLimits, Ident, MAX_POINTS, Microdegrees, RANGES, Text16, VERSION,
};

use super::schedule::{CalibrationRule, Schedule};

/// Settling and the line, for each point; a guess.
const POINT: Duration = Duration::from_millis(5);

/// Limits and speeds of a GP-200 for schedules that no instrument has seen yet: -90 to 90 degrees, 20
/// degrees per second.
pub fn typical() -> Ident {
    let quarter = 90 * Microdegrees::DEGREE;
    let axis = AxisLimits {
        least: Microdegrees(-quarter),
        most: Microdegrees(quarter),
        speed: 20 * Microdegrees::DEGREE as u32,
    };
    Ident {
        protocol: VERSION,
        model: Text16::new("GP-200"),
        serial: 0,
        firmware: [0; 3],
        sigma: axis,
        theta: axis,
        max_points: MAX_POINTS,
    }
}

/// From one position to another at full speed.
pub fn travel(axis: &AxisLimits, from: Microdegrees, to: Microdegrees) -> Duration {
    Duration::from_secs_f64(f64::from(from.0.abs_diff(to.0)) / f64::from(axis.speed.max(1)))
}

/// From one end of an axis to the other.
pub fn whole(axis: &AxisLimits) -> Duration {
    travel(axis, axis.least, axis.most)
}

/// Finding the zeros of both axes: there and back.
pub fn homing(ident: &Ident) -> Duration {
    (whole(&ident.sigma) + whole(&ident.theta)) * 2
}

/// A calibration run: every range once, and the travel of both axes.
pub fn calibration(ident: &Ident, integration_us: u32) -> Duration {
    reading(integration_us) * u32::from(RANGES) + whole(&ident.sigma) + whole(&ident.theta)
}

/// One reading.
pub fn reading(integration_us: u32) -> Duration {
    Duration::from_micros(u64::from(integration_us))
}

/// The next point of a segment.
pub fn point(schedule: &Schedule, ident: &Ident) -> Duration {
    travel(&ident.theta, Microdegrees(0), schedule.step())
        + reading(schedule.integration_us())
        + POINT
}

impl Schedule {
    /// The approximate duration on that instrument, without homing.
    pub fn estimate(&self, ident: &Ident) -> Duration {
        let end = self.theta(self.count().saturating_sub(1));
        let (mut total, mut sigma, mut theta) = (Duration::ZERO, Microdegrees(0), Microdegrees(0));
        for (k, &next) in self.sigmas().iter().enumerate() {
            if k == 0 || self.calibration() == CalibrationRule::PerSigma {
                let zero = Microdegrees(0);
                total += reading(self.integration_us()) * (u32::from(RANGES) + 1);
                total += travel(&ident.theta, theta, zero);
                theta = zero;
            }
            total += travel(&ident.sigma, sigma, next);
            total += travel(&ident.theta, theta, self.run_up(0, ident));
            total += travel(&ident.theta, self.run_up(0, ident), self.theta(0));
            total += point(self, ident) * u32::from(self.count());
            (sigma, theta) = (next, end);
        }
        total
            + travel(&ident.sigma, sigma, Microdegrees(0)).max(travel(
                &ident.theta,
                theta,
                Microdegrees(0),
            ))
    }
}

//! Each surface left out and predicted from the others: what the intervals of the atlas are worth.

use super::region::Region;
use super::table::{Engine, Measure, Solution, solutions};

/// A lobe and what the other surfaces say of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// The lobe; none of its surface's lobes took part in the prediction, nor in the size of its interval.
    pub solution: Solution,
    /// Its true error, %.
    pub error_percent: f64,
    /// The predicted one, %.
    pub predicted_percent: f64,
    /// Factor from it to either end of its interval.
    pub factor: f64,
}

impl LeftOut {
    /// Whether the interval holds the true error.
    pub fn is_held(&self) -> bool {
        (self.error_percent / self.predicted_percent).ln().abs() <= self.factor.ln()
    }
}

/// All lobes, as surfaces other than theirs predict the error of an engine.
pub fn left_out(engine: Engine, measure: Measure) -> Vec<LeftOut> {
    let mut found = Vec::new();
    for region in Region::ALL {
        let Some(course) = region.course(engine, measure) else { continue };
        let points = course.process.points().iter().zip(&course.left_out);
        for (solution, (point, estimate)) in
            solutions().iter().filter(|s| region.holds(s)).zip(points)
        {
            found.push(LeftOut {
                solution: *solution,
                error_percent: point.value.exp(),
                predicted_percent: estimate.value.exp(),
                factor: (course.reach_without(Some(point.group)) * estimate.deviation).exp(),
            });
        }
    }
    found
}

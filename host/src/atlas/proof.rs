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

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::{LeftOut, left_out};
    use crate::atlas::{Engine, Measure};

    /// Share of the lobes that their intervals hold, and the middle of the factors.
    fn score(found: &[LeftOut], is: impl Fn(&LeftOut) -> bool) -> (f64, f64) {
        let of: Vec<&LeftOut> = found.iter().filter(|l| is(l)).collect();
        let mut factors: Vec<f64> = of.iter().map(|l| l.factor).collect();
        factors.sort_by(f64::total_cmp);
        let held = of.iter().filter(|l| l.is_held()).count();
        (held as f64 / of.len() as f64, factors[of.len() / 2])
    }

    #[test]
    fn nine_of_ten_errors_of_left_out_surfaces_are_in_their_intervals() {
        for engine in Engine::ALL {
            for measure in Measure::ALL {
                let found = left_out(engine, measure);
                assert_eq!(found.len(), 504);
                let name = engine.name();
                let (all, factor) = score(&found, |_| true);
                println!("{name} {measure:?}: {:.1} % held, factor {factor:.2}", 100.0 * all);
                assert!(all >= 0.9, "{name} {measure:?} {all}");
                // an interval that holds everything says nothing
                assert!(factor < 2.1, "{name} {measure:?} {factor}");
                for side in [Side::Air, Side::Dielectric] {
                    for lobe in [Lobe::Reflection, Lobe::Transmission] {
                        let is = |l: &LeftOut| (l.solution.side, l.solution.lobe) == (side, lobe);
                        let (share, factor) = score(&found, is);
                        let (large, of_large) = score(&found, |l| is(l) && l.error_percent > 0.1);
                        println!(
                            "    {side:?} {lobe:?}: {:.1} %, factor {factor:.2}; errors above 0.1 %: {:.1} %, {of_large:.2}",
                            100.0 * share,
                            100.0 * large
                        );
                        assert!(
                            share >= 0.88 && factor < 2.6,
                            "{side:?} {lobe:?} {share} {factor}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn intervals_are_not_wide_where_lobes_are_wrong() {
        // the wrong surface's figure would be missed: errors differ by decades over the atlas
        let found = left_out(Engine::Rays, Measure::Reading);
        let shifted = found
            .iter()
            .zip(found.iter().skip(12))
            .map(|(a, b)| (a.error_percent / b.predicted_percent).ln().abs() <= b.factor.ln());
        let held = shifted.filter(|is| *is).count();
        assert!(held < 300, "{held}");
    }
}

//! Points of a profile at equal distances along the arc.

use crate::profile::Profile;
use crate::series::Series;

/// A profile as a curve.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Period in um.
    pub(crate) period: f64,
    /// Heights over x.
    pub(crate) heights: Series,
    /// The stretch of the arc, `sqrt(1 + h'^2)`, over x.
    stretch: Series,
}

/// One point of a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Place along the period, um.
    pub(crate) x: f64,
    /// Height, um.
    pub(crate) z: f64,
    /// Unit normal into the air, x component.
    pub(crate) nx: f64,
    /// Unit normal into the air, z component.
    pub(crate) nz: f64,
    /// Curvature in 1/um, positive where the air is in the hollow.
    pub(crate) curvature: f64,
}

/// Part of the largest amplitude of a series that is below its rounding.
const ROUNDING: f64 = 1e-15;

impl Curve {
    /// `least`: amplitude (um) up to which the last harmonics of the heights are left out. The rounding of heights in a file
    /// would otherwise be waves with a slope and a curvature, which nodes cannot follow.
    pub(crate) fn new(profile: &Profile, least: f64) -> Self {
        let period = profile.period_um();
        let heights =
            Series::new(profile.heights_um(), period, least.max(ROUNDING * profile.height_um()));
        let stretch = stretch_of(&heights, period);
        Self { period, heights, stretch }
    }

    /// Length of the arc over one period, um.
    pub(crate) fn arc(&self) -> f64 {
        self.stretch.harmonics()[0].re * self.period
    }

    /// `count` points at equal distances along the arc, the first at x = 0.
    pub(crate) fn nodes(&self, count: usize) -> Vec<Node> {
        let step = self.arc() / count as f64;
        let mut x = 0.0;
        (0..count)
            .map(|i| {
                if i > 0 {
                    x = self.at_arc(step * i as f64, x + step / self.stretch.at(x).value);
                }
                self.node(x)
            })
            .collect()
    }

    /// The last harmonic of the height over the arc with an amplitude above `least` um.
    pub(crate) fn last_harmonic(&self, least: f64) -> usize {
        let mut count = (4 * self.heights.highest()).next_power_of_two().max(64);
        loop {
            let heights: Vec<f64> = self.nodes(count).iter().map(|node| node.z).collect();
            let last = Series::new(&heights, self.arc(), least).highest();
            if last < count * 3 / 8 || count >= MOST_SAMPLES / 4 {
                return last;
            }
            count *= 2;
        }
    }

    /// Where the arc from x = 0 has the length `length`, by Newton's method from a guess.
    fn at_arc(&self, length: f64, guess: f64) -> f64 {
        let mut x = guess;
        for _ in 0..20 {
            let change = (self.stretch.integral(x) - length) / self.stretch.at(x).value;
            x -= change;
            if change.abs() < 1e-13 * self.period {
                break;
            }
        }
        x
    }

    fn node(&self, x: f64) -> Node {
        let local = self.heights.at(x);
        let stretch = local.slope.hypot(1.0);
        Node {
            x,
            z: local.value,
            nx: -local.slope / stretch,
            nz: 1.0 / stretch,
            curvature: local.second / stretch.powi(3),
        }
    }
}

/// `sqrt(1 + h'^2)`, which is no finite series: sampled ever more finely until its last harmonics are rounding.
fn stretch_of(heights: &Series, period: f64) -> Series {
    let mut count = (4 * heights.highest()).next_power_of_two().max(64);
    loop {
        let at = |i: usize| heights.at(period * i as f64 / count as f64).slope.hypot(1.0);
        let values: Vec<f64> = (0..count).map(at).collect();
        let series = Series::new(&values, period, 1e-14 * values[0]);
        if series.highest() < count * 7 / 16 || count >= MOST_SAMPLES {
            return series;
        }
        count *= 2;
    }
}

/// Samples of the stretch beyond which the profile is taken as it is.
const MOST_SAMPLES: usize = 1 << 14;

#[cfg(test)]
mod tests {
    use super::Curve;
    use crate::profile::Profile;

    #[test]
    fn nodes_are_at_equal_distances_along_the_arc() {
        let heights = (0..64).map(|i| 0.4 * (std::f64::consts::TAU * f64::from(i) / 64.0).sin());
        let curve = Curve::new(&Profile::new(heights.collect(), 2.0).unwrap(), 0.0);
        let nodes = curve.nodes(4000);
        let step = curve.arc() / 4000.0;
        for pair in nodes.windows(2) {
            let chord = (pair[1].x - pair[0].x).hypot(pair[1].z - pair[0].z);
            assert!((chord / step - 1.0).abs() < 1e-5, "{chord} {step}"); // a chord lacks (curvature step)^2 / 24
        }
        assert!((nodes[3999].x + step / 1.6 - 2.0).abs() < 1e-3);
    }
}

//! Interpolation between scattered points by a Gaussian process (kriging), which knows its own doubt.
//!
//! Values are a plane in the coordinates, of which nothing is known beforehand, plus a process with Matérn's correlation
//! `(1 + a + a^2 / 3) exp(-a)`, `a = sqrt(5) r`, `r` the distance in correlation lengths, plus the noise of each point. The variance of the
//! process is the one for which the points, each predicted from those of other groups, miss by as much as they are expected to.

use crate::linear;

/// Coordinates, in correlation lengths.
pub(super) type Place = [f64; 3];

/// Variance of each coefficient of the plane: nothing is known.
const VAGUE: f64 = 100.0;
/// Share of the variance that is not correlated with anything.
const ROUGH: f64 = 1e-3;
/// Steps towards the variance; it is then known to a percent.
const STEPS: usize = 4;

/// A known value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) at: Place,
    pub(super) value: f64,
    /// Variance of its noise.
    pub(super) noise: f64,
    /// Points of one group are left out together.
    pub(super) group: usize,
}

/// A value with its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) deviation: f64,
}

/// The process through its points.
#[derive(Debug)]
pub(super) struct Process {
    points: Vec<Point>,
    variance: f64,
    inverse: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl Process {
    /// `None` without points enough.
    pub(super) fn through(points: Vec<Point>) -> Option<Self> {
        let mut process = Self::with(points, 1.0)?;
        for _ in 0..STEPS {
            let score = process.left_out()?;
            let z = |(p, e): (&Point, &Estimate)| ((p.value - e.value) / e.deviation).powi(2);
            let mean = process.points.iter().zip(&score).map(z).sum::<f64>() / score.len() as f64;
            let variance = (process.variance * mean).clamp(1e-4, 1e4);
            process = Self::with(process.points, variance)?;
        }
        Some(process)
    }

    /// The same without some points, with the variance as it is.
    #[cfg(test)]
    pub(super) fn without(&self, left_out: impl Fn(&Point) -> bool) -> Option<Self> {
        let kept = self.points.iter().copied().filter(|p| !left_out(p)).collect();
        Self::with(kept, self.variance)
    }

    fn with(points: Vec<Point>, variance: f64) -> Option<Self> {
        let entry = |i: usize, j: usize| {
            let own = if i == j { variance * ROUGH + points[i].noise } else { 0.0 };
            variance * correlation(points[i].at, points[j].at)
                + plane(points[i].at, points[j].at)
                + own
        };
        let n = points.len();
        let matrix: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
        let inverse = linear::inverse(&matrix)?;
        let weights = inverse
            .iter()
            .map(|row| row.iter().zip(&points).map(|(a, p)| a * p.value).sum())
            .collect();
        (n > 0).then_some(Self { points, variance, inverse, weights })
    }

    /// The points.
    pub(super) fn points(&self) -> &[Point] {
        &self.points
    }

    /// The value at a place; its deviation grows with the distance from the points, and with their noise.
    pub(super) fn at(&self, place: Place) -> Estimate {
        let shared: Vec<f64> = self
            .points
            .iter()
            .map(|p| self.variance * correlation(p.at, place) + plane(p.at, place))
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let known: f64 =
            self.inverse.iter().zip(&shared).map(|(row, s)| s * dot(row, &shared)).sum();
        let all = self.variance * (1.0 + ROUGH) + plane(place, place);
        let least = self.variance * ROUGH;
        Estimate { value: dot(&self.weights, &shared), deviation: (all - known).max(least).sqrt() }
    }

    /// Each point as the points of all other groups predict it, its noise included.
    pub(super) fn left_out(&self) -> Option<Vec<Estimate>> {
        let mut found = vec![Estimate { value: 0.0, deviation: 0.0 }; self.points.len()];
        let mut groups: Vec<usize> = self.points.iter().map(|p| p.group).collect();
        groups.sort_unstable();
        groups.dedup();
        for group in groups {
            let members: Vec<usize> =
                (0..self.points.len()).filter(|&i| self.points[i].group == group).collect();
            // the inverse of the block of the inverse is the covariance of what the others do not tell
            let block: Vec<Vec<f64>> = members
                .iter()
                .map(|&i| members.iter().map(|&j| self.inverse[i][j]).collect())
                .collect();
            let doubt = linear::inverse(&block)?;
            for (row, &i) in doubt.iter().zip(&members) {
                let missed: f64 = row.iter().zip(&members).map(|(d, &j)| d * self.weights[j]).sum();
                let k = members.iter().position(|&j| j == i)?;
                found[i] =
                    Estimate { value: self.points[i].value - missed, deviation: row[k].sqrt() };
            }
        }
        Some(found)
    }
}

fn correlation(a: Place, b: Place) -> f64 {
    let r2: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let a = (5.0 * r2).sqrt();
    (1.0 + a + a * a / 3.0) * (-a).exp()
}

fn plane(a: Place, b: Place) -> f64 {
    VAGUE * (1.0 + a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::{Estimate, Place, Point, Process};

    fn grid(value: impl Fn(Place) -> f64, noise: impl Fn(Place) -> f64) -> Vec<Point> {
        let place = |k: usize| [0.6 * (k % 6) as f64, 0.6 * (k / 6) as f64, 0.0];
        (0..36)
            .map(|k| {
                let at = place(k);
                Point { at, value: value(at), noise: noise(at), group: k }
            })
            .collect()
    }

    #[test]
    fn a_plane_is_found_everywhere_and_a_wave_between_its_points() {
        let level = Process::through(grid(|[x, y, _]| 2.0 - x + 3.0 * y, |_| 1e-6)).unwrap();
        for place in [[0.3, 0.9, 0.0], [5.0, -2.0, 0.0]] {
            let found = level.at(place);
            let exact = 2.0 - place[0] + 3.0 * place[1];
            assert!((found.value - exact).abs() < 0.05, "{place:?} {found:?}");
        }
        let wave = |[x, y, _]: Place| (1.5 * x).sin() + 0.5 * y;
        let curved = Process::through(grid(wave, |_| 1e-6)).unwrap();
        for place in [[0.3, 0.9, 0.0], [1.7, 2.1, 0.0], [2.5, 0.2, 0.0]] {
            let found = curved.at(place);
            let off = (found.value - wave(place)).abs();
            assert!(off < 3.0 * found.deviation && off < 0.1, "{place:?} {found:?}");
        }
    }

    #[test]
    fn doubt_grows_with_noise_and_distance() {
        let wave = |[x, y, _]: Place| (1.5 * x).sin() + 0.5 * y;
        let quiet = Process::through(grid(wave, |_| 1e-6)).unwrap();
        let noisy = grid(wave, |[x, ..]| if x < 1.0 { 0.5 } else { 1e-6 });
        let noisy = Process::with(noisy, quiet.variance).unwrap();
        let [near, far] = [[0.3, 1.5, 0.0], [2.7, 1.5, 0.0]];
        assert!(noisy.at(near).deviation > 2.0 * quiet.at(near).deviation);
        assert!(noisy.at(far).deviation < 1.2 * quiet.at(far).deviation);
        assert!(quiet.at([4.5, 1.5, 0.0]).deviation > 3.0 * quiet.at(far).deviation);
    }

    #[test]
    fn what_is_left_out_is_as_if_it_had_never_been() {
        let mut points = grid(|[x, y, _]| (1.5 * x).sin() * y, |[x, ..]| 1e-3 * (1.0 + x));
        for p in &mut points {
            p.group /= 3;
        }
        let all = Process::through(points).unwrap();
        let quick = all.left_out().unwrap();
        for group in [0, 5, 11] {
            let rest = all.without(|p| p.group == group).unwrap();
            for (p, Estimate { value, deviation }) in all.points().iter().zip(&quick) {
                if p.group == group {
                    let slow = rest.at(p.at);
                    let noisy = slow.deviation.hypot(p.noise.sqrt());
                    assert!((slow.value - value).abs() < 1e-6, "{slow:?} {value}");
                    assert!((noisy / deviation - 1.0).abs() < 1e-4, "{noisy} {deviation}");
                }
            }
        }
        assert!(Process::through(Vec::new()).is_none());
    }
}

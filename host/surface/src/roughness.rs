//! Roughness figures \[Sokolov eqs 12-17\], slopes and the autocorrelation length.
//!
//! All heights count from the mean of the map; remove a form first if it has one. The "/ i" printed in
//! eq. (14) is a misprint.

use serde::Serialize;

use crate::heightmap::HeightMap;
use crate::ten_point;

/// Figures of a map, um unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Roughness {
    /// Mean of the absolute heights.
    pub ra_um: f64,
    /// Root mean square height.
    pub rq_um: f64,
    /// Depth of the deepest point, >= 0.
    pub rv_um: f64,
    /// Height of the highest point, >= 0.
    pub rp_um: f64,
    /// `Rv + Rp`.
    pub rz_um: f64,
    /// Mean of the five highest points of the map less that of the five deepest: points, as in the paper's table, where
    /// the standard's ten-point height has peaks and valleys of profiles.
    pub rz5_um: f64,
    /// Ten-point height of JIS B 0601: five peaks and five valleys of each sampling length of the profiles; `None` if they
    /// have not so many.
    pub rz_jis_um: Option<f64>,
    /// The sampling length of it: a fifth of a row or column, or the whole.
    pub rz_jis_length_um: Option<f64>,
    /// Skewness, dimensionless; 0 for a flat map.
    pub rsk: f64,
    /// Kurtosis, dimensionless, 3 for Gaussian heights; 0 for a flat map.
    pub rku: f64,
    /// Rms slope between neighbours along x, dimensionless; `None` without neighbours.
    pub rms_slope_x: Option<f64>,
    /// The same along y.
    pub rms_slope_y: Option<f64>,
    /// Lag at which the autocorrelation falls to 1/e, mean of both directions; `None` if it does not.
    pub acl_um: Option<f64>,
    /// Fraction of the points that are missing.
    pub missing_fraction: f64,
}

impl Roughness {
    /// Whether no figure has overflowed: heights of 1e100 um have none.
    pub fn is_finite(&self) -> bool {
        let slopes = [self.rms_slope_x, self.rms_slope_y, self.acl_um];
        let figures = [self.ra_um, self.rq_um, self.rz_um, self.rz5_um, self.rsk, self.rku];
        figures.into_iter().chain(slopes.into_iter().flatten()).all(f64::is_finite)
    }

    /// The figures of a map.
    pub fn of(map: &HeightMap) -> Self {
        let count = map.points().count() as f64;
        let mean = map.points().map(|p| p.2).sum::<f64>() / count;
        let moment = |k: i32| map.points().map(|p| (p.2 - mean).powi(k)).sum::<f64>() / count;
        let variance = moment(2);
        let rq = variance.sqrt();
        let heights = || map.points().map(|p| p.2 - mean);
        let lowest = smallest(heights());
        let highest: Vec<f64> = smallest(heights().map(|h| -h)).iter().map(|h| -h).collect();
        let sum = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let rz5 = sum(&highest) - sum(&lowest);
        let (rv, rp) = (
            0.0 - lowest.iter().copied().fold(0.0, f64::min),
            highest.iter().copied().fold(0.0, f64::max),
        );
        let shape = |k: i32| if rq > 0.0 { moment(k) / rq.powi(k) } else { 0.0 };
        let [rms_slope_x, rms_slope_y] = rms_slopes(map);
        let ten_point = ten_point::of(map);
        let along = [(1, 0, map.dx_um()), (0, 1, map.dy_um())];
        let lags: Vec<f64> = along
            .iter()
            .filter_map(|&(i, j, pitch)| acl(map, mean, variance, (i, j)).map(|l| l * pitch))
            .collect();
        Self {
            ra_um: map.points().map(|p| (p.2 - mean).abs()).sum::<f64>() / count,
            rq_um: rq,
            rv_um: rv,
            rp_um: rp,
            rz_um: rv + rp,
            rz5_um: rz5,
            rz_jis_um: ten_point.map(|t| t.height_um),
            rz_jis_length_um: ten_point.map(|t| t.length_um),
            rsk: shape(3),
            rku: shape(4),
            rms_slope_x,
            rms_slope_y,
            acl_um: (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64),
            missing_fraction: map.missing_fraction(),
        }
    }
}

/// The five smallest values, or all of fewer; without a copy of the map.
fn smallest(values: impl Iterator<Item = f64>) -> Vec<f64> {
    const FIVE: usize = 5;
    let mut found: Vec<f64> = Vec::with_capacity(FIVE + 1);
    for value in values {
        if found.len() == FIVE && found.last().is_some_and(|last| value >= *last) {
            continue;
        }
        found.insert(found.partition_point(|f| *f <= value), value);
        found.truncate(FIVE);
    }
    found
}

/// Pairs of points a step apart, both with a height.
fn pairs(map: &HeightMap, step: (usize, usize)) -> impl Iterator<Item = (f64, f64)> + '_ {
    map.points()
        .filter_map(move |(col, row, h)| Some((h, map.height_um(col + step.0, row + step.1)?)))
}

/// Rms slopes between neighbours along x and y; `None` without neighbours.
pub(super) fn rms_slopes(map: &HeightMap) -> [Option<f64>; 2] {
    [rms_slope(map, (1, 0), map.dx_um()), rms_slope(map, (0, 1), map.dy_um())]
}

fn rms_slope(map: &HeightMap, step: (usize, usize), pitch: f64) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_u64);
    for (a, b) in pairs(map, step) {
        sum += (b - a) * (b - a);
        count += 1;
    }
    (count > 0).then(|| (sum / count as f64).sqrt() / pitch)
}

/// Lines that the autocorrelation is averaged over, at most.
const MOST_LINES: usize = 256;

/// Lag in points at which the normalised autocorrelation crosses 1/e, interpolated between lags that
/// are at most 1/32 apart.
fn acl(map: &HeightMap, mean: f64, variance: f64, along: (usize, usize)) -> Option<f64> {
    if variance <= 0.0 {
        return None;
    }
    let (length, lines) = if along.0 > 0 { (map.nx(), map.ny()) } else { (map.ny(), map.nx()) };
    let at = |k: usize, line: usize| {
        let (col, row) = if along.0 > 0 { (k, line) } else { (line, k) };
        map.height_um(col, row).map(|h| h - mean)
    };
    let level = (-1.0_f64).exp();
    let (mut last_lag, mut last) = (0, 1.0);
    let mut lag = 1;
    while lag < length {
        let (mut sum, mut count) = (0.0, 0_u64);
        for line in (0..lines).step_by(lines.div_ceil(MOST_LINES)) {
            for k in 0..length - lag {
                if let (Some(a), Some(b)) = (at(k, line), at(k + lag, line)) {
                    sum += a * b;
                    count += 1;
                }
            }
        }
        if count == 0 {
            return None;
        }
        let here = sum / count as f64 / variance;
        if here <= level {
            let share = (last - level) / (last - here);
            return Some(last_lag as f64 + share * (lag - last_lag) as f64);
        }
        (last_lag, last) = (lag, here);
        lag += 1 + lag / 32;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::Roughness;
    use crate::HeightMap;

    #[test]
    fn a_sine_has_its_textbook_figures() {
        // amplitude 2 um, 16 whole periods of 32 points along x
        let (nx, ny, a) = (512, 8, 2.0);
        let step = std::f64::consts::TAU / 32.0;
        let heights = (0..nx * ny).map(|k| 7.0 + a * (((k % nx) as f64 + 0.5) * step).sin());
        let map = HeightMap::new((nx, ny), (0.25, 0.5), heights.collect()).unwrap();
        let r = Roughness::of(&map);
        let near = |x: f64, y: f64, t: f64| assert!((x - y).abs() < t, "{x} {y}");
        near(r.rq_um, a / 2.0_f64.sqrt(), 1e-12);
        near(r.ra_um, 2.0 * a / std::f64::consts::PI, 3e-3);
        near(r.rsk, 0.0, 1e-12);
        near(r.rku, 1.5, 1e-12);
        let top = a * (7.5 * step).sin();
        near(r.rp_um, top, 1e-12);
        near(r.rz_um, 2.0 * top, 1e-12);
        near(r.rz5_um, 2.0 * top, 1e-12);
        // slope of the chord: 2 sin(step/2) / dx times the rms of a cosine; edges see no period
        near(r.rms_slope_x.unwrap(), a * 2.0 * (step / 2.0).sin() / 0.25 / 2.0_f64.sqrt(), 3e-3);
        near(r.rms_slope_y.unwrap(), 0.0, 1e-12);
        // cos(2 pi lag / 32) = 1/e at 6.082 points along x, never along y
        near(r.acl_um.unwrap(), 6.082 * 0.25, 0.02);
    }

    #[test]
    fn flat_and_tiny_maps_have_figures_too() {
        for n in [1, 2, 3] {
            let map = HeightMap::new((n, 1), (1.0, 1.0), vec![4.0; n]).unwrap();
            let r = Roughness::of(&map);
            assert!(r.rq_um.abs() < 1e-15 && r.rku.abs() < 1e-15 && r.acl_um.is_none());
            assert_eq!(r.rms_slope_x.is_some(), n > 1);
        }
    }
}

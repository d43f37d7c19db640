//! Areal parameters of ISO 25178-2, of the map as it is: remove a form and filter it before.
//!
//! | parameter | definition |
//! |---|---|
//! | Sa, Sq, Ssk, Sku | mean absolute height about the mean, root mean square, skewness, kurtosis |
//! | Sp, Sv, Sz | highest peak, deepest pit, both together |
//! | Sdq | root mean square gradient |
//! | Sdr | share by which the developed area exceeds that of the projection, % |
//! | Sal | lag of the fastest decay of the autocorrelation to 0.2 |
//! | Str | Sal over the lag of the slowest decay to 0.2; 1 for isotropic surfaces, 0 for grooves |
//!
//! Gradient and area are those of the triangles between neighbouring points, the mean of both ways to cut a cell; cells across the
//! borders of a periodic map do not count. The decay is sought along straight lines from lag 0.

use serde::Serialize;

use crate::autocorrelation::Autocorrelation;
use crate::edges::Edges;
use crate::heightmap::HeightMap;
use crate::roughness::Roughness;

/// The level to which the autocorrelation decays \[ISO 25178-2, default\].
const LEVEL: f64 = 0.2;

/// Areal parameters, um unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Areal {
    /// Arithmetical mean height.
    pub sa_um: f64,
    /// Root mean square height.
    pub sq_um: f64,
    /// Maximum peak height.
    pub sp_um: f64,
    /// Maximum pit height, >= 0.
    pub sv_um: f64,
    /// Maximum height, `Sp + Sv`.
    pub sz_um: f64,
    /// Skewness, dimensionless.
    pub ssk: f64,
    /// Kurtosis, dimensionless.
    pub sku: f64,
    /// Root mean square gradient, dimensionless; `None` without a triangle of points.
    pub sdq: Option<f64>,
    /// Developed interfacial area ratio, %.
    pub sdr_percent: Option<f64>,
    /// Autocorrelation length; `None` if the autocorrelation does not fall to 0.2 within half a side.
    pub sal_um: Option<f64>,
    /// Texture aspect ratio, 0 to 1, dimensionless; `None` if in some direction it does not fall so far.
    pub str: Option<f64>,
    /// Upper bound of Str where it is `None` and Sal is not.
    pub str_at_most: Option<f64>,
}

impl Areal {
    /// The parameters of a map; `heights` are its figures.
    pub fn of(map: &HeightMap, edges: Edges, heights: &Roughness) -> Self {
        let developed = Developed::of(map);
        let fine = Autocorrelation::of(map, edges).map(|a| a.reach(LEVEL));
        // a large map is looked at in squares first: they may be too small
        let undecided = fine.is_some_and(|reach| reach.most_um.is_none());
        let coarse = undecided.then(|| Autocorrelation::coarse(map, edges)).flatten();
        let far = coarse.map(|a| a.reach(LEVEL)).or(fine);
        let sal_um = fine.and_then(|r| r.least_um).or(far.and_then(|r| r.least_um));
        let over = |most: Option<f64>| sal_um.zip(most).map(|(sal, most)| (sal / most).min(1.0));
        let str = over(far.and_then(|r| r.most_um));
        Self {
            sa_um: heights.ra_um,
            sq_um: heights.rq_um,
            sp_um: heights.rp_um,
            sv_um: heights.rv_um,
            sz_um: heights.rz_um,
            ssk: heights.rsk,
            sku: heights.rku,
            sdq: developed.map(|d| d.mean_square_gradient.sqrt()),
            sdr_percent: developed.map(|d| 100.0 * d.excess),
            sal_um,
            str,
            str_at_most: if str.is_none() { over(far.map(|r| r.seen_um)) } else { None },
        }
    }
}

/// Means over the triangles between neighbouring points.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Developed {
    mean_square_gradient: f64,
    /// Area over that of the projection, less 1.
    excess: f64,
}

impl Developed {
    /// `None` if no three neighbours have heights.
    fn of(map: &HeightMap) -> Option<Self> {
        let (mut squares, mut excess, mut count) = (0.0, 0.0, 0_u64);
        for row in 0..map.ny().saturating_sub(1) {
            for col in 0..map.nx().saturating_sub(1) {
                let at = |i: usize, j: usize| map.height_um(col + i, row + j);
                let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
                // the corner with the right angle, and its neighbours along x and along y
                for (corner, x, y) in [(a, b, c), (b, a, d), (c, d, a), (d, c, b)] {
                    let (Some(corner), Some(x), Some(y)) = (corner, x, y) else { continue };
                    let square =
                        ((x - corner) / map.dx_um()).powi(2) + ((y - corner) / map.dy_um()).powi(2);
                    squares += square;
                    // sqrt(1 + s) - 1 without cancellation
                    excess += square / (1.0 + (1.0 + square).sqrt());
                    count += 1;
                }
            }
        }
        let mean = |sum: f64| sum / count as f64;
        (count > 0).then(|| Self { mean_square_gradient: mean(squares), excess: mean(excess) })
    }
}

#[cfg(test)]
mod tests {
    use super::Areal;
    use crate::synthetic::stretched;
    use crate::{Edges, Form, HeightMap, Roughness};

    fn areal(map: &HeightMap, edges: Edges) -> Areal {
        Areal::of(map, edges, &Roughness::of(map))
    }

    fn near(found: f64, exact: f64, share: f64) {
        assert!((found / exact - 1.0).abs() < share, "{found} is not {exact}");
    }

    fn map(
        size: (usize, usize),
        pitches: (f64, f64),
        height: impl Fn(f64, f64) -> f64,
    ) -> HeightMap {
        let at =
            |k: usize| height((k % size.0) as f64 * pitches.0, (k / size.0) as f64 * pitches.1);
        HeightMap::new(size, pitches, (0..size.0 * size.1).map(at).collect()).unwrap()
    }

    #[test]
    fn a_sinusoid_has_its_closed_forms() {
        let (a, k) = (0.8, std::f64::consts::TAU / 16.0);
        let wave = map((640, 128), (0.05, 0.2), |x, _| a * (k * x).sin());
        let found = areal(&wave, Edges::Periodic);
        near(found.sa_um, 2.0 * a / std::f64::consts::PI, 1e-4);
        near(found.sq_um, a / 2.0_f64.sqrt(), 1e-9);
        near(found.sz_um, 2.0 * a, 1e-3);
        near(found.sku, 1.5, 1e-6);
        near(found.sdq.unwrap(), a * k / 2.0_f64.sqrt(), 2e-3);
        // mean of sqrt(1 + (a k cos)^2) - 1 over a period, by another rule
        let steps = 10_000;
        let slope =
            |i: i32| a * k * (f64::from(i) * std::f64::consts::TAU / f64::from(steps)).cos();
        let mean: f64 =
            (0..steps).map(|i| slope(i).hypot(1.0) - 1.0).sum::<f64>() / f64::from(steps);
        near(found.sdr_percent.unwrap(), 100.0 * mean, 4e-3);
        // cos(k lag) = 0.2 across the grooves; along them it never falls
        near(found.sal_um.unwrap(), 0.2_f64.acos() / k, 1e-3);
        assert_eq!(found.str, None);
        let along = 64.0 * 0.2;
        assert!(found.str_at_most.unwrap() <= found.sal_um.unwrap() / along * 1.02, "{found:?}");
    }

    #[test]
    fn crossed_waves_have_an_aspect_in_closed_form() {
        // (cos kx + cos ky) / 2 = 0.2: cos = -0.6 along an axis, cos = 0.2 along the diagonal
        let k = std::f64::consts::TAU / 32.0;
        let waves = map((256, 256), (1.0, 1.0), |x, y| (k * x).sin() + (k * y).sin());
        let found = areal(&waves, Edges::Periodic);
        let diagonal = 2.0_f64.sqrt() * 0.2_f64.acos() / k;
        near(found.sal_um.unwrap(), diagonal, 5e-3);
        near(found.str.unwrap(), diagonal / ((-0.6_f64).acos() / k), 5e-3);
        assert_eq!(found.str_at_most, None);
    }

    #[test]
    fn a_gaussian_surface_has_the_figures_of_its_correlation() {
        let (dx, dy) = (0.3, 0.3);
        let surface = stretched((512, 512), (dx, dy), (5.0, 5.0), 4);
        let found = areal(&surface, Edges::Periodic);
        let l = 5.0 * dx;
        // the least over all directions: a few per cent below, by the grain of 10 000 patches
        near(found.sal_um.unwrap(), l * 5.0_f64.ln().sqrt(), 0.06);
        assert!(found.str.unwrap() > 0.85, "{found:?}");
        // chords of a pitch: 2 (1 - exp(-(d/l)^2)) / d^2 along each direction
        let square = -2.0 * (-(dx / l).powi(2)).exp_m1() / (dx * dx);
        near(found.sdq.unwrap(), (2.0 * square).sqrt(), 0.02);
        // Gaussian slopes: u = |gradient|^2 / s^2 has the density exp(-u/2) / 2
        let steps = 200_000;
        let sum: f64 = (0..steps)
            .map(|i| 40.0 * (f64::from(i) + 0.5) / f64::from(steps))
            .map(|u| ((1.0 + square * u).sqrt() - 1.0) * (-0.5 * u).exp() / 2.0)
            .sum();
        near(found.sdr_percent.unwrap(), 100.0 * sum * 40.0 / f64::from(steps), 0.04);
        let long = areal(&stretched((512, 512), (dx, dy), (6.0, 24.0), 4), Edges::Mirrored);
        assert!((long.str.unwrap() - 0.25).abs() < 0.03, "{long:?}");
    }

    #[test]
    fn a_tilted_plane_counts_until_it_is_levelled() {
        let plane = map((40, 30), (0.5, 0.7), |x, y| 0.3 * x - 0.4 * y);
        let found = areal(&plane, Edges::Mirrored);
        near(found.sdq.unwrap(), 0.5, 1e-12);
        near(found.sdr_percent.unwrap(), 100.0 * (1.25_f64.sqrt() - 1.0), 1e-12);
        let levelled = areal(&Form::Plane.removed(&plane), Edges::Mirrored);
        assert!(levelled.sdq.unwrap() < 1e-12 && levelled.sq_um < 1e-12, "{levelled:?}");
    }

    #[test]
    fn the_developed_area_is_that_of_the_triangles() {
        let mut heights: Vec<f64> = (0..12).map(|k| (f64::from(k) * 2.3).sin()).collect();
        heights[6] = f64::NAN;
        let map = HeightMap::new((4, 3), (0.5, 0.8), heights).unwrap();
        let point =
            |i: usize, j: usize| Some([0.5 * i as f64, 0.8 * j as f64, map.height_um(i, j)?]);
        let (mut area, mut flat) = (0.0, 0.0);
        for j in 0..2 {
            for i in 0..3 {
                let corners = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                for k in 0..4 {
                    let [p, q, r] = [corners[k], corners[(k + 1) % 4], corners[(k + 3) % 4]];
                    let (Some(p), Some(q), Some(r)) = (p, q, r) else { continue };
                    let (u, v) = ([0, 1, 2].map(|n| q[n] - p[n]), [0, 1, 2].map(|n| r[n] - p[n]));
                    let cross = [
                        u[1] * v[2] - u[2] * v[1],
                        u[2] * v[0] - u[0] * v[2],
                        u[0] * v[1] - u[1] * v[0],
                    ];
                    area += cross.iter().map(|c| c * c).sum::<f64>().sqrt();
                    flat += 0.5 * 0.8;
                }
            }
        }
        near(areal(&map, Edges::Mirrored).sdr_percent.unwrap(), 100.0 * (area / flat - 1.0), 1e-12);
    }

    #[test]
    fn flat_and_tiny_maps_have_what_they_can() {
        for size in [(1, 1), (3, 1), (3, 3)] {
            let found = areal(&map(size, (1.0, 1.0), |_, _| 4.0), Edges::Periodic);
            assert_eq!((found.sal_um, found.str, found.str_at_most), (None, None, None));
            assert_eq!(found.sdr_percent, (size.1 > 1).then_some(0.0));
        }
    }
}

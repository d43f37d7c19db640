//! An angular law as a microfacet density with the masking of Smith: `D = F / K`, of projected area 1.
//!
//! `F(theta)` is the law of `super::law`, cut off at 90 degrees, and `K = 2 pi integral of F sin cos`. The mean excess of
//! the slope along a direction comes from a table made by quadrature:
//! `L(mu) = integral over slopes s > mu of (sqrt(s^2 - mu^2) - mu acos(mu / s)) / pi`, weighted by projected area.

use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use super::density::Density;
use super::form::Form;
use super::law::Law;
use super::quantile::{Measure, each_panel, quantile_table, table_value};
use crate::math::Real;
use crate::quadrature::{EIGHT_POINTS, hermite};
use crate::sampling::inverse_smoothstep;

/// Cells of the table of the excess.
const CELLS: usize = 96;

/// The density of an angular law, with `N` nodes of its table of quantiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmithNormals<T, const N: usize = 256> {
    law: Law<T>,
    form: Form<T>,
    /// `1 / K`, 1/sr.
    inverse_norm: T,
    /// `sin^2 theta` and its slope at the nodes.
    quantiles: [[f64; 2]; N],
    /// `L` and its slope at even nodes of `x = mu / (mu + warp)` in [0, 1], and 0 at 1.
    excess: [[f64; 2]; CELLS],
    /// The same at 1.
    last: [f64; 2],
    warp: f64,
    slope: T,
}

impl<T: Real, const N: usize> SmithNormals<T, N> {
    /// Facets of a law whose variable is the polar angle of the normal, in radians.
    pub fn new(law: Law<T>) -> Self {
        const { assert!(N >= 4, "a table of quantiles needs four nodes at least") };
        let wide: Law<f64> = law.cast();
        let total = Measure::ProjectedArea.total(&wide);
        let quantiles = quantile_table::<N>(&wide, Measure::ProjectedArea, total);
        let warp = tangent(table_value(&quantiles, 0.5));
        let excess = core::array::from_fn(|k| {
            let x = k as f64 / CELLS as f64;
            let mu = warp * x / (1.0 - x);
            let [value, beyond] = excess(&wide, total, mu);
            [value, -beyond * warp / ((1.0 - x) * (1.0 - x))]
        });
        // L = pi D(90 deg) / (4 mu) far out
        let end = wide.value(FRAC_PI_2) / (2.0 * PI * total);
        Self {
            law,
            form: Form::of(&wide),
            inverse_norm: T::from_f64(0.5 / (PI * total)),
            quantiles,
            excess,
            last: [0.0, -0.25 * PI * end / warp],
            warp,
            slope: T::from_f64(warp),
        }
    }

    /// The law.
    pub fn law(&self) -> &Law<T> {
        &self.law
    }
}

impl<T: Real, const N: usize> Density<T> for SmithNormals<T, N> {
    type In<U: Real> = SmithNormals<U, N>;

    #[inline]
    fn d(&self, xy2: T, z2: T, in_two: impl FnOnce() -> [[T; 2]; 2]) -> T {
        self.form.value(&self.law, xy2, z2, in_two) * self.inverse_norm
    }

    fn excess(&self, mu: f64) -> f64 {
        let position = mu / (mu + self.warp) * CELLS as f64;
        let k = position.to_index();
        let Some(&a) = self.excess.get(k) else { return 0.0 };
        let b = *self.excess.get(k + 1).unwrap_or(&self.last);
        Real::max(hermite(position - k as f64, 1.0 / CELLS as f64, a, b), 0.0)
    }

    fn steeper(&self, slope: f64) -> f64 {
        let square = slope * slope;
        let wanted = if square.is_finite() { square / (1.0 + square) } else { 1.0 };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..48 {
            let x = 0.5 * (low + high);
            if table_value(&self.quantiles, x) < wanted { low = x } else { high = x }
        }
        let rest = 1.0 - 0.5 * (low + high);
        // the last node stands for the steepest facets that count
        if high < 1.0 { rest * rest * (3.0 - 2.0 * rest) } else { 0.0 }
    }

    fn slope_above(&self, share: f64) -> f64 {
        tangent(table_value(&self.quantiles, 1.0 - inverse_smoothstep(share)))
    }

    fn slope(&self) -> T {
        self.slope
    }

    fn cast<U: Real>(&self) -> SmithNormals<U, N> {
        SmithNormals::new(self.law.cast())
    }
}

/// The tangent of an angle from the square of its sine.
fn tangent(sin2: f64) -> f64 {
    Real::sqrt(sin2 / Real::max(1.0 - sin2, 1e-30))
}

/// `L(mu)` and the share of slopes along a direction beyond `mu`, `-L'`, by quadrature over the polar angle.
fn excess(law: &Law<f64>, total: f64, mu: f64) -> [f64; 2] {
    let start = Real::atan2(mu, 1.0);
    let mut sums = [0.0; 2];
    each_panel(law, |a, b| {
        if b <= start {
            return;
        }
        let first = Real::max(a, start);
        for (x, weight) in EIGHT_POINTS {
            // near the angle where facets begin to be steeper both integrands have a root
            let (theta, width) = if a < start {
                (first + (b - first) * x * x, 2.0 * x * (b - first))
            } else {
                (a + (b - a) * x, b - a)
            };
            let (s, c) = Real::sin_cos(theta);
            let per = weight * width * law.value(theta) * s / total * FRAC_1_PI;
            let angle = Real::acos(Real::min(mu * c / s, 1.0));
            let root = Real::sqrt_positive((s - mu * c) * (s + mu * c));
            sums[0] += per * (root - mu * c * angle);
            sums[1] += per * c * angle;
        }
    });
    sums
}

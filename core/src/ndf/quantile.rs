//! Quantiles of the facet normals of an angular law.

use core::f64::consts::FRAC_PI_2;

use super::law::Law;
use crate::math::Real;
use crate::quadrature::{EIGHT_POINTS, hermite, monotone_slope};

/// Share of the normals that is cut off at either end of the table of quantiles.
const NO_ACCOUNT: f64 = 1e-9;

/// Hermite interpolation of the quantile table at `x` in [0, 1].
#[inline]
pub(super) fn table_value<T: Real, const N: usize>(table: &[[T; 2]; N], x: T) -> T {
    let cells = T::from_f64((N - 1) as f64);
    let position = x * cells;
    let k = position.to_index().min(N - 2);
    match (table.get(k), table.get(k + 1)) {
        (Some(&a), Some(&b)) => {
            let s = (position - T::from_f64(k as f64)).max(T::ZERO).min(T::ONE);
            hermite(s, T::ONE / cells, a, b).max(T::ZERO).min(T::ONE)
        }
        _ => T::ZERO,
    }
}

/// Calls `visit(a, b)` for panels that cover [0, pi/2] in order and are graded about the centre of the
/// law: geometric, and finer near one width away, where a large exponent makes an edge.
pub(super) fn each_panel(law: &Law<f64>, mut visit: impl FnMut(f64, f64)) {
    let (centre, delta, n) = (law.centre(), law.delta(), law.n());
    let least = 1e-6 * delta;
    let fine = 1.0 + Real::min(0.25, 4.0 / n);
    let ratio = |y: f64| if y > 0.25 * delta && y < 8.0 * delta { fine } else { 1.5 };
    let mut y = centre;
    while y > least {
        let next = y / ratio(y);
        visit(centre - y, if next > least { centre - next } else { centre });
        y = next;
    }
    let most = FRAC_PI_2 - centre;
    let mut y = 0.0;
    while y < most {
        let next = if y > 0.0 { y * ratio(y) } else { least };
        let end = if next < most { next } else { most };
        visit(centre + y, centre + end);
        y = next;
    }
}

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// The number of facets: `F sin theta`. Quantiles are those of `t = 1 - cos theta`.
    Number,
    /// Their projected area: `F sin theta cos theta`. Quantiles are those of `t = sin^2 theta`.
    #[cfg(feature = "microfacet")]
    ProjectedArea,
}

impl Measure {
    /// Its integral over [0, pi/2].
    pub(super) fn total(self, law: &Law<f64>) -> f64 {
        let mut total = 0.0;
        each_panel(law, |a, b| total += self.mass(law, (a, b)));
        total
    }

    /// Its integral over [a, b] by eight points.
    fn mass(self, law: &Law<f64>, (a, b): (f64, f64)) -> f64 {
        let sum: f64 =
            EIGHT_POINTS.iter().map(|&(x, w)| w * self.density(law, a + x * (b - a))).sum();
        sum * (b - a)
    }

    /// Per angle.
    fn density(self, law: &Law<f64>, theta: f64) -> f64 {
        match self {
            Self::Number => law.value(theta) * Real::sin_cos(theta).0,
            #[cfg(feature = "microfacet")]
            Self::ProjectedArea => {
                let (s, c) = Real::sin_cos(theta);
                law.value(theta) * s * c
            }
        }
    }

    /// The variable of the quantiles at an angle, and its slope over the integral of the measure, times `F`.
    fn variable(self, theta: f64) -> [f64; 2] {
        match self {
            Self::Number => {
                let half = Real::sin_cos(0.5 * theta).0;
                [2.0 * half * half, 1.0]
            }
            #[cfg(feature = "microfacet")]
            Self::ProjectedArea => {
                let s = Real::sin_cos(theta).0;
                [s * s, 2.0]
            }
        }
    }
}

/// Quantiles of the variable `t` of a measure and their slopes `dt/dx`, at nodes `x_k = k / (N - 1)` of the share
/// `u = 3 x^2 - 2 x^3`.
pub(super) fn quantile_table<const N: usize>(
    law: &Law<f64>,
    measure: Measure,
    total: f64,
) -> [[f64; 2]; N] {
    let mut table = [[1.0, 0.0]; N];
    let node = |k: usize| k as f64 / (N - 1) as f64;
    // A tail of no account is cut off, or the outermost cell would spread over all angles beyond.
    let least = if law.centre() > 0.0 { NO_ACCOUNT } else { 0.0 };
    let (mut below, mut k) = (0.0, 0);
    each_panel(law, |a, b| {
        let mass = measure.mass(law, (a, b)) / total;
        while k < N {
            let x = node(k);
            let u = Real::min(Real::max(x * x * (3.0 - 2.0 * x), least), 1.0 - NO_ACCOUNT);
            let target = u - below;
            if target > mass {
                break;
            }
            let theta = invert_panel(law, measure, total, (a, b), mass, target);
            let [t, dt] = measure.variable(theta);
            if let Some(row) = table.get_mut(k) {
                // du/dt = F / total, du/dx = 6 x (1 - x)
                *row = [t, dt * 6.0 * x * (1.0 - x) * total / law.value(theta)];
            }
            k += 1;
        }
        below += mass;
    });
    limit_slopes(&mut table);
    table
}

/// The angle in the panel below which a share `target` of all normals lies, counted from its start.
fn invert_panel(
    law: &Law<f64>,
    measure: Measure,
    total: f64,
    (a, b): (f64, f64),
    mass: f64,
    target: f64,
) -> f64 {
    let h = b - a;
    let (da, db) = (measure.density(law, a) / total, measure.density(law, b) / total);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let s = 0.5 * (low + high);
        if hermite(s, h, [0.0, da], [mass, db]) < target { low = s } else { high = s }
    }
    let mut theta = a + 0.5 * (low + high) * h;
    for _ in 0..2 {
        let density = measure.density(law, theta) / total;
        let step = (measure.mass(law, (a, theta)) / total - target) / density;
        if step.is_finite() {
            theta = Real::min(Real::max(theta - step, a), b);
        }
    }
    theta
}

/// Makes the table monotone between its nodes.
fn limit_slopes<const N: usize>(table: &mut [[f64; 2]; N]) {
    let cells = (N - 1) as f64;
    let values = table.map(|row| row[0]);
    for (k, row) in table.iter_mut().enumerate() {
        let here = row[0];
        let left = k.checked_sub(1).and_then(|j| values.get(j));
        let right = values.get(k + 1);
        let secant = |other: Option<&f64>| other.map(|v| (v - here).abs() * cells);
        let (l, r) = (secant(left), secant(right));
        row[1] = monotone_slope(row[1], l.or(r).unwrap_or(0.0), r.or(l).unwrap_or(0.0));
    }
}

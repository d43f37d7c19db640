//! The share of the facet normals that face a direction; drawing again divides by it.
//!
//! A normal at `theta` faces a direction of elevation `e` for all azimuths if `theta < e`, else for a
//! share `1 - acos(tan e / tan theta) / pi` of them.

use core::f64::consts::PI;

use crate::math::Real;
use crate::quadrature::gauss_legendre;

/// Cells of the table.
const CELLS: usize = 32;
/// Panels of the integral for each of its nodes.
const PANELS: usize = 24;

/// A cubic in each of even cells of `x = tan e / (tan e + warp)`, where `e` is the elevation above the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VisibleShare<T> {
    /// Coefficients of the powers of the distance from the cell's start, in cells.
    cells: [[T; 4]; CELLS],
    /// The tangent of the median normal.
    warp: T,
}

impl<T: Real> VisibleShare<T> {
    /// From the tangents of the normals' polar angles at the nodes `x` in [0, 1] of their table of quantiles,
    /// below which a share `3 x^2 - 2 x^3` lies.
    #[inline(never)]
    pub(super) fn new(slope: impl Fn(f64) -> f64) -> Self {
        let warp = slope(0.5);
        let value = |j: usize| match j {
            0 => 0.5,
            CELLS.. => 1.0,
            _ => {
                let x = j as f64 / CELLS as f64;
                1.0 - hidden(&slope, warp * x / (1.0 - x))
            }
        };
        let between = |left: f64, right: f64| {
            // harmonic mean: between the secants, zero if either is
            if left > 0.0 && right > 0.0 { 2.0 * left * right / (left + right) } else { 0.0 }
        };
        // values at the two ends of a cell, and the slope at its start
        let (mut v, mut start) = ([value(0), value(1)], 0.0);
        let cells = core::array::from_fn(|j| {
            let secant = v[1] - v[0];
            if j == 0 {
                start = Real::max(secant, 0.0);
            }
            let next = value(j + 2);
            let end = if j + 1 < CELLS { between(secant, next - v[1]) } else { 0.0 };
            let cubic = [v[0], start, 3.0 * secant - 2.0 * start - end, start + end - 2.0 * secant];
            (v, start) = ([v[1], next], end);
            cubic.map(T::from_f64)
        });
        Self { cells, warp: T::from_f64(warp) }
    }

    /// The share for a direction of given `|cos theta|` and `sin theta`, not both 0: 1/2 to 1.
    #[inline(always)]
    pub(super) fn of(&self, cos: T, sin: T) -> T {
        // a little less than there are cells: the last one ends at 1
        let position = cos * T::from_f64(CELLS as f64 * (1.0 - 1e-6)) / (cos + self.warp * sin);
        let k = position.to_index();
        let s = position - T::from_f64(k as f64);
        let Some(&[c0, c1, c2, c3]) = self.cells.get(k % CELLS) else { return T::ONE };
        c0 + s * (c1 + s * (c2 + s * c3))
    }
}

/// The share of the normals that do not face a direction whose elevation has this tangent.
fn hidden(slope: &impl Fn(f64) -> f64, tan_e: f64) -> f64 {
    // where in the table normals begin to be steeper than the direction
    let (mut x, mut end) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (x + end);
        if slope(middle) < tan_e { x = middle } else { end = middle }
    }
    let (rule, mut hidden) = (gauss_legendre::<4>(), 0.0);
    for p in 0..PANELS {
        for (node, weight) in rule {
            // v squared grades the panels towards the start, where the integrand has a root
            let v = (p as f64 + node) / PANELS as f64;
            let xv = x + (1.0 - x) * v * v;
            let ratio = tan_e / slope(xv);
            let du = 6.0 * xv * (1.0 - xv) * (1.0 - x) * 2.0 * v * weight / PANELS as f64;
            if ratio < 1.0 {
                hidden += Real::acos(ratio) / PI * du;
            }
        }
    }
    hidden
}

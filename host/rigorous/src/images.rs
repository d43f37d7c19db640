//! The Green's function of a periodic problem less its nearest source, as a table.
//!
//! Sources at x = 0, +-d, +-2d ... in phase. Those at -(M+1)d, -(M+2)d ... add up to
//! `exp(i k x) A(x, z)`, and those on the other side to the mirror image of that. With the integral over the steepest descent
//! of each source,
//! `A = 1/pi int_0^inf q^(M+1) / (1 - q) exp(-k s^2 x) cos(k z s r) / r ds`, `r = sqrt(s^2 - 2i)`,
//! `q = exp(i k d - k d s^2)`
//! (C. M. Linton, *The Green's function for the two-dimensional Helmholtz equation in periodic domains*, J. Eng. Math. 33 (1998)
//! 377, section 2.6). The integrand is even and smooth, and the trapezoidal rule converges exponentially. A varies slowly and is
//! interpolated. M = 0 unless the grooves are deep in comparison to the period.

use std::f64::consts::{FRAC_1_PI, PI};

use multiversion::multiversion;
use num_complex::Complex64;

use crate::bessel::Table as BesselTable;
use crate::stage::{Stopped, Tally};

/// Points of a stencil in one direction.
const STENCIL: usize = 8;
/// A: value, derivative along x of `exp(i k x) A` without the exponential, derivative along z; each a real and
/// an imaginary part; two zeros that fill a vector register.
type Entry = [f64; 8];

/// A value and its derivatives along x and z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field {
    pub(crate) value: Complex64,
    pub(crate) along_x: Complex64,
    pub(crate) along_z: Complex64,
}

/// All sources but the nearest, for |x| up to half a period and |z| up to a height.
#[derive(Debug)]
pub(crate) struct Images {
    wavenumber: f64,
    /// Steps of the grid, um.
    step_x: f64,
    step_z: f64,
    /// Points along x; the middle one is x = 0.
    columns: usize,
    /// Row after row of equal z, the first at `-MARGIN` steps.
    entries: Vec<Entry>,
}

/// Points beyond the range on each side, so that every stencil is centred.
const MARGIN: usize = STENCIL / 2;
/// Steps of half a period.
const HALF: usize = 32;
/// Phase along z of one step, rad.
const PHASE: f64 = 0.15;
/// The exponent at which a term is below rounding.
const ROUNDING: f64 = 42.0;
/// The exponent to which the integral is right.
const TRAPEZOID: f64 = 28.0;
/// The exponent by which terms may exceed their sum.
const EXCESS: f64 = 6.0;

impl Images {
    /// `wavenumber` in the medium (1/um), `period` and the largest difference of heights `height` in um.
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub(crate) fn new(
        wavenumber: f64,
        period: f64,
        height: f64,
        tally: &Tally<'_>,
    ) -> Result<Self, Stopped> {
        let direct =
            (wavenumber * height * height / (4.0 * EXCESS * period) - 0.5).ceil().max(0.0) as usize;
        let near = 0.5 * period; // distance of the nearest source of the table
        let angle = (height / near).atan();
        let steps = (near * wavenumber * (1.0 - angle.cos()) / (2.0 * PHASE)).ceil() as usize;
        let half = steps.max(HALF);
        let step_x = near / half as f64;
        let step_z = PHASE / (wavenumber * angle.sin() + (wavenumber / near).sqrt());
        let columns = 2 * (half + MARGIN) + 1;
        let rows = (height / step_z).ceil() as usize + 2 * MARGIN + 1;
        let mut images =
            Self { wavenumber, step_x, step_z, columns, entries: vec![[0.0; 8]; columns * rows] };
        images.add_far(period, height, direct, tally)?;
        for source in 1..=direct {
            images.add_source(source as f64 * period, tally)?;
        }
        Ok(images)
    }

    fn x(&self, column: usize) -> f64 {
        (column as f64 - (self.columns / 2) as f64) * self.step_x
    }

    fn z(&self, row: usize) -> f64 {
        (row as f64 - MARGIN as f64) * self.step_z
    }

    /// Adds the sources beyond the first `direct` ones.
    fn add_far(
        &mut self,
        period: f64,
        height: f64,
        direct: usize,
        tally: &Tally<'_>,
    ) -> Result<(), Stopped> {
        let k = self.wavenumber;
        let nearest = (direct as f64 + 0.5) * period - (MARGIN + 1) as f64 * self.step_x;
        let end = (ROUNDING / (k * nearest)).sqrt() + height / nearest;
        // off the real axis by b, less than to the nearest pole, the terms grow by exp(k nearest b^2 + k height b); the
        // trapezoidal rule is right to that times exp(-2 pi b / step)
        let orders = k * period / (2.0 * PI);
        let off = (1.0 - orders.floor() / orders).min(orders.ceil() / orders - 1.0);
        let b = (0.5 * off).sqrt().min((TRAPEZOID / (k * nearest)).sqrt()).min(0.5);
        let step = 2.0 * PI * b / (TRAPEZOID + k * nearest * b * b + k * height * b);
        let count = (end / step).ceil() as usize;
        let rows = self.entries.len() / self.columns;
        let mut decay = vec![0.0; self.columns];
        for n in 0..=count {
            tally.spend(0.0)?;
            let s = n as f64 * step;
            let weight = if n == 0 { 0.5 } else { 1.0 } * step * FRAC_1_PI;
            let root = Complex64::new(s * s, -2.0).sqrt();
            let q = Complex64::new(-k * period * s * s, k * period).exp();
            let source = weight * q.powu(direct as u32 + 1) / (1.0 - q) / root;
            let along_x = k * Complex64::new(-s * s, 1.0);
            let along_z = k * s * root;
            for (column, decay) in decay.iter_mut().enumerate() {
                *decay = (-k * s * s * ((column as f64 - (self.columns / 2) as f64) * self.step_x))
                    .exp();
            }
            for row in 0..rows {
                let phase = along_z * self.z(row);
                let value = source * phase.cos();
                let (x, z) = (value * along_x, -source * phase.sin() * along_z);
                let all = [value.re, value.im, x.re, x.im, z.re, z.im, 0.0, 0.0];
                let entries = &mut self.entries[row * self.columns..][..self.columns];
                accumulate(entries, &decay, &all);
            }
        }
        Ok(())
    }

    /// Adds the source at x = -`away`.
    fn add_source(&mut self, away: f64, tally: &Tally<'_>) -> Result<(), Stopped> {
        let k = self.wavenumber;
        let rows = self.entries.len() / self.columns;
        for row in 0..rows {
            tally.spend(0.0)?;
            for column in 0..self.columns {
                let (x, z) = (self.x(column), self.z(row));
                let field = source(k, x + away, z);
                let back = Complex64::from_polar(1.0, -k * x);
                let parts = [field.value * back, field.along_x * back, field.along_z * back];
                let entry = &mut self.entries[row * self.columns + column];
                for (to, from) in entry.chunks_exact_mut(2).zip(parts) {
                    to[0] += from.re;
                    to[1] += from.im;
                }
            }
        }
        Ok(())
    }

    /// The field at `x`, |x| up to half a period, and `z`; `turn` is `exp(i k |x|)`.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
    pub(crate) fn at(&self, x: f64, z: f64, turn: Complex64) -> Field {
        let across = Stencil::new(x.abs() / self.step_x);
        let up = Stencil::new(z.abs() / self.step_z);
        let middle = self.columns / 2;
        let right = middle + across.first - (MARGIN - 1);
        let left = middle - across.first - MARGIN;
        let row = up.first + 1;
        let (mut plus, mut minus) = ([0.0; 8], [0.0; 8]);
        for (i, high) in up.weights.iter().enumerate() {
            let line = &self.entries[(row + i) * self.columns..][..self.columns];
            let ahead = &line[right..right + STENCIL];
            let back = &line[left..left + STENCIL];
            for j in 0..STENCIL {
                let (a, b) = (high * across.weights[j], high * across.weights[STENCIL - 1 - j]);
                for c in 0..8 {
                    plus[c] += a * ahead[j][c];
                    minus[c] += b * back[j][c];
                }
            }
        }
        let part = |of: &[f64; 8], i: usize| Complex64::new(of[2 * i], of[2 * i + 1]);
        let back = turn.conj();
        let along_x = part(&plus, 1) * turn - part(&minus, 1) * back;
        let along_z = part(&plus, 2) * turn + part(&minus, 2) * back;
        Field {
            value: part(&plus, 0) * turn + part(&minus, 0) * back,
            along_x: if x < 0.0 { -along_x } else { along_x },
            along_z: if z < 0.0 { -along_z } else { along_z },
        }
    }
}

/// `entries[i] += weights[i] all`.
#[multiversion(targets("x86_64+avx2+fma"))]
fn accumulate(entries: &mut [Entry], weights: &[f64], all: &Entry) {
    for (entry, weight) in entries.iter_mut().zip(weights) {
        for (to, from) in entry.iter_mut().zip(all) {
            *to += weight * from;
        }
    }
}

/// A single source at the origin, `i/4 H0(k r)`.
fn source(k: f64, x: f64, z: f64) -> Field {
    let r = x.hypot(z);
    let bessel = BesselTable::get().at(k * r);
    let radial = -0.25 * k / r * Complex64::new(-bessel.y1, bessel.j1);
    Field {
        value: 0.25 * Complex64::new(-bessel.y0, bessel.j0),
        along_x: radial * x,
        along_z: radial * z,
    }
}

/// One over the products of the distances of each point from all others.
const SCALES: [f64; STENCIL] = [
    -1.0 / 5040.0,
    1.0 / 720.0,
    -1.0 / 240.0,
    1.0 / 144.0,
    -1.0 / 144.0,
    1.0 / 240.0,
    -1.0 / 720.0,
    1.0 / 5040.0,
];

/// Weights of Lagrange's interpolation.
struct Stencil {
    /// The point at or below the place; the stencil begins three points before it.
    first: usize,
    weights: [f64; STENCIL],
}

impl Stencil {
    /// `place` in steps.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
    fn new(place: f64) -> Self {
        let first = place as usize;
        let t = place - first as f64;
        let off: [f64; STENCIL] = std::array::from_fn(|i| t + (MARGIN - 1) as f64 - i as f64);
        let mut weights = SCALES;
        let (mut before, mut behind) = (1.0, 1.0);
        for i in 0..STENCIL {
            weights[i] *= before;
            before *= off[i];
            weights[STENCIL - 1 - i] *= behind;
            behind *= off[STENCIL - 1 - i];
        }
        Self { first, weights }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use num_complex::Complex64;

    use super::{Images, source};
    use crate::stage::{Tally, nobody};

    /// The sum over plane waves, which converges fast away from z = 0.
    fn by_orders(k: f64, d: f64, x: f64, z: f64) -> Complex64 {
        let mut sum = Complex64::ZERO;
        for m in -3000..=3000 {
            let alpha = TAU * f64::from(m) / d;
            let beta = Complex64::new(k * k - alpha * alpha, 0.0).sqrt();
            sum += (Complex64::I * (alpha * x + beta * z.abs())).exp() / beta;
        }
        sum * Complex64::new(0.0, 0.5 / d)
    }

    #[test]
    fn the_table_and_the_nearest_source_are_the_sum_over_orders() {
        // shallow, deep and short periods; the last with direct sources
        for (k, d, height) in [
            (17.0, 16.5, 2.0),
            (11.4, 2.0, 0.3),
            (11.4, 30.3, 5.0),
            (17.0, 3.0, 4.0),
            (2.0, 1.0, 0.5),
            (17.02, 2.3, 6.0),
            (11.42, 2.3, 6.0),
        ] {
            let images = Images::new(k, d, height, &Tally::new(&nobody, 1.0)).unwrap();
            for (x, z) in
                [(0.0, 0.2), (0.1, 0.29), (0.5, -0.25), (-0.37, 0.3), (-0.2, -0.11), (0.3, 1.0)]
            {
                let (x, z) = (x * d, z * height);
                if z.abs() < 0.03 * d / 4.0 && d > 5.0 {
                    continue; // the sum over orders has not converged
                }
                let got = images.at(x, z, Complex64::from_polar(1.0, k * x.abs()));
                let near = source(k, x, z);
                let exact = by_orders(k, d, x, z);
                let error = (got.value + near.value - exact).norm();
                assert!(error < 1e-9, "k {k} d {d} at {x} {z}: {error:e} of {}", exact.norm());
                let e = 1e-5;
                let (right, left) = (by_orders(k, d, x + e, z), by_orders(k, d, x - e, z));
                let error = (got.along_x + near.along_x - (right - left) / (2.0 * e)).norm();
                assert!(error < 1e-7, "k {k} d {d} at {x} {z} along x: {error:e}");
                let (up, down) = (by_orders(k, d, x, z + e), by_orders(k, d, x, z - e));
                let error = (got.along_z + near.along_z - (up - down) / (2.0 * e)).norm();
                assert!(error < 1e-7, "k {k} d {d} at {x} {z} along z: {error:e}");
            }
        }
    }
}

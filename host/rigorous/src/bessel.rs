//! Bessel functions of the first and second kind, orders 0 and 1, all four at once.

use std::f64::consts::{FRAC_2_PI, PI};
use std::sync::LazyLock;

/// The four functions at one argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bessel {
    pub(crate) j0: f64,
    pub(crate) y0: f64,
    pub(crate) j1: f64,
    pub(crate) y1: f64,
}

/// Terms of a polynomial.
const TERMS: usize = 16;
/// Where the series in powers of the argument ends.
const SMALL: f64 = 3.0;
/// Where the second of the two polynomials in the inverse of the argument begins.
const LARGE: f64 = 8.0;

/// Polynomials in Chebyshev's basis, four functions side by side.
#[derive(Debug)]
struct Quartet {
    middle: f64,
    half: f64,
    terms: [[f64; 4]; TERMS],
}

impl Quartet {
    /// Interpolates four functions between `from` and `to` at Chebyshev's points.
    fn new(from: f64, to: f64, f: impl Fn(f64) -> [f64; 4]) -> Self {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let angle = |k: usize| PI * (k as f64 + 0.5) / TERMS as f64;
        let values: [[f64; 4]; TERMS] = std::array::from_fn(|k| f(middle + half * angle(k).cos()));
        let terms = std::array::from_fn(|n| {
            let scale = if n == 0 { 1.0 } else { 2.0 } / TERMS as f64;
            let mut term = [0.0; 4];
            for (k, value) in values.iter().enumerate() {
                let weight = scale * (n as f64 * angle(k)).cos();
                for (to, from) in term.iter_mut().zip(value) {
                    *to += weight * from;
                }
            }
            term
        });
        Self { middle, half, terms }
    }

    /// The four functions at `x`, by Clenshaw's sum.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
    fn at(&self, x: f64) -> [f64; 4] {
        let t = (x - self.middle) / self.half;
        let (mut b1, mut b2) = ([0.0; 4], [0.0; 4]);
        for term in self.terms[1..].iter().rev() {
            for i in 0..4 {
                let b = term[i] + 2.0 * t * b1[i] - b2[i];
                b2[i] = b1[i];
                b1[i] = b;
            }
        }
        std::array::from_fn(|i| self.terms[0][i] + t * b1[i] - b2[i])
    }
}

/// The polynomials of all arguments.
#[derive(Debug)]
pub(crate) struct Table {
    /// In t^2: J0, J1 / t, and what is smooth of Y0 and of t Y1.
    small: Quartet,
    /// In 1 / t: `sqrt(t) exp(-i t)` times the Hankel functions of order 0 and 1, real and imaginary parts.
    middle: Quartet,
    large: Quartet,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| Table {
    small: Quartet::new(0.0, SMALL * SMALL, |square| {
        let t = square.sqrt();
        let log = FRAC_2_PI * (0.5 * t).ln();
        let (j0, j1) = (libm::j0(t), libm::j1(t));
        [j0, j1 / t, libm::y0(t) - log * j0, t * (libm::y1(t) - log * j1)]
    }),
    middle: Quartet::new(1.0 / LARGE, 1.0 / SMALL, envelopes),
    large: Quartet::new(0.0, 1.0 / LARGE, envelopes),
});

fn envelopes(inverse: f64) -> [f64; 4] {
    let t = 1.0 / inverse;
    let (sin, cos) = t.sin_cos();
    let root = t.sqrt();
    let turned = |j: f64, y: f64| [root * (j * cos + y * sin), root * (y * cos - j * sin)];
    let [a, b] = turned(libm::j0(t), libm::y0(t));
    let [c, d] = turned(libm::j1(t), libm::y1(t));
    [a, b, c, d]
}

impl Table {
    /// The one table there is.
    pub(crate) fn get() -> &'static Self {
        &TABLE
    }

    /// All four at `t > 0`, right to 1e-13 of their envelope.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
    pub(crate) fn at(&self, t: f64) -> Bessel {
        if t < SMALL {
            let [j0, j1, y0, y1] = self.small.at(t * t);
            let (log, j1) = (FRAC_2_PI * (0.5 * t).ln(), j1 * t);
            return Bessel { j0, y0: y0 + log * j0, j1, y1: y1 / t + log * j1 };
        }
        let inverse = 1.0 / t;
        let [a, b, c, d] = if t < LARGE { self.middle.at(inverse) } else { self.large.at(inverse) };
        let (sin, cos) = t.sin_cos();
        let (sin, cos) = (sin * inverse.sqrt(), cos * inverse.sqrt());
        Bessel {
            j0: a * cos - b * sin,
            y0: a * sin + b * cos,
            j1: c * cos - d * sin,
            y1: c * sin + d * cos,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    #[test]
    fn the_table_agrees_with_the_library() {
        let table = Table::get();
        let mut worst = 0.0f64;
        for i in 1..200_000 {
            let t = 1e-3 * 1.000065f64.powi(i);
            let got = table.at(t);
            let scale = |exact: f64| exact.abs().max(t.sqrt().recip().min(1.0));
            for (got, exact) in [
                (got.j0, libm::j0(t)),
                (got.y0, libm::y0(t)),
                (got.j1, libm::j1(t)),
                (got.y1, libm::y1(t)),
            ] {
                worst = worst.max((got - exact).abs() / scale(exact));
            }
        }
        assert!(worst < 2e-13, "{worst}");
    }
}

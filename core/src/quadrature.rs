//! Gauss-Legendre rules and Hermite interpolation, in double precision.

use crate::math::Real;

/// Nodes and weights of the `N`-point Gauss-Legendre rule on [0, 1]; exact to degree `2 N - 1`.
///
/// Nodes ascend, with an error below 1e-15. The rule is computed by the compiler: a call reads a table.
#[inline]
pub const fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    const { rule() }
}

#[allow(clippy::indexing_slicing, reason = "a constant: an index out of range would not compile")]
const fn rule<const N: usize>() -> [(f64, f64); N] {
    let mut nodes = [(0.0, 0.0); N];
    let mut k = 0;
    while k < N {
        nodes[k] = gauss_legendre_node(N, k);
        k += 1;
    }
    nodes
}

/// Node `k` of `count` of that rule and its weight, for a number of nodes that is found at run time.
///
/// By Newton's method on the Legendre recurrence, in a time in proportion to `count`.
pub const fn gauss_legendre_node(count: usize, k: usize) -> (f64, f64) {
    let n = count as f64;
    let mut x = sine(core::f64::consts::PI * (0.5 - (n - 0.25 - k as f64) / (n + 0.5)));
    let mut derivative = 1.0;
    let mut step = 0;
    while step < 8 {
        let (mut before, mut p) = (1.0, x);
        let mut j = 2;
        while j <= count {
            let next = ((2.0 * j as f64 - 1.0) * x * p - (j as f64 - 1.0) * before) / j as f64;
            (before, p) = (p, next);
            j += 1;
        }
        derivative = n * (x * p - before) / (x * x - 1.0);
        x -= p / derivative;
        step += 1;
    }
    (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * derivative * derivative))
}

/// The sine of an angle up to a right one, by its series.
const fn sine(angle: f64) -> f64 {
    let (mut term, mut sum, mut k) = (angle, angle, 1.0);
    while k < 12.0 {
        term *= -angle * angle / (2.0 * k * (2.0 * k + 1.0));
        sum += term;
        k += 1.0;
    }
    sum
}

/// The eight-point Gauss-Legendre rule on [0, 1]: [`gauss_legendre`] computed once and for all.
pub(crate) const EIGHT_POINTS: [(f64, f64); 8] = [
    (0.01985507175123188, 0.05061426814518813),
    (0.101_666_761_293_186_64, 0.11119051722668724),
    (0.2372337950418355, 0.15685332293894363),
    (0.4082826787521751, 0.181341891689181),
    (0.591717321247825, 0.181341891689181),
    (0.7627662049581645, 0.15685332293894363),
    (0.8983332387068134, 0.11119051722668724),
    (0.9801449282487681, 0.05061426814518813),
];

/// Cubic Hermite interpolation on a cell of width `h` at `s` in [0, 1]: values `a`, `b`, slopes `da`, `db`.
#[inline(always)]
pub fn hermite<T: Real>(s: T, h: T, [a, da]: [T; 2], [b, db]: [T; 2]) -> T {
    let r = T::ONE - s;
    let rise = b - a;
    a + rise * s * s * (T::from_f64(3.0) - T::TWO * s) + h * s * r * (da * r - db * s)
}

/// A slope that keeps [`hermite`] monotone between secants `left` and `right` \[Fritsch & Carlson 1980\].
///
/// Both secants are not negative; `wanted` may be infinite or NaN.
#[cfg(feature = "normals")]
#[inline]
pub(crate) fn monotone_slope(wanted: f64, left: f64, right: f64) -> f64 {
    let most = 3.0 * Real::min(left, right);
    if wanted >= 0.0 && wanted <= most { wanted } else { most }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{EIGHT_POINTS, gauss_legendre, hermite};

    #[test]
    fn the_rule_is_exact_to_its_degree_and_no_further() {
        fn check<const N: usize>() {
            let rule = gauss_legendre::<N>();
            assert!(rule.windows(2).all(|w| w[0].0 < w[1].0));
            for degree in 0..2 * i32::try_from(N).unwrap() {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                assert!((sum * f64::from(degree + 1) - 1.0).abs() < 1e-13, "{N} {degree}");
            }
            let sum: f64 =
                rule.iter().map(|(x, w)| w * x.powi(2 * i32::try_from(N).unwrap())).sum();
            assert!(N > 6 || (sum * (2 * N + 1) as f64 - 1.0).abs() > 1e-9);
        }
        check::<1>();
        check::<2>();
        check::<5>();
        check::<8>();
        check::<32>();
    }

    #[test]
    fn the_constant_rule_is_the_computed_one() {
        for (a, b) in EIGHT_POINTS.iter().zip(gauss_legendre::<8>()) {
            assert!((a.0 - b.0).abs() < 2e-16 && (a.1 - b.1).abs() < 2e-16, "{a:?} {b:?}");
        }
    }

    #[test]
    fn hermite_reproduces_a_cubic() {
        let f = |x: f64| 1.0 + x * (2.0 - x * (3.0 - 0.5 * x));
        let d = |x: f64| 2.0 - 6.0 * x + 1.5 * x * x;
        let (a, b) = (0.3, 1.7);
        for k in 0..=10 {
            let s = f64::from(k) / 10.0;
            let got = hermite(s, b - a, [f(a), d(a)], [f(b), d(b)]);
            assert!((got - f(a + s * (b - a))).abs() < 1e-14);
        }
    }
}

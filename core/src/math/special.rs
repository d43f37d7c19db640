//! Special functions of densities, in double precision: logarithm of gamma, beta, incomplete beta.

use super::Real;

/// `ln |gamma(x)|`.
pub(crate) fn ln_gamma(x: f64) -> f64 {
    libm::lgamma(x)
}

/// `erf(x)`, absolute error below 1e-15.
pub(crate) fn erf(x: f64) -> f64 {
    libm::erf(x)
}

/// `ln(1 + x)`.
pub(crate) fn ln_1p(x: f64) -> f64 {
    libm::log1p(x)
}

/// `exp(x) - 1`.
pub(crate) fn exp_m1(x: f64) -> f64 {
    libm::expm1(x)
}

/// What Stirling's series leaves of `ln gamma(x)` beyond `(x - 1/2) ln x - x + ln(2 pi) / 2`, for x from 10.
fn stirling_rest(x: f64) -> f64 {
    let r = 1.0 / (x * x);
    let terms =
        1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r * (1.0 / 1680.0 - r / 1188.0)));
    terms / x
}

/// The beta function of two numbers from 1; 0 if either is infinite.
///
/// Relative error below 1e-12, also where one is large: the logarithms of the gamma functions would then cancel
/// \[`DiDonato` & Morris 1992\].
pub(crate) fn beta(p: f64, q: f64) -> f64 {
    let (p, q) = if p <= q { (p, q) } else { (q, p) };
    if !q.is_finite() {
        return 0.0;
    }
    let ln = if q < 10.0 {
        ln_gamma(p) + ln_gamma(q) - ln_gamma(p + q)
    } else {
        // ln gamma(q) - ln gamma(p + q)
        let ratio = stirling_rest(q) - stirling_rest(p + q) + p - p * Real::ln(p + q)
            + (q - 0.5) * ln_1p(-p / (p + q));
        ratio + ln_gamma(p)
    };
    Real::exp(ln)
}

/// The beta function of a number above 0 and 3/2.
pub(crate) fn beta_three_halves(p: f64) -> f64 {
    Real::exp(ln_gamma(p) + ln_gamma(1.5) - ln_gamma(p + 1.5))
}

/// The regularised incomplete beta function `I_x(a, 1/2)` for `a` above 0, from `x` and `y = 1 - x`, neither
/// negative, and `1 / B(a, 1/2)`.
///
/// Lentz's continued fraction, relative error about 1e-14; it takes some `sqrt(a)` terms.
pub(crate) fn incomplete_beta_half(a: f64, x: f64, y: f64, inverse_beta: f64) -> f64 {
    let front = Real::pow(x, a) * Real::sqrt(y) * inverse_beta;
    let value = if x * (a + 2.5) < a + 1.0 {
        front * fraction(a, 0.5, x) / a
    } else {
        1.0 - front * fraction(0.5, a, y) / 0.5
    };
    Real::min(Real::max(value, 0.0), 1.0)
}

/// The continued fraction of the incomplete beta function.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let apart = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / apart(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for m in 1..300_u32 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / apart(1.0 + even * d);
        c = apart(1.0 + even / c);
        value *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / apart(1.0 + odd * d);
        c = apart(1.0 + odd / c);
        let step = d * c;
        value *= step;
        if Real::abs(step - 1.0) < 1e-15 {
            break;
        }
    }
    value
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{Real, beta, incomplete_beta_half, ln_gamma};

    #[test]
    fn beta_agrees_with_closed_forms_for_small_and_large_arguments() {
        // B(1, q) = 1 / q, B(2, q) = 1 / (q (q + 1)), B(3/2, 3/2) = pi / 8
        for q in [1.0, 1.5, 9.9, 10.1, 1e3, 1e8, 1e14, 1e100] {
            assert!((beta(1.0, q) * q - 1.0).abs() < 1e-12, "{q}");
            assert!((beta(q, 2.0) * q * (q + 1.0) - 1.0).abs() < 1e-12, "{q}");
        }
        assert!((beta(1.5, 1.5) - core::f64::consts::PI / 8.0).abs() < 1e-14);
        // B(m, n) of integers, by factorials
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for (m, n) in [(4, 7), (12, 9), (15, 40)] {
            let exact = factorial(m - 1) * factorial(n - 1) / factorial(m + n - 1);
            assert!((beta(f64::from(m), f64::from(n)) / exact - 1.0).abs() < 1e-12);
        }
        assert!(beta(1.0, f64::INFINITY).abs() < 1e-300);
    }

    #[test]
    fn the_incomplete_beta_function_agrees_with_its_integral() {
        for a in [0.51_f64, 0.7, 1.0, 2.0, 9.0, 99.0, 999.0] {
            let inverse = (ln_gamma(a + 0.5) - ln_gamma(a)).exp() / core::f64::consts::PI.sqrt();
            for x in [1e-3, 0.2, 0.5, 0.9, 0.99, 0.999, 1.0 - 1e-9, 1.0] {
                // with t = 1 - v^2 the integrand is 2 (1 - v^2)^(a - 1), from sqrt(1 - x); smooth but at v = 1,
                // where v = 1 - s^4 mends it
                let start: f64 = Real::sqrt(1.0 - x);
                let (end, steps) = ((1.0 - start).powf(0.25), 200_000);
                let sum: f64 = (0..steps)
                    .map(|k| {
                        let s = (f64::from(k) + 0.5) / f64::from(steps) * end;
                        let v = 1.0 - s.powi(4);
                        2.0 * (s.powi(4) * (1.0 + v)).powf(a - 1.0) * 4.0 * s.powi(3) * end
                            / f64::from(steps)
                    })
                    .sum();
                let got = incomplete_beta_half(a, x, 1.0 - x, inverse);
                assert!((got - sum * inverse).abs() < 1e-7, "{a} {x}: {got} {}", sum * inverse);
            }
        }
        // a = 1: I = 1 - sqrt(1 - x)
        for x in [0.1_f64, 0.5, 0.95] {
            assert!(
                (incomplete_beta_half(1.0, x, 1.0 - x, 0.5) - (1.0 - (1.0 - x).sqrt())).abs()
                    < 1e-14
            );
        }
    }
}

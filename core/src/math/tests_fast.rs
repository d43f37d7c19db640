//! The fast tier against `libm` in double precision, densely, region by region.

use std::vec::Vec;

use super::{Fast, Real};

/// Every number of a geometric grid from 1e-30 to `most`, both signs, with 0 and the edges.
fn arguments(most: f64, count: usize) -> Vec<f64> {
    let least: f64 = 1e-30;
    let ratio = libm::pow(most / least, 1.0 / count as f64);
    let mut x = least;
    let mut all = Vec::from([0.0, most, -most]);
    for k in 0..count {
        x *= ratio;
        // uneven too: a linear sweep of the same number
        let linear = most * (k as f64 + 0.5) / count as f64;
        all.extend([x.min(most), -x.min(most), linear, -linear]);
    }
    all
}

/// Largest error over `arguments`, relative where the value is above `floor`, over `floor` where below.
fn worst<T: Real>(
    arguments: &[f64],
    floor: f64,
    fast: impl Fn(T) -> T,
    exact: impl Fn(f64) -> f64,
) -> f64 {
    arguments.iter().fold(0.0, |worst, &x| {
        let x = T::from_f64(x);
        let (got, want) = (fast(x).to_f64(), exact(x.to_f64()));
        let error = (got - want).abs() / want.abs().max(floor);
        assert!(error.is_finite(), "{x}: {got} {want}");
        worst.max(error)
    })
}

/// The bounds that the documentation promises, in units of the type's epsilon.
fn bounds<T: Real>(epsilon: f64, tiny: f64, steps: usize) {
    #[allow(clippy::print_stdout, reason = "shown with --nocapture")]
    let check = |what: &str, error: f64, bound: f64| {
        std::println!("{what}: {:.2} epsilon", error / epsilon);
        assert!(error <= bound * epsilon, "{what}: {} epsilon", error / epsilon);
    };
    let angles = arguments(100.0, steps);
    check("sin", worst::<T>(&angles, 1e-3, |x| x.sin_cos().0, libm::sin), 1.5);
    check("cos", worst::<T>(&angles, 1e-3, |x| x.sin_cos().1, libm::cos), 1.5);
    let unit = arguments(1.0, steps);
    check("asin", worst::<T>(&unit, 1e-30, Real::asin, libm::asin), 3.0);
    check("acos", worst::<T>(&unit, 1e-3, Real::acos, libm::acos), 3.0);
    let powers = arguments(80.0, steps);
    check("exp", worst::<T>(&powers, tiny, Real::exp, libm::exp), 1.5);
    let most = -tiny.log2() - 0.001;
    let sizes: Vec<f64> = arguments(120.0, steps).iter().map(|&x| x.abs().min(most)).collect();
    check("halved", worst::<T>(&sizes, tiny, Real::halved, |x| libm::exp2(-x)), 2.0);
    let positive: Vec<f64> = arguments(1e30, steps).into_iter().filter(|&x| x > 0.0).collect();
    check("ln", worst::<T>(&positive, 1e-2, Real::ln, libm::log), 3.0);
    let near: Vec<f64> = arguments(0.5, steps).into_iter().map(|x| 1.0 + x).collect();
    check("ln near 1", worst::<T>(&near, 1e-30, Real::ln, libm::log), 3.0);
    let slopes: Vec<f64> = arguments(1e15, steps).into_iter().filter(|&x| x > 0.0).collect();
    for other in [1e-15, 0.3, 1.0, 4e5] {
        let run = |x: T| T::angle_squared(x, T::from_f64(other));
        let run2 = T::from_f64(other).to_f64().sqrt();
        let exact = |y2: f64| libm::pow(libm::atan2(libm::sqrt(y2), run2), 2.0);
        check("squared angle", worst::<T>(&slopes, 1e-30, run, exact), 5.0);
    }
    for other in [1e-20, 0.3, 1.0, 4e5] {
        let run = |x: T| x.atan2(T::from_f64(other));
        let rise = T::from_f64(other).to_f64();
        check("atan2", worst::<T>(&positive, 1e-30, run, |y| libm::atan2(y, rise)), 3.0);
        let left = |x: T| x.atan2(T::from_f64(-other));
        check("atan2, left", worst::<T>(&positive, 1e-30, left, |y| libm::atan2(y, -rise)), 3.0);
    }
}

#[test]
fn single_precision_stays_within_its_bounds() {
    bounds::<Fast<f32>>(f64::from(f32::EPSILON), f64::from(f32::MIN_POSITIVE), 200_000);
}

#[test]
fn double_precision_stays_within_its_bounds() {
    bounds::<Fast<f64>>(500.0 * f64::EPSILON, f64::MIN_POSITIVE, 200_000);
}

#[test]
fn edges_and_nonsense() {
    fn edges<T: Real>() {
        let (of, nan) = (T::from_f64, T::from_f64(f64::NAN));
        let infinity = of(f64::INFINITY);
        assert!(of(1e4).exp() == infinity && of(-1e4).exp() == T::ZERO);
        assert!(T::ZERO.ln() == -infinity && !of(-1.0).ln().is_finite());
        assert!(of(2e3).halved() == T::ZERO && T::ZERO.halved() == T::ONE);
        assert!(infinity.halved() == T::ZERO && T::ONE.halved() == T::HALF);
        assert!(infinity.ln() == infinity && T::ONE.ln() == T::ZERO);
        for x in [1.0001, -1.0001, 7.0] {
            assert!(!of(x).acos().is_finite() && !of(x).asin().is_finite());
        }
        for x in [nan, infinity, -infinity] {
            let (s, c) = x.sin_cos();
            assert!(!s.is_finite() && !c.is_finite() && !x.acos().is_finite());
        }
        assert!(!nan.exp().is_finite() && !nan.ln().is_finite() && !nan.atan2(T::ONE).is_finite());
        for x in [1e9, -1e20, 3e38] {
            let (s, c) = of(x).sin_cos();
            assert!(s.abs() <= T::ONE && c.abs() <= T::ONE);
        }
        assert!(T::ZERO.atan2(T::ZERO) == T::ZERO && T::ZERO.pow(T::TWO) == T::ZERO);
        assert!(of(5.0).pow(T::ZERO) == T::ONE && T::ZERO.pow(T::ZERO) == T::ONE);
    }
    edges::<Fast<f32>>();
    edges::<Fast<f64>>();
}

#[test]
fn powers_lose_what_their_exponent_multiplies() {
    for (x, y) in [(0.3_f32, 2.0_f32), (1e-3, 4.5), (7.0, -3.0), (1.5, 40.0), (0.9, 0.1)] {
        let want = libm::pow(f64::from(x), f64::from(y));
        let error = (f64::from(Fast(x).pow(Fast(y)).0) - want).abs() / want;
        let bound = 1.5 + 1.5 * libm::fabs(f64::from(y) * libm::log(f64::from(x)));
        assert!(error < bound * f64::from(f32::EPSILON), "{x}^{y}: {error:e}");
    }
}

#[test]
fn what_rounding_takes_is_found_exactly() {
    let mut word: u64 = 0x9e37_79b9_7f4a_7c15;
    for _ in 0..200_000 {
        word = word.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let number = |bits: u64| f32::from_bits((bits as u32 & 0x87ff_ffff) + 0x3a00_0000);
        let (a, b) = (number(word >> 32), number(word));
        let (product, sum) = (a * b, a + b);
        let exact = f64::from(a) * f64::from(b) - f64::from(product);
        assert_eq!(f64::from(a.product_error(b, product)), exact, "{a:e} {b:e}");
        let exact = f64::from(a) + f64::from(b) - f64::from(sum);
        assert_eq!(f64::from(a.sum_error(b, sum)), exact, "{a:e} {b:e}");
    }
}

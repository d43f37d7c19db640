//! The harness itself: a chi-square test must know chi-square, an oracle must know its quadrature.

use asperity_tests::chi2::{sidak, survival, upper_gamma};
use asperity_tests::oracle::{gauss, over_the_sphere};
use asperity_tests::tolerance;

#[test]
fn the_incomplete_gamma_function_has_its_known_values() {
    // 95 % points of chi-square
    for (x, freedom) in [
        (3.841458820694124, 1),
        (5.991464547107979, 2),
        (18.307038053275146, 10),
        (124.34211340400407, 100),
    ] {
        let p = survival(x, freedom);
        assert!((p / 0.05 - 1.0).abs() < tolerance::GAMMA.allowed, "{freedom}: {p}");
    }
    // a = 1: exp(-x), in series and continued fraction; a = 1/2: erfc
    for x in [1e-3, 0.5, 1.9, 2.1, 30.0, 300.0] {
        let q = upper_gamma(1.0, x);
        assert!((q / (-x).exp() - 1.0).abs() < tolerance::GAMMA.allowed, "{x} {q}");
    }
    assert!((upper_gamma(0.5, 1.0) - 0.157299207050285).abs() < tolerance::GAMMA.allowed);
    // recurrence Q(a + 1, x) = Q(a, x) + x^a e^-x / gamma(a + 1) joins both branches at large a
    for x in [480.0, 500.0, 520.0] {
        let step: f64 = upper_gamma(501.0, x) - upper_gamma(500.0, x);
        let ln_factorial: f64 = (1..=500).map(|k| f64::from(k).ln()).sum();
        let exact = (500.0 * f64::ln(x) - x - ln_factorial).exp();
        assert!((step / exact - 1.0).abs() < 1e-9, "{x}: {step} {exact}");
    }
}

#[test]
fn sidak_keeps_the_total_significance() {
    for n in [1_u8, 7, 100] {
        let each: f64 = sidak(0.01, usize::from(n));
        assert!(((1.0 - each).powi(i32::from(n)) - 0.99).abs() < 1e-12);
    }
}

#[test]
fn the_oracle_integrates_polynomials_and_the_sphere() {
    for n in [3_u32, 16] {
        let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powf(f64::from(2 * n - 1))).sum();
        assert!((sum * f64::from(2 * n) - 1.0).abs() < 1e-13);
    }
    for width in [0.01, 0.3, 2.0] {
        let axis = [0.6, 0.0, -0.8];
        // a lobe of that width, whose integral is elementary, and the whole sphere
        let lobe = over_the_sphere(axis, width, [60, 16], |w| {
            let c = 1.0 - asperity_tests::oracle::dot(w, axis);
            width * width / (width * width + c).powi(2)
        });
        let w2 = width * width;
        let exact = std::f64::consts::TAU * w2 * (1.0 / w2 - 1.0 / (w2 + 2.0));
        assert!((lobe / exact - 1.0).abs() < 1e-6, "{width} {lobe} {exact}");
    }
}

#[test]
fn every_tolerance_has_a_quantity_a_reason_and_a_name_of_its_own() {
    for (k, t) in tolerance::ALL.iter().enumerate() {
        assert!(t.allowed > 0.0 && t.reason.len() > 10, "{t:?}");
        assert!(tolerance::ALL[..k].iter().all(|u| u.quantity != t.quantity), "{t:?}");
    }
}

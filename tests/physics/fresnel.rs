//! Fresnel coefficients against complex amplitudes, total reflection, Brewster, reversal.

use asperity_core::fresnel::dielectric;
use asperity_tests::{oracle, tolerance};

const INDICES: [f64; 11] =
    [0.1, 0.3, 1.0 / 1.49, 0.95, 0.9999, 1.0001, 1.05, 1.33, 1.49, 4.0, 10.0];

/// Cosines from normal incidence to a grazing 1e-6.
fn cosines() -> impl Iterator<Item = f64> {
    let even = (1..=400).map(|k| f64::from(k) / 400.0);
    even.chain((0..60).map(|k| 10_f64.powf(-0.1 * f64::from(k))))
}

#[test]
fn fresnel_agrees_with_complex_amplitudes_on_both_sides_of_the_critical_angle() {
    let mut worst = (0.0_f64, 0.0, 0.0);
    for n in INDICES {
        for c in cosines() {
            let (got, want) = (dielectric(c, n), oracle::fresnel(c, n));
            let g2: f64 = n * n - 1.0 + c * c;
            // magnified near the critical angle, where a root meets zero
            let allowed = tolerance::FRESNEL.allowed * (1.0 + 1.0 / g2.abs().sqrt());
            let error = (got.reflected - want.unpolarised())
                .abs()
                .max((got.transmitted - want.through()).abs())
                .max((got.reflected + got.transmitted - 1.0).abs());
            assert!(error < allowed, "n {n} cos {c}: {got:?} {want:?} {error:e} > {allowed:e}");
            if error > worst.0 {
                worst = (error, n, c);
            }
        }
    }
    println!("fresnel: worst deviation {:.1e} at n {:.4}, cos {:.4}", worst.0, worst.1, worst.2);
}

#[test]
fn total_reflection_is_total() {
    for n in [0.1, 0.5, 1.0 / 1.49, 0.99_f64] {
        let critical = (1.0 - n * n).sqrt();
        for k in 0..100 {
            let beyond = dielectric(critical * (f64::from(k) / 100.0), n);
            assert!((beyond.reflected - 1.0).abs() < 1e-15 && beyond.transmitted.abs() < 1e-300);
            let f32_beyond = dielectric((critical * f64::from(k) / 100.5) as f32, n as f32);
            assert!(f32_beyond.reflected >= 1.0 && f32_beyond.transmitted <= 0.0, "{n} {k}");
        }
        let short = dielectric(critical + 1e-9, n);
        assert!(short.transmitted > 0.0 && short.reflected < 1.0);
    }
}

#[test]
fn at_brewsters_angle_only_the_s_polarisation_is_reflected() {
    for n in INDICES {
        let c = n.atan().cos();
        let polarised = oracle::fresnel(c, n);
        assert!(polarised.reflected[1] < tolerance::BREWSTER.allowed, "{n} {polarised:?}");
        // r_s at Brewster's angle is (1 - n^2) / (1 + n^2), and nothing else is left of F
        let rs = (1.0 - n * n) / (1.0 + n * n);
        let got = dielectric(c, n).reflected;
        assert!((got - 0.5 * rs * rs).abs() < tolerance::BREWSTER.allowed, "{n} {got}");
    }
}

#[test]
fn the_reversed_ray_meets_the_same_reflectance() {
    for n in INDICES {
        for c in cosines() {
            let t2 = 1.0 - (1.0 - c * c) / (n * n);
            if t2 < 1e-3 {
                continue; // totally reflected, or as good as
            }
            let (there, back) = (dielectric(c, n), dielectric(t2.sqrt(), 1.0 / n));
            // the refracted cosine is itself rounded, which 1 / cos magnifies
            let allowed = tolerance::FRESNEL.allowed * (1.0 + 10.0 / (c * c) / n.min(1.0));
            assert!(
                (there.reflected - back.reflected).abs() < allowed,
                "{n} {c} {there:?} {back:?}"
            );
        }
    }
}

#[test]
fn nearly_equal_indices_reflect_a_square_of_their_difference() {
    for d in [1e-6, -1e-6, 1e-3] {
        let n: f64 = 1.0 + d;
        for c in [1.0, 0.7, 0.1] {
            let small = n - 1.0;
            // to first order in small: r_s = -small / (2 c^2), r_p = small (1 - 2 c^2) / (2 c^2)
            let (rs, rp) = (small / (2.0 * c * c), small * (1.0 - 2.0 * c * c) / (2.0 * c * c));
            let series = 0.5 * (rs * rs + rp * rp);
            let got = dielectric(c, n).reflected;
            let next = 10.0 * small.abs() / (c * c);
            let allowed = tolerance::FRESNEL_NEAR_ONE.allowed + next;
            assert!((got / series - 1.0).abs() < allowed, "{n} {c} {got} {series}");
        }
    }
}

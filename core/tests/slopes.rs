//! A density of slopes through knots against the closed densities its knots are placed on, and against slow sums.
#![cfg(all(feature = "microfacet", feature = "f32"))]
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "tests may fail, and use the platform's mathematics"
)]

use asperity_core::direction::Direction;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::density::Density;
use asperity_core::ndf::slopes::Slopes;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::Alpha;

fn alpha(value: f64) -> Alpha<f64> {
    Alpha::new(value).unwrap()
}

/// `D` at a slope.
fn d(density: &impl Density<f64>, slope: f64) -> f64 {
    let z2 = 1.0 / (1.0 + slope * slope);
    density.d(slope * slope * z2, z2, || [[slope * slope * z2, 0.0], [z2, 0.0]])
}

/// The density of slopes, from `D`.
fn p(density: &impl Density<f64>, slope: f64) -> f64 {
    d(density, slope) / (1.0 + slope * slope).powi(2)
}

/// Knots on another density.
fn on<const K: usize>(other: &impl Density<f64>, width: f64) -> Slopes<f64, K> {
    let first = p(other, 0.0).ln();
    let knots = core::array::from_fn(|k| p(other, width * Slopes::<f64, K>::place(k)).ln() - first);
    Slopes::new(alpha(width), knots).unwrap()
}

/// Largest relative error of `D` at slopes whose density is above a share of its peak, and largest error of `G1`.
fn errors(ours: &impl Density<f64>, other: &impl Density<f64>, least: f64) -> [f64; 2] {
    let (mut worst, peak) = ([0.0_f64; 2], p(other, 0.0));
    for k in 0..400 {
        let slope = 1e-3 * 1.03_f64.powi(k);
        if p(other, slope) > least * peak {
            worst[0] = worst[0].max((d(ours, slope) / d(other, slope) - 1.0).abs());
        }
        let w = Direction::from_angles(f64::from(k) * 0.003_92, 1.0);
        worst[1] = worst[1].max((ours.g1(w) - other.g1(w)).abs());
    }
    worst
}

#[test]
fn knots_on_a_closed_density_reproduce_it() {
    // gamma, sigma, width; D with 8 and 10 knots, G1: to 4 decades below the peak
    for (gamma, sigma, width, eight, ten, mask) in
        [(2.0, 0.2, 2.0, 3e-3, 1e-3, 2e-3), (4.0, 0.1, 0.5, 5e-3, 1e-3, 2e-4)]
    {
        let student = Student::new(alpha(sigma), gamma).unwrap();
        let [d8, g8] = errors(&on::<8>(&student, width), &student, 1e-4);
        let [d10, g10] = errors(&on::<10>(&student, width), &student, 1e-4);
        assert!(d8 < eight && d10 < ten && g8 < mask && g10 < mask, "{d8} {d10} {g8} {g10}");
    }
    // a Gaussian bends most in the last interval, far below the peak
    let beckmann = Beckmann::new(alpha(0.3));
    for (least, eight, ten) in [(1e-2, 0.03, 0.015), (1e-4, 0.1, 0.05)] {
        let [d8, g8] = errors(&on::<8>(&beckmann, 0.93), &beckmann, least);
        let [d10, g10] = errors(&on::<10>(&beckmann, 0.93), &beckmann, least);
        assert!(d8 < eight && d10 < ten && g8 < 1e-3 && g10 < 1e-3, "{d8} {d10} {g8} {g10}");
    }
}

fn odd() -> Vec<Slopes<f64>> {
    let shapes = [
        [0.0, -0.2, -0.1, -0.4, -4.0, -9.0, -11.0, -14.0],
        [0.0, 0.6, 1.5, 1.0, -3.0, -4.0, -5.0, -8.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -30.0, -60.0],
        [0.0, -1.0, -2.2, -3.0, -3.6, -4.5, -5.6, -7.2],
    ];
    shapes.iter().map(|knots| Slopes::new(alpha(0.7), *knots).unwrap()).collect()
}

#[test]
fn the_area_is_one_and_shares_and_excess_are_sums_over_it() {
    for density in odd() {
        // midpoints in ln s, far beyond the last knot
        let (steps, low, high) = (200_000, 1e-5_f64.ln(), 1e12_f64.ln());
        let h = (high - low) / f64::from(steps);
        let at = |k: i32| (low + (f64::from(k) + 0.5) * h).exp();
        let mass = |s: f64| core::f64::consts::TAU * s * s * p(&density, s) * h;
        let total: f64 = (0..steps).map(|k| mass(at(k))).sum();
        assert!((total - 1.0).abs() < 1e-6, "{total} {density:?}");
        for mu in [0.0_f64, 0.01, 0.1, 0.3, 0.69, 0.71, 2.0, 30.0] {
            let (mut above, mut excess) = (0.0, 0.0);
            let low = mu.max(1e-5).ln();
            let h = (high - low) / f64::from(steps);
            for s in (0..steps).map(|k| (low + (f64::from(k) + 0.5) * h).exp()) {
                let mass = |s: f64| core::f64::consts::TAU * s * s * p(&density, s) * h;
                above += mass(s);
                let root = (s * s - mu * mu).sqrt();
                excess += mass(s) * (root - mu * (mu / s).acos()) / core::f64::consts::PI;
            }
            let [share, over] = [density.steeper(mu), density.excess(mu)];
            assert!((share - above).abs() < 1e-3 * above + 1e-9, "{mu}: {share} {above}");
            assert!((over - excess).abs() < 1e-3 * excess + 1e-9, "{mu}: {over} {excess}");
        }
        for share in [1.0, 0.99, 0.5, 1e-2, 1e-4, 1e-9] {
            let back = density.steeper(density.slope_above(share));
            assert!((back / share - 1.0).abs() < 1e-9, "{share} {back}");
        }
    }
}

#[test]
fn single_precision_keeps_the_peak_and_the_tail() {
    for density in odd() {
        let single: Slopes<f32> = density.cast();
        for k in 0..300 {
            let slope = 1e-4 * 1.05_f64.powi(k);
            let z2 = 1.0 / (1.0 + slope * slope);
            let (x, z) = ((slope * slope * z2) as f32, z2 as f32);
            let there = f64::from(single.d(x, z, || [[x, 0.0], [z, 0.0]]));
            let here = density.d(f64::from(x), f64::from(z), || [[0.0; 2]; 2]);
            assert!((there - here).abs() < 1e-4 * here + 1e-30, "{slope}: {there} {here}");
        }
    }
}

#[test]
fn values_outside_the_domain_are_refused() {
    let knots = |x: f64| [0.0, x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for bad in [f64::NAN, f64::INFINITY, 60.1, -60.1] {
        assert!(Slopes::new(alpha(1.0), knots(bad)).is_err(), "{bad}");
    }
    assert!(Slopes::new(alpha(1.0), knots(60.0)).is_ok());
}

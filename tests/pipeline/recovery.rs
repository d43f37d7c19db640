//! Scans made by Monte Carlo from known models are recovered by the deterministic fit.

use asperity::fit::{Fit, FitOptions};
use asperity::forward::Rays;
use asperity::measurement::Measurement;
use asperity::method::{GgxMethod, Method, Surface};
use asperity_core::gonio::Geometry::{self, Reflection, Transmission};
use asperity_core::plate::RoughSide::{self, Detector, Source};
use asperity_tests::count;
use asperity_tests::tolerance::Tolerance;

use crate::common::{CAUCHY, GAUSS, Virtual, fitted, grid, options, value};
use crate::limits::{
    PULL, RECOVERED_ALPHA, RECOVERED_DELTA, RECOVERED_EXPONENT, RECOVERED_GAIN, RECOVERED_IOR,
    RECOVERED_LAMBERT,
};

const SIGMAS: [f64; 3] = [0.0, 30.0, 60.0];

/// A parameter, its true value, and the deviation allowed: relative, that of `ior` absolute.
type Truth = (&'static str, f64, Tolerance);

struct Case<'a> {
    name: String,
    sample: Virtual,
    method: &'a dyn Method,
    options: FitOptions,
    rays: usize,
    gain: f64,
    truths: Vec<Truth>,
}

impl Case<'_> {
    /// Scans, fits, prints, and checks the values and their pulls.
    fn check(&self, seed: u64) -> Fit {
        let rays = Rays { count: count(self.rays) as u64, seed };
        let scan = self.sample.noisy_scan(&SIGMAS, &grid(5), rays, self.gain);
        let fit = fitted(self.method, &scan, &self.sample.setup, &self.options).unwrap();
        let name = format!("{}, seed {seed}", self.name);
        assert_eq!(fit.termination.word(), "converged", "{name}");
        let truth_cost = self.cost_of_the_truth(&scan);
        println!("{name}: {} {:.6}, of the truth {truth_cost:.6}", fit.objective.0, fit.objective.1);
        for &(parameter, truth, limit) in &self.truths {
            let (found, error) = value(&fit, parameter);
            let off = if parameter == "ior" { found - truth } else { found / truth - 1.0 };
            let pull = (found - truth) / error;
            println!(
                "{name}: {parameter} {found:.5} +- {error:.5} (true {truth}), off {off:+.5} of {} \
                 allowed, pull {pull:+.2}, {} evaluations",
                limit.allowed, fit.evaluations
            );
            assert!(off.abs() <= limit.allowed, "{name}: {parameter} {found}, true {truth}");
            assert!(pull.abs() < PULL.allowed, "{name}: {parameter} pull {pull}");
        }
        fit
    }
}

impl Case<'_> {
    /// What the fit minimises, at the values the scan was made from.
    fn cost_of_the_truth(&self, scan: &Measurement) -> f64 {
        let exact = self.sample.quadrature(&SIGMAS, &grid(5)).values;
        let largest = scan.largest_reading();
        let squares: f64 = scan
            .readings()
            .iter()
            .zip(&exact)
            .map(|(m, s)| self.options.objective.residual(m.value, s * self.gain, largest).powi(2))
            .sum();
        self.options.objective.of_mean_square(squares / exact.len() as f64)
    }
}

/// A case with the method and the index known.
fn plain<'a>(
    name: String,
    method: &'a dyn Method,
    values: &[f64],
    ior: f64,
    sides: (RoughSide, Geometry),
    truths: Vec<Truth>,
) -> Case<'a> {
    Case {
        name,
        sample: Virtual::plate(method, values, ior, sides.0, sides.1),
        method,
        options: options(Surface::Dielectric { ior }),
        rays: 200_000,
        gain: 1.0,
        truths,
    }
}

#[test]
fn ggx_of_a_plate_in_transmission_from_both_sides() {
    let mut seed = 1000;
    for alpha in [0.05, 0.2, 0.5] {
        for ior in [1.49, 1.6] {
            for side in [Source, Detector] {
                seed += 1;
                let method = GgxMethod::new(Surface::Dielectric { ior });
                let truths = vec![("alpha", alpha, RECOVERED_ALPHA)];
                let name = format!("ggx {alpha} n {ior} {side:?}");
                plain(name, &method, &[alpha], ior, (side, Transmission), truths).check(seed);
            }
        }
    }
}

#[test]
fn ggx_of_a_plate_in_reflection_from_both_sides() {
    let mut seed = 2000;
    for alpha in [0.05, 0.2, 0.5] {
        for side in [Source, Detector] {
            seed += 1;
            let method = GgxMethod::new(Surface::Dielectric { ior: 1.49 });
            let truths = vec![("alpha", alpha, RECOVERED_ALPHA)];
            let name = format!("ggx {alpha} reflection {side:?}");
            let mut case = plain(name, &method, &[alpha], 1.49, (side, Reflection), truths);
            // a tenth of the light comes back
            case.rays = 1_000_000;
            case.check(seed);
        }
    }
}

#[test]
fn ggx_and_the_refractive_index_from_a_wrong_start() {
    let mut seed = 3000;
    for (alpha, ior, start) in [(0.05, 1.49, 1.6), (0.2, 1.49, 1.4), (0.2, 1.6, 1.4), (0.5, 1.6, 1.49)] {
        for side in [Source, Detector] {
            seed += 1;
            let method = GgxMethod::new(Surface::Dielectric { ior });
            let truths = vec![("alpha", alpha, RECOVERED_ALPHA), ("ior", ior, RECOVERED_IOR)];
            let name = format!("ggx {alpha} n {ior} from {start} {side:?}");
            let mut case = plain(name, &method, &[alpha], ior, (side, Transmission), truths);
            case.options = FitOptions {
                fit_ior: true,
                ..options(Surface::Dielectric { ior: start })
            };
            case.rays = 600_000;
            let fit = case.check(seed);
            assert!(fit.ior.is_some_and(|n| n.to_bits() == value(&fit, "ior").0.to_bits()));
        }
    }
}

#[test]
fn a_calibration_factor_on_all_readings() {
    for (seed, alpha, side) in [(4001, 0.05, Source), (4002, 0.2, Detector), (4003, 0.5, Source)] {
        let method = GgxMethod::new(Surface::Dielectric { ior: 1.49 });
        let truths = vec![("alpha", alpha, RECOVERED_ALPHA), ("gain", 0.8, RECOVERED_GAIN)];
        let name = format!("ggx {alpha} times 0.8 {side:?}");
        let mut case = plain(name, &method, &[alpha], 1.49, (side, Transmission), truths);
        case.options.fit_gain = true;
        case.gain = 0.8;
        case.rays = 400_000;
        case.check(seed);
    }
}

#[test]
fn both_laws_of_normals() {
    let mut seed = 5000;
    for (method, label, shapes) in [
        (GAUSS, "gauss", [[3.0, 2.0], [10.0, 1.5], [20.0, 3.0]]),
        (CAUCHY, "cauchy", [[3.0, 4.0], [8.0, 3.0], [15.0, 6.0]]),
    ] {
        for [delta, n] in shapes {
            for side in [Source, Detector] {
                seed += 1;
                let truths =
                    vec![("delta", delta, RECOVERED_DELTA), ("n", n, RECOVERED_EXPONENT)];
                let name = format!("normals {label} {delta} deg n {n} {side:?}");
                let sides = (side, Transmission);
                let mut case = plain(name, &method, &[delta, n], 1.49, sides, truths);
                case.rays = 600_000;
                case.check(seed);
            }
        }
    }
}

#[test]
fn an_opaque_body_with_a_lambert_floor() {
    let values = [(0.05, 0.6, 0.02), (0.2, 0.5, 0.05), (0.45, 0.47, 0.03)];
    for (seed, (alpha, gain, lambert)) in (6001..).zip(values) {
        let method = GgxMethod::new(Surface::Opaque);
        let case = Case {
            name: format!("opaque ggx {alpha} {gain} {lambert}"),
            sample: Virtual::opaque(alpha, gain, lambert),
            method: &method,
            options: options(Surface::Opaque),
            rays: 2_000_000,
            gain: 1.0,
            truths: vec![
                ("alpha", alpha, RECOVERED_ALPHA),
                ("gain", gain, RECOVERED_GAIN),
                ("lambert", lambert, RECOVERED_LAMBERT),
            ],
        };
        case.check(seed);
    }
}

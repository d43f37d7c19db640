//! Scans made by Monte Carlo from known models are recovered by the deterministic fit.

use asperity::fit::FitOptions;
use asperity::forward::Rays;
use asperity::measurement::Measurement;
use asperity::method::{Body, GgxMethod, Method};
use asperity_core::gonio::Geometry::{self, Reflection, Transmission};
use asperity_core::plate::RoughSide::{self, Detector, Source};
use asperity_tests::tolerance::{
    BEST, FORWARD_MODEL, PULL, PULL_RMS, RECOVERED_ALPHA, RECOVERED_ALPHA_WITHIN, RECOVERED_DELTA,
    RECOVERED_EXPONENT, RECOVERED_GAIN, RECOVERED_IOR, RECOVERED_LAMBERT, Tolerance,
};
use asperity_tests::{count, extensive};

use crate::common::{CAUCHY, GAUSS, Virtual, fitted, grid, options, value};

/// Factor on all readings of an instrument out of calibration.
const CALIBRATED: f64 = 0.8;

const SIGMAS: [f64; 3] = [0.0, 30.0, 60.0];
const STEPS_PER_DEGREE: u32 = 5;

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

impl<'a> Case<'a> {
    /// A plate whose index is known.
    fn plate(
        method: &'a dyn Method,
        values: &[f64],
        ior: f64,
        sides: (RoughSide, Geometry),
        truths: Vec<Truth>,
    ) -> Self {
        let law = method.profile().unwrap_or_default();
        Case {
            name: format!("{} {law} {values:?} n {ior} {:?} {:?}", method.name(), sides.0, sides.1),
            sample: Virtual::plate(method, values, ior, sides.0, sides.1),
            method,
            options: options(Body::Dielectric { ior }),
            rays: 200_000,
            gain: 1.0,
            truths,
        }
    }

    /// More rays, and a detector as wide as the lobe allows: few of them leave in the plane.
    fn with_light(mut self, rays: usize, aperture_deg: f64) -> Self {
        self.rays = rays;
        self.sample.setup.aperture_deg = aperture_deg;
        self
    }

    /// Scans, fits and prints; what is wrong goes to `wrong`.
    fn check(&self, seed: u64, wrong: &mut Vec<String>) {
        let rays = Rays { count: count(self.rays) as u64, seed };
        let scan = self.sample.noisy_scan(&SIGMAS, &grid(STEPS_PER_DEGREE), rays, self.gain);
        let fit = fitted(self.method, &scan, &self.sample.setup, &self.options).unwrap();
        let name = format!("{}, seed {seed}", self.name);
        let (cost, truth_cost) = (fit.objective.1, self.cost_of_the_truth(&scan));
        println!("{name}: {} {cost:.5}, the truth has {truth_cost:.5}", fit.objective.0);
        let mut claim = |right: bool, what: String| {
            if !right {
                wrong.push(format!("{name}: {what}"));
            }
        };
        claim(fit.termination.word() == "converged", format!("{:?}", fit.termination));
        // what a fit ends at is the minimum: no worse than anything else, the truth included
        let best = cost <= truth_cost * (1.0 + BEST.allowed);
        claim(best, format!("ended at {cost}, the truth has {truth_cost}"));
        for &(parameter, truth, limit) in &self.truths {
            let (found, error) = value(&fit, parameter);
            let scale = if parameter == "ior" { 1.0 } else { truth };
            let (off, pull) = ((found - truth) / scale, (found - truth) / error);
            println!(
                "    {parameter} {found:.5} +- {error:.5} (true {truth}): off {off:+.5}, {:.5} allowed = \
                 {:.1} standard errors, pull {pull:+.2}, {} evaluations",
                limit.allowed,
                limit.allowed * scale / error,
                fit.evaluations
            );
            claim(off.abs() <= limit.allowed, format!("{parameter} {found}, true {truth}"));
            // a deviation this small is the forward model's, not the noise's
            let noise = pull.abs() < PULL.allowed || off.abs() < FORWARD_MODEL.allowed;
            claim(noise, format!("{parameter} pull {pull:.2}"));
        }
        if let Some(ior) = fit.ior.filter(|_| self.options.fit_ior) {
            claim(ior.to_bits() == value(&fit, "ior").0.to_bits(), "two values of ior".into());
        }
    }

    /// What the fit minimises, at the values the scan was made from.
    fn cost_of_the_truth(&self, scan: &Measurement) -> f64 {
        let exact = self.sample.quadrature(&SIGMAS, &grid(STEPS_PER_DEGREE)).values;
        let (objective, largest) = (self.options.objective, scan.largest_reading());
        let pairs = scan.readings().iter().zip(&exact);
        let squares: f64 =
            pairs.map(|(m, s)| objective.residual(m.value, s * self.gain, largest).powi(2)).sum();
        objective.of_mean_square(squares / exact.len() as f64)
    }
}

/// Checks cases, each with a seed of its own, and tells of all that is wrong.
fn check_all<'a>(seed: u64, cases: impl IntoIterator<Item = Case<'a>>) {
    let mut wrong = Vec::new();
    for (seed, case) in (seed..).zip(cases) {
        case.check(seed, &mut wrong);
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn ggx(ior: f64) -> GgxMethod {
    GgxMethod::new(Body::Dielectric { ior })
}

#[test]
fn ggx_of_a_plate_in_transmission_from_both_sides() {
    let method = ggx(1.49);
    let mut cases = Vec::new();
    for (alpha, aperture_deg) in [(0.05, 0.6), (0.2, 2.0), (0.5, 4.0)] {
        for (ior, side) in [(1.49, Source), (1.49, Detector), (1.6, Source), (1.6, Detector)] {
            let truths = vec![("alpha", alpha, RECOVERED_ALPHA)];
            let case = Case::plate(&method, &[alpha], ior, (side, Transmission), truths);
            cases.push(case.with_light(500_000, aperture_deg));
        }
    }
    check_all(1000, cases);
}

#[test]
fn ggx_of_a_plate_in_reflection_off_the_front() {
    let method = ggx(1.49);
    let cases = [(0.05, 0.6), (0.2, 4.0), (0.5, 8.0)].map(|(alpha, aperture_deg)| {
        let truths = vec![("alpha", alpha, RECOVERED_ALPHA)];
        let case = Case::plate(&method, &[alpha], 1.49, (Source, Reflection), truths);
        case.with_light(2_000_000, aperture_deg)
    });
    check_all(2000, cases);
}

#[test]
fn ggx_of_a_plate_in_reflection_off_the_back() {
    let method = ggx(1.49);
    let cases = [(0.05, 2.0), (0.2, 6.0)].map(|(alpha, aperture_deg)| {
        let truths = vec![("alpha", alpha, RECOVERED_ALPHA_WITHIN)];
        let case = Case::plate(&method, &[alpha], 1.49, (Detector, Reflection), truths);
        case.with_light(1_000_000, aperture_deg)
    });
    check_all(2100, cases);
}

#[test]
fn ggx_and_the_refractive_index_from_a_wrong_start() {
    let method = ggx(1.49);
    let cases = [
        (0.2, 1.49, 1.6, Source, 3.0),
        (0.2, 1.6, 1.4, Detector, 3.0),
        (0.5, 1.49, 1.4, Detector, 8.0),
        (0.5, 1.6, 1.49, Source, 8.0),
    ]
    .map(|(alpha, ior, start, side, aperture_deg)| {
        let truths = vec![("alpha", alpha, RECOVERED_ALPHA), ("ior", ior, RECOVERED_IOR)];
        let case = Case::plate(&method, &[alpha], ior, (side, Transmission), truths);
        let mut case = case.with_light(3_000_000, aperture_deg);
        case.name = format!("{} from {start}", case.name);
        let start = Body::Dielectric { ior: start };
        case.options = FitOptions { fit_ior: true, ..options(start) };
        case
    });
    check_all(3000, cases);
}

#[test]
fn a_calibration_factor_on_all_readings() {
    let method = ggx(1.49);
    let cases = [(0.05, Source, 0.6), (0.2, Detector, 3.0), (0.5, Source, 6.0)];
    let cases = cases.map(|(alpha, side, aperture_deg)| {
        let gain = CALIBRATED;
        let truths = vec![("alpha", alpha, RECOVERED_ALPHA), ("gain", gain, RECOVERED_GAIN)];
        let case = Case::plate(&method, &[alpha], 1.49, (side, Transmission), truths);
        let mut case = case.with_light(1_500_000, aperture_deg);
        case.name = format!("{} times {gain}", case.name);
        case.options.fit_gain = true;
        case.gain = gain;
        case
    });
    check_all(4000, cases);
}

#[test]
fn both_laws_of_normals() {
    let mut cases = Vec::new();
    for (method, shapes) in [
        (&GAUSS, [[3.0, 2.0], [10.0, 1.5], [20.0, 3.0]]),
        (&CAUCHY, [[3.0, 4.0], [8.0, 3.0], [15.0, 6.0]]),
    ] {
        for (k, [delta, n]) in shapes.into_iter().enumerate() {
            let truths = vec![("delta", delta, RECOVERED_DELTA), ("n", n, RECOVERED_EXPONENT)];
            let side = if k % 2 == 0 { Source } else { Detector };
            let aperture_deg = if k == 0 { 0.6 } else { 3.0 };
            let case = Case::plate(method, &[delta, n], 1.49, (side, Transmission), truths);
            cases.push(case.with_light(600_000, aperture_deg));
        }
    }
    check_all(5000, cases);
}

#[test]
fn an_opaque_body_with_a_lambert_floor() {
    let method = GgxMethod::new(Body::Opaque);
    let shapes = [(0.1, 0.5, 0.1, 3.0), (0.2, 0.5, 0.05, 6.0), (0.3, 0.47, 0.03, 10.0)];
    let cases = shapes.map(|(alpha, gain, lambert, aperture_deg)| Case {
        name: format!("opaque ggx {alpha} {gain} {lambert}"),
        sample: Virtual::opaque(alpha, gain, lambert).with_aperture(aperture_deg),
        method: &method,
        options: options(Body::Opaque),
        rays: 4_000_000,
        gain: 1.0,
        truths: vec![
            ("alpha", alpha, RECOVERED_ALPHA),
            ("gain", gain, RECOVERED_GAIN),
            ("lambert", lambert, RECOVERED_LAMBERT),
        ],
    });
    check_all(6000, cases);
}

#[test]
fn a_weak_floor_beside_a_strong_lobe_is_not_lost() {
    // the noise of the lobe hides most of the floor, yet no fit may end above the error of the truth
    let method = GgxMethod::new(Body::Opaque);
    let case = Case {
        name: "opaque ggx 0.05 0.6 0.02".into(),
        sample: Virtual::opaque(0.05, 0.6, 0.02),
        method: &method,
        options: options(Body::Opaque),
        rays: 2_000_000,
        gain: 1.0,
        truths: vec![("alpha", 0.05, RECOVERED_ALPHA), ("gain", 0.6, RECOVERED_GAIN)],
    };
    check_all(6001, [case]);
}

#[test]
fn standard_errors_are_as_large_as_the_scatter_of_the_fits() {
    let method = ggx(1.49);
    for (alpha, side, geometry, rays) in [
        (0.05, Source, Transmission, 50_000),
        (0.05, Detector, Transmission, 50_000),
        (0.2, Source, Transmission, 50_000),
        (0.05, Detector, Reflection, 300_000),
    ] {
        if geometry == Reflection && !extensive() {
            continue;
        }
        let sample = Virtual::plate(&method, &[alpha], 1.49, side, geometry);
        let seeds = 8001..8001 + count(16) as u64;
        let n = seeds.clone().count() as f64;
        let pulls: Vec<f64> = seeds
            .map(|seed| {
                let rays = Rays { count: rays, seed };
                let scan = sample.noisy_scan(&SIGMAS, &grid(STEPS_PER_DEGREE), rays, 1.0);
                let options = options(Body::Dielectric { ior: 1.49 });
                let fit = fitted(&method, &scan, &sample.setup, &options).unwrap();
                let (found, error) = value(&fit, "alpha");
                (found - alpha) / error
            })
            .collect();
        let rms = (pulls.iter().map(|p| p * p).sum::<f64>() / n).sqrt();
        let worst = pulls.iter().fold(0.0, |worst: f64, p| worst.max(p.abs()));
        println!("ggx {alpha} {side:?} {geometry:?}: rms pull {rms:.2}, worst {worst:.2} of {n}");
        assert!(
            rms < PULL_RMS.allowed && rms > 1.0 / PULL_RMS.allowed,
            "ggx {alpha} {side:?} {geometry:?}: rms pull {rms:.2} of {n}, worst {worst:.2}"
        );
    }
}

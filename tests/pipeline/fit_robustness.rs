//! What a fit makes of readings that make no sense, and of a user who stops it: a result with finite
//! numbers or an error that says why, never a panic.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use asperity::fit::{
    Fit, FitError, FitOptions, FitRays, MISFIT_PERCENT, Objective, Termination, fit,
};
use asperity::forward::{Rays, Sample, Setup};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod, Method};
use asperity::watch::{Progress, Watch};
use asperity_core::gonio::Geometry::{Reflection, Transmission};
use asperity_core::math::Real;
use asperity_core::plate::RoughSide::Source;
use asperity_tests::extensive;
use rand_pcg::Pcg64Mcg;

use crate::common::{CAUCHY, GAUSS, Virtual, angles, fitted, grid, measurement, options, value};

const OBJECTIVES: [Objective; 3] = [Objective::Rmsd, Objective::Relative, Objective::Log];
const CLEAR: Body = Body::Dielectric { ior: 1.49 };
/// Evaluations that a senseless fit may take.
const BUDGET: u64 = 40;

/// Readings at incidences of 0 and 45 degrees, every fifth degree.
fn readings(value: impl Fn(f64, f64) -> f64) -> Vec<Reading> {
    let thetas = (-18..=18).map(|k| 5.0 * f64::from(k));
    let points = thetas.flat_map(|theta| [(0.0, theta), (45.0, theta)]);
    let reading = |(sigma_deg, theta_deg)| {
        Reading::in_plane(sigma_deg, theta_deg, value(sigma_deg, theta_deg))
    };
    points.map(reading).collect()
}

/// Seeded uniform numbers, one a call.
fn noise(seed: u128) -> impl FnMut() -> f64 {
    let mut generator = Pcg64Mcg::new(seed);
    move || f64::uniform(&mut generator)
}

/// Measurements that no surface gives.
fn pathological() -> Vec<(&'static str, Vec<Reading>)> {
    let spike = |at: f64, height: f64| {
        move |sigma: f64, theta: f64| {
            if sigma < 1.0 && (theta - at).abs() < 2.5 { height } else { 0.0 }
        }
    };
    let lobe = |scale: f64| {
        move |sigma: f64, theta: f64| scale * (-((theta - sigma) / 10.0_f64).powi(2)).exp()
    };
    let mut uniform = noise(9001);
    let values: Vec<f64> = (0..74).map(|_| uniform()).collect();
    let mut random = readings(|_, _| 0.0);
    for (reading, value) in random.iter_mut().zip(&values) {
        reading.value = *value;
    }
    let mut noisy = readings(lobe(1e-3));
    for (reading, value) in noisy.iter_mut().zip(&values) {
        reading.value += 4e-5 * (value - 0.5);
    }
    let one = |theta_deg, value| vec![Reading::in_plane(30.0, theta_deg, value)];
    vec![
        ("one reading", one(30.0, 0.5)),
        ("one reading at the horizon", one(90.0, 0.5)),
        ("constant", readings(|_, _| 1.0)),
        ("a spike at the centre", readings(spike(0.0, 1.0))),
        ("a spike at the horizon", readings(spike(90.0, 1.0))),
        ("a spike far from the beam", readings(spike(-60.0, 1e3))),
        ("a mirror", readings(|s, t| if (t - s).abs() < 2.5 { 1.0 } else { 0.0 })),
        ("noise alone", random),
        ("a lobe with noise about zero", noisy),
        ("huge", readings(lobe(1e300))),
        ("largest of all", readings(lobe(f64::MAX))),
        ("tiny", readings(lobe(1e-300))),
        ("subnormal", readings(|s, t| if (t - s).abs() < 5.0 { 5e-324 } else { 0.0 })),
        ("huge beside tiny", readings(|s, _| if s < 1.0 { 1e300 } else { 1e-300 })),
        ("dark at one incidence", readings(|s, t| if s < 1.0 { 0.0 } else { lobe(1.0)(s, t) })),
    ]
}

/// All setups a fit can meet: method, body, instrument.
fn setups() -> Vec<(&'static str, Box<dyn Method>, Body, Setup)> {
    let plate = |geometry| Setup {
        sample: Sample::Plate { eta: CLEAR.eta().unwrap(), rough_side: Source },
        geometry,
        aperture_deg: 0.6,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let opaque = Setup {
        sample: Sample::Opaque,
        geometry: Reflection,
        aperture_deg: 0.0,
        slit_height_deg: None,
        quantity: Quantity::Bsdf,
    };
    vec![
        ("ggx", Box::new(GgxMethod::new(CLEAR)), CLEAR, plate(Transmission)),
        ("ggx reflection", Box::new(GgxMethod::new(CLEAR)), CLEAR, plate(Reflection)),
        ("gauss", Box::new(GAUSS), CLEAR, plate(Transmission)),
        ("cauchy", Box::new(CAUCHY), CLEAR, plate(Transmission)),
        ("opaque", Box::new(GgxMethod::new(Body::Opaque)), Body::Opaque, opaque),
    ]
}

/// What is wrong with a result, whatever it was fitted to.
fn complaint(result: &Result<Fit, FitError>) -> Option<String> {
    let fit = match result {
        Ok(fit) => fit,
        Err(FitError::TooFewReadings { .. } | FitError::NoStart) => return None,
        Err(other) => return Some(format!("unexpected error: {other}")),
    };
    for p in &fit.parameters {
        if !p.value.is_finite() || p.std_error.is_some_and(|e| !(e.is_finite() && e > 0.0)) {
            return Some(format!("{p:?}"));
        }
    }
    if let Some(r) = fit.readings.iter().find(|r| !(r.is_finite() && **r >= 0.0)) {
        return Some(format!("a simulated reading is {r:e}"));
    }
    // readings of 1e-300 are beyond any percentage, but then the answer must be no
    let errors = fit.incidences.iter().filter_map(|i| i.rmsd_percent);
    let finite = errors.chain([fit.rmsd_percent, fit.objective.1]).all(f64::is_finite);
    if !finite && fit.refusal(MISFIT_PERCENT).is_none() {
        return Some(format!(
            "described, with RMSD {} %, objective {:?}, {:?}",
            fit.rmsd_percent, fit.objective, fit.incidences
        ));
    }
    if fit.evaluations == 0 || !fit.neglected.flux.is_finite() || !fit.neglected.reading.is_finite()
    {
        return Some(format!("{} evaluations, {:?}", fit.evaluations, fit.neglected));
    }
    None
}

#[test]
fn readings_without_sense_give_finite_numbers_or_a_clear_error() {
    let mut wrong = Vec::new();
    for (what, readings) in pathological() {
        let scan = Measurement::new(Metadata::default(), readings).expect(what);
        for (label, method, body, setup) in setups() {
            for objective in OBJECTIVES {
                for free in [false, true] {
                    // `free` is the index and the calibration of a plate
                    let quick = matches!(label, "ggx" | "opaque") || objective == Objective::Log;
                    if free && body == Body::Opaque || !(quick || extensive()) {
                        continue;
                    }
                    let options = FitOptions {
                        objective,
                        fit_ior: free,
                        fit_gain: free,
                        max_evaluations: BUDGET,
                        rays: FitRays::default(),
                        ..options(body)
                    };
                    let result = fitted(&*method, &scan, &setup, &options);
                    if let Some(complaint) = complaint(&result) {
                        wrong.push(format!("{what}, {label} {objective} free {free}: {complaint}"));
                    }
                    if what.starts_with("one") && free {
                        let few = matches!(result, Err(FitError::TooFewReadings { .. }));
                        assert!(few, "{what} {label}: {:?}", result.map(|f| f.parameters));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong: {wrong:#?}", wrong.len());
}

#[test]
fn noise_is_not_called_described() {
    let (_, noise) = pathological().into_iter().find(|(what, _)| *what == "noise alone").unwrap();
    let scan = Measurement::new(Metadata::default(), noise).unwrap();
    for (label, method, body, setup) in setups() {
        let fit = fitted(&*method, &scan, &setup, &options(body)).unwrap();
        println!("{label}: {:?}", fit.refusal(MISFIT_PERCENT));
        assert!(fit.refusal(MISFIT_PERCENT).is_some(), "{label}: {:?}", fit.parameters);
    }
}

#[test]
fn values_that_make_no_boundary_are_refused_before_the_work() {
    let (scan, setup) = good_scan();
    for ior in [f64::NAN, f64::INFINITY, 0.0, -1.5, 1e9] {
        let options = options(Body::Dielectric { ior });
        let result = fitted(&GgxMethod::new(CLEAR), &scan, &setup, &options);
        let error = result.map(|fit| fit.parameters).unwrap_err();
        assert!(matches!(error, FitError::Build(_)), "{ior}: {error}");
        assert!(error.to_string().contains("refractive index"), "{error}");
    }
    let refused = fitted(&GAUSS, &scan, &setup, &options(Body::Opaque));
    assert!(refused.is_err(), "normals of an opaque body");
}

/// A scan that any method describes, small enough for many fits.
fn good_scan() -> (Measurement, Setup) {
    let sample = Virtual::ggx(0.2, 1.49);
    let scan = sample.noisy_scan(&[0.0, 45.0], &grid(1), Rays { count: 100_000, seed: 9100 }, 1.0);
    (scan, sample.setup)
}

#[test]
fn a_fit_stopped_before_the_start_is_an_error_and_calls_nothing() {
    let (scan, setup) = good_scan();
    let method = GgxMethod::new(CLEAR);
    let calls = AtomicU64::new(0);
    let count = |_: Progress<'_>| {
        calls.fetch_add(1, Ordering::Relaxed);
    };
    let stopped = AtomicBool::new(true);
    let result = fit(&method, &scan, &setup, &options(CLEAR), Watch::new(&stopped, &count));
    assert!(matches!(result, Err(FitError::Interrupted)), "{:?}", result.map(|f| f.parameters));
    assert_eq!(calls.into_inner(), 0);
}

#[test]
fn a_fit_stopped_on_the_way_keeps_the_best_values_so_far() {
    let (scan, setup) = good_scan();
    let method = GgxMethod::new(CLEAR);
    let all = fitted(&method, &scan, &setup, &options(CLEAR)).unwrap();
    assert_eq!(all.termination, Termination::Converged);
    let (mut errors, mut interrupted, mut last) = (0, 0, None);
    for after in 1..=all.evaluations {
        let stop = AtomicBool::new(false);
        let progress = |told: Progress<'_>| {
            if matches!(told, Progress::Done { done, .. } if done as u64 >= after) {
                stop.store(true, Ordering::Relaxed);
            }
        };
        match fit(&method, &scan, &setup, &options(CLEAR), Watch::new(&stop, &progress)) {
            Err(FitError::Interrupted) => {
                assert!(interrupted == 0, "an error at {after}, after a result earlier");
                errors += 1;
            }
            Err(other) => panic!("stopped after {after}: {other}"),
            Ok(fit) if fit.termination == Termination::Interrupted => {
                interrupted += 1;
                assert!(fit.evaluations <= after + 1, "{} for {after}", fit.evaluations);
                assert!(fit.rmsd_percent.is_finite() && fit.refusal(MISFIT_PERCENT).is_some());
                last = Some(fit);
            }
            Ok(fit) => {
                assert_eq!(fit.termination, Termination::Converged);
                assert_eq!(value(&fit, "alpha").0.to_bits(), value(&all, "alpha").0.to_bits());
            }
        }
    }
    println!(
        "{} evaluations: {errors} stops give no result, {interrupted} the best so far",
        all.evaluations
    );
    assert!(errors > 0 && interrupted > 5);
    let (near, best) = (value(&last.unwrap(), "alpha").0, value(&all, "alpha").0);
    assert!((near / best - 1.0).abs() < 1e-2, "{near} shortly before the end, {best} at it");
}

#[test]
fn evaluations_are_limited_and_the_limit_is_told() {
    let (scan, setup) = good_scan();
    let method = GgxMethod::new(CLEAR);
    for max_evaluations in [1, 2, 5, 10, 20, 30] {
        let limited = FitOptions { max_evaluations, ..options(CLEAR) };
        let fit = fitted(&method, &scan, &setup, &limited).unwrap();
        println!(
            "at most {max_evaluations}: {} evaluations, {:?}",
            fit.evaluations, fit.termination
        );
        assert_eq!(fit.termination, Termination::MaxEvaluations, "{max_evaluations}");
        // the starts are tried whatever the limit, and a step under way is finished
        assert!(
            fit.evaluations <= max_evaluations + 20,
            "{} of {max_evaluations}",
            fit.evaluations
        );
        let refusal = fit.refusal(MISFIT_PERCENT).expect("a refusal");
        assert!(refusal.contains("--max-evaluations"), "{refusal}");
        assert_eq!(complaint(&Ok(fit)), None);
    }
}

#[test]
fn readings_do_not_depend_on_the_order_given_nor_on_the_run() {
    let (scan, setup) = good_scan();
    let mut mixed = scan.readings().to_vec();
    mixed.reverse();
    let other = Measurement::new(scan.meta.clone(), mixed).unwrap();
    let bits = |scan: &Measurement| -> Vec<u64> {
        let fit = fitted(&GAUSS, scan, &setup, &options(CLEAR)).unwrap();
        fit.parameters.iter().map(|p| p.value.to_bits()).collect()
    };
    assert_eq!(bits(&scan), bits(&other));
    assert_eq!(bits(&scan), bits(&scan));
}

#[test]
fn readings_at_the_very_ends_of_the_range_are_fitted_like_others() {
    // 89.999 degrees of incidence and readings at the horizon
    let sample = Virtual::ggx(0.2, 1.49);
    let ends = measurement(&[0.0, 89.999], &grid(1), &vec![1e-3; 2 * angles(&grid(1)).len()]);
    for objective in OBJECTIVES {
        let options = FitOptions { objective, max_evaluations: BUDGET, ..options(CLEAR) };
        let result = fitted(&GgxMethod::new(CLEAR), &ends, &sample.setup, &options);
        assert_eq!(complaint(&result), None, "{objective}");
    }
}

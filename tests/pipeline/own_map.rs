//! Methods with a surface on data of the tree: a map of 96 x 96 points and its scan by an independent ray tracer
//! (`golden/traced.py`), and scans of random heights.

use std::sync::Arc;

use asperity::boundary::Boundary;
use asperity::fit::{Fit, FitOptions, FitRays};
use asperity::forward::{Angles, Effort, Rays, Sample, Setup, monte_carlo, simulate};
use asperity::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use asperity::measurement::{Measurement, Quantity, csv};
use asperity::method::{Body, Choice, Kind, Method};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, Preparation, Prepared, Purpose};
use asperity::watch::Watch;
use asperity_core::gonio::Geometry;
use asperity_core::metric::rmsd_percent;
use asperity_core::plate::RoughSide;
use asperity_tests::tolerance::{
    RECOVERED_HEIGHTS, SCALE_OF_SMALL_MAP, TRACED_FLUX, TRACED_SMALL_MAP,
};
use asperity_tests::{extensive, golden};

use crate::common::{angles, fitted, grid, least, measurement, options, value};
use crate::real_scans::setup;

const CLEAR: Body = Body::Dielectric { ior: 1.49 };

/// Transmitted flux of the independent tracer at 0, 20, 45 and 65 degrees.
const TRANSMITTED: [f64; 4] = [0.925485, 0.924276, 0.880204, 0.519451];

fn sample() -> (Measurement, Prepared) {
    let preparation = Preparation { pixel_um: Some(1.0), ..Preparation::default() };
    let prepared = preparation.load(&golden::path("traced_map.npy"), Purpose::Light).unwrap();
    assert_eq!(prepared.edges, Edges::Periodic);
    (csv::read(golden::path("traced_scan.csv")).unwrap(), prepared)
}

fn light() -> WaveOptions {
    let wavelengths = Wavelengths::single(550.0).unwrap();
    WaveOptions { wavelengths, speckle: Speckle::Averaged, shadowing: Shadowing::Off }
}

/// Few rays.
fn quick() -> FitOptions {
    let rays = FitRays { draft: 10_000, fit: Some(40_000), last: Some(200_000), seed: 3 };
    FitOptions { rays, max_evaluations: 60, ..options(CLEAR) }
}

/// The heights are given as so much of what they are.
const FLATTER: f64 = 0.9;

/// A method on the map of the tree, flattened.
fn method(name: &str) -> Box<dyn Method> {
    let (_, prepared) = sample();
    let map = prepared.map.map(|_, _, height| FLATTER * height);
    let (wave, kind) = (light(), Kind::named(name).unwrap());
    let choice = Choice {
        map: kind.needs_map.then_some((&map, prepared.edges)),
        wave: kind.is_wave().then_some(&wave),
        ..Choice::new(name, CLEAR)
    };
    choice.method().unwrap()
}

/// A fit of the scan of the tree.
fn fit_of(name: &str) -> Fit {
    let (scan, _) = sample();
    let fit = fitted(&*method(name), &scan, &setup(&scan), &quick()).unwrap();
    println!(
        "{name}: {:?}, RMSD {:.3} %, ray noise {:?} %, {} evaluations",
        fit.parameters, fit.rmsd_percent, fit.simulation_noise_percent, fit.evaluations
    );
    fit
}

#[test]
fn a_scan_of_a_small_map_is_that_of_the_independent_tracer() {
    let (scan, prepared) = sample();
    let field = Arc::new(Field::new(&prepared.map, prepared.edges).unwrap());
    let boundary = TracedBoundary { field, eta: CLEAR.eta().unwrap() };
    let (setup, plan) = (setup(&scan), Angles::of(&scan));
    let mut values = Vec::new();
    for (angles, expected) in plan.incidences.iter().zip(TRANSMITTED) {
        let rays = Rays { count: 500_000, seed: 11 };
        let done = monte_carlo(&boundary, &setup, angles, rays, Watch::nobody()).unwrap();
        let found = done.outcome.transmitted;
        println!("sigma {}: T {found:.5}, {expected:.5}", angles.sigma_deg);
        assert!((found - expected).abs() < TRACED_FLUX.allowed, "{found} {expected}");
        assert!(done.outcome.lost.abs() < 1e-9, "{:?}", done.outcome);
        values.extend(done.values);
    }
    let measured: Vec<f64> = scan.readings().iter().map(|r| r.value).collect();
    let error = rmsd_percent(&measured, &values).unwrap();
    println!("eq. (18) {error:.3} %");
    assert!(error <= TRACED_SMALL_MAP.allowed, "{error} %");
}

#[test]
fn the_heights_of_a_small_map_are_found_by_rays() {
    let fit = fit_of("measured-ray");
    let scale = FLATTER * fit.parameters[0].value;
    println!("{scale:.4} of the heights");
    assert!((scale - 1.0).abs() < SCALE_OF_SMALL_MAP.allowed, "{scale}");
    assert!(fit.refusal(15.0).is_none());
    assert!(fit.rmsd_percent <= 2.0 * TRACED_SMALL_MAP.allowed, "{}", fit.rmsd_percent);
}

/// Slopes of 0.28 at pixels of 1 um: Kirchhoff's integral is no way to trace them, and says so.
#[test]
fn waves_on_a_steep_small_map_say_that_they_fail() {
    let fit = fit_of("measured-wave");
    assert!(fit.refusal(15.0).is_some());
    let (_, prepared) = sample();
    let wave = WaveBoundary::of_map(&prepared.map, prepared.edges, CLEAR.eta().unwrap(), &light());
    let warnings = Boundary::Wave(Box::new(wave.unwrap())).warnings(&[0.0, 20.0, 45.0, 65.0]);
    println!("{}", warnings.join("\n"));
    for word in ["horizon", "beyond the critical", "pixel", "phase"] {
        assert!(warnings.iter().any(|w| w.contains(word)), "{word}: {warnings:?}");
    }
}

#[test]
fn closed_forms_describe_the_light_of_a_small_map_less_well_than_the_map() {
    for name in ["ggx", "normals"] {
        let fit = fit_of(name);
        let worse = 2.0 * TRACED_SMALL_MAP.allowed;
        assert!(fit.rmsd_percent > worse, "{name} {}", fit.rmsd_percent);
    }
}

#[test]
fn the_width_of_random_heights_is_found_with_other_random_heights() {
    let sample = Sample::Plate { eta: CLEAR.eta().unwrap(), rough_side: RoughSide::Source };
    let setup = Setup {
        sample,
        geometry: Geometry::Transmission,
        aperture_deg: 2.0,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    for (profile, truth) in [("gauss", 0.2), ("cauchy", 0.05)] {
        let method = |seed| {
            let choice = Choice { profile: Some(profile), seed, ..Choice::new("heights", CLEAR) };
            choice.method().unwrap()
        };
        let boundary = method(1).boundary(&[truth], CLEAR).unwrap();
        let (sigmas, grid) = ([0.0, 40.0], grid(1));
        let plan = Angles::product(&sigmas, &angles(&grid));
        let (rays, watch) = (Rays { count: 200_000, seed: 1 }, Watch::nobody());
        let readings = simulate(&boundary, &setup, &plan, Effort::Full, rays, watch).unwrap();
        let scan = measurement(&sigmas, &grid, &readings.values);
        let (errors, at) = least(&*method(2), &scan, &setup, &quick(), truth);
        println!("{profile}: errors {errors:.3?} %, least at {at:.4} of the width");
        assert!((at - 1.0).abs() < RECOVERED_HEIGHTS.allowed, "{profile} {at}");
        assert!(errors[1] < 1.0 && errors[1] < errors[0].min(errors[2]), "{profile} {errors:?}");
        if extensive() {
            let fit = fitted(&*method(2), &scan, &setup, &quick()).unwrap();
            let (found, error) = value(&fit, "delta");
            println!("{profile}: delta {found:.4} +- {error:.4}, true {truth}");
            assert!((found / truth - 1.0).abs() < RECOVERED_HEIGHTS.allowed, "{found} {truth}");
        }
    }
}

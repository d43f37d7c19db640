//! The two virtual samples with their height maps: virtual scans of the maps against an independent
//! ray tracer's, and fits of the methods that trace rays.

use std::sync::Arc;

use asperity::fit::{Fit, FitOptions, FitRays};
use asperity::forward::{Angles, Incidence, Rays, monte_carlo};
use asperity::measurement::{Measurement, csv};
use asperity::method::{Body, Choice, Kind, Method};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, Preparation, Prepared, Purpose};
use asperity::watch::Watch;
use asperity_core::metric::rmsd_percent;
use asperity_tests::tolerance::{
    SCALE_OF_MAP, TRACED_FLUX, TRACED_SAMPLE_5, TRACED_SAMPLE_8, Tolerance,
};
use asperity_tests::{data, extensive};

use crate::common::{fitted, options};
use crate::real_scans::setup;

const CLEAR: Body = Body::Dielectric { ior: 1.49 };

/// Totals of the transmitted flux that the independent tracer gives, at 0, 15, 30, 45 and 60 degrees.
const T_5: [f64; 5] = [0.9255, 0.9249, 0.9214, 0.9020, 0.7630];
const T_8: [f64; 5] = [0.9266, 0.9262, 0.9208, 0.8581, 0.5473];

pub(crate) fn sample(number: u32, pixel_um: f64) -> Option<(Measurement, Prepared)> {
    let scan = data::find(&format!("samples/scan{number}.csv"))?;
    let map = data::find(&format!("samples/sample{number}.npy"))?;
    let preparation = Preparation { pixel_um: Some(pixel_um), ..Preparation::default() };
    let prepared = preparation.load(&map, Purpose::Light).unwrap();
    assert_eq!(prepared.edges, Edges::Periodic);
    Some((csv::read(scan).unwrap(), prepared))
}

fn agrees(number: u32, pixel_um: f64, transmitted: [f64; 5], rays: u64, limit: Tolerance) {
    let Some((scan, prepared)) = sample(number, pixel_um) else { return };
    let field = Arc::new(Field::new(&prepared.map, prepared.edges).unwrap());
    let boundary = TracedBoundary { field, eta: CLEAR.eta().unwrap() };
    let (setup, plan) = (setup(&scan), Angles::of(&scan));
    let rays = if extensive() { 5 * rays } else { rays };
    let rays = Rays { count: rays, seed: 11 };
    let mut values = Vec::new();
    for (angles, expected) in plan.incidences.iter().zip(transmitted) {
        let done = monte_carlo(&boundary, &setup, angles, rays, Watch::nobody()).unwrap();
        println!("sample {number}: sigma {}, {:?}", angles.sigma_deg, done.outcome);
        let found = done.outcome.transmitted;
        assert!((found - expected).abs() < TRACED_FLUX.allowed, "{found} {expected}");
        let sum = done.outcome.reflected + found + done.outcome.lost;
        assert!((sum - 1.0).abs() < 1e-9 && done.outcome.lost.abs() < 1e-9, "{:?}", done.outcome);
        values.extend(done.values);
    }
    let measured: Vec<f64> = scan.readings().iter().map(|r| r.value).collect();
    let error = rmsd_percent(&measured, &values).unwrap();
    println!("sample {number}: eq. (18) {error:.3} % with {} rays", rays.count);
    assert!(error <= limit.allowed, "{error} %");
}

#[test]
fn a_scan_of_the_map_of_sample_5_is_that_of_the_independent_tracer() {
    agrees(5, 0.361, T_5, 2_000_000, TRACED_SAMPLE_5);
}

#[test]
fn a_scan_of_the_map_of_sample_8_is_that_of_the_independent_tracer() {
    agrees(8, 1.42, T_8, 2_000_000, TRACED_SAMPLE_8);
}

fn traced_fit(number: u32, pixel_um: f64, name: &str) -> Option<Fit> {
    let (scan, prepared) = sample(number, pixel_um)?;
    let choice = Choice {
        asked: &|name| name == "cutoff_um",
        map: Kind::named(name).unwrap().needs_map.then_some((&prepared.map, prepared.edges)),
        ..Choice::new(name, CLEAR)
    };
    let method: Box<dyn Method> = choice.method().unwrap();
    let rays = if extensive() {
        FitRays::default()
    } else {
        FitRays {
            draft: 50_000,
            fit: Some(if number == 5 { 200_000 } else { 800_000 }),
            last: Some(1_500_000),
            seed: 3,
        }
    };
    let fit = fitted(&*method, &scan, &setup(&scan), &FitOptions { rays, ..options(CLEAR) });
    let fit = fit.unwrap();
    println!(
        "sample {number} {name}: {:?}, RMSD {:.3} %, ray noise {:?} %, {} evaluations",
        fit.parameters, fit.rmsd_percent, fit.simulation_noise_percent, fit.evaluations
    );
    assert!(fit.refusal(15.0).is_none());
    Some(fit)
}

#[test]
fn the_map_of_sample_5_is_found_at_its_own_scale() {
    let Some(fit) = traced_fit(5, 0.361, "measured-ray") else { return };
    assert!((fit.parameters[0].value - 1.0).abs() < SCALE_OF_MAP.allowed);
    assert!(fit.rmsd_percent <= 0.5, "{}", fit.rmsd_percent);
}

#[test]
fn the_map_of_sample_8_is_found_at_its_own_scale() {
    let Some(fit) = traced_fit(8, 1.42, "measured-ray") else { return };
    assert!((fit.parameters[0].value - 1.0).abs() < SCALE_OF_MAP.allowed);
    let noise = fit.simulation_noise_percent.unwrap();
    assert!(fit.rmsd_percent <= 0.5_f64.max(1.3 * noise), "{}", fit.rmsd_percent);
}

#[test]
fn random_heights_describe_both_samples_better_than_ggx() {
    for (number, pixel_um, ggx) in [(5, 0.361, 1.528), (8, 1.42, 6.236)] {
        let Some(fit) = traced_fit(number, pixel_um, "heights") else { return };
        assert!(fit.rmsd_percent <= ggx, "sample {number}: {}", fit.rmsd_percent);
    }
}

#[test]
fn a_map_mirrored_at_its_edges_scatters_like_the_whole() {
    // a quarter of a periodic map is not periodic; it is as rough
    let Some((scan, prepared)) = sample(5, 0.361) else { return };
    let quarter = "0:700,0:700".parse::<asperity::surface::Crop>().unwrap();
    let part = quarter.of(&prepared.map).unwrap();
    assert_eq!(Edges::of(&part), Edges::Mirrored);
    let setup = setup(&scan);
    let angles = Incidence::in_plane(30.0, (0..181).map(|k| f64::from(k) - 90.0).collect());
    let rays = Rays { count: 1_000_000, seed: 2 };
    let trace = |map, edges| {
        let field = Arc::new(Field::new(map, edges).unwrap());
        let boundary = TracedBoundary { field, eta: CLEAR.eta().unwrap() };
        monte_carlo(&boundary, &setup, &angles, rays, Watch::nobody()).unwrap()
    };
    let whole = trace(&prepared.map, Edges::Periodic);
    let mirrored = trace(&part, Edges::Mirrored);
    let error = rmsd_percent(&whole.values, &mirrored.values).unwrap();
    println!("mirrored part against the whole: {error:.2} %, {:?}", mirrored.outcome);
    assert!(mirrored.outcome.lost.abs() < 1e-9);
    assert!((mirrored.outcome.transmitted - whole.outcome.transmitted).abs() < 5e-3);
    // half of the surface: its grain is the sample's own
    assert!(error < 8.0, "{error} %");
}

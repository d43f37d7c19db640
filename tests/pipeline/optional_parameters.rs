//! Parameters that the data have to ask for, and standard errors that hold.

use std::sync::Arc;

use asperity::boundary::Boundary;
use asperity::fit::{Fit, FitOptions, FitRays, Fitted};
use asperity::forward::{Angles, Rays, Sample, Setup};
use asperity::measurement::{Measurement, Quantity};
use asperity::method::{Body, Choice, GgxMethod, Method, NormalsMethod};
use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, GaussianSurface, HeightMap, LowPass};
use asperity::watch::Watch;
use asperity_core::gonio::Geometry;
use asperity_core::math::Real;
use asperity_core::ndf::law::Profile;
use asperity_core::plate::RoughSide;
use rand_pcg::Pcg64Mcg;

use crate::common::{GAUSS, Virtual, angles, fitted, grid, measurement, options, value};

const CLEAR: Body = Body::Dielectric { ior: 1.49 };
const SIGMAS: [f64; 3] = [0.0, 30.0, 60.0];

/// A normal deviate.
fn normal(generator: &mut Pcg64Mcg) -> f64 {
    let (u, v): (f64, f64) = (f64::uniform(generator), f64::uniform(generator));
    (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// The readings with independent normal noise, in parts of the largest.
fn noisy(scan: &Measurement, part: f64, seed: u64) -> Measurement {
    let generator = &mut Pcg64Mcg::new(0x5eed + u128::from(seed));
    let step = part * scan.largest_reading();
    let values: Vec<f64> =
        scan.readings().iter().map(|r| r.value + step * normal(generator)).collect();
    let sigmas: Vec<f64> = scan.by_incidence().map(|i| i.sigma_deg).collect();
    measurement(&sigmas, &grid(1), &values)
}

fn parameter<'a>(fit: &'a Fit, name: &str) -> &'a Fitted {
    fit.parameters.iter().find(|p| p.name == name).unwrap()
}

#[test]
fn one_standard_error_covers_two_of_three_truths() {
    let ggx = GgxMethod::new(CLEAR);
    let (source, transmission) = (RoughSide::Source, Geometry::Transmission);
    let cases: [(&dyn Method, &[f64], &[&str]); 2] =
        [(&ggx, &[0.2], &["alpha"]), (&GAUSS, &[9.0, 1.7], &["delta", "n"])];
    for (method, truths, names) in cases {
        let sample = Virtual::plate(method, truths, 1.49, source, transmission);
        let exact = sample.exact_scan(&SIGMAS, &grid(1));
        let mut covered = vec![0; names.len()];
        for seed in 0..40 {
            let scan = noisy(&exact, 0.01, seed);
            let fit = fitted(method, &scan, &sample.setup, &options(CLEAR)).unwrap();
            for ((name, truth), covered) in names.iter().zip(truths).zip(&mut covered) {
                let (found, error) = value(&fit, name);
                *covered += i32::from((found - truth).abs() <= error);
                // and the cost rises by 4 at two standard errors
                let profile = parameter(&fit, name).profile.unwrap();
                for rise in profile.rises {
                    assert!((rise.unwrap() - 4.0).abs() < 1.0, "{name} {profile:?}");
                }
                assert!(profile.is_confirmed());
            }
        }
        println!("{}: {covered:?} of 40 within one standard error", method.name());
        // 27.3 expected within three times its own scatter of 2.9
        assert!(covered.iter().all(|c| (18..=36).contains(c)), "{} {covered:?}", method.name());
    }
}

#[test]
fn an_error_that_the_curvature_understates_is_enlarged() {
    // a floor of one and a half standard errors: its logarithm has no parabola, and its lower side ends at nothing
    let method = GgxMethod::new(Body::Opaque);
    let sample = Virtual::opaque(0.3, 0.5, 0.004);
    let exact = sample.exact_scan(&[0.0, 45.0], &grid(1));
    for seed in 0..6 {
        let scan = noisy(&exact, 0.02, seed);
        let fit = fitted(&method, &scan, &sample.setup, &options(Body::Opaque)).unwrap();
        let floor = parameter(&fit, "lambert");
        let gain = parameter(&fit, "gain");
        println!("{floor:?}");
        assert!(floor.is_none == floor.std_error.is_none());
        assert!(gain.std_error.unwrap() >= gain.profile.unwrap().std_error);
    }
}

#[test]
fn no_floor_and_no_offset_are_kept_unless_the_data_ask() {
    let opaque = GgxMethod::new(Body::Opaque);
    let centred = NormalsMethod { profile: Profile::Gauss, centre: true };
    let (source, transmission) = (RoughSide::Source, Geometry::Transmission);
    let plate = |theta0| Virtual::plate(&centred, &[6.0, 2.0, theta0], 1.49, source, transmission);
    let cases: [(&dyn Method, &str, Virtual, Body, bool); 4] = [
        (&opaque, "lambert", Virtual::opaque(0.3, 0.5, 0.0), Body::Opaque, true),
        (&opaque, "lambert", Virtual::opaque(0.3, 0.5, 0.03), Body::Opaque, false),
        (&centred, "theta0", plate(0.0), CLEAR, true),
        (&centred, "theta0", plate(9.0), CLEAR, false),
    ];
    for (method, name, sample, surface, nothing) in cases {
        let exact = sample.exact_scan(&SIGMAS[..2], &grid(1));
        for seed in 0..8 {
            let scan = noisy(&exact, 0.01, seed);
            let fit = fitted(method, &scan, &sample.setup, &options(surface)).unwrap();
            let p = parameter(&fit, name);
            assert!(p.is_none == nothing, "{name} {nothing} {seed}: {p:?}");
            assert!(!nothing || (p.value.abs() <= 0.0 && p.std_error.is_none() && !p.at_bound));
            assert!(fit.refusal(15.0).is_none());
        }
    }
}

/// Long waves with a texture of 1.4 um on them.
fn textured() -> HeightMap {
    let part = |rq_um, length_um, seed| {
        let (size, pitches_um) = ((256, 256), (0.3, 0.3));
        let lengths_um = (length_um, length_um);
        GaussianSurface { size, pitches_um, rq_um, lengths_um, seed }.map().unwrap()
    };
    let (long, short) = (part(0.8, 10.0, 1), part(0.12, 1.4, 2));
    long.map(|x, y, h| h + short.height_um(x, y).unwrap())
}

#[test]
fn a_filter_is_found_where_there_is_one_and_else_left_out() {
    let map = textured();
    let setup = Setup {
        sample: Sample::Plate { eta: CLEAR.eta().unwrap(), rough_side: RoughSide::Source },
        geometry: Geometry::Transmission,
        aperture_deg: 1.0,
        slit_height_deg: None,
        quantity: Quantity::Flux,
    };
    let choice = Choice {
        asked: &|name| name == "cutoff_um",
        map: Some((&map, Edges::Periodic)),
        ..Choice::new("measured-ray", CLEAR)
    };
    let method = choice.method().unwrap();
    for (cutoff_um, seed) in [(None, 5), (None, 6), (Some(3.0), 7)] {
        let low_pass = LowPass::new(&map, Edges::Periodic).unwrap();
        let truth = low_pass.apply(1.0, cutoff_um).unwrap();
        let field = Arc::new(Field::new(&truth, Edges::Periodic).unwrap());
        let boundary = Boundary::Traced(TracedBoundary { field, eta: CLEAR.eta().unwrap() });
        let virtual_plate = Virtual { boundary, setup };
        let (sigmas, grid) = ([0.0, 40.0], grid(1));
        let plan = Angles::product(&sigmas, &angles(&grid));
        let rays = Rays { count: 400_000, seed: 91 + seed };
        let effort = asperity::forward::Effort::Full;
        let readings = asperity::forward::simulate(
            &virtual_plate.boundary,
            &setup,
            &plan,
            effort,
            rays,
            Watch::nobody(),
        );
        let scan = measurement(&sigmas, &grid, &readings.unwrap().values);
        let rays = FitRays { draft: 20_000, fit: Some(60_000), last: Some(200_000), seed };
        let fit = fitted(&*method, &scan, &setup, &FitOptions { rays, ..options(CLEAR) }).unwrap();
        println!("{cutoff_um:?}: {:?}, {:.3} %", fit.parameters, fit.rmsd_percent);
        let found = parameter(&fit, "cutoff_um");
        match cutoff_um {
            None => assert!(found.is_none && found.std_error.is_none(), "{found:?}"),
            Some(truth) => {
                assert!(!found.is_none && (found.value / truth - 1.0).abs() < 0.15, "{found:?}");
                assert!((found.value - truth).abs() < 4.0 * found.std_error.unwrap(), "{found:?}");
            }
        }
        let (scale, _) = value(&fit, "scale");
        assert!((scale - 1.0).abs() < 0.05, "{scale}");
    }
}

//! Methods with all bounces: balances, readings by quadrature against rays, and fits.

use asperity::boundary::Boundary;
use asperity::energy::balance;
use asperity::forward::Rays;
use asperity::method::{Body, Choice, Method};
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;

use crate::common::{Virtual, fitted, grid, options, value};

const BODY: Body = Body::Dielectric { ior: 1.49 };

fn method(name: &str, bounces: &str) -> Box<dyn Method> {
    Choice { bounces: Some(bounces), ..Choice::new(name, BODY) }.method().unwrap()
}

fn boundary(name: &str, bounces: &str, values: &[f64]) -> Boundary {
    method(name, bounces).boundary(values, BODY).unwrap()
}

fn plate(bounces: &str, alpha: f64, geometry: Geometry) -> Virtual {
    Virtual::plate(&*method("ggx", bounces), &[alpha], 1.49, RoughSide::Detector, geometry)
}

#[test]
fn no_light_is_lost_and_the_law_shares_it_as_the_walk_does() {
    let rays = Rays { count: 20_000, seed: 3 };
    for (name, values) in [
        ("ggx", vec![0.5]),
        ("beckmann", vec![0.9]),
        ("student", vec![0.4, 2.5]),
        ("smith-normals", vec![15.0, 2.0]),
    ] {
        let of = |bounces| boundary(name, bounces, &values);
        let (one, all, walk) = (of("one"), of("all"), of("walk"));
        for (side, deg) in [(Side::Air, 60.0), (Side::Dielectric, 20.0), (Side::Dielectric, 70.0)] {
            let [one, all, walk] = [&one, &all, &walk].map(|b| balance(b, side, deg, rays));
            assert!(one.lost > 0.01, "{name} {side:?} {deg}: {one:?}");
            assert!(all.lost.abs() < 6e-3 && walk.lost == 0.0, "{name} {side:?} {deg}: {all:?}");
            // four standard errors of the walk, and what the law promises
            let most = 4.0 * (0.25_f64 / 20_000.0).sqrt() + 0.01;
            assert!(
                (all.reflected - walk.reflected).abs() < most,
                "{name} {side:?} {deg}: {all:?} {walk:?}"
            );
        }
    }
}

#[test]
fn readings_by_quadrature_are_those_of_rays() {
    // the same law within the noise of its rays; eq. (18) of the difference from the walk, %, whose later bounces are not diffuse
    let (grid, rays) = (grid(1), Rays { count: 400_000, seed: 1 });
    for (alpha, geometry, of_walk) in [
        (0.3, Geometry::Transmission, 2.5),
        (0.7, Geometry::Transmission, 6.0),
        (0.3, Geometry::Reflection, 4.0),
    ] {
        let law = plate("all", alpha, geometry);
        let exact = law.quadrature(&[30.0], &grid).values;
        let peak = exact.iter().copied().fold(0.0, f64::max);
        let percent = |values: &[f64]| {
            let sum: f64 = exact.iter().zip(values).map(|(a, b)| (a - b) * (a - b)).sum();
            100.0 * (sum / exact.len() as f64).sqrt() / peak
        };
        let traced = law.monte_carlo(30.0, &grid, rays);
        let errors = traced.std_errors.iter().map(|e| e.max(1.0 / rays.count as f64));
        let pairs = exact.iter().zip(&traced.values).zip(errors);
        let squares: f64 = pairs.map(|((a, b), error)| ((a - b) / error).powi(2)).sum();
        let drawn = squares / exact.len() as f64;
        let walked = percent(&plate("walk", alpha, geometry).monte_carlo(30.0, &grid, rays).values);
        println!("{alpha} {geometry:?}: mean z^2 {drawn:.2} of rays, {walked:.3} % of the walk");
        assert!(drawn < 1.4 && walked < of_walk, "{alpha} {geometry:?}: {drawn} {walked}");
    }
}

#[test]
fn a_fit_recovers_the_width_and_says_how_many_bounces() {
    let truth = plate("all", 0.6, Geometry::Transmission);
    let scan = truth.exact_scan(&[0.0, 45.0], &grid(1));
    let method = method("ggx", "all");
    assert_eq!(method.label(), "ggx (all bounces)");
    let fit = fitted(&*method, &scan, &truth.setup, &options(BODY)).unwrap();
    assert!((value(&fit, "alpha").0 / 0.6 - 1.0).abs() < 2e-3, "{:?}", value(&fit, "alpha"));
    assert!(fit.rmsd_percent < 0.05, "{}", fit.rmsd_percent);
    assert!(matches!(fit.boundary, Boundary::AllGgx(_)));
}

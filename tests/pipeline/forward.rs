//! The quadrature of a fit against Monte Carlo of the same boundary, plate and instrument.

use asperity::forward::{Rays, Sample, Setup};
use asperity::method::{Body, GgxMethod, Method};
use asperity_core::fresnel::dielectric;
use asperity_core::gonio::AngleGrid;
use asperity_core::gonio::Geometry::{self, Reflection, Transmission};
use asperity_core::plate::RoughSide::{self, Detector, Source};
use asperity_tests::count;
use asperity_tests::tolerance::{self, INSIDE};

use crate::common::{CAUCHY, GAUSS, Virtual, grid};
use crate::student::Deviations;

/// Batches of a Monte Carlo run of at most 64 * 65536 rays, less one; with more rays there are more
/// batches, and the judgement is a little too mild.
const FREEDOM: u32 = 63;
/// Readings at a step of 0.1 degree that are at least an aperture of 0.6 degrees apart.
const APART: usize = 7;
/// Fewer rays than this in a reading are not normally distributed.
const MANY: f64 = 300.0;

/// Readings below this share of the largest are not compared one by one.
const WEAK: f64 = 0.05;

const SIGMAS: [f64; 3] = [0.0, 30.0, 60.0];
const SIDES: [(RoughSide, Geometry); 4] = [
    (Source, Transmission),
    (Detector, Transmission),
    (Source, Reflection),
    (Detector, Reflection),
];

/// Compares readings, and their sum, of one surface in one setup at all incidences.
fn compare(
    name: &str,
    sample: &Virtual,
    rays: usize,
    seed: u64,
    apart: usize,
    single: &mut Deviations,
    total: &mut Deviations,
) {
    let grid = grid(10);
    let rays = Rays { count: count(rays) as u64, seed };
    let exact = sample.quadrature(&SIGMAS, &grid).values;
    for (sigma, exact) in SIGMAS.iter().zip(exact.chunks(grid.count)) {
        let drawn = sample.monte_carlo(*sigma, &grid, rays);
        // a reading at sigma, where a narrow lobe is, and those an aperture apart from it
        let first = at(&grid, *sigma) % apart;
        let mirrored = mirrored_by_the_smooth_front(&sample.setup, *sigma);
        let (mut sum, mut variance) = (0.0, 0.0);
        for k in (first..grid.count).step_by(apart) {
            sum += exact[k] - drawn.values[k];
            variance += drawn.std_errors[k].powi(2);
            let away = (grid.degrees(k) - sigma).abs() * 2.0;
            let constant = if away <= sample.setup.aperture_deg { mirrored } else { 0.0 };
            if (exact[k] - constant) * drawn.rays as f64 > MANY {
                let z = (exact[k] - drawn.values[k]) / drawn.std_errors[k];
                single.add(z, || {
                    format!(
                        "{name}, sigma {sigma}, theta {:.1}, seed {seed}: {:.6e}, drawn {:.6e}",
                        grid.degrees(k),
                        exact[k],
                        drawn.values[k]
                    )
                });
            }
        }
        total.add(sum / variance.sqrt(), || format!("{name}, sigma {sigma}, seed {seed}"));
    }
}

/// Flux that a smooth front face mirrors to the detector's side: every ray gives the same.
fn mirrored_by_the_smooth_front(setup: &Setup, sigma_deg: f64) -> f64 {
    match setup.sample {
        Sample::Plate { eta, rough_side: Detector } if setup.geometry == Reflection => {
            dielectric(sigma_deg.to_radians().cos(), eta.get()).reflected
        }
        _ => 0.0,
    }
}

/// Index of an angle that is on the grid.
fn at(grid: &AngleGrid<f64>, theta_deg: f64) -> usize {
    ((theta_deg - grid.start_deg) / grid.step_deg).round() as usize
}

/// One family of comparisons, judged together.
fn family(
    label: &str,
    geometry: Geometry,
    rays: usize,
    seed: u64,
    surfaces: &[(&str, &dyn Method, &[f64])],
) {
    let (mut single, mut total) = (Deviations::default(), Deviations::default());
    let mut seed = seed;
    for (name, method, values) in surfaces {
        for (side, geometry) in SIDES.into_iter().filter(|(_, g)| *g == geometry) {
            seed += 1;
            let sample = Virtual::plate(*method, values, 1.49, side, geometry);
            let name = format!("{name} {values:?} {side:?} {geometry:?}");
            compare(&name, &sample, rays, seed, APART, &mut single, &mut total);
        }
    }
    let chance = tolerance::SIGNIFICANCE.allowed;
    let most = tolerance::MONTE_CARLO.allowed;
    single.judge(&format!("{label} {geometry:?}, readings"), FREEDOM, chance, most);
    total.judge(&format!("{label} {geometry:?}, sums over the plane"), FREEDOM, chance, most);
}

fn ggx(geometry: Geometry, rays: usize, seed: u64) {
    let method = GgxMethod::new(Body::Dielectric { ior: 1.49 });
    let widths = [[0.003], [0.02], [0.05], [0.2], [0.47]];
    let surfaces: Vec<(&str, &dyn Method, &[f64])> =
        widths.iter().map(|w| ("ggx", &method as &dyn Method, w.as_slice())).collect();
    family("ggx", geometry, rays, seed, &surfaces);
}

fn normals(geometry: Geometry, rays: usize, seed: u64) {
    let surfaces: [(&str, &dyn Method, &[f64]); 5] = [
        ("gauss", &GAUSS, &[0.3, 2.0]),
        ("gauss", &GAUSS, &[7.0, 1.7]),
        ("gauss", &GAUSS, &[25.0, 4.0]),
        ("cauchy", &CAUCHY, &[2.0, 4.0]),
        ("cauchy", &CAUCHY, &[8.5, 3.5]),
    ];
    family("normals", geometry, rays, seed, &surfaces);
}

#[test]
fn ggx_in_transmission_is_what_rays_give() {
    ggx(Transmission, 400_000, 7000);
}

#[test]
fn ggx_in_reflection_is_what_rays_give() {
    ggx(Reflection, 400_000, 7100);
}

#[test]
fn normals_in_transmission_are_what_rays_give() {
    normals(Transmission, 400_000, 7200);
}

#[test]
fn normals_in_reflection_are_what_rays_give() {
    normals(Reflection, 400_000, 7300);
}

#[test]
fn an_opaque_body_is_what_rays_give() {
    let (mut single, mut total) = (Deviations::default(), Deviations::default());
    for (seed, alpha) in (7401..).zip([0.003, 0.05, 0.2, 0.47]) {
        let sample = Virtual::opaque(alpha, 0.5, 0.05);
        compare(&format!("opaque {alpha}"), &sample, 400_000, seed, APART, &mut single, &mut total);
    }
    let chance = tolerance::SIGNIFICANCE.allowed;
    single.judge("opaque, readings", FREEDOM, chance, tolerance::MONTE_CARLO.allowed);
}

#[test]
fn other_apertures_are_what_rays_give() {
    let (mut single, mut total) = (Deviations::default(), Deviations::default());
    for (seed, alpha) in (7501..).zip([0.003, 0.02, 0.2]) {
        for (aperture_deg, apart) in [(0.2, APART), (4.0, 41)] {
            let sample = Virtual::ggx(alpha, 1.49).with_aperture(aperture_deg);
            let name = format!("ggx {alpha}, aperture {aperture_deg}");
            compare(&name, &sample, 400_000, seed, apart, &mut single, &mut total);
        }
    }
    let chance = tolerance::SIGNIFICANCE.allowed;
    single.judge("apertures, readings", FREEDOM, chance, tolerance::MONTE_CARLO.allowed);
}

#[test]
fn light_that_was_inside_a_plate_is_what_rays_give() {
    // a wide detector sees enough rays of a wide lobe to tell 3 % in each reading
    let grid = AngleGrid { start_deg: -87.0, step_deg: 6.0, count: 30 };
    let mut wrong = Vec::new();
    for (seed, (side, geometry)) in (7601..).zip(SIDES) {
        for alpha in [0.2, 0.47] {
            let sample = Virtual::ggx(alpha, 1.49).with_sides(side, geometry).with_aperture(6.0);
            let mut worst = (0.0_f64, String::new());
            for sigma in SIGMAS {
                let mirrored = mirrored_by_the_smooth_front(&sample.setup, sigma);
                let rays = Rays { count: count(2_000_000) as u64, seed };
                let exact = sample.quadrature(&[sigma], &grid).values;
                let drawn = sample.monte_carlo(sigma, &grid, rays);
                // the mirrored beam is at the rims of two readings at once: those say nothing
                let seen = |k: usize| mirrored <= 0.0 || (grid.degrees(k) - sigma).abs() > 3.5;
                let readings = (0..grid.count).filter(|&k| seen(k));
                let largest = readings.clone().map(|k| drawn.values[k]).fold(0.0, f64::max);
                for k in readings.filter(|&k| drawn.values[k] > WEAK * largest) {
                    let (off, value) = (exact[k] - drawn.values[k], drawn.values[k]);
                    let noise = tolerance::MONTE_CARLO.allowed * drawn.std_errors[k];
                    let beyond = (off.abs() - noise) / value;
                    let place = format!(
                        "alpha {alpha} {side:?} {geometry:?}, sigma {sigma}, theta {}: {:.4e}, drawn \
                         {value:.4e} +- {:.1e}",
                        grid.degrees(k),
                        exact[k],
                        drawn.std_errors[k]
                    );
                    if beyond > INSIDE.allowed {
                        wrong.push(place.clone());
                    }
                    if beyond > worst.0 {
                        worst = (beyond, place);
                    }
                }
            }
            println!(
                "alpha {alpha} {side:?} {geometry:?}: beyond noise {:.4} {}",
                worst.0, worst.1
            );
        }
    }
    assert!(wrong.is_empty(), "{} readings are off: {wrong:#?}", wrong.len());
}

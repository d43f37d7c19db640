//! Readings out of the plane of incidence: against rays, around the normal, and as a fit of a whole hemisphere.

use asperity::fit::{FitOptions, fit};
use asperity::forward::{Angles, Effort, Incidence, Rays, monte_carlo, simulate};
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod};
use asperity::watch::Watch;
use asperity_core::gonio::Geometry::{self, Reflection, Transmission};
use asperity_core::plate::RoughSide::{self, Detector, Source};

use crate::common::Virtual;

const SIDES: [(RoughSide, Geometry); 4] = [
    (Source, Transmission),
    (Detector, Transmission),
    (Source, Reflection),
    (Detector, Reflection),
];

fn plane(sigma_deg: f64, phi_deg: f64, step: i32) -> Incidence {
    let theta_deg = (-88..=88).step_by(step as usize).map(f64::from).collect();
    Incidence { phi_deg, ..Incidence::in_plane(sigma_deg, theta_deg) }
}

fn readings(sample: &Virtual, planes: Vec<Incidence>) -> Vec<f64> {
    let angles = Angles { incidences: planes };
    let rays = Rays { count: 1, seed: 0 };
    simulate(&sample.boundary, &sample.setup, &angles, Effort::Full, rays, Watch::nobody())
        .unwrap()
        .values
}

#[test]
fn rays_give_the_readings_of_turned_planes() {
    let rays = Rays { count: 1_000_000, seed: 11 };
    let (mut squares, mut count, mut worst) = (0.0, 0, 0.0_f64);
    for (alpha, sigma) in [(0.35, 40.0), (0.12, 25.0)] {
        for (side, geometry) in SIDES {
            let sample = Virtual::ggx(alpha, 1.49).with_sides(side, geometry).with_aperture(3.0);
            for phi in [12.0, -50.0, 90.0] {
                let plane = plane(sigma, phi, 4);
                let exact = readings(&sample, vec![plane.clone()]);
                let drawn =
                    monte_carlo(&sample.boundary, &sample.setup, &plane, rays, Watch::nobody())
                        .unwrap();
                let pairs = exact.iter().zip(drawn.values.iter().zip(&drawn.std_errors));
                for (exact, (drawn, error)) in pairs {
                    // enough rays that their number is nearly normal
                    if *exact * drawn_rays(rays) > 60.0 {
                        let z = (exact - drawn) / error;
                        squares += z * z;
                        count += 1;
                        worst = worst.max(z.abs());
                    }
                }
            }
        }
    }
    let mean = squares / f64::from(count);
    println!("{count} readings, mean square of z {mean:.3}, worst {worst:.2}");
    assert!(count > 150 && mean < 1.25 && worst < 4.8, "{count} {mean} {worst}");
}

fn drawn_rays(rays: Rays) -> f64 {
    rays.count as f64
}

#[test]
fn around_the_normal_all_planes_read_the_same() {
    for (side, geometry) in SIDES {
        let sample = Virtual::ggx(0.3, 1.49).with_sides(side, geometry);
        let planes = [0.0, 33.0, 90.0].map(|phi| plane(0.0, phi, 8)).to_vec();
        let found = readings(&sample, planes);
        let n = found.len() / 3;
        let top = found.iter().copied().fold(0.0, f64::max);
        for k in 0..2 * n {
            let off = (found[k % n] - found[n + k]).abs();
            // the rule for light that goes in, is mirrored and comes out again is about the plane of incidence
            assert!(off < 1e-5 * top, "{side:?} {geometry:?} {k}: {off} of {top}");
        }
    }
}

#[test]
fn a_slit_reads_the_integral_over_its_rectangle() {
    use asperity_core::quadrature::gauss_legendre;
    let (width, height) = (1.0_f64, 6.0_f64);
    for (alpha, geometry) in [(0.08, Transmission), (0.35, Transmission), (0.3, Reflection)] {
        let points = {
            let mut sample = Virtual::ggx(alpha, 1.49).with_sides(Source, geometry);
            (sample.setup.quantity, sample.setup.aperture_deg) = (Quantity::Bsdf, 0.0);
            sample
        };
        let mut slit = Virtual::ggx(alpha, 1.49).with_sides(Source, geometry).with_aperture(width);
        slit.setup.slit_height_deg = Some(height);
        let thetas = [10.0, 24.0, 30.0, 31.0, 45.0];
        let found = readings(&slit, vec![Incidence::in_plane(30.0, thetas.to_vec())]);
        let largest = found.iter().copied().fold(0.0, f64::max);
        for (theta, found) in thetas.into_iter().zip(found) {
            // point values over the rectangle: each direction lies in a plane of its own
            let (mut planes, mut weights) = (Vec::new(), Vec::new());
            for (t, w) in gauss_legendre::<8>() {
                let psi = (height * (t - 0.5)).to_radians();
                for (u, v) in gauss_legendre::<5>() {
                    let along = (theta + width * (u - 0.5)).to_radians();
                    let [x, y, z] = [along.sin() * psi.cos(), psi.sin(), along.cos() * psi.cos()];
                    let (polar, azimuth) = (z.acos(), (y / x).atan());
                    let theta_deg = vec![polar.to_degrees()];
                    planes.push(Incidence {
                        phi_deg: azimuth.to_degrees(),
                        ..Incidence::in_plane(30.0, theta_deg)
                    });
                    let area = width.to_radians() * height.to_radians();
                    weights.push(w * v * area * psi.cos() * polar.cos());
                }
            }
            let values = readings(&points, planes);
            let exact: f64 = values.iter().zip(&weights).map(|(f, w)| f * w).sum();
            assert!(
                (found - exact).abs() < 2e-3 * largest,
                "{alpha} {geometry:?} {theta}: {found} {exact} of {largest}"
            );
        }
    }
}

/// The scan of a hemisphere of point values, every 6 degrees and 15 degrees around.
fn hemisphere(alpha: f64) -> (Virtual, Measurement) {
    let mut sample = Virtual::ggx(alpha, 1.49).with_aperture(0.0);
    sample.setup.quantity = Quantity::Bsdf;
    let planes: Vec<Incidence> = [0.0, 35.0]
        .into_iter()
        .flat_map(|sigma| (-5..=6).map(move |k| plane(sigma, f64::from(15 * k), 6)))
        .collect();
    let values = readings(&sample, planes.clone());
    let places = planes.iter().flat_map(|p| p.theta_deg.iter().map(move |t| (p, *t)));
    let reading = |((plane, theta_deg), value): ((&Incidence, f64), &f64)| Reading {
        phi_deg: plane.phi_deg,
        ..Reading::in_plane(plane.sigma_deg, theta_deg, *value)
    };
    let all = places.zip(&values).map(reading).collect();
    let meta = Metadata { quantity: Some(Quantity::Bsdf), ..Metadata::default() };
    (sample, Measurement::new(meta, all).unwrap())
}

#[test]
fn a_hemisphere_is_fitted_and_holds_the_light_that_leaves() {
    let (sample, scan) = hemisphere(0.3);
    let body = Body::Dielectric { ior: 1.49 };
    let method = GgxMethod::new(body);
    let options = FitOptions::new(body);
    let found = fit(&method, &scan, &sample.setup, &options, Watch::nobody()).unwrap();
    let alpha = found.parameters[0].value;
    assert!((alpha - 0.3).abs() < 1e-4 && found.rmsd_percent < 0.02, "{alpha}");

    // the trapezoidal rule over all planes, against the rays that leave on that side
    let planes: Vec<Incidence> = (-11..=12).map(|k| plane(35.0, 7.5 * f64::from(k), 2)).collect();
    let values = readings(&sample, planes.clone());
    let thetas = planes.iter().flat_map(|p| &p.theta_deg);
    let area = 2.0_f64.to_radians() * 7.5_f64.to_radians();
    let part = |(theta, value): (&f64, &f64)| {
        let (sin, cos) = theta.abs().to_radians().sin_cos();
        value * cos * sin * area
    };
    let flux: f64 = thetas.zip(&values).map(part).sum();
    let wide =
        Virtual { setup: asperity::forward::Setup { aperture_deg: 1.0, ..sample.setup }, ..sample };
    let plane = Incidence::in_plane(35.0, vec![0.0]);
    let rays = Rays { count: 200_000, seed: 3 };
    let drawn = monte_carlo(&wide.boundary, &wide.setup, &plane, rays, Watch::nobody()).unwrap();
    let expected = drawn.outcome.transmitted;
    assert!((flux - expected).abs() < 0.003, "{flux} of {expected}");
}

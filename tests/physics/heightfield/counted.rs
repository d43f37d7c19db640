//! Readings as sums over facets and rays for the rest are those of rays alone.

use asperity::boundary::Boundary;
use asperity::forward::{Angles, Effort, Incidence, Rays, Sample, Setup, monte_carlo, simulate};
use asperity::measurement::Quantity;
use asperity::raytrace::TracedBoundary;
use asperity::watch::Watch;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;

use super::maps::{EDGES, ETA, boundary, gaussian, noise};
use crate::common::ior;

const SETUPS: [(Geometry, RoughSide); 4] = [
    (Geometry::Transmission, RoughSide::Source),
    (Geometry::Transmission, RoughSide::Detector),
    (Geometry::Reflection, RoughSide::Source),
    (Geometry::Reflection, RoughSide::Detector),
];

/// Deviations of readings in units of their standard error, and what the rays' own variance is over that of plain rays.
struct Compared {
    deviations: Vec<f64>,
    variance_ratio: f64,
}

fn compare(law: &TracedBoundary, setup: &Setup, incidence: &Incidence) -> Compared {
    let plain =
        monte_carlo(law, setup, incidence, Rays { count: 120_000, seed: 3 }, Watch::nobody());
    let plain = plain.unwrap();
    let plan = Angles { incidences: vec![incidence.clone()] };
    let rays = Rays { count: 120_000, seed: 11 };
    let traced = Boundary::Traced(law.clone());
    let counted = simulate(&traced, setup, &plan, Effort::Full, rays, Watch::nobody()).unwrap();
    let errors = counted.std_errors.unwrap();
    let seen = |k: &usize| plain.values[*k] * 120_000.0 > 30.0;
    let kept: Vec<usize> = (0..errors.len()).filter(seen).collect();
    let deviation =
        |&k: &usize| (counted.values[k] - plain.values[k]) / plain.std_errors[k].hypot(errors[k]);
    let square = |errors: &[f64]| kept.iter().map(|k| errors[*k] * errors[*k]).sum::<f64>();
    Compared {
        deviations: kept.iter().map(deviation).collect(),
        variance_ratio: square(&errors) / square(&plain.std_errors),
    }
}

#[test]
fn sums_over_facets_with_rays_for_the_rest_read_what_rays_read() {
    let mut wrong = Vec::new();
    for edges in EDGES {
        for (slope, gain) in [(0.15, 0.25), (0.6, 0.7)] {
            let law = boundary(&gaussian(96, 6.0, slope, 2), edges);
            let rough = boundary(&noise((70, 90), (1.0, 1.3), slope, 6), edges);
            for (geometry, rough_side) in SETUPS {
                let setup = Setup {
                    sample: Sample::Plate { eta: ior(ETA), rough_side },
                    geometry,
                    aperture_deg: 3.0,
                    slit_height_deg: None,
                    quantity: Quantity::Flux,
                };
                for (sigma_deg, phi_deg) in [(0.0, 0.0), (35.0, 0.0), (35.0, 9.0), (65.0, 0.0)] {
                    let theta_deg = (-16..=16).map(|k| 5.0 * f64::from(k)).collect();
                    let incidence =
                        Incidence { phi_deg, ..Incidence::in_plane(sigma_deg, theta_deg) };
                    for law in [&law, &rough] {
                        let found = compare(law, &setup, &incidence);
                        let n = found.deviations.len() as f64;
                        let squares: f64 = found.deviations.iter().map(|z| z * z).sum();
                        let largest = found.deviations.iter().fold(0.0_f64, |a, z| a.max(z.abs()));
                        let what = format!(
                            "{edges:?} {slope} {geometry:?} {rough_side:?} {sigma_deg} {phi_deg}"
                        );
                        let ratio = found.variance_ratio;
                        let most = if sigma_deg < 50.0 { gain } else { 1.5 };
                        // neighbours are apart here: a sum of squares has a deviation of root 2 n
                        let is_alike = largest < 4.2 && squares < n + 4.0 * (2.0 * n).sqrt();
                        if n > 2.0 && !(is_alike && ratio < most) {
                            wrong.push(format!(
                                "{what}: {largest:.2}, {squares:.1} of {n}, {ratio:.3}"
                            ));
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

//! The noise floor beside a fit: noise that was added, and nothing of the lobe.

use asperity::measurement::{Measurement, Metadata, Reading};
use asperity::method::{Body, GgxMethod, Method};
use asperity_core::gonio::Geometry::{self, Reflection, Transmission};
use asperity_core::plate::RoughSide::Source;
use asperity_tests::tolerance::NOISE_FLOOR;
use rand_pcg::Pcg64Mcg;

use asperity_core::math::Real;

use crate::common::{CAUCHY, GAUSS, Virtual, fitted, grid, options};

const CLEAR: Body = Body::Dielectric { ior: 1.49 };

/// Noise of one reading from its value and the largest.
type Noise = fn(f64, f64) -> f64;

/// A scan with noise, and the rms of that noise over the largest reading, %.
fn noisy(exact: &Measurement, noise: Noise, seed: u128) -> (Measurement, f64) {
    let mut generator = Pcg64Mcg::new(seed);
    // twelve uniforms are normal enough
    let mut normal = || (0..12).map(|_| f64::uniform(&mut generator)).sum::<f64>() - 6.0;
    let largest = exact.largest_reading();
    let mut squares = 0.0;
    let readings: Vec<Reading> = exact
        .readings()
        .iter()
        .map(|r| {
            let off = noise(r.value, largest) * normal();
            squares += off * off;
            Reading { value: r.value + off, ..*r }
        })
        .collect();
    let meta = Metadata { aperture_deg: Some(0.6), ..Metadata::default() };
    let rms = (squares / readings.len() as f64).sqrt();
    let scan = Measurement::new(meta, readings).unwrap();
    let percent = 100.0 * rms / scan.largest_reading();
    (scan, percent)
}

#[test]
fn it_is_the_noise_that_was_added() {
    let ggx = GgxMethod::new(CLEAR);
    let cases: [(&dyn Method, &[f64], Geometry); 8] = [
        (&ggx, &[0.001], Transmission),
        (&ggx, &[0.03], Transmission),
        (&ggx, &[0.2], Transmission),
        (&ggx, &[0.6], Transmission),
        (&GAUSS, &[0.2, 2.0], Transmission),
        (&CAUCHY, &[0.15, 3.0], Transmission),
        (&ggx, &[0.03], Reflection),
        (&ggx, &[0.3], Reflection),
    ];
    let noises: [(&str, Noise); 2] =
        [("even", |_, largest| 5e-4 * largest), ("growing", |value, _| 0.01 * value)];
    for (k, (method, values, geometry)) in cases.into_iter().enumerate() {
        let sample = Virtual::plate(method, values, 1.49, Source, geometry);
        let exact = sample.exact_scan(&[0.0, 30.0, 60.0], &grid(10));
        for (kind, noise) in noises {
            let (scan, added) = noisy(&exact, noise, 100 + k as u128);
            let fit = fitted(method, &scan, &sample.setup, &options(CLEAR)).unwrap();
            let floor = fit.noise_floor_percent.unwrap();
            println!(
                "{} {values:?} {geometry:?}, {kind}: added {added:.4} %, floor {floor:.4} %, RMSD {:.4} %",
                method.name(),
                fit.rmsd_percent
            );
            assert!(floor <= fit.rmsd_percent * (1.0 + 1e-12), "{floor} {}", fit.rmsd_percent);
            let off = floor / added - 1.0;
            assert!(off.abs() < NOISE_FLOOR.allowed, "{values:?} {kind} {floor} {added}");
        }
    }
}

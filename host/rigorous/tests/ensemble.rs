//! The mean over Gaussian surfaces against the atlas of rigorous solutions.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::float_cmp,
    reason = "a test fails where its data do, and shows what it measures"
)]

mod common;

use std::f64::consts::{PI, TAU};

use asperity_rigorous::{
    Accuracy, Ensemble, Incidence, Kind, Light, Profile, RigorousError, Side, go_on,
};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// A number of the standard normal distribution.
fn normal(rng: &mut Pcg64Mcg) -> f64 {
    let mut uniform = || (rng.next_u64() >> 11) as f64 / 9007199254740992.0;
    (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos()
}

/// Gaussian heights with the autocorrelation `Rq^2 exp(-x^2 / l^2)`.
fn gaussian(rq: f64, length: f64, period: f64, rng: &mut Pcg64Mcg) -> Profile {
    const COUNT: usize = 512;
    let mut heights = vec![0.0; COUNT];
    for k in 1..COUNT / 4 {
        let q = TAU * k as f64 / period;
        let sigma =
            rq * (2.0 * PI.sqrt() * length / period).sqrt() * (-(q * length).powi(2) / 8.0).exp();
        let (a, b) = (sigma * normal(rng), sigma * normal(rng));
        for (i, h) in heights.iter_mut().enumerate() {
            let (sin, cos) = (TAU * (k * i % COUNT) as f64 / COUNT as f64).sin_cos();
            *h += a * cos + b * sin;
        }
    }
    Profile::new(heights, period).unwrap()
}

#[test]
fn the_mean_is_that_of_the_atlas() {
    if !common::are_here() {
        return;
    }
    // all lengths in wavelengths
    let (rq, slope, period) = (0.2, 0.2, 30.1);
    let mut rng = Pcg64Mcg::new(0x9e37_79b9_7f4a_7c15_a5be_71b7_1234_5677);
    let length = 2.0f64.sqrt() * rq / slope;
    let profiles: Vec<Profile> = (0..120).map(|_| gaussian(rq, length, period, &mut rng)).collect();
    let incidences =
        [(Side::Air, 0), (Side::Air, 15), (Side::Dielectric, 0), (Side::Dielectric, 22)]
            .map(|(side, order)| Incidence { side, order });
    let ensemble =
        Ensemble::new(&profiles, 1.49, 1.0, &incidences, Accuracy::default(), &go_on).unwrap();
    println!("energy {:.1e}", ensemble.energy_error());
    assert!(ensemble.energy_error() < 1e-7);

    let text = std::fs::read_to_string(common::data("rigorous/atlas/atlas_summary.csv")).unwrap();
    let summary: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let curves =
        std::fs::read_to_string(common::data("rigorous/atlas/curves_0.2_0.2.csv")).unwrap();
    let mut lines = curves.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let curves: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let angles: Vec<f64> = curves.iter().map(|row| row[0]).collect();

    for (incidence, label, theta) in
        [(0, "air", "0"), (1, "air", "29.89"), (2, "inside", "0"), (3, "inside", "29.38")]
    {
        for (kind, letter) in [(Kind::Reflected, "R"), (Kind::Transmitted, "T")] {
            let lobe =
                |light| ensemble.lobe(incidences[incidence], kind, light, &angles, 2.0).unwrap();
            let unpolarised = lobe(Light::Unpolarised);
            let row = summary
                .iter()
                .find(|row| {
                    row[0] == "0.2"
                        && row[1] == "0.2"
                        && row[5] == label
                        && row[6] == theta
                        && row[7] == letter
                })
                .unwrap();
            let number = |at: usize| row[at].parse::<f64>().unwrap();
            let realisations = number(4);
            let means =
                [(unpolarised.total, 8), (lobe(Light::Te).total, 9), (lobe(Light::Tm).total, 10)];
            for (mean, column) in means {
                // the atlas states no error of totals: as if its realisations had no variate to control them
                let error = mean.error.hypot(mean.spread / realisations.sqrt());
                let off = (mean.value - number(column)) / error;
                println!(
                    "{label} {theta} {letter} column {column}: {:.6} +- {:.6}, atlas {}, {off:.1} sigma",
                    mean.value,
                    mean.error,
                    number(column)
                );
                assert!(off.abs() < 4.0);
            }
            let prefix = format!(
                "{}{:.2}_{letter}",
                if label == "air" { "air" } else { "in" },
                theta.parse::<f64>().unwrap()
            );
            let column = |what: &str| {
                names.iter().position(|name| *name == format!("{prefix}_{what}")).unwrap()
            };
            let (rigorous, noise) = (column("rig"), column("noise"));
            let peak = curves.iter().fold(0.0f64, |peak, row| peak.max(row[rigorous]));
            let (mut sum, mut count) = (0.0, 0.0);
            for (row, mean) in curves.iter().zip(&unpolarised.diffuse) {
                // near the horizon the cells of the few orders differ
                if row[rigorous] > 0.02 * peak && row[0].abs() < 75.0 {
                    // speckle: the spread is in proportion to the mean, here to the better known one
                    let error = mean.error * (row[rigorous] / mean.value).max(1.0);
                    let off = (mean.value - row[rigorous]) / error.hypot(row[noise]);
                    assert!(
                        off.abs() < 5.0,
                        "{prefix} at {}: {} +- {}, atlas {}",
                        row[0],
                        mean.value,
                        mean.error,
                        row[rigorous]
                    );
                    sum += off * off;
                    count += 1.0;
                }
            }
            println!(
                "{prefix}: {count} angles, rms {:.2} sigma; coherent {:.5} +- {:.5}, atlas {}",
                f64::sqrt(sum / count),
                unpolarised.coherent,
                unpolarised.coherent_error,
                number(15)
            );
            assert!(sum / count < 4.0);
            let error =
                unpolarised.coherent_error * (1.0 + profiles.len() as f64 / realisations).sqrt();
            let off = (unpolarised.coherent - number(15)) / error.max(1e-4);
            assert!(off.abs() < 4.0, "{prefix}: coherent off by {off:.1} sigma");
        }
    }
}

#[test]
fn what_is_no_ensemble_is_refused() {
    let flat = |period| Profile::new(vec![0.0; 8], period).unwrap();
    let run = |profiles: &[Profile]| {
        let light = Incidence { side: Side::Air, order: 0 };
        Ensemble::new(profiles, 1.5, 0.55, &[light], Accuracy::default(), &go_on).unwrap_err()
    };
    assert_eq!(run(&[flat(1.2)]), RigorousError::NoEnsemble);
    assert!(matches!(run(&[flat(1.2), flat(1.3)]), RigorousError::Periods { at: 1, .. }));
}

//! What approximations are off by, on own Gaussian profiles against the atlas of rigorous solutions.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where its data do, and shows what it measures"
)]

mod common;

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use asperity_rigorous::{
    Accuracy, Kind, Piece, Profile, Question, RayOptions, RigorousError, Side, Verdict, go_on,
    measure,
};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// A number of the standard normal distribution.
fn normal(rng: &mut Pcg64Mcg) -> f64 {
    let mut uniform = || (rng.next_u64() >> 11) as f64 / 9007199254740992.0;
    (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos()
}

/// Gaussian heights with the autocorrelation `Rq^2 exp(-x^2 / l^2)`, all lengths in wavelengths.
fn gaussian(rq: f64, slope: f64, period: f64, rng: &mut Pcg64Mcg) -> Profile {
    let length = 2.0f64.sqrt() * rq / slope;
    let last = (12.0 * period / (TAU * length)) as usize;
    let count = (2 * last + 2).max(16);
    // the mean of a period is chance too
    let mut heights = vec![rq * (PI.sqrt() * length / period).sqrt() * normal(rng); count];
    for k in 1..=last {
        let q = TAU * k as f64 / period;
        let sigma =
            rq * (2.0 * PI.sqrt() * length / period).sqrt() * (-(q * length).powi(2) / 8.0).exp();
        let (a, b) = (sigma * normal(rng), sigma * normal(rng));
        for (i, h) in heights.iter_mut().enumerate() {
            let (sin, cos) = (TAU * (k * i % count) as f64 / count as f64).sin_cos();
            *h += a * cos + b * sin;
        }
    }
    Profile::new(heights, period).unwrap()
}

/// A surface of the atlas, and how many profiles of it are made.
struct Surface {
    rq: f64,
    slope: f64,
    period: f64,
    solved: usize,
    all: usize,
    incidences: &'static [(Side, f64)],
}

/// A row of the atlas by the names of its columns.
type Row = HashMap<String, f64>;

impl Surface {
    fn compare(&self) {
        let mut rng = Pcg64Mcg::new(0x9e37_79b9_7f4a_7c15_a5be_71b7_1234_5677);
        let make = |_| gaussian(self.rq, self.slope, self.period, &mut rng);
        let pieces = Piece::independent((0..self.all).map(make).collect(), self.solved);
        let question = Question {
            index: 1.49,
            wavelength_um: 1.0,
            incidences: self.incidences.to_vec(),
            accuracy: Accuracy { tolerance: 1e-5, ..Accuracy::default() },
            rays: RayOptions { starts: 1500, seed: 3 },
        };
        let verdicts = measure(&pieces, &question, &go_on).unwrap();
        println!(
            "Rq {} slope {}: {} of {} solved, {} nodes, energy {:.0e}, rays lost {:.0e}",
            self.rq,
            self.slope,
            verdicts.solved,
            verdicts.all,
            verdicts.nodes,
            verdicts.energy_error,
            verdicts.rays_lost
        );
        assert!(verdicts.energy_error < 1e-5 && verdicts.rays_lost < 1e-4);
        for lobe in verdicts.lobes.chunks(3) {
            let row = self.row(&lobe[0]);
            self.check_errors(&lobe[0], &row);
            check_totals(lobe, &row);
        }
    }

    fn row(&self, verdict: &Verdict) -> Row {
        let text =
            std::fs::read_to_string(common::data("rigorous/atlas/atlas_summary.csv")).unwrap();
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        let is_it = |row: &&Vec<&str>| {
            let off = |at: usize, x: f64| (row[at].parse::<f64>().unwrap() - x).abs();
            off(0, self.rq) < 1e-9
                && off(1, self.slope) < 1e-9
                && row[5] == side(verdict)
                && off(6, verdict.incidence_deg) < 0.02
                && row[7] == kind(verdict)
        };
        let cells = rows.iter().find(is_it).unwrap().iter().zip(names);
        cells.filter_map(|(cell, name)| Some((name.to_owned(), cell.parse().ok()?))).collect()
    }

    /// Squares of deviations: their noise is what is known.
    fn check_errors(&self, verdict: &Verdict, row: &Row) {
        println!("{} {:.2} {}", side(verdict), verdict.incidence_deg, kind(verdict));
        let more = 1.0 + self.solved as f64 / row["M"];
        for (comparison, name) in verdict.comparisons.iter().zip(["kir", "ray", "fac"]) {
            for (found, measure) in [(comparison.reading, "rms"), (comparison.diffuse, "drms")] {
                let atlas = row[&format!("{measure}_{name}")];
                let error = (found.high_percent.powi(2) - found.percent.powi(2)) * more.sqrt();
                let sigma = error.hypot(0.04 * atlas * atlas).hypot(row["rms_floor"].powi(2));
                let off = (found.percent.powi(2) - atlas * atlas) / sigma;
                println!(
                    "  {name} {measure}: {:.4} % ({:.4} to {:.4}), atlas {atlas:.4}, {off:.1} sigma",
                    found.percent, found.low_percent, found.high_percent
                );
                // facets of the atlas are taken at the angles of the orders alone
                assert!(name == "fac" || off.abs() < 4.0);
            }
        }
    }
}

/// Rays of the atlas are the mean of TE and TM, without mixing them at each bounce.
fn check_totals(lobe: &[Verdict], row: &Row) {
    let (unpolarised, te, tm) = (&lobe[0], &lobe[1], &lobe[2]);
    let mean = |of: &dyn Fn(&Verdict) -> f64| 0.5 * (of(te) + of(tm));
    let [kirchhoff, rays, facets] = unpolarised.comparisons.map(|c| c.total);
    let polarised = mean(&|v| v.comparisons[1].total.value);
    let rigorous = unpolarised.total;
    let coherent = [unpolarised.coherent, unpolarised.coherent_kirchhoff];
    let figures = [
        ("E_rig", rigorous.value, rigorous.error),
        ("E_rigTE", te.total.value, te.total.error),
        ("E_rigTM", tm.total.value, tm.total.error),
        ("E_kir", kirchhoff.value, kirchhoff.error),
        ("E_ray", polarised, rays.error),
        ("E_fac", facets.value, facets.error),
        ("coh_rig", coherent[0].value, coherent[0].error),
        ("coh_kir", coherent[1].value, coherent[1].error),
    ];
    for (name, value, error) in figures {
        let off = (value - row[name]) / (1.5 * error).max(3e-5);
        println!("  {name}: {value:.5} +- {error:.5}, atlas {:.5}, {off:.1} sigma", row[name]);
        // the atlas misses what facets reflect inside near the horizon: 0.858 of 0.898 by quadrature at Rq .2, slope .2, 60 deg
        assert!(name == "E_fac" || off.abs() < 4.0);
    }
}

fn side(verdict: &Verdict) -> &'static str {
    if verdict.side == Side::Air { "air" } else { "inside" }
}

fn kind(verdict: &Verdict) -> &'static str {
    if verdict.kind == Kind::Reflected { "R" } else { "T" }
}

/// Whether the longer tests are asked for.
fn is_extensive() -> bool {
    std::env::var("ASPERITY_EXTENSIVE").is_ok_and(|v| v == "1")
}

#[test]
fn rq_0_2_slope_0_2() {
    if !common::are_here() {
        return;
    }
    let incidences = &[
        (Side::Air, 0.0),
        (Side::Air, 29.89),
        (Side::Air, 59.74),
        (Side::Dielectric, 0.0),
        (Side::Dielectric, 29.38),
        (Side::Dielectric, 60.41),
    ];
    Surface { rq: 0.2, slope: 0.2, period: 30.1, solved: 80, all: 240, incidences }.compare();
}

#[test]
fn rq_0_8_slope_0_3() {
    if !common::are_here() {
        return;
    }
    if !is_extensive() {
        return;
    }
    let incidences = &[
        (Side::Air, 0.0),
        (Side::Air, 29.92),
        (Side::Air, 58.77),
        (Side::Dielectric, 0.0),
        (Side::Dielectric, 29.62),
    ];
    Surface { rq: 0.8, slope: 0.3, period: 42.1, solved: 40, all: 200, incidences }.compare();
}

#[test]
fn rq_0_05_slope_0_1() {
    if !common::are_here() {
        return;
    }
    if !is_extensive() {
        return;
    }
    let incidences = &[
        (Side::Air, 0.0),
        (Side::Air, 29.89),
        (Side::Air, 59.74),
        (Side::Dielectric, 0.0),
        (Side::Dielectric, 29.38),
    ];
    Surface { rq: 0.05, slope: 0.1, period: 30.1, solved: 80, all: 240, incidences }.compare();
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let mut rng = Pcg64Mcg::new(7);
    let profiles: Vec<Profile> = (0..6).map(|_| gaussian(0.2, 0.2, 12.1, &mut rng)).collect();
    let question = Question {
        index: 1.49,
        wavelength_um: 1.0,
        incidences: vec![(Side::Dielectric, 20.0)],
        accuracy: Accuracy::default(),
        rays: RayOptions { starts: 200, seed: 3 },
    };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pieces = Piece::spread(profiles.clone(), 3);
        let verdicts = pool.install(|| measure(&pieces, &question, &go_on)).unwrap();
        format!("{verdicts:?}")
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let flat = Profile::new(vec![0.0; 8], 1.2).unwrap();
    let question = |angle| Question {
        index: 1.49,
        wavelength_um: 0.55,
        incidences: vec![(Side::Air, angle)],
        accuracy: Accuracy::default(),
        rays: RayOptions::default(),
    };
    let one = Piece::spread(vec![flat.clone(); 3], 1);
    assert_eq!(measure(&one, &question(0.0), &go_on).unwrap_err(), RigorousError::NoEnsemble);
    let two = Piece::spread(vec![flat; 3], 2);
    for angle in [90.0, f64::NAN] {
        let error = measure(&two, &question(angle), &go_on).unwrap_err();
        assert!(matches!(error, RigorousError::Incidence { .. }), "{error}");
    }
    let stop = |_| std::ops::ControlFlow::Break(());
    assert_eq!(measure(&two, &question(0.0), &stop).unwrap_err(), RigorousError::Stopped);
}

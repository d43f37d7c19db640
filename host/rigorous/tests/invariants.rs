//! What holds for every surface: energy, reciprocity, shift, mirror, and convergence.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where its data do, and shows what it measures"
)]

mod common;

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use asperity_rigorous::{
    Accuracy, Incidence, Kind, Polarisation, Problem, Profile, Response, RigorousError, Side,
    Solver, nobody, solve,
};
use num_complex::Complex64;

const INDEX: f64 = 1.49;
const WAVELENGTH: f64 = 0.55;

/// Three waves of a slope up to 1.
fn steep(shift: f64) -> Profile {
    let h = |x: f64| 0.25 * x.sin() + 0.1 * (2.0 * x + 0.7).cos() - 0.04 * (5.0 * x).sin();
    let period = 7.13 * WAVELENGTH;
    let heights = (0..128).map(|i| h(TAU * (f64::from(i) / 128.0 - shift / period)));
    Profile::new(heights.collect(), period).unwrap()
}

fn all_incidences(problem: &Problem) -> Vec<Incidence> {
    let of = |side| {
        let last = problem.last_order(side);
        (-last..=last).map(move |order| Incidence { side, order })
    };
    of(Side::Air).chain(of(Side::Dielectric)).collect()
}

fn efficiency(
    responses: &[Response],
    incidence: Incidence,
    to: Side,
    m: i32,
    polarisation: Polarisation,
) -> f64 {
    let kind = if incidence.side == to { Kind::Reflected } else { Kind::Transmitted };
    let response = responses.iter().find(|response| response.incidence == incidence).unwrap();
    let mut orders = response.orders(polarisation).iter();
    orders.find(|order| order.kind == kind && order.m == m).unwrap().efficiency()
}

#[test]
fn light_may_travel_backwards() {
    if !common::are_here() {
        return;
    }
    for profile in [steep(0.0), common::profile("B"), common::profile("D")] {
        let problem = Problem::new(profile, INDEX, WAVELENGTH).unwrap();
        let incidences = all_incidences(&problem);
        let accuracy = Accuracy { rerun: true, ..Accuracy::default() };
        let responses = solve(&problem, &incidences, accuracy, &nobody).unwrap().responses;
        let mut worst = 0.0f64;
        for polarisation in [Polarisation::Te, Polarisation::Tm] {
            for &a in &incidences {
                for &b in &incidences {
                    let there = efficiency(&responses, a, b.side, b.order, polarisation);
                    let back = Incidence { side: b.side, order: -b.order };
                    worst = worst.max(
                        (there - efficiency(&responses, back, a.side, -a.order, polarisation))
                            .abs(),
                    );
                }
            }
        }
        let energy = responses.iter().map(Response::energy_error).fold(0.0, f64::max);
        println!(
            "reciprocity of {} pairs {worst:.1e}, energy of {} incidences {energy:.1e}",
            incidences.len().pow(2),
            incidences.len()
        );
        assert!(worst < 1e-9, "{worst:e}");
        assert!(energy < 1e-6, "{energy:e}");
    }
}

#[test]
fn a_shift_turns_phases_only() {
    let shift = 0.31;
    let solve = |profile| {
        let problem = Problem::new(profile, INDEX, WAVELENGTH).unwrap();
        let incidences = all_incidences(&problem);
        Solver::new(problem, 260, &nobody).unwrap().solve(&incidences).unwrap()
    };
    let period = steep(0.0).period_um();
    for (a, b) in solve(steep(0.0)).iter().zip(&solve(steep(shift))) {
        for polarisation in [Polarisation::Te, Polarisation::Tm] {
            for (a_out, b_out) in a.orders(polarisation).iter().zip(b.orders(polarisation)) {
                let turns = f64::from(a.incidence.order - a_out.m) * shift / period;
                let expected = a_out.amplitude * Complex64::from_polar(1.0, TAU * turns);
                assert!((b_out.amplitude - expected).norm() < 1e-8);
            }
        }
    }
}

#[test]
fn a_mirror_changes_the_signs_of_orders() {
    let problem = Problem::new(steep(0.1), INDEX, WAVELENGTH).unwrap();
    let mirrored = Problem::new(steep(0.1).mirrored(), INDEX, WAVELENGTH).unwrap();
    let incidences = all_incidences(&problem);
    let there = Solver::new(problem, 260, &nobody).unwrap().solve(&incidences).unwrap();
    let here = Solver::new(mirrored, 260, &nobody).unwrap().solve(&incidences).unwrap();
    for &incidence in &incidences {
        let seen = Incidence { order: -incidence.order, ..incidence };
        for polarisation in [Polarisation::Te, Polarisation::Tm] {
            for to in &incidences {
                let a = efficiency(&there, incidence, to.side, to.order, polarisation);
                let b = efficiency(&here, seen, to.side, -to.order, polarisation);
                assert!((a - b).abs() < 1e-8);
            }
        }
    }
}

/// The error falls faster than any power of the number of nodes: by a factor for every node that is added.
#[test]
fn the_error_falls_exponentially() {
    let problem = Problem::new(steep(0.0), INDEX, WAVELENGTH).unwrap();
    let incidences = all_incidences(&problem);
    let amplitudes = |nodes| -> Vec<Complex64> {
        let responses =
            Solver::new(problem.clone(), nodes, &nobody).unwrap().solve(&incidences).unwrap();
        responses
            .iter()
            .flat_map(|response| response.te.iter().chain(&response.tm))
            .map(|order| order.amplitude)
            .collect()
    };
    let exact = amplitudes(400);
    let errors: Vec<f64> = [40, 50, 60, 70, 80, 90, 100]
        .into_iter()
        .map(|nodes| {
            let off = amplitudes(nodes)
                .iter()
                .zip(&exact)
                .map(|(a, b)| (a - b).norm())
                .fold(0.0, f64::max);
            println!("{nodes} nodes: amplitudes off by {off:.1e}");
            off
        })
        .collect();
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.5 * pair[0], "{pair:?}");
    }
    // as fast as order 12 at least, and faster with every step
    assert!(errors[6] < errors[0] * (40.0f64 / 100.0).powi(12), "{errors:?}");
}

/// Deep, steep, short, almost grazing, and of a high index.
#[test]
fn the_number_of_nodes_is_found() {
    let wave = |period: f64, height: f64, waves: f64| {
        let heights = (0..256).map(|i| 0.5 * height * (TAU * waves * f64::from(i) / 256.0).sin());
        Profile::new(heights.collect(), period).unwrap()
    };
    let cases = [
        ("deep", wave(8.2, 6.0, 2.0), 1.49),
        ("steep", wave(5.2, 1.0, 4.0), 1.49),
        ("short", wave(0.31, 0.2, 1.0), 1.49),
        ("near grazing", wave(10.002 * WAVELENGTH, 0.5, 3.0), 1.49),
        ("high index", wave(4.03, 0.5, 2.0), 3.5),
        ("low index", wave(4.03, 0.5, 2.0), 1.01),
        ("very deep", wave(2.3, 6.0, 1.0), 1.49),
    ];
    for (name, profile, index) in cases {
        let problem = Problem::new(profile, index, WAVELENGTH).unwrap();
        let incidences = all_incidences(&problem);
        let accuracy = Accuracy { rerun: true, ..Accuracy::default() };
        let solution = solve(&problem, &incidences, accuracy, &nobody).unwrap();
        println!(
            "{name}: {} nodes, energy {:.1e}, rerun {:.1e}",
            solution.nodes,
            solution.energy_error,
            solution.change.unwrap()
        );
        assert!(solution.change.unwrap() < 1e-6, "{name}");
    }
}

#[test]
fn a_watcher_ends_the_work() {
    let problem = Problem::new(steep(0.0), INDEX, WAVELENGTH).unwrap();
    for limit in [0.0, 0.3, 0.6, 0.9] {
        let last = std::cell::Cell::new(0.0);
        let watcher = |stage: asperity_rigorous::Stage| {
            assert!(stage.done >= last.get());
            last.set(stage.done);
            if stage.done > limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let error = Solver::new(problem.clone(), 300, &watcher).unwrap_err();
        assert_eq!(error, RigorousError::Stopped);
        assert!(last.get() < limit + 0.1);
    }
    let last = std::cell::Cell::new(0.0);
    let watcher = |stage: asperity_rigorous::Stage| {
        last.set(stage.done);
        ControlFlow::Continue(())
    };
    Solver::new(problem.clone(), 300, &watcher).unwrap();
    assert!(last.get() > 0.9, "{}", last.get());
    let light = Incidence { side: Side::Air, order: 8 };
    let refused = Solver::new(problem, 64, &nobody).unwrap().solve(&[light]).unwrap_err();
    assert_eq!(refused, RigorousError::Incidence { order: 8, last: 7 });
}

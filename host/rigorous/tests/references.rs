//! Against solutions of other programs.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::float_cmp,
    reason = "a test fails where its data do, and shows what it measures"
)]

mod common;

use std::f64::consts::{PI, TAU};

use asperity_rigorous::{
    Accuracy, Incidence, Kind, Polarisation, Problem, Profile, Response, Side, Solver, nobody,
    solve,
};

const INDEX: f64 = 1.49;
const WAVELENGTH: f64 = 0.55;

/// Boundary integral and Chandezon's method, which agree to 4e-8; the files have eight decimals.
#[test]
fn orders_of_the_reference_profiles() {
    if !common::are_here() {
        return;
    }
    for name in ["A", "B", "C", "D"] {
        let (incidences, exact) = common::orders(name);
        let problem = Problem::new(common::profile(name), INDEX, WAVELENGTH).unwrap();
        let accuracy = Accuracy { rerun: true, ..Accuracy::default() };
        let solution = solve(&problem, &incidences, accuracy, &nobody).unwrap();
        let (mut worst, mut count) = (0.0f64, 0);
        for response in &solution.responses {
            for (te, tm) in response.te.iter().zip(&response.tm) {
                let [exact_te, exact_tm] = exact[&(response.incidence, te.kind, te.m)];
                worst = worst.max((te.efficiency() - exact_te).abs());
                worst = worst.max((tm.efficiency() - exact_tm).abs());
                count += 1;
            }
        }
        println!(
            "{name}: {count} orders, off by {worst:.1e}; energy {:.1e}, rerun {:.1e}, {} nodes",
            solution.energy_error,
            solution.change.unwrap(),
            solution.nodes
        );
        assert_eq!(count, exact.len());
        assert!(worst < 4e-8, "{name}: {worst:e}");
        assert!(solution.energy_error < 1e-8);
        assert!(solution.change.unwrap() < 1e-7);
    }
}

/// Rigorous coupled waves, whose staircase is right to 1e-4.
#[test]
fn sinusoids_of_coupled_waves() {
    if !common::are_here() {
        return;
    }
    let rows = common::rows("rcw_sinusoid_transmission_n1.49_lam0.55.csv");
    let mut worst = 0.0f64;
    for set in rows.chunk_by(|a, b| a[..2] == b[..2]) {
        let number = |at: usize| set[0][at].parse::<f64>().unwrap();
        let (period, height) = (number(0), number(1));
        let heights = (0..64).map(|i| 0.5 * height * (TAU * f64::from(i) / 64.0).cos());
        let problem =
            Problem::new(Profile::new(heights.collect(), period).unwrap(), INDEX, WAVELENGTH)
                .unwrap();
        let light = Incidence { side: Side::Air, order: 0 };
        let solution = solve(&problem, &[light], Accuracy::default(), &nobody).unwrap();
        for row in set {
            let m = row[2].parse().unwrap();
            let got = unpolarised(&solution.responses[0], Kind::Transmitted, m);
            worst = worst.max((got - row[3].parse::<f64>().unwrap()).abs());
        }
    }
    println!("coupled waves: off by {worst:.1e}");
    assert!(worst < 1e-4, "{worst:e}");
}

fn unpolarised(response: &Response, kind: Kind, m: i32) -> f64 {
    let of = |polarisation| {
        let mut orders = response.orders(polarisation).iter();
        orders.find(|order| order.kind == kind && order.m == m).unwrap().efficiency()
    };
    0.5 * (of(Polarisation::Te) + of(Polarisation::Tm))
}

/// First-order perturbation: what a shallow sinusoid sends into its first order is what a surface with that
/// spectral density scatters there.
#[test]
fn shallow_sinusoids_of_rayleigh_and_rice() {
    const RMS: f64 = 0.01;
    const LENGTH: f64 = 2.0;
    if !common::are_here() {
        return;
    }
    let rows = common::rows("rayleigh_rice_sigma0.01_L2_n1.49_lam0.55.csv");
    let k = TAU / WAVELENGTH;
    let amplitude = 1e-4;
    let (mut worst, mut count) = (0.0f64, 0);
    for set in rows.chunk_by(|a, b| a[..2] == b[..2]) {
        let (code, incidence_deg) = (set[0][0].as_str(), set[0][1].parse::<f64>().unwrap());
        if incidence_deg == 30.0 {
            continue; // every period in which this is an order has another one that grazes
        }
        let (from, to) = match code {
            "0" => (Side::Air, Side::Air),
            "1" => (Side::Air, Side::Dielectric),
            "2" => (Side::Dielectric, Side::Dielectric),
            _ => (Side::Dielectric, Side::Air),
        };
        let index = |side| if side == Side::Air { 1.0 } else { INDEX };
        let sine = incidence_deg.to_radians().sin();
        let m0 = if incidence_deg == 0.0 { 0 } else { 4 };
        let period = if m0 == 0 {
            6.03 * WAVELENGTH
        } else {
            f64::from(m0) * WAVELENGTH / (index(from) * sine)
        };
        let values: Vec<f64> = set.iter().map(|row| row[3].parse().unwrap()).collect();
        // brightness over spectral density, a smooth function of the angle
        let factor = |degree: usize| {
            let q = k * (index(to) * (degree as f64).to_radians().sin() - index(from) * sine);
            let density =
                RMS.powi(2) * LENGTH.powi(2) / (4.0 * PI) * (-(q * LENGTH).powi(2) / 4.0).exp();
            values[degree] / (density * (k * index(to)).powi(2))
        };
        for m in 0..40 {
            let angle = (f64::from(m) * WAVELENGTH / (period * index(to))).asin().to_degrees();
            if m == m0 || angle.is_nan() || angle > 80.0 {
                continue;
            }
            let critical = (1.0 / INDEX).asin().to_degrees();
            if to == Side::Dielectric && (angle - critical).abs() < 3.0 {
                continue; // the values have a cusp there, and none can be read between the degrees
            }
            let first = (angle as usize).clamp(1, 82) - 1;
            let exact: f64 = (0..4)
                .map(|i| {
                    let others = (0..4).filter(|j| *j != i);
                    let weight: f64 = others
                        .map(|j| (angle - (first + j) as f64) / (i as f64 - j as f64))
                        .product();
                    weight * factor(first + i)
                })
                .sum();
            let wave = f64::from(m - m0);
            let heights = (0..64).map(|i| amplitude * (wave * TAU * f64::from(i) / 64.0).cos());
            let problem =
                Problem::new(Profile::new(heights.collect(), period).unwrap(), INDEX, WAVELENGTH)
                    .unwrap();
            let solver =
                Solver::new(problem, (16.0 * period / WAVELENGTH) as usize, &nobody).unwrap();
            let light = Incidence { side: from, order: m0 };
            let kind = if from == to { Kind::Reflected } else { Kind::Transmitted };
            let got = unpolarised(&solver.solve(&[light]).unwrap()[0], kind, m);
            let ratio = got / (exact * amplitude.powi(2) / 4.0);
            worst = worst.max((ratio - 1.0).abs());
            count += 1;
        }
    }
    println!("Rayleigh and Rice: {count} ratios, off by {worst:.1e}");
    assert!(count > 60);
    assert!(worst < 1e-3, "{worst:e}");
}

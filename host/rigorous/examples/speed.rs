//! Time and memory of a solution on one core: `speed WAVELENGTHS [RQ SLOPE]`, lengths in wavelengths.
//!
//! A Gaussian surface, both polarisations, ten incidences, the number of nodes found for an error of 1e-7. The time is that of the
//! thread, so that other work of the machine does not count.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "it is a measurement")]

use std::cell::RefCell;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use asperity_rigorous::{Accuracy, Incidence, Part, Problem, Profile, Side, solve};

fn now() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    stat.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}

fn gaussian(rq: f64, slope: f64, period: f64) -> Profile {
    let length = 2.0f64.sqrt() * rq / slope;
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / f64::from(1u32 << 31)
    };
    let waves: Vec<(f64, f64, f64)> = (1..100_000)
        .map(|k| TAU * f64::from(k) / period)
        .take_while(|q| q * length < 12.0)
        .map(|q| {
            let sigma = rq
                * (2.0 * PI.sqrt() * length / period).sqrt()
                * (-(q * length).powi(2) / 8.0).exp();
            (q, sigma * (-2.0 * (1.0 - uniform()).ln()).sqrt(), TAU * uniform())
        })
        .collect();
    let count = 4 * waves.len().max(16);
    let height = |x: f64| waves.iter().map(|(q, a, phase)| a * (q * x + phase).cos()).sum();
    Profile::new((0..count).map(|i| height(period * i as f64 / count as f64)).collect(), period)
        .unwrap()
}

fn main() {
    let args: Vec<f64> = std::env::args().skip(1).map(|arg| arg.parse().unwrap()).collect();
    let argument = |at: usize, default: f64| args.get(at).copied().unwrap_or(default);
    let waves = argument(0, 30.1);
    let problem =
        Problem::new(gaussian(argument(1, 0.2), argument(2, 0.2), waves), 1.49, 1.0).unwrap();
    let incidences: Vec<Incidence> = (0..10)
        .map(|i| Incidence {
            side: if i % 2 == 0 { Side::Air } else { Side::Dielectric },
            order: i,
        })
        .collect();

    let parts: RefCell<Vec<(Part, f64)>> = RefCell::new(Vec::new());
    let begin = now();
    let last = RefCell::new(begin);
    let solution = solve(&problem, &incidences, Accuracy::default(), &|stage| {
        let time = now();
        let spent = time - last.replace(time);
        let mut parts = parts.borrow_mut();
        match parts.iter_mut().find(|(part, _)| *part == stage.part) {
            Some((_, sum)) => *sum += spent,
            None => parts.push((stage.part, spent)),
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    let end = now();
    println!(
        "{waves} wavelengths: {} nodes, {:.3} s, energy to {:.1e}",
        solution.nodes,
        end - begin,
        solution.energy_error
    );
    for (part, time) in parts.borrow().iter() {
        println!("  {:<40} {time:.3} s", part.words());
    }
    println!("  {:<40} {:.3} s", "solving and sending out", end - *last.borrow());
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    println!("  {}", status.lines().find(|line| line.starts_with("VmHWM")).unwrap());
}

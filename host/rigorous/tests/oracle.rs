//! Against Rayleigh's expansion, an independent method.
//!
//! In the grooves too the fields are taken as sums of outgoing waves; both boundary conditions are projected on the orders.
//! There is no Green's function, no singular integral and no node on the surface. On sinusoids the sums converge where
//! the slope is below 0.448 (R. Petit and M. Cadilhac, C. R. Acad. Sci. B 262 (1966) 468).
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where its data do, and shows what it measures"
)]

use std::f64::consts::TAU;

use asperity_rigorous::{Incidence, Kind, Polarisation, Problem, Profile, Side, Solver, nobody};
use num_complex::Complex64;

const PERIOD: f64 = 1.31;
const INDEX: f64 = 1.49;
const WAVELENGTH: f64 = 0.55;
/// Orders on each side, and samples of a period.
const ORDERS: i32 = 14;
const SAMPLES: usize = 128;

fn height(x: f64) -> f64 {
    let t = TAU * x / PERIOD;
    0.04 * t.sin() + 0.01 * (2.0 * t + 0.4).cos()
}

fn alpha(m: i32) -> f64 {
    TAU * f64::from(m) / PERIOD
}

fn beta(index: f64, m: i32) -> Complex64 {
    Complex64::new((TAU * index / WAVELENGTH).powi(2) - alpha(m).powi(2), 0.0).sqrt()
}

/// Projections on the order `p` of the wave `exp(i alpha_m x + i b z)` on the surface, and of its derivative along the normal
/// (times the stretch of the arc).
fn projections(m: i32, b: Complex64, p: i32) -> [Complex64; 2] {
    let mut sums = [Complex64::ZERO; 2];
    for i in 0..SAMPLES {
        let x = PERIOD * i as f64 / SAMPLES as f64;
        let e = 1e-5;
        let slope = (8.0 * (height(x + e) - height(x - e)) - height(x + 2.0 * e)
            + height(x - 2.0 * e))
            / (12.0 * e);
        let wave =
            (Complex64::I * (b * height(x) + (alpha(m) - alpha(p)) * x)).exp() / SAMPLES as f64;
        sums[0] += wave;
        sums[1] += Complex64::I * (b - alpha(m) * slope) * wave;
    }
    sums
}

/// Amplitudes that leave on both sides for light of the order `m0`, from order `-ORDERS` on.
fn rayleigh(incidence: Incidence, polarisation: Polarisation) -> [Vec<Complex64>; 2] {
    let count = (2 * ORDERS + 1) as usize;
    let jump = if polarisation == Polarisation::Te { 1.0 } else { INDEX * INDEX };
    let mut rows = vec![vec![Complex64::ZERO; 2 * count + 1]; 2 * count];
    let order = |at: usize| at as i32 - ORDERS;
    for p in 0..count {
        for m in 0..count {
            let above = projections(order(m), beta(1.0, order(m)), order(p));
            let below = projections(order(m), -beta(INDEX, order(m)), order(p));
            for (row, (above, below)) in
                [(p, (above[0], below[0])), (count + p, (jump * above[1], below[1]))]
            {
                rows[row][m] = above;
                rows[row][count + m] = -below;
            }
        }
        let b = match incidence.side {
            Side::Air => -beta(1.0, incidence.order),
            Side::Dielectric => beta(INDEX, incidence.order),
        };
        let light = projections(incidence.order, b, order(p));
        let (sign, scale) = if incidence.side == Side::Air { (-1.0, jump) } else { (1.0, 1.0) };
        rows[p][2 * count] = sign * light[0];
        rows[count + p][2 * count] = sign * scale * light[1];
    }
    let solution = eliminate(rows);
    [solution[..count].to_vec(), solution[count..].to_vec()]
}

/// Gauss' elimination with pivots.
fn eliminate(mut rows: Vec<Vec<Complex64>>) -> Vec<Complex64> {
    let count = rows.len();
    for k in 0..count {
        let best =
            (k..count).max_by(|a, b| rows[*a][k].norm().total_cmp(&rows[*b][k].norm())).unwrap();
        rows.swap(k, best);
        let pivot: Vec<Complex64> = rows[k].iter().map(|x| x / rows[k][k]).collect();
        rows[k].clone_from(&pivot);
        for (i, row) in rows.iter_mut().enumerate() {
            if i != k {
                let factor = row[k];
                for (x, y) in row.iter_mut().zip(&pivot) {
                    *x -= factor * y;
                }
            }
        }
    }
    rows.iter().map(|row| row[count]).collect()
}

#[test]
fn amplitudes_are_those_of_rayleigh() {
    let heights = (0..64).map(|i| height(PERIOD * f64::from(i) / 64.0)).collect();
    let problem = Problem::new(Profile::new(heights, PERIOD).unwrap(), INDEX, WAVELENGTH).unwrap();
    let incidences: Vec<Incidence> =
        [(Side::Air, 0), (Side::Air, 2), (Side::Dielectric, -1), (Side::Dielectric, 3)]
            .into_iter()
            .map(|(side, order)| Incidence { side, order })
            .collect();
    let responses = Solver::new(problem, 120, &nobody).unwrap().solve(&incidences).unwrap();
    let mut worst = 0.0f64;
    for response in &responses {
        for polarisation in [Polarisation::Te, Polarisation::Tm] {
            let [above, below] = rayleigh(response.incidence, polarisation);
            let flux = |side, m| {
                let jump = if polarisation == Polarisation::Te { 1.0 } else { INDEX * INDEX };
                if side == Side::Air { beta(1.0, m).re } else { beta(INDEX, m).re / jump }
            };
            let from = response.incidence.side;
            for out in response.orders(polarisation) {
                let side = if out.kind == Kind::Reflected { from } else { from.other() };
                let exact =
                    if side == Side::Air { &above } else { &below }[(out.m + ORDERS) as usize];
                let scale = (flux(side, out.m) / flux(from, response.incidence.order)).sqrt();
                worst = worst.max((out.amplitude - scale * exact).norm());
            }
        }
    }
    println!("amplitudes off by {worst:.1e}");
    assert!(worst < 1e-8, "{worst:e}");
}

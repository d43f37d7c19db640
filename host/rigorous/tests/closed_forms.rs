//! A flat surface, in closed form.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails where its data do, and shows what it measures"
)]

use std::f64::consts::TAU;

use asperity_rigorous::{Incidence, Kind, Polarisation, Problem, Profile, Side, Solver, nobody};
use num_complex::Complex64;

/// Fresnel's amplitude of the field along the grooves, reflected, and the shares of the power.
fn fresnel(index: f64, side: Side, sine: f64, polarisation: Polarisation) -> (Complex64, f64) {
    let (here, there) = if side == Side::Air { (1.0, index) } else { (index, 1.0) };
    let cos_here = Complex64::new(here * (1.0 - sine * sine).sqrt(), 0.0);
    let cos_there = Complex64::new(there * there - (here * sine).powi(2), 0.0).sqrt();
    let (a, b) = match polarisation {
        Polarisation::Te => (cos_here, cos_there),
        Polarisation::Tm => (cos_here / (here * here), cos_there / (there * there)),
    };
    let r = (a - b) / (a + b);
    (r, 1.0 - r.norm_sqr())
}

#[test]
fn a_flat_surface_is_that_of_fresnel() {
    for (index, height) in [(1.49, 0.0), (1.49, 0.3), (2.4, -0.1), (1.02, 0.0)] {
        let profile = Profile::new(vec![height; 16], 3.3).unwrap();
        let problem = Problem::new(profile, index, 0.5).unwrap();
        let solver = Solver::new(problem.clone(), 200, &nobody).unwrap();
        let mut incidences = Vec::new();
        for side in [Side::Air, Side::Dielectric] {
            let last = problem.last_order(side);
            incidences.extend((-last..=last).map(|order| Incidence { side, order }));
        }
        let mut beyond = 0;
        for response in solver.solve(&incidences).unwrap() {
            let Incidence { side, order } = response.incidence;
            let sine = problem.sine(side, order);
            let k = TAU * problem.index_of(side) / 0.5;
            // the reference plane of phases is z = 0
            let path = 2.0 * k * (1.0 - sine * sine).sqrt() * height;
            let phase = Complex64::from_polar(1.0, if side == Side::Air { -path } else { path });
            for polarisation in [Polarisation::Te, Polarisation::Tm] {
                let (r, transmitted) = fresnel(index, side, sine, polarisation);
                let mut sum = 0.0;
                for out in response.orders(polarisation) {
                    if out.m != order {
                        assert!(out.efficiency() < 1e-18);
                    } else if out.kind == Kind::Reflected {
                        assert!(
                            (out.amplitude - r * phase).norm() < 1e-9,
                            "{side:?} {order} {polarisation:?}"
                        );
                    } else {
                        assert!(
                            (out.efficiency() - transmitted).abs() < 1e-9,
                            "{side:?} {order} {polarisation:?}"
                        );
                        sum += 1.0;
                    }
                }
                if sum == 0.0 {
                    beyond += 1; // total reflection: its order does not travel in air
                }
            }
        }
        assert!(beyond > 0 || index < 1.1, "{index}");
    }
}

//! Sinusoidal gratings: Bessel functions, and what Kirchhoff's error is beside a rigorous solution.
//!
//! The usual shortcut takes the `q_z` of straight transmission for all orders, and no obliquity. Ours has the order's own, so the two
//! are to agree in the zeroth order alone; the others are nearer to the rigorous solution (`golden/interfaces.py`).

use std::f64::consts::PI;

use asperity::surface::{Edges, HeightMap};
use asperity_core::bsdf::Lobe;
use asperity_tests::oracle::fresnel;
use asperity_tests::{golden, tolerance};

use super::surfaces::{ETA, K, WAVELENGTH_UM, all, beam};

/// Bessel's function of integer order: the mean over a period, exact to rounding.
fn bessel(order: i32, x: f64) -> f64 {
    let points = 256;
    let at = |k: i32| {
        let t = 2.0 * PI * f64::from(k) / f64::from(points);
        (f64::from(order) * t - x * t.sin()).cos()
    };
    (0..points).map(at).sum::<f64>() / f64::from(points)
}

/// One period, one point wide.
fn grating(period_um: f64, peak_to_valley_um: f64) -> HeightMap {
    let points = 256;
    let height =
        |k: i32| 0.5 * peak_to_valley_um * (2.0 * PI * f64::from(k) / f64::from(points)).sin();
    let pitch = (period_um / f64::from(points), period_um);
    HeightMap::new((points as usize, 1), pitch, (0..points).map(height).collect()).unwrap()
}

#[test]
fn orders_of_gratings_are_those_of_the_table() {
    let rows = golden::numbers("gratings.csv");
    for (period, pv) in [(2.0, 0.3), (4.0, 0.5), (8.0, 0.5), (8.0, 1.0)] {
        let map = grating(period, pv);
        let found = &all(&map, Edges::Periodic, &[beam(0.0, true, Lobe::Transmission)])[0];
        // ours, the shortcut's: worst and sum of squares of the distance to the rigorous column
        let (mut worst, mut squares, mut count, mut sums) = ([0.0_f64; 2], [0.0; 2], 0, [0.0; 3]);
        println!("period {period} pv {pv}: order, ours, the shortcut, rigorous, intensity off");
        for row in &rows {
            let &[p, h, order, rigorous] = row.as_slice() else { panic!("{row:?}") };
            if (p - period).abs() + (h - pv).abs() > 1e-9 {
                continue;
            }
            let number = [order as isize, 0];
            // orders that no facet leads to, as none of index 1.49 bends light by more than 48 degrees, are not kept
            let ours = found.iter().find(|o| o.number == number);
            let sine = order * WAVELENGTH_UM / (period * ETA);
            let q_z = K * (ETA * (1.0 - sine * sine).sqrt() - 1.0);
            assert!(ours.is_some() == (q_z > 0.0), "{row:?} {ours:?}");
            let (intensity, power) = ours.map_or((0.0, 0.0), |o| (o.intensity, o.power));
            let exact = if q_z > 0.0 { bessel(order as i32, 0.5 * pv * q_z).powi(2) } else { 0.0 };
            let off = intensity - exact;
            assert!(off.abs() < tolerance::GRATING.allowed, "{row:?} {ours:?} {exact}");
            // one q_z for all orders, that of straight transmission, and no obliquity
            let straight = K * (ETA - 1.0);
            let kirchhoff =
                fresnel(1.0, ETA).through() * bessel(order as i32, 0.5 * pv * straight).powi(2);
            println!(
                "{order:4} {:.6} {kirchhoff:.6} {rigorous:.6} {off:+.1e}, {:+.5} {:+.5}",
                power,
                power - rigorous,
                kirchhoff - rigorous
            );
            // where the order's own q_z leaves the phase as it is
            if 0.5 * pv * (q_z - straight).abs() < 2e-3 {
                let allowed = tolerance::GRATING.allowed;
                assert!((power - kirchhoff).abs() < allowed, "{row:?} {ours:?}");
            }
            for (k, value) in [power, kirchhoff].into_iter().enumerate() {
                worst[k] = worst[k].max((value - rigorous).abs());
                squares[k] += (value - rigorous).powi(2);
            }
            for (sum, value) in sums.iter_mut().zip([power, kirchhoff, rigorous]) {
                *sum += value;
            }
            count += 1;
        }
        assert!(count > 10, "{count}");
        let rms = squares.map(|s: f64| (s / f64::from(count)).sqrt());
        println!(
            "period {period} pv {pv}: from the rigorous solution, worst and rms: ours {:.5} {:.5}, the shortcut \
             {:.5} {:.5}; sums {:.4} {:.4} {:.4}",
            worst[0], rms[0], worst[1], rms[1], sums[0], sums[1], sums[2]
        );
        assert!(worst[0] < tolerance::GRATING_RIGOROUS.allowed, "{worst:?}");
        // a q_z of their own and the obliquity bring orders nearer to the truth
        assert!(rms[0] < 0.5 * rms[1], "{rms:?}");
    }
}

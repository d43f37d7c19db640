//! Orders of a map against direct sums at just their directions: every order in the plane of incidence, and some
//! out of it.

use asperity::kirchhoff::{Beam, BeamOrders, orders};
use asperity::surface::{Edges, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;

use crate::common::{Random, ior};
use asperity_tests::kirchhoff::{intensity, obliquity};

const ETA: f64 = 1.49;
const WAVELENGTH_UM: f64 = 0.55;

/// All beams of some incidences: both sides, both lobes.
fn beams(incidences_deg: &[f64], azimuth_deg: f64) -> Vec<Beam> {
    let mut beams = Vec::new();
    for deg in incidences_deg {
        let (s, c) = deg.to_radians().sin_cos();
        let (sin, cos) = azimuth_deg.to_radians().sin_cos();
        for z in [c, -c] {
            let wi = Direction::from_unit(-s * cos, -s * sin, z);
            for lobe in [Lobe::Reflection, Lobe::Transmission] {
                beams.push(Beam { wi, lobe, wavelength_um: WAVELENGTH_UM });
            }
        }
    }
    beams
}

fn all(map: &HeightMap, edges: Edges, beams: &[Beam]) -> Vec<BeamOrders> {
    orders(map, edges, ior(ETA), beams, Watch::nobody()).unwrap().unwrap()
}

fn sinusoid((nx, ny): (usize, usize), pitch: f64) -> HeightMap {
    let height =
        |k: usize| 0.25 * (std::f64::consts::TAU * 5.0 * (k % nx) as f64 / nx as f64).sin();
    HeightMap::new((nx, ny), (pitch, pitch), (0..nx * ny).map(height).collect()).unwrap()
}

fn random((nx, ny): (usize, usize), pitch: f64) -> HeightMap {
    let mut random = Random::new(77);
    let waves: Vec<[f64; 4]> = (0..40)
        .map(|_| {
            let amplitude = random.between(0.02, 0.12);
            [random.between(-7.0, 7.0), random.between(-7.0, 7.0), random.next(), amplitude]
        })
        .collect();
    let height = |k: usize| {
        let (x, y) = ((k % nx) as f64 / nx as f64, (k / nx) as f64 / ny as f64);
        let wave =
            |w: &[f64; 4]| w[3] * (std::f64::consts::TAU * (w[0] * x + w[1] * y + w[2])).sin();
        waves.iter().map(wave).sum()
    };
    HeightMap::new((nx, ny), (pitch, pitch), (0..nx * ny).map(height).collect()).unwrap()
}

#[test]
fn orders_are_those_of_the_direct_sum() {
    let maps = [
        ("sinusoid", sinusoid((96, 40), 0.2), Edges::Periodic),
        ("random, torn", random((90, 75), 0.2), Edges::Periodic),
        ("random", random((90, 75), 0.2), Edges::Mirrored),
    ];
    for (name, map, edges) in &maps {
        let mut worst = 0.0_f64;
        for azimuth in [0.0, 37.0] {
            for found in all(map, *edges, &beams(&[0.0, 30.0, 60.0], azimuth)) {
                let Beam { wi, lobe, .. } = *found.beam();
                let (mut squares, mut count, mut peak) = (0.0, 0, 0.0_f64);
                for order in found.iter() {
                    let [_, y] = order.number;
                    if !(y == 0 || (y == -3 && order.number[0] % 5 == 0)) {
                        continue;
                    }
                    let pair = (wi, order.wo);
                    let exact = intensity(map, *edges, ETA, WAVELENGTH_UM, pair);
                    let factor = obliquity(ETA, wi, order.wo) / order.wo.z().abs();
                    // power itself is averaged over the order's cell towards the horizon
                    let power = order.intensity * factor;
                    squares += (power - exact * factor).powi(2);
                    if order.wo.z().abs() > 0.4 && power > 0.0 {
                        assert!((order.power / power - 1.0).abs() < 2e-2, "{order:?} {power}");
                    }
                    peak = peak.max(exact * factor);
                    count += 1;
                }
                if peak > 0.0 {
                    let error = 100.0 * (squares / f64::from(count)).sqrt() / peak;
                    assert!(count > 30, "{name} {wi:?} {lobe:?} {count}");
                    worst = worst.max(error);
                }
            }
        }
        println!("{name}: largest RMSD {worst:.5} % of the peak");
        assert!(worst < 0.5, "{name}: {worst} %");
    }
}

//! Little roughness: the light that is lost to diffuse light, and first-order perturbation; none: Fresnel.

use asperity::surface::{Edges, HeightMap};
use asperity_core::bsdf::{Bsdf, Lobe};
use asperity_core::direction::Direction;
use asperity_tests::oracle::{fluxes, fresnel};
use asperity_tests::{golden, tolerance};

use super::surfaces::{ETA, Gaussian, K, LOBES, Ring, all, beam, boundary, index, momentum};
use crate::common::{dir, incidence, wide};
use asperity_tests::kirchhoff::obliquity;

const SURFACE: Gaussian = Gaussian { sigma_um: 0.01, length_um: 2.0 };
const PITCH_UM: f64 = 0.5;
const SIZE: usize = 128;

fn reflectance(wi: Direction<f64>) -> f64 {
    let relative = if wi.z() > 0.0 { ETA } else { 1.0 / ETA };
    fresnel(wi.z().abs(), relative).unpolarised()
}

#[test]
fn little_roughness_scatters_the_square_of_its_phase() {
    let maps = SURFACE.maps(SIZE, PITCH_UM, 4, 1);
    let laws: Vec<_> = maps.iter().map(|map| boundary(map, Edges::Periodic)).collect();
    for air in [true, false] {
        let wi = dir(incidence(0.0, air));
        let r = reflectance(wi);
        let n = index(wi);
        // all of the phase is small: reflection 2 k n sigma, transmission k (n - 1) sigma
        let expected = [
            r * (2.0 * K * n * SURFACE.sigma_um).powi(2),
            (1.0 - r) * (K * (ETA - 1.0) * SURFACE.sigma_um).powi(2),
        ];
        let beams = LOBES.map(|lobe| beam(0.0, air, lobe));
        let (mut by_orders, mut by_law) = ([0.0; 2], [0.0; 2]);
        for (map, law) in maps.iter().zip(&laws) {
            for (sum, found) in by_orders.iter_mut().zip(all(map, Edges::Periodic, &beams)) {
                let (all, coherent) = found.totals();
                *sum += (all - coherent) / maps.len() as f64;
            }
            let flux = fluxes(wide(wi), ETA, 0.1, [200, 8], |wo| law.ars(wi, dir(wo)));
            for (sum, flux) in by_law.iter_mut().zip(flux) {
                *sum += flux / maps.len() as f64;
            }
        }
        for k in 0..2 {
            let g = expected[k] / if k == 0 { r } else { 1.0 - r };
            let off = [by_orders[k], by_law[k]].map(|found| found / expected[k] - 1.0);
            println!(
                "diffuse, air {air}, {:?}: g {g:.4}, expected {:.4e}, orders {:+.2} %, mean law {:+.2} %",
                LOBES[k],
                expected[k],
                100.0 * off[0],
                100.0 * off[1]
            );
            // to first order in g; the next is half of it
            for off in off {
                let off = off + 0.5 * g;
                assert!(off.abs() < tolerance::LITTLE_ROUGHNESS.allowed, "{air} {k} {off}");
            }
        }
    }
}

/// Kirchhoff's light of the surface, 1/sr without cosine.
fn closed_form(wi: Direction<f64>, wo: Direction<f64>) -> f64 {
    let [q, q_z] = momentum(wi, wo);
    let n = K * index(wo);
    n * n * SURFACE.density(q, q_z) * obliquity(ETA, wi, wo) / wo.z().abs()
}

#[test]
fn near_the_specular_direction_it_is_first_order_perturbation() {
    let rows = golden::numbers("perturbation.csv");
    let laws: Vec<_> = SURFACE
        .maps(SIZE, PITCH_UM, 4, 2)
        .iter()
        .map(|map| boundary(map, Edges::Periodic))
        .collect();
    let step = std::f64::consts::TAU / (SIZE as f64 * PITCH_UM);
    for kind in 0..4 {
        let (from_air, to_air) = (kind < 2, kind == 0 || kind == 3);
        for degrees in [0.0, 15.0, 30.0] {
            let wi = dir(incidence(degrees, from_air));
            let n_o = if to_air { 1.0 } else { ETA };
            let specular = (-index(wi) * wi.x() / n_o).asin().to_degrees();
            let (mut worst, mut closed, mut count) = (0.0_f64, 0.0_f64, 0);
            for row in &rows {
                let &[k, i, o, want] = row.as_slice() else { panic!("{row:?}") };
                let other = (k - f64::from(kind)).abs() + (i - degrees).abs() > 1e-9;
                if other || (o - specular).abs() > 5.0 {
                    continue;
                }
                let (s, c) = o.to_radians().sin_cos();
                let wo = Direction::from_unit(s, 0.0, if to_air { c } else { -c });
                let ring = Ring::new(momentum(wi, wo)[0], 600.0, step);
                let (mut found, mut expected) = (0.0, 0.0);
                for law in &laws {
                    for wo in ring.directions(wi, to_air) {
                        found += law.eval(wi, wo);
                        expected += closed_form(wi, wo);
                    }
                }
                // the first order of the closed form in place of all of them
                let [q, q_z] = momentum(wi, wo);
                let first = SURFACE.first_order(q, q_z) / SURFACE.density(q, q_z);
                let first = first * closed_form(wi, wo) / want;
                worst = worst.max((found / expected * first - 1.0).abs());
                closed = closed.max((first - 1.0).abs());
                count += 1;
            }
            println!(
                "perturbation, type {kind} from {degrees} deg: {count} rows within 5 deg of the specular: worst \
                 {:.1} %, of the closed form {:.1} %",
                100.0 * worst,
                100.0 * closed
            );
            assert!(count > 4 && worst < tolerance::PERTURBATION.allowed, "{kind} {degrees}");
        }
    }
}

#[test]
fn a_flat_map_is_smooth() {
    let map = HeightMap::new((16, 10), (0.3, 0.4), vec![2.5; 160]).unwrap();
    let mut worst = 0.0_f64;
    for edges in [Edges::Periodic, Edges::Mirrored] {
        let law = boundary(&map, edges);
        for degrees in [0.0, 20.0, 41.0, 60.0, 85.0] {
            for air in [true, false] {
                let wi = dir(incidence(degrees, air));
                let exact = [reflectance(wi), 1.0 - reflectance(wi)];
                let coherent = law.coherent(wi);
                let found = LOBES.map(|lobe| beam(degrees, air, lobe));
                for (k, found) in all(&map, edges, &found).iter().enumerate() {
                    let (all, specular) = found.totals();
                    let of_law = [coherent.reflected, coherent.transmitted][k];
                    let off = [all - exact[k], specular - exact[k], of_law - exact[k]];
                    let off = off.map(f64::abs).into_iter().fold(0.0, f64::max);
                    worst = worst.max(off);
                    assert!(
                        off < tolerance::FLAT_WAVE.allowed,
                        "{edges:?} {degrees} {air} {k} {off}"
                    );
                    let lobe = [Lobe::Reflection, Lobe::Transmission][k];
                    let other = found.iter().filter(|o| !o.is_specular()).map(|o| o.power);
                    let other = other.fold(0.0, f64::max);
                    assert!(other < 1e-9, "{edges:?} {degrees} {air} {lobe:?} {other}");
                }
                for z in [0.9, 0.3, -0.2, -0.95_f64] {
                    let wo = Direction::from_unit((1.0 - z * z).sqrt(), 0.0, z);
                    assert!(law.ars(wi, wo) < 1e-6, "{degrees} {air} {z} {}", law.ars(wi, wo));
                }
            }
        }
    }
    println!("flat: within {worst:.1e} of Fresnel");
}

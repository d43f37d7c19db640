//! Flux: no boundary gives back more than it gets, and two integrals agree on what it gives.

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_core::{fresnel, ndf};
use asperity_tests::oracle::{self, Vec3, gauss};
use asperity_tests::{extensive, tolerance};

use crate::common::{alpha, dir, ggx, incidence};

/// Reflected, transmitted and visible area (which must be 1) by quadrature over facets.
///
/// Own warp: `tan theta_m = alpha tan chi`, with density `sin chi cos chi dchi dphi / pi` of projected
/// area; all else is core's `D`, `G1`, Fresnel and directions. The azimuths run to where facets turn away.
fn over_facets(a: f64, n: f64, wi: Vec3, rule: &[(f64, f64)]) -> [f64; 3] {
    let alpha = alpha::<f64>(a);
    let w = dir::<f64>(wi);
    let far = if wi[2] > 0.0 { n } else { 1.0 / n };
    let slope = a * wi[0].abs() / wi[2].abs();
    let kink = (1.0 / slope).atan(); // beyond it some facets of a ring are turned away
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut sums = [0.0; 3];
    for (from, to, wholly) in [(0.0, kink.min(quarter), true), (kink.min(quarter), quarter, false)]
    {
        if from >= to {
            continue; // no facet of any ring is turned away
        }
        for &(x, wx) in rule {
            // the square starts gently where the range of azimuths shrinks like a root
            let (x, wx) = if wholly { (x, wx) } else { (x * x, 2.0 * x * wx) };
            let chi = from + (to - from) * x;
            let (s, c) = chi.sin_cos();
            let t = a * s / c;
            let most = if wholly { std::f64::consts::PI } else { (-(c / s) / slope).acos() };
            for &(y, wy) in rule {
                let (sp, cp) = (most * y).sin_cos();
                // light comes from -x, or, inside, facets are seen from below
                let lean = if wi[2] > 0.0 { -cp } else { cp };
                let z = 1.0 / (1.0 + t * t).sqrt();
                let m = Direction::from_unit(t * z * lean, t * z * sp, z);
                // D cos dw, with dw = sin theta dtheta dphi; both halves of the azimuth
                let dtheta = a / (c * c) / (1.0 + t * t) * (to - from) * wx;
                let area = ndf::ggx::d(alpha, m) * z * (t * z) * dtheta * 2.0 * most * wy;
                let facing = (m.dot(w) * wi[2].signum()).max(0.0);
                let seen = area * facing / (z * wi[2].abs()) * ndf::ggx::g1(alpha, w);
                let f = fresnel::dielectric(facing, far);
                sums[2] += seen;
                let r = w.reflect(m);
                if r.z() * wi[2] > 0.0 {
                    sums[0] += seen * f.reflected * ndf::ggx::g1(alpha, r);
                }
                if let Some(o) = w.refract(m, far)
                    && o.z() * wi[2] < 0.0
                {
                    sums[1] += seen * f.transmitted * ndf::ggx::g1(alpha, o);
                }
            }
        }
    }
    sums
}

#[test]
fn transmitted_plus_reflected_never_exceeds_incident() {
    let rule = gauss(if extensive() { 128 } else { 48 });
    let mut most = (0.0_f64, String::new());
    let mut worst_area = 0.0_f64;
    for a in [1e-4, 1e-3, 0.01, 0.05, 0.2, 0.5, 1.0, 2.0, 5.0] {
        for n in [1.0001, 1.05, 1.33, 1.49, 2.0, 4.0] {
            for air in [true, false] {
                for deg in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0, 89.9] {
                    let [r, t, area] = over_facets(a, n, incidence(deg, air), &rule);
                    let case =
                        format!("alpha {a} n {n} {deg} deg air {air}: R {r} T {t} area {area}");
                    assert!(r >= 0.0 && t >= 0.0 && area.is_finite(), "{case}");
                    assert!(r + t <= 1.0 + tolerance::ENERGY.allowed, "{case}");
                    worst_area = worst_area.max((area - 1.0).abs());
                    if r + t > most.0 {
                        most = (r + t, case);
                    }
                }
            }
        }
    }
    println!("energy: most R + T - 1 = {:.1e} ({})", most.0 - 1.0, most.1);
    println!("energy: area of the visible facets is 1 within {worst_area:.1e}");
    assert!(worst_area < tolerance::ENERGY.allowed, "{worst_area:e}");
}

#[test]
fn the_integral_of_ars_over_directions_is_that_over_facets() {
    let rule = gauss(if extensive() { 800 } else { 200 });
    let mut worst = (0.0_f64, String::new());
    for a in [0.05, 0.2, 0.5, 1.0, 5.0] {
        for n in [1.05, 1.49, 4.0] {
            let law = ggx::<f64>(a, n);
            for air in [true, false] {
                for deg in [0.0, 30.0, 60.0, 80.0, 89.0] {
                    let wi = incidence(deg, air);
                    let [r, t, _] = over_facets(a, n, wi, &rule);
                    let grid = if extensive() { [1200, 360] } else { [300, 180] };
                    // refracted lobes of nearly equal indices are narrower than those of the facets
                    let width = 0.7 * a.min(1.0) * (n - 1.0_f64).min(1.0).sqrt();
                    let [br, bt] = oracle::fluxes(wi, n, width, grid, |o| law.ars(dir(wi), dir(o)));
                    let error = (r - br).abs().max((t - bt).abs());
                    let case = format!("alpha {a} n {n} {deg} deg air {air}: {r} {t}, {br} {bt}");
                    assert!(error < tolerance::ENERGY_BRUTE.allowed, "{case}");
                    assert!(br + bt <= 1.0 + tolerance::ENERGY_BRUTE.allowed, "{case}");
                    if error > worst.0 {
                        worst = (error, case);
                    }
                }
            }
        }
    }
    println!("energy: facets against directions, worst {:.1e} ({})", worst.0, worst.1);
}

/// R and T from air, n 1.49, by 20 000 samples of another program, at 0, 60 and 80 degrees.
const TABLE: [(f64, [[f64; 2]; 3]); 4] = [
    (0.05, [[0.0372, 0.9627], [0.0875, 0.9110], [0.3325, 0.6421]]),
    (0.2, [[0.0356, 0.9601], [0.0715, 0.9021], [0.1617, 0.7518]]),
    (0.5, [[0.0262, 0.9431], [0.0413, 0.8433], [0.0706, 0.6819]]),
    (1.0, [[0.0124, 0.8835], [0.0198, 0.6547], [0.0327, 0.4255]]),
];

#[test]
fn single_scattering_loses_what_other_programs_say_it_loses() {
    let rule = gauss(96);
    println!("energy of single-scatter GGX, n 1.49, from air: R T lost at 0, 60, 80 deg");
    let mut worst = 0.0_f64;
    for (a, row) in TABLE {
        print!("  alpha {a:5}");
        for (deg, want) in [0.0, 60.0, 80.0].into_iter().zip(row) {
            let [r, t, _] = over_facets(a, 1.49, incidence(deg, true), &rule);
            print!("   {r:.4} {t:.4} {:.4}", 1.0 - r - t);
            let error = (r - want[0]).abs().max((t - want[1]).abs());
            assert!(error < tolerance::ENERGY_TABLE.allowed, "{a} {deg}: {r} {t} {want:?}");
            worst = worst.max(error);
        }
        println!();
    }
    println!("  worst deviation from the published table {worst:.4}");
}

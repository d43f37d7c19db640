//! The Normals method: its normalisation, its facets against reference data, its flux.

use asperity_core::bsdf::{Bsdf, Scatter};
use asperity_core::direction::Direction;
use asperity_core::ndf;
use asperity_core::ndf::law::Profile;
use asperity_core::ndf::normals::NormalDensity;
use asperity_tests::oracle::{self, Vec3, combine, dot, unit};
use asperity_tests::{count, golden, tolerance};

use crate::common::{Random, alpha, dir, ggx, incidence, law, normals};

const CASES: [(Profile, f64, f64); 10] = [
    (Profile::Gauss, 0.1, 2.0),
    (Profile::Gauss, 1e-3, 2.0),
    (Profile::Gauss, 0.3, 0.7),
    (Profile::Gauss, 0.2, 64.0),
    (Profile::Gauss, 1.5, 8.0),
    (Profile::Gauss, 10.0, 0.5),
    (Profile::Cauchy, 0.1, 2.5),
    (Profile::Cauchy, 1e-3, 0.5),
    (Profile::Cauchy, 0.4, 2.0),
    (Profile::Cauchy, 0.3, 64.0),
];

/// The paper's profiles with the signs put right, spelled anew.
fn profile(kind: Profile, delta: f64, n: f64, theta: f64) -> f64 {
    match kind {
        Profile::Gauss => (-theta.powf(n) / (2.0 * delta.powf(n))).exp(),
        Profile::Cauchy => 1.0 / (1.0 + (theta / delta).powf(n)),
    }
}

/// `2 pi integral F sin theta`, midpoints in `asinh(theta / delta)`.
fn norm(kind: Profile, delta: f64, n: f64) -> f64 {
    let small = 0.1 * delta;
    let end = (std::f64::consts::FRAC_PI_2 / small).asinh();
    let steps = 200_000;
    let h = end / f64::from(steps);
    (0..steps)
        .map(|k| {
            let y = (f64::from(k) + 0.5) * h;
            let theta = small * y.sinh();
            profile(kind, delta, n, theta) * theta.sin() * small * y.cosh() * h
        })
        .sum::<f64>()
        * std::f64::consts::TAU
}

#[test]
fn the_density_of_normals_is_the_paper_s_law_normalised_over_the_hemisphere() {
    for (kind, delta, n) in CASES {
        let density: NormalDensity<f64, 256> = NormalDensity::new(law(kind, delta, n));
        let c = norm(kind, delta, n);
        for theta in [0.0, 0.3 * delta, delta, 3.0 * delta, 0.5, 1.5_f64] {
            if theta > std::f64::consts::FRAC_PI_2 {
                continue;
            }
            let (s, z) = theta.sin_cos();
            let (got, want) = (density.density(s, z) * c, profile(kind, delta, n, theta));
            let case = format!("{kind:?} delta {delta} n {n} theta {theta}: {got:e} {want:e}");
            assert!(
                (got - want).abs() <= tolerance::NORMALISATION.allowed * want + 1e-300,
                "{case}"
            );
        }
    }
}

/// The facet that turns `wi` into `wo`, facing the air.
fn facet(wi: Vec3, wo: Vec3, n: f64) -> Vec3 {
    let index = |w: Vec3| if w[2] > 0.0 { 1.0 } else { n };
    let h = unit(combine(index(wi), wi, index(wo), wo));
    if h[2] > 0.0 { h } else { h.map(|x| -x) }
}

/// Share of normals of a law that face `wi`, by rings about the pole.
fn visible(wi: Vec3, delta: f64, p: impl Fn(Vec3) -> f64) -> f64 {
    oracle::over_the_sphere([0.0, 0.0, 1.0], delta, [400, 400], |m| {
        if m[2] > 0.0 && dot(m, wi) * wi[2] > 0.0 { p(m) } else { 0.0 }
    })
}

/// The file has Gaussian slopes and facets weighted by their projection, without shadowing:
/// `f_ref = D(m) |wi.m| J F / |cos_i cos_o|`. GGX and Normals contain the same `|wi.m| J F` times factors that
/// are public or elementary, so both are brought to the file's law by a quotient of densities.
#[test]
fn the_facets_of_both_laws_agree_with_reference_data() {
    let rows = golden::numbers("facets.csv");
    assert!(rows.len() > 1000);
    let (s, n) = (0.1_f64, 1.49);
    let (kind, delta, exponent) = (Profile::Gauss, 0.15, 2.0);
    let smith = ggx::<f64>(0.2, n);
    let width = alpha::<f64>(0.2);
    let drawn = normals::<f64>(kind, delta, exponent, n);
    let c = norm(kind, delta, exponent);
    let p = |m: Vec3| profile(kind, delta, exponent, m[0].hypot(m[1]).atan2(m[2])) / c;
    let mut worst = [0.0_f64; 4];
    let mut seen = [0; 4];
    let mut last = (f64::NAN, false, 1.0);
    for row in rows {
        let &[geometry, i, o, want] = row.as_slice() else { panic!("{row:?}") };
        let from_air = geometry < 2.0;
        let through = geometry as i32 % 2 == 1;
        let wi = incidence(i, from_air);
        // the file's directions of observation are 1e-3 degrees further on than it says
        let (sin, cos) = (o + 1e-3).to_radians().sin_cos();
        let wo = [sin, 0.0, if from_air == through { -cos } else { cos }];
        let m = facet(wi, wo, n);
        let tan2 = (m[0] * m[0] + m[1] * m[1]) / (m[2] * m[2]);
        let d = (-tan2 / (s * s)).exp() / (std::f64::consts::PI * s * s * m[2].powi(4));
        let masked = ndf::ggx::g1(width, dir(wi)) * ndf::ggx::g1(width, dir(wo));
        let from_ggx: f64 = smith.eval(dir(wi), dir(wo)) * d / ndf::ggx::d(width, dir(m)) / masked;
        if (last.0 - i).abs() > 0.0 || last.0.is_nan() || last.1 != from_air {
            last = (i, from_air, visible(wi, delta, p));
        }
        let weight = d * dot(wi, m).abs() / (wi[2].abs() * p(m) / last.2);
        let from_normals: f64 = drawn.ars(dir(wi), dir(wo)) * weight / wo[2].abs();
        // what the law of the file hardly ever draws is written with few digits, or not at all
        if want < 1e-12 {
            continue;
        }
        let errors = [(from_ggx / want - 1.0).abs(), (from_normals / want - 1.0).abs()];
        let case =
            format!("type {geometry} {i} {o}: {want:e} ggx {from_ggx:e} normals {from_normals:e}");
        assert!(errors[0] < tolerance::FACET_REFERENCE.allowed, "{case}");
        assert!(errors[1] < tolerance::NORMALS_FLUX.allowed, "{case}");
        let k = geometry as usize;
        worst[k] = worst[k].max(errors[0]);
        seen[k] += 1;
    }
    println!(
        "facets against the reference: worst relative deviation {:.1e} of {seen:?} values",
        worst.iter().copied().fold(0.0, f64::max)
    );
    assert!(seen.iter().all(|&k| k > 30), "{seen:?}");
}

#[test]
fn reflected_transmitted_and_lost_make_one_in_sampling_as_in_quadrature() {
    let mut random = Random::new(4);
    println!("Normals: incidence, side, R and T by quadrature, R T lost by sampling");
    for (kind, delta, exponent) in
        [(Profile::Gauss, 0.1, 2.0), (Profile::Gauss, 0.5, 4.0), (Profile::Cauchy, 0.3, 2.5)]
    {
        let boundary = normals::<f64>(kind, delta, exponent, 1.49);
        for air in [true, false] {
            for deg in [0.0, 35.0, 60.0, 80.0] {
                let wi = incidence(deg, air);
                let [r, t] = oracle::fluxes(wi, 1.49, delta, [120, 180], |wo| {
                    boundary.ars(dir(wi), dir(wo))
                });
                let rays = count(40_000);
                let mut went = [0.0; 3];
                for _ in 0..rays {
                    let s = boundary.sample(dir(wi), &mut || random.next());
                    let k = s.map_or(2, |s| usize::from(s.wo.z() * wi[2] < 0.0));
                    went[k] += s.map_or(1.0, |s| s.weight) / rays as f64;
                }
                let case = format!("{kind:?} {delta} {exponent} {deg} air {air}: {r} {t} {went:?}");
                println!("  {case}");
                for (got, want) in [(went[0], r), (went[1], t), (went[2], 1.0 - r - t)] {
                    let noise =
                        (want.clamp(0.0, 1.0) * (1.0 - want.clamp(0.0, 1.0)) / rays as f64).sqrt();
                    let allowed =
                        tolerance::NORMALS_FLUX.allowed + tolerance::MONTE_CARLO.allowed * noise;
                    assert!((got - want).abs() < allowed, "{case}");
                }
            }
        }
    }
}

#[test]
fn every_normal_drawn_lies_above_the_surface() {
    let mut random = Random::new(5);
    for (kind, delta, exponent) in CASES {
        let density: NormalDensity<f64, 256> = NormalDensity::new(law(kind, delta, exponent));
        for _ in 0..1000 {
            let m: Direction<f64> = density.sample([random.next(), random.next()]);
            assert!(m.z() > 0.0 && (m.dot(m) - 1.0).abs() < 1e-14, "{kind:?} {delta} {m:?}");
        }
    }
}

#[test]
fn the_tail_of_the_drawn_normals_is_no_fatter_than_the_table_of_quantiles() {
    let mut random = Random::new(8);
    println!("Normals, gauss n = 2: share drawn beyond k standard deviations, and exactly");
    for delta in [0.1, 0.01, 1e-3] {
        let density: NormalDensity<f64, 256> = NormalDensity::new(law(Profile::Gauss, delta, 2.0));
        let rays = count(500_000);
        let mut beyond = [0.0; 4];
        for _ in 0..rays {
            let m: Direction<f64> = density.sample([random.next(), random.next()]);
            let theta = m.x().hypot(m.y()).atan2(m.z());
            for (k, share) in beyond.iter_mut().enumerate() {
                *share += f64::from(theta > delta * (3.0 + k as f64)) / rays as f64;
            }
        }
        println!(
            "  delta {delta:6}: {beyond:.1?}",
            beyond = beyond.map(|x| x * 1e6).map(f64::round)
        );
        for (k, got) in beyond.into_iter().enumerate() {
            // small widths: Rayleigh's law
            let want = (-0.5 * (3.0 + k as f64).powi(2)).exp();
            let noise = tolerance::MONTE_CARLO.allowed * (want / rays as f64).sqrt();
            let curved = 10.0 * delta * delta * want;
            let allowed = tolerance::NORMALS_TAIL.allowed + noise + curved;
            assert!((got - want).abs() < allowed, "delta {delta} beyond {}: {got} {want}", 3 + k);
        }
    }
}

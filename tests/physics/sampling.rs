//! Every sampler against its density by chi-square.

use asperity_core::bsdf::{Backing, Bsdf, Mix, MixShares, OpaqueGgx};
use asperity_core::math::Real;
use asperity_core::ndf::law::Profile;
use asperity_tests::chi2::{Bins, Fit, sidak};
use asperity_tests::oracle::Vec3;
use asperity_tests::{count, tolerance};

use crate::common::{Random, alpha, dir, ggx, incidence, ior, normals, wide};

/// Incidence in degrees and side: near normal, oblique, grazing, inside, beyond the critical angle.
const INCIDENCES: [(f64, bool); 7] = [
    (1.0, true),
    (50.0, true),
    (80.0, true),
    (88.5, true),
    (20.0, false),
    (41.0, false),
    (65.0, false),
];

/// Tests samples of `law` in `T` from `wi` against `pdf`.
fn fit<T: Real>(law: &impl Bsdf<T>, pdf: impl Fn(Vec3) -> f64, wi: Vec3, seed: u128) -> Fit {
    let mut random = Random::new(seed);
    let mut sample = || {
        let s = law.sample(dir(wi), &mut || random.next());
        s.map(|s| wide(s.wo))
    };
    let pilot: Vec<Vec3> = (0..200_000).filter_map(|_| sample()).take(20_000).collect();
    let bins = Bins::new(&pilot, 80);
    let integrals = bins.integrals(&pdf, 1e-7);
    bins.test(&integrals, count(150_000), sample)
}

/// Fails unless all fits hold together; prints the family.
fn judge(what: &str, fits: &[(String, Fit)]) {
    let each = sidak(tolerance::SIGNIFICANCE.allowed, fits.len());
    let least = fits.iter().map(|(_, f)| f.p).fold(1.0, f64::min);
    println!(
        "sampling, {what}: {} cases, least p {least:.4}, failing below {each:.1e}",
        fits.len()
    );
    for (case, f) in fits {
        assert!(f.freedom >= 15, "{case}: {f:?} has too few bins to judge");
        assert!(f.p > each, "{case}: {f:?}");
    }
}

#[test]
fn ggx_samples_follow_their_density() {
    let mut fits = Vec::new();
    for a in [1e-3, 0.05, 0.3, 1.0, 3.0] {
        for (deg, air) in INCIDENCES {
            let (law, wi) = (ggx::<f64>(a, 1.49), incidence(deg, air));
            let f = fit(&law, |o| law.pdf(dir(wi), dir(o)), wi, fits.len() as u128);
            fits.push((format!("alpha {a} n 1.49 {deg} deg air {air}"), f));
        }
    }
    for (a, n) in [(0.2, 1.05), (0.2, 4.0), (0.5, 0.7)] {
        for (deg, air) in [(40.0, true), (75.0, true), (10.0, false), (60.0, false)] {
            let (law, wi) = (ggx::<f64>(a, n), incidence(deg, air));
            let f = fit(&law, |o| law.pdf(dir(wi), dir(o)), wi, fits.len() as u128);
            fits.push((format!("alpha {a} n {n} {deg} deg air {air}"), f));
        }
    }
    judge("GGX", &fits);
}

#[test]
fn single_precision_samples_follow_the_density_of_double_precision() {
    let mut fits = Vec::new();
    for a in [0.01, 0.3, 1.0] {
        for (deg, air) in [(30.0, true), (85.0, true), (30.0, false), (65.0, false)] {
            let (law, exact) = (ggx::<f32>(a, 1.49), ggx::<f64>(a, 1.49));
            let wi = incidence(deg, air);
            let f = fit(&law, |o| exact.pdf(dir(wi), dir(o)), wi, 100 + fits.len() as u128);
            fits.push((format!("f32 alpha {a} {deg} deg air {air}"), f));
        }
    }
    judge("GGX in f32", &fits);
}

#[test]
fn normals_samples_follow_their_density() {
    let mut fits = Vec::new();
    for (profile, delta, exponent) in [
        (Profile::Gauss, 0.01, 2.0),
        (Profile::Gauss, 0.2, 2.0),
        (Profile::Gauss, 0.3, 0.8),
        (Profile::Gauss, 0.5, 8.0),
        (Profile::Cauchy, 0.1, 2.0),
        (Profile::Cauchy, 0.3, 3.5),
        (Profile::Cauchy, 1.5, 3.0),
    ] {
        let law = normals::<f64>(profile, delta, exponent, 1.49);
        for (deg, air) in INCIDENCES {
            let wi = incidence(deg, air);
            let f = fit(&law, |o| law.pdf(dir(wi), dir(o)), wi, 200 + fits.len() as u128);
            fits.push((format!("{profile:?} {delta} {exponent} {deg} deg air {air}"), f));
        }
    }
    judge("Normals", &fits);
}

#[test]
fn opaque_samples_follow_their_density() {
    let mut fits = Vec::new();
    for (a, gain, lambert) in [(0.05, 0.6, 0.1), (0.4, 0.5, 0.05), (1.5, 0.9, 0.0), (0.2, 0.0, 0.3)]
    {
        for deg in [1.0, 50.0, 80.0, 88.5] {
            let (law, wi) =
                (OpaqueGgx::new(alpha(a), gain, lambert).unwrap(), incidence(deg, true));
            let f = fit(&law, |o| law.pdf(dir(wi), dir(o)), wi, 300 + fits.len() as u128);
            fits.push((format!("alpha {a} gain {gain} lambert {lambert} {deg} deg"), f));
        }
    }
    judge("OpaqueGgx", &fits);
}

/// The weight of a sample is what the density leaves to be explained.
#[test]
fn the_weight_of_a_sample_is_ars_over_pdf() {
    fn check(law: &impl Bsdf<f64>, wi: Vec3, random: &mut Random, case: &str) {
        for _ in 0..2000 {
            let Some(s) = law.sample(dir(wi), &mut || random.next()) else {
                continue;
            };
            let (ars, pdf) = (law.ars(dir(wi), s.wo), law.pdf(dir(wi), s.wo));
            // below this the facet is met too flat for a quotient to mean anything
            if pdf > 1e-8 {
                let error = (ars / pdf - s.weight).abs();
                assert!(error < 1e-9, "{case} {wi:?} {s:?}: {ars} {pdf} {error:e}");
            }
        }
    }
    let mut random = Random::new(9);
    for (deg, air) in INCIDENCES {
        let wi = incidence(deg, air);
        check(&ggx::<f64>(0.3, 1.49), wi, &mut random, "ggx");
        check(&normals::<f64>(Profile::Gauss, 0.3, 2.0, 1.49), wi, &mut random, "normals");
        check(&OpaqueGgx::new(alpha(0.3), 0.5, 0.1).unwrap(), wi, &mut random, "opaque");
    }
}

#[test]
fn the_test_has_power_a_width_off_by_5_percent_fails() {
    let each = sidak(tolerance::SIGNIFICANCE.allowed, 50);
    for (deg, air) in INCIDENCES {
        for a in [0.05, 0.3, 1.0] {
            let wi = incidence(deg, air);
            let (law, wrong) = (ggx::<f64>(a, 1.49), ggx::<f64>(1.05 * a, 1.49));
            let f = fit(&law, |o| wrong.pdf(dir(wi), dir(o)), wi, 400);
            assert!(f.p < each, "alpha {a} {deg} deg air {air}: {f:?}");
        }
    }
    let wi = incidence(30.0, true);
    let law = normals::<f64>(Profile::Gauss, 0.2, 2.0, 1.49);
    let wrong = normals::<f64>(Profile::Gauss, 0.21, 2.0, 1.49);
    let f = fit(&law, |o| wrong.pdf(dir(wi), dir(o)), wi, 401);
    assert!(f.p < each, "normals: {f:?}");
}

#[test]
fn samples_of_laws_side_by_side_follow_their_density() {
    let mut fits = Vec::new();
    let shares = MixShares { second: 0.3, specular: 0.0, lambert: 0.2 };
    let backing = Backing::Dielectric(ior(1.49));
    let law =
        Mix::<f64, _, _>::new(backing, ggx(0.05, 1.49), Some(ggx(0.5, 1.49)), shares).unwrap();
    for (deg, air) in INCIDENCES {
        let wi = incidence(deg, air);
        let f = fit(&law, |o| law.pdf(dir(wi), dir(o)), wi, 400 + fits.len() as u128);
        fits.push((format!("{deg} deg air {air}"), f));
    }
    judge("Mix", &fits);
}

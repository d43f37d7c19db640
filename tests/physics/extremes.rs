//! The edges of the domain: everything finite, nothing negative, no weight above 1, no panic.

use std::fmt::Debug;

use asperity_core::bsdf::{Backing, Bsdf, Lambert, Mix, MixShares, OpaqueGgx, Scatter, Smooth};
use asperity_core::direction::Direction;
use asperity_core::math::{Fast, Real};
use asperity_core::ndf::law::Profile;
use asperity_core::plate::{Plate, RoughSide};
use asperity_tests::oracle::Vec3;
use asperity_tests::tolerance;

use crate::common::{Random, alpha, dir, ggx, ior, normals};

const ALPHAS: [f64; 6] = [1e-6, 1e-4, 0.01, 0.3, 1.0, 10.0];
const INDICES: [f64; 10] =
    [0.1, 0.67, 0.9999, 1.0 - 1e-7, 1.0, 1.0 + 1e-7, 1.0 + 1e-15, 1.0001, 1.49, 10.0];
const LAWS: [(f64, f64); 10] = [
    (1e-6, 2.0),
    (1e-4, 0.5),
    (1e-4, 64.0),
    (0.1, 2.0),
    (0.3, 0.1),
    (0.3, 100.0),
    (std::f64::consts::FRAC_PI_2, 0.5),
    (std::f64::consts::FRAC_PI_2, 64.0),
    (10.0, 2.0),
    (10.0, 100.0),
];

/// Directions of both sides, from the normal to 1e-7 above the surface.
fn directions() -> Vec<Vec3> {
    let mut all = Vec::new();
    for z in [1.0, 0.9999995, 0.7, 0.05, 1e-4, 1e-7_f64] {
        for phi in [0.0, 0.4, std::f64::consts::PI] {
            let s = ((1.0 - z) * (1.0 + z)).sqrt();
            all.extend([1.0, -1.0].map(|up| [s * f64::cos(phi), s * f64::sin(phi), up * z]));
        }
    }
    all
}

/// The worst that was seen, in units of epsilon where it is rounding.
#[derive(Debug, Default)]
struct Worst {
    length: f64,
    weight: f64,
    reciprocity: f64,
    samples: u32,
    lost: u32,
}

impl Worst {
    fn show(&self, what: &str) {
        println!(
            "  {what:22} length {:5.1} eps, weight - 1 {:5.1} eps, reciprocity {:.1e}, {} samples, {} lost",
            self.length, self.weight, self.reciprocity, self.samples, self.lost
        );
    }
}

/// Evaluates and samples over all pairs of directions.
fn scour<T: Real>(
    law: &(impl Bsdf<T> + Debug),
    case: &str,
    random: &mut Random,
    worst: &mut Worst,
) {
    let all = directions();
    let value = |x: T| x.is_finite() && x >= T::ZERO;
    for &i in &all {
        let wi = dir::<T>(i);
        for &o in &all {
            let wo = dir::<T>(o);
            let (f, ars, pdf) = (law.eval(wi, wo), law.ars(wi, wo), law.pdf(wi, wo));
            assert!(value(f) && value(ars) && value(pdf), "{case} {wi:?} {wo:?}: {f} {ars} {pdf}");
        }
        sample_all(law, wi, case, random, worst);
    }
}

/// Samples with uniforms from the corners of [0, 1) and inside.
fn sample_all<T: Real>(
    law: &impl Scatter<T>,
    wi: Direction<T>,
    case: &str,
    random: &mut Random,
    worst: &mut Worst,
) {
    let epsilon = T::EPSILON.to_f64();
    let corners = [T::ZERO, T::HALF, T::ONE - T::EPSILON * T::HALF];
    for k in 0..40 {
        let mut n = 0;
        let s = law.sample(wi, &mut || {
            n += 1;
            // three corners in each of the first three uniforms, then random ones
            if k < 27 && n <= 3 { corners[k / 3_usize.pow(n - 1) % 3] } else { random.next() }
        });
        let Some(s) = s else {
            worst.lost += 1;
            continue;
        };
        let [x, y, z] = s.wo.xyz().map(Real::to_f64);
        let length = ((x * x + y * y + z * z).sqrt() - 1.0).abs() / epsilon;
        let over = (s.weight.to_f64() - 1.0) / epsilon;
        let text = format!("{case} {wi:?}: {s:?}");
        assert!(length < tolerance::UNIT.allowed, "{text} length {length}");
        assert!(s.weight >= T::ZERO && over < tolerance::WEIGHT.allowed, "{text} weight {over}");
        assert!(s.wo.side().is_some(), "{text}");
        worst.length = worst.length.max(length);
        worst.weight = worst.weight.max(over);
        worst.samples += 1;
    }
}

/// Reciprocity over all pairs, where both ways are seen.
fn reverse<T: Real>(law: &impl Bsdf<T>, n: f64, worst: &mut Worst) {
    let all = directions();
    let square = |w: Vec3| if w[2] > 0.0 { 1.0 } else { n * n };
    for &i in &all {
        for &o in &all {
            let there = law.eval(dir(i), dir(o)).to_f64() / square(o);
            let back = law.eval(dir(o), dir(i)).to_f64() / square(i);
            if there > 0.0 && back > 0.0 {
                worst.reciprocity = worst.reciprocity.max((there / back - 1.0).abs());
            }
        }
    }
}

fn ggx_at_the_edges<T: Real>(name: &str) {
    let mut random = Random::new(21);
    let mut worst = Worst::default();
    let mut tame = Worst::default();
    for a in ALPHAS {
        for n in INDICES {
            let law = ggx::<T>(a, n);
            scour(&law, &format!("ggx {name} alpha {a} n {n}"), &mut random, &mut worst);
            reverse(&law, law.eta.get().to_f64(), &mut worst);
            if a >= 0.01 && !(0.9..1.1).contains(&n) {
                reverse(&law, law.eta.get().to_f64(), &mut tame);
            }
        }
    }
    worst.show(&format!("ggx {name}"));
    println!(
        "    of which reciprocity for alpha >= 0.01, n outside 0.9 to 1.1: {:.1e}",
        tame.reciprocity
    );
    let allowed = tolerance::RECIPROCITY_CONDITIONING.allowed * T::EPSILON.to_f64() * 4.0 / 0.01;
    assert!(tame.reciprocity < allowed, "{name} {} {allowed}", tame.reciprocity);
}

#[test]
fn ggx_is_sound_at_the_edges_of_its_domain() {
    ggx_at_the_edges::<f64>("f64");
    ggx_at_the_edges::<f32>("f32");
    ggx_at_the_edges::<Fast<f64>>("fast f64");
    ggx_at_the_edges::<Fast<f32>>("fast f32");
}

fn normals_at_the_edges<T: Real>(name: &str) {
    let mut random = Random::new(22);
    let mut worst = Worst::default();
    for profile in [Profile::Gauss, Profile::Cauchy] {
        for (delta, exponent) in LAWS {
            for n in INDICES {
                let law = normals::<T>(profile, delta, exponent, n);
                let case = format!("{profile:?} {name} delta {delta} exponent {exponent} n {n}");
                scour(&law, &case, &mut random, &mut worst);
            }
        }
    }
    worst.show(&format!("normals {name}"));
}

#[test]
fn normals_are_sound_at_the_edges_of_their_domain() {
    normals_at_the_edges::<f64>("f64");
    normals_at_the_edges::<f32>("f32");
    normals_at_the_edges::<Fast<f64>>("fast f64");
    normals_at_the_edges::<Fast<f32>>("fast f32");
}

fn others_at_the_edges<T: Real>(name: &str) {
    let mut random = Random::new(23);
    let mut worst = Worst::default();
    for a in ALPHAS {
        for (gain, lambert) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.1), (0.0, 0.3), (1e-30, 1e-30)] {
            let (gain, lambert) = (T::from_f64(gain), T::from_f64(lambert));
            let law = OpaqueGgx::new(alpha(a), gain, lambert).unwrap();
            scour(&law, &format!("opaque {name} {law:?}"), &mut random, &mut worst);
            reverse(&law, 1.0, &mut worst);
        }
    }
    worst.show(&format!("opaque {name}"));
    let mut worst = Worst::default();
    for n in INDICES {
        for w in directions() {
            let law = Smooth { eta: ior::<T>(n) };
            sample_all(&law, dir(w), &format!("smooth {name} n {n}"), &mut random, &mut worst);
        }
    }
    worst.show(&format!("smooth {name}"));
}

#[test]
fn opaque_and_smooth_are_sound_at_the_edges_of_their_domain() {
    others_at_the_edges::<f64>("f64");
    others_at_the_edges::<f32>("f32");
    others_at_the_edges::<Fast<f64>>("fast f64");
    others_at_the_edges::<Fast<f32>>("fast f32");
}

fn mixes_at_the_edges<T: Real>(name: &str) {
    let mut random = Random::new(25);
    let mut worst = Worst::default();
    for n in INDICES {
        let backing = Backing::Dielectric(ior::<T>(n));
        let lambert = Lambert::new(backing);
        scour(&lambert, &format!("lambert {name} n {n}"), &mut random, &mut worst);
        reverse(&lambert, T::from_f64(n).to_f64(), &mut worst);
        for [a, b] in [[1e-6, 10.0], [0.01, 0.3], [1.0, 1e-4]] {
            for [second, specular, lambert] in
                [[0.3, 0.2, 0.1], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-30; 3]]
            {
                let [second, specular, lambert] = [second, specular, lambert].map(T::from_f64);
                let shares = MixShares { second, specular, lambert };
                let law = Mix::new(backing, ggx(a, n), Some(ggx(b, n)), shares).unwrap();
                let case = format!("mix {name} {a} {b} n {n} {shares:?}");
                scour(&law, &case, &mut random, &mut worst);
            }
        }
    }
    worst.show(&format!("mix {name}"));
}

#[test]
fn mixes_are_sound_at_the_edges_of_their_domain() {
    mixes_at_the_edges::<f64>("f64");
    mixes_at_the_edges::<f32>("f32");
    mixes_at_the_edges::<Fast<f64>>("fast f64");
    mixes_at_the_edges::<Fast<f32>>("fast f32");
}

/// How far f32 may be from f64 at the edges: shown, and bounded where the problem is well-conditioned.
#[test]
fn single_precision_stays_near_double_precision_at_the_edges() {
    let all = directions();
    println!(
        "extremes: worst relative deviation of f32 from f64, reflection, transmission (both > 1e-20)"
    );
    for a in ALPHAS {
        for n in [1.0001, 1.49, 10.0] {
            let (narrow, law) = (ggx::<f32>(a.max(1.001e-6), n), {
                ggx::<f64>(f64::from(a.max(1.001e-6) as f32), f64::from(n as f32))
            });
            let mut worst = [0.0_f64; 2];
            for &i in &all {
                for &o in &all {
                    let (i, o) = (i.map(|x| f64::from(x as f32)), o.map(|x| f64::from(x as f32)));
                    let got = f64::from(narrow.eval(dir(i), dir(o)));
                    let want = law.eval(dir(i), dir(o));
                    if got > 1e-20 && want > 1e-20 {
                        let k = usize::from(i[2] * o[2] < 0.0);
                        worst[k] = worst[k].max((got / want - 1.0).abs());
                    }
                }
            }
            println!("  alpha {a:8} n {n:6}: {:.1e} {:.1e}", worst[0], worst[1]);
            if a >= 0.01 && n > 1.1 {
                let ulps = 4.0 / a * f64::from(f32::EPSILON);
                let allowed = tolerance::F32.allowed + tolerance::F32_CONDITIONING.allowed * ulps;
                assert!(worst[0] < allowed, "alpha {a} n {n}: {worst:?}, allowed {allowed:e}");
            }
        }
    }
}

fn plate_at_the_edges<T: Real, S: Scatter<T> + Copy>(
    rough: S,
    n: f64,
    case: &str,
    allowed: f64,
    failures: &mut Vec<String>,
) -> f64 {
    let mut random = Random::new(24);
    let mut worst = 0.0_f64;
    for side in [RoughSide::Source, RoughSide::Detector] {
        for w in directions().into_iter().filter(|w| w[2] > 0.0) {
            let plate = Plate::new(rough, ior::<T>(n), side);
            for _ in 0..6 {
                let mut sum = 0.0;
                let out = plate.trace(dir(w), &mut || random.next(), &mut |wo, flux| {
                    let length = (wo.dot(wo).to_f64() - 1.0).abs() / T::EPSILON.to_f64();
                    assert!(length < 4.0 * tolerance::UNIT.allowed, "{case} {side:?} {w:?} {wo:?}");
                    assert!(flux.is_finite() && flux >= T::ZERO, "{case} {side:?} {w:?} {flux}");
                    sum += flux.to_f64();
                });
                let parts = [out.reflected, out.transmitted, out.lost].map(Real::to_f64);
                let off = (parts.iter().sum::<f64>() - 1.0).abs();
                worst = worst.max(off);
                if off >= allowed {
                    failures.push(format!("{case} {side:?} {w:?}: {out:?} {off:e}"));
                }
                assert!((sum - parts[0] - parts[1]).abs() < allowed, "{case} {w:?} {out:?}");
            }
        }
    }
    worst
}

#[test]
fn the_plate_keeps_its_books_at_the_edges() {
    let (mut wide, mut narrow) = (0.0_f64, 0.0_f64);
    let mut failures = Vec::new();
    let (books64, books32) = (tolerance::PLATE_F64.allowed, tolerance::PLATE_F32.allowed);
    for n in INDICES {
        for a in ALPHAS {
            let case = format!("plate alpha {a} n {n}");
            wide =
                wide.max(plate_at_the_edges::<f64, _>(ggx(a, n), n, &case, books64, &mut failures));
            narrow = narrow.max(plate_at_the_edges::<f32, _>(
                ggx(a, n),
                n,
                &case,
                books32,
                &mut failures,
            ));
        }
        for (delta, exponent) in [(1e-6, 2.0), (0.3, 0.1), (10.0, 100.0)] {
            let case = format!("plate normals {delta} {exponent} n {n}");
            let law = normals(Profile::Cauchy, delta, exponent, n);
            wide = wide.max(plate_at_the_edges::<f64, _>(law, n, &case, books64, &mut failures));
            let law = normals(Profile::Cauchy, delta, exponent, n);
            narrow =
                narrow.max(plate_at_the_edges::<f32, _>(law, n, &case, books32, &mut failures));
        }
    }
    println!("extremes: plate books close within {wide:.1e} in f64, {narrow:.1e} in f32");
    failures.dedup();
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

fn refraction<T: Real>(name: &str) {
    let epsilon = T::EPSILON.to_f64();
    let (mut worst, mut relative) = (0.0_f64, (0.0_f64, 0.0, 0.0));
    for n in INDICES {
        for k in 0..70 {
            let c = 10_f64.powf(-0.1 * f64::from(k));
            let w = dir::<T>([((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c]);
            let (c, eta) = (w.z().to_f64(), T::from_f64(n).to_f64());
            let exact = ((eta - 1.0) * (eta + 1.0) + c * c) / (eta * eta);
            let got =
                w.refract(Direction::normal(), T::from_f64(n)).map_or(0.0, |t| t.z().to_f64());
            let error = (got * got - exact.max(0.0)).abs();
            let case = format!("{name} n {n} cos {c:e}: cos^2 {:e}, exactly {exact:e}", got * got);
            let scale = epsilon * (1.0 + 1.0 / (eta * eta));
            assert!(error < tolerance::REFRACTED.allowed * scale, "{case}");
            worst = worst.max(error / scale);
            if exact > 0.0 && error / exact > relative.0 {
                relative = (error / exact, n, c);
            }
        }
    }
    let (r, n, c) = relative;
    println!(
        "  refraction {name}: cos^2 within {worst:.1} eps, relative {r:.1e} (n {n}, cos {c:.1e})"
    );
}

#[test]
fn a_refracted_direction_has_snells_cosine_to_rounding() {
    refraction::<f64>("f64");
    refraction::<f32>("f32");
}

/// Components that are no direction at all.
fn abuse<T: Real>(huge: f64, tiny: f64) {
    let mut random = Random::new(25);
    let values = [0.0, -0.0, tiny, -tiny, 1.0, -huge, huge, f64::INFINITY, f64::NAN];
    let mut all = Vec::new();
    for x in values {
        for y in [0.0, tiny, huge, f64::NAN] {
            all.extend(values.map(|z| dir::<T>([x, y, z])));
        }
    }
    let smith = ggx::<T>(0.3, 1.49);
    let facets = normals::<T>(Profile::Gauss, 0.3, 2.0, 1.49);
    let opaque = OpaqueGgx::new(alpha::<T>(0.3), T::HALF, T::from_f64(0.1)).unwrap();
    let plate = Plate::new(smith, ior(1.49), RoughSide::Detector);
    for &wi in &all {
        for &wo in &all {
            let _ = (smith.eval(wi, wo), smith.pdf(wi, wo), facets.ars(wi, wo));
            let _ = (facets.eval(wi, wo), opaque.eval(wi, wo), opaque.pdf(wi, wo));
            let _ = wi.refract(wo, T::from_f64(1.49));
        }
        let mut uniform = || random.next();
        let _ = (smith.sample(wi, &mut uniform), facets.sample(wi, &mut uniform));
        let _ = opaque.sample(wi, &mut uniform);
        let _ = plate.trace(wi, &mut uniform, &mut |_, _| ());
    }
}

#[test]
fn no_components_whatever_make_it_panic() {
    abuse::<f64>(1e300, 5e-324);
    abuse::<f32>(3e38, 1e-45);
}

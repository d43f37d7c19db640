//! Reciprocity in flux transport: `f(i,o) / n_o^2 = f(o,i) / n_i^2`.

use asperity_core::bsdf::{Bsdf, OpaqueGgx, Scatter};
use asperity_tests::oracle::{Vec3, combine, dot};
use asperity_tests::{count, tolerance};

use crate::common::{Random, alpha, dir, ggx, wide};

/// How many times one rounding of `h = n_i wi + n_o wo` is magnified in `f`.
///
/// `D` changes by `4 / (alpha |h|)` per unit of `h` across the normal at its steepest; the cosines at the
/// facet by `1 / |w.h|`, since the transmittance has them as factors.
fn magnification(a: f64, n: f64, wi: Vec3, wo: Vec3) -> f64 {
    let index = |w: Vec3| if w[2] > 0.0 { 1.0 } else { n };
    let h = combine(index(wi), wi, index(wo), wo);
    let across = h[0].hypot(h[1]);
    let length = dot(h, h).sqrt();
    let steepness = 4.0 * across / ((a * h[2]).powi(2) + across * across).max(1e-300);
    let facet = 1.0 / dot(wi, h).abs() + 1.0 / dot(wo, h).abs();
    steepness + 4.0 * a / length + 4.0 / length + facet
}

#[test]
fn light_takes_the_same_way_back() {
    let mut random = Random::new(6);
    let mut worst = [(0.0_f64, String::new()), (0.0, String::new()), (0.0, String::new())];
    for _ in 0..count(200_000) {
        let (a, n) = (random.log(1e-3, 5.0), 1.0 + random.log(1e-4, 3.0));
        let law = ggx::<f64>(a, n);
        let wi = random.direction();
        let wo = if random.next::<f64>() < 0.6 {
            match law.sample(dir(wi), &mut || random.next()) {
                Some(s) => wide(s.wo),
                None => continue,
            }
        } else {
            random.direction()
        };
        let square = |w: Vec3| if w[2] > 0.0 { 1.0 } else { n * n };
        let there = law.eval(dir(wi), dir(wo)) / square(wo);
        let back = law.eval(dir(wo), dir(wi)) / square(wi);
        let case = format!("alpha {a} n {n} wi {wi:?} wo {wo:?}: {there:e} {back:e}");
        let largest = there.max(back);
        if largest <= 0.0 {
            continue;
        }
        let error = (there - back).abs() / largest;
        let magnified = magnification(a, n, wi, wo);
        let rounding = tolerance::RECIPROCITY_CONDITIONING.allowed * f64::EPSILON * magnified;
        let kind = if wi[2] * wo[2] > 0.0 {
            0
        } else if rounding < tolerance::RECIPROCITY.allowed {
            1
        } else {
            2
        };
        assert!(error < tolerance::RECIPROCITY.allowed + rounding, "{case} {error:e} {rounding:e}");
        if error > worst[kind].0 {
            worst[kind] = (error, case);
        }
    }
    for (what, (error, case)) in
        ["reflection", "transmission", "transmission, ill-conditioned"].into_iter().zip(&worst)
    {
        println!("reciprocity, {what}: worst {error:.1e} ({case})");
    }
    assert!(worst[0].0 < tolerance::RECIPROCITY.allowed);
    assert!(worst[1].0 < 2.0 * tolerance::RECIPROCITY.allowed);
}

#[test]
fn an_opaque_surface_is_reciprocal() {
    let mut random = Random::new(7);
    for _ in 0..count(20_000) {
        let law = OpaqueGgx::new(alpha(random.log(1e-3, 5.0)), 0.6_f64, 0.05).unwrap();
        let up = |[x, y, z]: Vec3| [x, y, z.abs()];
        let (wi, wo) = (up(random.direction()), up(random.direction()));
        let (there, back) = (law.eval(dir(wi), dir(wo)), law.eval(dir(wo), dir(wi)));
        let error = (there / back - 1.0).abs();
        assert!(error < tolerance::RECIPROCITY.allowed, "{law:?} {wi:?} {wo:?}");
    }
}

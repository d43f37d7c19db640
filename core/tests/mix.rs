//! Laws side by side on one surface: figures of an independent quadrature, and what follows from the parts.
#![cfg(all(
    feature = "microfacet",
    feature = "tails",
    feature = "f32",
    feature = "air",
    feature = "dielectric",
    feature = "reflection",
    feature = "transmission"
))]
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "tests may fail, and use the platform's mathematics"
)]

use asperity_core::bsdf::tail::Shape;
use asperity_core::bsdf::{
    AllBounces, Backing, Bsdf, Ggx, Lambert, Lobe, Masking, Microfacet, Mix, MixShares, OpaqueGgx,
    Scatter, ShiftInvariant,
};
use asperity_core::direction::{Direction, Side};
use asperity_core::fresnel;
use asperity_core::ndf::ggx_facets::GgxFacets;
use asperity_core::quantity::{Alpha, RelativeIor};

const N: f64 = 1.49;

fn eta() -> RelativeIor<f64> {
    RelativeIor::new(N).unwrap()
}

fn alpha(a: f64) -> Alpha<f64> {
    Alpha::new(a).unwrap()
}

fn ggx(a: f64) -> Ggx<f64> {
    Ggx::new(alpha(a), eta())
}

fn of<A, B>(first: A, second: B, shares: [f64; 3]) -> Mix<f64, A, B> {
    let [second_share, specular, lambert] = shares;
    let shares = MixShares { second: second_share, specular, lambert };
    Mix::new(Backing::Dielectric(eta()), first, Some(second), shares).unwrap()
}

fn incidence(deg: f64, air: bool) -> Direction<f64> {
    let (s, c) = deg.to_radians().sin_cos();
    Direction::from_unit(-s, 0.0, if air { c } else { -c })
}

/// Reflected and transmitted flux over a Fibonacci lattice.
fn fluxes(law: &impl Bsdf<f64>, wi: Direction<f64>) -> [f64; 2] {
    const POINTS: u32 = 196_418;
    let n = f64::from(POINTS);
    [Lobe::Reflection, Lobe::Transmission].map(|lobe| {
        let weight = |k: u32| {
            let around = (u64::from(k) * 121_393 % u64::from(POINTS)) as f64 / n;
            let u = [around, (f64::from(k) + 0.5) / n];
            law.sample_lobe(wi, lobe, u).map_or(0.0, |ray| ray.weight)
        };
        (0..POINTS).map(weight).sum::<f64>() / n
    })
}

/// Side, incidence, and R1, T1 with correlated and with separable masking, of 0.7 GGX 0.1 and 0.3 GGX 0.4 side by side.
const TWO_LOBES: [(bool, f64, [f64; 4]); 8] = [
    (true, 0.0, [0.036184, 0.956898, 0.036184, 0.956898]),
    (true, 30.0, [0.038110, 0.951680, 0.038100, 0.951702]),
    (true, 60.0, [0.074062, 0.895148, 0.073836, 0.895986]),
    (true, 75.0, [0.160071, 0.768009, 0.158512, 0.774053]),
    (false, 0.0, [0.042448, 0.899448, 0.042448, 0.899448]),
    (false, 30.0, [0.121172, 0.807102, 0.121055, 0.807166]),
    (false, 60.0, [0.815462, 0.070591, 0.813552, 0.071677]),
    (false, 75.0, [0.820943, 0.026816, 0.813593, 0.029508]),
];

#[test]
fn two_lobes_have_the_totals_of_an_independent_quadrature() {
    let separable = of(ggx(0.1), ggx(0.4), [0.3, 0.0, 0.0]);
    let facets =
        |a| Microfacet::new(GgxFacets::new(alpha(a)), eta()).with_masking(Masking::Correlated);
    let correlated = of(facets(0.1), facets(0.4), [0.3, 0.0, 0.0]);
    for (air, deg, [r_corr, t_corr, r_sep, t_sep]) in TWO_LOBES {
        let wi = incidence(deg, air);
        let [r, t] = fluxes(&separable, wi);
        assert!((r - r_sep).abs() < 5e-5 && (t - t_sep).abs() < 5e-5, "{air} {deg}: {r} {t}");
        let [r, t] = fluxes(&correlated, wi);
        assert!((r - r_corr).abs() < 5e-5 && (t - t_corr).abs() < 5e-5, "{air} {deg}: {r} {t}");
    }
}

#[test]
fn values_are_the_sum_of_the_parts_and_reciprocal() {
    let (a, b) = (ggx(0.1), ggx(0.4));
    let law = of(a, b, [0.3, 0.2, 0.1]);
    let lambert = Lambert::new(Backing::Dielectric(eta()));
    let index2 = |w: Direction<f64>| if w.z() > 0.0 { 1.0 } else { N * N };
    for k in 0..400 {
        let angle = |m: i32| f64::from(k * m % 400) / 400.0;
        let wi = Direction::from_angles(3.1 * angle(7), 6.0 * angle(3));
        let wo = Direction::from_angles(3.1 * angle(11), 6.0 * angle(17));
        let want = 0.4 * a.eval(wi, wo) + 0.3 * b.eval(wi, wo) + 0.1 * lambert.eval(wi, wo);
        assert!((law.eval(wi, wo) - want).abs() <= 1e-14 * want);
        let (there, back) = (law.eval(wi, wo) / index2(wo), law.eval(wo, wi) / index2(wi));
        assert!((there - back).abs() <= 1e-9 * there, "{wi:?} {wo:?}: {there} {back}");
    }
}

#[test]
fn nothing_is_lost_where_the_parts_lose_nothing() {
    let all = |a| AllBounces::new(ggx(a));
    let law = of(all(0.1), all(0.4), [0.3, 0.2, 0.1]);
    let lambert = Lambert::new(Backing::Dielectric(eta()));
    for (air, deg) in [(true, 0.0), (true, 70.0), (false, 20.0), (false, 60.0)] {
        let wi = incidence(deg, air);
        let [r, t] = fluxes(&law, wi);
        assert!((r + t - 1.0).abs() < 2e-3, "{air} {deg}: {r} {t}");
        let [r, t] = fluxes(&lambert, wi);
        let side = wi.side().unwrap();
        assert!((r - lambert.flux(side, Lobe::Reflection)).abs() < 1e-9);
        assert!((r + t - 1.0).abs() < 1e-9, "{air} {deg}: {r} {t}");
        // what keeps its direction is Fresnel's
        let smooth = fresnel::dielectric(wi.z().abs(), if air { N } else { 1.0 / N });
        let kept = law.coherent_flux(wi);
        assert!((kept.reflected - 0.2 * smooth.reflected).abs() < 1e-15);
        assert!((kept.transmitted - 0.2 * smooth.transmitted).abs() < 1e-15);
    }
}

#[test]
fn a_furnace_stays_as_bright_as_it_was() {
    // light of the same radiance over n^2 from all directions of both sides: what leaves in any direction has it too
    let lambert = Lambert::new(Backing::Dielectric(eta()));
    for wo in [incidence(0.0, true), incidence(50.0, true), incidence(80.0, false)] {
        let there = lambert
            .flux(Side::Air, if wo.z() > 0.0 { Lobe::Reflection } else { Lobe::Transmission });
        let below = if wo.z() > 0.0 { Lobe::Transmission } else { Lobe::Reflection };
        let index2 = if wo.z() > 0.0 { 1.0 } else { N * N };
        let sum = there + N * N * lambert.flux(Side::Dielectric, below);
        assert!((sum / index2 - 1.0).abs() < 1e-12, "{wo:?}: {sum}");
    }
}

/// Uniforms that repeat.
fn uniforms() -> impl FnMut() -> f64 {
    let mut word = 1_u64;
    move || {
        word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (word >> 11) as f64 / 9_007_199_254_740_992.0
    }
}

#[test]
fn samples_have_the_weights_of_their_density_and_the_fluxes_of_the_lobes() {
    let mut random = uniforms();
    let law = of(ggx(0.1), ggx(0.4), [0.3, 0.2, 0.15]);
    for (air, deg) in [(true, 20.0), (true, 75.0), (false, 30.0), (false, 70.0)] {
        let wi = incidence(deg, air);
        let [x, y, z] = wi.xyz();
        let mirror = Direction::from_unit(-x, -y, z);
        let count = 40_000_u32;
        let (mut sums, mut mirrored) = ([0.0; 2], 0.0);
        for _ in 0..count {
            let Some(ray) = law.sample(wi, &mut random) else { continue };
            let reflected = (ray.wo.z() > 0.0) == air;
            sums[usize::from(!reflected)] += ray.weight / f64::from(count);
            if ray.wo == mirror {
                mirrored += ray.weight / f64::from(count);
            } else if (ray.weight - 1.0).abs() > 1e-12 {
                let weight = law.ars(wi, ray.wo) / law.pdf(wi, ray.wo);
                assert!((ray.weight - weight).abs() < 1e-12, "{ray:?} {weight}");
            }
        }
        let error = 5.0 * (0.25 / f64::from(count)).sqrt();
        let [r, t] = fluxes(&law, wi);
        assert!(
            (sums[0] - r).abs() < error && (sums[1] - t).abs() < error,
            "{air} {deg}: {sums:?} {r} {t}"
        );
        let kept = law.coherent_flux(wi).reflected;
        assert!((mirrored - kept).abs() < error, "{air} {deg}: {mirrored} {kept}");
    }
}

#[test]
fn scatter_about_the_specular_direction_adds_its_levels() {
    // T1 = 0.2 and T2 = 0.05 of levels 1: shares 0.8 and 0.2 of laws whose levels are over these
    let shape = |a: f64, w: f64| Shape::SuperGauss { a, w, p: 2.0 };
    let law = |a, w| {
        ShiftInvariant::new(shape(a, w), Lobe::Transmission, RelativeIor::new(1.0).unwrap(), None)
    };
    let total = |a, w| law(a, w).unwrap().scattered(Direction::normal());
    let (a, b) = ([4.0, 0.1], [0.1, 0.3]);
    let (ta, tb) = (total(a[0], a[1]), total(b[0], b[1]));
    let share = tb / (ta + tb);
    let parts = [law(a[0] / (1.0 - share), a[1]).unwrap(), law(b[0] / share, b[1]).unwrap()];
    let shares = MixShares { second: share, specular: 0.0, lambert: 0.0 };
    let mix = Mix::new(Backing::Air(Lobe::Transmission), parts[0], Some(parts[1]), shares).unwrap();
    let (wi, wo) = (incidence(20.0, true), incidence(150.0, true));
    let sum = law(a[0], a[1]).unwrap().eval(wi, wo) + law(b[0], b[1]).unwrap().eval(wi, wo);
    assert!((mix.eval(wi, wo) / sum - 1.0).abs() < 1e-12);
    let kept = mix.coherent_flux(Direction::normal());
    assert!((kept.transmitted - (1.0 - ta - tb)).abs() < 1e-12 && kept.reflected.abs() < 1e-15);
}

#[test]
fn other_backings_send_light_where_they_can() {
    let shares = MixShares { second: 0.0, specular: 0.3, lambert: 0.2 };
    let metal = OpaqueGgx::new(alpha(0.2), 0.5, 0.0).unwrap();
    let metal: Mix<f64, _, OpaqueGgx<f64>> =
        Mix::new(Backing::Opaque, metal, None, shares).unwrap();
    let wi = incidence(30.0, true);
    assert!((metal.coherent_flux(wi).reflected - 0.3).abs() < 1e-15);
    assert!(metal.eval(wi, incidence(150.0, true)).abs() <= 0.0);
    assert!(metal.eval(wi, incidence(-10.0, true)) >= 0.2 / std::f64::consts::PI);
    let below = wi.opposite();
    assert!(metal.coherent_flux(below).reflected.abs() <= 0.0);
    assert!(metal.sample(below, &mut uniforms()).is_none());
}

#[test]
fn shares_that_are_none_are_refused() {
    let made = |second: Option<Ggx<f64>>, shares: [f64; 3]| {
        let [s, specular, lambert] = shares;
        let shares = MixShares { second: s, specular, lambert };
        Mix::new(Backing::Dielectric(eta()), ggx(0.1), second, shares).is_some()
    };
    assert!(made(None, [0.0; 3]) && made(Some(ggx(0.3)), [0.5, 0.25, 0.25]));
    for shares in
        [[0.6, 0.3, 0.2], [-0.1, 0.0, 0.0], [0.0, f64::NAN, 0.0], [0.0, 0.0, f64::INFINITY]]
    {
        assert!(!made(Some(ggx(0.3)), shares), "{shares:?}");
    }
    assert!(!made(None, [0.1, 0.0, 0.0]));
}

#[test]
fn single_precision_is_the_same_law() {
    let law = of(ggx(0.1), ggx(0.4), [0.3, 0.2, 0.1]);
    let single: Mix<f32, _, _> = law.map(Ggx::cast::<f32>, Ggx::cast::<f32>);
    for k in 0..200 {
        let angle = |m: i32| f64::from(k * m % 200) / 200.0;
        let wi = Direction::from_angles(3.1 * angle(7), 6.0 * angle(3));
        let wo = Direction::from_angles(3.1 * angle(11), 6.0 * angle(17));
        let narrow = |w: Direction<f64>| {
            let [x, y, z] = w.xyz();
            Direction::from_unit(x as f32, y as f32, z as f32)
        };
        let (want, got) = (law.eval(wi, wo), f64::from(single.eval(narrow(wi), narrow(wo))));
        assert!((got - want).abs() <= 1e-4 * want + 1e-12, "{got} {want}");
    }
    assert!((f64::from(single.slope()) - 0.1).abs() < 1e-7);
}

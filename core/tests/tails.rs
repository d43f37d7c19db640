//! Scatter about the specular direction against figures of independent programs, its draws, and its edges.
#![cfg(all(feature = "tails", feature = "f32"))]
#![cfg(all(
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

use asperity_core::bsdf::tail::{Shape, ShapeError};
use asperity_core::bsdf::{Bsdf, Lobe, Scatter, ShiftInvariant};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::quantity::RelativeIor;

const ABG: Shape<f64> = Shape::Abg { a: 0.0025, b: 0.001, g: 1.8 };
const ABG_2: Shape<f64> = Shape::Abg { a: 0.01, b: 0.0001, g: 2.0 };
const HARVEY: Shape<f64> = Shape::Harvey { b0: 0.1, l: 0.01, s: -1.5, m: 2.0 };
const HARVEY_2: Shape<f64> = Shape::Harvey { b0: 5.0, l: 0.002, s: -2.0, m: 2.0 };
const GAUSS: Shape<f64> = Shape::SuperGauss { a: 31.830_988_618_379_067, w: 0.1, p: 2.0 };

fn mirror() -> Shape<f64> {
    Shape::k_correlation([0.01, 362.0, 2.5], 0.6328, 2.0)
}

fn sheet(shape: Shape<f64>, lobe: Lobe) -> ShiftInvariant<f64> {
    ShiftInvariant::new(shape, lobe, RelativeIor::new(1.0).unwrap(), None).unwrap()
}

fn at(deg: f64) -> Direction<f64> {
    Direction::from_angles(deg.to_radians(), 0.4)
}

#[test]
fn values_are_those_of_independent_programs() {
    // distance from the specular direction, scatter in 1/sr; light along the normal
    let far = Shape::k_correlation([0.0003, 20.0, 3.0], 0.55, 0.49);
    for (shape, rows) in [
        (ABG, [(0.0, 2.5), (0.005, 2.331_795_913), (0.5, 0.008_675_296_496)]),
        (ABG_2, [(0.0001, 99.990_001), (0.03, 10.0), (1.0, 0.009_999_000_1)]),
        (HARVEY, [(0.001, 0.099_256_502_9), (0.3, 0.000_608_073_961_5), (1.0, 9.999_250_066e-5)]),
        (GAUSS, [(0.03, 29.091_333_16), (0.3, 0.003_928_256_069), (0.5, 4.420_669_831e-10)]),
        (mirror(), [(0.001, 6.912_916_49), (0.05, 0.002_244_485_98), (0.9, 7.137_022_65e-7)]),
        (far, [(0.0, 0.031_075_805_4), (0.1, 0.000_576_430_22), (0.6, 2.386_105_63e-6)]),
    ] {
        for (x, wanted) in rows {
            let wo = Direction::from_unit(x, 0.0, f64::sqrt(1.0 - x * x));
            if wo.z() <= 0.0 {
                continue;
            }
            for lobe in [Lobe::Reflection, Lobe::Transmission] {
                let wo = if lobe == Lobe::Reflection { wo } else { wo.turned_over() };
                let got = sheet(shape, lobe).eval(Direction::normal(), wo);
                assert!((got / wanted - 1.0).abs() < 1e-8, "{shape:?} {x}: {got} {wanted}");
            }
        }
    }
}

#[test]
fn total_scatter_is_that_of_independent_quadrature() {
    for (shape, rows) in [
        (ABG, [0.041_343_693_9, 0.039_357_540_4, 0.032_576_711_8, 0.023_885_100_7]),
        (ABG_2, [0.289_354_518, 0.280_319_162, 0.245_849_82, 0.182_351_869]),
        (HARVEY, [0.001_131_004_77, 0.001_066_509_54, 0.000_873_888_377, 0.000_678_259_066]),
        (HARVEY_2, [0.000_780_950_937, 0.000_762_875_535, 0.000_693_851_263, 0.000_561_222_863]),
        (GAUSS, [1.0, 1.0, 0.968_322_5, 0.571_107_309]),
    ] {
        for (deg, wanted) in [0.0, 30.0, 60.0, 80.0].into_iter().zip(rows) {
            let got = sheet(shape, Lobe::Transmission).scattered(at(deg));
            assert!(
                (got - wanted).abs() < 2e-8 * wanted.max(0.02),
                "{shape:?} {deg}: {got} {wanted}"
            );
        }
    }
    let got = sheet(mirror(), Lobe::Reflection).scattered(Direction::normal());
    assert!((got / 0.000_359_220_413 - 1.0).abs() < 1e-8, "{got}");
}

#[test]
fn the_flux_over_the_sphere_is_the_total_scatter_also_between_two_media() {
    let eta = RelativeIor::new(1.49).unwrap();
    let slight = Shape::KCorrelation { b0: 0.3, l: 0.4, s: -2.0 };
    for shape in [Shape::Abg { a: 0.02, b: 0.05, g: 2.5 }, slight] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            let law = ShiftInvariant::new(shape, lobe, eta, None).unwrap();
            for deg in [0.0, 40.0, 85.0, 110.0, 150.0] {
                let wi = at(deg);
                let n = 400;
                let mut sum = 0.0;
                for i in 0..n {
                    // cosines along -1 to 1, spaced so that the kink at the horizon does no harm
                    let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                    let sin = f64::sqrt(1.0 - z * z);
                    for k in 0..n {
                        let phi = core::f64::consts::TAU * f64::from(k) / f64::from(n);
                        sum +=
                            law.ars(wi, Direction::from_unit(sin * phi.cos(), sin * phi.sin(), z));
                    }
                }
                let flux = sum * 4.0 * core::f64::consts::PI / f64::from(n * n);
                let total = law.scattered(wi);
                assert!((flux - total).abs() < 2e-4, "{shape:?} {lobe:?} {deg}: {flux} {total}");
                let kept = law.coherent_flux(wi);
                let all = total + kept.reflected + kept.transmitted;
                assert!((all - 1.0).abs() < 1e-12, "{lobe:?} {deg}: {all}");
            }
        }
    }
}

#[test]
fn more_light_than_there_is_and_values_outside_their_domains_are_refused() {
    let air = RelativeIor::new(1.0).unwrap();
    let new = |shape, specular| ShiftInvariant::new(shape, Lobe::Reflection, air, specular);
    let bright = Shape::Abg { a: 1.0, b: 0.01, g: 2.0 };
    let Err(ShapeError::TooMuch { scattered }) = new(bright, None) else { panic!("accepted") };
    assert!((scattered - core::f64::consts::PI * 101.0_f64.ln()).abs() < 1e-7, "{scattered}");
    assert!(matches!(new(GAUSS, Some(0.1)), Err(ShapeError::TooMuch { .. })));
    for bad in [
        Shape::Abg { a: 0.1, b: 0.0, g: 2.0 },
        Shape::Abg { a: f64::NAN, b: 0.1, g: 2.0 },
        Shape::Harvey { b0: 0.1, l: 0.1, s: 0.5, m: 2.0 },
        Shape::Harvey { b0: 0.1, l: 0.1, s: -0.5, m: 0.0 },
        Shape::SuperGauss { a: 0.1, w: 0.1, p: 0.01 },
    ] {
        assert!(matches!(new(bad, None), Err(ShapeError::OutOfDomain { .. })), "{bad:?}");
    }
}

/// A quick generator: 53 bits of a Weyl sequence, mixed.
fn uniforms() -> impl FnMut() -> f64 {
    let mut state = 0_u64;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        f64::from_bits_uniform(z ^ (z >> 31))
    }
}

#[test]
fn draws_follow_the_density_and_the_rest_keeps_its_direction() {
    let flat = Shape::SuperGauss { a: 0.9, w: 0.5, p: 12.0 };
    let slight = Shape::KCorrelation { b0: 0.5, l: 0.3, s: -2.5 };
    let eta = RelativeIor::new(1.49).unwrap();
    let air = RelativeIor::new(1.0).unwrap();
    let mut uniform = uniforms();
    for (shape, eta, deg) in [
        (flat, air, 50.0),
        (slight, air, 70.0),
        (ABG_2, eta, 30.0),
        (Shape::Abg { a: 0.03, b: 0.05, g: 2.0 }, eta, 130.0),
    ] {
        let law = ShiftInvariant::new(shape, Lobe::Transmission, eta, None).unwrap();
        let wi = at(deg);
        let count = 30_000_u32;
        // bins of the azimuth about the normal (8) and of the square of the sine (8)
        let bin = |w: Direction<f64>| {
            let phi = (w.y().atan2(w.x()) / core::f64::consts::TAU).rem_euclid(1.0);
            let s2 = (w.x() * w.x() + w.y() * w.y()).min(0.999_999);
            ((s2 * 8.0) as usize) * 8 + ((phi * 8.0) as usize).min(7)
        };
        let mut found = [0.0; 64];
        let mut kept = 0_u32;
        let specular = law.coherent_flux(wi);
        for _ in 0..count {
            let ray = law.sample(wi, &mut uniform).unwrap();
            assert!((ray.weight - 1.0).abs() < 1e-15);
            let dx = wi.x() + ray.wo.x();
            let direct = law.pdf(wi, ray.wo);
            let keeps = if eta.is_matched() {
                dx.abs() < 1e-12
            } else {
                (ray.wo.z() > 0.0) == (wi.z() > 0.0)
                    || (ray.wo.x().hypot(ray.wo.y())
                        - wi.x().hypot(wi.y()) * if deg < 90.0 { 1.0 / 1.49 } else { 1.49 })
                    .abs()
                        < 1e-12
            };
            if keeps {
                kept += 1;
            } else {
                assert!(direct > 0.0);
                found[bin(ray.wo)] += 1.0;
            }
        }
        let share = f64::from(kept) / f64::from(count);
        let wanted = specular.reflected + specular.transmitted;
        let se = f64::sqrt(wanted * (1.0 - wanted) / f64::from(count));
        assert!((share - wanted).abs() < 4.0 * se + 1e-9, "{shape:?}: {share} {wanted}");
        let mut expected = [0.0; 64];
        let n = 1200;
        let below = if wi.z() > 0.0 { -1.0 } else { 1.0 };
        for i in 0..n {
            let s2 = (f64::from(i) + 0.5) / f64::from(n);
            for k in 0..n {
                let phi = core::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(n);
                let sin = s2.sqrt();
                let wo = Direction::from_unit(
                    sin * phi.cos(),
                    sin * phi.sin(),
                    below * (1.0 - s2).sqrt(),
                );
                // f cos d omega = f d(s2) d(phi) / 2
                expected[bin(wo)] += law.eval(wi, wo) * core::f64::consts::PI;
            }
        }
        let scale = f64::from(count) / f64::from(n * n);
        let (mut chi2, mut bins) = (0.0, 0);
        for (found, expected) in found.iter().zip(expected.map(|e| e * scale)) {
            if expected > 20.0 {
                chi2 += (found - expected).powi(2) / expected;
                bins += 1;
            }
        }
        let dof = f64::from(bins);
        assert!(bins > 8 && chi2 < dof + 5.0 * (2.0 * dof).sqrt(), "{shape:?}: {chi2} of {bins}");
    }
}

#[test]
fn one_draw_into_the_lobe_has_its_flux_on_average() {
    // many in the first uniform, at whose end the specular light is
    let (many, few) = (2000, 8);
    for shape in [ABG_2, Shape::KCorrelation { b0: 0.5, l: 0.3, s: -2.5 }] {
        let law = sheet(shape, Lobe::Reflection);
        let wi = at(65.0);
        let (mut all, mut off) = (0.0, 0.0);
        for k in 0..many * few {
            let u = [f64::from(k / few) / f64::from(many), f64::from(k % few) / f64::from(few)];
            let u = [u[0] + 0.5 / f64::from(many), u[1] + 0.5 / f64::from(few)];
            let ray = law.sample_lobe(wi, Lobe::Reflection, u).unwrap();
            all += ray.weight;
            if (ray.wo.x() + wi.x()).hypot(ray.wo.y() + wi.y()) > 1e-12 {
                off += ray.weight;
            }
            assert!(law.sample_lobe(wi, Lobe::Transmission, u).is_none());
        }
        let [all, off] = [all, off].map(|sum| sum / f64::from(many * few));
        // the ends of both parts fall between two draws
        assert!((all - 1.0).abs() < 1e-3, "{shape:?}: {all}");
        assert!((off - law.scattered(wi)).abs() < 1e-3, "{shape:?}: {off}");
    }
}

fn edges<T: Real>(shape: Shape<f64>, lobe: Lobe, eta: f64) {
    let eta = RelativeIor::new(eta).unwrap();
    let law = ShiftInvariant::new(shape, lobe, eta, None).unwrap();
    let narrow = law.cast::<T>();
    let good = |x: T| x.is_finite() && x >= T::ZERO;
    let directions: Vec<[f64; 3]> = [1.0, 0.6, 0.02, 1e-7, 0.0_f64]
        .into_iter()
        .flat_map(|z| {
            let s = ((1.0 - z) * (1.0 + z)).sqrt();
            [[s, 0.0, z], [-s, 0.0, -z], [0.6 * s, -0.8 * s, z], [0.0, s, -z]]
        })
        .chain([[f64::NAN, 0.0, 0.5], [0.0, 0.0, f64::NAN], [0.0, 0.0, -0.0]])
        .collect();
    let to =
        |w: [f64; 3]| Direction::from_unit(T::from_f64(w[0]), T::from_f64(w[1]), T::from_f64(w[2]));
    for &i in &directions {
        for &o in &directions {
            let [there, back] = [narrow.eval(to(i), to(o)), narrow.eval(to(o), to(i))];
            assert!(good(there) && good(back), "{shape:?} {i:?} {o:?} {}", there.to_f64());
            let n2 = |w: [f64; 3]| if w[2] > 0.0 { 1.0 } else { eta.get() * eta.get() };
            let [a, b] = [there.to_f64() / n2(o), back.to_f64() / n2(i)];
            assert!((a - b).abs() <= 1e-5 * a.max(b) + 1e-30, "{shape:?} {i:?} {o:?} {a} {b}");
        }
        for corner in [0.0, 0.5, 1.0 - 6e-8] {
            if let Some(ray) = narrow.sample(to(i), &mut || T::from_f64(corner)) {
                let size = ray.wo.dot(ray.wo).to_f64();
                let broken = i.iter().any(|x| x.is_nan());
                assert!(broken || (size - 1.0).abs() < 1e-5, "{shape:?} {i:?} {size}");
            }
            let _ = narrow.sample_lobe(to(i), lobe, [T::from_f64(corner); 2]);
        }
    }
}

#[test]
fn values_are_finite_and_reciprocal_up_to_the_edges_in_both_precisions() {
    for shape in [
        ABG,
        Shape::Abg { a: 1e-7, b: 1e-12, g: 3.0 },
        Shape::Abg { a: 0.1, b: 0.1, g: 0.0 },
        HARVEY,
        Shape::Harvey { b0: 1e-5, l: 1e-9, s: -50.0, m: 2.0 },
        GAUSS,
        Shape::Harvey { b0: 0.1, l: 0.1, s: -20.0, m: 40.0 },
        Shape::SuperGauss { a: 0.3, w: 0.5, p: 200.0 },
        Shape::SuperGauss { a: 1e-3, w: 1e-3, p: 0.1 },
        mirror(),
    ] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            for eta in [1.0, 1.49, 0.7] {
                let dim = match shape {
                    Shape::SuperGauss { a, w, p } => Shape::SuperGauss { a: 0.3 * a, w, p },
                    other => other,
                };
                edges::<f64>(dim, lobe, eta);
                edges::<f32>(dim, lobe, eta);
            }
        }
    }
}

//! Densities of facets against figures of independent programs, and the boundary made of them at the edges.
#![cfg(all(feature = "microfacet", feature = "f32"))]
#![cfg(all(
    feature = "air",
    feature = "dielectric",
    feature = "reflection",
    feature = "transmission"
))]
#![allow(
    clippy::unwrap_used,
    clippy::large_stack_arrays,
    clippy::large_types_passed_by_value,
    clippy::disallowed_methods,
    reason = "tests may fail, have room, and use the platform's mathematics"
)]

use asperity_core::bsdf::{Bsdf, Lobe, Masking, Microfacet, Scatter};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::ndf::any::AnyDensity;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::density::Density;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::slopes::Slopes;
use asperity_core::ndf::smith::SmithNormals;
use asperity_core::ndf::stretched::Stretched;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::{Alpha, RelativeIor};

fn student(sigma: f64, gamma: f64) -> AnyDensity<f64> {
    AnyDensity::Student(Student::new(Alpha::new(sigma).unwrap(), gamma).unwrap())
}

fn beckmann(alpha: f64) -> AnyDensity<f64> {
    AnyDensity::Beckmann(Beckmann::new(Alpha::new(alpha).unwrap()))
}

fn smith(profile: Profile, delta_deg: f64, n: f64) -> AnyDensity<f64> {
    let law = Law::new(profile, delta_deg.to_radians(), n, 0.0).unwrap();
    AnyDensity::SmithNormals(SmithNormals::new(law))
}

fn stretched(sigma: [f64; 2], gamma: f64) -> AnyDensity<f64> {
    let sigma = sigma.map(|s| Alpha::new(s).unwrap());
    AnyDensity::StretchedStudent(Stretched::student(sigma, gamma, 0.6).unwrap())
}

fn gaussian(alpha: [f64; 2]) -> AnyDensity<f64> {
    let alpha = alpha.map(|a| Alpha::new(a).unwrap());
    AnyDensity::StretchedBeckmann(Stretched::beckmann(alpha, -2.0).unwrap())
}

fn slopes(width: f64, knots: [f64; 8]) -> AnyDensity<f64> {
    AnyDensity::Slopes(Slopes::new(Alpha::new(width).unwrap(), knots).unwrap())
}

fn boundary(density: AnyDensity<f64>) -> Microfacet<f64, AnyDensity<f64>> {
    Microfacet::new(density, RelativeIor::new(1.49).unwrap())
}

#[test]
fn densities_and_masking_are_those_of_independent_quadrature() {
    // polar angle in degrees, D in 1/sr, G1; the figures of Student-t and of the angular laws are by SciPy
    for (density, rows) in [
        (
            student(0.2, 3.0),
            [(20.0, 0.544_750_223, 0.999_993_054), (75.0, 0.000_330_314_678, 0.965_767_565)],
        ),
        (
            student(0.1, 1.7),
            [(10.0, 1.899_804_74, 0.998_057_196), (85.0, 0.030_264_204_6, 0.613_143_229)],
        ),
        (
            smith(Profile::Gauss, 10.0, 2.0),
            [(10.0, 3.299_783_09, 1.0), (70.0, 1.245_712_51e-10, 0.995_489_379_3)],
        ),
    ] {
        for (deg, d, g1) in rows {
            let w = Direction::from_angles(f64::to_radians(deg), 0.3);
            let [x, y, z] = w.xyz();
            let got = density.d(x * x + y * y, z * z, || [[x * x + y * y, 0.0], [z * z, 0.0]]);
            assert!((got / d - 1.0).abs() < 1e-8, "{density:?} {deg}: {got}");
            assert!((density.g1(w) - g1).abs() < 2e-8, "{density:?} {deg}: {}", density.g1(w));
        }
    }
    let cauchy = smith(Profile::Cauchy, 15.0, 2.0);
    for (deg, g1) in [(30.0, 0.984_913_696_2), (60.0, 0.881_321_981_7), (89.0, 0.074_495_851_8)] {
        let got = cauchy.g1(Direction::from_angles(f64::to_radians(deg), 0.0));
        assert!((got - g1).abs() < 1e-7, "{deg}: {got}");
    }
}

#[test]
fn a_large_exponent_of_student_approaches_beckmann() {
    let (near, limit) = (student(0.3, 500.0), beckmann(0.3));
    for deg in [5.0, 30.0, 70.0, 85.0, 89.0] {
        let w = Direction::from_angles(f64::to_radians(deg), 0.0);
        assert!((near.g1(w) - limit.g1(w)).abs() < 2e-3, "{deg}");
    }
}

/// Fluxes of both lobes by midpoints over the uniforms.
fn fluxes(law: &Microfacet<f64, AnyDensity<f64>>, wi: Direction<f64>) -> [f64; 2] {
    let n = 120;
    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
    [Lobe::Reflection, Lobe::Transmission].map(|lobe| {
        let rays = (0..n * n).filter_map(|k| law.sample_lobe(wi, lobe, [at(k / n), at(k % n)]));
        rays.map(|ray| ray.weight).sum::<f64>() / f64::from(n * n)
    })
}

#[test]
fn single_scattering_has_the_fluxes_of_independent_quadrature() {
    // incidence in degrees (above 90: from inside), R and T with separable and with correlated masking
    for (density, deg, separable, correlated) in [
        (student(0.7, 2.0), 60.0, [0.030_922, 0.770_294], [0.032_616, 0.747_551]),
        (beckmann(0.5 * 2.0_f64.sqrt()), 75.0, [0.075_114, 0.848_219], [0.077_658, 0.840_560]),
        (beckmann(0.5 * 2.0_f64.sqrt()), 120.0, [0.470_947, 0.233_230], [0.473_193, 0.230_515]),
        (smith(Profile::Cauchy, 15.0, 2.0), 75.0, [0.068_744, 0.756_181], [0.073_709, 0.726_269]),
    ] {
        let wi = Direction::from_angles(f64::to_radians(deg), 0.0);
        for (masking, want) in [(Masking::Separable, separable), (Masking::Correlated, correlated)]
        {
            let got = fluxes(&boundary(density).with_masking(masking), wi);
            for (a, b) in got.iter().zip(want) {
                assert!((a - b).abs() < 8e-4, "{deg} {masking:?}: {got:?} {want:?}");
            }
        }
    }
}

fn pairs() -> Vec<[f64; 3]> {
    let mut all = Vec::new();
    for z in [1.0, 0.7, 0.05, 1e-4, 1e-7_f64] {
        for phi in [0.0_f64, 0.4, 3.0] {
            let s = ((1.0 - z) * (1.0 + z)).sqrt();
            all.extend([1.0, -1.0].map(|up| [s * phi.cos(), s * phi.sin(), up * z]));
        }
    }
    all
}

fn edges<T: Real>(density: AnyDensity<f64>, masking: Masking) {
    let law: Microfacet<T, _> = boundary(density).with_masking(masking).cast();
    let direction = |w: [f64; 3]| {
        let [x, y, z] = w.map(T::from_f64);
        Direction::from_unit(x, y, z)
    };
    let good = |x: T| x.is_finite() && x >= T::ZERO;
    for i in pairs() {
        for o in pairs() {
            let (wi, wo) = (direction(i), direction(o));
            assert!(good(law.eval(wi, wo)) && good(law.pdf(wi, wo)), "{i:?} {o:?} {density:?}");
            let square = |w: [f64; 3]| if w[2] > 0.0 { 1.0 } else { 1.49 * 1.49 };
            let there = law.eval(wi, wo).to_f64() / square(o);
            let back = law.eval(wo, wi).to_f64() / square(i);
            let most = there.max(back);
            assert!((there - back).abs() <= 1e-3 * most + 1e-20, "{i:?} {o:?} {there} {back}");
        }
        for k in 0..27 {
            let corner = |n: i32| [0.0, 0.5, 1.0 - 6e-8][usize::try_from(k / n % 3).unwrap()];
            let mut u = [corner(1), corner(3), corner(9)].into_iter().cycle();
            if let Some(ray) = law.sample(direction(i), &mut || T::from_f64(u.next().unwrap())) {
                assert!(good(ray.weight) && ray.weight.to_f64() <= 1.0 + 1e-5, "{ray:?}");
                assert!((ray.wo.dot(ray.wo).to_f64() - 1.0).abs() < 1e-5, "{ray:?}");
            }
        }
        for bad in [[f64::NAN, 0.0, 0.5], [0.0, 0.0, f64::NAN], [1.0, 0.0, 0.0]] {
            assert!(law.eval(direction(i), direction(bad)) == T::ZERO);
            assert!(law.eval(direction(bad), direction(i)) == T::ZERO);
            let _ = law.sample(direction(bad), &mut || T::HALF);
        }
    }
}

#[test]
fn values_are_finite_and_reciprocal_up_to_the_edges_in_both_precisions() {
    for density in [
        student(1e-3, 1.51),
        student(0.3, 1.7),
        student(2.0, 500.0),
        beckmann(1e-3),
        beckmann(1.5),
        smith(Profile::Gauss, 0.1, 2.0),
        smith(Profile::Gauss, 30.0, 64.0),
        smith(Profile::Cauchy, 15.0, 0.5),
        stretched([1e-3, 0.3], 1.7),
        stretched([2.0, 0.05], 500.0),
        gaussian([0.002, 0.004]),
        gaussian([2.0, 0.1]),
        slopes(2.0, [0.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0]),
        slopes(0.01, [0.0, 5.0, -60.0, 0.0, 60.0, -60.0, 3.0, 4.0]),
        slopes(100.0, [0.0, -8.0, -16.0, -24.0, -32.0, -40.0, -48.0, -60.0]),
    ] {
        for masking in [Masking::Separable, Masking::Correlated] {
            edges::<f64>(density, masking);
            edges::<f32>(density, masking);
        }
    }
}

#[test]
fn visible_normals_follow_their_density() {
    // bins: 12 of the share of the area that is steeper, 8 of the azimuth from the direction, by symmetry half of it
    let (rings, parts, count) = (12_usize, 8_usize, 40_000_u32);
    for density in [
        student(0.3, 1.7),
        student(0.5, 4.0),
        beckmann(0.7),
        smith(Profile::Gauss, 20.0, 8.0),
        slopes(1.0, [0.0, 0.5, 1.0, 0.2, -2.0, -3.0, -6.0, -8.0]),
        slopes(0.5, [0.0, 0.0, -0.1, -0.2, -3.0, -5.0, -7.0, -11.0]),
    ] {
        for deg in [20.0, 60.0, 80.0, 88.0_f64] {
            let w = Direction::from_angles(deg.to_radians(), 0.0);
            let scale = density.g1(w) / w.z();
            let mut expected = vec![0.0; rings * parts];
            for ring in 0..rings {
                for k in 0..400 {
                    // shares spaced by a square, for the steepest facets are seen most; in the first ring by the power of the tail
                    let v = (f64::from(k) + 0.5) / 400.0;
                    let power = if ring == 0 { 0.5 * Density::<f64>::tail(&density) } else { 1.0 };
                    let y = (ring as f64 + v.powf(power)) / rings as f64;
                    let slope = Density::<f64>::slope_above(&density, y * y);
                    let area = 2.0 * y * power * v.powf(power - 1.0) / (400.0 * rings as f64);
                    for part in 0..parts {
                        for j in 0..40 {
                            let phi = (part as f64 + (f64::from(j) + 0.5) / 40.0) / parts as f64;
                            let facing =
                                w.z() + w.x() * slope * (phi * core::f64::consts::PI).cos();
                            expected[ring * parts + part] +=
                                scale * facing.max(0.0) * area / (40 * parts) as f64;
                        }
                    }
                }
            }
            let mut seen = vec![0.0; rings * parts];
            for k in 0..count {
                // SplitMix64
                let mut word = (u64::from(k) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                word ^= word >> 31;
                let u = [word >> 32, word & 0xffff_ffff].map(|x| x as f64 / 4_294_967_296.0);
                let [x, y, z] = density.sample_visible(w, u).xyz();
                let share = Density::<f64>::steeper(&density, x.hypot(y) / z).sqrt();
                let phi = y.abs().atan2(x) / core::f64::consts::PI;
                let bin = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
                seen[bin(share, rings) * parts + bin(phi, parts)] += 1.0;
            }
            let (mut chi2, mut freedom) = (0.0, -1.0);
            for (s, e) in seen.iter().zip(&expected) {
                let e = e * f64::from(count);
                if e > 20.0 {
                    chi2 += (s - e) * (s - e) / e;
                    freedom += 1.0;
                }
            }
            let sigmas = (chi2 - freedom) / (2.0_f64 * freedom).sqrt();
            assert!(freedom > 15.0 && sigmas < 5.0, "{density:?} {deg}: {sigmas} {chi2} {freedom}");
        }
    }
}

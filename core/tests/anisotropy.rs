//! Stretched facets against figures of an independent closed form, against the isotropic law, and against slow sums.
#![cfg(all(
    feature = "microfacet",
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

use asperity_core::bsdf::{Bsdf, Masking, Microfacet};
use asperity_core::direction::Direction;
use asperity_core::math::Real;
use asperity_core::ndf::beckmann::Beckmann;
use asperity_core::ndf::density::Density;
use asperity_core::ndf::stretched::Stretched;
use asperity_core::ndf::student::Student;
use asperity_core::quantity::{Alpha, QuantityError, RelativeIor};

type Facets = Stretched<f64, Student<f64>>;

fn pair([x, y]: [f64; 2]) -> [Alpha<f64>; 2] {
    [x, y].map(|a| Alpha::new(a).unwrap())
}

fn facets(sigma: [f64; 2], gamma: f64, deg: f64) -> Facets {
    Stretched::student(pair(sigma), gamma, deg.to_radians()).unwrap()
}

fn boundary(density: Facets) -> Microfacet<f64, Facets> {
    Microfacet::new(density, RelativeIor::new(1.49).unwrap())
}

/// Widths, orientation in degrees, both directions, and `f |cos|` with independent and with correlated masking and the
/// density of samples, of an independent closed form of anisotropic GGX (the last by Mitsuba 3).
type Row = ([f64; 3], [f64; 3], [f64; 3], [f64; 3]);

#[rustfmt::skip]
const GGX: [Row; 16] = [
    ([0.1, 0.3, 0.0], [0.6146380305, 0.02286575921, -0.788477838], [-0.7214056253, -0.1250524819, -0.6811283827], [1.365396371, 1.365403778, 1.370243907]),
    ([0.1, 0.3, 0.0], [0.9408940673, 0.1788087785, 0.287655592], [-0.7306573987, -0.5505753756, -0.4037406147], [0.2935644457, 0.2932625493, 0.3075817823]),
    ([0.3, 0.1, 30.0], [-0.9668432597, -0.1380161573, -0.21486184], [0.4436955868, -0.06935100861, -0.8934901357], [0.7842245218, 0.7849069106, 0.7871100903]),
    ([0.3, 0.1, 30.0], [-0.3798084924, -0.3526893031, -0.8551933765], [0.1593784324, 0.2572030808, 0.9531238675], [0.3411626486, 0.3411595299, 0.3417813778]),
    ([0.05, 0.5, 90.0], [0.7381590605, 0.350528419, -0.5764122009], [-0.5120885968, -0.3677668273, -0.7762169838], [3.753653149, 3.762031507, 3.853625059]),
    ([0.05, 0.5, 90.0], [-0.2975268364, -0.3992322385, -0.8672320247], [0.3455443382, 0.593929112, 0.7265309691], [24.74591715, 24.74422638, 25.10100555]),
    ([0.2, 0.2, 57.0], [-0.328566897, -0.9359656438, -0.1265388131], [0.3181314827, 0.9353195342, -0.1548217386], [7.860597032, 8.463655612, 10.30265713]),
    ([0.2, 0.2, 57.0], [-0.3766315817, 0.3612688484, 0.8530143499], [0.3407225749, -0.2314387753, -0.911232233], [9.838323814, 9.838275652, 9.858382225]),
    ([0.6, 0.25, -45.0], [-0.157802732, -0.647790866, -0.745295465], [0.7790816709, 0.3248099564, -0.5362184644], [0.2298856038, 0.2302470957, 0.2440491617]),
    ([0.6, 0.25, -45.0], [-0.5457373089, 0.1628878546, 0.8219721913], [0.3334831456, -0.1104772581, -0.9362605214], [9.798920043, 9.796706174, 9.901340485]),
    ([0.02, 0.1, 15.0], [-0.4482977932, 0.858865778, -0.2477470785], [0.4278689137, -0.7552821401, -0.4964645505], [15.3682217, 15.37192745, 15.47780323]),
    ([0.02, 0.1, 15.0], [-0.3825669845, -0.01385787729, -0.9238238335], [0.4692351996, 0.1025606416, 0.877097249], [0.1566271405, 0.1566271404, 0.1566318125]),
    ([1.0, 0.4, 120.0], [-0.3465670312, -0.6001890853, 0.7208775282], [0.1055381441, -0.2355884233, 0.9661054611], [0.003956350344, 0.003961320365, 0.004025154281]),
    ([1.0, 0.4, 120.0], [-0.9075348771, -0.2374792461, 0.3463870585], [0.9477588486, 0.02306631811, -0.3181526959], [0.7058480224, 0.6504383907, 1.07019043]),
    ([0.4, 1.2, 72.0], [-0.2778822364, 0.9514736426, -0.1322096139], [-0.7559693154, -0.3776692358, -0.534674108], [0.3198199028, 0.3946407335, 0.4379764497]),
    ([0.4, 1.2, 72.0], [-0.09222782498, -0.00538360132, -0.9957233667], [-0.130385661, 0.02560064518, 0.9911327958], [1.46858368, 1.468567334, 1.477904916]),
];

fn direction<T: Real>(w: [f64; 3]) -> Direction<T> {
    let w = Direction::new(w[0], w[1], w[2]).unwrap().xyz().map(T::from_f64);
    Direction::from_unit(w[0], w[1], w[2])
}

/// Relative errors of the three columns.
fn errors<T: Real>(&([x, y, deg], i, o, want): &Row) -> [f64; 3] {
    let law = boundary(facets([x, y], 2.0, deg)).cast::<T>();
    let (wi, wo) = (direction::<T>(i), direction::<T>(o));
    let correlated = law.with_masking(Masking::Correlated);
    let got = [law.ars(wi, wo), correlated.ars(wi, wo), law.pdf(wi, wo)].map(Real::to_f64);
    core::array::from_fn(|k| (got[k] / want[k] - 1.0).abs())
}

#[test]
fn anisotropic_ggx_has_the_figures_of_an_independent_closed_form() {
    // the directions of the figures are those of single precision
    for row in &GGX {
        let [separable, correlated, density] = errors::<f64>(row);
        assert!(separable < 1e-6 && correlated < 1e-6 && density < 1.5e-4, "{row:?}");
        let [separable, correlated, density] = errors::<f32>(row);
        assert!(separable < 5e-6 && correlated < 5e-6 && density < 1.5e-4, "{row:?}");
    }
}

#[test]
fn equal_widths_are_the_isotropic_law() {
    let (round, plain) =
        (facets([0.3, 0.3], 3.0, 25.0), Student::new(Alpha::new(0.3).unwrap(), 3.0));
    let (round, plain) = (boundary(round), plain.unwrap());
    let plain = Microfacet::new(plain, RelativeIor::new(1.49).unwrap());
    assert!(!round.density.is_anisotropic());
    // a width that differs in the last digits takes the other path
    let nearly = boundary(facets([0.3 * (1.0 + 1e-15), 0.3], 3.0, 25.0));
    assert!(nearly.density.is_anisotropic());
    for k in 0..200 {
        let angle = |m: i32| f64::from(k * m % 200) / 200.0;
        let wi = Direction::from_angles(1.5 * angle(7), 6.0 * angle(3));
        let wo = Direction::from_angles(3.1 * angle(11), 6.0 * angle(17));
        let want = plain.eval(wi, wo);
        assert!((round.eval(wi, wo) - want).abs() <= 1e-14 * want);
        assert!((nearly.eval(wi, wo) - want).abs() <= 1e-12 * want);
        let u = [angle(13), angle(29)];
        let apart = round.density.sample_visible(wi, u).dot(plain.density.sample_visible(wi, u));
        assert!((apart - 1.0).abs() < 1e-12);
    }
}

#[test]
fn gaussian_slopes_have_the_variances_of_their_widths() {
    // E[p^2] = alpha^2 / 2 along either axis, by the density and by what is visible along the normal
    let law = Stretched::beckmann(pair([0.4, 0.1]), 0.5).unwrap();
    let n = 400;
    let mut sums = [0.0; 3];
    for k in 0..n * n {
        let u = [k % n, k / n].map(|j| (f64::from(j) + 0.5) / f64::from(n));
        let [x, y, z] = law.sample_visible(Direction::normal(), u).xyz();
        let (p, q) = (
            (x * 0.5_f64.cos() + y * 0.5_f64.sin()) / z,
            (y * 0.5_f64.cos() - x * 0.5_f64.sin()) / z,
        );
        for (sum, term) in sums.iter_mut().zip([p * p, q * q, p * q]) {
            *sum += term / f64::from(n * n);
        }
    }
    assert!((sums[0] - 0.08).abs() < 1e-3 && (sums[1] - 0.005).abs() < 1e-4, "{sums:?}");
    assert!(sums[2].abs() < 1e-5, "{sums:?}");
    // the peak, and one width away along either axis
    let d = |x: f64, y: f64| {
        let (x, y) = (x * 0.5_f64.cos() - y * 0.5_f64.sin(), x * 0.5_f64.sin() + y * 0.5_f64.cos());
        law.d_of([x * x + y * y, 1.0], || [[0.0; 2]; 2], || [[x, 0.0], [y, 0.0], [1.0, 0.0]])
            / (1.0 + x * x + y * y).powi(2)
    };
    let peak = 1.0 / (core::f64::consts::PI * 0.04);
    assert!((d(0.0, 0.0) / peak - 1.0).abs() < 1e-12);
    for (x, y) in [(0.4, 0.0), (0.0, 0.1)] {
        assert!((d(x, y) * core::f64::consts::E / peak - 1.0).abs() < 1e-12);
    }
    let isotropic = Beckmann::new(Alpha::new(0.1).unwrap());
    assert!((law.slope() - Density::<f64>::slope(&isotropic)).abs() < 1e-15);
}

#[test]
fn visible_normals_follow_the_stretched_slopes() {
    // bins of the slopes before they are stretched: 8 of the share that is steeper, 12 of the azimuth
    let (rings, parts, count) = (8_usize, 12_usize, 40_000_u32);
    let (deg, stretch) = (35.0_f64, [0.6, 0.15]);
    let density = facets(stretch, 2.5, deg);
    let base = Student::new(Alpha::new(0.3).unwrap(), 2.5).unwrap();
    let (sin, cos) = deg.to_radians().sin_cos();
    for (theta, phi) in [(0.3, 0.0), (1.0, 2.0), (1.35, 4.5), (1.5, 1.0_f64)] {
        let w = Direction::from_angles(theta, phi);
        let mut expected = vec![0.0; rings * parts];
        for ring in 0..rings * 300 {
            let y = (ring as f64 + 0.5) / (300 * rings) as f64;
            let slope = Density::<f64>::slope_above(&base, y * y) / 0.3;
            for part in 0..parts * 40 {
                let angle = core::f64::consts::TAU * (part as f64 + 0.5) / (40 * parts) as f64;
                let (p, q) = (stretch[0] * slope * angle.cos(), stretch[1] * slope * angle.sin());
                let (x, y_slope) = (p * cos - q * sin, p * sin + q * cos);
                let facing = (w.z() + w.x() * x + w.y() * y_slope).max(0.0);
                let area = 2.0 * y / (300 * rings * 40 * parts) as f64;
                expected[ring / 300 * parts + part / 40] += facing * area;
            }
        }
        let visible: f64 = expected.iter().sum();
        assert!((visible / density.visible_area(w) - 1.0).abs() < 1e-3, "{theta} {visible}");
        let mut seen = vec![0.0; rings * parts];
        for k in 0..count {
            // SplitMix64
            let mut word = (u64::from(k) + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            word ^= word >> 31;
            let u = [word >> 32, word & 0xffff_ffff].map(|x| x as f64 / 4_294_967_296.0);
            let [x, y, z] = density.sample_visible(w, u).xyz();
            let (p, q) =
                ((x * cos + y * sin) / z / stretch[0], (y * cos - x * sin) / z / stretch[1]);
            let share = Density::<f64>::steeper(&base, 0.3 * p.hypot(q)).sqrt();
            let turn = q.atan2(p).rem_euclid(core::f64::consts::TAU) / core::f64::consts::TAU;
            let bin = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
            seen[bin(share, rings) * parts + bin(turn, parts)] += 1.0;
        }
        let (mut chi2, mut freedom) = (0.0, -1.0);
        for (s, e) in seen.iter().zip(&expected) {
            let e = e / visible * f64::from(count);
            if e > 20.0 {
                chi2 += (s - e) * (s - e) / e;
                freedom += 1.0;
            }
        }
        let sigmas = (chi2 - freedom) / (2.0_f64 * freedom).sqrt();
        assert!(freedom > 30.0 && sigmas < 5.0, "{theta} {phi}: {sigmas} {chi2} {freedom}");
    }
}

#[test]
fn single_precision_keeps_a_narrow_axis_beside_a_wide_one() {
    let law = boundary(facets([1e-3, 0.8], 2.0, 33.0));
    let single = law.cast::<f32>();
    let turned = |p: f64, q: f64| {
        let (sin, cos) = 33.0_f64.to_radians().sin_cos();
        [p * cos - q * sin, p * sin + q * cos]
    };
    for k in 0..60 {
        // facets up to three narrow widths beside the ridge, far along it
        let (p, q) = (1e-3 * (f64::from(k % 7) - 3.0), 0.03 * f64::from(k) - 0.9);
        let [x, y] = turned(p, q);
        let m = Direction::new(x, y, 1.0).unwrap();
        let wi = Direction::from_angles(0.4, 1.0);
        let wo = Direction::new(
            2.0 * wi.dot(m) * m.x() - wi.x(),
            2.0 * wi.dot(m) * m.y() - wi.y(),
            2.0 * wi.dot(m) * m.z() - wi.z(),
        )
        .unwrap();
        if wo.z() > 0.0 && wi.dot(m) > 0.0 {
            let [i, o] = [wi, wo].map(|w| w.xyz().map(|x| x as f32));
            let (i, o) =
                (Direction::from_unit(i[0], i[1], i[2]), Direction::from_unit(o[0], o[1], o[2]));
            let wide = |w: Direction<f32>| {
                let [x, y, z] = w.xyz().map(f64::from);
                Direction::from_unit(x, y, z)
            };
            let (got, want) = (f64::from(single.eval(i, o)), law.eval(wide(i), wide(o)));
            assert!((got / want - 1.0).abs() < 1e-3, "{k}: {got} {want}");
        }
    }
}

#[test]
fn numbers_outside_the_domain_are_refused() {
    let sigma = pair([0.1, 0.2]);
    assert_eq!(Stretched::student(sigma, 1.0, 0.0).err(), Some(QuantityError::TooSmall));
    assert_eq!(Stretched::student(sigma, 2.0, f64::NAN).err(), Some(QuantityError::NotFinite));
    assert!(Stretched::beckmann(sigma, f64::INFINITY).is_err());
    assert!(Stretched::beckmann(pair([1e-6, 1e-6]), 0.0).is_ok());
    assert!(Stretched::beckmann(pair([100.0, 1e-6]), 0.0).is_ok());
}

/// `D` of a normal.
fn d_at(density: &Facets, m: Direction<f64>) -> f64 {
    let [x, y, z] = m.xyz();
    let squares = [x * x + y * y, z * z];
    density.d_of(squares, || squares.map(|s| [s, 0.0]), || [x, y, z].map(|c| [c, 0.0]))
}

#[test]
fn facets_that_face_a_direction_from_below_follow_their_density() {
    // moments of the normals against a sum over slopes
    let density = facets([0.3, 0.9], 3.0, 40.0);
    let mut state = 5_u64;
    let mut uniform = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from_bits_uniform(state)
    };
    for (polar_deg, azimuth) in [(95.0_f64, 0.4), (120.0, 2.0), (150.0, -1.0)] {
        let w = Direction::from_angles(polar_deg.to_radians(), azimuth);
        let of = |m: Direction<f64>| [m.x(), m.y(), m.x() * m.x(), m.x() * m.y(), m.z()];
        let (mut area, mut sums) = (0.0, [0.0; 5]);
        let (rings, parts) = (700, 400);
        for i in 0..rings {
            let t = (f64::from(i) + 0.5) / f64::from(rings);
            let theta = core::f64::consts::FRAC_PI_2 * t;
            for k in 0..parts {
                let phi = core::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(parts);
                let m = Direction::from_angles(theta, phi);
                let per = d_at(&density, m) * m.dot(w).max(0.0) * theta.sin();
                area += per;
                sums.iter_mut().zip(of(m)).for_each(|(sum, x)| *sum += per * x);
            }
        }
        let count = 40_000;
        let (mut means, mut squares) = ([0.0; 5], [0.0; 5]);
        for _ in 0..count {
            let m = Density::<f64>::sample_facing(&density, w, [uniform(), uniform()]);
            assert!(m.dot(w) > -1e-9, "{m:?}");
            for (k, x) in of(m).into_iter().enumerate() {
                means[k] += x;
                squares[k] += x * x;
            }
        }
        for k in 0..5 {
            let mean = means[k] / f64::from(count);
            let se = ((squares[k] / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
            let wanted = sums[k] / area;
            assert!(
                (mean - wanted).abs() < 4.5 * se + 1e-4,
                "{polar_deg} {k}: {mean} {wanted} {se}"
            );
        }
    }
}

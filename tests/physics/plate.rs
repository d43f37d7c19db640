//! The plate: flux, the smooth limit, and a walker in the plate's own frame that knows no trick.

use asperity_core::bsdf::{Ggx, Normals, Scatter, Smooth};
use asperity_core::direction::{Direction, Side};
use asperity_core::math::Real;
use asperity_core::ndf::law::Profile;
use asperity_core::plate::{Outcome, Plate, RoughSide};
use asperity_tests::oracle::{self, Vec3};
use asperity_tests::{count, tolerance};

use crate::common::{Random, dir, ggx, incidence, ior, normals, wide};

const SIDES: [RoughSide; 2] = [RoughSide::Source, RoughSide::Detector];

/// Means over rays, the standard error of the transmitted share, and the mean x of what is transmitted.
struct Mean {
    out: [f64; 3],
    error: f64,
    x: f64,
    worst_sum: f64,
}

fn run<T: Real, S: Scatter<T>>(plate: &Plate<S, T>, wi: Vec3, rays: usize, seed: u128) -> Mean {
    let mut random = Random::new(seed);
    let mut mean = Mean { out: [0.0; 3], error: 0.0, x: 0.0, worst_sum: 0.0 };
    let mut squares = 0.0;
    let share = 1.0 / rays as f64;
    for _ in 0..rays {
        let mut left = [0.0; 2];
        let mut x = 0.0;
        let Outcome { reflected, transmitted, lost } =
            plate.trace(dir(wi), &mut || random.next(), &mut |wo, flux| {
                left[usize::from(wo.side() != Some(Side::Air))] += flux.to_f64();
                if wo.side() == Some(Side::Dielectric) {
                    x += wo.x().to_f64() * flux.to_f64();
                }
            });
        let parts = [reflected, transmitted, lost].map(Real::to_f64);
        // what leaves is what is counted
        assert!(
            (left[0] - parts[0]).abs() + (left[1] - parts[1]).abs() < 1e-5,
            "{left:?} {parts:?}"
        );
        mean.worst_sum = mean.worst_sum.max((parts.iter().sum::<f64>() - 1.0).abs());
        for (m, p) in mean.out.iter_mut().zip(parts) {
            *m += p * share;
        }
        squares += parts[1] * parts[1] * share;
        mean.x += x * share;
    }
    mean.error = ((squares - mean.out[1] * mean.out[1]).max(0.0) * share).sqrt();
    mean
}

/// The same plate walked in its own frame, face by face, every choice by lot.
fn walk(
    rough: &impl Scatter<f64>,
    n: f64,
    side: RoughSide,
    wi: Vec3,
    random: &mut Random,
) -> Option<(Vec3, f64)> {
    // travel: where the light goes; place: above 0, inside 1, below 2
    let mut travel = wi.map(|x| -x);
    let mut place = 0;
    let mut weight = 1.0;
    for _ in 0..2000 {
        let top = match place {
            0 => true,
            1 => travel[2] > 0.0,
            _ => return Some((travel, weight)),
        };
        let from = travel.map(|x| -x);
        // the frame of a face has its air above: the lower face is seen upside down
        let flip = |w: Vec3| if top { w } else { [w[0], -w[1], -w[2]] };
        let is_rough = top == (side == RoughSide::Source);
        let seen = flip(from);
        if is_rough {
            let s = rough.sample(dir(seen), &mut || random.next())?;
            weight *= s.weight;
            travel = flip(wide(s.wo));
        } else {
            let [mirror, snell] = oracle::lobes(seen, n);
            let far = if seen[2] > 0.0 { n } else { 1.0 / n };
            let f = oracle::fresnel(seen[2].abs(), far).unpolarised();
            travel = flip(if random.next::<f64>() < f { mirror } else { snell });
        }
        let outside = if top { travel[2] > 0.0 } else { travel[2] < 0.0 };
        match (outside, top) {
            (true, true) => return Some((travel, weight)),
            (true, false) => place = 2,
            (false, _) => place = 1,
        }
    }
    None
}

#[test]
fn a_smooth_plate_transmits_what_its_internal_passes_sum_to() {
    for n in [1.2, 1.49, 2.4] {
        for deg in [0.0, 30.0, 60.0, 85.0] {
            let wi = incidence(deg, true);
            let f = oracle::fresnel(wi[2], n).unpolarised();
            let exact = (1.0 - f) / (1.0 + f);
            for side in SIDES {
                let eta = ior::<f64>(n);
                let mean = run(&Plate::new(Smooth { eta }, eta, side), wi, count(20_000), 11);
                let case = format!("n {n} {deg} deg {side:?}: {:?}, exactly {exact}", mean.out);
                let allowed = tolerance::MONTE_CARLO.allowed * mean.error + 1e-9;
                assert!((mean.out[1] - exact).abs() < allowed, "{case}");
                assert!(mean.out[2].abs() < 1e-3, "{case}");
                assert!(mean.worst_sum < tolerance::PLATE_F64.allowed, "{case} {}", mean.worst_sum);
                // all of it leaves along the undeviated beam
                assert!((mean.x / mean.out[1] - -wi[0]).abs() < 1e-9, "{case} {}", mean.x);
            }
        }
    }
}

#[test]
fn a_nearly_smooth_plate_is_a_smooth_plate() {
    for deg in [0.0, 30.0, 60.0] {
        let wi = incidence(deg, true);
        let f = oracle::fresnel(wi[2], 1.49).unpolarised();
        let exact = (1.0 - f) / (1.0 + f);
        for side in SIDES {
            let plate = Plate::new(ggx::<f64>(1e-6, 1.49), ior(1.49), side);
            let mean = run(&plate, wi, count(20_000), 12);
            let case = format!("{deg} deg {side:?}: {:?}, smooth {exact}", mean.out);
            let allowed = tolerance::MONTE_CARLO.allowed * mean.error;
            assert!((mean.out[1] - exact).abs() < allowed, "{case}");
            assert!(
                (mean.x / mean.out[1] - -wi[0]).abs() < tolerance::SMOOTH_LIMIT.allowed,
                "{case}"
            );
        }
    }
}

#[test]
fn flux_is_conserved_and_an_artless_walker_finds_the_same() {
    println!("plate: R T lost, and T and mean x of a plain walker");
    let rays = count(30_000);
    let mut seed = 0;
    let mut check = |rough: &dyn Fn() -> Rough, n: f64, side, deg: f64, case: &str| {
        let wi = incidence(deg, true);
        let mean = run(&Plate::new(rough(), ior(n), side), wi, rays, 2000 + seed);
        seed += 1;
        let mut random = Random::new(1000 + seed);
        let (mut r, mut t, mut x) = (0.0, 0.0, 0.0);
        for _ in 0..rays {
            if let Some((w, weight)) = walk(&rough(), n, side, wi, &mut random) {
                let share = weight / rays as f64;
                if w[2] > 0.0 {
                    r += share;
                } else {
                    t += share;
                    x += w[0] * share;
                }
            }
        }
        let [got_r, got_t, lost] = mean.out;
        let text = format!(
            "{case} n {n} {side:?} {deg} deg: {got_r:.4} {got_t:.4} {lost:.4}, {r:.4} {t:.4}, x {:.4} {x:.4}",
            mean.x
        );
        println!("  {text}");
        assert!(mean.worst_sum < tolerance::PLATE_F64.allowed, "{text} sum {:e}", mean.worst_sum);
        // the plain walker's ray ends in one place or the other
        let walkers = |p: f64| p * (1.0 - p) / rays as f64;
        let noise = |p| tolerance::MONTE_CARLO.allowed * (mean.error.powi(2) + walkers(p)).sqrt();
        assert!((got_r - r).abs() < noise(r) && (got_t - t).abs() < noise(t), "{text}");
        let noise = noise(0.5);
        assert!((mean.x - x).abs() < noise, "{text}");
    };
    for side in SIDES {
        for deg in [0.0, 45.0, 75.0] {
            for a in [0.05, 0.5] {
                let make = || Rough::Ggx(ggx(a, 1.49));
                check(&make, 1.49, side, deg, &format!("ggx {a}"));
            }
            let density = normals(Profile::Cauchy, 0.3, 2.5, 1.49);
            check(&|| Rough::Normals(Box::new(density)), 1.49, side, deg, "normals");
        }
    }
}

/// A rough face of either kind.
enum Rough {
    Ggx(Ggx<f64>),
    Normals(Box<Normals<f64>>),
}

impl Scatter<f64> for Rough {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<asperity_core::bsdf::Scattered<f64>> {
        match self {
            Self::Ggx(law) => law.sample(wi, uniform),
            Self::Normals(law) => law.sample(wi, uniform),
        }
    }
}

#[test]
fn single_precision_keeps_the_books_of_the_plate() {
    let mut worst = 0.0_f64;
    for side in SIDES {
        for deg in [0.0, 60.0, 85.0] {
            for a in [0.01, 0.3, 1.0] {
                let wi = incidence(deg, true);
                let narrow = run(&Plate::new(ggx::<f32>(a, 1.49), ior(1.49), side), wi, 5000, 15);
                let wider = run(&Plate::new(ggx::<f64>(a, 1.49), ior(1.49), side), wi, 5000, 15);
                let case =
                    format!("alpha {a} {deg} deg {side:?}: {:?} {:?}", narrow.out, wider.out);
                worst = worst.max(narrow.worst_sum);
                assert!(narrow.worst_sum < tolerance::PLATE_F32.allowed, "{case}");
                // the uniforms are the same to 24 bits: few rays take another way
                assert!((narrow.out[1] - wider.out[1]).abs() < 2e-3, "{case}");
            }
        }
    }
    println!("plate: R + T + lost of single rays in f32 is 1 within {worst:.1e}");
}

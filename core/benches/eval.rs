//! Nanoseconds per evaluation, sample and Monte Carlo ray of the core, one core, one call at a time.
//!
//! Inputs are so many and so random that no branch predictor learns them by heart: "any sides" is the
//! worst case, "air to air" what a scan in reflection asks for.
#![expect(clippy::unwrap_used, reason = "constant inputs")]

use std::hint::black_box;
use std::time::Duration;

use asperity_core::bsdf::{Bsdf, Ggx, Normals, OpaqueGgx, Scatter};
use asperity_core::direction::Direction;
use asperity_core::gonio::incidence;
use asperity_core::math::Real;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::plate::{Plate, RoughSide};
use asperity_core::quantity::{Alpha, RelativeIor};
use criterion::Criterion;
use rand_pcg::Pcg64Mcg;

/// A power of two; a few thousand would be learnt.
const PAIRS: usize = 1 << 15;

type Pair<T> = (Direction<T>, Direction<T>);

fn alpha<T: Real>() -> Alpha<T> {
    Alpha::new(T::from_f64(0.3)).unwrap()
}

fn ior<T: Real>() -> RelativeIor<T> {
    RelativeIor::new(T::from_f64(1.49)).unwrap()
}

/// Uniform over the sphere.
fn direction<T: Real>(generator: &mut Pcg64Mcg) -> Direction<T> {
    let z = 2.0 * f64::uniform(generator) - 1.0;
    let r = Real::sqrt(1.0 - z * z);
    let (s, c) = Real::sin_cos(std::f64::consts::TAU * f64::uniform(generator));
    Direction::from_unit(T::from_f64(r * c), T::from_f64(r * s), T::from_f64(z))
}

fn any_sides<T: Real>() -> Vec<Pair<T>> {
    let generator = &mut Pcg64Mcg::new(1);
    (0..PAIRS).map(|_| (direction(generator), direction(generator))).collect()
}

fn air_to_air<T: Real>() -> Vec<Pair<T>> {
    let up = |w: Direction<T>| Direction::from_unit(w.x(), w.y(), w.z().abs());
    any_sides().into_iter().map(|(wi, wo)| (up(wi), up(wo))).collect()
}

/// Times one call of `f`, which gets another pair each time.
fn each<T: Real>(c: &mut Criterion, name: &str, pairs: &[Pair<T>], f: impl Fn(&Pair<T>) -> T) {
    let mut k = 0;
    c.bench_function(name, |bencher| {
        bencher.iter(|| {
            k = (k + 1) % PAIRS;
            f(black_box(&pairs[k]))
        });
    });
}

/// Times one sample, uniforms included; a lost ray is one, too.
fn each_sample<T: Real>(c: &mut Criterion, name: &str, boundary: &impl Scatter<T>) {
    let pairs = any_sides::<T>();
    let (mut k, mut generator) = (0, Pcg64Mcg::new(2));
    c.bench_function(name, |bencher| {
        bencher.iter(|| {
            k = (k + 1) % PAIRS;
            boundary.sample(pairs[k].0, &mut || T::uniform(&mut generator))
        });
    });
}

fn ggx<T: Real>(c: &mut Criterion, scalar: &str) {
    let (any, air) = (any_sides::<T>(), air_to_air::<T>());
    let boundary = Ggx::<T>::new(alpha(), ior());
    each(c, &format!("ggx eval, any sides, {scalar}"), &any, |p| boundary.eval(p.0, p.1));
    each(c, &format!("ggx eval, air to air, {scalar}"), &air, |p| boundary.eval(p.0, p.1));
    each(c, &format!("ggx ars, any sides, {scalar}"), &any, |p| boundary.ars(p.0, p.1));
    each(c, &format!("ggx pdf, any sides, {scalar}"), &any, |p| boundary.pdf(p.0, p.1));
    each_sample(c, &format!("ggx sample, {scalar}"), &boundary);
    let opaque = OpaqueGgx::new(alpha(), T::from_f64(0.7), T::from_f64(0.05)).unwrap();
    each(c, &format!("opaque ggx eval, air to air, {scalar}"), &air, |p| opaque.eval(p.0, p.1));
}

fn normals(c: &mut Criterion) {
    let law = Law::new(Profile::Gauss, 0.2, 2.0, 0.0).unwrap();
    let boundary: Normals<f64> = Normals::new(NormalDensity::new(law), ior());
    each(c, "normals eval, any sides, f64", &any_sides(), |p| boundary.eval(p.0, p.1));
    each(c, "normals eval, air to air, f64", &air_to_air(), |p| boundary.eval(p.0, p.1));
    each_sample(c, "normals sample, f64", &boundary);
    c.bench_function("normals density made, f64", |bencher| {
        bencher.iter(|| NormalDensity::<f64, 256>::new(black_box(law)));
    });
}

/// One ray at 30 degrees through a plate, all internal passes, uniforms included.
fn plate<T: Real>(c: &mut Criterion, scalar: &str) {
    for (side, rough_side) in [("source", RoughSide::Source), ("detector", RoughSide::Detector)] {
        let plate = Plate::new(Ggx::<T>::new(alpha(), ior()), ior(), rough_side);
        let wi = incidence(T::from_f64(30.0_f64.to_radians()));
        let mut generator = Pcg64Mcg::new(3);
        c.bench_function(&format!("plate ray, ggx, rough to {side}, {scalar}"), |bencher| {
            bencher.iter(|| {
                let mut sum = T::ZERO;
                let mut exit = |wo: Direction<T>, flux| sum = sum + wo.z() * flux;
                let outcome = plate.trace(wi, &mut || T::uniform(&mut generator), &mut exit);
                (sum, outcome)
            });
        });
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    ggx::<f64>(&mut criterion, "f64");
    ggx::<f32>(&mut criterion, "f32");
    normals(&mut criterion);
    plate::<f64>(&mut criterion, "f64");
    plate::<f32>(&mut criterion, "f32");
    criterion.final_summary();
}

//! Evaluators in single, fast and double precision, with parameters drawn over their domains.

use std::marker::PhantomData;

use asperity_core::bsdf::{Bsdf, Ggx, Normals, OpaqueGgx};
use asperity_core::direction::Direction;
use asperity_core::math::{Fast, Real};
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::ndf::normals::NormalDensity;
use asperity_tests::oracle::Vec3;

use crate::common::{Random, alpha, dir, ior, wide};

/// One evaluator in all tiers, its parameters rounded to single precision first.
pub(crate) struct Subject {
    pub(crate) name: &'static str,
    pub(crate) text: String,
    /// What a facet's slope is measured in, and the index.
    pub(crate) width: f64,
    pub(crate) index: f64,
    pub(crate) centre: f64,
    pub(crate) double: Box<dyn Evaluate>,
    pub(crate) tiers: [Box<dyn Evaluate>; 3],
}

/// An evaluator on double numbers that hold single ones.
pub(crate) trait Evaluate: Send + Sync {
    /// `eval`, `ars`, `pdf`.
    fn values(&self, wi: Vec3, wo: Vec3) -> [f64; 3];
    fn sample(&self, wi: Vec3, u: [f64; 4]) -> Option<(Vec3, f64)>;
}

struct Of<B, T>(B, PhantomData<T>);

impl<T: Real, B: Bsdf<T> + Send + Sync> Evaluate for Of<B, T> {
    fn values(&self, wi: Vec3, wo: Vec3) -> [f64; 3] {
        let (wi, wo): (Direction<T>, Direction<T>) = (dir(wi), dir(wo));
        [self.0.eval(wi, wo), self.0.ars(wi, wo), self.0.pdf(wi, wo)].map(Real::to_f64)
    }
    fn sample(&self, wi: Vec3, u: [f64; 4]) -> Option<(Vec3, f64)> {
        let mut next = u.into_iter().cycle().map(T::from_f64);
        let s = self.0.sample(dir(wi), &mut || next.next().unwrap_or(T::HALF))?;
        Some((wide(s.wo), s.weight.to_f64()))
    }
}

fn evaluator<T: Real, B: Bsdf<T> + Send + Sync + 'static>(law: B) -> Box<dyn Evaluate> {
    Box::new(Of::<B, T>(law, PhantomData))
}

macro_rules! subject {
    ($name:literal, $text:expr, $width:expr, $index:expr, $centre:expr, $make:ident($($x:expr),*)) => {
        Subject {
            name: $name, text: $text, width: $width, index: $index, centre: $centre,
            double: $make::<f64>($($x),*),
            tiers: [$make::<f32>($($x),*), $make::<Fast<f32>>($($x),*), $make::<Fast<f64>>($($x),*)],
        }
    };
}

fn make_ggx<T: Real>(a: f64, n: f64) -> Box<dyn Evaluate> {
    evaluator::<T, _>(Ggx::new(alpha(a), ior(n)))
}

fn make_opaque<T: Real>(a: f64, lambert: f64) -> Box<dyn Evaluate> {
    evaluator::<T, _>(OpaqueGgx::new(alpha(a), T::from_f64(0.75), T::from_f64(lambert)).unwrap())
}

fn make_normals<T: Real>(profile: Profile, p: [f64; 3], n: f64) -> Box<dyn Evaluate> {
    let [delta, exponent, centre] = p.map(T::from_f64);
    let law = Law::new(profile, delta, exponent, centre).unwrap();
    evaluator::<T, _>(Normals::<T, 256>::new(NormalDensity::new(law), ior(n)))
}

/// Rounded to single precision.
pub(crate) fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

/// An index: a plate's, any, near 1 (no nearer than 1e-3), below 1.
fn index(random: &mut Random) -> f64 {
    single(match random.next::<f64>() {
        x if x < 0.4 => 1.49,
        x if x < 0.7 => random.between(1.1, 2.5),
        x if x < 0.85 => 1.0 + random.log(1e-3, 0.1),
        _ => 1.0 / random.between(1.02, 2.5),
    })
}

/// GGX, or an opaque surface, of alpha 1e-3 to 2.
pub(crate) fn closed_form(random: &mut Random) -> Subject {
    let a = single(random.log(1e-3, 2.0));
    if random.next::<f64>() < 0.2 {
        let lambert = single(if random.next::<f64>() < 0.5 { 0.0 } else { 0.05 });
        let text = format!("alpha {a} lambert {lambert}");
        return subject!("opaque", text, a, 1.0, 0.0, make_opaque(a, lambert));
    }
    let n = index(random);
    subject!("ggx", format!("alpha {a} index {n}"), a, n, 0.0, make_ggx(a, n))
}

/// Laws of normals: all profiles, delta 1e-3 to 1.5, n 0.3 to 100, also with a centre.
pub(crate) fn normals(random: &mut Random) -> Subject {
    let exponents = [0.3, 0.7, 1.0, 2.0, 2.0, 2.0, 2.5, 4.0, 8.0, 16.0, 40.0, 100.0];
    let pick = random.next::<f64>() * exponents.len() as f64;
    let (delta, exponent) = (single(random.log(1e-3, 1.5)), single(exponents[pick as usize]));
    let centred = random.next::<f64>() < 0.75;
    let centre = single(if centred { 0.0 } else { random.log(0.01, 1.0) });
    let cauchy = random.next::<f64>() < 0.5;
    let profile = if cauchy { Profile::Cauchy } else { Profile::Gauss };
    let (n, p) = (index(random), [delta, exponent, centre]);
    let text = format!("{profile:?} delta {delta} n {exponent} centre {centre} index {n}");
    subject!("normals", text, delta, n, centre, make_normals(profile, p, n))
}

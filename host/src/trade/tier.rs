//! A law of any number type as one of double precision, so that all can be compared with the same reference.

use std::marker::PhantomData;

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe, Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_core::math::Real;

/// The same direction in another number type.
#[inline]
pub(crate) fn cast<A: Real, B: Real>(w: Direction<A>) -> Direction<B> {
    let [x, y, z] = w.xyz().map(|x| B::from_f64(x.to_f64()));
    Direction::from_unit(x, y, z)
}

/// `B`, computed in `T`, asked and answered in `f64`.
pub(crate) struct Through<'a, T, B> {
    law: &'a B,
    of: PhantomData<T>,
}

impl<'a, T: Real, B: Bsdf<T>> Through<'a, T, B> {
    pub(crate) fn new(law: &'a B) -> Self {
        Self { law, of: PhantomData }
    }
}

/// A uniform of another type, still below 1.
fn uniform<T: Real>(u: f64) -> T {
    T::from_f64(u).min(T::ONE - T::EPSILON)
}

fn wide<T: Real>(ray: Scattered<T>) -> Scattered<f64> {
    Scattered { wo: cast(ray.wo), weight: ray.weight.to_f64() }
}

impl<T: Real, B: Bsdf<T>> Scatter<f64> for Through<'_, T, B> {
    fn sample(&self, wi: Direction<f64>, next: &mut impl FnMut() -> f64) -> Option<Scattered<f64>> {
        self.law.sample(cast(wi), &mut || uniform(next())).map(wide)
    }
}

impl<T: Real, B: Bsdf<T>> Bsdf<f64> for Through<'_, T, B> {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.law.eval(cast(wi), cast(wo)).to_f64()
    }
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.law.ars(cast(wi), cast(wo)).to_f64()
    }
    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.law.pdf(cast(wi), cast(wo)).to_f64()
    }
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        self.law.sample_lobe(cast(wi), lobe, u.map(uniform)).map(wide)
    }
    fn slope(&self) -> f64 {
        self.law.slope().to_f64()
    }
    fn coherent_flux(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        let CoherentFlux { reflected, transmitted } = self.law.coherent_flux(cast(wi));
        CoherentFlux { reflected: reflected.to_f64(), transmitted: transmitted.to_f64() }
    }
}

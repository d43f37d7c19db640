//! All bounces of light on a rough boundary, as a law with values.

mod balance;
mod compensation;
mod exchange;
mod facets;
mod first;
mod shares;
mod single;

pub use compensation::{Compensation, LaterFlux, NUMBERS as COMPENSATION_NUMBERS};
pub use single::FirstBounce;

use super::facet::{facet_ray, lit, straight};
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::Direction;
use crate::fresnel;
use crate::math::Real;
use crate::scope;

/// A law of one bounce, completed by the light that meets more than one facet.
///
/// The first bounce is exact, with height-correlated masking. Later bounces have their exact flux, which the first leaves
/// over, are shared between reflection and transmission as the microsurface of Smith shares them, and leave as a diffuse lobe
/// ([`Compensation`]). R + T is 1; [`super::Walk`] is the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllBounces<T, L> {
    /// The law of the first bounce; its own masking does not matter.
    pub single: L,
    /// The light of later bounces.
    pub later: Compensation<T>,
}

impl<T: Real, L: FirstBounce<T>> AllBounces<T, L> {
    /// Completes a law: some milliseconds of work on a computer.
    pub fn new(single: L) -> Self {
        Self { single, later: Compensation::new(&single.facets(), single.eta().cast()) }
    }

    /// Draws a ray of the first bounce into one lobe from two uniforms in [0, 1); its mean weight is the flux of that bounce.
    pub fn first_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let (m, far) = self.single.facet(wi, u)?;
        let ray = facet_ray(wi, m, far, lobe)?;
        Some(Scattered { wo: ray.wo, weight: ray.weight * self.single.way_out(wi, ray.wo) })
    }

    /// The same boundary in another precision, each number rounded once.
    pub fn cast<U: Real>(&self) -> AllBounces<U, L::In<U>> {
        AllBounces { single: self.single.cast(), later: self.later.cast() }
    }
}

impl<T: Real, L: FirstBounce<T>> Scatter<T> for AllBounces<T, L> {
    /// Draws a facet, and whether its ray leaves; otherwise a direction of later bounces. Every weight is 1.
    ///
    /// Takes six uniforms.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let u = [uniform(), uniform()];
        let (choice, escape) = (uniform(), uniform());
        let diffuse = [uniform(), uniform()];
        let eta = self.single.eta();
        if eta.is_matched() {
            return straight(wi);
        }
        let (m, far) = self.single.facet(wi, u)?;
        let reflected = fresnel::dielectric(m.dot(wi).abs(), far).reflected;
        let lobe = if choice < reflected { Lobe::Reflection } else { Lobe::Transmission };
        if !scope::lobe(lobe == Lobe::Reflection) {
            return None;
        }
        let mut left = T::ONE;
        let mut rest = escape;
        if let Some(ray) = facet_ray(wi, m, far, lobe) {
            let leaves = self.single.way_out(wi, ray.wo);
            if escape < leaves {
                return Some(Scattered { wo: ray.wo, weight: T::ONE });
            }
            left = T::ONE - leaves;
            rest = escape - leaves;
        }
        let flux = self.later.flux(wi);
        let back = rest * (flux.reflected + flux.transmitted) < left * flux.reflected;
        let lobe = if back { Lobe::Reflection } else { Lobe::Transmission };
        let wo = self.later.draw(wi, lobe, diffuse)?;
        Some(Scattered { wo, weight: T::ONE })
    }
}

impl<T: Real, L: FirstBounce<T>> Bsdf<T> for AllBounces<T, L> {
    #[inline(always)]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        (self.single.first(wi, wo) + self.later.eval(wi, wo)).min(T::MAX)
    }

    #[inline(always)]
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.ars(wi, wo)
    }

    /// A part of the uniforms, as large as the share of later bounces, draws from their lobe.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        if self.single.eta().is_matched() {
            return straight(wi).filter(|_| lobe == Lobe::Transmission);
        }
        lit(wi)?;
        let flux = self.later.flux(wi);
        let first = (T::ONE - flux.reflected - flux.transmitted).max(T::from_f64(0.25));
        let [u0, u1] = u;
        if u0 < first {
            let ray = self.first_lobe(wi, lobe, [u0 / first, u1])?;
            return Some(Scattered { wo: ray.wo, weight: ray.weight / first });
        }
        let rest = T::ONE - first;
        let wo = self.later.draw(wi, lobe, [(u0 - first) / rest, u1])?;
        let share = match lobe {
            Lobe::Reflection => flux.reflected,
            Lobe::Transmission => flux.transmitted,
        };
        (share > T::ZERO).then(|| Scattered { wo, weight: share / rest })
    }

    fn slope(&self) -> T {
        self.single.slope()
    }
}

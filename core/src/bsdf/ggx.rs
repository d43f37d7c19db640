//! GGX rough dielectric, reflection and transmission from both sides \[Walter2007; Sokolov eqs 1-3\].

use super::facet::{facet_ray, lit, straight};
use super::half::HalfVector;
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel;
use crate::math::Real;
use crate::ndf::ggx::{d_of_vector, g1, sample_visible, shadow_sum};
use crate::quantity::{Alpha, RelativeIor};

/// A rough dielectric boundary with GGX facets, separable Smith shadowing and exact Fresnel factors.
///
/// `f = D G F / (4 |cos_i cos_o|)` in reflection and \[Walter2007, eq. 21\] in transmission, `G = G1 G1`.
/// It leaves out light that meets a second facet (this light is lost; see the energy table of `check`), polarisation
/// and diffraction. With matched media (`eta` = 1) there is nothing to scatter: `eval` is 0
/// and `sample` passes straight through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx<T> {
    /// Width of the slope distribution.
    pub alpha: Alpha<T>,
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<T>,
}

impl<T: Real> Ggx<T> {
    /// A boundary of a given width and index.
    pub fn new(alpha: Alpha<T>, eta: RelativeIor<T>) -> Self {
        Self { alpha, eta }
    }

    /// The same boundary in another precision, each parameter rounded once.
    pub fn cast<U: Real>(&self) -> Ggx<U> {
        Ggx { alpha: self.alpha.cast(), eta: self.eta.cast() }
    }
}

impl<T: Real> Ggx<T> {
    /// A facet normal visible from `wi`, and the index of the far medium over that of `wi`'s.
    #[inline(always)]
    fn facet(&self, wi: Direction<T>, u: [T; 2]) -> Option<(Direction<T>, T)> {
        let (front, eta) = match lit(wi)? {
            Side::Air => (wi, self.eta.get()),
            Side::Dielectric => (wi.opposite(), self.eta.inverse()),
        };
        Some((sample_visible(self.alpha, front, u), eta))
    }

    #[inline(always)]
    fn value(&self, wi: Direction<T>, wo: Direction<T>, h: &HalfVector<T>) -> T {
        let a = self.alpha.get();
        let masked = shadow_sum(a, wi.xyz()) * shadow_sum(a, wo.xyz());
        let f = d_of_vector(a, h.xy2, h.z2) * h.share * T::from_f64(4.0) / masked;
        // the quotient of a narrow peak by cosines next to nothing is larger than any number
        if h.possible { f.min(T::MAX) } else { T::ZERO }
    }

    /// [`Bsdf::ars`] for loops over many pairs: a value, and whether it equals that of `ars` to the last bit. If it
    /// does not, as for a few pairs in a hundred, call `ars`.
    ///
    /// `lost(a, b, product)` is `a * b - product`, exactly: [`Real::product_error`], or a fused multiplication where
    /// the processor has one. Pairs with overflow, or with underflow that matters, are left over for `ars`.
    #[inline(always)]
    pub fn ars_or_not(
        &self,
        wi: Direction<T>,
        wo: Direction<T>,
        lost: impl Fn(T, T, T) -> T,
    ) -> (T, bool) {
        let (h, all) = HalfVector::plainly(self.eta, wi, wo, lost);
        (self.value(wi, wo, &h) * wo.z().abs(), all)
    }
}

impl<T: Real> Scatter<T> for Ggx<T> {
    /// Draws a visible normal, then reflects with probability `F`; the weight is `G1(wo)`.
    ///
    /// Takes three uniforms.
    #[inline]
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let u = [uniform(), uniform()];
        let choice = uniform();
        if self.eta.is_matched() {
            return straight(wi);
        }
        let (m, eta) = self.facet(wi, u)?;
        let reflected = fresnel::dielectric(m.dot(wi).abs(), eta).reflected;
        let lobe = if choice < reflected { Lobe::Reflection } else { Lobe::Transmission };
        let ray = facet_ray(wi, m, eta, lobe)?;
        Some(Scattered { wo: ray.wo, weight: g1(self.alpha, ray.wo) })
    }
}

impl<T: Real> Bsdf<T> for Ggx<T> {
    #[inline(always)]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.value(wi, wo, &HalfVector::between(self.eta, wi, wo))
    }

    #[inline(always)]
    fn ars(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.eval(wi, wo) * wo.z().abs()
    }

    #[inline(always)]
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let a = self.alpha.get();
        let h = HalfVector::between(self.eta, wi, wo);
        let p = d_of_vector(a, h.xy2, h.z2) * h.share * T::TWO / shadow_sum(a, wi.xyz());
        if h.possible { p.min(T::MAX) } else { T::ZERO }
    }

    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        if self.eta.is_matched() {
            return straight(wi).filter(|_| lobe == Lobe::Transmission);
        }
        let (m, eta) = self.facet(wi, u)?;
        let ray = facet_ray(wi, m, eta, lobe)?;
        Some(Scattered { wo: ray.wo, weight: ray.weight * g1(self.alpha, ray.wo) })
    }

    fn slope(&self) -> T {
        self.alpha.get()
    }
}

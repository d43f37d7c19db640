//! Rough dielectric of any density of facets, reflection and transmission from both sides.

use super::facet::{facet_ray, lit, straight};
use super::half::HalfVector;
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel;
use crate::math::{Real, special};
use crate::ndf::density::Density;
use crate::quantity::RelativeIor;

/// How the masking of the two directions of a path goes together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Masking {
    /// Independently: `G = G1(i) G1(o)`, as [`super::Ggx`] \[Walter2007, eq. 23\].
    #[default]
    Separable,
    /// By the height of the facet, which both see: `1 / (1 + Li + Lo)` in reflection, and the beta function
    /// `B(1 + Li, 1 + Lo)` in transmission \[Heitz et al. 2016\].
    Correlated,
}

/// A rough dielectric boundary with facets of a density `D`, Smith's masking and exact Fresnel factors.
///
/// `f = D G F / (4 |cos_i cos_o|)` in reflection and \[Walter2007, eq. 21\] in transmission. Light that meets a second
/// facet is left out: it is lost, as in [`super::Ggx`]. With matched media (`eta` = 1) `eval` is 0 and `sample` passes
/// straight through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacet<T, D> {
    /// Density of the facets.
    pub density: D,
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<T>,
    /// How masking goes together.
    pub masking: Masking,
}

impl<T: Real, D: Density<T>> Microfacet<T, D> {
    /// A boundary with given facets and index, and separable masking.
    pub fn new(density: D, eta: RelativeIor<T>) -> Self {
        Self { density, eta, masking: Masking::Separable }
    }

    /// The same boundary with another masking.
    #[must_use]
    pub fn with_masking(self, masking: Masking) -> Self {
        Self { masking, ..self }
    }

    /// The same boundary in another precision, each parameter rounded once.
    pub fn cast<U: Real>(&self) -> Microfacet<U, D::In<U>> {
        Microfacet { density: self.density.cast(), eta: self.eta.cast(), masking: self.masking }
    }

    /// A facet normal visible from `wi`, and the index of the far medium over that of `wi`'s.
    #[inline]
    pub(super) fn facet(&self, wi: Direction<T>, u: [T; 2]) -> Option<(Direction<T>, T)> {
        let (front, eta) = match lit(wi)? {
            Side::Air => (wi, self.eta.get()),
            Side::Dielectric => (wi.opposite(), self.eta.inverse()),
        };
        Some((self.density.sample_visible(front, u), eta))
    }

    /// `D` times all of the facet but masking, 1/sr; 0 if there is none.
    #[inline]
    fn facets(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let h = HalfVector::between(self.eta, wi, wo);
        if !h.possible {
            return T::ZERO;
        }
        let in_two = || HalfVector::squares_in_two(self.eta, wi, wo);
        let vector = || HalfVector::vector_in_two(self.eta, wi, wo);
        let d = self.density.d_of([h.xy2, h.z2], in_two, vector);
        // a density without a bound at 90 degrees is larger than any number there
        (d * h.share).min(T::MAX)
    }

    /// `|cos_i| / G` times what is left of it by the other end: `G = |cos_i cos_o| / joint`.
    #[inline]
    fn joint_area(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let areas = [wi, wo].map(|w| self.density.visible_area(w));
        let [ai, ao] = areas;
        if self.masking == Masking::Separable {
            return ai * ao;
        }
        let [ci, co] = [wi, wo].map(|w| w.z().abs());
        if (wi.z() > T::ZERO) == (wo.z() > T::ZERO) {
            return ai * co + ci * ao - ci * co;
        }
        let [p, q] = [ai / ci, ao / co];
        ci * co / T::from_f64(special::beta(p.to_f64(), q.to_f64()))
    }

    /// Masking of a ray on its way out, if its facet is visible from `wi`: `G / G1(i)`, at most 1.
    pub(super) fn way_out(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        if self.masking == Masking::Separable {
            return self.density.g1(wo);
        }
        let joint = self.joint_area(wi, wo);
        let share = self.density.visible_area(wi) * wo.z().abs() / joint;
        if joint > T::ZERO { share.min(T::ONE) } else { T::ZERO }
    }
}

impl<T: Real, D: Density<T>> Scatter<T> for Microfacet<T, D> {
    /// Draws a visible normal, then reflects with probability `F`; the weight is `G / G1(wi)`.
    ///
    /// Takes three uniforms.
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
        Some(Scattered { wo: ray.wo, weight: self.way_out(wi, ray.wo) })
    }
}

impl<T: Real, D: Density<T>> Bsdf<T> for Microfacet<T, D> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let facets = self.facets(wi, wo);
        // a NaN is no facet
        if facets > T::ZERO { (facets / self.joint_area(wi, wo)).min(T::MAX) } else { T::ZERO }
    }

    #[inline]
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let facets = self.facets(wi, wo);
        if facets > T::ZERO {
            (facets / self.density.visible_area(wi)).min(T::MAX)
        } else {
            T::ZERO
        }
    }

    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        if self.eta.is_matched() {
            return straight(wi).filter(|_| lobe == Lobe::Transmission);
        }
        let (m, eta) = self.facet(wi, u)?;
        let ray = facet_ray(wi, m, eta, lobe)?;
        Some(Scattered { wo: ray.wo, weight: ray.weight * self.way_out(wi, ray.wo) })
    }

    fn slope(&self) -> T {
        self.density.slope()
    }

    fn is_anisotropic(&self) -> bool {
        self.density.is_anisotropic()
    }
}

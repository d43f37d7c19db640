//! The `Normals` method: one facet at each hit, drawn from a density of normals \[Sokolov section 2.2\].

use super::facet::{facet_ray, lit, straight};
use super::half::HalfVector;
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel;
use crate::math::Real;
use crate::ndf::normals::NormalDensity;
use crate::quantity::RelativeIor;

/// A rough dielectric boundary whose facet normal is drawn anew at each hit, with density `p(m)`.
///
/// `ars = p(m) / V(wi) * J * (F or 1 - F)`, where `V` is the share of normals that face `wi` (others are
/// drawn again) and `J` the Jacobian of \[Walter2007, eqs 14 and 17\]. No masking and no interreflection:
/// light meets facets in proportion to their number, not to their projected area, so the law is not reciprocal, and a
/// ray sent back into the surface is lost. This is the published method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normals<T, const N: usize = 256> {
    /// Density of the facet normals.
    pub density: NormalDensity<T, N>,
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<T>,
}

impl<T: Real, const N: usize> Normals<T, N> {
    /// A boundary with given facets and index.
    pub fn new(density: NormalDensity<T, N>, eta: RelativeIor<T>) -> Self {
        Self { density, eta }
    }

    /// The same boundary in another precision, each parameter rounded once.
    pub fn cast<U: Real>(&self) -> Normals<U, N> {
        Normals { density: self.density.cast(), eta: self.eta.cast() }
    }

    /// How often a normal that faces away is drawn again before the ray counts as lost; at least half
    /// of all normals face any direction, so this happens once in 2^64 rays.
    const DRAWS: usize = 64;

    /// Whether normals face this side with a positive cosine, and the far index over the near one.
    fn near_side(&self, side: Side) -> (bool, T) {
        match side {
            Side::Air => (true, self.eta.get()),
            Side::Dielectric => (false, self.eta.inverse()),
        }
    }

    /// The share of the normals that face `w`.
    fn visible(&self, w: Direction<T>) -> T {
        let [x, y, z] = w.xyz();
        self.density.visible(z, (x * x + y * y).sqrt())
    }
}

impl<T: Real, const N: usize> Scatter<T> for Normals<T, N> {
    /// Takes two uniforms for each normal drawn, and one to choose between reflection and refraction.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let side = lit(wi)?;
        if self.eta.is_matched() {
            return straight(wi);
        }
        let (above, eta) = self.near_side(side);
        let m = (0..Self::DRAWS)
            .map(|_| self.density.sample([uniform(), uniform()]))
            .find(|m| (m.dot(wi) > T::ZERO) == above)?;
        let reflect = uniform() < fresnel::dielectric(m.dot(wi).abs(), eta).reflected;
        let lobe = if reflect { Lobe::Reflection } else { Lobe::Transmission };
        let ray = facet_ray(wi, m, eta, lobe)?;
        Some(Scattered { wo: ray.wo, weight: T::ONE })
    }
}

impl<T: Real, const N: usize> Bsdf<T> for Normals<T, N> {
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let cos = wo.z().abs();
        // The law is finite, its quotient by a vanishing cosine need not be.
        if cos > T::ZERO { (self.ars(wi, wo) / cos).min(T::MAX) } else { T::ZERO }
    }

    fn ars(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let h = HalfVector::between(self.eta, wi, wo);
        if !h.possible {
            return T::ZERO;
        }
        let visible = self.visible(wi);
        let in_two = || HalfVector::squares_in_two(self.eta, wi, wo);
        let facet = self.density.twice_of_squares(h.xy2, h.z2, in_two);
        // share / |wi.m|, with |wi.m| = cosine / 2 |h|
        facet * h.share * (h.xy2 + h.z2).sqrt() / (visible * h.cosine)
    }

    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.ars(wi, wo)
    }

    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        if self.eta.is_matched() {
            return straight(wi).filter(|_| lobe == Lobe::Transmission);
        }
        let (above, eta) = self.near_side(lit(wi)?);
        let m = self.density.sample(u);
        // Normals that face away are not drawn again, but weighted: zero for them, 1 / V for the rest.
        if (m.dot(wi) > T::ZERO) != above {
            return None;
        }
        let ray = facet_ray(wi, m, eta, lobe)?;
        Some(Scattered { wo: ray.wo, weight: ray.weight / self.visible(wi) })
    }

    fn slope(&self) -> T {
        // tan would run away at pi/2; a width of the law is an angle, and small ones are slopes
        self.density.law().delta().min(T::ONE) + self.density.law().centre()
    }
}

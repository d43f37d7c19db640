//! The first bounce: one facet, masked on the way in and out at the same height.

use crate::bsdf::facet::lit;
use crate::bsdf::half::HalfVector;
use crate::bsdf::microfacet::{Masking, Microfacet};
use crate::bsdf::{Bsdf, Ggx};
use crate::direction::{Direction, Side};
use crate::math::{Real, joint};
use crate::ndf::density::Density;
use crate::ndf::ggx::{d_of_vector, sample_visible};
use crate::ndf::ggx_facets::GgxFacets;
use crate::quantity::RelativeIor;

/// A law of facets of which [`super::AllBounces`] takes the first bounce, with height-correlated masking
/// \[Heitz et al. 2016\].
pub trait FirstBounce<T: Real>: Copy {
    /// The same law in another precision.
    type In<U: Real>: FirstBounce<U>;
    /// Its facets in double precision.
    type Facets: Density<f64>;

    /// The facets, for what is computed once.
    fn facets(&self) -> Self::Facets;

    /// Index of the dielectric over that of the air.
    fn eta(&self) -> RelativeIor<T>;

    /// The BSDF of the first bounce in 1/sr, without cosine.
    fn first(&self, wi: Direction<T>, wo: Direction<T>) -> T;

    /// A facet normal visible from `wi`, and the index of the far medium over that of `wi`'s.
    fn facet(&self, wi: Direction<T>, u: [T; 2]) -> Option<(Direction<T>, T)>;

    /// The share of the light sent to `wo` by a facet visible from `wi` that meets no other facet.
    fn way_out(&self, wi: Direction<T>, wo: Direction<T>) -> T;

    /// Typical slope of the facets.
    fn slope(&self) -> T;

    /// The same law in another precision, each parameter rounded once.
    fn cast<U: Real>(&self) -> Self::In<U>;
}

impl<T: Real, D: Density<T>> FirstBounce<T> for Microfacet<T, D> {
    type In<U: Real> = Microfacet<U, D::In<U>>;
    type Facets = D::In<f64>;

    fn facets(&self) -> D::In<f64> {
        self.density.cast()
    }

    fn eta(&self) -> RelativeIor<T> {
        self.eta
    }

    #[inline]
    fn first(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.with_masking(Masking::Correlated).eval(wi, wo)
    }

    #[inline]
    fn facet(&self, wi: Direction<T>, u: [T; 2]) -> Option<(Direction<T>, T)> {
        Microfacet::facet(self, wi, u)
    }

    fn way_out(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        Microfacet::way_out(&self.with_masking(Masking::Correlated), wi, wo)
    }

    fn slope(&self) -> T {
        self.density.slope()
    }

    fn cast<U: Real>(&self) -> Microfacet<U, D::In<U>> {
        Microfacet::cast(self)
    }
}

/// `Lambda` of both directions, each times twice the other's cosine as well as its own: no quotient.
struct Masked<T> {
    cosines: [T; 2],
    roots: [T; 2],
}

impl<T: Real> Masked<T> {
    #[inline(always)]
    fn of(a: T, wi: Direction<T>, wo: Direction<T>) -> Self {
        let root = |w: Direction<T>| {
            let [x, y, z] = w.xyz();
            (z * z + a * a * (x * x + y * y)).sqrt()
        };
        Self { cosines: [wi.z().abs(), wo.z().abs()], roots: [root(wi), root(wo)] }
    }

    /// `1 / ((1 + Li + Lo) |cos_i cos_o|)`.
    #[inline(always)]
    fn mirrored(&self) -> T {
        let ([ci, co], [ri, ro]) = (self.cosines, self.roots);
        T::TWO / (ri * co + ci * ro)
    }

    /// `B(1 + Li, 1 + Lo) / |cos_i cos_o|`.
    #[inline(always)]
    fn crossed(&self) -> T {
        let ([ci, co], [ri, ro]) = (self.cosines, self.roots);
        // 2 cos Lambda
        let [li, lo] = [ri - ci, ro - co];
        let both = T::HALF / (ci * co);
        let (sum, product) = ((li * co + lo * ci) * both, T::HALF * li * lo * both);
        let separate = (ri + ci) * (ro + co);
        let four = T::from_f64(4.0);
        if let Some(inverse) = joint::near(sum, product) {
            return four / (separate * inverse);
        }
        let [i, o] = [li / (ci + ci), lo / (co + co)];
        four * joint::far(i, o) / separate
    }
}

impl<T: Real> FirstBounce<T> for Ggx<T> {
    type In<U: Real> = Ggx<U>;
    type Facets = GgxFacets<f64>;

    fn facets(&self) -> GgxFacets<f64> {
        GgxFacets::new(self.alpha.cast())
    }

    fn eta(&self) -> RelativeIor<T> {
        self.eta
    }

    #[inline(always)]
    fn first(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let a = self.alpha.get();
        let h = HalfVector::between(self.eta, wi, wo);
        if !h.possible {
            return T::ZERO;
        }
        let masked = Masked::of(a, wi, wo);
        let mirrored = (wi.z() > T::ZERO) == (wo.z() > T::ZERO);
        let masking = if mirrored { masked.mirrored() } else { masked.crossed() };
        (d_of_vector(a, h.xy2, h.z2) * h.share * masking).min(T::MAX)
    }

    #[inline]
    fn facet(&self, wi: Direction<T>, u: [T; 2]) -> Option<(Direction<T>, T)> {
        let (front, eta) = match lit(wi)? {
            Side::Air => (wi, self.eta.get()),
            Side::Dielectric => (wi.opposite(), self.eta.inverse()),
        };
        Some((sample_visible(self.alpha, front, u), eta))
    }

    fn way_out(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let masked = Masked::of(self.alpha.get(), wi, wo);
        let ([ci, co], [ri, _]) = (masked.cosines, masked.roots);
        let mirrored = (wi.z() > T::ZERO) == (wo.z() > T::ZERO);
        let joint = if mirrored { masked.mirrored() } else { masked.crossed() };
        // G over G1 of the way in
        let share = joint * co * T::HALF * (ri + ci);
        if share > T::ZERO { share.min(T::ONE) } else { T::ZERO }
    }

    fn slope(&self) -> T {
        self.alpha.get()
    }

    fn cast<U: Real>(&self) -> Ggx<U> {
        Ggx::cast(self)
    }
}

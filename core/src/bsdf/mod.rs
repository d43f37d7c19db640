//! Scattering laws of a boundary.
//!
//! A boundary has the air above (z > 0) and a dielectric of relative index `eta` below, or is opaque.
//! Flux transport: no `eta^2` of radiance, so the integral of [`Bsdf::ars`] over all `wo` is the
//! scattered fraction of the flux, at most 1; reciprocity reads `f(i,o) / n_o^2 = f(o,i) / n_i^2`.

#[cfg(all(feature = "ggx", feature = "microfacet"))]
mod bounces;
mod lobe_set;
#[cfg(any(feature = "ggx", feature = "normals", feature = "tails"))]
mod facet;
#[cfg(feature = "ggx")]
mod ggx;
#[cfg(any(feature = "ggx", feature = "normals", feature = "table"))]
mod half;
#[cfg(any(feature = "normals", feature = "tails"))]
mod lambert;
#[cfg(feature = "microfacet")]
mod microfacet;
#[cfg(any(feature = "normals", feature = "tails"))]
mod mix;
#[cfg(feature = "normals")]
mod normals;
#[cfg(feature = "ggx")]
mod opaque;
mod smooth;
#[cfg(feature = "tails")]
pub mod tail;
#[cfg(feature = "microfacet")]
mod walk;
#[cfg(all(test, feature = "ggx", feature = "normals", feature = "fast"))]
mod tests_cast;

#[cfg(all(feature = "ggx", feature = "microfacet"))]
pub use bounces::{AllBounces, COMPENSATION_NUMBERS, Compensation, FirstBounce, LaterFlux};
#[cfg(feature = "ggx")]
pub use ggx::Ggx;
#[cfg(any(feature = "normals", feature = "tails"))]
pub use lambert::{Backing, Lambert};
pub use lobe_set::LobeSet;
#[cfg(feature = "microfacet")]
pub use microfacet::{Masking, Microfacet};
#[cfg(any(feature = "normals", feature = "tails"))]
pub use mix::{Mix, MixShares};
#[cfg(feature = "normals")]
pub use normals::Normals;
#[cfg(feature = "ggx")]
pub use opaque::OpaqueGgx;
pub use smooth::Smooth;
#[cfg(feature = "tails")]
pub use tail::ShiftInvariant;
#[cfg(feature = "microfacet")]
pub use walk::{Walk, Walked};

#[cfg(feature = "table")]
pub(crate) use half::HalfVector;

use crate::direction::Direction;
use crate::math::Real;

/// A scattered ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered<T: Real> {
    /// Direction, away from the surface, on either side.
    pub wo: Direction<T>,
    /// The flux the ray carries away for unit flux in: `ars / pdf`, at most 1 from `sample` of a dielectric.
    pub weight: T,
}

/// Fluxes of the light that keeps its direction at a boundary, as fractions of the incident flux.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoherentFlux<T> {
    /// Specularly reflected.
    pub reflected: T,
    /// Refracted by Snell's law.
    pub transmitted: T,
}

/// One of the two sides to which light leaves a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// Back to the side the light came from.
    Reflection,
    /// Through to the other side.
    Transmission,
}

/// Something that scatters rays: the least that a method provides.
pub trait Scatter<T: Real> {
    /// Scatters light that came from `wi`; `None` if the ray is lost (a facet sent it into the surface).
    ///
    /// `uniform` gives independent uniforms in [0, 1); the law determines how many it takes.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>>;
}

impl<T: Real, S: Scatter<T>> Scatter<T> for &S {
    #[inline(always)]
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        (**self).sample(wi, uniform)
    }
}

/// A scattering law with a value.
pub trait Bsdf<T: Real>: Scatter<T> {
    /// The BSDF `f(wi, wo)` in 1/sr, without cosine; 0 if either direction lies in the surface.
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T;

    /// Angle-resolved scatter `f |cos theta_o|` in 1/sr: scattered flux per solid angle, for unit flux in.
    fn ars(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.eval(wi, wo) * wo.z().abs()
    }

    /// Density of [`Scatter::sample`] at `wo`, per solid angle, in 1/sr.
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T;

    /// Draws a ray into one lobe from two uniforms in [0, 1). The result is smooth in them: no path is chosen at random.
    ///
    /// The weight carries the Fresnel share, so its mean over the uniforms is the flux of the lobe.
    /// `None` is a weight of zero. For rules that integrate over the uniforms.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>>;

    /// Typical slope of the facets: a length scale for quadrature, not a physical quantity.
    fn slope(&self) -> T;

    /// Whether values depend on the azimuth of the light, not only on its difference from that of `wo`.
    fn is_anisotropic(&self) -> bool {
        false
    }

    /// The light from `wi` that keeps its direction: samples include it, values and densities do not.
    fn coherent_flux(&self, _wi: Direction<T>) -> CoherentFlux<T> {
        CoherentFlux { reflected: T::ZERO, transmitted: T::ZERO }
    }
}

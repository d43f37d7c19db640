//! The smooth boundary: mirror and Snell directions only.

use super::{Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel::{self, Fresnel};
use crate::math::Real;
use crate::quantity::RelativeIor;

/// A smooth dielectric boundary: the back face of a plate, and the limit of every rough one.
///
/// Its BSDF is a pair of delta functions, so it has no value to evaluate, only fluxes and rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth<T> {
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<T>,
}

impl<T: Real> Smooth<T> {
    /// The same boundary in another precision, its index rounded once.
    pub fn cast<U: Real>(&self) -> Smooth<U> {
        Smooth { eta: self.eta.cast() }
    }

    /// Index of the far medium over that of the side `w` is on.
    #[inline(always)]
    fn relative(&self, side: Side) -> T {
        match side {
            Side::Air => self.eta.get(),
            Side::Dielectric => self.eta.inverse(),
        }
    }

    /// Reflected and transmitted flux for light from `wi`; a grazing ray is reflected.
    #[inline]
    pub fn fresnel(&self, wi: Direction<T>) -> Fresnel<T> {
        match wi.side() {
            Some(side) => fresnel::dielectric(wi.z().abs(), self.relative(side)),
            None => Fresnel { reflected: T::ONE, transmitted: T::ZERO },
        }
    }

    /// The transmitted direction by Snell's law; `None` on total reflection.
    #[inline]
    pub fn refract(&self, wi: Direction<T>) -> Option<Direction<T>> {
        wi.refract(Direction::normal(), self.relative(wi.side()?))
    }

    /// Reflected share of the flux from `wi`, and the transmitted direction; `None` for a grazing ray.
    #[inline]
    pub fn facet(&self, wi: Direction<T>) -> Option<(T, Option<Direction<T>>)> {
        Some(fresnel::facet(wi, Direction::normal(), self.relative(wi.side()?)))
    }

    /// The mirror direction.
    #[inline]
    pub fn reflect(&self, wi: Direction<T>) -> Direction<T> {
        let [x, y, z] = wi.xyz();
        Direction::from_unit(-x, -y, z)
    }
}

impl<T: Real> Scatter<T> for Smooth<T> {
    /// Takes one uniform.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let reflected = self.fresnel(wi).reflected;
        let wo = if uniform() < reflected { self.reflect(wi) } else { self.refract(wi)? };
        Some(Scattered { wo, weight: T::ONE })
    }
}

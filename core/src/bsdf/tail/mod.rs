//! Scatter about the specular direction that depends on the difference of direction cosines alone: the laws that optical
//! design programs take.
//!
//! With directions away from the surface and their components along it, `s`, light from `wi` is specular at
//! `n_o s_o = -n_i s_i`, in reflection and in transmission, and `x = |n_i s_i + n_o s_o|` is the distance from there. The law is
//! `f = n_o^2 shape(x)`: reciprocal, and in a body with air on both sides (`eta` = 1) just the shape. What is not scattered
//! keeps its direction.

mod disc;
mod shape;

pub use shape::{Shape, ShapeError};

use disc::Disc;

use super::facet::lit;
use super::{Bsdf, CoherentFlux, Lobe, Scatter, Scattered, Smooth};
use crate::direction::{Direction, Side};
use crate::math::Real;
use crate::quantity::RelativeIor;
use crate::scope;

/// A sheet, or a face of a dielectric, that scatters into one lobe about the specular direction.
///
/// A sheet (`eta` = 1) has air on both sides and sends all that it does not scatter on into the same lobe. A face between
/// two media sends what it does not scatter by Fresnel's shares, as far as that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftInvariant<T> {
    shape: Shape<T>,
    lobe: Lobe,
    eta: RelativeIor<T>,
    specular: Option<T>,
}

impl<T: Real> ShiftInvariant<T> {
    /// Scatter of a shape into one lobe. Without a share that stays `specular` all the rest does; with one, what is neither
    /// is lost.
    ///
    /// # Errors
    /// A parameter outside its domain; more light than there is, at normal incidence, where a shape that falls scatters most.
    pub fn new(
        shape: Shape<T>,
        lobe: Lobe,
        eta: RelativeIor<T>,
        specular: Option<T>,
    ) -> Result<Self, ShapeError> {
        shape.check()?;
        let law = Self { shape, lobe, eta, specular };
        let share = specular.map_or(0.0, Real::to_f64);
        if !(0.0..=1.0).contains(&share) {
            let domain =
                ShapeError::OutOfDomain { name: "specular", value: share, least: 0.0, most: 1.0 };
            return Err(domain);
        }
        let both = [Side::Air, Side::Dielectric].map(|side| law.most_scattered(side));
        let scattered = Real::max(both[0], both[1]) + share;
        // a millionth more is rounding of parameters in files
        if scattered <= 1.0 + 1e-6 { Ok(law) } else { Err(ShapeError::TooMuch { scattered }) }
    }

    /// The shape.
    pub fn shape(&self) -> &Shape<T> {
        &self.shape
    }

    /// The lobe that light is scattered into.
    pub fn lobe(&self) -> Lobe {
        self.lobe
    }

    /// Index of the far medium over that of the air; 1 for a sheet.
    pub fn eta(&self) -> RelativeIor<T> {
        self.eta
    }

    /// The same law in another precision, each number rounded once.
    pub fn cast<U: Real>(&self) -> ShiftInvariant<U> {
        ShiftInvariant {
            shape: self.shape.cast(),
            lobe: self.lobe,
            eta: self.eta.cast(),
            specular: self.specular.map(|s| U::from_f64(s.to_f64())),
        }
    }

    /// Total integrated scatter: the share of the light from `wi` that is scattered, 0 to 1.
    pub fn scattered(&self, wi: Direction<T>) -> T {
        let total = self.disc(wi).map_or(0.0, |(disc, _)| self.total(&disc, wi));
        T::from_f64(total)
    }

    /// The same at normal incidence.
    fn most_scattered(&self, side: Side) -> f64 {
        let disc = Disc { shape: self.shape.cast(), centre: 0.0, rim: self.index(self.far(side)) };
        disc.total(self.shape.is_oblique())
    }

    fn total(&self, disc: &Disc, wi: Direction<T>) -> f64 {
        let oblique = self.shape.is_oblique();
        let cos = if oblique { Real::abs(wi.z().to_f64()) } else { 1.0 };
        Real::min(cos * disc.total(oblique), 1.0)
    }

    fn index(&self, side: Side) -> f64 {
        match side {
            Side::Air => 1.0,
            Side::Dielectric => self.eta.get().to_f64(),
        }
    }

    /// The side that light from `side` is scattered to.
    fn far(&self, side: Side) -> Side {
        match (self.lobe, side) {
            (Lobe::Reflection, side) => side,
            (Lobe::Transmission, Side::Air) => Side::Dielectric,
            (Lobe::Transmission, Side::Dielectric) => Side::Air,
        }
    }

    /// The disc of the directions that light from `wi` is scattered to, and their side; `None` if this build has none.
    fn disc(&self, wi: Direction<T>) -> Option<(Disc, Side)> {
        let side = lit(wi)?;
        if !scope::lobe(self.lobe == Lobe::Reflection) {
            return None;
        }
        let far = self.far(side);
        let [x, y] = [wi.x(), wi.y()].map(Real::to_f64);
        let centre = self.index(side) * Real::sqrt(x * x + y * y);
        Some((Disc { shape: self.shape.cast(), centre, rim: self.index(far) }, far))
    }

    /// The direction at a point of the disc.
    fn towards(wi: Direction<T>, far: Side, rim: f64, [along, across]: [f64; 2]) -> Direction<T> {
        let [x, y] = [wi.x(), wi.y()].map(Real::to_f64);
        let sin = Real::sqrt(x * x + y * y);
        let [ux, uy] = if sin > 0.0 { [-x / sin, -y / sin] } else { [1.0, 0.0] };
        let [sx, sy] = [(along * ux - across * uy) / rim, (along * uy + across * ux) / rim];
        let cos = Real::sqrt_positive(1.0 - sx * sx - sy * sy);
        let z = T::from_f64(cos).max(T::MIN_POSITIVE);
        let z = if far == Side::Air { z } else { T::ZERO - z };
        Direction::from_unit(T::from_f64(sx), T::from_f64(sy), z)
    }

    /// Where light goes through without being scattered; `None` on total reflection.
    fn straight_on(&self, wi: Direction<T>) -> Option<Direction<T>> {
        if self.eta.is_matched() {
            Some(wi.opposite())
        } else {
            Smooth { eta: self.eta }.refract(wi)
        }
    }

    /// What keeps its direction if `scattered` does not.
    fn kept(&self, wi: Direction<T>, scattered: T) -> CoherentFlux<T> {
        let left = (T::ONE - scattered).max(T::ZERO);
        let mine = self.specular.map_or(left, |share| share.min(left));
        if self.eta.is_matched() {
            return match self.lobe {
                Lobe::Reflection => CoherentFlux { reflected: mine, transmitted: T::ZERO },
                Lobe::Transmission => CoherentFlux { reflected: T::ZERO, transmitted: mine },
            };
        }
        let smooth = Smooth { eta: self.eta }.fresnel(wi);
        match (self.lobe, self.specular) {
            (Lobe::Transmission, None) => {
                let reflected = smooth.reflected.min(left);
                CoherentFlux { reflected, transmitted: left - reflected }
            }
            (Lobe::Transmission, Some(_)) => {
                let transmitted = mine.min(smooth.transmitted);
                let reflected = smooth.reflected.min(left - transmitted);
                CoherentFlux { reflected, transmitted }
            }
            (Lobe::Reflection, None) => {
                let transmitted = smooth.transmitted.min(left);
                CoherentFlux { reflected: left - transmitted, transmitted }
            }
            (Lobe::Reflection, Some(_)) => {
                let transmitted = smooth.transmitted.min(left - mine);
                CoherentFlux { reflected: mine, transmitted }
            }
        }
    }
}

/// Draws of a direction whose cosine is a factor, before the ray counts as lost.
const DRAWS: usize = 64;

impl<T: Real> Scatter<T> for ShiftInvariant<T> {
    /// Takes three uniforms; more where cosines are factors of the shape.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let (disc, far) = self.disc(wi)?;
        let choice = uniform();
        let scattered = T::from_f64(self.total(&disc, wi));
        if choice < scattered {
            for _ in 0..DRAWS {
                let [u, v] = [uniform(), uniform()].map(Real::to_f64);
                let wo = Self::towards(wi, far, disc.rim, disc.point(disc.distance(u), v));
                if !self.shape.is_oblique() || uniform() < wo.z().abs() {
                    return Some(Scattered { wo, weight: T::ONE });
                }
            }
            return None;
        }
        let kept = self.kept(wi, scattered);
        let smooth = Smooth { eta: self.eta };
        let left = choice - scattered;
        if left < kept.reflected {
            Some(Scattered { wo: smooth.reflect(wi), weight: T::ONE })
        } else if left < kept.reflected + kept.transmitted {
            self.straight_on(wi).map(|wo| Scattered { wo, weight: T::ONE })
        } else {
            None
        }
    }
}

impl<T: Real> Bsdf<T> for ShiftInvariant<T> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (Some(side), Some(far)) = (lit(wi), wo.side()) else { return T::ZERO };
        if far != self.far(side) || !scope::lobe(self.lobe == Lobe::Reflection) {
            return T::ZERO;
        }
        let index = |side| if side == Side::Air { T::ONE } else { self.eta.get() };
        let (near, n) = (index(side), index(far));
        let [dx, dy] = [near * wi.x() + n * wo.x(), near * wi.y() + n * wo.y()];
        let mut value = n * n * self.shape.value(dx * dx + dy * dy);
        if self.shape.is_oblique() {
            value = value * (wi.z() * wo.z()).abs();
        }
        // a NaN is no light
        if value > T::ZERO { value.min(T::MAX) } else { T::ZERO }
    }

    /// Of the scattered light alone; what keeps its direction has no density.
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.ars(wi, wo)
    }

    /// What keeps its direction comes at the end of the first uniform.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let (disc, far) = self.disc(wi)?;
        let kept = self.kept(wi, T::from_f64(self.total(&disc, wi)));
        let (kept, wo) = match lobe {
            Lobe::Reflection => (kept.reflected, Some(Smooth { eta: self.eta }.reflect(wi))),
            Lobe::Transmission => (kept.transmitted, self.straight_on(wi)),
        };
        let oblique = self.shape.is_oblique();
        let cos = if oblique { wi.z().abs() } else { T::ONE };
        let scattered =
            if lobe == self.lobe { T::from_f64(disc.total(false)) * cos } else { T::ZERO };
        let all = scattered + kept;
        let place = u[0] * all;
        if place >= scattered {
            return wo.filter(|_| kept > T::ZERO).map(|wo| Scattered { wo, weight: all });
        }
        let [share, across] = [place / scattered, u[1]].map(Real::to_f64);
        let wo = Self::towards(wi, far, disc.rim, disc.point(disc.distance(share), across));
        let weight = if oblique { all * wo.z().abs() } else { all };
        Some(Scattered { wo, weight })
    }

    /// The slope of facets that would scatter as far.
    fn slope(&self) -> T {
        let bend = match self.lobe {
            Lobe::Reflection => T::TWO,
            Lobe::Transmission if self.eta.is_matched() => T::ONE,
            Lobe::Transmission => (self.eta.get() - T::ONE).abs().max(T::from_f64(1e-3)),
        };
        self.shape.width() / bend
    }

    fn coherent_flux(&self, wi: Direction<T>) -> CoherentFlux<T> {
        let Some((disc, _)) = self.disc(wi) else {
            return CoherentFlux { reflected: T::ZERO, transmitted: T::ZERO };
        };
        self.kept(wi, T::from_f64(self.total(&disc, wi)))
    }
}

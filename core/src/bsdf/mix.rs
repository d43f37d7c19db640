//! Several laws side by side on one surface.

use super::facet::lit;
use super::{Backing, Bsdf, CoherentFlux, Lambert, Lobe, Scatter, Scattered, Smooth};
use crate::direction::Direction;
use crate::fresnel::Fresnel;
use crate::math::Real;
use crate::scope;

/// The shares of a surface that do not follow the first law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MixShares<T> {
    /// Follows the second law.
    pub second: T,
    /// Is smooth: light keeps its direction.
    pub specular: T,
    /// Is diffuse ([`Lambert`]).
    pub lambert: T,
}

/// A surface of areas that are larger than the relief: a share of it follows each law, `f = s1 f1 + s2 f2 + d lambert`, and a
/// share is smooth.
///
/// Light meets one area only, so that reciprocity and the balance of energy are those of the laws. The first law has what the
/// shares leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix<T, A, B> {
    first: A,
    second: Option<B>,
    shares: MixShares<T>,
    lambert: Lambert<T>,
}

impl<T: Real, A, B> Mix<T, A, B> {
    /// Of two laws, or of one and what is specular or diffuse beside it; `None` unless each share is from 0 to 1, all
    /// together are at most 1, and the second has no share without a law.
    pub fn new(
        backing: Backing<T>,
        first: A,
        second: Option<B>,
        shares: MixShares<T>,
    ) -> Option<Self> {
        let MixShares { second: s, specular, lambert } = shares;
        let is_share = |x: T| x >= T::ZERO && x <= T::ONE;
        // a millionth more is rounding of parameters in files
        let fits = s + specular + lambert <= T::ONE + T::from_f64(1e-6);
        let fine = is_share(s) && is_share(specular) && is_share(lambert) && fits;
        (fine && (second.is_some() || s <= T::ZERO)).then(|| Self {
            first,
            second,
            shares,
            lambert: Lambert::new(backing),
        })
    }

    /// The first law.
    pub fn first(&self) -> &A {
        &self.first
    }

    /// The second law.
    pub fn second(&self) -> Option<&B> {
        self.second.as_ref()
    }

    /// What is behind the surface.
    pub fn backing(&self) -> Backing<T> {
        self.lambert.backing()
    }

    /// The diffuse lobe of an area.
    pub fn lambert(&self) -> &Lambert<T> {
        &self.lambert
    }

    /// The shares of all but the first law.
    pub fn shares(&self) -> MixShares<T> {
        self.shares
    }

    /// The share of the first law.
    pub fn first_share(&self) -> T {
        let MixShares { second, specular, lambert } = self.shares;
        (T::ONE - second - specular - lambert).max(T::ZERO)
    }

    /// The same of other laws, in any precision.
    pub fn map<U: Real, C, D>(
        &self,
        first: impl FnOnce(&A) -> C,
        second: impl FnOnce(&B) -> D,
    ) -> Mix<U, C, D> {
        let cast = |x: T| U::from_f64(x.to_f64());
        let MixShares { second: s, specular, lambert } = self.shares;
        Mix {
            first: first(&self.first),
            second: self.second.as_ref().map(second),
            shares: MixShares { second: cast(s), specular: cast(specular), lambert: cast(lambert) },
            lambert: self.lambert.cast(),
        }
    }

    /// Fluxes of a smooth area.
    pub fn smooth(&self, wi: Direction<T>) -> CoherentFlux<T> {
        if lit(wi).is_none() {
            return none();
        }
        let Fresnel { reflected, transmitted } = match self.backing() {
            Backing::Dielectric(eta) => Smooth { eta }.fresnel(wi),
            Backing::Air(Lobe::Transmission) => Fresnel { reflected: T::ZERO, transmitted: T::ONE },
            Backing::Opaque if wi.z() < T::ZERO => return none(),
            Backing::Air(Lobe::Reflection) | Backing::Opaque => {
                Fresnel { reflected: T::ONE, transmitted: T::ZERO }
            }
        };
        let kept = |lobe, flux| if scope::lobe(lobe == Lobe::Reflection) { flux } else { T::ZERO };
        CoherentFlux {
            reflected: kept(Lobe::Reflection, reflected),
            transmitted: kept(Lobe::Transmission, transmitted),
        }
    }

    /// Where a smooth area sends light.
    fn kept(&self, wi: Direction<T>, lobe: Lobe) -> Option<Direction<T>> {
        match (lobe, self.backing()) {
            (Lobe::Reflection, _) => {
                let [x, y, z] = wi.xyz();
                Some(Direction::from_unit(T::ZERO - x, T::ZERO - y, z))
            }
            (Lobe::Transmission, Backing::Dielectric(eta)) if !eta.is_matched() => {
                Smooth { eta }.refract(wi)
            }
            (Lobe::Transmission, _) => Some(wi.opposite()),
        }
    }
}

impl<T: Real, A: Bsdf<T>, B: Bsdf<T>> Mix<T, A, B> {
    /// A sum over the lobes that have values.
    #[inline]
    fn sum(&self, first: impl FnOnce(&A) -> T, second: impl FnOnce(&B) -> T, lambert: T) -> T {
        let mut sum = self.first_share() * first(&self.first) + self.shares.lambert * lambert;
        if let Some(law) = &self.second {
            sum = sum + self.shares.second * second(law);
        }
        sum.min(T::MAX)
    }

    /// A ray of a law, with the weight that it has among all: every law may have sent it.
    fn among(&self, wi: Direction<T>, ray: Scattered<T>, kept: CoherentFlux<T>) -> Scattered<T> {
        // what keeps its direction has no density, and laws that keep some have weights of 1
        if kept.reflected + kept.transmitted > T::ZERO {
            return ray;
        }
        let (value, density) = (self.eval(wi, ray.wo), self.pdf(wi, ray.wo));
        // where a peak is larger than any number its law knows better
        if value < T::MAX && density < T::MAX && density > T::ZERO {
            Scattered { weight: value * ray.wo.z().abs() / density, ..ray }
        } else {
            ray
        }
    }
}

impl<T: Real, A: Bsdf<T>, B: Bsdf<T>> Scatter<T> for Mix<T, A, B> {
    /// Takes one uniform to choose an area, and those of its law.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let MixShares { second, specular, lambert } = self.shares;
        let mut left = uniform();
        if left < specular {
            let kept = self.smooth(wi);
            let u = uniform();
            let lobe = if u < kept.reflected {
                Lobe::Reflection
            } else if u < kept.reflected + kept.transmitted {
                Lobe::Transmission
            } else {
                return None;
            };
            return self.kept(wi, lobe).map(|wo| Scattered { wo, weight: T::ONE });
        }
        left = left - specular;
        if left < lambert {
            let ray = self.lambert.sample(wi, uniform)?;
            return Some(self.among(wi, ray, none()));
        }
        left = left - lambert;
        if let Some(law) = self.second.as_ref().filter(|_| left < second) {
            let ray = law.sample(wi, uniform)?;
            return Some(self.among(wi, ray, law.coherent_flux(wi)));
        }
        let ray = self.first.sample(wi, uniform)?;
        Some(self.among(wi, ray, self.first.coherent_flux(wi)))
    }
}

impl<T: Real, A: Bsdf<T>, B: Bsdf<T>> Bsdf<T> for Mix<T, A, B> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.sum(|law| law.eval(wi, wo), |law| law.eval(wi, wo), self.lambert.eval(wi, wo))
    }

    /// Of the scattered light; what keeps its direction has no density.
    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.sum(|law| law.pdf(wi, wo), |law| law.pdf(wi, wo), self.lambert.pdf(wi, wo))
    }

    /// Each law has a part of the first uniform, as large as its share.
    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let MixShares { second, specular, lambert } = self.shares;
        let [u0, u1] = u;
        let first = self.first_share();
        let mut left = u0;
        if left < first {
            return self.first.sample_lobe(wi, lobe, [left / first, u1]);
        }
        left = left - first;
        if let Some(law) = &self.second {
            if left < second {
                return law.sample_lobe(wi, lobe, [left / second, u1]);
            }
            left = left - second;
        }
        if left < lambert {
            return self.lambert.sample_lobe(wi, lobe, [left / lambert, u1]);
        }
        // rounding may leave a little
        if specular <= T::ZERO {
            return None;
        }
        let kept = self.smooth(wi);
        let weight = match lobe {
            Lobe::Reflection => kept.reflected,
            Lobe::Transmission => kept.transmitted,
        };
        self.kept(wi, lobe).filter(|_| weight > T::ZERO).map(|wo| Scattered { wo, weight })
    }

    /// That of the narrowest lobe.
    fn slope(&self) -> T {
        let second = self.second.as_ref().filter(|_| self.shares.second > T::ZERO);
        let first = self.first.slope();
        second.map_or(first, |law| law.slope().min(first))
    }

    fn is_anisotropic(&self) -> bool {
        self.first.is_anisotropic() || self.second.as_ref().is_some_and(Bsdf::is_anisotropic)
    }

    fn coherent_flux(&self, wi: Direction<T>) -> CoherentFlux<T> {
        let mut sum = none();
        let mut add = |share: T, flux: CoherentFlux<T>| {
            sum.reflected = sum.reflected + share * flux.reflected;
            sum.transmitted = sum.transmitted + share * flux.transmitted;
        };
        add(self.first_share(), self.first.coherent_flux(wi));
        if let Some(law) = &self.second {
            add(self.shares.second, law.coherent_flux(wi));
        }
        if self.shares.specular > T::ZERO {
            add(self.shares.specular, self.smooth(wi));
        }
        sum
    }
}

/// No light that keeps its direction.
fn none<T: Real>() -> CoherentFlux<T> {
    CoherentFlux { reflected: T::ZERO, transmitted: T::ZERO }
}

//! Light that forgot where it came from: the diffuse lobe of a surface.

use super::facet::lit;
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel;
use crate::math::Real;
use crate::quadrature::gauss_legendre;
use crate::quantity::RelativeIor;
use crate::sampling::cosine_hemisphere;
use crate::scope;

/// What lies behind a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Backing<T> {
    /// A clear dielectric of this index over that of air.
    Dielectric(RelativeIor<T>),
    /// Air again: a sheet, that sends all light into one lobe.
    Air(Lobe),
    /// Nothing that light enters; from the inside there is none.
    Opaque,
}

impl<T: Real> Backing<T> {
    /// The same in another precision.
    pub fn cast<U: Real>(&self) -> Backing<U> {
        match self {
            Self::Dielectric(eta) => Backing::Dielectric(eta.cast()),
            Self::Air(lobe) => Backing::Air(*lobe),
            Self::Opaque => Backing::Opaque,
        }
    }
}

/// Shares of light that go to either lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Split<T> {
    reflected: T,
    transmitted: T,
}

impl<T: Real> Split<T> {
    /// From the reflected share; the rest passes.
    fn of(reflected: f64) -> Self {
        Self { reflected: T::from_f64(reflected), transmitted: T::from_f64(1.0 - reflected) }
    }

    fn cast<U: Real>(&self) -> Split<U> {
        let cast = |x: T| U::from_f64(x.to_f64());
        Split { reflected: cast(self.reflected), transmitted: cast(self.transmitted) }
    }
}

/// A surface whose light leaves by Lambert's law, whatever its direction was: `f` is the flux of a lobe over `pi`.
///
/// A dielectric shares the light as a smooth face shares diffuse light: from the air it reflects the mean of Fresnel's
/// reflectance, `R = 2 integral of F mu dmu`, from inside `1 - (1 - R) / n^2`. The law is thus reciprocal and loses nothing. A sheet sends
/// all into its lobe, an opaque body reflects all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert<T> {
    backing: Backing<T>,
    /// From the air and from behind.
    air: Split<T>,
    behind: Split<T>,
}

impl<T: Real> Lambert<T> {
    /// Of a surface with something behind it.
    pub fn new(backing: Backing<T>) -> Self {
        let [air, behind] = match backing {
            Backing::Dielectric(eta) => shares(eta.get().to_f64()).map(Split::of),
            Backing::Air(Lobe::Transmission) => [Split::of(0.0); 2],
            Backing::Air(Lobe::Reflection) => [Split::of(1.0); 2],
            Backing::Opaque => [Split::of(1.0), Split { reflected: T::ZERO, transmitted: T::ZERO }],
        };
        Self { backing, air, behind }
    }

    /// What is behind it.
    pub fn backing(&self) -> Backing<T> {
        self.backing
    }

    /// The same in another precision, each number rounded once.
    pub fn cast<U: Real>(&self) -> Lambert<U> {
        Lambert { backing: self.backing.cast(), air: self.air.cast(), behind: self.behind.cast() }
    }

    /// The flux of a lobe, for unit flux from a side.
    pub fn flux(&self, side: Side, lobe: Lobe) -> T {
        let split = if side == Side::Air { &self.air } else { &self.behind };
        match lobe {
            _ if !scope::lobe(lobe == Lobe::Reflection) => T::ZERO,
            Lobe::Reflection => split.reflected,
            Lobe::Transmission => split.transmitted,
        }
    }
}

/// Reflected shares of diffuse light from the air and from behind, for an index.
fn shares(eta: f64) -> [f64; 2] {
    // from the thinner medium, where nothing is reflected totally
    let n = if eta < 1.0 { 1.0 / eta } else { eta };
    // nodes are dense where the light grazes
    let part = |(x, weight): (f64, f64)| {
        let mu = x * x * x;
        weight * 6.0 * mu * x * x * fresnel::dielectric(mu, n).reflected
    };
    let thin = gauss_legendre::<32>().into_iter().map(part).sum::<f64>();
    let dense = 1.0 - (1.0 - thin) / (n * n);
    if eta < 1.0 { [dense, thin] } else { [thin, dense] }
}

impl<T: Real> Scatter<T> for Lambert<T> {
    /// Takes three uniforms; every weight is 1.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let (choice, u) = (uniform(), [uniform(), uniform()]);
        let side = lit(wi)?;
        let reflected = self.flux(side, Lobe::Reflection);
        let lobe = if choice < reflected {
            Lobe::Reflection
        } else if choice < reflected + self.flux(side, Lobe::Transmission) {
            Lobe::Transmission
        } else {
            return None;
        };
        self.sample_lobe(wi, lobe, u).map(|ray| Scattered { weight: T::ONE, ..ray })
    }
}

impl<T: Real> Bsdf<T> for Lambert<T> {
    #[inline]
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let (Some(side), Some(far)) = (lit(wi), wo.side()) else { return T::ZERO };
        let lobe = if far == side { Lobe::Reflection } else { Lobe::Transmission };
        self.flux(side, lobe) / T::PI
    }

    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        self.ars(wi, wo)
    }

    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        let side = lit(wi)?;
        let weight = self.flux(side, lobe);
        let up = (side == Side::Air) == (lobe == Lobe::Reflection);
        let [x, y, z] = cosine_hemisphere(u).xyz();
        let wo = Direction::from_unit(x, y, if up { z } else { T::ZERO - z });
        (weight > T::ZERO).then_some(Scattered { wo, weight })
    }

    fn slope(&self) -> T {
        T::ONE
    }
}

#[cfg(test)]
mod tests {
    use super::shares;
    use crate::math::Real;

    /// The mean of Fresnel's reflectance in closed form \[Duntley 1942\], for n > 1.
    fn duntley(n: f64) -> f64 {
        let n2 = n * n;
        let n4 = n2 * n2;
        0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
            + n2 * (n2 - 1.0) * (n2 - 1.0) / ((n2 + 1.0) * (n2 + 1.0) * (n2 + 1.0))
                * Real::ln((n - 1.0) / (n + 1.0))
            - 2.0 * n2 * n * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
            + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * Real::ln(n)
    }

    #[test]
    fn shares_are_the_means_of_fresnel_in_closed_form() {
        for n in [1.02, 1.1, 1.33, 1.49, 2.0, 4.0, 10.0] {
            let [air, behind] = shares(n);
            assert!((air - duntley(n)).abs() < 2e-6, "{n}: {air} {}", duntley(n));
            assert!(((1.0 - behind) * n * n - (1.0 - air)).abs() < 1e-12, "{n}");
            let [turned, back] = shares(1.0 / n);
            assert!((turned - behind).abs() < 1e-12 && (back - air).abs() < 1e-12, "{n}");
        }
        assert!(shares(1.0).iter().all(|share| share.abs() < 1e-12));
    }
}

//! Opaque GGX surface with a Lambert floor, for fits of reflection scans of metals.

use super::facet::lit;
use super::{Bsdf, Lobe, Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::math::Real;
use crate::ndf::ggx::{d_of_vector, sample_visible, shadow_sum};
use crate::quantity::Alpha;
use crate::sampling::cosine_hemisphere;
use crate::scope;

/// `f = gain D G / (4 |cos_i cos_o|) + lambert`, from the air side only; nothing is transmitted.
///
/// `gain` stands for the Fresnel reflectance of the metal, taken as constant. Both coefficients are the
/// user's: `gain + pi lambert <= 1` conserves energy and [`OpaqueGgx::conserves_energy`] checks it; a relative
/// measurement may give more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpaqueGgx<T> {
    /// Width of the slope distribution.
    pub alpha: Alpha<T>,
    /// Reflectance of a facet, dimensionless, >= 0.
    pub gain: T,
    /// Lambert term, 1/sr, >= 0.
    pub lambert: T,
}

impl<T: Real> OpaqueGgx<T> {
    /// A surface; `None` unless both coefficients are finite and at least 0.
    pub fn new(alpha: Alpha<T>, gain: T, lambert: T) -> Option<Self> {
        let fine = |x: T| x.is_finite() && x >= T::ZERO;
        (fine(gain) && fine(lambert)).then_some(Self { alpha, gain, lambert })
    }

    /// The same surface in another precision, each parameter rounded once; a coefficient beyond a precision is its largest number.
    pub fn cast<U: Real>(&self) -> OpaqueGgx<U> {
        let cast = |x: T| U::from_f64(x.to_f64()).min(U::MAX);
        OpaqueGgx { alpha: self.alpha.cast(), gain: cast(self.gain), lambert: cast(self.lambert) }
    }

    /// Whether no incidence can reflect more than it receives: `gain + pi lambert <= 1`.
    pub fn conserves_energy(&self) -> bool {
        self.gain + T::PI * self.lambert <= T::ONE
    }

    /// Probability of sampling the facets rather than the floor.
    fn facet_share(&self) -> T {
        let total = self.gain + T::PI * self.lambert;
        if total > T::ZERO { self.gain / total } else { T::ONE }
    }

    /// A ray off the facets or off the floor; the weight is that of the mixture.
    fn draw(&self, wi: Direction<T>, u: [T; 2], facets: bool) -> Option<Scattered<T>> {
        if lit(wi)? != Side::Air || !scope::REFLECTION {
            return None;
        }
        let wo = if facets {
            wi.reflect(sample_visible(self.alpha, wi, u))
        } else {
            cosine_hemisphere(u)
        };
        let density = self.pdf(wi, wo);
        (wo.side()? == Side::Air && density > T::ZERO)
            .then(|| Scattered { wo, weight: self.ars(wi, wo) / density })
    }

    /// `D` and the two shadow sums, if both directions are in the air.
    fn lobe(&self, wi: Direction<T>, wo: Direction<T>) -> Option<(T, T, T)> {
        if lit(wi)? != Side::Air || wo.side()? != Side::Air || !scope::REFLECTION {
            return None;
        }
        let (i, o) = (wi.xyz(), wo.xyz());
        let [hx, hy, hz] = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
        let (a, xy2, z2) = (self.alpha.get(), hx * hx + hy * hy, hz * hz);
        (xy2 + z2 > T::ZERO).then(|| (d_of_vector(a, xy2, z2), shadow_sum(a, i), shadow_sum(a, o)))
    }
}

impl<T: Real> Scatter<T> for OpaqueGgx<T> {
    /// Takes three uniforms.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let u = [uniform(), uniform()];
        self.draw(wi, u, uniform() < self.facet_share())
    }
}

impl<T: Real> Bsdf<T> for OpaqueGgx<T> {
    fn eval(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        match self.lobe(wi, wo) {
            // a narrow peak over cosines next to nothing is larger than any number
            Some((d, si, so)) => (self.gain * d / (si * so) + self.lambert).min(T::MAX),
            None => T::ZERO,
        }
    }

    fn pdf(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        match self.lobe(wi, wo) {
            Some((d, si, _)) => {
                let facets = self.facet_share();
                (facets * d / (T::TWO * si) + (T::ONE - facets) * wo.z() / T::PI).min(T::MAX)
            }
            None => T::ZERO,
        }
    }

    fn sample_lobe(&self, wi: Direction<T>, lobe: Lobe, u: [T; 2]) -> Option<Scattered<T>> {
        if lobe == Lobe::Transmission {
            return None;
        }
        // One uniform serves twice: which part, then where in it.
        let share = self.facet_share();
        if u[1] < share {
            self.draw(wi, [u[0], u[1] / share], true)
        } else {
            self.draw(wi, [u[0], (u[1] - share) / (T::ONE - share)], false)
        }
    }

    fn slope(&self) -> T {
        self.alpha.get()
    }
}

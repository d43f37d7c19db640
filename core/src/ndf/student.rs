//! Student-t slopes: a tail between and beyond those of GGX and Beckmann \[Ribardiere et al. 2017\].

use core::f64::consts::PI;

use super::density::Density;
use crate::math::{Real, special};
use crate::quantity::{Alpha, QuantityError};

/// `D = 1 / (pi sigma^2 cos^4 (1 + tan^2 / c)^gamma)`, `c = (gamma - 1) sigma^2`.
///
/// `gamma` = 2 is GGX of `alpha` = `sigma`, and a large one Beckmann. `Lambda` is closed: with `mu = cot theta`,
/// `x = c / (c + mu^2)`, `a = gamma - 1` and Euler's beta function,
/// `Lambda = x^a sqrt(c + mu^2) / (B(a, 1/2) (2 a - 1) mu) - I_x(a, 1/2) / 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Student<T> {
    sigma: Alpha<T>,
    gamma: T,
    /// `(gamma - 1) sigma^2`.
    c: T,
    /// `(gamma - 1) c / pi`.
    peak: T,
    /// `1 / B(gamma - 1, 1/2)`.
    inverse_beta: f64,
}

impl<T: Real> Student<T> {
    /// Smallest exponent; at 1.5 the facets of any tile would be infinitely steep on average.
    pub const LEAST: f64 = 1.51;
    /// Largest exponent: within 0.2 % of Beckmann.
    pub const MOST: f64 = 500.0;

    /// Facets of a given width and tail.
    ///
    /// # Errors
    /// [`QuantityError`] if `gamma` is not finite, or outside 1.51 to 500.
    pub fn new(sigma: Alpha<T>, gamma: T) -> Result<Self, QuantityError> {
        if !gamma.is_finite() {
            Err(QuantityError::NotFinite)
        } else if gamma < T::from_f64(Self::LEAST) {
            Err(QuantityError::TooSmall)
        } else if gamma > T::from_f64(Self::MOST) {
            Err(QuantityError::TooLarge)
        } else {
            Ok(Self::of(sigma, gamma))
        }
    }

    fn of(sigma: Alpha<T>, gamma: T) -> Self {
        let (s, a) = (sigma.get().to_f64(), gamma.to_f64() - 1.0);
        let c = a * s * s;
        let ratio = special::ln_gamma(a + 0.5) - special::ln_gamma(a);
        let inverse_beta = Real::exp(ratio) / Real::sqrt(PI);
        let [c, peak] = [c, a * c / PI].map(T::from_f64);
        Self { sigma, gamma, c, peak, inverse_beta }
    }

    /// Width of the slope distribution.
    pub fn sigma(&self) -> Alpha<T> {
        self.sigma
    }

    /// Exponent of the tail.
    pub fn gamma(&self) -> T {
        self.gamma
    }

    /// `gamma - 1` and `c`.
    fn wide(&self) -> (f64, f64) {
        let (s, a) = (self.sigma.get().to_f64(), self.gamma.to_f64() - 1.0);
        (a, a * s * s)
    }
}

impl<T: Real> Density<T> for Student<T> {
    type In<U: Real> = Student<U>;

    #[inline(always)]
    fn d(&self, xy2: T, z2: T, _: impl FnOnce() -> [[T; 2]; 2]) -> T {
        let cz = self.c * z2;
        let sum = cz + xy2;
        let scale = (xy2 + z2) / sum;
        let tail = if self.gamma == T::TWO { T::ONE } else { (cz / sum).pow(self.gamma - T::TWO) };
        self.peak * (scale * scale) * tail
    }

    fn excess(&self, mu: f64) -> f64 {
        let (a, c) = self.wide();
        let square = mu * mu;
        let (x, y) = (c / (c + square), square / (c + square));
        // beyond this it is far below a rounding of mu
        if x < 1e-30 || !square.is_finite() {
            return 0.0;
        }
        let ln_x = if y < 0.5 { special::ln_1p(-y) } else { Real::ln(x) };
        let root = Real::sqrt(c + square);
        let tail = self.inverse_beta * root * Real::exp(a * ln_x) / (2.0 * a - 1.0);
        let share = special::incomplete_beta_half(a, x, y, self.inverse_beta);
        Real::max(tail - 0.5 * mu * share, 0.0)
    }

    fn steeper(&self, slope: f64) -> f64 {
        let (a, c) = self.wide();
        Real::exp(-a * special::ln_1p(slope * slope / c))
    }

    fn slope_above(&self, share: f64) -> f64 {
        let (a, c) = self.wide();
        let ln = Real::ln(Real::max(share, f64::MIN_POSITIVE));
        Real::sqrt_positive(c * special::exp_m1(-ln / a))
    }

    fn slope(&self) -> T {
        self.sigma.get()
    }

    fn tail(&self) -> f64 {
        let a = self.gamma.to_f64() - 1.0;
        Real::max(2.0 * a / (2.0 * a - 1.0), 2.0)
    }

    fn cast<U: Real>(&self) -> Student<U> {
        let [least, most] = [Self::LEAST, Self::MOST].map(U::from_f64);
        Student::of(self.sigma.cast(), U::from_f64(self.gamma.to_f64()).max(least).min(most))
    }
}

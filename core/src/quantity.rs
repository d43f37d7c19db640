//! Validated quantities: a value that exists is in its domain, and nothing checks it again.

use core::fmt;

use crate::math::Real;

/// Why a number cannot be the quantity it was offered for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum QuantityError {
    /// NaN or infinite.
    NotFinite,
    /// Below the smallest value of the domain.
    TooSmall,
    /// Above the largest value of the domain.
    TooLarge,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "not a finite number",
            Self::TooSmall => "below its domain",
            Self::TooLarge => "above its domain",
        })
    }
}

impl core::error::Error for QuantityError {}

fn within<T: Real>(x: T, least: f64, most: f64) -> Result<T, QuantityError> {
    if !x.is_finite() {
        Err(QuantityError::NotFinite)
    } else if x < T::from_f64(least) {
        Err(QuantityError::TooSmall)
    } else if x > T::from_f64(most) {
        Err(QuantityError::TooLarge)
    } else {
        Ok(x)
    }
}

/// GGX width `alpha_g`, the rms-like slope of the surface, dimensionless, 1e-6 to 100.
///
/// Below 1e-6 a surface is smooth to `f32`; use [`crate::bsdf::Smooth`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha<T>(T);

impl<T: Real> Alpha<T> {
    /// Smallest width.
    pub const LEAST: f64 = 1e-6;
    /// Largest width.
    pub const MOST: f64 = 100.0;

    /// Checks a width.
    ///
    /// # Errors
    /// [`QuantityError`] if not finite, or outside 1e-6 to 100.
    pub fn new(alpha: T) -> Result<Self, QuantityError> {
        within(alpha, Self::LEAST, Self::MOST).map(Self)
    }

    /// The number.
    #[inline(always)]
    pub fn get(self) -> T {
        self.0
    }
}

/// Relative refractive index `eta = n_dielectric / n_air`, dimensionless, 0.1 to 10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeIor<T> {
    value: T,
    /// `1 / value`, divided once: every call needs one or the other, by the side of `wi`.
    inverse: T,
}

impl<T: Real> RelativeIor<T> {
    /// Smallest index.
    pub const LEAST: f64 = 0.1;
    /// Largest index.
    pub const MOST: f64 = 10.0;

    /// Checks an index.
    ///
    /// # Errors
    /// [`QuantityError`] if not finite, or outside 0.1 to 10.
    pub fn new(eta: T) -> Result<Self, QuantityError> {
        within(eta, Self::LEAST, Self::MOST).map(|value| Self { value, inverse: T::ONE / value })
    }

    /// The number.
    #[inline(always)]
    pub fn get(self) -> T {
        self.value
    }

    /// Its inverse, `n_air / n_dielectric`.
    #[inline(always)]
    pub fn inverse(self) -> T {
        self.inverse
    }

    /// The same index in another precision, each number rounded once.
    #[inline(always)]
    pub fn cast<U: Real>(self) -> RelativeIor<U> {
        RelativeIor {
            value: U::from_f64(self.value.to_f64()),
            inverse: U::from_f64(self.inverse.to_f64()),
        }
    }

    /// True if the two media are alike, so that the boundary does not exist: |eta - 1| <= 4 epsilon.
    #[inline(always)]
    pub fn is_matched(self) -> bool {
        (self.value - T::ONE).abs() <= T::EPSILON * T::from_f64(4.0)
    }
}

#[cfg(feature = "f32")]
impl RelativeIor<f32> {
    /// [`Self::new`] in a constant; `None` outside its domain.
    pub const fn constant(eta: f32) -> Option<Self> {
        let fine = eta >= Self::LEAST as f32 && eta <= Self::MOST as f32;
        if fine { Some(Self { value: eta, inverse: 1.0 / eta }) } else { None }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{Alpha, QuantityError, RelativeIor};

    #[test]
    fn a_constant_is_the_same_quantity() {
        for x in [0.05_f32, 0.1, 0.7, 1.0, 1.49, 10.0, 10.5, f32::NAN, f32::INFINITY] {
            assert_eq!(RelativeIor::constant(x), RelativeIor::new(x).ok(), "{x}");
        }
    }

    #[test]
    fn a_quantity_outside_its_domain_is_refused_with_the_reason() {
        assert_eq!(Alpha::new(f64::NAN), Err(QuantityError::NotFinite));
        assert_eq!(Alpha::new(f32::INFINITY), Err(QuantityError::NotFinite));
        assert_eq!(Alpha::new(0.0), Err(QuantityError::TooSmall));
        assert_eq!(Alpha::new(-0.2_f32), Err(QuantityError::TooSmall));
        assert_eq!(Alpha::new(1e9), Err(QuantityError::TooLarge));
        assert!(Alpha::new(1e-6).is_ok() && Alpha::new(1e-6_f32).is_ok());
        assert_eq!(RelativeIor::new(0.0), Err(QuantityError::TooSmall));
        assert!(RelativeIor::new(1.0).is_ok_and(RelativeIor::is_matched));
        assert!(RelativeIor::new(1.0001_f32).is_ok_and(|n| !n.is_matched()));
    }
}

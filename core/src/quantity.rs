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
    /// `4 (1 - n^2)` and `4 (1 - 1 / n^2)`, for reflection seen from the air and from the dielectric, and `|n^2 - 1|`,
    /// for transmission, each as a number and what its rounding left: critical and grazing angles are where the
    /// square of a half vector equals one of them, and a difference from it needs more digits than the index has.
    /// NaN if the media are matched.
    limits: [[T; 2]; 3],
    /// `n^2 + 1`.
    squares: T,
    /// `n / (8 (n^2 - 1)^2)` from the air, over `n^2` from the dielectric, with the sign of `n^2 - 1`.
    through: [T; 2],
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
        let value = within(eta, Self::LEAST, Self::MOST)?;
        let n = value.to_f64();
        let step = (n - 1.0) * (n + 1.0);
        let in_two = |x: f64| {
            let high = T::from_f64(x);
            [high, T::from_f64(x - high.to_f64())]
        };
        let limits = [in_two(-4.0 * step), in_two(4.0 * step / (n * n)), in_two(step.abs())];
        let through = [n, 1.0 / n].map(|e| T::from_f64(e / (8.0 * step * step.abs())));
        let squares = T::from_f64(n * n + 1.0);
        Ok(Self { value, inverse: T::ONE / value, limits, squares, through }.unless_matched())
    }

    /// Matched media scatter nothing: with NaN for a limit no facet is possible, and nobody has to ask.
    fn unless_matched(self) -> Self {
        let nan = [[T::from_f64(f64::NAN); 2]; 3];
        if self.is_matched() { Self { limits: nan, ..self } } else { self }
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

    /// `|h|^2` of the half vector at the critical angle (reflection, where there is one) or of a facet at grazing
    /// incidence (transmission): `[number, what its rounding left]`.
    #[inline(always)]
    #[cfg_attr(not(any(feature = "ggx", feature = "normals", feature = "table")), allow(dead_code))]
    pub(crate) fn limit(&self, reflected: bool, from_below: bool) -> [T; 2] {
        let [above, below, through] = self.limits;
        match (reflected, from_below) {
            (false, _) => through,
            (true, false) => above,
            (true, true) => below,
        }
    }

    /// `n^2 + 1`, and `e / (8 (n^2 - 1)^2)` with the sign of `n^2 - 1`, `e` the far index over the near one.
    #[inline(always)]
    #[cfg_attr(not(any(feature = "ggx", feature = "normals", feature = "table")), allow(dead_code))]
    pub(crate) fn transmission(&self, from_below: bool) -> [T; 2] {
        let [above, below] = self.through;
        [self.squares, if from_below { below } else { above }]
    }

    /// The same index in another precision, each number rounded once; a wider one computes what follows from it anew.
    #[inline(always)]
    pub fn cast<U: Real>(self) -> RelativeIor<U> {
        let cast = |x: T| U::from_f64(x.to_f64());
        if T::EPSILON.to_f64() > U::EPSILON.to_f64()
            && let Ok(there) = RelativeIor::new(cast(self.value))
        {
            return there;
        }
        // between tiers of one precision nothing is computed, and the compiler knows it here
        let narrower = T::EPSILON.to_f64() < U::EPSILON.to_f64();
        let limits = self.limits.map(|[high, low]| {
            let lost = high.to_f64() - cast(high).to_f64() + low.to_f64();
            [cast(high), if narrower { U::from_f64(lost) } else { cast(low) }]
        });
        let there = RelativeIor {
            value: cast(self.value),
            inverse: cast(self.inverse),
            limits,
            squares: cast(self.squares),
            through: self.through.map(cast),
        };
        if narrower { there.unless_matched() } else { there }
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
        if fine { Some(Self::of(eta)) } else { None }
    }

    /// The numbers of [`Self::new`], known when a program is built.
    const fn of(value: f32) -> Self {
        const fn in_two(x: f64) -> [f32; 2] {
            let high = x as f32;
            [high, (x - high as f64) as f32]
        }
        let n = value as f64;
        let step = (n - 1.0) * (n + 1.0);
        let size = if step < 0.0 { -step } else { step };
        let nan = [f32::NAN; 2];
        let matched = (value - 1.0).abs() <= 4.0 * f32::EPSILON;
        let limits = if matched {
            [nan; 3]
        } else {
            [in_two(-4.0 * step), in_two(4.0 * step / (n * n)), in_two(size)]
        };
        let through = [(n / (8.0 * step * size)) as f32, (1.0 / n / (8.0 * step * size)) as f32];
        Self { value, inverse: 1.0 / value, limits, squares: (n * n + 1.0) as f32, through }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{Alpha, QuantityError, RelativeIor};

    #[test]
    fn a_constant_is_the_same_quantity() {
        for x in [0.05_f32, 0.1, 0.7, 1.0, 1.49, 10.0, 10.5, f32::NAN, f32::INFINITY] {
            // to the last bit; matched media have limits that are not numbers
            let bits = |n: RelativeIor<f32>| {
                let rest = [n.value, n.inverse, n.squares].into_iter().chain(n.through);
                let all = rest.chain(n.limits.into_iter().flatten());
                all.map(f32::to_bits).collect::<std::vec::Vec<u32>>()
            };
            let [constant, new] = [RelativeIor::constant(x), RelativeIor::new(x).ok()];
            assert_eq!(constant.map(bits), new.map(bits), "{x}");
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

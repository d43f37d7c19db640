//! The paper's two profiles, with the signs corrected \[Sokolov eqs 4-5 and 7-8\].
//!
//! As printed, the Gauss profile has no minus in its exponent and grows, and the Cauchy profile has a
//! minus in its denominator and a pole at `|t - t0| = delta`. The forms below are the intended ones.

use core::fmt;

use crate::math::Real;

/// The shape of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// `F = exp(-|t - t0|^n / (2 delta^n))`; n = 2 is the normal law of standard deviation delta.
    Gauss,
    /// `F = delta^n / (|t - t0|^n + delta^n)`; n = 2 is the Lorentz law of half width delta.
    Cauchy,
}

/// Which parameter of a law is outside its domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LawError {
    /// `delta` is not within 1e-6 to 10.
    Delta,
    /// The exponent `n` is not within 0.1 to 100.
    Exponent,
    /// The centre is not within 0 to pi/2.
    Centre,
}

impl fmt::Display for LawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Delta => "delta must be a number from 1e-6 to 10",
            Self::Exponent => "the exponent n must be a number from 0.1 to 100",
            Self::Centre => "theta0 must be a number from 0 to pi/2 (90 degrees)",
        })
    }
}

impl core::error::Error for LawError {}

/// Domains of the parameters.
const DELTA: [f64; 2] = [1e-6, 10.0];
const EXPONENT: [f64; 2] = [0.1, 100.0];
const CENTRE: [f64; 2] = [0.0, core::f64::consts::FRAC_PI_2];

/// A profile with its width `delta`, exponent `n` and centre `t0`; `delta` and `t0` are in the unit of the variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<T> {
    profile: Profile,
    delta: T,
    n: T,
    centre: T,
}

impl<T: Real> Law<T> {
    /// A law; `delta` and `centre` in the unit of the variable (radians for facet angles).
    ///
    /// # Errors
    /// [`LawError`] names the parameter outside its domain; NaN is outside every domain.
    pub fn new(profile: Profile, delta: T, n: T, centre: T) -> Result<Self, LawError> {
        let within = |x: T, [a, b]: [f64; 2]| x >= T::from_f64(a) && x <= T::from_f64(b);
        if !within(delta, DELTA) {
            Err(LawError::Delta)
        } else if !within(n, EXPONENT) {
            Err(LawError::Exponent)
        } else if !within(centre, CENTRE) {
            Err(LawError::Centre)
        } else {
            Ok(Self { profile, delta, n, centre })
        }
    }

    /// `F(t)`, not normalised, 1 at the centre.
    #[inline]
    pub fn value(&self, t: T) -> T {
        let y = (t - self.centre).abs() / self.delta;
        // the normal law needs no general power, which costs as much as all the rest
        let power = if self.n == T::TWO { y * y } else { y.pow(self.n) };
        self.falls(power)
    }

    /// `F` from `y^n`, the power of the distance from the centre in widths.
    #[inline(always)]
    pub(super) fn falls(&self, power: T) -> T {
        match self.profile {
            Profile::Gauss => (-T::HALF * power).exp(),
            Profile::Cauchy => T::ONE / (T::ONE + power),
        }
    }

    /// The same law in another precision, each parameter rounded once; the ends of its domain stay its ends.
    pub fn cast<U: Real>(&self) -> Law<U> {
        let cast = |x: T, [least, most]: [f64; 2]| {
            U::from_f64(x.to_f64()).max(U::from_f64(least)).min(U::from_f64(most))
        };
        Law {
            profile: self.profile,
            delta: cast(self.delta, DELTA),
            n: cast(self.n, EXPONENT),
            centre: cast(self.centre, CENTRE),
        }
    }

    /// The shape.
    pub fn profile(&self) -> Profile {
        self.profile
    }
    /// The width.
    pub fn delta(&self) -> T {
        self.delta
    }
    /// The exponent.
    pub fn n(&self) -> T {
        self.n
    }
    /// The centre.
    pub fn centre(&self) -> T {
        self.centre
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{Law, LawError, Profile};

    #[test]
    fn both_profiles_fall_from_one_and_have_no_pole() {
        for n in [0.5, 1.0, 2.0, 3.7, 64.0] {
            for profile in [Profile::Gauss, Profile::Cauchy] {
                let law = Law::<f64>::new(profile, 0.1, n, 0.0).unwrap();
                assert!((law.value(0.0_f64) - 1.0_f64).abs() < 1e-15);
                let mut last = 1.0;
                for k in 1..1000 {
                    let v = law.value(f64::from(k) * 1e-3);
                    assert!(v.is_finite() && v >= 0.0 && v <= last, "{profile:?} {n} {k}");
                    last = v;
                }
            }
        }
        // at t = delta: exp(-1/2), and 1/2
        let g = Law::<f64>::new(Profile::Gauss, 0.1, 3.0, 0.0).unwrap();
        let c = Law::<f64>::new(Profile::Cauchy, 0.1, 3.0, 0.0).unwrap();
        assert!(
            (g.value(0.1) - (-0.5_f64).exp()).abs() < 1e-15 && (c.value(0.1) - 0.5).abs() < 1e-15
        );
    }

    #[test]
    fn a_parameter_outside_its_domain_is_named() {
        let law = |d, n, c| Law::<f64>::new(Profile::Gauss, d, n, c);
        assert_eq!(law(0.0, 2.0, 0.0), Err(LawError::Delta));
        assert_eq!(law(f64::NAN, 2.0, 0.0), Err(LawError::Delta));
        assert_eq!(law(0.1, 0.0, 0.0), Err(LawError::Exponent));
        assert_eq!(law(0.1, f64::INFINITY, 0.0), Err(LawError::Exponent));
        assert_eq!(law(0.1, 2.0, 2.0), Err(LawError::Centre));
    }
}

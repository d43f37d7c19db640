//! Uniforms turned into points and directions.

use crate::direction::Direction;
use crate::math::Real;

/// A direction of the air side with density `cos theta / pi`, from two uniforms in [0, 1).
pub fn cosine_hemisphere<T: Real>(u: [T; 2]) -> Direction<T> {
    let (s, c) = (T::TWO * T::PI * u[0]).sin_cos();
    let r = u[1].sqrt();
    let z = (T::ONE - u[1]).sqrt_positive().max(T::MIN_POSITIVE);
    Direction::from_unit(r * c, r * s, z)
}

/// The direction of height `z` at the azimuth `u` of a turn.
#[cfg(all(feature = "ggx", feature = "microfacet"))]
pub(crate) fn around<T: Real>(z: T, u: T) -> Direction<T> {
    let (s, c) = (T::TWO * T::PI * u).sin_cos();
    let r = ((T::ONE - z) * (T::ONE + z)).sqrt_positive();
    Direction::from_unit(r * c, r * s, z)
}

/// The smoothstep `3 x^2 - 2 x^3` solved for `x` in [0, 1], for `u` in [0, 1].
///
/// A table of quantiles at these `x`, evenly spaced, is dense at both ends of a distribution.
#[inline]
pub fn inverse_smoothstep<T: Real>(u: T) -> T {
    let clamped = u.max(T::ZERO).min(T::ONE);
    T::HALF - ((T::ONE - T::TWO * clamped).asin() / T::from_f64(3.0)).sin_cos().0
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{cosine_hemisphere, inverse_smoothstep};

    #[test]
    fn the_smoothstep_is_inverted() {
        for k in 0..=1000 {
            let x = f64::from(k) / 1000.0;
            let u = x * x * (3.0 - 2.0 * x);
            assert!((inverse_smoothstep(u) - x).abs() < 1e-7, "{x}");
        }
        assert!((inverse_smoothstep(2.0_f32) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn hemisphere_directions_are_unit_and_above() {
        for k in 0..100 {
            let d = cosine_hemisphere([k as f32 / 100.0, 0.999_999_94]);
            assert!(d.z() > 0.0 && (d.dot(d) - 1.0).abs() < 1e-5);
        }
    }
}

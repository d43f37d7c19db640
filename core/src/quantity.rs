//! Validated quantities: the constructor checks the domain, and nothing checks it again.

use core::fmt;

use crate::math::Real;

/// Why a number cannot be the quantity it was offered for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u32)] // beside a byte, quantities in a `Result` would be copied bytewise, for which a device needs a `memcpy`
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

    /// The same width in another precision, rounded once; the ends of the domain stay its ends.
    #[inline]
    pub fn cast<U: Real>(self) -> Alpha<U> {
        let [least, most] = [Self::LEAST, Self::MOST].map(U::from_f64);
        Alpha(U::from_f64(self.0.to_f64()).max(least).min(most))
    }
}

/// Relative refractive index `eta = n_dielectric / n_air`, dimensionless, 0.1 to 10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeIor<T> {
    value: T,
    /// `1 / value`, divided once: every call needs one of the two, depending on the side of `wi`.
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
    #[inline(always)]
    pub fn new(eta: T) -> Result<Self, QuantityError> {
        let value = within(eta, Self::LEAST, Self::MOST)?;
        Ok(in_two::follows(value))
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
    #[cfg_attr(
        not(any(feature = "ggx", feature = "normals", feature = "table")),
        allow(dead_code, reason = "without a law nobody asks")
    )]
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
    #[cfg_attr(
        not(any(feature = "ggx", feature = "normals", feature = "table")),
        allow(dead_code, reason = "without a law nobody asks")
    )]
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
        let in_two = |[high, low]: [T; 2]| {
            let lost = high.to_f64() - cast(high).to_f64() + low.to_f64();
            [cast(high), if narrower { U::from_f64(lost) } else { cast(low) }]
        };
        // one by one: a map of an array is a call, for every value of a table
        let ([above, below, crossed], [up, down]) = (self.limits, self.through);
        let there = RelativeIor {
            value: cast(self.value),
            inverse: cast(self.inverse),
            limits: [in_two(above), in_two(below), in_two(crossed)],
            squares: cast(self.squares),
            through: [cast(up), cast(down)],
        };
        let nan = [U::from_f64(f64::NAN); 2];
        let matched = narrower && there.is_matched();
        if matched { RelativeIor { limits: [nan; 3], through: nan, ..there } } else { there }
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
        if fine { Some(in_two_constant::follows(eta)) } else { None }
    }
}

/// What follows from an index, for a type that may be generic or whose functions may be `const`, but not both.
///
/// A pair is `[number, what its rounding left]`. In single precision all is computed in pairs, to 1e-14: digits that
/// doubles have too, but a Cortex-M4F has no doubles, and 3 kB of code for them. In double the second is 0.
/// Of what runs on a device there is one copy; what is `const` is in line, and folded where it is called.
macro_rules! in_two {
    ($name:ident, $t:ident, [$($constant:ident)?], [$($generic:tt)*], $splitter:expr, $nan:expr,
     $inline:meta) => {
        mod $name {
            use crate::math::Real;
            use crate::scope;

            /// `a + b` \[Knuth's two-sum\].
            $($constant)? fn sum $($generic)* (a: $t, b: $t) -> [$t; 2] {
                let sum = a + b;
                let part = sum - a;
                let low = (a - (sum - part)) + (b - part);
                [sum, if $t::IN_TWO { low } else { $t::ZERO }]
            }

            /// A pair of which the second is small beside the first, but perhaps not below its last digit.
            $($constant)? fn renormalised $($generic)* ([high, low]: [$t; 2]) -> [$t; 2] {
                let sum = high + low;
                [sum, if $t::IN_TWO { low - (sum - high) } else { $t::ZERO }]
            }

            /// The rounding error of a product of two \[Dekker\], of numbers halved by Veltkamp.
            $($constant)? fn lost $($generic)* (a: $t, b: $t, product: $t) -> $t {
                let (a_large, b_large) = (a * $splitter, b * $splitter);
                let (a_high, b_high) = (a_large - (a_large - a), b_large - (b_large - b));
                let (a_low, b_low) = (a - a_high, b - b_high);
                ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
            }

            /// The product of two pairs.
            #[cfg_attr(target_arch = "arm", $inline)]
            $($constant)? fn product $($generic)* (a: [$t; 2], b: [$t; 2]) -> [$t; 2] {
                let product = a[0] * b[0];
                let low = lost(a[0], b[0], product) + (a[0] * b[1] + a[1] * b[0]);
                renormalised([product, if $t::IN_TWO { low } else { $t::ZERO }])
            }

            /// The quotient of two pairs.
            #[cfg_attr(target_arch = "arm", $inline)]
            $($constant)? fn quotient $($generic)* (a: [$t; 2], b: [$t; 2]) -> [$t; 2] {
                let quotient = a[0] / b[0];
                let product = quotient * b[0];
                let rest = (a[0] - product) - lost(quotient, b[0], product);
                let low = (rest + (a[1] - quotient * b[1])) / b[0];
                renormalised([quotient, if $t::IN_TWO { low } else { $t::ZERO }])
            }

            /// All that follows from an index. Matched media scatter nothing: with NaN for a limit no facet is possible, and
            /// no caller needs to ask.
            #[cfg_attr(target_arch = "arm", $inline)]
            pub(super) $($constant)? fn follows $($generic)* (n: $t) -> super::RelativeIor<$t> {
                let (one, four) = ($t::ONE, $t::TWO * $t::TWO);
                let (value, eighth) = ([n, $t::ZERO], $t::HALF / four);
                let squared = product(value, value);
                // n^2 - 1, which must keep its digits next to n = 1
                let [step, low] = product(sum(n, -one), sum(n, one));
                let step = if (n - one).abs() > four * $t::EPSILON { step } else { $nan };
                let sign = if step < $t::ZERO { -one } else { one };
                // what is out of scope, and takes a division, nobody asks for
                let nothing = [$t::ZERO; 2];
                let below_too = scope::DIELECTRIC && scope::REFLECTION;
                let [below, below_low] = if below_too { quotient([step, low], squared) } else { nothing };
                let through_too = scope::DIELECTRIC && scope::TRANSMISSION;
                let fourth_power = product([step, low], [step, low]);
                let [above_through, _] = quotient(value, fourth_power);
                let [below_through, _] = if through_too {
                    quotient(quotient([one, $t::ZERO], value), fourth_power)
                } else {
                    nothing
                };
                let [squares, squares_low] = sum(squared[0], one);
                super::RelativeIor {
                    value: n,
                    inverse: one / n,
                    limits: [
                        [-(four * step), -(four * low)],
                        [four * below, four * below_low],
                        [sign * step, sign * low],
                    ],
                    squares: squares + (squares_low + squared[1]),
                    through: [sign * eighth * above_through, sign * eighth * below_through],
                }
            }
        }
    };
}

in_two!(in_two, T, [], [<T: Real>], T::from_f64(4097.0), T::from_f64(f64::NAN), inline(never));
#[cfg(feature = "f32")]
in_two!(in_two_constant, f32, [const], [], 4097.0, f32::NAN, inline(always));

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::{Alpha, QuantityError, RelativeIor};

    /// All numbers of an index to the last bit, but for the sign of a NaN, which matched media have for limits.
    fn bits(n: RelativeIor<f32>) -> std::vec::Vec<u32> {
        let rest = [n.value, n.inverse, n.squares].into_iter().chain(n.through);
        let all = rest.chain(n.limits.into_iter().flatten());
        all.map(|x| if x.is_nan() { u32::MAX } else { x.to_bits() }).collect()
    }

    #[test]
    fn a_constant_is_the_same_quantity() {
        for x in [0.05_f32, 0.1, 0.7, 1.0, 1.49, 10.0, 10.5, f32::NAN, f32::INFINITY] {
            let [constant, new] = [RelativeIor::constant(x), RelativeIor::new(x).ok()];
            assert_eq!(constant.map(bits), new.map(bits), "{x}");
        }
    }

    /// Indices over the whole domain, and next to 1 from both sides.
    fn indices() -> impl Iterator<Item = f32> {
        let even = (0..=20_000).map(|k| 0.1 * 100.0_f32.powf(k as f32 / 20_000.0));
        let steps = (5..4000).chain((12..23).map(|k| 1 << k));
        let near = steps
            .flat_map(|k| [1.0 + k as f32 * f32::EPSILON, 1.0 - k as f32 * f32::EPSILON / 2.0]);
        even.chain(near).chain([0.1, 0.5, 1.33, 1.49, 2.0, 10.0])
    }

    #[test]
    fn what_follows_from_an_index_has_the_digits_of_doubles() {
        let mut seen = 0;
        for n in indices() {
            let Ok(index) = RelativeIor::new(n.clamp(0.1, 10.0)) else { panic!("{n}") };
            assert_eq!(RelativeIor::constant(index.value).map(bits), Some(bits(index)), "{n}");
            if index.is_matched() {
                continue;
            }
            seen += 1;
            let n = f64::from(index.value);
            let step = (n - 1.0) * (n + 1.0);
            let limits = [-4.0 * step, 4.0 * step / (n * n), step.abs()];
            for ([high, low], limit) in index.limits.into_iter().zip(limits) {
                assert!(
                    (f64::from(high) + f64::from(low) - limit).abs() < 2e-14 * limit.abs(),
                    "{n}"
                );
                assert_eq!((high + low).to_bits(), high.to_bits(), "{n}");
            }
            let through = [n, 1.0 / n].map(|e| e / (8.0 * step * step.abs()));
            let all = [
                (index.squares, n * n + 1.0),
                (index.through[0], through[0]),
                (index.through[1], through[1]),
            ];
            for (single, double) in all {
                // rounded once; what is next to half a unit may go either way
                let off = (f64::from(single) - double).abs();
                let unit = f64::from(single.abs().next_up() - single.abs());
                assert!(off <= unit * (0.5 + 1e-6), "{n}: {single} {double}");
            }
        }
        assert!(seen > 27_000, "{seen}");
    }

    #[test]
    fn double_has_no_second_parts() {
        for n in indices().map(|n| f64::from(n) * (1.0 + 1e-11)).filter(|n| (0.1..10.0).contains(n))
        {
            let index = RelativeIor::new(n).unwrap();
            let step = (n - 1.0) * (n + 1.0);
            let limits = [-4.0 * step, 4.0 * step / (n * n), step.abs()];
            assert_eq!(index.limits, limits.map(|x| [x, 0.0]), "{n}");
            let through = [n, 1.0 / n].map(|e| e / (8.0 * step * step.abs()));
            assert_eq!((index.squares, index.through), (n * n + 1.0, through), "{n}");
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

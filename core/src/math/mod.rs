//! The only access to mathematics: a sealed scalar trait, [`Real`], on `libm`.
//!
//! Nothing else in this crate calls `libm` or an inherent float function that needs `std`. The same
//! source therefore gives the same bits on a workstation and on a Cortex-M, in debug and release.

#[cfg(feature = "fast")]
mod fast;
mod hardware;
#[cfg(feature = "fast")]
mod polynomial;
#[cfg(feature = "microfacet")]
pub(crate) mod special;
#[cfg(all(feature = "ggx", feature = "microfacet"))]
pub(crate) mod joint;
#[cfg(test)]
#[allow(clippy::disallowed_methods, clippy::float_cmp, reason = "oracles, and exact values")]
mod tests_fast;

#[cfg(feature = "fast")]
pub use fast::{Fast, FastVec3};

use core::fmt::{Debug, Display};
use core::ops::{Add, Div, Mul, Neg, Sub};

use rand_core::Rng;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Three components of a scalar; implemented by glam's `Vec3` and `DVec3`.
pub trait Vector<T>:
    Copy + Debug + Default + PartialEq + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self>
{
    /// The vector (x, y, z).
    fn from_xyz(x: T, y: T, z: T) -> Self;
    /// The components.
    fn xyz(self) -> [T; 3];
    /// Scalar product.
    fn dot(self, other: Self) -> T;
    /// The vector times a scalar.
    fn scale(self, by: T) -> Self;
}

/// A floating-point number, `f32` or `f64`, with the functions that scattering needs.
///
/// Sealed: an evaluator is only as reproducible as its arithmetic, and these two are tested.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + Display
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// glam's vector of this scalar.
    type Vec3: Vector<Self> + Send + Sync;

    /// 0.
    const ZERO: Self;
    /// 1/2.
    const HALF: Self;
    /// 1.
    const ONE: Self;
    /// 2.
    const TWO: Self;
    /// The circle constant.
    const PI: Self;
    /// Distance from 1 to the next number.
    const EPSILON: Self;
    /// Smallest positive normal number.
    const MIN_POSITIVE: Self;
    /// Largest finite number.
    const MAX: Self;
    /// Whether differences of nearly equal numbers are computed in two parts: in single precision.
    const IN_TWO: bool;

    /// Nearest number of this type.
    fn from_f64(x: f64) -> Self;
    /// Widened to `f64`, exactly.
    fn to_f64(self) -> f64;
    /// Uniform in [0, 1) from the high bits of a random word.
    fn from_bits_uniform(bits: u64) -> Self;
    /// Correctly rounded square root; NaN for negative arguments.
    fn sqrt(self) -> Self;
    /// Cube root.
    fn cbrt(self) -> Self;
    /// Sine and cosine of an angle in radians.
    fn sin_cos(self) -> (Self, Self);
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// Arc sine in radians; NaN outside [-1, 1].
    fn asin(self) -> Self;
    /// Arc cosine in radians; NaN outside [-1, 1].
    fn acos(self) -> Self;
    /// Angle of the point (`x`, `self`) in radians.
    fn atan2(self, x: Self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Power of a number that is not negative. In double precision `exp(exponent ln x)`, whose relative error is about
    /// `|exponent ln x|` roundings: `libm::pow` carries the logarithm in two parts, and takes 2.6 times as long.
    fn pow(self, exponent: Self) -> Self;
    /// Largest integer not above.
    fn floor(self) -> Self;
    /// As an array index: truncated, 0 for negatives and NaN.
    fn to_index(self) -> usize;
    /// The number of an index, which is exact below 2^24.
    fn from_index(index: u32) -> Self;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Magnitude of `self` with the sign of another, also of a zero or a NaN.
    fn copysign(self, sign: Self) -> Self;

    /// The rounding error of a sum of two: `self + other - sum`, exactly \[Knuth's two-sum\]; 0 in double.
    #[inline(always)]
    fn sum_error(self, other: Self, sum: Self) -> Self {
        if !Self::IN_TWO {
            return Self::ZERO;
        }
        let part = sum - self;
        (self - (sum - part)) + (other - part)
    }
    /// The rounding error of a product of two: `self * other - product`, exactly \[Dekker\]; 0 in double, whose
    /// rounding is below every requirement.
    ///
    /// Four products of halves, though some processors would need one instruction: not all have it, and these
    /// have the same bits on all.
    #[inline(always)]
    fn product_error(self, other: Self, product: Self) -> Self {
        if !Self::IN_TWO {
            return Self::ZERO;
        }
        let ([a, a_low], [b, b_low]) = (self.halves(), other.halves());
        ((a * b - product) + a * b_low + a_low * b) + a_low * b_low
    }
    /// A number as two of half as many digits \[Veltkamp\], in single precision.
    #[inline(always)]
    fn halves(self) -> [Self; 2] {
        let large = self * Self::from_f64(4097.0);
        let high = large - (large - self);
        [high, self - high]
    }
    /// Square of the polar angle of a vector, from `x^2 + y^2` and `z^2`: what a law of normals is a function of.
    #[inline(always)]
    fn angle_squared(xy2: Self, z2: Self) -> Self {
        let angle = xy2.sqrt().atan2(z2.sqrt());
        angle * angle
    }
    /// `2^-self` of a number that is not negative; may be 0 where that is next to the smallest normal number.
    #[inline(always)]
    fn halved(self) -> Self {
        (self * Self::from_f64(-core::f64::consts::LN_2)).exp()
    }
    /// The smaller of two; the second if either is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    /// The larger of two; the second if either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// Square root of the positive part: 0 where rounding made the argument negative.
    #[inline(always)]
    fn sqrt_positive(self) -> Self {
        self.max(Self::ZERO).sqrt()
    }
    /// Uniform in [0, 1) from a generator; takes one 64-bit word whatever the precision.
    #[inline(always)]
    fn uniform<G: Rng + ?Sized>(generator: &mut G) -> Self {
        Self::from_bits_uniform(generator.next_u64())
    }
}

#[cfg(any(feature = "f32", feature = "f64"))]
macro_rules! implement {
    ($t:ty, $vec:ty, $sqrt:path, $cbrt:path, $sincos:path, $tan:path, $asin:path, $acos:path, $atan2:path,
     $exp:path, $ln:path, $pow:path, $floor:path, $mantissa:expr) => {
        impl Vector<$t> for $vec {
            #[inline(always)]
            fn from_xyz(x: $t, y: $t, z: $t) -> Self {
                Self::new(x, y, z)
            }
            #[inline(always)]
            fn xyz(self) -> [$t; 3] {
                [self.x, self.y, self.z]
            }
            #[inline(always)]
            fn dot(self, other: Self) -> $t {
                self.x * other.x + self.y * other.y + self.z * other.z
            }
            #[inline(always)]
            fn scale(self, by: $t) -> Self {
                self * by
            }
        }

        impl Real for $t {
            type Vec3 = $vec;

            const ZERO: Self = 0.0;
            const HALF: Self = 0.5;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const PI: Self = core::f64::consts::PI as $t;
            const EPSILON: Self = <$t>::EPSILON;
            const MIN_POSITIVE: Self = <$t>::MIN_POSITIVE;
            const MAX: Self = <$t>::MAX;
            const IN_TWO: bool = $mantissa < 30;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn from_bits_uniform(bits: u64) -> Self {
                (bits >> (64 - $mantissa)) as $t * (1.0 / (1_u64 << $mantissa) as $t)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn cbrt(self) -> Self {
                $cbrt(self)
            }
            #[inline]
            fn sin_cos(self) -> (Self, Self) {
                $sincos(self)
            }
            #[inline]
            fn tan(self) -> Self {
                $tan(self)
            }
            #[inline]
            fn asin(self) -> Self {
                $asin(self)
            }
            #[inline]
            fn acos(self) -> Self {
                $acos(self)
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn ln(self) -> Self {
                $ln(self)
            }
            #[inline]
            fn pow(self, exponent: Self) -> Self {
                $pow(self, exponent)
            }
            #[inline]
            fn floor(self) -> Self {
                $floor(self)
            }
            #[inline(always)]
            fn to_index(self) -> usize {
                self as usize
            }
            #[inline(always)]
            fn from_index(index: u32) -> Self {
                index as $t
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$t>::abs(self)
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                <$t>::copysign(self, sign)
            }
        }
    };
}

#[cfg(feature = "f32")]
implement!(
    f32,
    glam::Vec3,
    hardware::sqrt_f32,
    libm::cbrtf,
    libm::sincosf,
    libm::tanf,
    libm::asinf,
    libm::acosf,
    libm::atan2f,
    libm::expf,
    libm::logf,
    libm::powf,
    libm::floorf,
    24
);
/// Power of a number that is not negative.
#[cfg(feature = "f64")]
fn power(x: f64, exponent: f64) -> f64 {
    if exponent == 0.0 { 1.0 } else { libm::exp(exponent * libm::log(x)) }
}

#[cfg(feature = "f64")]
implement!(
    f64,
    glam::DVec3,
    hardware::sqrt_f64,
    libm::cbrt,
    libm::sincos,
    libm::tan,
    libm::asin,
    libm::acos,
    libm::atan2,
    libm::exp,
    libm::log,
    power,
    libm::floor,
    53
);

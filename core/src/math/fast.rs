//! The fast tier: numbers whose elementary functions are polynomials.
//!
//! `Ggx<Fast<f32>>` is the same evaluator as `Ggx<f32>` with the functions of `polynomial.rs` in the
//! place of `libm`'s. Arithmetic and square roots are exact in both, so results that need nothing else have the same
//! bits. Like the exact tier, the fast tier gives the same bits on every machine.

use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

#[cfg(feature = "f64")]
use super::polynomial::double;
#[cfg(feature = "f32")]
use super::polynomial::single;
use super::{Real, Vector, sealed};

/// An `f32` or `f64` of the fast tier.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[repr(transparent)]
pub struct Fast<T>(pub T);

impl<T: fmt::Display> fmt::Display for Fast<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<T: Neg<Output = T>> Neg for Fast<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

/// Three components of the fast tier.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FastVec3<T>([Fast<T>; 3]);

impl<T: Copy + Neg<Output = T>> Neg for FastVec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<T: $trait<Output = T>> $trait for Fast<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

macro_rules! componentwise {
    ($trait:ident, $method:ident) => {
        impl<T: Copy + $trait<Output = T>> $trait for FastVec3<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
                Self([ax.$method(bx), ay.$method(by), az.$method(bz)])
            }
        }
    };
}

componentwise!(Add, add);
componentwise!(Sub, sub);

macro_rules! implement {
    ($t:ident, $functions:ident) => {
        impl sealed::Sealed for Fast<$t> {}

        impl Vector<Fast<$t>> for FastVec3<$t> {
            #[inline(always)]
            fn from_xyz(x: Fast<$t>, y: Fast<$t>, z: Fast<$t>) -> Self {
                Self([x, y, z])
            }
            #[inline(always)]
            fn xyz(self) -> [Fast<$t>; 3] {
                self.0
            }
            #[inline(always)]
            fn dot(self, other: Self) -> Fast<$t> {
                let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
                ax * bx + ay * by + az * bz
            }
            #[inline(always)]
            fn scale(self, by: Fast<$t>) -> Self {
                Self(self.0.map(|x| x * by))
            }
        }

        impl Real for Fast<$t> {
            type Vec3 = FastVec3<$t>;

            const ZERO: Self = Self(0.0);
            const HALF: Self = Self(0.5);
            const ONE: Self = Self(1.0);
            const TWO: Self = Self(2.0);
            const PI: Self = Self(<$t>::PI);
            const EPSILON: Self = Self(<$t>::EPSILON);
            const MIN_POSITIVE: Self = Self(<$t>::MIN_POSITIVE);
            const MAX: Self = Self(<$t>::MAX);
            const IN_TWO: bool = <$t>::IN_TWO;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self(x as $t)
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self.0)
            }
            #[inline(always)]
            fn from_bits_uniform(bits: u64) -> Self {
                Self(<$t>::from_bits_uniform(bits))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(Real::sqrt(self.0))
            }
            #[inline(always)]
            fn cbrt(self) -> Self {
                let root = $functions::exp($functions::ln(self.0.abs()) / 3.0);
                Self(root).copysign(self)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (s, c) = $functions::sin_cos(self.0);
                (Self(s), Self(c))
            }
            #[inline(always)]
            fn tan(self) -> Self {
                let (s, c) = $functions::sin_cos(self.0);
                Self(s / c)
            }
            #[inline(always)]
            fn asin(self) -> Self {
                Self($functions::asin(self.0))
            }
            #[inline(always)]
            fn acos(self) -> Self {
                Self($functions::acos(self.0))
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                Self($functions::atan2(self.0, x.0))
            }
            #[inline(always)]
            fn exp(self) -> Self {
                Self($functions::exp(self.0))
            }
            #[inline(always)]
            fn angle_squared(xy2: Self, z2: Self) -> Self {
                Self($functions::angle_squared(xy2.0, z2.0))
            }
            #[inline(always)]
            fn halved(self) -> Self {
                Self($functions::halved(self.0))
            }
            #[inline(always)]
            fn ln(self) -> Self {
                Self($functions::ln(self.0))
            }
            #[inline(always)]
            fn pow(self, exponent: Self) -> Self {
                Self($functions::pow(self.0, exponent.0))
            }
            #[inline(always)]
            fn floor(self) -> Self {
                Self(Real::floor(self.0))
            }
            #[inline(always)]
            fn to_index(self) -> usize {
                self.0.to_index()
            }
            #[inline(always)]
            fn from_index(index: u32) -> Self {
                Self(Real::from_index(index))
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                self.0.is_finite()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                Self(self.0.copysign(sign.0))
            }
        }
    };
}

#[cfg(feature = "f32")]
implement!(f32, single);
#[cfg(feature = "f64")]
implement!(f64, double);

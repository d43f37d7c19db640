//! Any isotropic density of slopes: the logarithm of the density through `K` knots, and a power of the slope beyond.
//!
//! The knots lie at `s_k = W sinh(3 k / (K - 1)) / sinh 3`: nearly even about 0, geometric farther out, the last at the width `W`.
//! Between them `ln P` is a cubic of `t = asinh(s sinh 3 / W) / 3`, even about 0 and monotone from knot to knot
//! \[Fritsch & Carlson 1980\]. Beyond the last `P` falls as `s^-p`, as steeply as it arrives there, with `p` from 3.1 to 1000.
//! A flat top, a shoulder or a ring, of which no closed form knows, are as good as a peak with a tail.

use super::density::Density;
use super::knots::{Excess, Knots, SINH, Share, place, unplaced};
use crate::math::Real;
use crate::quantity::{Alpha, QuantityError};

/// A density of slopes through `K` knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes<T, const K: usize = 8> {
    width: Alpha<T>,
    given: [T; K],
    /// `ln P`, for slopes in units of their own.
    curve: Knots<T, K>,
    /// `sinh 3` over the width.
    inverse: T,
    /// The share that is steeper and the mean excess, in units of the width.
    share: Share<K>,
    excess: Excess<K>,
    median: T,
}

impl<T: Real, const K: usize> Slopes<T, K> {
    /// The largest logarithm of a knot.
    pub const MOST: f64 = 60.0;

    /// Facets of a density with the logarithms `knots`, relative to any one number, at slopes from 0 to `width`.
    ///
    /// # Errors
    /// [`QuantityError`] if a logarithm is not finite, or outside -60 to 60.
    pub fn new(width: Alpha<T>, knots: [T; K]) -> Result<Self, QuantityError> {
        const { assert!(K >= 4, "a curve needs four knots at least") };
        let most = T::from_f64(Self::MOST);
        for knot in knots {
            if !knot.is_finite() {
                return Err(QuantityError::NotFinite);
            } else if knot < -most {
                return Err(QuantityError::TooSmall);
            } else if knot > most {
                return Err(QuantityError::TooLarge);
            }
        }
        Ok(Self::of(width, knots))
    }

    /// The slope at a knot over the width: 0 to 1.
    pub fn place(knot: usize) -> f64 {
        place(knot as f64 / (K - 1) as f64)[0]
    }

    /// The slope at the last knot.
    pub fn width(&self) -> Alpha<T> {
        self.width
    }

    fn of(width: Alpha<T>, given: [T; K]) -> Self {
        let scale = width.get().to_f64();
        let (curve, share, excess) = Knots::through(given.map(Real::to_f64)).normalised();
        let median = Real::max(scale * share.slope(0.5), Alpha::<T>::LEAST);
        let [inverse, median] = [SINH / scale, median].map(T::from_f64);
        Self { width, given, curve: curve.cast(scale), inverse, share, excess, median }
    }

    fn scale(&self) -> f64 {
        self.width.get().to_f64()
    }
}

impl<T: Real, const K: usize> Density<T> for Slopes<T, K> {
    type In<U: Real> = Slopes<U, K>;

    #[inline]
    fn d(&self, xy2: T, z2: T, _: impl FnOnce() -> [[T; 2]; 2]) -> T {
        let y = (xy2 / z2).sqrt() * self.inverse;
        let t = unplaced(y);
        if t < T::ONE {
            let ratio = (xy2 + z2) / z2;
            return self.curve.at(t).exp() * (ratio * ratio);
        }
        // by logarithms, for a facet may be upright
        let ln_z2 = z2.max(T::MIN_POSITIVE).ln();
        let far = T::TWO * (xy2.sqrt() * self.inverse * T::from_f64(1.0 / SINH)).ln() - ln_z2;
        let upright = (xy2 + z2).ln() - ln_z2;
        (self.curve.last() - T::HALF * self.curve.power() * far + T::TWO * upright).exp()
    }

    fn excess(&self, mu: f64) -> f64 {
        self.scale() * self.excess.over(mu / self.scale())
    }

    fn steeper(&self, slope: f64) -> f64 {
        self.share.above(slope / self.scale())
    }

    fn slope_above(&self, share: f64) -> f64 {
        self.scale() * self.share.slope(share)
    }

    /// The median.
    fn slope(&self) -> T {
        self.median
    }

    fn tail(&self) -> f64 {
        let power = self.curve.power().to_f64();
        Real::max((power - 2.0) / (power - 3.0), 2.0)
    }

    fn cast<U: Real>(&self) -> Slopes<U, K> {
        let most = U::from_f64(Slopes::<U, K>::MOST);
        let knots = self.given.map(|x| U::from_f64(x.to_f64()).max(-most).min(most));
        Slopes::of(self.width.cast(), knots)
    }
}

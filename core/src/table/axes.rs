//! The axes of a table: where a value lies between nodes, and where the nodes are.

use crate::math::Real;

/// Half a facet's slope of the scale `s0` is `r = 1/3`, all beyond it the rest.
///
/// `r = s / (s + s0)` from a slope `s >= 0` and a scale `s0 > 0`, 0 to 1.
pub fn radius<T: Real>(s: T, s0: T) -> T {
    s / (s + s0)
}

/// The slope at a radius below 1.
pub fn slope<T: Real>(r: T, s0: T) -> T {
    s0 * r / (T::ONE - r)
}

/// `y = (1 - c) / (1 + k c)` of a cosine of incidence `c`, 0 at the normal, 1 at grazing.
#[inline(always)]
pub fn incidence_place<T: Real>(c: T, k: T) -> T {
    (T::ONE - c) / (T::ONE + k * c)
}

/// The cosine at `y`.
pub fn incidence_cosine<T: Real>(y: T, k: T) -> T {
    (T::ONE - y) / (T::ONE + k * y)
}

/// A cell of an axis and the share of its upper node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place<T> {
    /// Number of the lower node.
    pub cell: usize,
    /// 0 at the lower node, 1 at the upper.
    pub share: T,
}

impl<T: Real> Place<T> {
    /// Between `nodes >= 2` even nodes, for `x` in [0, 1]; beyond by rounding, a share is beyond by rounding.
    #[inline(always)]
    pub fn of(x: T, nodes: u16) -> Self {
        let scaled = x * whole(nodes.wrapping_sub(1));
        let cell = scaled.to_index().min(usize::from(nodes.wrapping_sub(2)));
        Self { cell, share: scaled - whole(cell as u16) }
    }

    /// The value between two.
    #[inline(always)]
    pub fn mix(self, low: T, high: T) -> T {
        low + self.share * (high - low)
    }
}

/// A small whole number; exact, and a single conversion where the device has one.
#[inline(always)]
pub(super) fn whole<T: Real>(n: u16) -> T {
    T::from_f64(f64::from(n))
}

/// A stored parameter.
#[inline(always)]
pub(super) fn real<T: Real>(x: f32) -> T {
    T::from_f64(f64::from(x))
}

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

/// `y = (1 + k) t / (1 + k t)` with `t = tan(theta / 2) = s / (1 + c)` of an angle of incidence with the sine `s` and the
/// cosine `c`: 0 at the normal, 1 at grazing, and even at both ends, since a lobe moves with the sine near the normal and
/// with the cosine near grazing.
#[inline(always)]
pub fn incidence_place<T: Real>(s: T, c: T, k: T) -> T {
    (s + k * s) / (T::ONE + c + k * s)
}

/// The cosine at `y`.
pub fn incidence_cosine<T: Real>(y: T, k: T) -> T {
    let t = y / (T::ONE + k - k * y);
    (T::ONE - t) * (T::ONE + t) / (T::ONE + t * t)
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
    /// Of `x` in [0, 1], or beyond by rounding, on an axis of so many [`cells`].
    #[inline(always)]
    pub fn of(x: T, cells: f32) -> Self {
        let scaled = x * real(cells);
        let cell = scaled.to_index();
        Self { cell, share: scaled - T::from_index(cell as u32) }
    }

    /// The value between two.
    #[inline(always)]
    pub fn mix(self, low: T, high: T) -> T {
        low + self.share * (high - low)
    }
}

/// Steps of the gain within a cell of incidence.
pub const GAIN_STEPS: u16 = 8;

/// A cell of incidence, and the value of a stored unit there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Incidence<T> {
    pub(super) place: Place<T>,
    /// Number of the nearer node.
    pub(super) nearest: usize,
    pub(super) gain: T,
}

impl<T: Real> Incidence<T> {
    /// Of `y` in [0, 1] on an axis of so many [`cells`] of gains.
    #[inline(always)]
    pub(super) fn of(y: T, cells: f32, gains: &[f32]) -> Option<Self> {
        let steps = usize::from(GAIN_STEPS);
        let scaled = y * real(cells);
        let step = scaled.to_index();
        let &[a, b] = gains.get(step..)?.first_chunk()?;
        let gain =
            Place { cell: step, share: scaled - T::from_index(step as u32) }.mix(real(a), real(b));
        let cell = step / steps;
        let share = scaled * T::from_f64(1.0 / f64::from(GAIN_STEPS)) - T::from_index(cell as u32);
        Some(Self { place: Place { cell, share }, nearest: (step + steps / 2) / steps, gain })
    }
}

/// What makes a place that rounding sends past the last node stay before it.
pub(super) const INWARDS: f32 = 1.0 - 4e-6;

/// Cells between so many nodes, at least one, a hair less.
pub const fn cells(nodes: u16) -> f32 {
    steps(nodes, 1.0)
}

/// The same times a number of steps in each cell.
#[inline(always)]
pub(super) const fn steps(nodes: u16, each: f32) -> f32 {
    (nodes as f32 - 1.0) * (INWARDS * each)
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

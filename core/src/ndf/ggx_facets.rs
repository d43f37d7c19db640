//! GGX as a density like the others, in closed forms where Student-t of exponent 2 takes series.

use super::density::Density;
use super::ggx;
use crate::direction::Direction;
use crate::math::Real;
use crate::quantity::Alpha;

/// The facets of [`crate::bsdf::Ggx`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxFacets<T> {
    /// Width of the slope distribution.
    pub alpha: Alpha<T>,
}

impl<T: Real> GgxFacets<T> {
    /// Facets of a given width.
    pub fn new(alpha: Alpha<T>) -> Self {
        Self { alpha }
    }

    fn wide(&self) -> f64 {
        self.alpha.get().to_f64()
    }
}

impl<T: Real> Density<T> for GgxFacets<T> {
    type In<U: Real> = GgxFacets<U>;

    #[inline(always)]
    fn d(&self, xy2: T, z2: T, _: impl FnOnce() -> [[T; 2]; 2]) -> T {
        ggx::d_of_vector(self.alpha.get(), xy2, z2)
    }

    fn excess(&self, mu: f64) -> f64 {
        // (sqrt(mu^2 + a^2) - mu) / 2
        let square = self.wide() * self.wide();
        0.5 * square / (mu + Real::sqrt(mu * mu + square))
    }

    fn steeper(&self, slope: f64) -> f64 {
        let ratio = slope / self.wide();
        1.0 / (1.0 + ratio * ratio)
    }

    fn slope_above(&self, share: f64) -> f64 {
        let share = Real::max(share, f64::MIN_POSITIVE);
        self.wide() * Real::sqrt_positive((1.0 - share) / share)
    }

    fn slope(&self) -> T {
        self.alpha.get()
    }

    fn cast<U: Real>(&self) -> GgxFacets<U> {
        GgxFacets { alpha: self.alpha.cast() }
    }

    fn sample_visible(&self, w: Direction<T>, u: [T; 2]) -> Direction<T> {
        let [x, y, z] = w.xyz();
        ggx::sample_visible(self.alpha, Direction::from_unit(x, y, z.abs()), u)
    }

    /// The spherical cap of visible reflections serves both sides.
    fn sample_facing(&self, w: Direction<T>, u: [T; 2]) -> Direction<T> {
        ggx::sample_visible(self.alpha, w, u)
    }
}

//! The Beckmann density: Gaussian slopes \[Beckmann & Spizzichino 1963; Walter2007, eqs 25-28\].

use core::f64::consts::{FRAC_1_PI, PI};

use super::density::Density;
use crate::math::{Real, special};
use crate::quantity::Alpha;

/// `D = exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4)`; the rms slope along any azimuth is `alpha / sqrt 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann<T> {
    /// Width of the slope distribution.
    pub alpha: Alpha<T>,
}

impl<T: Real> Beckmann<T> {
    /// Facets of a given width.
    pub fn new(alpha: Alpha<T>) -> Self {
        Self { alpha }
    }
}

impl<T: Real> Density<T> for Beckmann<T> {
    type In<U: Real> = Beckmann<U>;

    #[inline(always)]
    fn d(&self, xy2: T, z2: T, _: impl FnOnce() -> [[T; 2]; 2]) -> T {
        let a = self.alpha.get();
        // 1 / (alpha cos^2); where it has no bound the exponential is 0
        let scale = (xy2 + z2) / (a * z2);
        let fall = (-xy2 / (a * a * z2)).exp();
        if fall > T::ZERO { scale * scale * fall * T::from_f64(FRAC_1_PI) } else { T::ZERO }
    }

    fn excess(&self, mu: f64) -> f64 {
        let a = self.alpha.get().to_f64();
        let nu = mu / a;
        // beyond this it is below 1e-18 of mu
        if nu >= 6.0 {
            return 0.0;
        }
        let fall = 0.5 * a * Real::exp(-nu * nu) / Real::sqrt(PI);
        Real::max(fall - 0.5 * mu * (1.0 - special::erf(nu)), 0.0)
    }

    fn steeper(&self, slope: f64) -> f64 {
        let y = slope / self.alpha.get().to_f64();
        Real::exp(-y * y)
    }

    fn slope_above(&self, share: f64) -> f64 {
        self.alpha.get().to_f64()
            * Real::sqrt_positive(-Real::ln(Real::max(share, f64::MIN_POSITIVE)))
    }

    fn slope(&self) -> T {
        self.alpha.get()
    }

    fn cast<U: Real>(&self) -> Beckmann<U> {
        Beckmann { alpha: self.alpha.cast() }
    }
}

//! Polar angles inside a plate, and how fine the rules over them are.

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_core::fresnel;

use super::returns::passes_by;

/// A polar angle inside, measured from the normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polar {
    pub(super) theta: f64,
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// Share of light scattered this way that arrives at the rough face again, over all passes that keep its direction.
    pub(super) kept: f64,
    /// Number of passes.
    pub(super) times: f64,
}

impl Polar {
    pub(super) fn new<B: Bsdf<f64>>(theta: f64, eta: f64, boundary: &B) -> Self {
        let (sin, cos) = theta.sin_cos();
        let kept = fresnel::dielectric(cos, 1.0 / eta).reflected;
        let times = passes_by(boundary, cos, kept);
        Self { theta, sin, cos, kept: kept * times, times }
    }

    /// The direction from which light arrives at the rough face, at an azimuth of this cosine and sine.
    pub(super) fn from(&self, cos: f64, sin: f64) -> Direction<f64> {
        Direction::from_unit(-self.sin * cos, self.sin * sin, -self.cos)
    }

    /// The direction in which it left the rough face before.
    pub(super) fn towards(&self, cos: f64, sin: f64) -> Direction<f64> {
        Direction::from_unit(self.sin * cos, -self.sin * sin, -self.cos)
    }
}

/// Sizes of the rules for a lobe of given width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// Azimuthal modes.
    pub(super) modes: usize,
    /// Distances of polar angles: of the kernel, of what a first hit sends, and of observation in the air.
    pub(super) step: f64,
    pub(super) fine: f64,
    pub(super) views: f64,
    /// Polar angles of a panel of a graded rule, at the peak and beyond.
    pub(super) panel: usize,
    pub(super) beyond: usize,
    /// The same where two lobes meet.
    pub(super) pair: usize,
}

impl Sizes {
    pub(super) fn new(slope: f64) -> Self {
        // where facets begin to mirror totally the kernel rises with a root, however wide the law is
        let step = (1.1 * slope).clamp(0.02, 0.03);
        Self {
            modes: (4.0 / slope).clamp(16.0, 256.0) as usize,
            step,
            fine: if slope < 0.1 { step } else { 0.015 },
            views: step,
            panel: 12, // tails of two narrow lobes meet where each has fallen far
            beyond: 8,
            pair: if slope < 0.1 { 10 } else { 8 },
        }
    }
}

//! How many rays a fit traces.

/// Rays per incidence in a fit that traces them.
///
/// All evaluations of a stage use the same seed, so that they differ only by the surface; the final figures use
/// another seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FitRays {
    /// In the search for a start.
    pub draft: u64,
    /// In the fit; `None`: as many as bring their noise to [`FitRays::FIT_NOISE_PERCENT`].
    pub fit: Option<u64>,
    /// For the final figures; `None`: as many as bring their noise below [`FitRays::NOISE_PERCENT`].
    pub last: Option<u64>,
    /// The seed of the fit; the final figures use the next one.
    pub seed: u64,
}

impl FitRays {
    /// Target noise of the final figures in terms of eq. (18), %.
    pub const NOISE_PERCENT: f64 = 0.2;
    /// Target noise of a simulation in the fit, %: some of it cancels in the cost.
    pub const FIT_NOISE_PERCENT: f64 = 1.3;
    /// Rays per incidence that are spent on the aims, in the fit and for the final figures.
    pub(super) const IN_FIT: (f64, f64) = (2e4, 4e6);
    pub(super) const MOST: f64 = 1e8;

    /// The number of rays that reduce a noise to a target.
    pub(super) fn for_noise(count: u64, percent: f64, aim_percent: f64) -> f64 {
        count as f64 * (percent / aim_percent).powi(2)
    }
}

impl Default for FitRays {
    fn default() -> Self {
        Self { draft: 8_000, fit: None, last: None, seed: 1 }
    }
}

//! Flux of rays, gathered by the angle at which they leave.

use crate::waves::Kind;

/// Width of a bin, degrees: windows of whole degrees consist of whole bins.
const BIN_DEG: f64 = 0.25;
const BINS: usize = 720;

/// Flux over the angle, as shares of the incident flux.
#[derive(Clone, Debug)]
pub struct Angles {
    bins: Vec<f64>,
}

/// The light of one polarisation that leaves on both sides.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// Light that goes back into the medium it came from.
    pub reflected: Angles,
    /// Light that goes into the other one.
    pub transmitted: Angles,
}

impl Default for Angles {
    fn default() -> Self {
        Self { bins: vec![0.0; BINS] }
    }
}

impl Angles {
    /// Adds flux at an angle from the normal whose sine is given.
    pub(crate) fn add(&mut self, sine: f64, flux: f64) {
        let angle = sine.clamp(-1.0, 1.0).asin().to_degrees();
        let bin = ((angle + 90.0) / BIN_DEG) as usize;
        self.bins[bin.min(BINS - 1)] += flux;
    }

    /// All of it.
    pub fn total(&self) -> f64 {
        self.bins.iter().sum()
    }

    /// Flux between two angles, degrees; a bin counts as even.
    pub fn between(&self, low_deg: f64, high_deg: f64) -> f64 {
        let (low, high) = ((low_deg + 90.0) / BIN_DEG, (high_deg + 90.0) / BIN_DEG);
        let (low, high) = (low.clamp(0.0, BINS as f64), high.clamp(0.0, BINS as f64));
        let last = (high.ceil() as usize).min(BINS);
        let share = |bin: usize| ((bin + 1) as f64).min(high) - (bin as f64).max(low);
        (low as usize..last).map(|bin| self.bins[bin] * share(bin).max(0.0)).sum()
    }

    /// Flux per degree, mean over a window of full width `window_deg` about an angle.
    pub fn density(&self, angle_deg: f64, window_deg: f64) -> f64 {
        let half = 0.5 * window_deg;
        self.between(angle_deg - half, angle_deg + half) / window_deg
    }
}

impl Gathered {
    /// The light of a kind.
    pub fn of(&self, kind: Kind) -> &Angles {
        match kind {
            Kind::Reflected => &self.reflected,
            Kind::Transmitted => &self.transmitted,
        }
    }

    pub(crate) fn of_mut(&mut self, kind: Kind) -> &mut Angles {
        match kind {
            Kind::Reflected => &mut self.reflected,
            Kind::Transmitted => &mut self.transmitted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Angles;

    #[test]
    fn windows_share_the_flux() {
        let mut angles = Angles::default();
        angles.add(0.5, 0.3);
        angles.add(-1.0, 0.2);
        angles.add(1.0, 0.1);
        assert!((angles.total() - 0.6).abs() < 1e-15);
        assert!((angles.between(-90.0, 90.0) - 0.6).abs() < 1e-15);
        let windows: f64 =
            (-45..45).map(|i| 2.0 * angles.density(2.0 * f64::from(i) + 1.0, 2.0)).sum();
        assert!((windows - 0.6).abs() < 1e-12);
        assert!(
            (angles.between(30.0, 30.125) - 0.15).abs() < 1e-12
                || angles.between(29.75, 30.0) > 0.29
        );
    }
}

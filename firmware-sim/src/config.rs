//! What is simulated: a sample, and an instrument with its faults of nature.

use asperity_core::bsdf::Normals;
use asperity_core::gonio::Geometry;
use asperity_core::ndf::law::Law;
use asperity_core::ndf::normals::NormalDensity;
use asperity_core::plate::RoughSide;
use asperity_core::protocol::{AxisLimits, Microdegrees};
use asperity_core::quantity::{Alpha, RelativeIor};

/// Photocurrent of the beam without a sample, nA, new lamp: four fifths of the coarsest range, so that
/// noise and a drift of some percent do not run over it.
pub(crate) const OPEN_BEAM_NA: f32 = 800.0;

/// The sample's axis.
pub(crate) const SIGMA: AxisLimits =
    AxisLimits { least: Microdegrees(0), most: Microdegrees(85_000_000), speed: 10_000_000 };

/// The detector's axis.
pub(crate) const THETA: AxisLimits = AxisLimits {
    least: Microdegrees(-95_000_000),
    most: Microdegrees(95_000_000),
    speed: 20_000_000,
};

/// The rough face of the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one, and nothing to allocate from")]
pub enum Boundary {
    /// GGX facets of this width.
    Ggx(f32),
    /// Facets with a given law of their normals.
    Normals(Normals<f32, 64>),
    /// No roughness at all.
    Smooth,
}

/// A sample and an instrument. All durations are divided by `acceleration`, but not the silence limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The rough face. A width outside the domain of [`Alpha`] is a black sample.
    pub boundary: Boundary,
    /// Index of the plate; outside the domain of [`RelativeIor`] the sample is black.
    pub ior: f32,
    /// Which way the rough face looks.
    pub rough_side: RoughSide,
    /// On which side of the plate the detector moves.
    pub geometry: Geometry,
    /// Rays for one incidence.
    pub rays: u32,
    /// Of the rays and of the noise.
    pub seed: u64,
    /// Serial number.
    pub serial: u32,
    /// How many times faster than a real one the instrument moves, measures and ages; >= 1.
    pub acceleration: u32,
    /// How long an owner may be silent, microseconds of the line's clock.
    pub silence_us: u32,
    /// Play of the detector's axis; >= 0.
    pub backlash: Microdegrees,
    /// Relative change of the lamp in an hour since power-on.
    pub drift_per_hour: f32,
    /// Dark current of range 0, nA; a twentieth more in each finer range.
    pub dark_na: f32,
    /// Noise: the variance of a current `I` over a time `T` is this times `I / T`; nA s.
    pub shot_na_s: f32,
}

impl Config {
    /// The instrument that firmware and tests agree upon: GGX of width 0.2, index 1.49, rough side to
    /// the source, transmission, 20 000 rays, no drift.
    ///
    /// The dark current fits the finest range (0.01 nA); 10 ms of the open beam have a noise of 1e-4.
    pub const fn demo() -> Self {
        Self {
            boundary: Boundary::Ggx(0.2),
            ior: 1.49,
            rough_side: RoughSide::Source,
            geometry: Geometry::Transmission,
            rays: 20_000,
            seed: 0x0905_1720_0000_0001,
            serial: 200_001,
            acceleration: 1,
            silence_us: 5_000_000,
            backlash: Microdegrees(50_000),
            drift_per_hour: 0.0,
            dark_na: 0.004,
            shot_na_s: 1e-7,
        }
    }

    /// The instrument of the emulated board: [`demo`](Self::demo), a thousand times faster than a real one.
    pub const fn emulated() -> Self {
        Self { acceleration: 1000, ..Self::demo() }
    }

    /// The same with facets of a given law, in radians.
    ///
    /// `None` if the index is outside its domain.
    pub fn with_normals(self, law: Law<f32>) -> Option<Self> {
        let eta = RelativeIor::new(self.ior).ok()?;
        let normals = Normals::new(NormalDensity::new(law), eta);
        Some(Self { boundary: Boundary::Normals(normals), ..self })
    }

    /// Whether the sample is one: all its numbers are in their domains.
    pub fn is_valid(&self) -> bool {
        let numbers = [self.drift_per_hour, self.dark_na, self.shot_na_s];
        let face = match self.boundary {
            Boundary::Ggx(alpha) => Alpha::new(alpha).is_ok(),
            Boundary::Normals(_) | Boundary::Smooth => true,
        };
        face && RelativeIor::new(self.ior).is_ok()
            && numbers.iter().all(|x| x.is_finite())
            && self.dark_na >= 0.0
            && self.shot_na_s >= 0.0
            && self.rays > 0
            && self.acceleration > 0
            && self.backlash.0 >= 0
    }

    /// A duration of the machine by the clock of the line, microseconds.
    pub(crate) const fn scaled(&self, us: u64) -> u64 {
        match self.acceleration {
            0 => us,
            k => us.div_ceil(k as u64),
        }
    }

    /// An axis with its speed by the clock of the line.
    pub(crate) const fn limits(&self, limits: AxisLimits) -> AxisLimits {
        let speed = match self.acceleration {
            0 => limits.speed,
            k => limits.speed.saturating_mul(k),
        };
        AxisLimits { speed, ..limits }
    }
}

impl Default for Config {
    fn default() -> Self {
        Self::demo()
    }
}

#[cfg(test)]
mod tests {
    use super::{Boundary, Config, SIGMA};

    #[test]
    fn only_what_is_in_its_domain_is_valid() {
        let good = Config::demo();
        assert!(good.is_valid());
        assert!(Config { boundary: Boundary::Smooth, ..good }.is_valid());
        for bad in [
            Config { boundary: Boundary::Ggx(0.0), ..good },
            Config { ior: f32::NAN, ..good },
            Config { rays: 0, ..good },
            Config { acceleration: 0, ..good },
            Config { shot_na_s: -1.0, ..good },
            Config { dark_na: f32::INFINITY, ..good },
        ] {
            assert!(!bad.is_valid(), "{bad:?}");
        }
    }

    #[test]
    fn durations_shrink_and_speeds_grow() {
        let fast = Config { acceleration: 1000, ..Config::demo() };
        assert_eq!((fast.scaled(10_000), fast.scaled(1)), (10, 1));
        assert_eq!(fast.limits(SIGMA).speed, u32::MAX);
        assert_eq!(Config { acceleration: 3, ..fast }.limits(SIGMA).speed, 30_000_000);
    }
}

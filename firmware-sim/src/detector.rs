//! From light to numbers: photocurrent, dark current, noise, ranges, a converter of 16 bits.

use asperity_core::math::Real;
use asperity_core::protocol::{Microdegrees, RANGES, Range, Reading};
use rand_pcg::Pcg32;

use crate::clock::Instant;
use crate::config::{Config, OPEN_BEAM_NA};
use crate::digest::Digest;

/// Current that the ranges measure at most, nA.
const FULL_SCALE_NA: [f32; RANGES as usize] = [1000.0, 100.0, 10.0, 1.0, 0.1, 0.01];

/// Steps of the converter to either side of zero.
const STEPS: f32 = 32767.0;

/// What the detector looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum View {
    /// The light of the sample, as a share of the beam, with the arm here.
    Sample { sigma: Microdegrees, arm: i32 },
    /// The closed shutter.
    Dark,
    /// The beam, the sample withdrawn.
    Beam,
}

/// One measurement: all that its value depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    pub(crate) view: View,
    /// Light on the detector, relative to the beam.
    pub(crate) relative: f32,
    pub(crate) aperture: Microdegrees,
    pub(crate) integration_us: u32,
    /// When it is read; a lamp drifts.
    pub(crate) now: Instant,
}

/// Reads the detector; `dark` are the currents of the calibration.
pub(crate) fn read(
    config: &Config,
    exposure: &Exposure,
    range: Range,
    dark: Option<&[f32; RANGES as usize]>,
) -> Reading {
    let finest = match range {
        Range::Fixed(range) => range.min(RANGES - 1),
        Range::Auto => {
            (1..RANGES).rev().find(|&range| !convert(config, exposure, range).1).unwrap_or(0)
        }
    };
    let (signal, over) = convert(config, exposure, finest);
    let under = matches!(range, Range::Fixed(_))
        && finest + 1 < RANGES
        && !convert(config, exposure, finest + 1).1;
    let dark = dark.and_then(|dark| dark.get(usize::from(finest))).copied().unwrap_or(0.0);
    Reading { signal, dark, range: finest, over, under }
}

/// What the converter says in a range, nA, and whether it was too much.
fn convert(config: &Config, exposure: &Exposure, range: u8) -> (f32, bool) {
    let full = FULL_SCALE_NA.get(usize::from(range)).copied().unwrap_or(OPEN_BEAM_NA);
    let current = current(config, exposure, range);
    let code = (current / full * STEPS + 0.5).floor();
    let over = code >= STEPS;
    (code.clamp(-STEPS, STEPS) * (full / STEPS), over)
}

/// The current before conversion, nA.
fn current(config: &Config, exposure: &Exposure, range: u8) -> f32 {
    let light = match exposure.view {
        View::Sample { .. } | View::Beam => exposure.relative * lamp(config, exposure.now),
        View::Dark => 0.0,
    };
    let dark = config.dark_na * (1.0 + 0.05 * f32::from(range));
    let mean = OPEN_BEAM_NA * light + dark;
    let seconds = exposure.integration_us as f32 / 1e6;
    let deviation = (config.shot_na_s * mean.abs() / seconds).sqrt_positive();
    mean + deviation * gaussian(&mut noise(config, exposure, range))
}

/// Power of the lamp, relative to that at power-on.
fn lamp(config: &Config, now: Instant) -> f32 {
    let us = now.0 as f32 * config.acceleration as f32;
    (1.0 + config.drift_per_hour * (us / 3.6e9)).max(0.0)
}

/// The noise of a measurement depends on what is measured, not on when: repeated, it repeats its bits.
fn noise(config: &Config, exposure: &Exposure, range: u8) -> Pcg32 {
    let (kind, sigma, arm) = match exposure.view {
        View::Sample { sigma, arm } => (0, sigma.0, arm),
        View::Dark => (1, 0, 0),
        View::Beam => (2, 0, 0),
    };
    let mut key = Digest::new();
    key.word(kind);
    key.word(u64::from(sigma.cast_unsigned()) << 32 | u64::from(arm.cast_unsigned()));
    key.word(u64::from(range) << 32 | u64::from(exposure.integration_us));
    key.word(u64::from(exposure.aperture.0.cast_unsigned()));
    Pcg32::new(key.finish(), config.seed)
}

/// A normal deviate: Box and Muller's cosine.
fn gaussian(generator: &mut Pcg32) -> f32 {
    let (u, v) = (f32::uniform(generator), f32::uniform(generator));
    // 1 - u is in (0, 1]
    (-2.0 * Real::ln(1.0 - u)).sqrt_positive() * Real::sin_cos(2.0 * f32::PI * v).1
}

#[cfg(test)]
mod tests {
    use super::{Exposure, FULL_SCALE_NA, STEPS, View, read};
    use crate::clock::Instant;
    use crate::config::Config;
    use asperity_core::protocol::{Microdegrees, RANGES, Range};

    fn at(relative: f32, arm: i32) -> Exposure {
        Exposure {
            view: View::Sample { sigma: Microdegrees(0), arm },
            relative,
            aperture: Microdegrees(600_000),
            integration_us: 10_000,
            now: Instant(0),
        }
    }

    fn quiet() -> Config {
        Config { shot_na_s: 0.0, dark_na: 0.0, ..Config::demo() }
    }

    #[test]
    fn the_finest_range_that_holds_the_signal_is_chosen() {
        // 800 nA times these
        for (relative, range) in
            [(1.0, 0), (0.126, 0), (0.124, 1), (0.0124, 2), (1.24e-3, 3), (1.2e-4, 4), (1.2e-5, 5)]
        {
            let got = read(&quiet(), &at(relative, 0), Range::Auto, None);
            assert_eq!((got.range, got.over, got.under), (range, false, false), "{relative}");
            let step = FULL_SCALE_NA[usize::from(range)] / STEPS;
            assert!((got.signal - 800.0 * relative).abs() <= 0.51 * step, "{relative} {got:?}");
        }
        let dark = read(&quiet(), &at(0.0, 0), Range::Auto, None);
        assert_eq!((dark.range, dark.signal.to_bits()), (RANGES - 1, 0));
        assert!(read(&quiet(), &at(2.0, 0), Range::Auto, None).over);
    }

    #[test]
    fn a_fixed_range_says_that_it_is_too_fine_or_too_coarse() {
        let got = |range| read(&quiet(), &at(0.01, 0), Range::Fixed(range), None);
        assert!(got(2).signal > 7.9 && !got(2).over && !got(2).under);
        assert!(got(1).under && !got(1).over && got(0).under);
        assert!(got(3).over && !got(3).under);
        assert_eq!(got(3).signal.to_bits(), 1.0_f32.to_bits(), "cut off at full scale");
    }

    #[test]
    fn noise_has_its_variance_and_no_bias() {
        let config = Config { dark_na: 0.0, ..Config::demo() };
        let (mut sum, mut squares, mut fourth) = (0.0, 0.0, 0.0);
        let count = 20_000;
        for arm in 0..count {
            let got = f64::from(read(&config, &at(0.05, arm), Range::Fixed(1), None).signal);
            let x = (got - 40.0) / (1e-7_f64 * 40.0 / 0.01).sqrt();
            (sum, squares, fourth) = (sum + x, squares + x * x, fourth + x * x * x * x);
        }
        let n = f64::from(count);
        assert!((sum / n).abs() < 4.0 / n.sqrt(), "{}", sum / n);
        assert!((squares / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt() + 0.01, "{}", squares / n);
        assert!((fourth / n - 3.0).abs() < 0.3, "{}", fourth / n);
        // four times the time, half the noise
        let long = Exposure { integration_us: 40_000, ..at(0.05, 0) };
        let spread = |exposure: Exposure| {
            let square = |arm| {
                let view = View::Sample { sigma: Microdegrees(0), arm };
                let reading = read(&config, &Exposure { view, ..exposure }, Range::Fixed(1), None);
                (f64::from(reading.signal) - 40.0).powi(2)
            };
            ((0..5000).map(square).sum::<f64>() / 5000.0).sqrt()
        };
        assert!((spread(long) / spread(at(0.05, 0)) - 0.5).abs() < 0.03);
    }

    #[test]
    fn a_measurement_repeats_its_bits_and_others_differ() {
        let config = Config::demo();
        let bits = |e: Exposure| read(&config, &e, Range::Fixed(0), None).signal.to_bits();
        let first = at(0.9, 5);
        assert_eq!(bits(first), bits(Exposure { now: Instant(99), ..first }));
        assert_ne!(bits(first), bits(at(0.9, 6)));
        assert_ne!(bits(first), bits(Exposure { integration_us: 10_001, ..first }));
        assert_ne!(bits(first), bits(Exposure { aperture: Microdegrees(1), ..first }));
    }

    #[test]
    fn the_lamp_drifts_by_the_hours_of_the_machine() {
        let config = Config { drift_per_hour: -0.1, acceleration: 3600, ..quiet() };
        let later = Exposure { now: Instant(1_000_000), ..at(1.0, 0) };
        let got = read(&config, &later, Range::Auto, None).signal;
        assert!((got - 720.0).abs() < 0.1, "{got}");
        let closed = Exposure { view: View::Dark, ..later };
        assert!(read(&config, &closed, Range::Auto, None).signal.abs() < 1e-9);
    }
}

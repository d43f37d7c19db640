//! A piece of a measured line as one period of grooves.
//!
//! 1. The piece is `period + crossfade` long, levelled by its least squares line.
//! 2. Its last part fades into its first one over the crossfade: `h(x) sin(p) + h(x + period) cos(p)`, `p = pi/4 (1 - cos(pi x /
//!    crossfade))`. The weights keep the variance of heights that do not know of each other, and have no slope at either end.
//! 3. A Gaussian low-pass: a wave of length w keeps `exp(-ln 2 (cutoff / w)^2)` of its amplitude, a half at the cut-off.
//! 4. x is stretched by the least part that keeps orders off the horizon in air and in the dielectric.
//!
//! Light of wavelength w in vacuum never leaves, in first order, from a wave of the surface shorter than `w / 2n`, whatever its incidence. The
//! usual cut-off, `w / 3n`, leaves 0.73 of the amplitude of that one and 0.93 of the one of length `w / n`.

use std::f64::consts::{LN_2, PI};

use thiserror::Error;

use crate::profile::{Profile, ProfileError};
use crate::series::Series;

/// How pieces become periodic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOptions {
    /// Length of a period that is asked for, um. What is made is a whole number of pixels, stretched by a thousandth or less.
    pub period_um: f64,
    /// Part of the period over which its ends fade into each other, 0.02 to 0.5.
    pub crossfade: f64,
    /// Cut-off of the low-pass, um; 0: none.
    pub cutoff_um: f64,
    /// Index of the dielectric.
    pub index: f64,
    /// Wavelength in vacuum, um.
    pub wavelength_um: f64,
}

/// Height and slope of a line, both rms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Rms height about the mean, um.
    pub rq_um: f64,
    /// Rms of the differences of neighbours over the pitch.
    pub rms_slope: f64,
}

/// A profile, and what became of the piece that it is made of.
#[derive(Clone, Debug)]
pub struct Cut {
    /// One period.
    pub profile: Profile,
    /// The levelled piece, crossfade included.
    pub measured: Shape,
    /// After the crossfade.
    pub joined: Shape,
    /// After the low-pass, at the same pitch.
    pub filtered: Shape,
    /// Rms slope of the profile itself, between the heights too.
    pub profile_slope: f64,
    /// Length of the crossfade, um.
    pub crossfade_um: f64,
    /// Factor of all lengths along x.
    pub stretch: f64,
}

/// Why a line cannot be cut.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CutError {
    /// A setting out of range.
    #[error("{what} is {range}, not {value}")]
    Setting {
        /// Which one.
        what: &'static str,
        /// What it may be.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// The line ends before the piece.
    #[error(
        "a cut takes {needed} heights, and the line has {left} from number {start} on; ask for a shorter period"
    )]
    TooShort {
        /// Heights of a piece.
        needed: usize,
        /// Where it begins.
        start: usize,
        /// Heights that are left from there.
        left: usize,
    },
    /// A height that is not a number.
    #[error("height {0} of the line is missing; fill it or cut elsewhere")]
    Missing(usize),
    /// What is no profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
}

/// The least number of pixels in a period.
const LEAST_PIXELS: usize = 16;
/// How far, in orders, the horizon has to be from the nearest order.
const OFF: f64 = 0.05;
/// Amplitude in wavelengths up to which the last harmonics are left out.
const NOTHING: f64 = 1e-6;

impl CutOptions {
    /// The usual crossfade, 0.25, and cut-off, `wavelength / 3 index`.
    pub fn new(period_um: f64, index: f64, wavelength_um: f64) -> Self {
        let cutoff_um = wavelength_um / (3.0 * index);
        Self { period_um, crossfade: 0.25, cutoff_um, index, wavelength_um }
    }

    /// How many heights of a line a piece takes.
    ///
    /// # Errors
    /// A setting or a pitch out of range.
    pub fn needed(&self, pitch_um: f64) -> Result<usize, CutError> {
        let (period, crossfade) = self.pixels(pitch_um)?;
        Ok(period + crossfade)
    }

    /// Where pieces begin in a line of `count` heights: as many as find room without a height in two of them, evenly spread.
    ///
    /// # Errors
    /// A setting or a pitch out of range.
    pub fn starts(&self, count: usize, pitch_um: f64) -> Result<Vec<usize>, CutError> {
        let needed = self.needed(pitch_um)?;
        let pieces = count / needed;
        let rest = count - pieces * needed;
        Ok((0..pieces).map(|i| i * needed + rest * (2 * i + 1) / (2 * pieces)).collect())
    }

    /// One period from the heights of a line (um, `pitch_um` apart) from number `start` on. All cuts of one pitch have the same
    /// period.
    ///
    /// # Errors
    /// A setting or a pitch out of range, a line that ends too early, a missing height.
    pub fn cut(&self, line_um: &[f64], pitch_um: f64, start: usize) -> Result<Cut, CutError> {
        let (count, crossfade) = self.pixels(pitch_um)?;
        let needed = count + crossfade;
        let left = line_um.len().saturating_sub(start);
        if left < needed {
            return Err(CutError::TooShort { needed, start, left });
        }
        let piece = &line_um[start..start + needed];
        if let Some(at) = piece.iter().position(|h| !h.is_finite()) {
            return Err(CutError::Missing(start + at));
        }
        let levelled = levelled(piece);
        let joined = joined(&levelled, count);
        let stretch = self.stretch(count as f64 * pitch_um);
        let period = count as f64 * pitch_um * stretch;
        let gain = |k: usize| match k {
            0 => 0.0,
            _ if 2 * k == count => 0.0, // its phase is not known
            _ => (-LN_2 * (self.cutoff_um * k as f64 / period).powi(2)).exp(),
        };
        let series = Series::new(&joined, period, 0.0).scaled(gain);
        let at = |count: usize| -> Vec<f64> {
            (0..count).map(|i| series.at(period * i as f64 / count as f64).value).collect()
        };
        let filtered = at(count);
        let short = series.clone().shortened(NOTHING * self.wavelength_um);
        let kept = (2 * short.highest() + 2).max(Profile::LEAST);
        let fine = 4 * kept;
        let slope = |i: usize| short.at(period * i as f64 / fine as f64).slope;
        let square = (0..fine).map(|i| slope(i).powi(2)).sum::<f64>() / fine as f64;
        let heights = (0..kept).map(|i| short.at(period * i as f64 / kept as f64).value).collect();
        Ok(Cut {
            profile: Profile::new(heights, period)?,
            measured: Shape::of(&levelled, pitch_um, false),
            joined: Shape::of(&joined, pitch_um, true),
            filtered: Shape::of(&filtered, pitch_um, true),
            profile_slope: square.sqrt(),
            crossfade_um: crossfade as f64 * pitch_um,
            stretch,
        })
    }

    /// Pixels of a period and of the crossfade.
    fn pixels(&self, pitch_um: f64) -> Result<(usize, usize), CutError> {
        let above = |x: f64| x.is_finite() && x > 0.0;
        let settings = [
            ("the pitch of a line in um", "above 0", pitch_um, above(pitch_um)),
            ("the period in um", "above 0", self.period_um, above(self.period_um)),
            (
                "the crossfade",
                "from 0.02 to 0.5 of the period",
                self.crossfade,
                (0.02..=0.5).contains(&self.crossfade),
            ),
            (
                "the cut-off in um",
                "0 or more",
                self.cutoff_um,
                self.cutoff_um.is_finite() && self.cutoff_um >= 0.0,
            ),
            ("the index", "from 1.0001 to 10", self.index, (1.0001..=10.0).contains(&self.index)),
            ("the wavelength in um", "above 0", self.wavelength_um, above(self.wavelength_um)),
        ];
        if let Some(&(what, range, value, _)) = settings.iter().find(|setting| !setting.3) {
            return Err(CutError::Setting { what, range, value });
        }
        let period = (self.period_um / pitch_um).round();
        if !(LEAST_PIXELS as f64..=1e6).contains(&period) {
            let (what, range) = ("the period in pixels", "from 16 to 1000000");
            return Err(CutError::Setting { what, range, value: period });
        }
        let crossfade = (period * self.crossfade).round().max(1.0);
        Ok((period as usize, crossfade as usize))
    }

    /// The factor next to 1 that takes the horizons of both media off the orders.
    fn stretch(&self, period_um: f64) -> f64 {
        let ratio = period_um / self.wavelength_um;
        let is_off = |ratio: f64| {
            let off = |waves: f64| (waves - waves.round()).abs() >= OFF;
            off(ratio) && off(self.index * ratio)
        };
        let shifts = (0..2000).flat_map(|step| [1e-3, -1e-3].map(|sign| sign * f64::from(step)));
        let shifted =
            shifts.map(|shift| ratio + shift).find(|ratio| *ratio > 0.0 && is_off(*ratio));
        shifted.unwrap_or(ratio) / ratio
    }
}

/// Heights over their line of least squares.
fn levelled(heights: &[f64]) -> Vec<f64> {
    let count = heights.len() as f64;
    let mean = heights.iter().sum::<f64>() / count;
    let x = |i: usize| i as f64 - 0.5 * (count - 1.0);
    let square: f64 = (0..heights.len()).map(|i| x(i).powi(2)).sum();
    let slope = heights.iter().enumerate().map(|(i, h)| x(i) * h).sum::<f64>() / square;
    heights.iter().enumerate().map(|(i, h)| h - mean - slope * x(i)).collect()
}

/// The first `count` heights, with those beyond faded into the beginning.
fn joined(heights: &[f64], count: usize) -> Vec<f64> {
    let crossfade = heights.len() - count;
    (0..count)
        .map(|i| {
            if i >= crossfade {
                return heights[i];
            }
            let way = PI * i as f64 / crossfade as f64;
            let (own, next) = (0.25 * PI * (1.0 - way.cos())).sin_cos();
            own * heights[i] + next * heights[count + i]
        })
        .collect()
}

impl Shape {
    /// `around`: the first height follows the last one.
    fn of(heights: &[f64], pitch: f64, around: bool) -> Self {
        let count = heights.len();
        let mean = heights.iter().sum::<f64>() / count as f64;
        let square: f64 = heights.iter().map(|h| (h - mean).powi(2)).sum();
        let pairs = if around { count } else { count - 1 };
        let slope = |i: usize| (heights[(i + 1) % count] - heights[i]) / pitch;
        let slopes: f64 = (0..pairs).map(|i| slope(i).powi(2)).sum();
        Self { rq_um: (square / count as f64).sqrt(), rms_slope: (slopes / pairs as f64).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::{CutError, CutOptions};
    use crate::problem::Problem;
    use crate::series::Series;

    fn line(count: usize) -> Vec<f64> {
        let mut state = 7u64;
        let waves: Vec<(f64, f64)> = (0..60)
            .map(|k| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (0.05 + 0.031 * f64::from(k), (state >> 40) as f64 / 1e6)
            })
            .collect();
        let height = |i: usize| -> f64 {
            waves.iter().map(|(q, phase)| 0.03 * (q * 0.4 * i as f64 + phase).sin()).sum()
        };
        (0..count).map(|i| 5.0 + 0.02 * i as f64 + height(i)).collect()
    }

    #[test]
    fn a_cut_is_the_line_outside_the_crossfade() {
        let options = CutOptions { cutoff_um: 0.0, ..CutOptions::new(33.0, 1.49, 0.55) };
        let line = line(200);
        let cut = options.cut(&line, 0.4, 20).unwrap();
        assert!((cut.stretch - 1.0).abs() < 3e-3, "{}", cut.stretch);
        let period = cut.profile.period_um();
        let series = Series::new(cut.profile.heights_um(), period, 0.0);
        let pixel = period / 83.0;
        // differences of third order do not know of levelling
        let third = |h: &dyn Fn(usize) -> f64, i| h(i + 3) - 3.0 * h(i + 2) + 3.0 * h(i + 1) - h(i);
        for i in 21..80 {
            let own = third(&|i| series.at(pixel * i as f64).value, i);
            let of_line = third(&|i| line[20 + i], i);
            assert!((own - of_line).abs() < 1e-5, "{i}: {own} {of_line}");
        }
        assert!(Problem::new(cut.profile, 1.49, 0.55).is_ok());
    }

    #[test]
    fn crossfade_and_low_pass_are_told() {
        let options = CutOptions { cutoff_um: 2.0, ..CutOptions::new(33.0, 1.49, 0.55) };
        let cut = options.cut(&line(200), 0.4, 0).unwrap();
        assert!(cut.filtered.rms_slope < 0.9 * cut.joined.rms_slope);
        assert!((cut.joined.rms_slope / cut.measured.rms_slope - 1.0).abs() < 0.2, "{cut:?}");
        assert!((cut.joined.rq_um / cut.measured.rq_um - 1.0).abs() < 0.3, "{cut:?}");
        assert!((cut.crossfade_um - 8.4).abs() < 1e-9);
    }

    #[test]
    fn pieces_do_not_overlap() {
        let options = CutOptions::new(33.0, 1.49, 0.55);
        let needed = options.needed(0.4).unwrap();
        assert_eq!(needed, 83 + 21);
        assert_eq!(options.starts(103, 0.4).unwrap(), [0; 0]);
        let starts = options.starts(330, 0.4).unwrap();
        assert_eq!(starts.len(), 3);
        assert!(starts.windows(2).all(|pair| pair[1] >= pair[0] + needed));
        assert!(starts[2] + needed <= 330);
    }

    #[test]
    fn what_cannot_be_cut_is_refused() {
        let options = CutOptions::new(33.0, 1.49, 0.55);
        let mut line = line(110);
        assert!(matches!(options.cut(&line, 0.4, 8), Err(CutError::TooShort { left: 102, .. })));
        line[9] = f64::NAN;
        assert_eq!(options.cut(&line, 0.4, 6).unwrap_err(), CutError::Missing(9));
        assert!(matches!(options.cut(&line, 0.0, 0), Err(CutError::Setting { .. })));
        let wide = CutOptions { crossfade: 0.6, ..options };
        assert!(matches!(wide.needed(0.4), Err(CutError::Setting { .. })));
        assert!(matches!(options.needed(4.0), Err(CutError::Setting { .. })));
    }
}

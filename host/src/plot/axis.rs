//! Axes: the place of a value, and the values of the ticks.

/// A linear or logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axis {
    Linear {
        lo: f64,
        hi: f64,
    },
    /// Ends as decadic logarithms.
    Log {
        lo: f64,
        hi: f64,
    },
}

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where, from 0 to 1 along the axis.
    pub(super) at: f64,
    /// Its label; `None` for a minor tick, which has no grid line either.
    pub(super) label: Option<String>,
}

impl Axis {
    /// A vertical linear axis around zero and these readings.
    pub(super) fn linear_over(lowest: f64, highest: f64) -> Self {
        let (lo, hi) = (lowest.min(0.0), highest.max(0.0));
        let span = if hi > lo { hi - lo } else { 1.0 };
        let hi = lo + span;
        // the zero line stays clear of the frame, the peak below it
        Self::Linear { lo: lo - 0.025 * span, hi: hi + 0.06 * span }
    }

    /// A vertical logarithmic axis from `decades` below `peak` to `highest`.
    pub(super) fn log_over(peak: f64, highest: f64, decades: u8) -> Self {
        let (decades, peak) = (f64::from(decades), peak.log10());
        Self::Log { lo: peak - decades, hi: highest.log10().max(peak) + 0.06 * decades }
    }

    /// Where a value lies, 0 to 1 between the ends and beyond them outside; `None` if it has no place.
    pub(super) fn at(self, value: f64) -> Option<f64> {
        match self {
            Self::Linear { lo, hi } => Some((value - lo) / (hi - lo)),
            Self::Log { lo, hi } => (value > 0.0).then(|| (value.log10() - lo) / (hi - lo)),
        }
    }

    /// Ticks of an axis of angles in degrees: parts of a circle where they fit.
    pub(super) fn angle_ticks(self) -> Vec<Tick> {
        const STEPS: [f64; 13] =
            [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0];
        match self {
            Self::Linear { lo, hi } => {
                let fits = |step: &&f64| hi - lo <= 7.0 * **step && hi - lo > 2.0 * **step;
                match STEPS.iter().find(fits) {
                    Some(&step) => self.multiples(step, 0),
                    None => self.multiples(round_step((hi - lo) / 5.0), 0),
                }
            }
            Self::Log { .. } => self.reading_ticks(0),
        }
    }

    /// Ticks of an axis of readings, labelled as multiples of ten to the `exponent` if linear.
    pub(super) fn reading_ticks(self, exponent: i32) -> Vec<Tick> {
        match self {
            Self::Linear { lo, hi } => self.multiples(round_step((hi - lo) / 4.5), exponent),
            Self::Log { lo, hi } => decades(lo, hi),
        }
    }

    fn multiples(self, step: f64, exponent: i32) -> Vec<Tick> {
        let Self::Linear { lo, hi } = self else {
            return Vec::new();
        };
        let decimals = (f64::from(exponent) - (step * 1.0001).log10().floor()).max(0.0) as usize;
        let unit = 10_f64.powi(exponent);
        let slack = 1e-6 * (hi - lo) / step;
        let (first, last) = ((lo / step - slack).ceil(), (hi / step + slack).floor());
        (0..=(last - first).clamp(0.0, 50.0) as u32)
            .map(|i| {
                let value = (first + f64::from(i)) * step;
                Tick {
                    at: (value - lo) / (hi - lo),
                    label: Some(signed(&format!("{:.decimals$}", value / unit + 0.0))),
                }
            })
            .collect()
    }
}

/// The power of ten, a multiple of 3, that labels of readings up to `highest` are best written in.
pub(super) fn common_exponent(highest: f64) -> i32 {
    if highest > 0.0 && !(1e-2..1e4).contains(&highest) {
        (highest.log10() / 3.0).floor() as i32 * 3
    } else {
        0
    }
}

/// A whole number in raised digits, for exponents.
pub(super) fn superscript(number: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    number
        .to_string()
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize]))
        .collect()
}

/// A number as typeset, with a minus sign for the hyphen and no sign on zero.
pub(super) fn signed(number: &str) -> String {
    let zero = !number.contains(|c: char| c.is_ascii_digit() && c != '0');
    if zero { number.trim_start_matches('-').to_owned() } else { number.replace('-', "−") }
}

/// Ticks at the powers of ten and their multiples between two decadic logarithms.
fn decades(lo: f64, hi: f64) -> Vec<Tick> {
    let every = ((hi - lo) / 6.0).ceil().max(1.0) as i32;
    let few = hi - lo < 1.5;
    let mut ticks = Vec::new();
    for decade in lo.floor() as i32..=hi.ceil() as i32 {
        for digit in 1..=9 {
            let place = f64::from(decade) + f64::from(digit).log10();
            if place < lo - 1e-9 || place > hi + 1e-9 || (digit > 1 && every > 1) {
                continue;
            }
            let label = match digit {
                1 if decade.rem_euclid(every) == 0 => Some(format!("10{}", superscript(decade))),
                2 | 5 if few => Some(format!("{digit}×10{}", superscript(decade))),
                _ => None,
            };
            ticks.push(Tick { at: (place - lo) / (hi - lo), label });
        }
    }
    ticks
}

/// 1, 2 or 5 times a power of ten near `rough`.
fn round_step(rough: f64) -> f64 {
    let power = 10_f64.powf(rough.log10().floor());
    match rough / power {
        r if r < 1.5 => power,
        r if r < 3.5 => 2.0 * power,
        r if r < 7.5 => 5.0 * power,
        _ => 10.0 * power,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().filter_map(|t| t.label.as_deref()).collect()
    }

    #[test]
    fn observation_angles_are_marked_every_thirty_degrees() {
        let ticks = Axis::Linear { lo: -90.0, hi: 90.0 }.angle_ticks();
        assert_eq!(labels(&ticks), ["−90", "−60", "−30", "0", "30", "60", "90"]);
        let ticks = Axis::Linear { lo: 29.0, hi: 31.0 }.angle_ticks();
        assert_eq!(labels(&ticks), ["29.0", "29.5", "30.0", "30.5", "31.0"]);
        let ticks = Axis::Linear { lo: 0.0, hi: 360.0 }.angle_ticks();
        assert!((3..=8).contains(&ticks.len()));
    }

    #[test]
    fn small_readings_share_an_exponent() {
        assert_eq!(common_exponent(0.003), -3);
        assert_eq!(common_exponent(0.3), 0);
        let ticks = Axis::linear_over(0.0, 0.003).reading_ticks(-3);
        assert_eq!(labels(&ticks), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]);
    }

    #[test]
    fn decades_are_labelled_and_their_parts_are_not() {
        let ticks = Axis::log_over(0.03, 0.03, 4).reading_ticks(0);
        assert_eq!(labels(&ticks), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"]);
        assert!(ticks.len() > 30);
        assert_eq!(labels(&Axis::log_over(1.0, 1.0, 1).reading_ticks(0)).len(), 4);
        assert!(labels(&Axis::log_over(1.0, 1.0, 15).reading_ticks(0)).len() <= 7);
    }

    #[test]
    fn zero_has_no_place_on_a_logarithmic_axis() {
        assert_eq!(Axis::log_over(1.0, 1.0, 4).at(0.0), None);
        assert_eq!(Axis::log_over(1.0, 1.0, 4).at(-1.0), None);
        assert!(Axis::log_over(1.0, 1.0, 4).at(1e-5).is_some_and(|at| at < 0.0));
    }
}

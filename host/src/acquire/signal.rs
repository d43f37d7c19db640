//! Possible currents of the detector: PROTOCOL.md, section 6.
//!
//! A relative reading is `(signal - dark) / (reference - dark)`. With a sample the detector never receives more than
//! the beam without it: a reading is at most 1, apart from noise and drift of the lamp. With a reference hardly above
//! the dark current it could be any number.

use asperity_core::protocol::{Calibration, RANGES, Reading};

use super::error::{Trouble, plain};

/// A current may be above the end of its range by this share: rounding.
const ROUNDING: f64 = 1e-3;
/// At the end of its range, but for the rounding of single precision, a current is cut off.
const CUT_OFF: f64 = 1.0 - 1e-6;
/// The beam must be above the dark current by at least this many times the largest dark current ...
const ABOVE_DARK: f64 = 10.0;
/// ... and by this share of its range: a converter of 16 bits has 300 steps for it.
const SHARE_OF_RANGE: f64 = 0.01;
/// No relative reading is farther from zero: the lamp would have doubled.
const MOST_RELATIVE: f64 = 2.0;
/// A relative reading above this is reported: it exceeds the drift of a lamp in an hour or two.
const ABOVE_BEAM: f64 = 1.05;

/// Current that a range holds, nA.
fn full_scale(range: u8) -> f64 {
    1000.0 / 10_f64.powi(i32::from(range))
}

/// Photocurrent of the beam without the sample, dark current taken off, nA; NaN for a range that is none.
fn beam(calibration: &Calibration) -> f64 {
    let dark = calibration.dark.get(usize::from(calibration.range)).copied().unwrap_or(f32::NAN);
    f64::from(calibration.reference) - f64::from(dark)
}

/// A reading relative to the beam without the sample.
pub(super) fn relative(calibration: &Calibration, reading: &Reading) -> f64 {
    (f64::from(reading.signal) - f64::from(reading.dark)) / beam(calibration)
}

/// Whether a relative reading is reported, because it exceeds the whole beam.
pub(super) fn is_above_beam(relative: f64) -> bool {
    relative > ABOVE_BEAM
}

/// Whether a sample can give such a relative reading.
pub(super) fn is_possible(relative: f64) -> bool {
    relative.abs() <= MOST_RELATIVE
}

/// Whether readings can be taken relative to a calibration.
///
/// # Errors
/// [`Trouble::Nonsense`], [`Trouble::WeakBeam`].
pub(super) fn check_calibration(calibration: &Calibration) -> Result<(), Trouble> {
    let values = calibration.dark.iter().chain([&calibration.reference]);
    if calibration.range >= RANGES || !values.clone().all(|value| value.is_finite()) {
        let values: Vec<String> = values.map(|value| plain(f64::from(*value))).collect();
        let (range, values) = (calibration.range, values.join(", "));
        return Err(Trouble::Nonsense(format!(
            "a calibration of range {range} with the currents {values} nA"
        )));
    }
    let (full, reference) = (full_scale(calibration.range), f64::from(calibration.reference));
    if reference >= full * CUT_OFF {
        let (reference, range) = (plain(reference), calibration.range);
        return Err(Trouble::Nonsense(format!(
            "the beam without the sample has {reference} nA, and range {range} holds {} nA: it is cut off",
            plain(full)
        )));
    }
    let dark = calibration.dark.iter().map(|dark| f64::from(dark.abs())).fold(0.0, f64::max);
    let least = (ABOVE_DARK * dark).max(SHARE_OF_RANGE * full);
    let beam = beam(calibration);
    if beam < least {
        return Err(Trouble::WeakBeam { reference, above: beam, dark, least });
    }
    Ok(())
}

/// Whether a detector with that calibration can have read this; what is wrong if not.
pub(super) fn check_reading(calibration: &Calibration, reading: &Reading) -> Result<(), String> {
    let (signal, dark) = (f64::from(reading.signal), f64::from(reading.dark));
    if !signal.is_finite() || !dark.is_finite() {
        return Err(format!("signal {}, dark {}", plain(signal), plain(dark)));
    }
    let Some(calibrated) = calibration.dark.get(usize::from(reading.range)) else {
        return Err(format!("it was read in range {}", reading.range));
    };
    if calibrated.to_bits() != reading.dark.to_bits() {
        return Err(format!(
            "a dark current of {} nA in range {}, and its calibration says {} nA",
            plain(dark),
            reading.range,
            plain(f64::from(*calibrated))
        ));
    }
    let full = full_scale(reading.range);
    if signal.abs() > full * (1.0 + ROUNDING) {
        return Err(format!(
            "{} nA in range {}, which holds {} nA",
            plain(signal),
            reading.range,
            plain(full)
        ));
    }
    let relative = relative(calibration, reading);
    // over-range has words of its own
    if !reading.over && !is_possible(relative) {
        return Err(format!(
            "{} times the beam without the sample, and no sample gives more than it gets",
            plain(relative)
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Calibration = Calibration { id: 1, dark: [0.004; 6], reference: 800.0, range: 0 };

    #[test]
    fn a_beam_hardly_above_the_dark_is_none_to_measure_against() {
        assert!(check_calibration(&GOOD).is_ok());
        // least: 10 times the dark current of 0.5 nA, 1 % of the range
        for (reference, range, good) in [
            (0.5, 0, false),
            (0.5002, 0, false),
            (0.9, 1, false),
            (5.4, 2, false),
            (5.6, 2, true),
            (10.4, 0, false),
            (10.6, 0, true),
            (-800.0, 0, false),
        ] {
            let calibration = Calibration { dark: [0.5; 6], reference, range, ..GOOD };
            let found = check_calibration(&calibration);
            assert_eq!(found.is_ok(), good, "{reference} {found:?}");
            assert!(good || matches!(found, Err(Trouble::WeakBeam { .. })), "{found:?}");
        }
    }

    #[test]
    fn a_beam_that_is_cut_off_or_no_number_is_refused() {
        for (reference, range) in [(1000.0, 0), (1200.0, 0), (f32::NAN, 0), (f32::MAX, 0), (5.0, 6)]
        {
            let calibration = Calibration { reference, range, ..GOOD };
            let found = check_calibration(&calibration).unwrap_err();
            assert!(matches!(found, Trouble::Nonsense(_)), "{found}");
            assert!(found.to_string().len() < 250, "{found}");
        }
        assert!(check_calibration(&Calibration { reference: 999.9, ..GOOD }).is_ok());
    }

    #[test]
    fn no_reading_is_far_above_the_beam() {
        let weak = Calibration { reference: 12.0, ..GOOD };
        let read = |signal, dark, range| {
            let reading = Reading { signal, dark, range, over: false, under: false };
            check_reading(&weak, &reading).err().unwrap_or_default()
        };
        assert_eq!(read(12.0, 0.004, 1), "");
        assert_eq!(read(0.0, 0.004, 5), "");
        assert!(read(30.0, 0.004, 1).contains("2.500"), "{}", read(30.0, 0.004, 1));
        assert!(read(-30.0, 0.004, 1).contains("times the beam"));
        assert!(read(1.1, 0.004, 3).contains("holds 1 nA"));
        assert!(read(1.0, 0.005, 3).contains("its calibration says 0.004"));
        assert!(read(f32::NAN, 0.004, 3).contains("NaN"));
        assert!(read(1.0, 0.004, 6).contains("range 6"));
    }
}

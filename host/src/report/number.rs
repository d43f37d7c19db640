//! Numbers as people read them: a value with its error, and figures that are not rounded to nothing.

/// Least number that is written without a power of ten, and least that needs one again.
const PLAIN: (f64, f64) = (1e-3, 1e6);
/// Most decimals of an error that is written without a power of ten.
const MOST_DECIMALS: i32 = 6;

/// A value and its standard error to two digits of the error, small or large ones in thousands.
///
/// `0.187003 +- 0.00087` reads `0.18700 ± 0.00087`, `1.03e-9 +- 8.5e-10` reads `(1.03 ± 0.85)e-9`, and a value that is small beside
/// its error keeps two digits of its own, `1.0e-4 ± 0.020`. An error that is not finite is `?`.
pub fn with_error(value: f64, std_error: Option<f64>) -> String {
    let Some(error) = std_error else { return significant(value, 6) };
    if !value.is_finite() || !error.is_finite() || error < 0.0 {
        return format!("{} ± ?", significant(value, 6));
    }
    if error <= 0.0 {
        return format!("{} ± 0", significant(value, 6));
    }
    let last = exponent(error, 2) - 1;
    let largest = value.abs().max(error);
    if value.abs() > 0.0 && value.abs() < 0.5 * 10.0_f64.powi(last) {
        return format!("{} ± {}", significant(value, 2), significant(error, 2));
    }
    let is_plain = largest >= PLAIN.0 && last <= 0;
    let power = if is_plain { 0 } else { exponent(largest, 2).div_euclid(3) * 3 };
    let decimals = (power - last).clamp(0, 17);
    let (unit, shown) = (10.0_f64.powi(power), decimals as usize);
    if is_plain && decimals > MOST_DECIMALS {
        return format!("{value:.shown$} ± {error:.1e}");
    }
    let (value, error) = (value / unit + 0.0, error / unit);
    match power {
        0 => format!("{value:.shown$} ± {error:.shown$}"),
        _ => format!("({value:.shown$} ± {error:.shown$})e{power}"),
    }
}

/// A number to some significant digits; those before the decimal point are all shown.
pub fn significant(x: f64, digits: i32) -> String {
    if !(x.is_finite() && x.abs() > 0.0) {
        return if x.is_finite() { "0".into() } else { format!("{x}") };
    }
    let decimals = (digits - 1 - exponent(x.abs(), digits)).max(0) as usize;
    if x.abs() >= PLAIN.0 && x.abs() < PLAIN.1.max(10.0_f64.powi(digits + 1)) {
        format!("{x:.decimals$}")
    } else {
        format!("{x:.most$e}", most = (digits - 1).max(0) as usize)
    }
}

/// A figure with so many decimals, unless they would all be zeros; `0` only if it is.
pub fn figure_text(x: f64, decimals: usize) -> String {
    let half = 0.5 * 10.0_f64.powi(-(decimals as i32));
    if x.abs() > 0.0 && x.abs() < half {
        format!("{x:.1e}")
    } else {
        format!("{:.decimals$}", x + 0.0)
    }
}

/// An angle in degrees as people write it: to a millionth, and no digit more than it needs.
pub fn angle_text(deg: f64) -> String {
    let rounded = (deg * 1e6).round() / 1e6 + 0.0;
    format!("{}", if rounded.is_finite() { rounded } else { deg })
}

/// A small number as a power of ten, to two digits.
pub fn power_text(x: f64) -> String {
    if x.abs() > 0.0 { format!("{x:.1e}") } else { "0".into() }
}

/// The exponent of ten of a positive number after it is rounded to some digits.
fn exponent(x: f64, digits: i32) -> i32 {
    let text = format!("{x:.most$e}", most = (digits - 1).max(0) as usize);
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::{angle_text, figure_text, power_text, significant, with_error};

    #[test]
    fn a_value_has_the_digits_of_its_error() {
        for (value, error, text) in [
            (0.187_003, 0.000_87, "0.18700 ± 0.00087"),
            (26.459, 0.6, "26.46 ± 0.60"),
            (26.459, 12.0, "26 ± 12"),
            (1e-4, 2e-6, "(100.0 ± 2.0)e-6"),
            (0.0, 1e-3, "0.0000 ± 0.0010"),
            (-0.0, 1e-9, "(0.0 ± 1.0)e-9"),
            (1_234_567.0, 20.0, "1234567 ± 20"),
            (1_234_567.0, 2000.0, "(1.2346 ± 0.0020)e6"),
            (1.03e-9, 8.5e-10, "(1.03 ± 0.85)e-9"),
            (-4.2e-4, 1.1e-5, "(-420 ± 11)e-6"),
            (-1.5, 0.25, "-1.50 ± 0.25"),
            (0.300_000_003, 8e-9, "0.3000000030 ± 8.0e-9"),
            (12.0, 1500.0, "12 ± 1500"),
            // an error that is rounded up to the next power of ten
            (0.5, 0.0996, "0.50 ± 0.10"),
            (5.0, 99.6, "5 ± 100"),
            (4.9e-300, 1e-301, "(4.90 ± 0.10)e-300"),
        ] {
            assert_eq!(with_error(value, Some(error)), text);
        }
    }

    #[test]
    fn a_small_value_is_not_rounded_away() {
        assert_eq!(with_error(1e-4, Some(0.02)), "1.0e-4 ± 0.020");
        assert_eq!(with_error(-3.2e-8, Some(0.5)), "-3.2e-8 ± 0.50");
        for (value, error) in [(1e-4, 0.02), (0.004, 0.1), (7e-9, 1e-3), (3.0, 1e5)] {
            let text = with_error(value, Some(error));
            let shown = text.split(" ± ").next().unwrap().trim_start_matches('(');
            assert!(shown.parse::<f64>().unwrap().abs() > 0.0, "{text}");
        }
    }

    #[test]
    fn what_is_no_error_is_not_shown_as_one() {
        assert_eq!(with_error(2.5e-7, None), "2.50000e-7");
        assert_eq!(with_error(1.5, None), "1.50000");
        assert_eq!(with_error(0.0, None), "0");
        assert_eq!(with_error(1.5, Some(0.0)), "1.50000 ± 0");
        for error in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(with_error(1.5, Some(error)), "1.50000 ± ?");
        }
        assert_eq!(with_error(f64::NAN, Some(0.1)), "NaN ± ?");
    }

    #[test]
    fn what_is_shown_is_the_value_to_half_its_last_digit() {
        // read back, value and error are within half of the second digit of the error
        for k in 0..4000 {
            let noise = |m: f64| (f64::from(k) * m).sin();
            let value = noise(1.7) * 10.0_f64.powf(9.0 * noise(0.3));
            let error = noise(2.9).abs().max(0.1) * 10.0_f64.powf(9.0 * noise(0.71) - 1.0);
            let text = with_error(value, Some(error));
            let (inside, power) = match text.strip_prefix('(').and_then(|t| t.split_once(")e")) {
                Some((inside, power)) => (inside, 10.0_f64.powi(power.parse().unwrap())),
                None => (text.as_str(), 1.0),
            };
            let (v, e) = inside.split_once(" ± ").unwrap();
            let place = 10.0_f64.powi(error.log10().floor() as i32 - 1);
            let half = 0.5 * place * (1.0 + 1e-6) + 1e-14 * value.abs();
            // an error that rounds up to 1.0 has its digits one place higher
            let half = if error / place > 99.4 { 10.0 * half } else { half };
            assert!(
                (v.parse::<f64>().unwrap() * power - value).abs() <= half,
                "{value} {error} {text}"
            );
            assert!(
                (e.parse::<f64>().unwrap() * power - error).abs() <= half,
                "{value} {error} {text}"
            );
        }
    }

    #[test]
    fn angles_are_written_as_people_do() {
        for (deg, text) in [
            (-90.0 + 130.1, "40.1"),
            (-90.0 + 58.2, "-31.8"),
            (35.264_389_7, "35.26439"),
            (-1e-17, "0"),
            (45.0, "45"),
        ] {
            assert_eq!(angle_text(deg), text);
        }
    }

    #[test]
    fn figures_are_zero_only_if_they_are() {
        assert_eq!(figure_text(0.3401, 3), "0.340");
        assert_eq!(figure_text(2.1e-4, 3), "2.1e-4");
        assert_eq!(figure_text(-0.0, 3), "0.000");
        assert_eq!(figure_text(5e-4, 3), "0.001");
        assert_eq!((power_text(0.0), power_text(1.23e-7)), ("0".to_owned(), "1.2e-7".to_owned()));
        assert_eq!(significant(1e9, 6), "1.00000e9");
        assert_eq!(significant(0.001_234_56, 6), "0.00123456");
    }
}

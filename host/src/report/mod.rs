//! Reports for people: tables of results, plots, the HTML page.

mod grid;
mod comparison;
mod formats;
mod figures;
mod heights;
mod html;
mod trade;

pub use figures::{FigureError, FigureFiles, PolarFiles, figure, figure_at, hemispheres};
pub use heights::{MapFigureFiles, MapFigures};
pub use html::{Picture, page};
pub use trade::TradeReport;

use crate::fit::Fit;

/// A value with as many digits as its standard error supports, and the error in the same place.
///
/// `0.18700 +- 0.00087` reads `0.1870 ± 0.0009`, `1.03e-9 +- 8.5e-10` reads `(1.03 ± 0.85)e-9`.
pub fn with_error(value: f64, std_error: Option<f64>) -> String {
    let error = std_error.filter(|e| *e > 0.0 && e.is_finite());
    let largest = value.abs().max(error.unwrap_or(0.0));
    if largest < 1e-3 && largest > 0.0 {
        let power = largest.log10().div_euclid(3.0) as i32 * 3;
        let unit = 10.0_f64.powi(power);
        let Some(e) = error.map(|e| e / unit) else { return format!("{value:.4e}") };
        let digits = (1.0 - e.log10().floor()).clamp(0.0, 12.0) as usize;
        return format!("({:.digits$} ± {e:.digits$})e{power}", value / unit);
    }
    match error {
        Some(e) => {
            // an error larger than a small value must not round it away
            let of_value = if value == 0.0 { 0.0 } else { 1.0 - value.abs().log10().floor() };
            let of_error = -(e.log10().floor());
            let digits = if e > value.abs() { of_error.max(of_value) } else { of_error };
            let digits = digits.clamp(0.0, 12.0) as usize;
            format!("{value:.digits$} ± {e:.digits$}")
        }
        None => format!("{value:.5}"),
    }
}

/// A fitted value with its error and unit; `none` if it means nothing is there.
pub fn value_text(p: &crate::fit::Fitted) -> String {
    if p.is_none {
        return "none".into();
    }
    let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
    let unsure = if p.is_unreliable() { " (error unreliable)" } else { "" };
    with_error(p.value, p.std_error) + &unit + unsure
}

/// The parameters of a fit in one line.
pub fn parameters_text(fit: &Fit) -> String {
    let one = |p: &crate::fit::Fitted| {
        let bound = if p.at_bound { " (at its bound)" } else { "" };
        format!("{} = {}{bound}", p.name, value_text(p))
    };
    fit.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::with_error;

    #[test]
    fn digits_follow_the_standard_error() {
        assert_eq!(with_error(0.187_003, Some(0.000_87)), "0.1870 ± 0.0009");
        assert_eq!(with_error(26.459, Some(0.6)), "26.5 ± 0.6");
        assert_eq!(with_error(26.459, Some(12.0)), "26 ± 12");
        assert_eq!(with_error(1.03e-9, Some(8.5e-10)), "(1.03 ± 0.85)e-9");
        assert_eq!(with_error(-4.2e-4, Some(1.1e-5)), "(-420 ± 11)e-6");
        assert_eq!(with_error(1e-4, Some(0.02)), "0.00010 ± 0.02000");
        assert_eq!(with_error(2.5e-7, None), "2.5000e-7");
        assert_eq!(with_error(1.5, None), "1.50000");
        assert_eq!(with_error(1.5, Some(f64::NAN)), "1.50000");
    }
}

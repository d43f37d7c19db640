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
/// `0.18700 +- 0.00087` reads `0.1870 ± 0.0009`.
pub fn with_error(value: f64, std_error: Option<f64>) -> String {
    match std_error {
        Some(e) if e > 0.0 && e.is_finite() => {
            let digits = (-(e.log10().floor())).clamp(0.0, 12.0) as usize;
            format!("{value:.digits$} ± {e:.digits$}")
        }
        _ => format!("{value:.5}"),
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
        assert_eq!(with_error(1.5, None), "1.50000");
        assert_eq!(with_error(1.5, Some(f64::NAN)), "1.50000");
    }
}

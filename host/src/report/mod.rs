//! Reports for people: tables of results, plots, the HTML page.

mod number;
mod grid;
mod comparison;
mod formats;
mod figures;
mod boundary;
mod laws;
mod residuals;
mod heights;
mod cuts;
mod ranking;
mod page;
mod trade;
mod trade_csv;

pub use boundary::{BoundaryFiles, boundary_csv, boundary_figure};
pub use cuts::cuts_figure;
pub use figures::{Drawn, FigureError, FigureFiles, PolarFiles, figure, figure_at, hemispheres};
pub use heights::{MapFigureFiles, MapFigures};
pub use laws::{
    NamedFluxes, NamedValues, flux_figure, hemisphere_picture, lobe_diagrams, lobes_figure,
};
pub use number::{angle_text, figure_text, power_text, significant, with_error};
pub use page::{Origin, page, plan_page};
pub use ranking::ranking_text;
pub use residuals::{quantile_figure, residual_figure};
pub use trade::TradeReport;
pub use trade_csv::NoTrade;

use crate::fit::Shown;

/// A fitted value with its error and unit; `none` if it means nothing is there.
pub fn value_text(p: &Shown) -> String {
    if p.is_none {
        return "none".into();
    }
    let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
    let unsure = if p.is_unreliable { " (error unreliable)" } else { "" };
    with_error(p.value, p.std_error) + &unit + unsure
}

/// The parameters of a fit in one line.
pub fn parameters_text(parameters: &[Shown]) -> String {
    let one = |p: &Shown| {
        let bound = if p.at_bound { " (at its bound)" } else { "" };
        format!("{} = {}{bound}", p.name, value_text(p))
    };
    parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}

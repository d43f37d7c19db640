//! Plots of measured against fitted readings and of maps, as SVG and as PNG.
//!
//! [`sigma_panels`] turns readings into a [`Figure`], one panel per incidence; [`svg`] and [`png()`] draw it:
//!
//! ```
//! use asperity::plot::{Scale, sigma_panels, svg};
//!
//! let measured = vec![(0.0, vec![(-1.0, 0.1), (0.0, 0.4), (1.0, 0.1)])];
//! let fits = vec![("GGX".to_owned(), vec![(0.0, vec![(-1.0, 0.2), (0.0, 0.3), (1.0, 0.2)])])];
//! let picture = svg(&sigma_panels("sample 5", &measured, &fits, Scale::Linear))?;
//! assert!(picture.contains("GGX"));
//! # Ok::<(), asperity::plot::PlotError>(())
//! ```
//!
//! The layout is fixed, so that a reading is in the same place in both formats; only `canvas.rs` uses the plotting library.

mod figure;
mod palette;
mod slots;
mod polyline;
mod axis;
mod layout;
mod raster;
mod canvas;
mod legend;
mod render;
mod sigma;
mod map;
mod polar;
mod hemisphere;
mod diagram;
mod caption;

pub(crate) use caption::{caption, difference_colour};
pub use diagram::{Diagram, DiagramLobe, DiagramPicture, diagram_png, diagram_svg};
pub use figure::{Across, Curve, CurveStyle, Figure, MAX_PANELS, Panel, PlotError, Scale};
pub use hemisphere::{
    HEMISPHERE_PIXELS, HemisphereDisc, HemispherePicture, cosine_at, hemisphere_png, hemisphere_svg,
};
pub use map::{MapPicture, map_png, map_svg};
pub use polar::{PolarPicture, PolarPoint, PolarRow, polar_png, polar_svg};
pub use render::{png, svg};
pub use sigma::{AtSigma, shown, sigma_panels};
pub use slots::{method_in, slots};

#[cfg(test)]
mod tests;

//! The BSDF of any method as a table for a microcontroller.
//!
//! The program's verb `tabulate` makes the arrays and writes them as Rust or C source; `asperity::tabulate` does so in the library
//! and has a runnable example. Firmware builds a [`Header`] and [`Arrays`] from that source; [`Header::table`] checks them once and
//! borrows them as a [`BsdfTableRef`], which evaluates and samples like any law ([`Bsdf`](crate::bsdf::Bsdf)) and allocates nothing.
//!
//! A lobe is not tabulated over its directions but over the *facet* that turns `wi` into `wo`, with all that is
//! exactly known divided out ([`Form`], [`Fall`]): the rest hardly changes with the incidence and the azimuth, so a
//! few nodes of each suffice, and between two incidences the peak moves instead of fading. Three axes ([`Shape`]):
//!
//! - the tangent of half the angle of incidence, crowded by `k`, from 0 at the normal to 1 at grazing;
//! - the azimuth of the facet against the mirror direction, as its cosine `p`, -1 to 1: an isotropic surface is
//!   symmetric, and even functions of an angle are smooth in its cosine;
//! - the slope of the facet `s`, as `r = s / (s + s0)`: a peak of any width gets the same nodes.
//!
//! The table stores square roots: small values keep their digits in 8 or 16 bits, and nothing is negative. Between
//! nodes it is
//! linear in the last two, its square is in the first. The value of a unit, the gain, has [`GAIN_STEPS`] within each
//! cell of incidence; there the flux is that of the model. Samples need no values: each incidence has the quantiles
//! of
//! `r^2`, which are interpolated like the values, and for each interval the mean of `p`, of which the nearer is taken; so the
//! density of the samples is known exactly without a sum over incidences.

mod error;
mod storage;
mod axes;
mod lobe;
mod side;
mod view;
mod value;
mod sample;
mod energy;
mod header;
#[cfg(feature = "checksum")]
mod checksum;
mod owned;
#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests;

pub use axes::{GAIN_STEPS, Place, cells, incidence_cosine, incidence_place, radius, slope};
pub use error::TableError;
pub use header::{Arrays, Header, LobeHeader};
pub use lobe::{Fall, Form, LobeTable, Shape};
pub use owned::BsdfTable;
pub use side::{Fluxes, SideTable};
pub use storage::Storage;
pub use view::{BsdfTableRef, Coherent};

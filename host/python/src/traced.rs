//! Values of a boundary whose rays must be traced: a table for the incidences that are asked for.

use asperity::binned::Asked;
use asperity::boundary::Boundary;
use asperity::forward::Rays;
use asperity_core::direction::Direction;
use pyo3::prelude::*;

use crate::error::bad;
use crate::work::interruptible;

/// The table that the program's `eval` makes for the same incidences.
///
/// # Errors
/// Those of the plan, and what a signal raised.
pub(crate) fn table(
    py: Python<'_>,
    boundary: &Boundary,
    wi: &[Direction<f64>],
    rays: Rays,
) -> PyResult<Asked> {
    interruptible(py, |watch| Asked::of(boundary, wi, rays, watch))?.map_err(bad)
}

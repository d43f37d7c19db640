//! Values of a boundary whose rays must be traced: a table for the incidences that are asked for.

use std::sync::atomic::AtomicBool;

use asperity::boundary::Boundary;
use asperity::forward::Rays;
use asperity::kirchhoff::{Speckle, WaveBoundary};
use asperity::table::{Azimuth, BsdfTable, TablePlan, tabulate, tabulate_orders};
use asperity_core::direction::Direction;
use pyo3::prelude::*;

use crate::error::bad;
use crate::work::interruptible;

/// The table that the program's `eval` makes for the same incidences; `None` for a boundary in closed form.
///
/// # Errors
/// Those of the plan, and what a signal raised.
pub(crate) fn table(
    py: Python<'_>,
    boundary: &Boundary,
    wi: &[Direction<f64>],
    rays: Rays,
) -> PyResult<Option<BsdfTable>> {
    let made = interruptible(py, |stop| match boundary {
        Boundary::Traced(t) => {
            let plan = TablePlan::new(t.eta(), rays).with_azimuth(Azimuth::of(t.anisotropy()))?;
            Ok(tabulate(t, &plan.for_directions(wi), stop, &|_| ()))
        }
        Boundary::Hybrid(h) => {
            let plan = TablePlan::new(h.eta(), rays).with_azimuth(Azimuth::of(h.anisotropy()))?;
            Ok(tabulate(&**h, &plan.for_directions(wi), stop, &|_| ()))
        }
        Boundary::Wave(wave) => of_waves(wave, wi, rays, stop),
        Boundary::Ggx(_) | Boundary::Normals(_) | Boundary::Opaque(_) | Boundary::Table(_) => {
            Ok(None)
        }
    })?;
    made.map_err(bad)
}

fn of_waves(
    wave: &WaveBoundary,
    wi: &[Direction<f64>],
    rays: Rays,
    stop: &AtomicBool,
) -> Result<Option<BsdfTable>, asperity::table::PlanError> {
    let plan = TablePlan::new(wave.eta(), rays);
    if wave.speckle() == Speckle::Averaged {
        return Ok(tabulate(wave, &plan.for_directions(wi), stop, &|_| ()));
    }
    let plan = plan.with_azimuth(Azimuth::directional())?.for_directions(wi);
    Ok(tabulate_orders(wave, &plan, stop, &|_, _| ()))
}

//! Tables without all lobes: what a verb needs of them, and what it says.

use std::path::Path;

use asperity_core::bsdf::{Lobe, LobeSet};
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;

use super::error::Failure;
use crate::boundary::Boundary;
use crate::forward::{Sample, Setup};

/// The lobes that the readings of a scan are made of; with rays the account of the flux too.
pub(super) fn of_scan(setup: &Setup, rays: bool) -> LobeSet {
    let back = setup.geometry == Geometry::Reflection;
    match setup.sample {
        Sample::Opaque => LobeSet::AIR_REFLECTION,
        // what came in is mirrored at the smooth face, and leaves by either
        Sample::Plate { rough_side: RoughSide::Source, .. } => {
            let always = LobeSet::AIR_TRANSMISSION | LobeSet::DIELECTRIC_REFLECTION;
            always | LobeSet::ALL.only_if(back || rays)
        }
        Sample::Plate { rough_side: RoughSide::Detector, .. } => {
            let through = LobeSet::DIELECTRIC_TRANSMISSION.only_if(!back || rays);
            LobeSet::DIELECTRIC_REFLECTION | through
        }
    }
}

/// The lobes that the balances of these sides are made of.
pub(super) fn of_balance(sides: &[Side]) -> LobeSet {
    LobeSet::of_each(sides, &[Lobe::Reflection, Lobe::Transmission])
}

/// Refuses a table that lacks lobes; `or` is another way, and begins the remedy.
pub(super) fn need(
    path: &Path,
    boundary: &Boundary,
    (wanted, what, or): (LobeSet, &str, &str),
) -> Result<(), Failure> {
    let Boundary::Table(table) = boundary else { return Ok(()) };
    let Some(missing) = table.missing(wanted) else { return Ok(()) };
    Err(Failure::bad(format!(
        "{}: the table holds no {missing}, which {what} needs; {or}give one made by `asperity tabulate` with \
         --side both --lobe both",
        path.display()
    )))
}

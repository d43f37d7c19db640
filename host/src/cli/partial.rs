//! Tables without all lobes: what a verb needs of them, and what it says.

use std::path::Path;

use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;

use super::error::Failure;
use crate::boundary::Boundary;
use crate::forward::{Sample, Setup};

/// Which lobes: reflection and transmission from the air, then from the dielectric.
pub(super) type Lobes = [bool; 4];

/// The lobes that the readings of a scan are made of; with rays the account of the flux too.
pub(super) fn of_scan(setup: &Setup, rays: bool) -> Lobes {
    let back = setup.geometry == Geometry::Reflection;
    match setup.sample {
        Sample::Opaque => [true, false, false, false],
        // what came in is mirrored at the smooth face, and leaves by either
        Sample::Plate { rough_side: RoughSide::Source, .. } => {
            [back || rays, true, true, back || rays]
        }
        Sample::Plate { rough_side: RoughSide::Detector, .. } => {
            [false, false, true, !back || rays]
        }
    }
}

/// The lobes that the balances of these sides are made of.
pub(super) fn of_balance(sides: &[Side]) -> Lobes {
    let (air, dielectric) = (sides.contains(&Side::Air), sides.contains(&Side::Dielectric));
    [air, air, dielectric, dielectric]
}

/// Refuses a table that lacks lobes; `or` is another way, and begins the remedy.
pub(super) fn need(
    path: &Path,
    boundary: &Boundary,
    (wanted, what, or): (Lobes, &str, &str),
) -> Result<(), Failure> {
    let Boundary::Table(table) = boundary else { return Ok(()) };
    let Some(missing) = table.missing(wanted) else { return Ok(()) };
    Err(Failure::bad(format!(
        "{}: the table holds no {missing}, which {what} needs; {or}give one made by `asperity tabulate` with \
         --side both --lobe both",
        path.display()
    )))
}

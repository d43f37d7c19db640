//! Tables without all lobes: what a scan or a balance needs of them.

use asperity_core::bsdf::{Lobe, LobeSet};
use asperity_core::direction::Side;
use asperity_core::gonio::Geometry;
use asperity_core::plate::RoughSide;

use crate::boundary::Boundary;
use crate::embedded::MissingLobes;
use crate::forward::{Sample, Setup};

/// What a table lacks.
#[derive(Debug, thiserror::Error)]
#[error("the table holds no {missing}, which {what} needs")]
pub struct Lacking {
    /// The lobes.
    pub missing: MissingLobes,
    /// What they are needed for.
    pub what: &'static str,
}

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

/// Refuses a table that lacks lobes.
pub(super) fn need(
    boundary: &Boundary,
    wanted: LobeSet,
    what: &'static str,
) -> Result<(), Lacking> {
    let Boundary::Table(table) = boundary else { return Ok(()) };
    table.missing(wanted).map_or(Ok(()), |missing| Err(Lacking { missing, what }))
}

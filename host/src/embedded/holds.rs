//! The content of a table: which lobes, how much coherent light, an opaque body or a dielectric.

use std::fmt;

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe};
use asperity_core::direction::{Direction, Side};

use super::{EmbeddedTable, with_view};

/// The lobes in the order of the header.
pub(crate) const LOBES: [(Side, Lobe); 4] = [
    (Side::Air, Lobe::Reflection),
    (Side::Air, Lobe::Transmission),
    (Side::Dielectric, Lobe::Reflection),
    (Side::Dielectric, Lobe::Transmission),
];
/// Index that stands for an opaque body, in a table of nothing but reflection from the air: Fresnel's factor hardly changes with
/// angle.
pub(crate) const OPAQUE: f32 = 10.0;

/// Lobes that were left out of a table; its text names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingLobes([bool; 4]);

impl fmt::Display for MissingLobes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = ["reflection", "transmission"];
        let sides = [("the air", &self.0[..2]), ("the dielectric", &self.0[2..])];
        let mut first = true;
        for (side, missing) in sides {
            let lobes: Vec<&str> =
                names.into_iter().zip(missing).filter(|(_, m)| **m).map(|(n, _)| n).collect();
            if !lobes.is_empty() {
                let comma = if first { "" } else { ", no " };
                write!(f, "{comma}{} of light from {side}", lobes.join(" or "))?;
                first = false;
            }
        }
        Ok(())
    }
}

impl EmbeddedTable {
    /// Index of the dielectric over that of air; `None` for an opaque body.
    pub fn eta(&self) -> Option<f64> {
        (!self.opaque).then_some(f64::from(self.header().eta.get()))
    }

    /// Which of these lobes were left out: reflection and transmission from the air, then from the dielectric. `None`
    /// if none was; an opaque body lacks nothing.
    pub fn missing(&self, wanted: [bool; 4]) -> Option<MissingLobes> {
        self.eta()?;
        let mut missing = wanted;
        for (missing, lobe) in missing.iter_mut().zip(&self.header().lobes) {
            *missing &= lobe.is_none();
        }
        missing.contains(&true).then_some(MissingLobes(missing))
    }

    /// The lobe that joins two directions, for [`Self::missing`]; none if one of them lies in the surface.
    pub fn lobe_between(wi: Direction<f64>, wo: Direction<f64>) -> [bool; 4] {
        let (Some(side), Some(to)) = (wi.side(), wo.side()) else { return [false; 4] };
        let lobe = if side == to { Lobe::Reflection } else { Lobe::Transmission };
        LOBES.map(|one| one == (side, lobe))
    }

    /// Whether the table has coherent light.
    pub fn is_coherent(&self) -> bool {
        self.fluxes.iter().any(|&[.., reflected, transmitted]| reflected | transmitted > 0)
    }

    /// The coherent light from `wi`; 0 along the surface.
    pub fn coherent(&self, wi: Direction<f64>) -> CoherentFlux<f64> {
        with_view!(self, view => view.coherent_flux(wi), else CoherentFlux::default())
    }
}

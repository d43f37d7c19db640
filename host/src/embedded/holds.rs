//! The content of a table: which lobes, how much coherent light, an opaque body or a dielectric.

use std::fmt;

use asperity_core::bsdf::{Bsdf, CoherentFlux, Lobe, LobeSet};
use asperity_core::direction::Direction;

use super::{EmbeddedTable, with_view};

/// Lobes that were left out of a table; its text names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingLobes(LobeSet);

impl fmt::Display for MissingLobes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sides = [("the air", LobeSet::AIR), ("the dielectric", LobeSet::DIELECTRIC)];
        let mut first = true;
        for (side, of_side) in sides {
            let lobes: Vec<&str> = (self.0 & of_side).iter().map(|(_, lobe)| name(lobe)).collect();
            if !lobes.is_empty() {
                let comma = if first { "" } else { ", no " };
                write!(f, "{comma}{} of light from {side}", lobes.join(" or "))?;
                first = false;
            }
        }
        Ok(())
    }
}

fn name(lobe: Lobe) -> &'static str {
    match lobe {
        Lobe::Reflection => "reflection",
        Lobe::Transmission => "transmission",
    }
}

impl EmbeddedTable {
    /// Index of the dielectric over that of air; `None` for an opaque body.
    pub fn eta(&self) -> Option<f64> {
        (!self.header().opaque).then_some(f64::from(self.header().eta.get()))
    }

    /// Which of these lobes were left out; `None` if none was. An opaque body lacks nothing.
    pub fn missing(&self, wanted: LobeSet) -> Option<MissingLobes> {
        self.eta()?;
        let missing = wanted - self.header().holds();
        (!missing.is_empty()).then_some(MissingLobes(missing))
    }

    /// The lobe that joins two directions, for [`Self::missing`]; none if one of them lies in the surface.
    pub fn lobe_between(wi: Direction<f64>, wo: Direction<f64>) -> LobeSet {
        let (Some(side), Some(to)) = (wi.side(), wo.side()) else { return LobeSet::NONE };
        LobeSet::of(side, if side == to { Lobe::Reflection } else { Lobe::Transmission })
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

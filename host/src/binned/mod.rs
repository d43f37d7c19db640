//! The BSDF of a boundary that can only be sampled, as a table that can be evaluated.
//!
//! Rays are traced from both sides and gathered in bins that follow the lobes ([`gather()`]), and so are the orders
//! of a map that scatters waves ([`gather_orders()`]); between the tabulated
//! incidences lobes move in direction cosines rather than fade into each other ([`BinnedBsdf`]).

mod disc;
mod bins;
mod binning;
mod gather;
mod waves;
mod lookup;
mod asked;

pub use asked::Asked;
pub use binning::{Azimuth, Binning, BinningError, default_incidences_deg};
pub use bins::{Bin, Estimate};
pub use disc::{to_disc, to_square};
pub use gather::gather;
pub use waves::gather_orders;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;

use bins::BinnedLobe;

/// The scatter of a boundary at discrete incidences, with an interpolation between them.
///
/// Between two incidences, and two azimuths, `f(wi, wo) = sum w_k f_k(wo_k)`: the tabulated lobe is translated over
/// the disc of direction cosines as the mirror direction or Snell's direction moves. A translation keeps `f` and the
/// flux; what would move beyond the horizon is folded back to just before it, so that the flux of a lobe
/// is the interpolated one, and R + T is at most 1, everywhere. Weights are linear in the angle. Beyond the last
/// incidence its lobe continues to move and keeps its flux. A side without incidences scatters nothing.
///
/// Only one piece of surface is traced: errors are those of a finite number of rays, not of the small size of the piece.
#[derive(Clone, Debug)]
pub struct BinnedBsdf {
    eta: RelativeIor<f64>,
    azimuth: Azimuth,
    sides: [SideTable; 2],
    slope: f64,
}

/// The traced light from one side.
#[derive(Clone, Debug, Default)]
struct SideTable {
    /// Incidences, rad, ascending.
    angles: Vec<f64>,
    /// Reflected and transmitted lobe; all azimuths of the first incidence, then of the next.
    beams: Vec<[BinnedLobe; 2]>,
}

/// Hemispherical totals at one incidence, as fractions of the incident flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals {
    /// Reflected.
    pub reflected: Estimate,
    /// Transmitted.
    pub transmitted: Estimate,
}

impl BinnedBsdf {
    fn new(binning: &Binning, sides: [SideTable; 2]) -> Self {
        let mut table =
            Self { eta: binning.eta, azimuth: binning.azimuth.clone(), sides, slope: f64::NAN };
        table.slope = table.find_slope();
        table
    }

    /// Index of the dielectric over that of air.
    pub fn eta(&self) -> RelativeIor<f64> {
        self.eta
    }

    /// Whether all azimuths are alike, or which ones were tabulated.
    pub fn azimuth(&self) -> &Azimuth {
        &self.azimuth
    }

    /// Tabulated incidences of a side, degrees, ascending.
    pub fn incidences_deg(&self, side: Side) -> Vec<f64> {
        self.side(side).angles.iter().map(|a| a.to_degrees()).collect()
    }

    /// The bins of a tabulated lobe, by the numbers of its incidence and azimuth; none if there is no such lobe.
    ///
    /// With all azimuths alike (azimuth 0) the light comes from (-sin, 0, +-cos).
    pub fn bins(
        &self,
        side: Side,
        incidence: usize,
        azimuth: usize,
        lobe: Lobe,
    ) -> impl Iterator<Item = Bin> + '_ {
        let count = self.azimuths();
        let beam = (azimuth < count).then(|| incidence * count + azimuth);
        let lobes = beam.and_then(|at| self.side(side).beams.get(at));
        lobes.map(|lobes| of_lobe(lobes, lobe).bins()).into_iter().flatten()
    }

    /// Azimuths of each incidence.
    fn azimuths(&self) -> usize {
        match &self.azimuth {
            Azimuth::Isotropic => 1,
            Azimuth::Fixed(degrees) => degrees.len(),
        }
    }

    fn side(&self, side: Side) -> &SideTable {
        &self.sides[binning::side_index(side)]
    }
}

fn of_lobe(lobes: &[BinnedLobe; 2], lobe: Lobe) -> &BinnedLobe {
    &lobes[usize::from(lobe == Lobe::Transmission)]
}

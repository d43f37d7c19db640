//! A boundary as a law that the formats of other programs can sample ([`asperity_exchange`]).

use asperity_core::bsdf::Bsdf;
use asperity_core::direction::Direction;
use asperity_exchange::convention::Global;
use asperity_exchange::law::{Closed, Law, Subject};
use asperity_exchange::{Band, Lobe, Side, Symmetry};

use crate::binned::{Asked, Azimuth, BinnedBsdf, BinningError};
use crate::boundary::Boundary;
use crate::forward::Rays;
use crate::kirchhoff::Speckle;
use crate::watch::Watch;

/// One lobe of one side of a boundary.
#[derive(Debug)]
pub struct BoundaryLaw<'a> {
    boundary: &'a Boundary,
    /// Where the boundary has no values of its own.
    table: Option<BinnedBsdf>,
    /// The side the light comes from.
    pub side: Side,
    /// What becomes of it.
    pub lobe: Lobe,
}

/// Why a boundary has no such lobe.
#[derive(Debug, thiserror::Error)]
pub enum NoLaw {
    /// An opaque body has one lobe.
    #[error("an opaque body only reflects light from the air; give --side air --lobe reflection")]
    Opaque,
    /// Its rays cannot be gathered.
    #[error(transparent)]
    Binning(#[from] BinningError),
    /// Stopped.
    #[error("interrupted before the rays were traced")]
    Stopped,
}

impl<'a> BoundaryLaw<'a> {
    /// The lobe for light of the given incidences, polar angle and azimuth in radians. A map is traced first, `rays` per incidence.
    ///
    /// # Errors
    /// [`NoLaw`].
    pub fn of(
        boundary: &'a Boundary,
        (side, lobe): (Side, Lobe),
        incidences: &[[f64; 2]],
        rays: Rays,
        watch: Watch<'_>,
    ) -> Result<Self, NoLaw> {
        if boundary.eta().is_none() && (side, lobe) != (Side::Air, Lobe::Reflection) {
            return Err(NoLaw::Opaque);
        }
        let needs_table = match boundary {
            Boundary::Wave(wave) => wave.speckle() != Speckle::Averaged,
            other => other.is_traced(),
        };
        let table = if needs_table {
            let wi = incidences.iter().filter_map(|at| vector(Global::of_incidence(side, *at)));
            match Asked::of(boundary, &wi.collect::<Vec<_>>(), rays, watch)? {
                Asked::AsItIs => None,
                Asked::Table(table) => Some(*table),
                Asked::Stopped => return Err(NoLaw::Stopped),
            }
        } else {
            None
        };
        Ok(Self { boundary, table, side, lobe })
    }

    /// What the law is the law of; `wavelength_nm` is that of the user, where the boundary has none of its own.
    pub fn subject(&self, wavelength_nm: Option<f64>, notes: Vec<String>) -> Subject {
        let own = self.boundary.wavelengths().map(|w| w.iter().map(|(um, _)| 1000.0 * um));
        let own: Vec<f64> = own.into_iter().flatten().collect();
        let band = match (&own[..], wavelength_nm) {
            ([one], _) => Band::Wavelength((one * 1e6).round() / 1e6),
            ([], Some(nm)) => Band::Wavelength(nm),
            ([], None) => Band::Unknown,
            (many, _) => {
                let list: Vec<_> = many.iter().map(|nm| format!("{nm:.1}")).collect();
                Band::Named(format!("weighted mean of {} nm", list.join(", ")))
            }
        };
        let symmetry = match self.table.as_ref().map(BinnedBsdf::azimuth) {
            Some(Azimuth::Fixed(_)) => Symmetry::None,
            _ if self.boundary.is_anisotropic() => Symmetry::None,
            _ => Symmetry::Isotropic,
        };
        let closed = match self.boundary {
            Boundary::Ggx(ggx) => Some(Closed::Ggx { alpha: ggx.alpha.get() }),
            _ => None,
        };
        Subject {
            side: self.side,
            lobe: self.lobe,
            index: self.boundary.eta(),
            symmetry,
            band,
            notes,
            coherent: 0.0,
            closed,
        }
    }

    /// Coherent fraction of the flux of an incidence in this lobe, which no value holds.
    pub fn coherent(&self, incidence: [f64; 2]) -> f64 {
        let Some(wi) = vector(Global::of_incidence(self.side, incidence)) else { return 0.0 };
        let coherent = self.boundary.coherent(wi);
        match self.lobe {
            Lobe::Reflection => coherent.reflected,
            Lobe::Transmission => coherent.transmitted,
        }
    }

    /// Whether rays were traced for it.
    pub fn is_traced(&self) -> bool {
        self.table.is_some()
    }

    fn pair(&self, incidence: [f64; 2], out: [f64; 2]) -> Option<[Direction<f64>; 2]> {
        let wi = vector(Global::of_incidence(self.side, incidence))?;
        let wo = vector(Global::of_outgoing(self.side, self.lobe, incidence[1], out))?;
        Some([wi, wo])
    }

    fn value_of(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let Some([wi, wo]) = self.pair(incidence, out) else { return 0.0 };
        match &self.table {
            Some(table) => table.eval(wi, wo),
            None => self.boundary.eval(wi, wo).unwrap_or(0.0),
        }
    }
}

impl Law for BoundaryLaw<'_> {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let isotropic = self.table.as_ref().is_some_and(|t| *t.azimuth() == Azimuth::Isotropic);
        let here = self.value_of(incidence, out);
        // left and right of an isotropic surface differ by the grain of the rays alone
        if isotropic {
            f64::midpoint(here, self.value_of(incidence, [out[0], -out[1]]))
        } else {
            here
        }
    }

    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        let wi = vector(Global::of_incidence(self.side, incidence))?;
        let totals = self.table.as_ref()?.totals(wi);
        let all = match self.lobe {
            Lobe::Reflection => totals.reflected.value,
            Lobe::Transmission => totals.transmitted.value,
        };
        Some(all)
    }

    fn has_grain(&self) -> bool {
        self.is_traced()
    }
}

/// The unit vector of a direction about the sample.
fn vector(at: Global) -> Option<Direction<f64>> {
    let ((sin, cos), (s, c)) = (at.theta.sin_cos(), at.phi.sin_cos());
    Direction::new(sin * c, sin * s, cos)
}

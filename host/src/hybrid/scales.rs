//! The wavelength at which a map is split.
//!
//! A surface whose heights differ by the mean square `D(r)` over a distance `r` keeps the coherence `exp(-q_z^2 D(r) / 2)`
//! between two of its points. Over the distance where that is lost the light is one wave; what is straight over this distance acts
//! as a facet, what bends within it diffracts. So the split lies at a few of these distances. Where
//! coherence is never lost all light is a wave and nothing is traced; on a smooth surface of large heights it
//! is lost so soon that no waves are short enough to diffract. Between the two the split moves steadily, and so
//! does what it makes of the light: no switch.

use std::f64::consts::TAU;

use asperity_core::quantity::RelativeIor;

use crate::kirchhoff::Wavelengths;
use crate::surface::structure::StructureFunction;
use crate::surface::{Edges, HeightMap, Incomplete};

/// `q_z^2 D / 2` where coherence counts as lost: `exp(-10)`. A detector's cone takes some 0.3 % of a lobe, in which all
/// coherent light falls into one reading: `exp(-6)` of it would still be seen.
pub(super) const LOST: f64 = 10.0;
/// The split in distances over which coherence is lost. Most is lost over a third of one, a ninth of such a wave,
/// which is straight there to 4 %.
pub(super) const DISTANCES: f64 = 3.0;

/// A map's two scales.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Waves longer than this are traced, um; `None` if the whole map diffracts.
    pub cutoff_um: Option<f64>,
    /// Rms height of the traced part, um.
    pub long_um: f64,
    /// Rms height of the diffracting part, um.
    pub short_um: f64,
}

/// The wavelength in um that splits a map for light; `None` if nothing is traced.
///
/// Judged for the least momentum across a plate's face: of light that passes at normal incidence, or is mirrored
/// at 60 degrees, whichever is less, and of the longest wavelength.
///
/// # Errors
/// [`Incomplete`] if points are missing.
pub(super) fn cutoff_um(
    map: &HeightMap,
    edges: Edges,
    eta: RelativeIor<f64>,
    wavelengths: &Wavelengths,
) -> Result<Option<f64>, Incomplete> {
    let q_z = TAU / wavelengths.longest_um() * (eta.get() - 1.0).abs().min(1.0);
    let level = 2.0 * LOST / (q_z * q_z);
    Ok(StructureFunction::of(map, edges)?.reach_um(level).map(|r| DISTANCES * r))
}

impl Scales {
    /// In words.
    pub fn text(&self) -> String {
        let Self { cutoff_um, long_um, short_um } = self;
        match cutoff_um {
            None => format!("the whole map diffracts (rms {short_um:.3} um); nothing is traced"),
            Some(_) if *short_um <= 0.0 => {
                format!(
                    "the whole map is traced (rms {long_um:.3} um); nothing is short enough to diffract"
                )
            }
            Some(cutoff) => format!(
                "waves of the map longer than {cutoff:.2} um are traced (rms {long_um:.3} um), shorter ones diffract \
                 (rms {short_um:.4} um)"
            ),
        }
    }
}

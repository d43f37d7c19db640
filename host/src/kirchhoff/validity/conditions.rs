//! The conditions of the Kirchhoff approximation for one lobe, and the largest angle into which a sampled map can scatter.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use serde::{Serialize, Serializer};

pub use super::facets::Violating;
use super::light::Light;
use super::margins::Margins;

/// Share of the steps between neighbours that may exceed half a wave.
pub const MOST_SHARE: f64 = 0.05;
/// Share of the facets that may violate a condition: what lies beyond three rms slopes on grooves of Gaussian slopes, `erfc(3 / sqrt 2)`.
pub const MOST_VIOLATING: f64 = 0.0027;
/// Largest accepted excess of the outgoing light, as a fraction of the incident flux.
pub const MOST_EXCESS: f64 = 0.01;
/// 99 % of the facets of a Gaussian surface are less steep than this many rms slopes: `sqrt(2 ln 100)`.
const STEEP: f64 = 3.034_854_258_770_293;

/// The angles that a sampled map can scatter into, and those that its lobe takes; at normal incidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FarField {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Where the light comes from.
    #[serde(serialize_with = "side_name")]
    pub side: Side,
    /// Where it goes.
    #[serde(serialize_with = "lobe_name")]
    pub lobe: Lobe,
    /// `asin(lambda / (2 pixel))` in the medium of the scattered light: a finer structure the map has not. Degrees.
    pub reach_deg: f64,
    /// Where a facet sends light that is steeper than 99 % of the others, were the slopes Gaussian. Degrees.
    pub lobe_deg: f64,
}

/// The conditions for one lobe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LobeValidity {
    /// Wavelength in vacuum, nm.
    pub wavelength_nm: f64,
    /// Where the light comes from.
    #[serde(serialize_with = "side_name")]
    pub side: Side,
    /// Where it goes.
    #[serde(serialize_with = "lobe_name")]
    pub lobe: Lobe,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// Where a mirror or a smooth boundary sends it, from the normal; `None` on total reflection. Degrees.
    pub specular_deg: Option<f64>,
    /// Eq. (9): share of the points with `2 pi R cos^3 <= 10 lambda`, facets facing away included.
    pub curved_fraction: f64,
    /// Share of the steps between neighbours that change the phase of the specular direction by more than pi.
    pub undersampled_fraction: f64,
    /// `q_z Rq` in the specular direction: below about 2 light stays coherent and rays err.
    pub phase_rms: f64,
    /// The share of the light that facets which face away would receive: the excess of a model without shadows.
    pub turned_away_fraction: f64,
    /// The distance of the approximation from failure, in rms slopes of the map along the plane of incidence; for
    /// information.
    #[serde(flatten)]
    pub margins: Margins,
    /// The shares of the facets that violate its conditions, which decide.
    #[serde(flatten)]
    pub violating: Violating,
    /// [`Validity::correlation_um`](super::limits::Validity::correlation_um) in vacuum wavelengths.
    pub correlation_wavelengths: Option<f64>,
    /// The least correlation length for the diffuse light alone, in the same unit.
    pub least_correlation_wavelengths: f64,
    /// The lost share of the light, of both lobes and of all wavelengths, as `check` finds it; negative if more comes
    /// out than went in. `None` if it was not computed.
    pub lost: Option<f64>,
    /// Whether a reading of this lobe, its specular light included, may be trusted to 1 % of its peak.
    pub passes: bool,
    /// Whether its diffuse light alone may be trusted to 1 % of its own peak.
    pub diffuse_passes: bool,
}

impl FarField {
    pub(super) fn of(light: &Light, pixel_um: f64, rms_slope: f64) -> Self {
        Self {
            wavelength_nm: light.nm(),
            side: light.side,
            lobe: light.lobe,
            reach_deg: light.reach_deg(pixel_um),
            lobe_deg: light.turned_deg(STEEP * rms_slope),
        }
    }

    /// Whether the pixel carries the whole lobe.
    pub fn is_wide_enough(&self) -> bool {
        self.lobe_deg <= self.reach_deg
    }
}

impl LobeValidity {
    /// Whether nearly all facets send the light where the integral does: conditions (a) to (c) of `margins`, and there is a
    /// lobe at all.
    pub fn is_seen_aright(&self) -> bool {
        self.specular_deg.is_some() && self.violating.any <= MOST_VIOLATING
    }

    /// Whether the phase is known between nearly all neighbours.
    pub fn is_sampled(&self) -> bool {
        self.undersampled_fraction <= MOST_SHARE
    }

    /// Whether no more light comes out than went in, as far as is known.
    pub fn conserves_energy(&self) -> bool {
        self.lost.is_none_or(|lost| lost >= -MOST_EXCESS)
    }

    /// Whether structures are long enough for diffuse light alone.
    pub fn is_long_enough(&self) -> bool {
        self.correlation_wavelengths.is_none_or(|l| l >= self.least_correlation_wavelengths)
    }
}

/// The word for a side in files.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn side_name<S: Serializer>(side: &Side, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match side {
        Side::Air => "air",
        Side::Dielectric => "dielectric",
    })
}

/// The word for a lobe in files.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn lobe_name<S: Serializer>(lobe: &Lobe, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match lobe {
        Lobe::Reflection => "reflection",
        Lobe::Transmission => "transmission",
    })
}

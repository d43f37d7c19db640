//! How waves are sent on a map.

use super::wavelengths::Wavelengths;

/// Whether readings are those of this very map, or of a larger piece of the same surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Speckle {
    /// The mean over the azimuths of the momentum: all directions of the surface must be alike.
    Averaged,
    /// This very map, which goes on as its edges say, its speckle smoothed by the detector's cone and the wavelengths
    /// alone.
    Kept,
    /// The same, but the map is all that is lit: a beam as large as the map.
    Patch,
}

/// How waves are sent on a map.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveOptions {
    /// The light, vacuum wavelengths in nm with weights.
    #[serde(rename = "wavelengths_nm")]
    pub wavelengths: Wavelengths,
    /// What readings are of.
    pub speckle: Speckle,
    /// Smith's shadowing and masking on the stationary facet: what Kirchhoff's integral leaves out.
    #[serde(default)]
    pub shadowing: bool,
}

impl Speckle {
    /// `averaged`, `kept` or `patch`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Averaged => "averaged",
            Self::Kept => "kept",
            Self::Patch => "patch",
        }
    }
}

//! A scene as its file says it: every value with its place.

use serde::Deserialize;
use toml::Spanned;

/// A value that may be left out.
pub(super) type Said<T> = Option<Spanned<T>>;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Draft {
    pub(super) name: Said<String>,
    pub(super) body: Said<BodyDraft>,
    #[serde(default)]
    pub(super) surface: Said<SurfaceDraft>,
    pub(super) source: Said<SourceDraft>,
    pub(super) wanted: Said<WantedDraft>,
    pub(super) target: Said<TargetDraft>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyDraft {
    pub(super) kind: Said<String>,
    pub(super) ior: Said<f64>,
    pub(super) abbe: Said<f64>,
    pub(super) rough: Said<String>,
    pub(super) behind: Said<String>,
    pub(super) thickness_mm: Said<f64>,
    pub(super) length_mm: Said<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceDraft {
    pub(super) rq_um: Said<f64>,
    pub(super) correlation_um: Said<f64>,
    pub(super) rms_slope: Said<f64>,
    pub(super) alpha: Said<f64>,
    pub(super) statistics: Said<String>,
    pub(super) map: Said<String>,
    pub(super) pixel_um: Said<f64>,
    pub(super) model: Said<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SourceDraft {
    pub(super) kind: Said<String>,
    pub(super) incidence_deg: Said<OneOrTwo>,
    pub(super) half_angle_deg: Said<f64>,
    pub(super) wavelength_nm: Said<OneOrTwo>,
    pub(super) file: Said<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WantedDraft {
    pub(super) quantity: Said<String>,
    pub(super) face: Said<String>,
    pub(super) theta_deg: Said<f64>,
    pub(super) azimuth_deg: Said<f64>,
    pub(super) half_angle_deg: Said<f64>,
    pub(super) observation_deg: Said<OneOrTwo>,
    pub(super) error_percent: Said<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TargetDraft {
    pub(super) kind: Said<String>,
    pub(super) kib: Said<f64>,
    pub(super) instructions: Said<f64>,
}

/// A number, or two.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "give a number, or two as in [0, 30]")]
pub(super) enum OneOrTwo {
    /// A number.
    One(f64),
    /// From, to.
    Two([f64; 2]),
}

impl OneOrTwo {
    /// From, to.
    pub(super) fn ends(self) -> [f64; 2] {
        match self {
            Self::One(x) => [x, x],
            Self::Two(both) => both,
        }
    }
}

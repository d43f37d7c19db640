//! The model file: a boundary's parameters, and how they were found. JSON, `"asperity": 1`.
//!
//! ```
//! use asperity::method::{Choice, Body};
//! use asperity::model::{Model, Value};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let surface = Body::Dielectric { ior: 1.49 };
//! let method = Choice::new("ggx", surface).method()?;
//! let alpha = ("alpha".to_owned(), Value::given(0.2, String::new()));
//! let text = Model::new(&*method, surface, [alpha].into_iter()).to_json();
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("model.json");
//! asperity::output::write_text(&path, &text)?;
//! let (model, boundary, _bytes) = Model::read(&path)?; // the boundary is ready to use
//! assert_eq!((&*model.method, boundary.eta()), ("ggx", Some(1.49)));
//! # Ok(())
//! # }
//! ```
//!
//! | module | concept |
//! |---|---|
//! | `record` | the measured map that a model was made with |
//! | `rank` | a law among those that were tried |
//! | `verdict` | what a fit is worth |
//! | `read` | from a file to a model, with the line of what is wrong |
//! | `build` | from a model to its boundary |
//! | `spread` | the uncertainty of what it says |

mod record;
mod rank;
mod verdict;
mod read;
mod build;
mod spread;

pub use self::rank::Rank;
pub use self::read::ModelError;
pub(crate) use self::read::read_bytes;
pub use self::record::MapRecord;
pub use self::spread::{NoSpread, Spread};
pub use self::verdict::{Contribution, Correlation, Flux, Grade, Verdict};

use std::collections::BTreeMap;

use asperity_core::bsdf::Lobe;
use serde::{Deserialize, Serialize};

use crate::kirchhoff::WaveOptions;
use crate::method::{Body, Bounces, Method};
use crate::provenance::Provenance;

/// Version of the format.
pub const FORMAT: u32 = 1;

/// A value with its unit, and its standard error if it was fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Value {
    /// The value, in the unit below.
    pub value: f64,
    /// The unit; empty if dimensionless.
    #[serde(default)]
    pub unit: String,
    /// Standard error; absent if the value was given, or the data do not determine it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// Where the profile of the cost does not confirm the curvature: the standard errors downwards and upwards, null where
    /// none can be stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error_sides: Option<[Option<f64>; 2]>,
    /// A note about the value: that it is `none`, or that its error is unreliable.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl Value {
    /// A value that was not fitted.
    pub fn given(value: f64, unit: String) -> Self {
        Self { value, unit, std_error: None, std_error_sides: None, note: None }
    }
}

/// The body that has the rough surface, in files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyKind {
    /// A clear dielectric; `ior` is given.
    #[default]
    Dielectric,
    /// An opaque body; no `ior`.
    Opaque,
    /// A sheet as measured; `ior` is its material's, where it is known.
    Sheet,
}

/// The lobe of a law that describes one, in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LobeKind {
    /// Light that stays on its side.
    Reflection,
    /// Light that goes through.
    Transmission,
}

impl From<Lobe> for LobeKind {
    fn from(lobe: Lobe) -> Self {
        match lobe {
            Lobe::Reflection => Self::Reflection,
            Lobe::Transmission => Self::Transmission,
        }
    }
}

impl From<LobeKind> for Lobe {
    fn from(kind: LobeKind) -> Self {
        match kind {
            LobeKind::Reflection => Self::Reflection,
            LobeKind::Transmission => Self::Transmission,
        }
    }
}

/// The error of a fit at one incidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IncidenceRecord {
    /// Angle of incidence, degrees.
    pub sigma_deg: f64,
    /// Error of eq. (18) for this incidence alone, %.
    pub rmsd_percent: Option<f64>,
}

/// A model or fit, as in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Version of the format, 1.
    pub asperity: u32,
    /// Name of the method.
    pub method: String,
    /// Shape of the law, for `normals`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// How many facets light may meet, `all` or `walk`, for methods of microfacets; one if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounces: Option<String>,
    /// The methods that a mix is made of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// The measured map, for methods that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapRecord>,
    /// The options of waves, for methods that use them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wave: Option<WaveOptions>,
    /// Seed of the heights, for methods that draw them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_seed: Option<u64>,
    /// The lobe, for laws of one lobe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lobe: Option<LobeKind>,
    /// Wavelength of a spectrum of roughness, nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelength_nm: Option<f64>,
    /// The body that has the surface.
    #[serde(default)]
    pub body: BodyKind,
    /// Refractive index over that of air; null for an opaque body.
    #[serde(default)]
    pub ior: Option<f64>,
    /// The parameters by name.
    #[serde(deserialize_with = "read::distinct")]
    pub parameters: BTreeMap<String, Value>,
    /// Error of eq. (18), %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rmsd_percent: Option<f64>,
    /// Noise of the measurement in the same terms, %.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor_percent: Option<f64>,
    /// Noise of the simulated readings in the same terms, %, for methods that trace rays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation_noise_percent: Option<f64>,
    /// The objective.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective: Option<String>,
    /// Its value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objective_value: Option<f64>,
    /// The error of every incidence.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub incidences: Vec<IncidenceRecord>,
    /// Evaluations of the forward model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evaluations: Option<u64>,
    /// Why the fit ended: `converged`, `max_evaluations` or `interrupted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub termination: Option<String>,
    /// Flux left out of the internal passes, as a fraction of the beam's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neglected_flux: Option<f64>,
    /// Estimate of what that adds to a reading at most, in % of the largest reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neglected_percent: Option<f64>,
    /// The laws that were tried beside this one, in the order of what the data support.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ranking: Vec<Rank>,
    /// What the fit is worth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Verdict>,
    /// Where the flux goes, from both sides.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fluxes: Vec<Flux>,
    /// Correlations of the errors of fitted parameters, each pair once.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<Correlation>,
    /// The budget of uncertainty, one row a source.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub budget: Vec<Contribution>,
    /// Draws of fitted values by the bootstrap, in the order of `sample_names`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub samples: Vec<Vec<f64>>,
    /// The parameters of the draws.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sample_names: Vec<String>,
    /// Warnings about the model's validity, in plain words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub validity: Vec<String>,
    /// What rigorous solutions say of waves and rays on a surface like the measured map, in plain words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub atlas: Vec<String>,
    /// The program and the inputs that made the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// The duration, the only part that differs between two runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<Timing>,
    /// The same in older files, before `timing`; not written.
    #[serde(default, skip_serializing, rename = "seconds")]
    old_seconds: Option<f64>,
}

/// The duration of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// Wall time, s.
    pub seconds: f64,
}

impl Model {
    /// A model that was not fitted.
    pub fn new(
        method: &dyn Method,
        body: Body,
        values: impl IntoIterator<Item = (String, Value)>,
    ) -> Self {
        let (body, ior) = match body {
            Body::Dielectric { ior } => (BodyKind::Dielectric, Some(ior)),
            Body::Opaque => (BodyKind::Opaque, None),
            Body::Sheet { ior } => (BodyKind::Sheet, ior),
        };
        Self {
            asperity: FORMAT,
            method: method.name().into(),
            law: method.profile().map(Into::into),
            bounces: (method.bounces() != Bounces::One).then(|| method.bounces().word().into()),
            of: method.of().to_vec(),
            map: None,
            wave: method.wave().cloned(),
            surface_seed: method.seed(),
            lobe: method.lobe().map(Into::into),
            wavelength_nm: method.wavelength_nm(),
            body,
            ior,
            parameters: values.into_iter().collect(),
            rmsd_percent: None,
            noise_floor_percent: None,
            simulation_noise_percent: None,
            objective: None,
            objective_value: None,
            incidences: Vec::new(),
            evaluations: None,
            termination: None,
            neglected_flux: None,
            neglected_percent: None,
            ranking: Vec::new(),
            verdict: None,
            fluxes: Vec::new(),
            correlations: Vec::new(),
            budget: Vec::new(),
            samples: Vec::new(),
            sample_names: Vec::new(),
            validity: Vec::new(),
            atlas: Vec::new(),
            provenance: None,
            timing: None,
            old_seconds: None,
        }
    }

    /// The file's text.
    pub fn to_json(&self) -> String {
        // A structure of strings and finite numbers cannot fail to serialise.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

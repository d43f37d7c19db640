//! The methods: each turns a few parameters into a rough boundary; all else is shared.
//!
//! | method | file | engine |
//! |---|---|---|
//! | `ggx` | [`ggx`] | closed form in `asperity_core::bsdf` |
//! | `normals` | [`normals`] | density of normals in `asperity_core::ndf` |
//! | `beckmann` | [`beckmann`] | microfacets of `asperity_core::bsdf`, Gaussian slopes |
//! | `student` | [`student`] | the same, with a fitted tail |
//! | `smith-normals` | [`smith_normals`] | the same, with the laws of `normals` |
//! | `slopes` | [`slopes`] | the same, with a density of slopes through knots |
//! | `abg`, `harvey`, `k-correlation`, `super-gauss` | [`tail`] | scatter about the specular direction, `asperity_core::bsdf::tail` |
//! | all four microfacet methods with several bounces | [`Bounces`] | `AllBounces` and `Walk` of `asperity_core::bsdf` |
//! | `mix` | [`mix`] | one or two of those side by side, `asperity_core::bsdf::Mix` |
//! | `heights` | [`heights`] | random heights of `surface`, traced by `raytrace` |
//! | `measured-ray` | [`measured_ray`] | measured map, filtered by `surface`, traced by `raytrace` |
//! | `measured-wave` | [`measured_wave`] | the same map, waves by `kirchhoff` |
//! | `measured-hybrid` | [`measured_hybrid`] | the same map, long waves traced, short ones diffracting, by `hybrid` |

mod parameter;
mod kind;
mod oriented;
mod bounces;
mod bouncing;
pub mod ggx;
pub mod normals;
pub mod beckmann;
pub mod student;
pub mod smith_normals;
pub mod slopes;
pub mod tail;
pub mod mix;
pub mod heights;
mod measured;
mod wave_job;
pub mod measured_ray;
pub mod measured_wave;
pub mod measured_hybrid;
mod registry;

pub use beckmann::BeckmannMethod;
pub use bounces::Bounces;
pub use ggx::GgxMethod;
pub use heights::HeightsMethod;
pub use kind::{Choice, Kind, Lack, Origin, Waves};
pub use measured_hybrid::MeasuredHybridMethod;
pub use measured_ray::MeasuredRayMethod;
pub use measured_wave::MeasuredWaveMethod;
pub use mix::MixMethod;
pub use normals::NormalsMethod;
pub use parameter::{Parameter, Scale};
pub use registry::{KINDS, in_words};
pub use slopes::SlopesMethod;
pub use smith_normals::SmithNormalsMethod;
pub use student::StudentMethod;
pub use tail::TailMethod;

use asperity_core::bsdf::Lobe;
use asperity_core::ndf::law::Profile;
use asperity_core::quantity::{Alpha, QuantityError, RelativeIor};

use crate::boundary::Boundary;
use crate::kirchhoff::WaveOptions;

/// Why parameters do not make a boundary. The text gives the domain.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A parameter is missing.
    #[error("parameter `{0}` is missing; the method needs it")]
    Missing(&'static str),
    /// A parameter is outside its domain.
    #[error("parameter `{name}` = {value} is outside its domain, {least} to {most}{}{unit}", if unit.is_empty() { "" } else { " " })]
    OutOfDomain {
        /// Its name.
        name: &'static str,
        /// The given value.
        value: f64,
        /// Smallest value.
        least: f64,
        /// Largest value.
        most: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// The refractive index is outside its domain, or missing.
    #[error("{0}")]
    Ior(String),
    /// More light would be scattered than there is.
    #[error(
        "the law scatters {scattered:.4} of the light along the normal, which is more than all; make its level lower"
    )]
    TooBright {
        /// Total integrated scatter with the specular share.
        scattered: f64,
    },
    /// The shares of a mix are more than the surface.
    #[error(
        "the shares of the second law, of what is specular and of what is diffuse are together {sum:.4}, more than 1; make one smaller"
    )]
    Shares {
        /// Their sum.
        sum: f64,
    },
    /// The wider law of a mix comes first.
    #[error("the first law of the mix is to be the narrower")]
    Order,
    /// The heights cannot be traced.
    #[error("{0}")]
    Map(String),
}

/// The body that has the rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// A clear dielectric of this refractive index relative to air.
    Dielectric {
        /// Index of the dielectric over that of air.
        ior: f64,
    },
    /// An opaque body, seen in reflection only.
    Opaque,
    /// A sheet as it is measured, air on both sides: no faces, no inside.
    Sheet {
        /// Index of its material, where it is known; the spectrum of roughness needs it in transmission.
        ior: Option<f64>,
    },
}

impl Body {
    /// The checked index.
    ///
    /// # Errors
    /// If it is outside the domain, or there is none.
    pub fn eta(&self) -> Result<RelativeIor<f64>, BuildError> {
        match *self {
            Self::Dielectric { ior } => RelativeIor::new(ior).map_err(|e| {
                BuildError::Ior(format!(
                    "refractive index {ior} is {e}; give one from {} to {}",
                    RelativeIor::<f64>::LEAST,
                    RelativeIor::<f64>::MOST
                ))
            }),
            Self::Opaque => Err(BuildError::Ior("an opaque body has no refractive index".into())),
            // air beyond it
            Self::Sheet { .. } => RelativeIor::new(1.0).map_err(|e| BuildError::Ior(e.to_string())),
        }
    }
}

/// One way to describe a rough boundary by a few numbers.
pub trait Method: Send + Sync {
    /// Name in files and on the command line.
    fn name(&self) -> &'static str;
    /// Works to cite, printed with every result.
    fn references(&self) -> &'static [&'static str];
    /// The parameters, in the order of the values.
    fn parameters(&self) -> &[Parameter];
    /// The boundary for values in the units of the parameters.
    ///
    /// # Errors
    /// [`BuildError`] names the value outside its domain.
    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError>;
    /// A boundary of a random surface of about so many cells, where less than all is enough; else all of it.
    ///
    /// # Errors
    /// As [`Method::boundary`].
    fn boundary_of(
        &self,
        values: &[f64],
        body: Body,
        cells: usize,
    ) -> Result<Boundary, BuildError> {
        let _ = cells;
        self.boundary(values, body)
    }
    /// The shape of the law, for methods that have one.
    fn profile(&self) -> Option<&'static str> {
        None
    }
    /// Whether its boundaries are traced: simulated by Monte Carlo, with its noise.
    fn is_traced(&self) -> bool {
        false
    }
    /// Whether its parameters are knots of a curve, of which single ones say nothing.
    fn is_free_form(&self) -> bool {
        false
    }
    /// The options of its waves, for methods that use them; their forward model costs seconds.
    fn wave(&self) -> Option<&WaveOptions> {
        None
    }
    /// The lobe it describes, for methods that describe one.
    fn lobe(&self) -> Option<Lobe> {
        None
    }
    /// The wavelength of its spectrum of roughness, nm.
    fn wavelength_nm(&self) -> Option<f64> {
        None
    }
    /// The methods that it is made of.
    fn of(&self) -> &[String] {
        &[]
    }
    /// How many facets light may meet.
    fn bounces(&self) -> Bounces {
        Bounces::One
    }
    /// Its name with what tells its variants apart: `normals (gauss)`.
    fn label(&self) -> String {
        let variant = self.profile().or(self.wave().map(|w| w.speckle.name()));
        let bounces = match self.bounces() {
            Bounces::One => None,
            Bounces::All => Some("all bounces"),
            Bounces::Walk => Some("walk"),
        };
        let variants: Vec<&str> = variant.into_iter().chain(bounces).collect();
        match variants[..] {
            [] => self.name().to_owned(),
            _ => format!("{} ({})", self.name(), variants.join(", ")),
        }
    }
    /// The seed of its surface, for methods that draw one.
    fn seed(&self) -> Option<u64> {
        None
    }
}

/// The word for the shape of a law.
fn profile_name(profile: Profile) -> &'static str {
    match profile {
        Profile::Gauss => "gauss",
        Profile::Cauchy => "cauchy",
    }
}

/// Checks the width of a slope distribution.
fn alpha(name: &'static str, value: f64) -> Result<Alpha<f64>, BuildError> {
    Alpha::new(value).map_err(|_: QuantityError| BuildError::OutOfDomain {
        name,
        value,
        least: Alpha::<f64>::LEAST,
        most: Alpha::<f64>::MOST,
        unit: "",
    })
}

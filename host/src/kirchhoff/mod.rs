//! Scattering of waves by a height map in the tangent-plane (Kirchhoff) approximation: reflection and
//! transmission, from both sides.
//!
//! Three rooms: `field`, the orders of this very map; `mean`, the law of what a larger piece scatters; `validity`, where either may
//! be trusted. They share the light (`wavelengths`), its momentum (`optics`), the choices (`options`), the slopes of a map and what they
//! hide (`slopes`, `shadowing`).

mod wavelengths;
mod options;
mod slopes;
mod optics;
mod shadowing;
pub mod validity;
mod field;
mod mean;

pub use asperity_fourier::{Coefficients, Fourier};
pub use field::{BeamOrders, Order, Tiling, orders};
pub use mean::{ByFlux, CoherentFlux, MeanSpectra, WaveBoundary, warning_for_rays};
pub use optics::Beam;
pub use options::{Shadowing, Speckle, WaveOptions};
pub use shadowing::shadows_by_itself;
pub use slopes::steepest_slope;
pub use validity::{GaussianLobe, GaussianVerdict, Loss, Validity, ValidityError};
pub use wavelengths::{Wavelengths, WavelengthsError};

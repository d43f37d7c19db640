//! Scattering of waves by a height map in the tangent-plane (Kirchhoff) approximation: reflection and
//! transmission, from both sides.

mod wavelengths;
mod light;
mod options;
mod slopes;
mod margins;
mod facets;
mod conditions;
pub mod validity;
mod gaussian;
mod warnings;
mod screen;
mod kernel;
mod optics;
mod horizon;
mod patch;
mod stack;
mod orders;
mod coherent;
mod coherence;
mod rings;
mod density;
mod mean;
mod shadowing;
mod aim;
mod boundary;
mod sampling;
mod flux;
mod by_flux;

pub use asperity_fourier::{Coefficients, Fourier};
pub use boundary::{CoherentFlux, WaveBoundary};
pub use by_flux::ByFlux;
pub use coherence::warning_for_rays;
pub use gaussian::{GaussianLobe, GaussianVerdict};
pub use mean::MeanSpectra;
pub use optics::Beam;
pub use options::{Shadowing, Speckle, WaveOptions};
pub use orders::{BeamOrders, Order, orders};
pub use stack::Tiling;
pub use validity::{Loss, Validity, ValidityError};
pub use wavelengths::{Wavelengths, WavelengthsError};

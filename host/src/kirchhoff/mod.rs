//! Scattering of waves by a height map in the tangent-plane (Kirchhoff) approximation: reflection and
//! transmission, from both sides.

mod wavelengths;
mod light;
mod facets;
pub mod validity;
mod warnings;
mod fft;
mod screen;
mod kernel;
mod optics;
mod orders;
mod coherent;
mod coherence;
mod mean;
mod shadowing;
mod boundary;

pub use boundary::{CoherentFlux, Speckle, WaveBoundary, WaveOptions};
pub use coherence::warning_for_rays;
pub use fft::{Coefficients, Fourier};
pub use mean::MeanSpectra;
pub use optics::Beam;
pub use orders::{BeamOrders, Order, orders};
pub use validity::{Validity, ValidityError};
pub use wavelengths::{Wavelengths, WavelengthsError};

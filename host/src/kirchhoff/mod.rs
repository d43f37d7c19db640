//! Wave optics on a height map in the Kirchhoff (tangent plane) approximation.

mod wavelengths;
mod light;
mod facets;
pub mod validity;
mod warnings;

pub use validity::{Validity, ValidityError};
pub use wavelengths::{Wavelengths, WavelengthsError};

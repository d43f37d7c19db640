//! Wave optics on a height map in the Kirchhoff (tangent plane) approximation.

mod wavelengths;

pub use wavelengths::{Wavelengths, WavelengthsError};

//! Measured surfaces: height maps, their files and figures, and what is done to them before light is.

pub mod heightmap;
pub mod form;
mod ten_point;
pub mod roughness;
pub mod edges;
mod nearest;
mod membrane;
pub mod fill;
pub mod crop;
mod transform;
pub mod gaussian;
#[cfg(test)]
mod synthetic;
pub mod modify;
pub mod spectrum;
pub mod split;
pub mod structure;
pub mod io;
pub mod sanity;
pub mod prepare;
pub mod random;

pub use crop::Crop;
pub use edges::Edges;
pub use fill::Fill;
pub use form::Form;
pub use gaussian::GaussianSurface;
pub use heightmap::{HeightMap, HeightMapError, Incomplete};
pub use modify::{LowPass, scaled};
pub use prepare::{Preparation, Prepared, Purpose};
pub use random::{HeightLaw, RandomHeights};
pub use roughness::Roughness;
pub use spectrum::Spectrum;

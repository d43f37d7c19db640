//! Measured surfaces: height maps, their files and figures, and their preparation for light.
//!
//! ```
//! use asperity::surface::{Edges, GaussianSurface, Roughness, Spectrum};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (size, pitches_um, lengths_um) = ((128, 128), (0.5, 0.5), (4.0, 4.0));
//! let surface = GaussianSurface { size, pitches_um, rq_um: 0.7, lengths_um, seed: 1 };
//! let map = surface.map().ok_or("no surface")?; // from a file: Preparation::load
//! assert!((Roughness::of(&map).rq_um - 0.7).abs() < 1e-9);
//! let spectrum = Spectrum::of(&map, Edges::Periodic)?;
//! assert!(spectrum.anisotropy().is_some_and(|a| !a.is_directional()));
//! # Ok(())
//! # }
//! ```

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

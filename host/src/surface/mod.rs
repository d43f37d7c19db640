//! Measured surfaces: height maps, their files and figures.

pub mod heightmap;
pub mod edges;
pub mod form;
pub mod roughness;
pub mod io;

pub use edges::Edges;
pub use form::Form;
pub use heightmap::{HeightMap, HeightMapError};
pub use roughness::Roughness;

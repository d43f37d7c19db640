//! Distributions of microfacet normals.

#[cfg(any(feature = "ggx", feature = "table"))]
pub mod ggx;
#[cfg(feature = "normals")]
pub mod law;
#[cfg(feature = "normals")]
mod edge;
#[cfg(feature = "normals")]
mod visible;
#[cfg(feature = "normals")]
pub mod normals;

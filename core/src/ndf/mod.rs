//! Distributions of microfacet normals.

pub mod ggx;
pub mod law;
mod edge;
mod visible;
pub mod normals;

//! Distributions of microfacet normals.

pub mod ggx;
pub mod law;
mod edge;
pub mod normals;

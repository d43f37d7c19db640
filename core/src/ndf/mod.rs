//! Distributions of microfacet normals.

pub mod ggx;
pub mod law;
pub mod normals;

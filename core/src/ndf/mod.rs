//! Distributions of microfacet normals.

#[cfg(any(feature = "ggx", feature = "table", feature = "microfacet"))]
pub mod ggx;
#[cfg(feature = "normals")]
pub mod law;
#[cfg(feature = "normals")]
mod edge;
#[cfg(feature = "normals")]
mod form;
#[cfg(feature = "normals")]
mod quantile;
#[cfg(feature = "normals")]
mod visible;
#[cfg(feature = "normals")]
pub mod normals;
#[cfg(feature = "microfacet")]
pub mod density;
#[cfg(feature = "microfacet")]
pub mod ggx_facets;
#[cfg(feature = "microfacet")]
pub mod beckmann;
#[cfg(feature = "microfacet")]
pub mod student;
#[cfg(feature = "microfacet")]
pub mod smith;
#[cfg(feature = "microfacet")]
mod knots;
#[cfg(feature = "microfacet")]
pub mod slopes;
#[cfg(feature = "microfacet")]
pub mod stretched;
#[cfg(feature = "microfacet")]
pub mod any;

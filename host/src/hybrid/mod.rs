//! Rays and waves on one height map: long waves of the surface are traced with all bounces, short ones diffract.
//!
//! The two-scale model of a rough surface: a facet of the smooth, long part does not refract and reflect as a mirror
//! does, but scatters as a level surface with the short part on it does, by the mean law of Kirchhoff's integral.

mod scales;
mod boundary;

pub use boundary::HybridBoundary;
pub use scales::Scales;

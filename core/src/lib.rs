//! BSDF evaluators, plate and goniophotometer, without `std` and without allocation.
//!
//! Conventions (CONVENTIONS.md): +z is the mean surface normal and points into the air; directions are
//! unit vectors pointing away from the surface; `eval` is `f` in 1/sr without cosine, `ars` is
//! `f |cos theta_o|`, `pdf` is per solid angle of `wo`; flux, not radiance, is transported.
//!
//! Features of cargo leave out what is not asked for: [`scope`].
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests may fail"))]
#![allow(clippy::inline_always, reason = "generic arithmetic must vanish into vectorised loops")]

#[cfg(test)]
extern crate std;

pub mod scope;
pub mod math;
pub mod quantity;
pub mod direction;
#[cfg(feature = "normals")]
pub mod quadrature;
pub mod sampling;
pub mod fresnel;
pub mod ndf;
pub mod bsdf;
#[cfg(feature = "table")]
pub mod table;
#[cfg(feature = "slot")]
pub mod slot;
#[cfg(feature = "gonio")]
pub mod plate;
#[cfg(feature = "gonio")]
pub mod gonio;
#[cfg(feature = "gonio")]
pub mod metric;
#[cfg(feature = "protocol")]
pub mod protocol;

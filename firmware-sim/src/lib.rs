//! The device side: Asperity's core as it runs on a Cortex-M, without `std` and without allocation.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

pub mod digest;
pub mod selftest;

//! The device side: a goniophotometer without a motor, and Asperity's core as it runs on a Cortex-M.
//!
//! [`Simulator`] takes bytes and the time and gives bytes: it waits for nothing, allocates nothing and
//! panics on nothing, so that the same code is a program on a workstation and firmware on a board.
//! PROTOCOL.md says what it answers.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.
#![no_std]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(
    test,
    allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests may fail")
)]

#[cfg(test)]
extern crate std;

pub mod digest;
pub mod hostile;
mod seeded;
mod selftest_laws;
pub mod selftest;
pub mod clock;
pub mod fault;
pub mod transition;
mod axis;
mod config;
mod optics;
mod detector;
mod memory;
mod machine;
mod session;
mod text;
mod simulator;

pub use clock::{Instant, Sink};
pub use config::{Boundary, Config};
pub use fault::MachineFault;
pub use simulator::Simulator;

#[cfg(test)]
mod tests;

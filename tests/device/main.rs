//! The device side, run: what a Cortex-M4F computes and says must be what this machine does.
//!
//! Needs `qemu-system-arm` and the Rust target `thumbv7em-none-eabihf`; without them see [`asperity_needs`]. `ASPERITY_DEVICE_ENV`,
//! assignments separated by blanks, is given to the compiler run for the device (see `.ci/run`).
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may fail")]

mod corruption;
mod counts;
mod elf;
mod emulator;
mod evaluator;
mod features;
mod instrument;
mod protocol;
mod selftest;
mod trade;

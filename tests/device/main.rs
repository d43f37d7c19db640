//! The device side, run: what a Cortex-M4F computes and says must be what this machine does.
//!
//! Needs `qemu-system-arm` and the Rust target `thumbv7em-none-eabihf`. Without them the tests say what
//! to install and pass; where the environment variable `CI` is set they fail. `ASPERITY_DEVICE_ENV`,
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

use std::io::Write as _;

/// Says that a test cannot run here; `cargo test` shows what goes to standard error directly.
fn skip(remedy: &str) {
    let ci = std::env::var("CI").is_ok_and(|v| !v.is_empty() && v != "false");
    assert!(!ci, "{remedy} (a failure, not a skip, because CI is set)");
    let _ = writeln!(std::io::stderr(), "skipped: {remedy}");
}

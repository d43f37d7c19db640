//! The evaluators of `asperity-core` behind a C ABI.
//!
//! `include/asperity.h` is what a C or C++ program sees; it is generated from this crate and kept in the
//! repository (`tests/capi` compares it). Objects live in storage of the caller, nothing is allocated, no
//! function keeps state, so the same code is linked into a program of a workstation and into a firmware:
//!
//! ```text
//! cargo build --release -p asperity-capi                       # libasperity_capi.a and .so
//! cargo rustc --profile firmware -p asperity-capi --crate-type staticlib \
//!     --no-default-features --features panic-handler,table-u16,air,transmission --target thumbv7em-none-eabihf
//! ```
//!
//! **No panic crosses the border.** Core has no path to one, and this crate adds none: the linked firmware
//! of `tests/capi` has no symbol of a panic. Nothing is therefore caught here. Were there one after all,
//! `extern "C"` would end the program instead of unwinding into C.
//!
//! **Unsafe code** is in `abi` alone. It checks pointers and turns them into values and slices; what those
//! mean is the business of the safe modules above it. Under Miri, on a machine for which `libm` has no
//! assembly, since Miri reads none:
//!
//! ```text
//! cargo +nightly miri test -p asperity-capi --target riscv64gc-unknown-linux-gnu
//! ```
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.
#![cfg_attr(target_os = "none", no_std)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests may fail"))]
#![allow(clippy::inline_always, reason = "a call must cost what the evaluator costs")]

pub mod status;
pub mod options;
pub mod law;
pub mod table;
pub mod abi;
#[cfg(all(target_os = "none", feature = "panic-handler"))]
mod panic;

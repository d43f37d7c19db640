//! The C ABI, used from C and C++: on this machine, under Valgrind, and linked for a Cortex-M4F.
//!
//! Needs a C and a C++ compiler, pkg-config, `CMake`, Valgrind, `gcc-arm-none-eabi` with newlib and the Rust target
//! `thumbv7em-none-eabihf`. Without one of them a test says what to install and passes; where the environment
//! variable `CI` is set it fails. `ASPERITY_DEVICE_ENV` is as for the tests of the device.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests may fail")]

mod tools;
mod table;
mod header;
mod programs;
mod install;
mod hostile;
mod firmware;

//! What `plan` promises, measured.
//!
//! Figures are printed; `--nocapture` shows them. `ASPERITY_EXTENSIVE=1` runs five scenes on three surfaces with five seeds.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests and their helpers; figures are shown with --nocapture"
)]

mod scenes;
mod schedule;

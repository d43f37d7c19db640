//! From readings to a fit through the library: measured scans, recovery of known models, the two forward
//! models against each other, and what a fit does with readings that make no sense.
//!
//! Figures are printed; `--nocapture` shows them.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests and their helpers; figures are shown with --nocapture"
)]

mod common;
mod bounces;
mod student;
mod real_scans;
mod traced_samples;
mod verdicts;
mod coverage;
mod own_map;
mod wave_samples;
mod kirchhoff_validity;
mod kirchhoff_atlas;
mod atlas_intervals;
mod noise_floor;
mod metals;
mod recovery;
mod forward;
mod forward_inside;
mod forward_limits;
mod out_of_plane;
mod tails;
mod mix;
mod fit_robustness;
mod optional_parameters;
mod odd_lobes;
mod anisotropy;

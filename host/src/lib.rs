//! Reconstructs the BSDF of rough optical surfaces from goniophotometer scans.
//!
//! Features, all on by default: `cli`, the program `asperity`; `plots`, plots and reports; `serial`, instruments at a serial
//! port.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.

pub mod message;
mod linear;
mod custody;
mod scratch;
mod input;
pub mod output;
pub mod provenance;
pub mod measurement;
pub mod acquire;
pub mod surface;
pub mod raytrace;
pub mod kirchhoff;
pub mod hybrid;
pub mod embedded;
pub mod boundary;
pub mod batch;
pub mod forward;
pub mod table;
pub mod method;
pub mod model;
pub mod law_file;
pub mod energy;
pub mod tabulate;
pub mod trade;
pub mod fit;
pub mod reconstruct;
#[cfg(feature = "plots")]
pub mod plot;
#[cfg(feature = "plots")]
pub mod report;
#[cfg(feature = "cli")]
pub mod cli;

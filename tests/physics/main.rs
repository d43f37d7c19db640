//! Physics of the evaluators and the plate, against textbook formulas, reference data and brute force.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests and their helpers; tables are shown with --nocapture"
)]

mod common;
mod harness;
mod golden;
mod fresnel;
mod ggx;
mod microfacets;
mod tiers;
mod precision;
mod heightfield;
mod kirchhoff;
mod normals;
mod energy;
mod bounces;
mod reciprocity;
mod sampling;
mod extremes;
mod plate;
mod table;
mod embedded_table;
mod table_distance;
mod table_damage;
mod coherent_returns;
mod table_boundary;

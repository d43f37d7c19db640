//! Light in a scene of rough bodies: a path tracer for any scattering law.
//!
//! Lengths are in metres, radiances in the unit in which the scene gives its lamps. The same scene, seed and number of paths
//! give the same bits with any number of threads and on any machine: all mathematics but the basic operations and the square
//! root is libm's.
#![allow(clippy::inline_always, reason = "a path is one loop")]

pub mod ray;
pub mod shape;
pub mod law;
pub mod camera;
pub mod scene;
mod lamp;
pub mod path;
mod numbers;
pub mod colour;
pub mod tally;
pub mod image;
mod state;
pub mod region;
pub mod scene_file;

pub use glam;
pub use state::StateError;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

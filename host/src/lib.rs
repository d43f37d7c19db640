//! Reconstructs the BSDF of rough optical surfaces from goniophotometer scans.
//!
//! A goniophotometer measures a plate: two faces, and all reflections between them. This crate finds the scattering law of the rough face
//! alone, also from inside the material, where no instrument can look. Frame, units and the meaning of each figure are those of
//! [`asperity_core`].
//!
//! # Example
//! A scan becomes a model, and the model gives values that no instrument can measure:
//! ```
//! use asperity::reconstruct::fit_scan;
//! use asperity_core::direction::Direction;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("scan.csv");
//! std::fs::write(
//!     &path,
//!     "# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 0.6\n\
//!     sigma_deg,theta_deg,reading\n0,-10,0.00013\n0,-5,0.00061\n0,0,0.00113\n0,5,0.00061\n0,10,0.00013\n",
//! )?;
//! let fit = fit_scan(&path, "ggx")?.entry.fit;
//! let alpha = &fit.parameters[0];
//! assert!(alpha.value > 0.05 && alpha.value < 0.5, "{}", alpha.value);
//! // f from inside the material, towards the air
//! let (inside, air) = (Direction::new(0.0, 0.0, -1.0), Direction::new(0.1, 0.0, 0.995));
//! let f = fit.boundary.eval(inside.ok_or("zero")?, air.ok_or("zero")?);
//! assert!(f > Some(0.0));
//! # Ok(())
//! # }
//! ```
//! What the header does not say is said by [`reconstruct::Said`]; [`reconstruct::Task`] takes maps, light and options.
//!
//! # Architecture
//! Each stage reads the immutable result of the stage before and makes its own; nothing flows back.
//!
//! 1. **Data.** [`measurement`] reads scans, [`acquire`] measures them on an instrument. [`surface`] reads height maps and prepares them.
//! 2. **Light on a map.** [`raytrace`] follows rays, [`kirchhoff`] computes waves, [`hybrid`] combines both; [`atlas`] quotes by how much they err, [`rigorous`] solves
//!    Maxwell's equations on grooves.
//! 3. **Boundary.** [`boundary::Boundary`] is the rough face that any method makes: a closed form of [`asperity_core::bsdf`], a map with rays or
//!    waves, or a table from a file ([`embedded`]). A boundary that can only be sampled gets values from [`binned`] rays.
//! 4. **Forward model.** [`forward`] puts the boundary into a plate and an instrument and predicts readings: by quadrature if the boundary has
//!    values, else by Monte Carlo with common random numbers.
//! 5. **Reconstruction.** A [`method`] turns a few parameters into a boundary; [`mod@fit`] searches the parameters, with standard errors and a verdict; [`mod@reconstruct`]
//!    finds body and instrument in the header of a scan, tries what a method allows, and keeps the best.
//! 6. **Results.** [`model`] is the file of parameters, [`law_file`] reads models and tables alike, [`energy`] sums fluxes, [`mod@tabulate`]
//!    makes tables for a device, [`mod@export`] gives laws to the formats of other programs ([`exchange`]), [`trade`] compares evaluators. `report`, `plot` and `render` are for people; the command line is the last layer.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.
//!
//! # Features
//! All are on by default: `cli`, the program `asperity`; `plots`, plots and reports; `render`, images of scenes; `serial`, instruments at a serial port.

pub use asperity_exchange as exchange;
pub use asperity_surface as surface;
use asperity_surface::{input, linear};

pub mod shard;
pub mod watch;
mod parallel;
pub mod message;
mod custody;
mod scratch;
pub mod output;
pub mod provenance;
pub mod measurement;
pub mod acquire;
pub mod raytrace;
pub mod kirchhoff;
pub mod hybrid;
pub mod atlas;
pub mod rigorous;
pub mod embedded;
pub mod boundary;
pub mod batch;
pub mod forward;
pub mod binned;
pub mod method;
pub mod model;
pub mod law_file;
pub mod energy;
pub mod export;
pub mod tabulate;
pub mod trade;
pub mod fit;
pub mod reconstruct;
pub mod specimens;
pub mod plan;
#[cfg(feature = "plots")]
pub mod plot;
#[cfg(feature = "plots")]
pub mod report;
#[cfg(feature = "render")]
pub mod render;
#[cfg(feature = "cli")]
pub mod cli;

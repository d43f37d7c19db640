//! Reconstructs the BSDF of rough optical surfaces from goniophotometer scans.
//!
//! A scan becomes a model, and the model tells what no instrument sees:
//! ```
//! use std::path::Path;
//!
//! use asperity::fit::{FitOptions, fit};
//! use asperity::{measurement::csv, method::Choice, reconstruct::Said, watch::Watch};
//! use asperity_core::{bsdf::Bsdf, direction::Direction};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = b"# geometry: transmission\n# ior: 1.49\n# rough_side: source\n# aperture_deg: 0.6\n\
//!     sigma_deg,theta_deg,reading\n0,-10,0.00013\n0,-5,0.00061\n0,0,0.00113\n0,5,0.00061\n0,10,0.00013\n";
//! let scan = csv::parse(text, Path::new("scan.csv"))?; // of a file: csv::load
//! let plate = Said::default().about(&scan)?; // all is in the header
//! let method = Choice::new("ggx", plate.body).method()?;
//! let options = FitOptions::new(plate.body);
//! let found = fit(&*method, &scan, &plate.setup, &options, Watch::nobody())?;
//! let alpha = &found.parameters[0];
//! assert!(alpha.value > 0.05 && alpha.value < 0.5, "{}", alpha.value);
//! // f from inside the material, towards the air
//! let (inside, air) = (Direction::new(0.0, 0.0, -1.0), Direction::new(0.1, 0.0, 0.995));
//! if let asperity::boundary::Boundary::Ggx(rough_face) = &found.boundary {
//!     assert!(rough_face.eval(inside.ok_or("zero")?, air.ok_or("zero")?) > 0.0);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Features, all on by default: `cli`, the program `asperity`; `plots`, plots and reports; `serial`, instruments at a serial
//! port.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.

pub use asperity_surface as surface;
use asperity_surface::{input, linear};

pub mod watch;
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
pub mod embedded;
pub mod boundary;
pub mod batch;
pub mod forward;
pub mod binned;
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

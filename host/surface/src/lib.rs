//! Measured surfaces: files of 27 profilometer formats, roughness, form removal, filters, random surfaces.
//!
//! ```
//! use asperity_surface::io::{OpenOptions, parse};
//! use asperity_surface::{Form, Roughness};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = b"# x [um] y [um] z [nm]\n\
//!     0 0 10\n1 0 24\n2 0 30\n0 1 10\n1 1 16\n2 1 30\n0 2 10\n1 2 20\n2 2 30\n";
//! let raw = parse(text, &OpenOptions::default())?; // of a file: io::open
//! assert_eq!((raw.nx, raw.ny, raw.dx_um), (3, 3, Some(1.0)));
//! let map = raw.into_map(None)?; // None: no pixel size but that of the file
//! let flat = Form::Plane.removed(&map);
//! let (tilted, flat) = (Roughness::of(&map), Roughness::of(&flat));
//! assert!(tilted.rq_um > 0.008 && flat.rq_um < 0.002);
//! println!("Ra {:.2} nm, Rq {:.2} nm", 1e3 * flat.ra_um, 1e3 * flat.rq_um);
//! # Ok(())
//! # }
//! ```
//!
//! What there is:
//! - [`io`] reads x3p, SDF, Alicona al3d, Wyko opd, Bruker/DI, Digital Surf sur, Gwyddion gwy and text, npy and npz, PNG, TIFF, lists
//!   of points and matrices, told apart by content. A [`RawMap`](io::RawMap) is what a file says. **Units are never guessed**:
//!   what a file does not say is a [`MapFault`](io::MapFault) until [`OpenOptions`](io::OpenOptions) says it. Any bytes are
//!   answered by a map or an error, in bounded memory.
//! - [`HeightMap`]: heights in um over a regular grid; points may be missing ([`Fill`] makes them up, [`Crop`] avoids them).
//! - [`Form`] removes a mean, a plane or a quadratic surface; [`Roughness`] has Ra, Rq, Rz and their kin, slopes and the
//!   autocorrelation length; [`Areal`] the parameters of ISO 25178-2; [`Spectrum`] the power spectral density; [`structure`] the structure function.
//! - [`LowPass`], [`split`] and [`scaled`] make other maps of one; [`Edges`] says how a map goes on.
//! - [`GaussianSurface`] and [`RandomHeights`] make surfaces, from a seed; [`Patches`] two pieces of one with printed figures.
//! - [`Preparation`] does all of it in the usual order, from a file to the map that is used, and can be written down.
//! - [`sanity`] refuses what no surface is: rms slopes above 30, and for light one line of points or pixels of a
//!   decimetre.
//!
//! Messages name what is missing by the flag of the program `asperity`, which is the name of the field here: `--pixel-um` is
//! [`pixel_um`](io::OpenOptions::pixel_um).
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.

pub mod message;
pub mod input;
#[doc(hidden)] // shared with `asperity`, nothing of surfaces
pub mod linear;
pub mod heightmap;
pub mod form;
mod ten_point;
pub mod roughness;
pub mod edges;
pub mod autocorrelation;
pub mod areal;
mod nearest;
mod membrane;
pub mod fill;
pub mod crop;
pub mod gaussian;
#[cfg(test)]
mod synthetic;
pub mod modify;
pub mod figures;
pub mod patches;
pub mod spectrum;
pub mod split;
pub mod structure;
pub mod io;
pub mod sanity;
pub mod prepare;
pub mod random;

pub use areal::Areal;
pub use crop::Crop;
pub use edges::Edges;
pub use figures::{HeightDensity, HeightFigures, NoHeights};
pub use fill::Fill;
pub use form::Form;
pub use gaussian::GaussianSurface;
pub use heightmap::{HeightMap, HeightMapError, Incomplete};
pub use modify::{LowPass, scaled};
pub use patches::{Patches, Profilometer};
pub use prepare::{Preparation, Prepared, Purpose};
pub use random::{HeightLaw, RandomHeights};
pub use roughness::Roughness;
pub use spectrum::Spectrum;

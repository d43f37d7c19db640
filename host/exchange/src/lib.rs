//! Sampled BSDFs in the formats of optical design, lighting and measurement programs.
//!
//! [`SampledBsdf`] is one lobe of one side of a surface on a grid. [`formats`] reads and writes it; every format says how the program that
//! reads it interpolates ([`Interpolation`]), and [`SampledBsdf::flux`] integrates it in just that way, so that the flux of
//! a file is the flux its reader will compute. [`plan`] chooses the grid of a law.
//!
//! # Convention
//! All angles are radians. Incidence `theta` is measured from the normal of the side the light comes from, 0 to pi/2; its azimuth `phi` is that
//! of the source, counter-clockwise from x seen from the air. Outgoing `theta` is measured from the normal on the side the light leaves to, 0
//! to pi/2. Outgoing `phi` is relative to the plane of incidence: 0 is the side of the specular or direct ray, pi the side of
//! the source, counter-clockwise seen from the air. Values are BSDF, 1/sr, without cosine and without the eta^2 of radiance.

pub mod frame;
pub mod interpolation;
pub mod sampled;
mod nearest;
pub mod convention;
pub mod interpolate;
pub mod flux;
pub mod isotropy;
pub mod table;
pub mod law;
mod hemisphere;
mod refine;
pub mod plan;
mod square;
mod patches;
pub mod error;
pub mod text;
pub mod formats;
pub mod resample;
pub mod compare;
pub mod compare_patches;
#[cfg(test)]
mod tests_round_trip;
#[cfg(test)]
mod tests_texts;
#[cfg(test)]
mod tests_faults;
#[cfg(test)]
mod tests_radiance;

pub use error::{Fault, FileError};
pub use formats::{FORMATS, Format, read, read_bytes};
pub use interpolation::Interpolation;
pub use sampled::{Band, Grid, Incidence, Lobe, Nodes, Patch, SampledBsdf, Side, Symmetry};

//! Fourier transforms of lines and grids, in the precisions that Asperity uses.
//!
//! [`Fourier`] takes a complex field, periodic or mirrored, into its coefficients; [`RealFourier`] a real grid there and back. Both
//! transform line by line, along x and then in panels of neighbouring columns, and give the same bits for any number of threads.
//! A mirrored line takes a transform of its own length, not of twice as much \[Makhoul 1980\].
//!
//! rustfft's algorithms are generic, so they are compiled anew in every crate that makes a plan: a quarter of the
//! code of `asperity`, at each build of it. Here they are compiled once, and behind trait objects nothing of them is
//! left in the callers.
//!
//! The order of the `mod` lines is the layer order: a module imports only modules above it.

mod precision;
mod lines;
mod complex;
mod real;

pub use complex::{Coefficients, Fourier, place};
pub use lines::Ends;
pub use precision::Precision;
pub use real::RealFourier;

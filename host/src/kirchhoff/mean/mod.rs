//! The mean law: what a larger piece of the same surface scatters, and a boundary that follows it.
//!
//! `coherent` is the light that keeps its direction. `rings` average the far field of a map over azimuths, `spectra` keeps these
//! means by `q_z`, `density` looks up between them. `boundary` is the law of them, `aim` and `sampling` draw rays from it, `flux` sums
//! it ring by ring, `by_flux` draws many rays of even weights.

mod coherent;
mod rings;
mod density;
mod spectra;
mod aim;
mod boundary;
mod sampling;
mod flux;
mod by_flux;

pub use boundary::{CoherentFlux, WaveBoundary};
pub use by_flux::ByFlux;
pub use coherent::warning_for_rays;
pub use spectra::MeanSpectra;

//! Seeded random maps for tests.

use crate::gaussian::GaussianSurface;
use crate::heightmap::HeightMap;

/// A periodic map of Gaussian heights, Rq 1 um, whose autocorrelation falls to 1/e over `correlation` pitches.
pub(super) fn gaussian(
    size: (usize, usize),
    pitches_um: (f64, f64),
    correlation: f64,
    seed: u64,
) -> HeightMap {
    stretched(size, pitches_um, (correlation, correlation), seed)
}

/// The same with two correlation lengths.
pub(super) fn stretched(
    size: (usize, usize),
    pitches_um: (f64, f64),
    (along_x, along_y): (f64, f64),
    seed: u64,
) -> HeightMap {
    let lengths_um = (along_x * pitches_um.0, along_y * pitches_um.1);
    GaussianSurface { size, pitches_um, rq_um: 1.0, lengths_um, seed }.map().unwrap()
}

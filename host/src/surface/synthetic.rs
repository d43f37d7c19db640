//! Seeded random maps for tests.

use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;

use super::transform::Transform;
use super::{Edges, HeightMap};

/// A periodic map of Gaussian heights, Rq 1 um, whose autocorrelation falls to 1/e over `correlation` pitches.
pub(super) fn gaussian(
    size: (usize, usize),
    pitches_um: (f64, f64),
    correlation: f64,
    seed: u128,
) -> HeightMap {
    stretched(size, pitches_um, (correlation, correlation), seed)
}

/// The same with two correlation lengths.
pub(super) fn stretched(
    (nx, ny): (usize, usize),
    pitches_um: (f64, f64),
    (along_x, along_y): (f64, f64),
    seed: u128,
) -> HeightMap {
    let generator = &mut Pcg64Mcg::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 12345);
    let normal: Vec<f64> = (0..nx * ny)
        .map(|_| {
            let r = (-2.0 * (1.0 - f64::uniform(generator)).ln()).sqrt();
            r * (std::f64::consts::TAU * f64::uniform(generator)).cos()
        })
        .collect();
    let transform = Transform::new((nx, ny), Edges::Periodic);
    let weight = |periods: f64, n: usize, length: f64| {
        (-0.5 * (std::f64::consts::PI * length * periods / n as f64).powi(2)).exp()
    };
    let heights = transform.weighted_back(
        &transform.forward(normal),
        |i| weight(transform.periods_x(i), nx, along_x),
        |j| weight(transform.periods_y(j), ny, along_y),
    );
    let rms = (heights.iter().map(|h| h * h).sum::<f64>() / heights.len() as f64).sqrt();
    let heights = heights.iter().map(|h| h / rms).collect();
    HeightMap::new((nx, ny), pitches_um, heights).unwrap()
}

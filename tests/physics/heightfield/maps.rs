//! Maps to trace: white noise, waves, Gaussian heights; all seeded.

use std::f64::consts::TAU;
use std::sync::Arc;

use asperity::raytrace::{Field, TracedBoundary};
use asperity::surface::{Edges, HeightMap};

use crate::common::{Random, ior};

pub(super) const ETA: f64 = 1.49;
pub(super) const EDGES: [Edges; 2] = [Edges::Periodic, Edges::Mirrored];

/// A source of uniforms for the `number`-th of many: small seeds of the generator itself share streams by fours.
pub(super) fn stream(number: u64) -> Random {
    Random::new(u128::from(number + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835))
}

/// A surface of index 1.49.
pub(super) fn boundary(map: &HeightMap, edges: Edges) -> TracedBoundary {
    TracedBoundary { field: Arc::new(Field::new(map, edges).unwrap()), eta: ior(ETA) }
}

/// Mean square of the slope of the facets along x and along y; both triangles of a cell have the
/// differences of its sides.
fn mean_square_slopes(map: &HeightMap) -> [f64; 2] {
    let (nx, ny) = (map.nx(), map.ny());
    let height = |x: usize, y: usize| map.height_um(x % nx, y % ny).unwrap();
    let mut sum = [0.0; 2];
    for y in 0..ny {
        for x in 0..nx {
            sum[0] += (height(x + 1, y) - height(x, y)).powi(2);
            sum[1] += (height(x, y + 1) - height(x, y)).powi(2);
        }
    }
    let n = (nx * ny) as f64;
    [sum[0] / n / map.dx_um().powi(2), sum[1] / n / map.dy_um().powi(2)]
}

/// Scaled so that the root mean square of the whole slope, both axes together, is as given.
fn with_slope(map: HeightMap, slope: f64) -> HeightMap {
    let [x, y] = mean_square_slopes(&map);
    let scale = slope / (x + y).sqrt();
    map.map(|_, _, h| h * scale)
}

/// Independent heights: facets of all kinds, many bounces.
pub(super) fn noise(
    (nx, ny): (usize, usize),
    pitch: (f64, f64),
    slope: f64,
    seed: u64,
) -> HeightMap {
    let mut random = stream(seed);
    let heights = (0..nx * ny).map(|_| random.next()).collect();
    with_slope(HeightMap::new((nx, ny), pitch, heights).unwrap(), slope)
}

/// A few waves of random direction and phase that fit the map: smooth where the map is large.
pub(super) fn waves(
    (nx, ny): (usize, usize),
    pitch: (f64, f64),
    slope: f64,
    seed: u64,
) -> HeightMap {
    let mut random = stream(seed);
    let waves: Vec<[f64; 4]> = (0..6)
        .map(|_| {
            let [p, q] = [0, 1].map(|_| random.between(-2.0, 3.0).floor());
            [p, q, random.next(), random.between(0.3, 1.0)]
        })
        .collect();
    let height = |x: usize, y: usize| -> f64 {
        let at = |w: &[f64; 4]| {
            let turns = w[0] * x as f64 / nx as f64 + w[1] * y as f64 / ny as f64 + w[2];
            w[3] * (TAU * turns).sin()
        };
        waves.iter().map(at).sum()
    };
    let heights = (0..nx * ny).map(|k| height(k % nx, k / nx)).collect();
    with_slope(HeightMap::new((nx, ny), pitch, heights).unwrap(), slope)
}

/// Gaussian heights, periodic, of correlation `exp(-r^2 / length^2)` with `length` in pixels.
///
/// White noise under a Gaussian kernel whose width is half the length: its correlation is that of the heights.
pub(super) fn gaussian(size: usize, length: f64, slope: f64, seed: u64) -> HeightMap {
    let mut random = stream(seed);
    // two uniforms a point are enough: a height is a sum over hundreds of points
    let white: Vec<f64> =
        (0..size * size).map(|_| random.next::<f64>() + random.next::<f64>() - 1.0).collect();
    let reach = (2.5 * length).ceil() as usize;
    let kernel: Vec<f64> = (0..=2 * reach)
        .map(|k| (-2.0 * ((k as f64 - reach as f64) / length).powi(2)).exp())
        .collect();
    // along x, turned over; twice
    let filtered = |from: &[f64]| {
        let mut to = vec![0.0; size * size];
        let mut row = vec![0.0; size + 2 * reach];
        for y in 0..size {
            for (k, cell) in row.iter_mut().enumerate() {
                *cell = from[y * size + (k + size - reach % size) % size];
            }
            for x in 0..size {
                let near = &row[x..=x + 2 * reach];
                to[x * size + y] = near.iter().zip(&kernel).map(|(h, k)| h * k).sum();
            }
        }
        to
    };
    let heights = filtered(&filtered(&white));
    with_slope(HeightMap::new((size, size), (1.0, 1.0), heights).unwrap(), slope)
}

//! The surface and the rays that are timed: the same for every program that counts or measures.

use asperity::raytrace::Ray;
use asperity::surface::HeightMap;
use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;

/// Gaussian heights, periodic, of correlation `exp(-r^2 / length^2)`; `slope` is the rms along each axis,
/// `length` is in pixels of 1 um.
pub(crate) fn gaussian(size: usize, length: f64, slope: f64, seed: u128) -> HeightMap {
    let mut generator = Pcg64Mcg::new(seed);
    let mut heights: Vec<f64> =
        (0..size * size).map(|_| f64::uniform(&mut generator) - 0.5).collect();
    let reach = (2.5 * length).ceil() as usize;
    let kernel: Vec<f64> = (0..=2 * reach)
        .map(|k| (-2.0 * ((k as f64 - reach as f64) / length).powi(2)).exp())
        .collect();
    let mut line = vec![0.0; size + 2 * reach];
    // along x, turned over; twice
    for _ in 0..2 {
        let mut turned = vec![0.0; size * size];
        for y in 0..size {
            for (k, cell) in line.iter_mut().enumerate() {
                *cell = heights[y * size + (k + size - reach % size) % size];
            }
            for x in 0..size {
                let near = line[x..].iter().zip(&kernel);
                turned[x * size + y] = near.map(|(h, k)| h * k).sum();
            }
        }
        heights = turned;
    }
    let rise = |k: usize| heights[k - k % size + (k + 1) % size] - heights[k];
    let square = (0..size * size).map(|k| rise(k).powi(2)).sum::<f64>();
    let scale = slope / (square / (size * size) as f64).sqrt();
    for h in &mut heights {
        *h *= scale;
    }
    HeightMap::new((size, size), (1.0, 1.0), heights).unwrap()
}

/// Half the range of heights, in pitches: where the field has its highest point.
pub(crate) fn top(map: &HeightMap) -> f64 {
    let (low, high) =
        map.points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.2), b.max(p.2)));
    0.5 * (high - low) / map.dx_um()
}

/// A ray from above at an angle from the vertical, from anywhere on the plane at height `top`; in pitches.
pub(crate) fn ray(
    top: f64,
    extent: [f64; 2],
    degrees: f64,
    uniform: &mut impl FnMut() -> f64,
) -> Ray {
    let (s, c) = degrees.to_radians().sin_cos();
    let (sin, cos) = (std::f64::consts::TAU * uniform()).sin_cos();
    let [x, y] = extent.map(|n| n * uniform());
    Ray {
        origin: [x as f32, y as f32, top as f32],
        direction: [(s * cos) as f32, (s * sin) as f32, -c as f32],
        above: true,
        from: None,
    }
}

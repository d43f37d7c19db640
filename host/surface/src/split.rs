//! A map split in two by wavelength: the long waves keep the shape, the short ones are its texture.
//!
//! Both filters are complementary in power: a wave of length `l` keeps the amplitude `H` in the long map and
//! `sqrt(1 - H^2)` in the short one, `H^2 = exp(-ln 2 (lc / l)^4)`, so that the variances of heights and of slopes, and the
//! structure functions, of the two add up to those of the map. (The residual of a filter, `1 - H`, would lose half the
//! power of the waves at the cut-off.) The heights themselves do not add up: the short map serves laws that use the
//! statistics of a surface only.

use crate::edges::Edges;
use crate::heightmap::{HeightMap, Incomplete};
use asperity_fourier::RealFourier;

/// The long and the short waves of a complete map; each loses its mean.
///
/// # Errors
/// [`Incomplete`] if points are missing.
pub fn split(
    map: &HeightMap,
    edges: Edges,
    cutoff_um: f64,
) -> Result<(HeightMap, HeightMap), Incomplete> {
    let heights = map.need_complete()?;
    let (nx, ny) = (map.nx(), map.ny());
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let transform = RealFourier::new((nx, ny), edges);
    let whole = transform.forward(heights.iter().map(|h| h - mean).collect());
    let waves = |periods: f64, n: usize, pitch_um: f64| {
        (cutoff_um * periods / (n as f64 * pitch_um)).powi(2)
    };
    let along_y: Vec<f64> =
        (0..ny).map(|j| waves(transform.periods_y(j), ny, map.dy_um())).collect();
    let part = |amplitude: fn(f64) -> f64| {
        let mut coefficients = whole.clone();
        for (i, column) in coefficients.chunks_mut(ny).enumerate() {
            let along_x = waves(transform.periods_x(i), nx, map.dx_um());
            for (c, y) in column.iter_mut().zip(&along_y) {
                *c *= amplitude(std::f64::consts::LN_2 * (along_x + y).powi(2));
            }
        }
        let heights = transform.weighted_back(&coefficients, |_| 1.0, |_| 1.0);
        map.clone().map(|col, row, _| heights[row * nx + col])
    };
    Ok((part(|x| (-0.5 * x).exp()), part(|x| (-(-x).exp_m1()).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::split;
    use crate::synthetic::gaussian;
    use crate::{Edges, HeightMap, Roughness};

    #[test]
    fn variances_add_up_and_the_ends_are_all_or_nothing() {
        for edges in [Edges::Periodic, Edges::Mirrored] {
            let map = gaussian((96, 80), (0.5, 0.4), 6.0, 3);
            let rq = |m: &HeightMap| Roughness::of(m).rq_um;
            for cutoff in [2.0, 9.0, 20.0] {
                let (long, short) = split(&map, edges, cutoff).unwrap();
                let sum = rq(&long).hypot(rq(&short));
                assert!((sum / rq(&map) - 1.0).abs() < 1e-9, "{edges:?} {cutoff} {sum}");
            }
            let (long, short) = split(&map, edges, 1e-6).unwrap();
            assert!((rq(&long) / rq(&map) - 1.0).abs() < 1e-9 && rq(&short) < 1e-9);
            let (long, short) = split(&map, edges, 1e6).unwrap();
            assert!((rq(&short) / rq(&map) - 1.0).abs() < 1e-9 && rq(&long) < 1e-9);
        }
        let holed = HeightMap::new((2, 2), (1.0, 1.0), vec![0.0, f64::NAN, 1.0, 2.0]).unwrap();
        assert!(split(&holed, Edges::Mirrored, 1.0).is_err());
    }

    #[test]
    fn half_of_a_waves_power_is_left_at_the_cut_off() {
        let wave = |k: usize| (std::f64::consts::TAU * (k % 64) as f64 / 16.0).cos();
        let map = HeightMap::new((64, 16), (0.5, 0.5), (0..1024).map(wave).collect()).unwrap();
        let (long, short) = split(&map, Edges::Periodic, 8.0).unwrap();
        for part in [long, short] {
            let ratio = part.height_um(0, 3).unwrap() / map.height_um(0, 3).unwrap();
            assert!((ratio - 0.5_f64.sqrt()).abs() < 1e-12, "{ratio}");
        }
    }
}

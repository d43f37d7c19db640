//! Vertical scale and areal Gaussian low-pass filter, the two parameters of the methods with measured heights.

use crate::edges::Edges;
use crate::heightmap::{HeightMap, Incomplete};
use asperity_fourier::RealFourier;

/// Why a map cannot be scaled or filtered so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ModifyError {
    /// Points are missing.
    #[error(transparent)]
    Missing(#[from] Incomplete),
    /// The scale is not a finite number, or too large for the heights.
    #[error("heights cannot be scaled by {0}; give a finite number that keeps them finite")]
    Scale(f64),
    /// The cut-off is not a finite number >= 0.
    #[error("a cut-off of {0} um is no wavelength; give a positive number, or 0 for no filter")]
    Cutoff(f64),
}

/// The map with its heights times `scale`; missing points stay missing.
///
/// # Errors
/// [`ModifyError::Scale`] if a height would not be finite.
pub fn scaled(map: &HeightMap, scale: f64) -> Result<HeightMap, ModifyError> {
    if !(scale.is_finite() && map.points().all(|p| (p.2 * scale).is_finite())) {
        return Err(ModifyError::Scale(scale));
    }
    Ok(map.clone().map(|_, _, h| h * scale))
}

/// A complete map made ready for many cut-offs: the areal Gaussian filter of ISO 16610-61.
///
/// The weighting function is `exp(-pi (x^2 + y^2) / (alpha lc)^2) / (alpha lc)^2`, `alpha = sqrt(ln 2 / pi)`;
/// a wave of length `l` keeps the share `exp(-ln 2 (lc / l)^2)` of its amplitude, half of it at the cut-off.
/// The share is applied to the waves of the map, with its edges, so nothing is cut off from the weighting
/// function and the mean height is kept.
#[derive(Clone)]
pub struct LowPass {
    map: HeightMap,
    mean_um: f64,
    transform: RealFourier,
    /// Of the heights about the mean.
    coefficients: Vec<f64>,
}

impl std::fmt::Debug for LowPass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LowPass").field("mean_um", &self.mean_um).finish_non_exhaustive()
    }
}

impl LowPass {
    /// Transforms the map once.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(map: &HeightMap, edges: Edges) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let mean_um = heights.iter().sum::<f64>() / heights.len() as f64;
        let transform = RealFourier::new((map.nx(), map.ny()), edges);
        let coefficients = transform.forward(heights.iter().map(|h| h - mean_um).collect());
        Ok(Self { map: map.clone(), mean_um, transform, coefficients })
    }

    /// The map, its waves shorter than `cutoff_um` damped, then its heights times `scale`.
    ///
    /// Without a cut-off, or with 0, it is scaled only. The same bits for any number of threads.
    ///
    /// # Errors
    /// [`ModifyError::Scale`], [`ModifyError::Cutoff`].
    pub fn apply(&self, scale: f64, cutoff_um: Option<f64>) -> Result<HeightMap, ModifyError> {
        let cutoff = match cutoff_um {
            None | Some(0.0) => return scaled(&self.map, scale),
            Some(c) if c.is_finite() && c > 0.0 => c,
            Some(c) => return Err(ModifyError::Cutoff(c)),
        };
        let (nx, ny) = (self.map.nx(), self.map.ny());
        let share = |periods: f64, n: usize, pitch: f64| {
            let waves = cutoff * periods / (n as f64 * pitch);
            (-std::f64::consts::LN_2 * waves * waves).exp()
        };
        let mut heights = self.transform.weighted_back(
            &self.coefficients,
            |i| share(self.transform.periods_x(i), nx, self.map.dx_um()),
            |j| share(self.transform.periods_y(j), ny, self.map.dy_um()),
        );
        for h in &mut heights {
            *h = scale * (*h + self.mean_um);
        }
        // A height that is not finite would be a missing point.
        HeightMap::new((nx, ny), (self.map.dx_um(), self.map.dy_um()), heights)
            .ok()
            .filter(|map| map.complete().is_some())
            .ok_or(ModifyError::Scale(scale))
    }
}

#[cfg(test)]
mod tests {
    use super::{LowPass, ModifyError, scaled};
    use crate::synthetic::gaussian;
    use crate::{Edges, HeightMap};

    const BOTH: [Edges; 2] = [Edges::Periodic, Edges::Mirrored];

    fn largest_difference(a: &HeightMap, b: &HeightMap) -> f64 {
        let (a, b) = (a.complete().unwrap(), b.complete().unwrap());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// The sum of the sampled weighting function over the continued map, until nothing is left of it.
    fn convolved(map: &HeightMap, edges: Edges, cutoff: f64) -> HeightMap {
        let around = |k: i64, n: usize| {
            let n = n as i64;
            match edges {
                Edges::Periodic => k.rem_euclid(n) as usize,
                Edges::Mirrored => {
                    let k = k.rem_euclid(2 * n);
                    (if k < n { k } else { 2 * n - 1 - k }) as usize
                }
            }
        };
        let kernel = |pitch: f64| {
            let reach = (2.6 * cutoff / pitch).ceil() as i64;
            let w = |k: i64| {
                let x = k as f64 * pitch / cutoff;
                // alpha^2 = ln 2 / pi
                (-std::f64::consts::PI.powi(2) / std::f64::consts::LN_2 * x * x).exp()
            };
            let sum: f64 = (-reach..=reach).map(w).sum();
            (-reach..=reach).map(|k| (k, w(k) / sum)).collect::<Vec<_>>()
        };
        let (in_x, in_y) = (kernel(map.dx_um()), kernel(map.dy_um()));
        map.clone().map(|col, row, _| {
            let mut sum = 0.0;
            for &(j, wy) in &in_y {
                for &(i, wx) in &in_x {
                    let x = around(col as i64 + i, map.nx());
                    let y = around(row as i64 + j, map.ny());
                    sum += wx * wy * map.height_um(x, y).unwrap();
                }
            }
            sum
        })
    }

    #[test]
    fn it_agrees_with_the_sum_over_the_weighting_function() {
        for (size, pitches) in [((24, 18), (0.5, 0.5)), ((17, 30), (0.4, 0.6)), ((12, 1), (1., 1.))]
        {
            for edges in BOTH {
                let map = gaussian(size, pitches, 2.0, 7);
                // 14 points a cut-off: sampling the weighting function costs 1e-14 there
                for cutoff in [8.4, 14.0, 30.0] {
                    if cutoff < 14.0 * pitches.0.max(pitches.1) - 1e-9 {
                        continue;
                    }
                    let fast = LowPass::new(&map, edges).unwrap().apply(1.0, Some(cutoff)).unwrap();
                    let error = largest_difference(&fast, &convolved(&map, edges, cutoff));
                    assert!(error < 1e-12, "{size:?} {edges:?} {cutoff}: {error}");
                }
            }
        }
    }

    #[test]
    fn half_of_a_wave_is_left_at_the_cut_off() {
        let (nx, ny, dx, dy) = (60, 48, 0.5, 0.3);
        let tau = std::f64::consts::TAU;
        for (kx, ky) in [(3.0, 0.0), (0.0, 5.0), (4.0, 2.0)] {
            let wave = |x: f64, y: f64| (tau * (kx * x / 60.0 + ky * y / 48.0) + 0.4).cos();
            let heights = (0..nx * ny).map(|k| 2.0 + wave((k % nx) as f64, (k / nx) as f64));
            let map = HeightMap::new((nx, ny), (dx, dy), heights.collect()).unwrap();
            let frequency = f64::hypot(kx / (60.0 * dx), ky / (48.0 * dy));
            let pass = LowPass::new(&map, Edges::Periodic).unwrap();
            for (cutoff, share) in [(1.0 / frequency, 0.5), (2.0 / frequency, 0.0625)] {
                let found = pass.apply(3.0, Some(cutoff)).unwrap();
                let exact = map.clone().map(|_, _, h| 3.0 * (2.0 + share * (h - 2.0)));
                assert!(largest_difference(&found, &exact) < 1e-12);
            }
        }
    }

    #[test]
    fn no_cut_off_changes_nothing_and_a_constant_stays() {
        for edges in BOTH {
            let map = gaussian((64, 50), (0.5, 0.7), 3.0, 1).map(|_, _, h| h + 1000.0);
            let pass = LowPass::new(&map, edges).unwrap();
            assert_eq!(pass.apply(1.0, None).unwrap(), map);
            assert_eq!(pass.apply(1.0, Some(0.0)).unwrap(), map);
            assert!(largest_difference(&pass.apply(1.0, Some(1e-9)).unwrap(), &map) < 1e-12);
            assert_eq!(pass.apply(2.0, None).unwrap(), scaled(&map, 2.0).unwrap());
            let flat = map.map(|_, _, _| 123.456);
            let found = LowPass::new(&flat, edges).unwrap().apply(1.0, Some(5.0)).unwrap();
            assert!(largest_difference(&found, &flat) < 1e-12);
        }
    }

    #[test]
    fn what_makes_no_map_is_refused() {
        let holed = HeightMap::new((2, 2), (1.0, 1.0), vec![1.0, 2.0, f64::NAN, 3.0]).unwrap();
        assert!(LowPass::new(&holed, Edges::Mirrored).is_err());
        assert_eq!(scaled(&holed, 2.0).unwrap().height_um(1, 0), Some(4.0));
        let map = gaussian((8, 8), (1.0, 1.0), 1.0, 1);
        let pass = LowPass::new(&map, Edges::Mirrored).unwrap();
        for bad in [f64::NAN, f64::INFINITY, 1e308 * 1e308] {
            assert!(matches!(pass.apply(bad, None), Err(ModifyError::Scale(_))));
            assert!(matches!(pass.apply(bad, Some(3.0)), Err(ModifyError::Scale(_))));
        }
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(matches!(pass.apply(1.0, Some(bad)), Err(ModifyError::Cutoff(_))));
        }
    }
}

//! Random surfaces of Gaussian heights with a Gaussian autocorrelation, by spectral synthesis.
//!
//! White noise is filtered in the space of frequencies, so that the map is periodic and smooth across its borders.

use asperity_core::math::Real;
use asperity_fourier::RealFourier;
use rand_pcg::Pcg64Mcg;

use crate::edges::Edges;
use crate::heightmap::HeightMap;

/// A periodic surface of Gaussian heights whose autocorrelation is `exp(-(x/lx)^2 - (y/ly)^2)`.
///
/// Rq is that of the map itself, not of an ensemble; the rms slope along x is `sqrt(2) Rq / lx`, as far as the pixels
/// resolve it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianSurface {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Distance of columns and of rows, um.
    pub pitches_um: (f64, f64),
    /// Root mean square height about the mean, um.
    pub rq_um: f64,
    /// Lags at which the autocorrelation is 1/e, along x and y, um.
    pub lengths_um: (f64, f64),
    /// The seed of the heights.
    pub seed: u64,
}

impl GaussianSurface {
    /// The map, its mean zero; `None` if the numbers make none: too few points to have waves, or lengths that leave none.
    pub fn map(&self) -> Option<HeightMap> {
        let (nx, ny) = self.size;
        let count = nx.checked_mul(ny).filter(|count| *count > 0)?;
        let seed = u128::from(self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) + 12345;
        let generator = &mut Pcg64Mcg::new(seed);
        let white: Vec<f64> = (0..count).map(|_| normal(generator)).collect();
        let transform = RealFourier::new(self.size, Edges::Periodic);
        let weight = |periods: f64, n: usize, pitch_um: f64, length_um: f64| {
            let per_um = periods / (n as f64 * pitch_um);
            (-0.5 * (std::f64::consts::PI * length_um * per_um).powi(2)).exp()
        };
        let ((dx, dy), (lx, ly)) = (self.pitches_um, self.lengths_um);
        let heights = transform.weighted_back(
            &transform.forward(white),
            |i| weight(transform.periods_x(i), nx, dx, lx),
            |j| weight(transform.periods_y(j), ny, dy, ly),
        );
        let mean = heights.iter().sum::<f64>() / count as f64;
        let rms =
            (heights.iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / count as f64).sqrt();
        let factor = self.rq_um / rms;
        // waves that are only rounding are no surface
        let seen = rms > 1e-9 && factor.is_finite();
        let scaled = || heights.iter().map(|h| (h - mean) * factor).collect();
        seen.then(|| HeightMap::new(self.size, self.pitches_um, scaled()).ok()).flatten()
    }
}

/// A normal deviate \[Box and Muller\].
pub fn normal(generator: &mut Pcg64Mcg) -> f64 {
    let r = (-2.0 * (1.0 - f64::uniform(generator)).ln()).sqrt();
    r * (std::f64::consts::TAU * f64::uniform(generator)).cos()
}

#[cfg(test)]
mod tests {
    use super::GaussianSurface;
    use crate::{Edges, Roughness};

    const SURFACE: GaussianSurface = GaussianSurface {
        size: (512, 384),
        pitches_um: (0.35, 0.5),
        rq_um: 0.45,
        lengths_um: (3.0, 4.5),
        seed: 7,
    };

    #[test]
    fn its_figures_are_those_asked_for() {
        let map = SURFACE.map().unwrap();
        let r = Roughness::of(&map);
        assert!((r.rq_um / 0.45 - 1.0).abs() < 1e-12, "{r:?}");
        assert!(r.rsk.abs() < 0.1 && (r.rku - 3.0).abs() < 0.2, "{r:?}");
        assert_eq!(Edges::of(&map), Edges::Periodic);
        // rms slope between neighbours: the structure function 2 Rq^2 (1 - exp(-(d/l)^2)) at one pitch
        let slope = |d: f64, l: f64| 0.45 / d * (2.0 * -(-(d / l).powi(2)).exp_m1()).sqrt();
        for (found, exact) in [(r.rms_slope_x, slope(0.35, 3.0)), (r.rms_slope_y, slope(0.5, 4.5))]
        {
            assert!((found.unwrap() / exact - 1.0).abs() < 0.02, "{found:?} {exact}");
        }
    }

    #[test]
    fn its_autocorrelation_is_gaussian() {
        let map = SURFACE.map().unwrap();
        let (nx, ny) = SURFACE.size;
        let heights = map.complete().unwrap();
        for (dx, dy) in [(4, 0), (9, 0), (14, 0), (0, 5), (0, 9), (6, 6), (20, 3), (0, 30)] {
            let product =
                |k: usize| heights[k] * heights[(k / nx + dy) % ny * nx + (k % nx + dx) % nx];
            let found = (0..nx * ny).map(product).sum::<f64>() / (nx * ny) as f64 / (0.45 * 0.45);
            let (x, y) = (dx as f64 * 0.35 / 3.0, dy as f64 * 0.5 / 4.5);
            let exact = (-x * x - y * y).exp();
            // some 2500 independent patches
            assert!((found - exact).abs() < 0.06, "{dx} {dy}: {found} {exact}");
        }
    }

    #[test]
    fn it_depends_on_its_seed_alone_and_exists_only_if_it_can() {
        let other = GaussianSurface { seed: 8, ..SURFACE };
        assert_eq!(SURFACE.map(), SURFACE.map());
        assert_ne!(SURFACE.map(), other.map());
        let none = |surface: GaussianSurface| surface.map().is_none();
        assert!(none(GaussianSurface { size: (1, 1), ..SURFACE }));
        assert!(none(GaussianSurface { size: (0, 8), ..SURFACE }));
        assert!(none(GaussianSurface { pitches_um: (0.0, 1.0), ..SURFACE }));
        assert!(none(GaussianSurface { lengths_um: (1e6, 1e6), ..SURFACE }));
        assert!(none(GaussianSurface { rq_um: f64::NAN, ..SURFACE }));
    }
}

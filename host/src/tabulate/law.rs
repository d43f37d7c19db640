//! What a table is made of, and rays drawn from it at the points of a lattice.

use asperity_core::bsdf::{Bsdf, Lobe, Scattered};
use asperity_core::direction::Direction;

/// The law that fills a table: a [`Bsdf`] behind one pointer, so that this code is compiled once.
pub(super) trait Law: Sync {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>>;
    fn slope(&self) -> f64;
}

impl<B: Bsdf<f64> + Sync> Law for B {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        Bsdf::ars(self, wi, wo)
    }
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        Bsdf::sample_lobe(self, wi, lobe, u)
    }
    fn slope(&self) -> f64 {
        Bsdf::slope(self)
    }
}

/// The golden ratio less 1: its multiples fill the unit interval evenly, however many there are.
pub(super) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Points in the unit square that fill it evenly: `(around_k, (k + 1/2) / N)`, `k` from 0 to `N - 1`.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lattice {
    /// `around_k = k step / N mod 1`; `step` and `N = points` are numbers of Fibonacci that follow each other.
    Fibonacci { points: u32, step: u32 },
    /// `around_k` is that multiple of [`GOLDEN`], for any number of points.
    Golden { points: u32 },
}

impl Lattice {
    /// For a median.
    pub(super) const COARSE: Self = Self::Fibonacci { points: 987, step: 610 };
    /// For a flux that weighs errors.
    pub(super) const MIDDLE: Self = Self::Fibonacci { points: 2584, step: 1597 };
    /// For a flux that is reported.
    pub(super) const FINE: Self = Self::Fibonacci { points: 46_368, step: 28_657 };

    fn points(self) -> u32 {
        let (Self::Fibonacci { points, .. } | Self::Golden { points }) = self;
        points
    }

    fn at(self, k: u32) -> [f64; 2] {
        let n = f64::from(self.points());
        let around = match self {
            Self::Fibonacci { points, step } => {
                (u64::from(k) * u64::from(step) % u64::from(points)) as f64 / n
            }
            Self::Golden { .. } => (f64::from(k) * GOLDEN).fract(),
        };
        [around, (f64::from(k) + 0.5) / n]
    }

    /// What a lobe gives where `draw` takes the points for its uniforms; a lost ray is left out.
    pub(super) fn rays(
        self,
        draw: impl Fn([f64; 2]) -> Option<Scattered<f64>>,
    ) -> Vec<Scattered<f64>> {
        (0..self.points()).filter_map(|k| draw(self.at(k))).collect()
    }

    /// Flux of a lobe, as a fraction of the incident one, by these rays: their mean weight.
    pub(super) fn flux(self, rays: &[Scattered<f64>]) -> f64 {
        rays.iter().map(|ray| ray.weight).sum::<f64>() / f64::from(self.points())
    }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Scattered;
    use asperity_core::direction::Direction;

    use super::Lattice;

    #[test]
    fn the_mean_over_a_lattice_is_the_integral() {
        // of x y^2, 1/6, with a third of the square dark
        for (lattice, error) in [
            (Lattice::COARSE, 1e-3),
            (Lattice::MIDDLE, 5e-4),
            (Lattice::FINE, 5e-5),
            (Lattice::Golden { points: 256 }, 5e-3),
        ] {
            let rays = lattice.rays(|[x, y]| {
                let wo = Direction::from_unit(0.0, 0.0, 1.0);
                (x > 1.0 / 3.0).then_some(Scattered { wo, weight: x * y * y })
            });
            let exact = (1.0 - 1.0 / 9.0) / 6.0;
            assert!((lattice.flux(&rays) - exact).abs() < error, "{lattice:?}");
        }
    }
}

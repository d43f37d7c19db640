//! Random heights, one for every node of a grid of step 1 \[Sokolov eqs 6-8, signs corrected\].
//!
//! Gauss: `F(z) = exp(-|z - z0|^n / (2 delta^n))`; Cauchy: `F(z) = delta^n / (|z - z0|^n + delta^n)`; both on
//! `0 <= z <= h_max`, lengths in units of the step. The uniform number of a node depends on the seed and its
//! place alone, so heights move smoothly with the parameters.

use asperity_core::ndf::law::Profile;
use rayon::prelude::*;

use crate::heightmap::HeightMap;

/// The density of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightLaw {
    /// Its shape.
    pub profile: Profile,
    /// Width, steps.
    pub delta: f64,
    /// Exponent.
    pub n: f64,
    /// Largest height, steps.
    pub h_max: f64,
    /// Most frequent height, steps.
    pub z0: f64,
}

/// Cells of the table of the integrated density.
const CELLS: usize = 1 << 13;
/// Cells of the table of heights over probability.
const QUANTILES: usize = 1 << 14;

impl HeightLaw {
    /// The density, not normalised; `z` in steps.
    pub fn density(&self, z: f64) -> f64 {
        let x = ((z - self.z0).abs() / self.delta).powf(self.n);
        match self.profile {
            Profile::Gauss => (-0.5 * x).exp(),
            Profile::Cauchy => 1.0 / (x + 1.0),
        }
    }

    /// Heights at equally spaced probabilities, 0 to 1; `None` if the density has no finite positive integral.
    fn quantiles(&self) -> Option<Vec<f64>> {
        // where the density is not yet nothing, the cells are as fine as its width
        let reach = match self.profile {
            Profile::Gauss => self.delta * 80.0_f64.powf(1.0 / self.n),
            Profile::Cauchy => f64::INFINITY,
        };
        let (low, high) = ((self.z0 - reach).max(0.0), (self.z0 + reach).min(self.h_max));
        let edges: Vec<f64> = if low < high {
            // denser about z0: the offset grows as a cubic
            let side = |end: f64| {
                let half = CELLS / 2;
                let width = end - self.z0;
                (0..=half).map(move |k| {
                    let t = k as f64 / half as f64;
                    self.z0 + width * (0.02 * t + 0.98 * t * t * t)
                })
            };
            let mut edges: Vec<f64> = if self.z0 > low { side(low).collect() } else { vec![low] };
            edges.reverse();
            if self.z0 < high {
                edges.extend(side(high).skip(usize::from(self.z0 > low)));
            }
            edges
        } else {
            return None;
        };
        let mut sums = vec![0.0];
        for pair in edges.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let density = [pair[0], middle, pair[1]].map(|z| self.density(z));
            let area = (pair[1] - pair[0]) * (density[0] + 4.0 * density[1] + density[2]) / 6.0;
            sums.push(sums.last().copied().unwrap_or(0.0) + area);
        }
        let total = *sums.last()?;
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let mut at = 0;
        let heights = (0..=QUANTILES).map(|k| {
            let wanted = total * k as f64 / QUANTILES as f64;
            while at + 2 < sums.len() && sums[at + 1] < wanted {
                at += 1;
            }
            let width = sums[at + 1] - sums[at];
            let share =
                if width > 0.0 { ((wanted - sums[at]) / width).clamp(0.0, 1.0) } else { 0.0 };
            edges[at] + share * (edges[at + 1] - edges[at])
        });
        Some(heights.collect())
    }
}

/// A grid of nodes with frozen random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RandomHeights {
    /// Nodes along a side; the grid is periodic.
    pub side: usize,
    /// The seed of the numbers.
    pub seed: u64,
}

impl RandomHeights {
    /// The surface for a law, in steps: a periodic map whose pitch of 1 um stands for one step.
    ///
    /// `None` if the law draws no heights.
    pub fn map(self, law: &HeightLaw) -> Option<HeightMap> {
        let quantiles = law.quantiles()?;
        let height = |k: usize| {
            let u = uniform(self.seed, k as u64) * QUANTILES as f64;
            let at = (u as usize).min(QUANTILES - 1);
            let share = u - at as f64;
            quantiles[at] + share * (quantiles[at + 1] - quantiles[at])
        };
        let heights: Vec<f64> =
            (0..self.side * self.side).into_par_iter().with_min_len(4096).map(height).collect();
        HeightMap::new((self.side, self.side), (1.0, 1.0), heights).ok()
    }
}

/// The uniform of a node: splitmix64 of its number.
fn uniform(seed: u64, node: u64) -> f64 {
    let mut z = seed.wrapping_mul(0xd134_2543_de82_ef95) ^ node.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::{HeightLaw, RandomHeights};
    use asperity_core::ndf::law::Profile;

    fn law(profile: Profile, delta: f64, n: f64, h_max: f64, z0: f64) -> HeightLaw {
        HeightLaw { profile, delta, n, h_max, z0 }
    }

    #[test]
    fn heights_follow_their_density() {
        for law in [
            law(Profile::Gauss, 0.2, 2.0, 1.0, 0.0),
            law(Profile::Gauss, 1e-3, 2.0, 1.0, 0.0),
            law(Profile::Gauss, 5.0, 1.5, 1.0, 0.3),
            law(Profile::Cauchy, 0.1, 2.0, 1.0, 0.0),
            law(Profile::Cauchy, 0.05, 3.0, 2.0, 1.0),
        ] {
            let map = RandomHeights { side: 512, seed: 5 }.map(&law).unwrap();
            let (low, high) = (0.0, law.h_max);
            let steps = 2_000_000;
            let width = (high - low) / f64::from(steps);
            // the oracle: plain sums of the density
            let (mut total, mut first, mut second) = (0.0, 0.0, 0.0);
            for k in 0..steps {
                let z = low + (f64::from(k) + 0.5) * width;
                let f = law.density(z);
                total += f;
                first += f * z;
                second += f * z * z;
            }
            let (mean, square) = (first / total, second / total);
            let n = (512.0 * 512.0_f64).sqrt();
            let spread = (square - mean * mean).sqrt();
            let found = map.points().map(|p| p.2).sum::<f64>() / (n * n);
            let found_square = map.points().map(|p| p.2 * p.2).sum::<f64>() / (n * n);
            assert!((found - mean).abs() < 4.5 * spread / n, "{law:?} {found} {mean}");
            assert!((found_square / square - 1.0).abs() < 0.02, "{law:?} {found_square} {square}");
            assert!(map.points().all(|p| (low..=high).contains(&p.2)));
        }
    }

    #[test]
    fn heights_move_smoothly_with_the_width() {
        let heights = |delta| {
            let law = law(Profile::Gauss, delta, 2.0, 1.0, 0.0);
            RandomHeights { side: 64, seed: 1 }.map(&law).unwrap()
        };
        let (a, b) = (heights(0.2), heights(0.2002));
        let most = a.points().zip(b.points()).map(|(p, q)| (p.2 - q.2).abs()).fold(0.0, f64::max);
        assert!(most > 1e-6 && most < 2e-3, "{most}");
        let nothing = law(Profile::Gauss, 1e-9, 2.0, 1.0, -5.0);
        assert!(RandomHeights { side: 8, seed: 1 }.map(&nothing).is_none());
    }
}

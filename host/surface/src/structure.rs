//! The structure function of a surface: the mean square difference of heights over a distance.

use rayon::prelude::*;

use crate::edges::Edges;
use crate::heightmap::{HeightMap, Incomplete};

/// `D(r) = mean of (h(x + r) - h(x))^2`, averaged over the x and the y direction.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureFunction {
    /// By direction: lags in um, ascending, and D in um^2.
    along: [Vec<(f64, f64)>; 2],
}

/// Lags per octave.
const FINENESS: f64 = 4.0;

impl StructureFunction {
    /// Of a complete map, for lags from one pitch to half a side. A finite map is compared with itself only.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn of(map: &HeightMap, edges: Edges) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let (nx, ny) = (map.nx(), map.ny());
        let one = |n: usize, pitch_um: f64, square: &(dyn Fn(usize) -> f64 + Sync)| {
            lags(n / 2).into_iter().map(|k| (k as f64 * pitch_um, square(k))).collect()
        };
        // sums by rows, added in their order: the same for any number of threads
        let mean = |rows: usize, row: &(dyn Fn(usize) -> f64 + Sync), count: usize| {
            let sums: Vec<f64> = (0..rows).into_par_iter().map(row).collect();
            sums.iter().sum::<f64>() / count.max(1) as f64
        };
        let difference =
            |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
        let line = |j: usize| &heights[j * nx..(j + 1) * nx];
        let periodic = edges == Edges::Periodic;
        let x = one(nx, map.dx_um(), &|k| {
            let row = |j: usize| {
                let h = line(j);
                let around = if periodic { difference(&h[nx - k..], &h[..k]) } else { 0.0 };
                difference(&h[..nx - k], &h[k..]) + around
            };
            mean(ny, &row, ny * if periodic { nx } else { nx - k })
        });
        let y = one(ny, map.dy_um(), &|k| {
            let rows = if periodic { ny } else { ny - k };
            mean(rows, &|j| difference(line(j), line((j + k) % ny)), rows * nx)
        });
        Ok(Self { along: [x, y] })
    }

    /// `D(r)` in um^2: a power law between two lags, quadratic below the first, constant beyond the last.
    pub fn at(&self, r_um: f64) -> f64 {
        let known = self.along.iter().filter(|lags| !lags.is_empty());
        let (sum, count) =
            known.fold((0.0, 0.0), |(s, n), lags| (s + interpolated(lags, r_um), n + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// The least distance over which heights differ by a mean square of `level` um^2; `None` if they never do.
    pub fn reach_um(&self, level: f64) -> Option<f64> {
        let mut lags: Vec<f64> = self.along.iter().flatten().map(|l| l.0).collect();
        lags.sort_by(f64::total_cmp);
        let beyond = lags.iter().position(|r| self.at(*r) >= level)?;
        let (mut low, mut high) = (if beyond > 0 { lags[beyond - 1] } else { 0.0 }, lags[beyond]);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle) >= level { high = middle } else { low = middle }
        }
        Some(high)
    }
}

/// 1, 2, 3, ... and then in proportion.
fn lags(most: usize) -> Vec<usize> {
    let mut found = Vec::new();
    let mut next = 1.0_f64;
    while next.round() as usize <= most {
        found.push(next.round() as usize);
        next = (next + 1.0).max(next * (1.0 / FINENESS).exp2());
    }
    found
}

fn interpolated(lags: &[(f64, f64)], r_um: f64) -> f64 {
    let k = lags.partition_point(|l| l.0 < r_um);
    let Some(&(b, high)) = lags.get(k) else { return lags.last().map_or(0.0, |l| l.1) };
    let Some(&(a, low)) = k.checked_sub(1).and_then(|k| lags.get(k)) else {
        return high * (r_um / b).powi(2);
    };
    let t = (r_um / a).ln() / (b / a).ln();
    if low > 0.0 && high > 0.0 { low * (high / low).powf(t) } else { low + t * (high - low) }
}

#[cfg(test)]
mod tests {
    use super::StructureFunction;
    use crate::synthetic::gaussian;
    use crate::{Edges, HeightMap};

    #[test]
    fn it_is_that_of_the_autocorrelation() {
        let map = gaussian((512, 512), (0.5, 0.5), 8.0, 5);
        for edges in [Edges::Periodic, Edges::Mirrored] {
            let found = StructureFunction::of(&map, edges).unwrap();
            for r in [0.25_f64, 0.5, 1.0, 2.6, 4.0, 9.0] {
                let exact = -2.0 * (-(r / 4.0).powi(2)).exp_m1();
                assert!((found.at(r) / exact - 1.0).abs() < 0.07, "{edges:?} {r} {}", found.at(r));
            }
            let reach = found.reach_um(1.0).unwrap();
            assert!((found.at(reach) - 1.0).abs() < 1e-6 && (2.9..3.8).contains(&reach), "{reach}");
            assert!(found.reach_um(9.0).is_none());
        }
        let line = HeightMap::new((4, 1), (1.0, 1.0), vec![0.0, 1.0, 0.0, 1.0]).unwrap();
        let found = StructureFunction::of(&line, Edges::Periodic).unwrap();
        assert!((found.at(1.0) - 1.0).abs() < 1e-12 && found.at(2.0).abs() < 1e-12);
    }
}

//! Mean square slopes of a map, in all directions.

use rayon::prelude::*;

use crate::surface::{Edges, HeightMap};

/// Second moments of the slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slopes {
    xx: f64,
    yy: f64,
    xy: f64,
}

/// Sums over the steps between neighbours; a row at a time, added in their order.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    along_x: f64,
    steps_x: u64,
    along_y: f64,
    steps_y: u64,
    mixed: f64,
    corners: u64,
}

impl Slopes {
    /// From the differences of neighbours, over the seam of a periodic map; zero if points are missing.
    pub(super) fn of(map: &HeightMap, edges: Edges) -> Self {
        let Some(heights) = map.complete() else { return Self::default() };
        let (nx, ny) = (map.nx(), map.ny());
        let wrap = edges == Edges::Periodic;
        let rows: Vec<Sums> = (0..ny)
            .into_par_iter()
            .map(|y| {
                let row = &heights[y * nx..(y + 1) * nx];
                let above = (y + 1 < ny || wrap).then(|| (y + 1) % ny);
                let above = above.map(|y| &heights[y * nx..(y + 1) * nx]);
                let mut sums = Sums::default();
                for (x, h) in row.iter().enumerate() {
                    let next = (x + 1 < nx || wrap).then(|| (x + 1) % nx);
                    if let Some(next) = next {
                        sums.along_x += (row[next] - h).powi(2);
                        sums.steps_x += 1;
                    }
                    let Some(above) = above else { continue };
                    sums.along_y += (above[x] - h).powi(2);
                    sums.steps_y += 1;
                    if let Some(next) = next {
                        // of the two triangles of the cell
                        let lower = (row[next] - h) * (above[next] - row[next]);
                        let upper = (above[next] - above[x]) * (above[x] - h);
                        sums.mixed += 0.5 * (lower + upper);
                        sums.corners += 1;
                    }
                }
                sums
            })
            .collect();
        let all = rows.iter().fold(Sums::default(), |a, b| Sums {
            along_x: a.along_x + b.along_x,
            steps_x: a.steps_x + b.steps_x,
            along_y: a.along_y + b.along_y,
            steps_y: a.steps_y + b.steps_y,
            mixed: a.mixed + b.mixed,
            corners: a.corners + b.corners,
        });
        let mean = |sum: f64, count: u64| if count > 0 { sum / count as f64 } else { 0.0 };
        let (dx, dy) = (map.dx_um(), map.dy_um());
        let xx = mean(all.along_x, all.steps_x) / (dx * dx);
        let yy = mean(all.along_y, all.steps_y) / (dy * dy);
        // the steps of the border are in one mean and not in the other
        let most = (xx * yy).sqrt();
        let xy = (mean(all.mixed, all.corners) / (dx * dy)).clamp(-most, most);
        Self { xx, yy, xy }
    }

    /// Rms of the slope along a direction of the plane, times the length of the vector.
    pub(super) fn along(&self, x: f64, y: f64) -> f64 {
        (x * x * self.xx + 2.0 * x * y * self.xy + y * y * self.yy).max(0.0).sqrt()
    }

    /// Rms slope along the direction in which it is largest.
    pub(super) fn steepest(&self) -> f64 {
        let (middle, half) = (0.5 * (self.xx + self.yy), 0.5 * (self.xx - self.yy));
        (middle + half.hypot(self.xy)).sqrt()
    }
}

/// Rms slope of a map along the direction in which it is largest; 0 if points are missing.
pub fn steepest_slope(map: &HeightMap, edges: Edges) -> f64 {
    Slopes::of(map, edges).steepest()
}

#[cfg(test)]
mod tests {
    use super::Slopes;
    use crate::surface::{Edges, HeightMap};

    #[test]
    fn grooves_are_as_steep_whichever_way_they_lie() {
        let (n, pitch) = (240_u32, 0.1);
        let tau = std::f64::consts::TAU;
        // whole waves along x, along y, along the diagonal, and along x + 2 y
        for (kx, ky) in [(3.0, 0.0), (0.0, 3.0), (3.0, 3.0), (2.0, 4.0)] {
            let period = 24.0 / f64::hypot(kx, ky);
            let height = |k: u32| {
                let (x, y) = (pitch * f64::from(k % n), pitch * f64::from(k / n));
                0.2 * (tau * (kx * x + ky * y) / 24.0).sin()
            };
            let map = HeightMap::new(
                (n as usize, n as usize),
                (pitch, pitch),
                (0..n * n).map(height).collect(),
            );
            let slopes = Slopes::of(&map.unwrap(), Edges::Periodic);
            let rms = 0.2 * tau / period / std::f64::consts::SQRT_2;
            assert!((slopes.steepest() / rms - 1.0).abs() < 2e-3, "{slopes:?} {rms}");
            let length = f64::hypot(kx, ky);
            let (x, y) = (kx / length, ky / length);
            assert!((slopes.along(x, y) / rms - 1.0).abs() < 2e-3);
            // a root of a difference of means that the steps of a pixel know to the square of its phase
            let phase = tau * pitch / period;
            assert!(slopes.along(-y, x) < phase * rms, "{}", slopes.along(-y, x) / rms);
        }
    }

    #[test]
    fn maps_without_neighbours_are_level() {
        let point = HeightMap::new((1, 1), (1.0, 1.0), vec![3.0]).unwrap();
        let row = HeightMap::new((3, 1), (2.0, 1.0), vec![0.0, 1.0, 0.0]).unwrap();
        for edges in [Edges::Periodic, Edges::Mirrored] {
            assert!(Slopes::of(&point, edges).steepest() <= 0.0);
        }
        assert!((Slopes::of(&row, Edges::Mirrored).steepest() - 0.5).abs() < 1e-12);
    }
}

//! Missing points and their filling.

use crate::form::Form;
use crate::heightmap::HeightMap;
use crate::heightmap::HeightMapError;
use crate::membrane::Membrane;
use crate::nearest::nearest;

/// The filling of missing points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fill {
    /// The height of the mean plane there.
    Plane,
    /// The height of the nearest point that has one, in the plane of the map.
    Nearest,
    /// A membrane spanned over each gap from its rim (Laplace's equation), free where the gap meets the
    /// border of the map. The mean plane is set aside first, so a tilt goes on undisturbed.
    Harmonic,
}

/// Why a map cannot be filled.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FillError {
    /// Heights so large that numbers overflow.
    #[error("the heights are too large to be filled; check their unit")]
    Overflow,
    /// The numbers make no map.
    #[error(transparent)]
    Map(#[from] HeightMapError),
}

impl Fill {
    /// The complete map; points that have a height keep it to the last bit.
    ///
    /// Harmonic gaps are solved to 1e-10 of their disturbance; the time grows with the number of points.
    ///
    /// # Errors
    /// [`FillError::Overflow`] if a filled height is not finite.
    pub fn filled(self, map: &HeightMap) -> Result<HeightMap, FillError> {
        if map.complete().is_some() {
            return Ok(map.clone());
        }
        let (nx, ny) = (map.nx(), map.ny());
        let mut heights = vec![f64::NAN; nx * ny];
        for (col, row, h) in map.points() {
            heights[row * nx + col] = h;
        }
        let gaps: Vec<usize> = (0..nx * ny).filter(|&k| heights[k].is_nan()).collect();
        match self {
            Self::Plane => {
                let plane = Form::Plane.fitted(map);
                for k in gaps {
                    heights[k] = plane.height_um(k % nx, k / nx);
                }
            }
            Self::Nearest => {
                let known = |k: usize| !heights[k].is_nan();
                let source = nearest((nx, ny), (map.dx_um(), map.dy_um()), known);
                for k in gaps {
                    heights[k] = heights[source[k]];
                }
            }
            Self::Harmonic => {
                let plane = Form::Plane.fitted(map);
                let flat: Vec<f64> = heights
                    .iter()
                    .enumerate()
                    .map(|(k, h)| h - plane.height_um(k % nx, k / nx))
                    .collect();
                let above = Membrane::new((nx, ny), (map.dx_um(), map.dy_um()), &flat).solve();
                for k in gaps {
                    heights[k] = plane.height_um(k % nx, k / nx) + above[k];
                }
            }
        }
        let full = HeightMap::new((nx, ny), (map.dx_um(), map.dy_um()), heights)?;
        if full.complete().is_some() { Ok(full) } else { Err(FillError::Overflow) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Fill, FillError};
    use crate::HeightMap;

    const ALL: [Fill; 3] = [Fill::Plane, Fill::Nearest, Fill::Harmonic];

    /// The map without the points for which `hole` says so.
    fn holed(
        (nx, ny): (usize, usize),
        height: impl Fn(f64, f64) -> f64,
        hole: impl Fn(usize, usize) -> bool,
    ) -> HeightMap {
        let heights = (0..nx * ny).map(|k| {
            let (col, row) = (k % nx, k / nx);
            if hole(col, row) { f64::NAN } else { height(col as f64, row as f64) }
        });
        HeightMap::new((nx, ny), (0.5, 0.8), heights.collect()).unwrap()
    }

    fn scattered(col: usize, row: usize) -> bool {
        (col * 7919 + row * 104_729 + col * row) % 10 < 3
    }

    fn largest_error(map: &HeightMap, height: impl Fn(f64, f64) -> f64) -> f64 {
        assert!(map.complete().is_some());
        map.points().map(|(c, r, h)| (h - height(c as f64, r as f64)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_plane_goes_on_in_its_gaps_also_at_edges_and_corners() {
        let plane = |x: f64, y: f64| 40.0 + 0.3 * x - 0.2 * y;
        let gaps: [&dyn Fn(usize, usize) -> bool; 4] = [
            &scattered,
            &|c, r| (10..25).contains(&c) && (8..20).contains(&r),
            &|c, r| c < 12 && r < 9,
            &|c, r| c > 30 || r > 25,
        ];
        for gap in gaps {
            let map = holed((40, 30), plane, gap);
            for fill in [Fill::Plane, Fill::Harmonic] {
                let error = largest_error(&fill.filled(&map).unwrap(), plane);
                assert!(error < 1e-11, "{fill:?} {error}");
            }
        }
    }

    #[test]
    fn a_membrane_is_harmonic_inside_and_never_beyond_its_rim() {
        // x^2/dx^2 - y^2/dy^2 solves the difference equation with these pitches exactly
        let saddle =
            |x: f64, y: f64| 0.01 * (0.25 * (x - 20.0).powi(2) - 0.64 * (y - 15.0).powi(2)) + 3.0;
        let map = holed((40, 30), saddle, |c, r| (6..33).contains(&c) && (5..26).contains(&r));
        let filled = Fill::Harmonic.filled(&map).unwrap();
        let error = largest_error(&filled, saddle);
        assert!(error < 1e-9, "{error}");
        let bumpy = |x: f64, y: f64| (0.7 * x).sin() * (0.9 * y).cos();
        let map = holed((64, 64), bumpy, |c, r| (c + r) % 3 == 0 || (20..50).contains(&c));
        let filled = Fill::Harmonic.filled(&map).unwrap();
        let slack = 0.1; // the mean plane, which is set aside
        assert!(filled.points().all(|p| p.2.abs() < 1.0 + slack));
    }

    #[test]
    fn one_point_alone_gives_its_height_to_all_and_no_known_point_changes() {
        for (nx, ny) in [(9, 7), (1, 8), (8, 1), (2, 2)] {
            let map = holed((nx, ny), |_, _| 5.0, |c, r| (c, r) != (nx / 2, ny / 2));
            for fill in ALL {
                let error = largest_error(&fill.filled(&map).unwrap(), |_, _| 5.0);
                assert!(error < 1e-12, "{fill:?} {nx} x {ny}: {error}");
            }
        }
        let map = holed((50, 40), |x, y| (0.3 * x).sin() + (x * y).cos(), scattered);
        for fill in ALL {
            let full = fill.filled(&map).unwrap();
            assert!(map.points().all(|(c, r, h)| full.height_um(c, r) == Some(h)));
            assert_eq!(fill.filled(&full).unwrap(), full);
        }
    }

    #[test]
    fn the_nearest_point_respects_the_pitches() {
        // pitches 0.5 and 0.8: one row away is farther than one column
        let map = holed((3, 3), |x, y| x + 10.0 * y, |c, r| (c, r) == (1, 1));
        let h = Fill::Nearest.filled(&map).unwrap().height_um(1, 1).unwrap();
        assert!((h - 10.0).abs() < 1e-12 || (h - 12.0).abs() < 1e-12, "{h}");
    }

    #[test]
    fn heights_that_overflow_are_refused() {
        let map = holed((4, 4), |x, _| 1e308 * (x - 1.5), |c, r| c == r);
        assert_eq!(Fill::Plane.filled(&map), Err(FillError::Overflow));
    }
}

//! A height map: heights over a regular grid that owns its pitch.

/// Heights in um over a regular grid, `[row = y, col = x]`, x fastest; points may be missing.
///
/// Valid by construction: at least one point, positive finite pitches, finite heights.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    nx: usize,
    ny: usize,
    dx_um: f64,
    dy_um: f64,
    heights_um: Vec<f64>,
    /// Empty if no point is missing, else one flag per point.
    missing: Vec<bool>,
}

/// Why numbers do not make a height map.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HeightMapError {
    /// The counts do not match the numbers.
    #[error("{heights} heights cannot fill {nx} x {ny} points")]
    Count {
        /// Columns.
        nx: usize,
        /// Rows.
        ny: usize,
        /// Heights given.
        heights: usize,
    },
    /// A pitch is not a positive finite number.
    #[error("the pixel size {0} um is not a positive number")]
    Pitch(f64),
    /// No point has a height.
    #[error("no point of the map has a height")]
    Empty,
}

/// Points are missing where all are needed; holds their share in percent.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{0:.2} % of the points are missing; fill them with --fill")]
pub struct Incomplete(pub f64);

impl HeightMap {
    /// A map from heights in um, row by row; a height that is not finite is a missing point.
    ///
    /// # Errors
    /// [`HeightMapError`] as its variants say.
    pub fn new(
        (nx, ny): (usize, usize),
        (dx_um, dy_um): (f64, f64),
        mut heights_um: Vec<f64>,
    ) -> Result<Self, HeightMapError> {
        if nx.checked_mul(ny) != Some(heights_um.len()) || heights_um.is_empty() {
            return Err(HeightMapError::Count { nx, ny, heights: heights_um.len() });
        }
        for pitch in [dx_um, dy_um] {
            if !(pitch.is_finite() && pitch > 0.0) {
                return Err(HeightMapError::Pitch(pitch));
            }
        }
        if heights_um.iter().all(|h| h.is_finite()) {
            return Ok(Self { nx, ny, dx_um, dy_um, heights_um, missing: Vec::new() });
        }
        let missing: Vec<bool> = heights_um.iter().map(|h| !h.is_finite()).collect();
        if missing.iter().all(|m| *m) {
            return Err(HeightMapError::Empty);
        }
        for h in &mut heights_um {
            if !h.is_finite() {
                *h = 0.0;
            }
        }
        Ok(Self { nx, ny, dx_um, dy_um, heights_um, missing })
    }

    /// Columns, along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Rows, along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Distance of columns, um.
    pub fn dx_um(&self) -> f64 {
        self.dx_um
    }

    /// Distance of rows, um.
    pub fn dy_um(&self) -> f64 {
        self.dy_um
    }

    /// The height at a point in um; `None` if it is missing or outside.
    pub fn height_um(&self, col: usize, row: usize) -> Option<f64> {
        if col >= self.nx || row >= self.ny {
            return None;
        }
        let k = row * self.nx + col;
        if self.missing.get(k).copied().unwrap_or(false) {
            return None;
        }
        self.heights_um.get(k).copied()
    }

    /// All points with a height: column, row, height in um.
    pub fn points(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        self.heights_um.iter().enumerate().filter_map(|(k, &h)| {
            let lost = self.missing.get(k).copied().unwrap_or(false);
            (!lost).then_some((k % self.nx, k / self.nx, h))
        })
    }

    /// Fraction of the points that are missing.
    pub fn missing_fraction(&self) -> f64 {
        let lost = self.missing.iter().filter(|m| **m).count();
        lost as f64 / self.heights_um.len() as f64
    }

    /// Heights row by row in um, if none is missing.
    pub fn complete(&self) -> Option<&[f64]> {
        self.missing.is_empty().then_some(&self.heights_um)
    }

    /// Heights row by row in um.
    ///
    /// # Errors
    /// [`Incomplete`] if a point is missing.
    pub fn need_complete(&self) -> Result<&[f64], Incomplete> {
        self.complete().ok_or_else(|| Incomplete(100.0 * self.missing_fraction()))
    }

    /// The same grid with other heights; missing points stay missing.
    ///
    /// `height(col, row, old)` gives the new height in um.
    #[must_use]
    pub fn map(mut self, mut height: impl FnMut(usize, usize, f64) -> f64) -> Self {
        for (k, h) in self.heights_um.iter_mut().enumerate() {
            if !self.missing.get(k).copied().unwrap_or(false) {
                *h = height(k % self.nx, k / self.nx, *h);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::{HeightMap, HeightMapError};

    #[test]
    fn a_map_exists_only_if_its_numbers_fit() {
        let map = HeightMap::new((2, 2), (0.5, 1.0), vec![1.0, f64::NAN, 2.0, 3.0]).unwrap();
        assert_eq!(map.height_um(0, 1), Some(2.0));
        assert_eq!(map.height_um(1, 0), None);
        assert_eq!(map.height_um(2, 0), None);
        assert!((map.missing_fraction() - 0.25).abs() < 1e-15 && map.complete().is_none());
        let bad = |n, p, h: Vec<f64>| HeightMap::new(n, p, h).unwrap_err();
        assert!(matches!(bad((2, 2), (1.0, 1.0), vec![1.0]), HeightMapError::Count { .. }));
        assert!(matches!(
            bad((usize::MAX, 2), (1.0, 1.0), vec![1.0]),
            HeightMapError::Count { .. }
        ));
        assert!(matches!(bad((1, 1), (0.0, 1.0), vec![1.0]), HeightMapError::Pitch(_)));
        assert!(matches!(bad((1, 1), (1.0, f64::NAN), vec![1.0]), HeightMapError::Pitch(_)));
        assert_eq!(bad((1, 1), (1.0, 1.0), vec![f64::INFINITY]), HeightMapError::Empty);
    }
}
